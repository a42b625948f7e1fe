// The largest values that factors of a measurement may have, as engine/brdf/ceiling.py looks them up.
// brdf_ceiling has columns theta_i and rows theta_o from 0 to a quarter turn, and layers |phi_i - phi_o| to half a turn.

#include "brdf/angle.glsl"

uniform sampler2DArray brdf_ceiling;

// 0 where there is no ceiling.
uniform int brdf_bounded;

vec3 ceiling_row(ivec3 low, float across)
{
    return mix(texelFetch(brdf_ceiling, low, 0).rgb, texelFetch(brdf_ceiling, low + ivec3(1, 0, 0), 0).rgb, across);
}

vec3 under_ceiling(vec3 value, vec3 wi, vec3 wo)
{
    if (brdf_bounded == 0)
        return value;
    float last = float(textureSize(brdf_ceiling, 0).x - 1);
    vec2 sines = vec2(length(wi.xy), length(wo.xy));
    float apart = 0.0;
    if (min(sines.x, sines.y) > 0.0) {
        int quarters;
        float beyond = precise_quarter(abs(wi.x * wo.y - wi.y * wo.x), dot(wi.xy, wo.xy), quarters);
        apart = 0.5 * float(quarters) + beyond * 0.31830989;
    }
    vec2 angles = vec2(precise_angle(sines.x, wi.z), precise_angle(sines.y, wo.z)) * 0.63661977;
    vec3 at = clamp(vec3(angles, apart), 0.0, 1.0) * last;
    ivec3 low = min(ivec3(at), ivec3(int(last) - 1));
    vec3 part = at - vec3(low);
    vec3 near = mix(ceiling_row(low, part.x), ceiling_row(low + ivec3(0, 1, 0), part.x), part.y);
    vec3 far = mix(ceiling_row(low + ivec3(0, 0, 1), part.x), ceiling_row(low + ivec3(0, 1, 1), part.x), part.y);
    return min(value, mix(near, far, part.z));
}
