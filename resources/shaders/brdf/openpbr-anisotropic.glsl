// OpenPBR Surface 1.1 with highlights of two widths.
// in: wi to the light, wo to the viewer, unit, surface frame (tangent +x, normal +z); out: 1/sr, no cosine, 0 below the
// horizon.

#include "brdf/openpbr_layers.glsl"

uniform vec3 brdf_base_color;
uniform float brdf_base_metalness;
uniform float brdf_specular_roughness;
uniform float brdf_specular_ior;
uniform float brdf_specular_roughness_anisotropy;
uniform float brdf_coat_roughness_anisotropy;
uniform float brdf_rotation_deg;

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    vec2 widths = two_widths(base_width(brdf_specular_roughness), brdf_specular_roughness_anisotropy);
    float smooth_coat = layer_square(max(brdf_coat_roughness, LAYER_SMOOTHEST));
    vec2 coat = two_widths(smooth_coat, brdf_coat_roughness_anisotropy);
    return reflect_layers(wi, wo, brdf_base_color, brdf_base_metalness, widths, brdf_specular_ior, coat,
                          brdf_rotation_deg);
}
