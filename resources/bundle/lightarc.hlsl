// @NAME@: a material exported by Lightarc. HLSL of shader model 4 and later; needs no other file.
// @LOSS@
//
// Shading maps after Kautz, Sattler, Sarlette, Klein and Seidel 2004: the radiance of a texel depends on
//     r = sigma * luminance(f(wi, wo)) * cos(theta_i),
// and is stored compressed, S(r) = scale * (r / r_max)^exponent for each texel and channel.
//
// Usage, for one directional light of irradiance 1 (add up several):
//     float3 scale = power_law_scale.Sample(state, uv).rgb;       // power_law_scale.exr, 32-bit floats, linear
//     float3 exponent = power_law_exponent.Sample(state, uv).rgb * LIGHTARC_EXPONENT_RANGE;
//         // power_law_exponent.exr, or where there is a power_law_exponent.png its codes from 0 to 1; data
//     float3 radiance = lightarc_radiance(wi, wo, scale, exponent);
// uv has v downwards (row 0 of the files on top) and repeats. wi (to the light) and wo (to the viewer) are unit vectors
// in the local frame of the surface: tangent +x, bitangent +y, normal +z. The result is linear sRGB.
// With the slices of shading_map.exr as a texture array: lightarc_slices(r, slices, state, layers, uv).

static const float LIGHTARC_SIGMA = @SIGMA@;
static const float LIGHTARC_R_MAX = @R_MAX@;
static const float LIGHTARC_EXPONENT_RANGE = @EXPONENT_RANGE@;

// ---- @BRDF_TEXT@
@BRDF@
// ---- Shading map

float lightarc_r(float3 wi, float3 wo)
{
    return LIGHTARC_SIGMA * dot(brdf(wi, wo), float3(0.2126390, 0.7151687, 0.0721923)) * max(wi.z, 0.0);
}

float3 lightarc_power_law(float r, float3 scale, float3 exponent)
{
    float share = r > 0.0 ? min(r / LIGHTARC_R_MAX, 1.0) : 0.0;
    return share > 0.0 ? scale * exp2(max(exponent, 0.0) * log2(share)) : float3(0.0, 0.0, 0.0);
}

float3 lightarc_slices(float r, Texture2DArray slices, SamplerState state, float layers, float2 uv)
{
    float layer = (r > 0.0 ? min(r / LIGHTARC_R_MAX, 1.0) : 0.0) * (layers - 1.0);
    float lower = min(floor(layer), layers - 2.0);
    float3 below = slices.Sample(state, float3(uv, lower)).rgb;
    return lerp(below, slices.Sample(state, float3(uv, lower + 1.0)).rgb, layer - lower);
}

float3 lightarc_radiance(float3 wi, float3 wo, float3 scale, float3 exponent)
{
    return lightarc_power_law(lightarc_r(wi, wo), scale, exponent);
}
