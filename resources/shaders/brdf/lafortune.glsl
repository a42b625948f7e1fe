// Lafortune, one lobe: kd/pi + ks (n+2)/(2 pi m^n) max(0, cxy (xx' + yy') + cz zz')^n, m = max(|cxy|, |cz|).
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); out: 1/sr, no cosine, 0 below the horizon.

#include "brdf/power.glsl"
#include "brdf/cosine-lobe.glsl"

uniform vec3 brdf_kd;
uniform vec3 brdf_ks;
uniform float brdf_cxy;
uniform float brdf_cz;
uniform float brdf_exponent;

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    vec3 diffuse = brdf_kd * 0.31830988618379067;
    float m = max(abs(brdf_cxy), abs(brdf_cz));
    if (m == 0.0)
        return diffuse;
    float lobe = power_of_one_minus(lobe_deficit(wi, wo, brdf_cxy, brdf_cz, m), brdf_exponent);
    return diffuse + brdf_ks * (lobe * (brdf_exponent + 2.0) * 0.15915494309189535);
}
