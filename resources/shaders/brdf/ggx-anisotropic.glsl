// GGX with a width along the tangent and one across it: kd/pi + F D G2 / (4 n.l n.v).
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); out: 1/sr, no cosine, 0 below the horizon.

#include "brdf/highlight.glsl"
#include "brdf/microfacet.glsl"

uniform vec3 brdf_kd;
uniform float brdf_alpha_x;
uniform float brdf_alpha_y;
uniform vec3 brdf_f0;

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    vec2 alpha = vec2(brdf_alpha_x, brdf_alpha_y);
    vec3 both = wi + wo;
    float size = length(both);
    float slopes = wi.z * ggx_slope_length(wo, alpha) + wo.z * ggx_slope_length(wi, alpha);
    vec3 fresnel = brdf_f0 + (1.0 - brdf_f0) * schlick(wi, wo, size);
    return brdf_kd * 0.31830988618379067 + fresnel * (0.5 * ggx_distribution(both / size, alpha) / slopes);
}
