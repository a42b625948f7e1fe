// Ashikhmin-Shirley: an anisotropic Phong lobe with Schlick's Fresnel term, and what it leaves to the diffuse part.
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); out: 1/sr, no cosine, 0 below the horizon.

#include "brdf/highlight.glsl"
#include "brdf/power.glsl"

uniform vec3 brdf_kd;
uniform vec3 brdf_ks;
uniform float brdf_nu;
uniform float brdf_nv;

// 1 - (1 - y)^5
float diffuse_gain(float y)
{
    return y * (5.0 + y * (-10.0 + y * (10.0 + y * (y - 5.0))));
}

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    vec3 both = wi + wo;
    float size = length(both);
    vec2 squares = both.xy * both.xy;
    float across = squares.x + squares.y;
    float exponent = across > 0.0 ? (brdf_nu * squares.x + brdf_nv * squares.y) / across : 0.0;
    float lobe = sqrt((brdf_nu + 1.0) * (brdf_nv + 1.0)) * 0.07957747154594767
        * power_of_one_minus(half_deficit(both, size), exponent) / (size * max(wi.z, wo.z));
    float under = 0.38750768752816408 * diffuse_gain(0.5 * wi.z) * diffuse_gain(0.5 * wo.z);
    return lobe * brdf_ks + (1.0 - brdf_ks) * (lobe * schlick(wi, wo, size) + brdf_kd * under);
}
