// glTF 2.0, Appendix B.3: (1-F) (1-metallic) base_color/pi + F D G / (4 n.l n.v), G the product of two Smith terms,
// and beside it a share of the light that facets scatter more than once; over it sheen, and over that a clear coat.
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); out: 1/sr, no cosine, 0 below the horizon.

#include "brdf/highlight.glsl"
#include "brdf/microfacet.glsl"
#include "brdf/multiple_scattering.glsl"
#include "brdf/clear_coat.glsl"
#include "brdf/sheen.glsl"

uniform vec3 brdf_base_color;
uniform float brdf_metallic;
uniform float brdf_roughness;
uniform float brdf_multiple_scattering;

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    vec2 alpha = vec2(brdf_roughness * brdf_roughness);
    vec3 both = wi + wo;
    float size = length(both);
    float shadowing = (wi.z + ggx_slope_length(wi, alpha)) * (wo.z + ggx_slope_length(wo, alpha));
    vec3 f0 = 0.04 + (brdf_base_color - 0.04) * brdf_metallic;
    vec3 fresnel = f0 + (1.0 - f0) * schlick(wi, wo, size);
    vec3 diffuse = (1.0 - fresnel) * ((1.0 - brdf_metallic) * 0.31830988618379067 * brdf_base_color);
    vec3 value = diffuse + fresnel * (ggx_distribution(both / size, alpha) / shadowing);
#if !defined(SINGLE_SCATTERING)
    if (brdf_multiple_scattering > 0.0)
        value += brdf_multiple_scattering * multiple_scattering(wi.z, wo.z, alpha.x, f0);
#endif
#if !defined(NO_SHEEN)
    if (sheen_most() > 0.0) {
        vec2 fibres = sheen(wi.z, wo.z, dot(both.xy, both.xy) / (size * size));
        value = fibres.y * value + fibres.x * brdf_sheen_color;
    }
#endif
#if !defined(NO_COAT)
    if (brdf_coat_weight > 0.0) {
        float sine2 = dot(both.xy, both.xy) / (size * size);
        float coat = coat_lobe(wi.z, wo.z, sine2, brdf_multiple_scattering);
        value = mix(value, vec3(coat), coat_share(wo.z));
    }
#endif
    return value;
}
