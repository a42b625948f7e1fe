// @NAME@: a material exported by Lightarc. HLSL of shader model 4 and later; needs no other file.
// @LOSS@
//
// A directional map: a texel under light from any azimuth is a weighted sum of @PLANES@ planes, in codes of sRGB. It is
// looked up by the light of equal azimuth that gives, seen from above as in the photographs, the same
//     luminance(f(wi, wo)) * cos(theta_i)
// (after Kautz, Sattler, Sarlette, Klein and Seidel 2004). From above, photographs come back as they were taken.
//
// Usage, for one directional light of irradiance 1 (add up several):
//     float3 radiance = lightarc_radiance(wi, wo, planes, state, weights, weights_state, uv);
// planes: an array texture of @PLANES@ layers, the red channel of layer k is directional_plane<k>.png, 8 bits, data
//     without a colour transform; state: linear filter, repeating.
// weights: an array texture of floats, 1 + @PLANES@ layers of red, green, blue: first c.R, c.G, c.B of
//     directional_weights.exr, then planeNN.R, planeNN.G, planeNN.B; its first row is light overhead. weights_state:
//     linear filter, repeating along the first coordinate, clamped along the second.
// uv has v downwards (row 0 of the files on top) and repeats. wi (to the light) and wo (to the viewer) are unit vectors
// in the local frame of the surface: +x to the right of the pictures, +y upwards in them, +z the normal. The result is
// linear sRGB.

static const int LIGHTARC_PLANES = @PLANES@;
static const float LIGHTARC_GAIN = @GAIN@;
static const float LIGHTARC_LOWEST_COSINE = @LOWEST@;
static const float3 LUMINANCE = float3(0.2126390, 0.7151687, 0.0721923);

// ---- @BRDF_TEXT@
@BRDF@
// ---- Look-up

@SEARCH@
float3 lightarc_from_above(float cosine, float azimuth, Texture2DArray planes, SamplerState state,
    Texture2DArray weights, SamplerState weights_state, float2 uv)
{
    float columns, rows, layers;
    weights.GetDimensions(columns, rows, layers);
    float tilt = acos(clamp(cosine, 0.0, 1.0)) / 1.57079632679489662;
    float2 at = float2(azimuth / 6.28318530717958648 + 0.5 / columns, (tilt * (rows - 1.0) + 0.5) / rows);
    float3 code = weights.SampleLevel(weights_state, float3(at, 0.0), 0.0).rgb;
    for (int k = 0; k < LIGHTARC_PLANES; ++k)
        code += 255.0 * planes.Sample(state, float3(uv, float(k))).r
            * weights.SampleLevel(weights_state, float3(at, float(k + 1)), 0.0).rgb;
    code = max(code / 255.0, 0.0);
    float3 high = pow((max(code, 0.04045) + 0.055) / 1.055, 2.4);
    return min(cosine / LIGHTARC_LOWEST_COSINE, 1.0) * lerp(high, code / 12.92, step(code, 0.04045));
}

float3 lightarc_radiance(float3 wi, float3 wo, Texture2DArray planes, SamplerState state,
    Texture2DArray weights, SamplerState weights_state, float2 uv)
{
    float product = dot(brdf(wi, wo), LUMINANCE) * max(wi.z, 0.0);
    float azimuth = dot(wi.xy, wi.xy) > 0.0 ? atan2(wi.y, wi.x) : 0.0;
    float cosine = searched_cosine(wi, LIGHTARC_GAIN * product);
    return lightarc_from_above(cosine, azimuth, planes, state, weights, weights_state, uv);
}
