// Products of textures of projections of both directions, as engine/factor/homomorphic.py looks them up.
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); out: 1/sr, no cosine, 0 below the horizon.
// A layer per term: logarithms, bilinear between texel centres at -1 ... 1. MAX_TERMS as in that file.

#include "brdf/ceiling.glsl"

const int MAX_TERMS = 16;

uniform sampler2DArray brdf_textures;
uniform int brdf_terms;

// 0 linear, then the fixed projections in the order of engine/factor/projections.py; two rows for each linear one,
// divided by its scale; and 1 where the texture is read by the conjugate projection, too.
uniform int brdf_kinds[MAX_TERMS];
uniform vec4 brdf_rows[2 * MAX_TERMS];
uniform int brdf_twice[MAX_TERMS];

// 1 where linear projections are of half and difference vector, 0 of light and viewer.
uniform int brdf_of_half;

uniform vec3 brdf_mean;
// The largest logarithm that is taken back.
uniform vec3 brdf_highest;
uniform float brdf_epsilon;

// What projections see of a pair of directions.
struct Points {
    vec4 flat_pair;
    vec2 incident;
    vec2 outgoing;
    vec2 half_way;
    vec3 angles;
};

vec2 parabolic(vec3 w)
{
    return w.xy / (1.0 + w.z);
}

Points points_of(vec3 wi, vec3 wo)
{
    Points points;
    vec3 both = 0.5 * (wi + wo);
    vec3 between = 0.5 * (wi - wo);
    float cosine = length(both);
    vec3 h = cosine > 1e-11 ? both / cosine : vec3(0.0, 0.0, 1.0);
    points.incident = parabolic(wi);
    points.outgoing = parabolic(wo);
    points.half_way = parabolic(h);
    float a = dot(points.incident, points.incident);
    float b = dot(points.outgoing, points.outgoing);
    float mean = sqrt(2.0 * (a + b) / ((1.0 + a) * (1.0 + b))) / (1.0 + sqrt(wi.z * wo.z));
    points.angles = vec3(length(points.half_way), length(between) / (1.0 + cosine), mean);
    points.flat_pair = vec4(points.incident, points.outgoing);
    if (brdf_of_half == 1) {
        // Cole 2002, Eq. 1.4, and its limit towards the tangent
        float squared = dot(h.yz, h.yz);
        float towards = h.x >= 0.0 ? -1.0 : 1.0;
        vec3 r = squared < 1e-12 ? vec3(-towards * h.z * h.x, -towards * h.z * h.y, towards * dot(h.xy, h.xy))
            : vec3(squared, -h.x * h.y, -h.x * h.z);
        r = normalize(r);
        vec3 s = cross(h, r);
        points.flat_pair = vec4(points.half_way, vec2(dot(r, between), dot(s, between)) / (1.0 + cosine));
    }
    return points;
}

// The same pair with light and viewer exchanged.
Points exchanged(Points points)
{
    vec4 pair = points.flat_pair;
    points.flat_pair = brdf_of_half == 1 ? vec4(pair.xy, -pair.zw) : pair.zwxy;
    vec2 incident = points.incident;
    points.incident = points.outgoing;
    points.outgoing = incident;
    return points;
}

// The angles of kind 9 and up: three pairs, on four scales each.
vec2 on_scale(Points points, int number)
{
    int pair = number / 4;
    vec2 radii = pair == 0 ? points.angles.xy : pair == 1 ? points.angles.xz : points.angles.yz;
    vec2 squares = radii * radii;
    switch (number - 4 * pair) {
    case 0:
        return 2.0 * (1.0 - squares) / (1.0 + squares) - 1.0;
    case 1:
        return 4.0 * radii / (1.0 + squares) - 1.0;
    case 2:
        return 2.0 * squares - 1.0;
    }
    return vec2(radii.x + radii.y - 1.0, radii.x - radii.y);
}

vec2 project(Points points, int term)
{
    if (brdf_kinds[term] > 8)
        return on_scale(points, brdf_kinds[term] - 9);
    switch (brdf_kinds[term]) {
    case 1:
        return points.incident;
    case 2:
        return points.outgoing;
    case 3:
        return points.half_way;
    case 4:
        return 2.0 * points.angles.xy - 1.0;
    case 5:
        return 2.0 * vec2(length(points.incident), length(points.outgoing)) - 1.0;
    case 6:
        return 2.0 * vec2(length(points.outgoing), length(points.incident)) - 1.0;
    case 7:
        return 2.0 * points.angles.xz - 1.0;
    case 8:
        return 2.0 * points.angles.yz - 1.0;
    }
    return vec2(dot(brdf_rows[2 * term], points.flat_pair), dot(brdf_rows[2 * term + 1], points.flat_pair));
}

vec3 log_look_up(vec2 at, int term)
{
    int size = textureSize(brdf_textures, 0).x;
    vec2 position = clamp(0.5 * (at + 1.0) * float(size - 1), 0.0, float(size - 1));
    ivec2 low = min(ivec2(position), ivec2(size - 2));
    vec2 part = position - vec2(low);
    vec3 lower = mix(texelFetch(brdf_textures, ivec3(low, term), 0).rgb,
                     texelFetch(brdf_textures, ivec3(low + ivec2(1, 0), term), 0).rgb, part.x);
    vec3 upper = mix(texelFetch(brdf_textures, ivec3(low + ivec2(0, 1), term), 0).rgb,
                     texelFetch(brdf_textures, ivec3(low + ivec2(1, 1), term), 0).rgb, part.x);
    return mix(lower, upper, part.y);
}

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    Points points = points_of(wi, wo);
    Points conjugate = exchanged(points);
    vec3 sum = vec3(0.0);
    for (int term = 0; term < brdf_terms; ++term) {
        sum += log_look_up(project(points, term), term);
        if (brdf_twice[term] == 1)
            sum += log_look_up(project(conjugate, term), term);
    }
    return under_ceiling(brdf_mean * max(exp(min(sum, brdf_highest)) - brdf_epsilon, 0.0), wi, wo);
}
