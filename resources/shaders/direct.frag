#version 330 core
// Radiance of one fragment under the sum of directional lights and of lights near the model; see engine.scene.scene for the formulas.
// in: position and normal relative to the mesh, world axes; out: linear radiance and coverage 1.
// A result that is not finite is 0; in debug builds magenta with coverage 2, so that it can be seen and counted.

#include "frame.glsl"
#include BRDF
#include "light_sum.glsl"
#if defined(SHADOWS)
#include "shadow_maps.glsl"
vec3 shadow_normal;
#endif
#if defined(NEAR_LAMPS)
#include "near_lamps.glsl"
#endif

uniform vec3 eye;
uniform sampler2D lights;
uniform int light_count;
uniform float sigma;
uniform float r_max;

in vec3 position;
in vec3 normal;
in vec2 uv;
#if defined(BRUSHED)
in vec3 tangent;
#endif
#if defined(VERTEX_COLOURS)
in vec3 colour;
#endif

out vec4 radiance;

const vec3 LUMINANCE = vec3(0.21263900587151036, 0.71516867876775593, 0.072192315360733714);

#if !defined(SOURCE_NONE)
// Above the brightest photograph the share is clamped in the look-up, or scales what is looked up there.
void add_share(float share, vec3 weight)
{
#if defined(ABOVE_SCALE)
    weight *= max(share, 1.0);
#endif
    add_light(share, weight);
}
#endif

#if defined(SOURCE_PLANES)
mat2x3 axes;
vec2 mean_heading;
#endif

// Add light from one direction in the world: to the sum, or to that of the look-ups.
// Lights below the horizon add nothing. A cosine that is not a number must show, so the test is the negative one.
void reflect_light(vec3 towards, vec3 irradiance, mat3 frame, vec3 wo, inout vec3 sum)
{
    vec3 wi = towards * frame;
#if defined(PBR_MAPS)
    sum += product_of_texel(wi, wo) * irradiance;
#else
    if (wi.z <= 0.0)
        return;
    vec3 f = brdf(wi, wo);
#if defined(SOURCE_NONE)
    sum += f * (wi.z * irradiance);
#else
    float reflectance = sigma / r_max * dot(f, LUMINANCE);
#if defined(SOURCE_PLANES)
    vec2 heading = towards * axes;
    light_turn = turn_of(heading);
    mean_heading += reflectance * wi.z * dot(irradiance, LUMINANCE) * heading;
#endif
#if defined(LOOKUP_TEXTURE) || defined(LOOKUP_OUTGOING)
    sum += reflectance * wi.z * irradiance;
#elif defined(LOOKUP_ANGLE)
    add_light(wi.z, reflectance * irradiance);
#else
    add_share(reflectance * wi.z, irradiance);
#endif
#endif
#endif
}

// Lights are the rows of a texture of two texels: the direction towards each in the world, and its irradiance.
vec3 shade(mat3 frame, vec3 wo)
{
    vec3 sum = vec3(0.0);
#if !defined(SOURCE_NONE)
    begin_light_sum(uv);
#endif
#if defined(SOURCE_PLANES)
    axes = texture_axes(position, uv, frame[2]);
    mean_heading = vec2(0.0);
#endif
    for (int i = 0; i < light_count; ++i) {
        vec3 towards = texelFetch(lights, ivec2(0, i), 0).xyz;
        vec3 irradiance = texelFetch(lights, ivec2(1, i), 0).rgb;
#if defined(SHADOWS)
        if (lit_by_distant(i, position, shadow_normal) == 0.0)
            continue;
#endif
        reflect_light(towards, irradiance, frame, wo, sum);
    }
#if defined(NEAR_LAMPS) && defined(FACETS)
    sum += near_radiance(position, frame, wo);
#elif defined(NEAR_LAMPS)
    for (int number = 0; number < near_count; ++number) {
        NearLamp lamp = near_lamp(number, position);
        int count = near_points_of(lamp, near_points);
#if defined(SHADOWS)
        float lit = lit_by_near(number, position, shadow_normal);
#else
        const float lit = 1.0;
#endif
        for (int i = 0; i < count; ++i) {
            vec3 direction, irradiance;
            near_light(lamp, i, count, direction, irradiance);
            irradiance *= lit;
            reflect_light(direction, irradiance, frame, wo, sum);
        }
    }
#endif
#if defined(SOURCE_NONE)
    return sum;
#else
#if defined(SOURCE_PLANES)
    light_turn = turn_of(mean_heading);
#endif
#if defined(LOOKUP_TEXTURE)
    add_light(1.0, sum);
#elif defined(LOOKUP_OUTGOING)
    float share = dot(sum, LUMINANCE);
    add_share(share, share > 0.0 ? sum / share : vec3(0.0));
#endif
    return light_sum(uv);
#endif
}

// The shading normal on the side that is seen. An interpolated normal may point away from the viewer near the
// silhouette, where a BRDF is 0 and a dark fringe would show: it is bent until it just faces the viewer.
vec3 visible_normal(vec3 wo)
{
    vec3 flat_normal = safe_normalize(cross(dFdx(position), dFdy(position)), wo);
    flat_normal *= dot(flat_normal, wo) < 0.0 ? -1.0 : 1.0;
    vec3 n = safe_normalize(normal, flat_normal) * (gl_FrontFacing ? 1.0 : -1.0);
    float facing = dot(n, wo);
    return facing < 0.01 ? safe_normalize(n + (0.01 - facing) * wo, wo) : n;
}

#if defined(PBR_MAPS)
// Radiance of the texel that was fetched.
vec3 shade_texel(mat3 bent, vec3 wo)
{
#if defined(VERTEX_COLOURS)
    base_here *= colour;
    joint_here *= colour;
#endif
    vec3 base = base_here, gloss = gloss_here, sum = vec3(0.0);
    for (int part = 0; part < parts_of_texel(); ++part) {
        float weight = choose_part(part, base, gloss);
        if (weight > 0.0)
            sum += weight * shade(bent, wo * bent);
    }
    return sum;
}
#endif

void main()
{
    vec3 wo = safe_normalize(eye - position, vec3(0.0, 0.0, 1.0));
#if defined(BRUSHED)
    mat3 frame = frame_along(visible_normal(wo), tangent);
#else
    mat3 frame = world_from_tangent(visible_normal(wo));
#endif
#if defined(SHADOWS)
    shadow_normal = frame[2];
#endif
#if defined(PBR_MAPS)
    begin_texels(position, uv, frame[2]);
    vec2 across = 0.25 * dFdx(uv), down = 0.25 * dFdy(uv);
    mat3 bent = fetch_texel(uv, 0.0, frame, wo);
    vec3 value = vec3(0.0);
    if (differ_within())
        for (int part = 0; part < 4; ++part) {
            vec2 shift = (part % 2 == 0 ? -across : across) + (part < 2 ? -down : down);
            bent = fetch_texel(uv + shift, 1.0, frame, wo);
            value += 0.25 * shade_texel(bent, wo);
        }
    else
        value = shade_texel(bent, wo);
#else
    vec3 value = shade(frame, wo * frame);
#endif
    radiance = vec4(max(value, 0.0), 1.0);
    if (any(isnan(value)) || any(isinf(value)))
#if defined(DEBUG)
        radiance = vec4(1.0, 0.0, 1.0, 2.0);
#else
        radiance = vec4(0.0, 0.0, 0.0, 1.0);
#endif
}
