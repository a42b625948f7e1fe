// Lafortune, three lobes in each channel: kd/pi + sum of max(0, cxy (xx' + yy') + cz zz')^n.
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); out: 1/sr, no cosine, 0 below the horizon.

#include "brdf/power.glsl"
#include "brdf/cosine-lobe.glsl"

uniform vec3 brdf_kd;
uniform vec3 brdf_cxy1;
uniform vec3 brdf_cz1;
uniform vec3 brdf_exponent1;
uniform vec3 brdf_cxy2;
uniform vec3 brdf_cz2;
uniform vec3 brdf_exponent2;
uniform vec3 brdf_cxy3;
uniform vec3 brdf_cz3;
uniform vec3 brdf_exponent3;

float lafortune_lobe(vec3 wi, vec3 wo, float cxy, float cz, float exponent)
{
    float m = max(abs(cxy), abs(cz));
    if (m == 0.0)
        return exponent == 0.0 ? 1.0 : 0.0;
    return exp2(exponent * log2(m)) * power_of_one_minus(lobe_deficit(wi, wo, cxy, cz, m), exponent);
}

vec3 lafortune_lobes(vec3 wi, vec3 wo, vec3 cxy, vec3 cz, vec3 exponent)
{
    return vec3(
        lafortune_lobe(wi, wo, cxy.r, cz.r, exponent.r),
        lafortune_lobe(wi, wo, cxy.g, cz.g, exponent.g),
        lafortune_lobe(wi, wo, cxy.b, cz.b, exponent.b));
}

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    return brdf_kd * 0.31830988618379067
        + lafortune_lobes(wi, wo, brdf_cxy1, brdf_cz1, brdf_exponent1)
        + lafortune_lobes(wi, wo, brdf_cxy2, brdf_cz2, brdf_exponent2)
        + lafortune_lobes(wi, wo, brdf_cxy3, brdf_cz3, brdf_exponent3);
}
