// Sums of products of two textures, as engine/factor/separable_factors.py looks them up.
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); out: 1/sr, no cosine, 0 below the horizon.
// A layer per term; the map of the textures and what lies in them are described in engine/factor/hemisphere_map.py.

#include "brdf/ceiling.glsl"
#include "direction_map.glsl"

uniform sampler2DArray brdf_first;
uniform sampler2DArray brdf_second;
uniform int brdf_terms;

// 1 where the textures belong to half and difference vector, 0 to viewer and light.
uniform int brdf_of_half;

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    vec3 one = wo;
    vec3 other = wi;
    if (brdf_of_half == 1) {
        vec3 both = wi + wo;
        vec3 between = wi - wo;
        float size = length(both);
        one = size > 1e-11 ? both / size : vec3(0.0, 0.0, 1.0);
        float across = length(one.xy);
        vec2 turn = across > 0.0 ? one.xy / across : vec2(1.0, 0.0);
        other = 0.5 * vec3(one.z * dot(turn, between.xy) - across * between.z,
                           turn.x * between.y - turn.y * between.x, size);
    }
    Taps first = taps_of(one);
    Taps second = taps_of(other);
    vec3 sum = vec3(0.0);
    for (int term = 0; term < brdf_terms; ++term) {
        vec3 a = vec3(0.0);
        vec3 b = vec3(0.0);
        for (int k = 0; k < 4; ++k) {
            a += first.weight[k] * texelFetch(brdf_first, ivec3(first.place[k], term), 0).rgb;
            b += second.weight[k] * texelFetch(brdf_second, ivec3(second.place[k], term), 0).rgb;
        }
        sum += a * b;
    }
    return under_ceiling(max(sum, 0.0), wi, wo);
}
