// Blinn-Phong: kd/pi + ks (n+2)(n+4)/(8 pi (2^(-n/2) + n)) (n.h)^n.
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); out: 1/sr, no cosine, 0 below the horizon.

#include "brdf/power.glsl"

uniform vec3 brdf_kd;
uniform vec3 brdf_ks;
uniform float brdf_exponent;

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    vec3 both = wi + wo;
    float across = dot(both.xy, both.xy);
    float size = length(both);
    float lobe = power_of_one_minus(across / (size * (size + both.z)), brdf_exponent);
    float norm = (brdf_exponent + 2.0) * 0.039788735772973836
        * ((brdf_exponent + 4.0) / (exp2(-0.5 * brdf_exponent) + brdf_exponent));
    return brdf_kd * 0.31830988618379067 + brdf_ks * (lobe * norm);
}
