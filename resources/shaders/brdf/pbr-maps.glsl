// PBR maps: the BRDF of metallic-roughness.glsl at each texel, with the f0 of dielectrics beside it, and the normal that
// bends the frame (engine.render.pbr). fetch_texel comes before brdf.
// in: the layers base colour; roughness, metallic and f0; normal. out: 1/sr, no cosine, 0 below the horizon.

#include "brdf/highlight.glsl"
#include "brdf/microfacet.glsl"
#include "texture_axes.glsl"

uniform sampler2DArray pbr_maps;
uniform float pbr_smoothest;

vec3 base_here;
vec3 gloss_here;

// The frame about the normal of the map at these coordinates (v down), from that of the surface.
mat3 fetch_texel(vec3 place, vec2 uv, mat3 frame, vec3 wo)
{
    vec2 size = vec2(textureSize(pbr_maps, 0).xy);
    vec2 across = dFdx(uv) * size;
    vec2 down = dFdy(uv) * size;
    float detail = 0.5 * log2(max(max(dot(across, across), dot(down, down)), 1e-30));
    base_here = textureLod(pbr_maps, vec3(uv, 0.0), detail).rgb;
    gloss_here = textureLod(pbr_maps, vec3(uv, 1.0), detail).rgb;
    vec3 tilt = textureLod(pbr_maps, vec3(uv, 2.0), detail).xyz;
    mat2x3 axes = texture_axes(place, uv, frame[2]);
    vec3 n = safe_normalize(axes * tilt.xy + tilt.z * frame[2], frame[2]);
    float facing = dot(n, wo);
    return world_from_tangent(facing < 0.01 ? safe_normalize(n + (0.01 - facing) * wo, wo) : n);
}

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    float roughness = max(gloss_here.x, pbr_smoothest);
    float metallic = gloss_here.y;
    vec2 alpha = vec2(roughness * roughness);
    vec3 both = wi + wo;
    float size = length(both);
    float shadowing = (wi.z + ggx_slope_length(wi, alpha)) * (wo.z + ggx_slope_length(wo, alpha));
    vec3 f0 = gloss_here.z * (1.0 - metallic) + base_here * metallic;
    vec3 fresnel = f0 + (1.0 - f0) * schlick(wi, wo, size);
    vec3 diffuse = (1.0 - fresnel) * ((1.0 - metallic) * 0.31830988618379067 * base_here);
    return diffuse + fresnel * (ggx_distribution(both / size, alpha) / shadowing);
}
