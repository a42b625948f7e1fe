// @NAME@: a material exported by Lightarc. GLSL 3.30 and later, GLSL ES 3.00 and later; needs no other file.
// @LOSS@
//
// Shading maps after Kautz, Sattler, Sarlette, Klein and Seidel 2004: the radiance of a texel depends on
//     r = sigma * luminance(f(wi, wo)) * cos(theta_i),
// and is stored compressed, S(r) = scale * (r / r_max)^exponent for each texel and channel.
//
// Usage, for one directional light of irradiance 1 (add up several):
//     vec3 scale = texture(power_law_scale, uv).rgb;        // power_law_scale.exr, 32-bit floats, linear
//     vec3 exponent = texture(power_law_exponent, uv).rgb * LIGHTARC_EXPONENT_RANGE;  // power_law_exponent.exr, 32-bit
//         floats, or where there is a power_law_exponent.png its codes from 0 to 1; data, no colour transform
//     vec3 radiance = lightarc_radiance(wi, wo, scale, exponent);
// uv has v downwards (row 0 of the files on top) and repeats. wi (to the light) and wo (to the viewer) are unit vectors
// in the local frame of the surface: tangent +x, bitangent +y, normal +z. The result is linear sRGB.
// In GLSL ES, begin with: precision highp float; precision highp sampler2D; precision highp sampler2DArray;
// With the slices of shading_map.exr as the layers of an array texture: lightarc_slices(r, slices, layers, uv).
// Where power_law_kept_tiles.exr lies beside the pair, some tiles keep their slices, because a power law describes them
// too badly. With these slices as the layers of an array texture and A in the alpha of each layer:
//     vec3 radiance = lightarc_mixed(lightarc_r(wi, wo), scale, exponent, kept, layers, uv);

const float LIGHTARC_SIGMA = @SIGMA@;
const float LIGHTARC_R_MAX = @R_MAX@;
const float LIGHTARC_EXPONENT_RANGE = @EXPONENT_RANGE@;

// ---- @BRDF_TEXT@
@BRDF@
// ---- Shading map

float lightarc_r(vec3 wi, vec3 wo)
{
    return LIGHTARC_SIGMA * dot(brdf(wi, wo), vec3(0.2126390, 0.7151687, 0.0721923)) * max(wi.z, 0.0);
}

vec3 lightarc_power_law(float r, vec3 scale, vec3 exponent)
{
    float share = r > 0.0 ? min(r / LIGHTARC_R_MAX, 1.0) : 0.0;
    return share > 0.0 ? scale * exp2(max(exponent, 0.0) * log2(share)) : vec3(0.0);
}

vec4 lightarc_layers(float r, sampler2DArray slices, float layers, vec2 uv)
{
    float layer = (r > 0.0 ? min(r / LIGHTARC_R_MAX, 1.0) : 0.0) * (layers - 1.0);
    float lower = min(floor(layer), layers - 2.0);
    return mix(texture(slices, vec3(uv, lower)), texture(slices, vec3(uv, lower + 1.0)), layer - lower);
}

vec3 lightarc_slices(float r, sampler2DArray slices, float layers, vec2 uv)
{
    return lightarc_layers(r, slices, layers, uv).rgb;
}

vec3 lightarc_mixed(float r, vec3 scale, vec3 exponent, sampler2DArray kept, float layers, vec2 uv)
{
    vec4 tiles = lightarc_layers(r, kept, layers, uv);
    return tiles.rgb + (1.0 - tiles.a) * lightarc_power_law(r, scale, exponent);
}

vec3 lightarc_radiance(vec3 wi, vec3 wo, vec3 scale, vec3 exponent)
{
    return lightarc_power_law(lightarc_r(wi, wo), scale, exponent);
}
