// OpenPBR Surface 1.1 with highlights of one width.
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); out: 1/sr, no cosine, 0 below the horizon.

#include "brdf/openpbr_layers.glsl"

uniform vec3 brdf_base_color;
uniform float brdf_base_metalness;
uniform float brdf_specular_roughness;
uniform float brdf_specular_ior;

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    vec2 widths = vec2(base_width(brdf_specular_roughness));
    vec2 coat = vec2(layer_square(max(brdf_coat_roughness, LAYER_SMOOTHEST)));
    return reflect_layers(wi, wo, brdf_base_color, brdf_base_metalness, widths, brdf_specular_ior, coat, 0.0);
}
