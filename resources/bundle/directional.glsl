// @NAME@: a material exported by Lightarc. GLSL 3.30 and later, GLSL ES 3.00 and later; needs no other file.
// @LOSS@
//
// A directional map: a texel under light from any azimuth is a weighted sum of @PLANES@ planes, in codes of sRGB. It is
// looked up by the light of equal azimuth that gives, seen from above as in the photographs, the same
//     luminance(f(wi, wo)) * cos(theta_i)
// (after Kautz, Sattler, Sarlette, Klein and Seidel 2004). From above, photographs come back as they were taken.
//
// Usage, for one directional light of irradiance 1 (add up several):
//     vec3 radiance = lightarc_radiance(wi, wo, planes, weights, uv);
// planes: an array texture of @PLANES@ layers, the red channel of layer k is directional_plane<k>.png, 8 bits, data
//     without a colour transform, linear filter, repeating.
// weights: an array texture of floats, 1 + @PLANES@ layers of red, green, blue: first c.R, c.G, c.B of
//     directional_weights.exr, then planeNN.R, planeNN.G, planeNN.B; its first row is light overhead. Linear filter,
//     repeating along the first coordinate, clamped along the second.
// uv has v downwards (row 0 of the files on top) and repeats. wi (to the light) and wo (to the viewer) are unit vectors
// in the local frame of the surface: +x to the right of the images, +y upwards in them, +z the normal. The result is
// linear sRGB.
// In GLSL ES, begin with: precision highp float; precision highp sampler2D; precision highp sampler2DArray;

const int LIGHTARC_PLANES = @PLANES@;
const float LIGHTARC_GAIN = @GAIN@;
const float LIGHTARC_LOWEST_COSINE = @LOWEST@;
const vec3 LUMINANCE = vec3(0.2126390, 0.7151687, 0.0721923);

// ---- @BRDF_TEXT@
@BRDF@
// ---- Look-up

@SEARCH@
vec3 lightarc_from_above(float cosine, float azimuth, sampler2DArray planes, sampler2DArray weights, vec2 uv)
{
    vec2 size = vec2(textureSize(weights, 0).xy);
    float tilt = acos(clamp(cosine, 0.0, 1.0)) / 1.57079632679489662;
    vec2 at = vec2(azimuth / 6.28318530717958648, (tilt * (size.y - 1.0))  / size.y) + 0.5 / size;
    vec3 code = textureLod(weights, vec3(at, 0.0), 0.0).rgb;
    for (int k = 0; k < LIGHTARC_PLANES; ++k)
        code += 255.0 * texture(planes, vec3(uv, float(k))).r * textureLod(weights, vec3(at, float(k + 1)), 0.0).rgb;
    code = max(code / 255.0, 0.0);
    vec3 high = pow((max(code, 0.04045) + 0.055) / 1.055, vec3(2.4));
    return min(cosine / LIGHTARC_LOWEST_COSINE, 1.0) * mix(high, code / 12.92, lessThanEqual(code, vec3(0.04045)));
}

vec3 lightarc_radiance(vec3 wi, vec3 wo, sampler2DArray planes, sampler2DArray weights, vec2 uv)
{
    float product = dot(brdf(wi, wo), LUMINANCE) * max(wi.z, 0.0);
    float azimuth = dot(wi.xy, wi.xy) > 0.0 ? atan(wi.y, wi.x) : 0.0;
    return lightarc_from_above(searched_cosine(wi, LIGHTARC_GAIN * product), azimuth, planes, weights, uv);
}
