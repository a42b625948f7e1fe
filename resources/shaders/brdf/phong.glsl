// Modified Phong (Lewis 1993): kd/pi + ks (n+2)/(2 pi) max(0, r.wo)^n, r the mirror direction of wi.
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); out: 1/sr, no cosine, 0 below the horizon.

#include "brdf/power.glsl"

uniform vec3 brdf_kd;
uniform vec3 brdf_ks;
uniform float brdf_exponent;

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    vec3 difference = wi * vec3(-1.0, -1.0, 1.0) - wo;
    float lobe = power_of_one_minus(0.5 * dot(difference, difference), brdf_exponent);
    return brdf_kd * 0.31830988618379067 + brdf_ks * (lobe * (brdf_exponent + 2.0) * 0.15915494309189535);
}
