// From linear radiance to the sRGB-coded display; engine.core.colour.tone_map and srgb_encode in GLSL.

uniform float gain;
uniform int operator;
uniform vec3 background;

const float BRIGHTEST = 1e15;

vec3 neutral(vec3 colour)
{
    const float start = 0.8 - 0.04;
    float low = min(colour.r, min(colour.g, colour.b));
    colour -= low < 0.08 ? low - 6.25 * low * low : 0.04;
    float peak = max(colour.r, max(colour.g, colour.b));
    if (peak < start)
        return colour;
    float compressed = 1.0 - (1.0 - start) * (1.0 - start) / (peak + 1.0 - 2.0 * start);
    float grey = 1.0 - 1.0 / (0.15 * (peak - compressed) + 1.0);
    return mix(colour * (compressed / peak), vec3(compressed), grey);
}

vec3 aces(vec3 colour)
{
    const mat3 from_srgb = mat3(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
    const mat3 to_srgb = mat3(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602);
    vec3 v = from_srgb * colour;
    vec3 fitted = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081);
    return clamp(to_srgb * fitted, 0.0, 1.0);
}

vec3 srgb_encode(vec3 linear)
{
    vec3 high = 1.055 * pow(max(linear, 0.0031308), vec3(1.0 / 2.4)) - 0.055;
    return mix(high, linear * 12.92, lessThanEqual(linear, vec3(0.0031308)));
}

// What a screen shows of radiance times coverage, and coverage.
vec4 shown(vec4 picture)
{
    vec3 colour = picture.a > 0.0 ? picture.rgb / picture.a : vec3(0.0);
    colour = clamp(colour, 0.0, min(BRIGHTEST, BRIGHTEST / gain)) * gain;
    if (operator == 1)
        colour = neutral(colour);
    else if (operator == 2)
        colour = aces(colour);
    return vec4(srgb_encode(mix(background, clamp(colour, 0.0, 1.0), picture.a)), 1.0);
}
