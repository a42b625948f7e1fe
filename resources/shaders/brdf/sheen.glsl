// Sheen as glTF defines it (engine.brdf.models.sheen has the formulas, their source and the fit).

uniform vec3 brdf_sheen_color;
uniform float brdf_sheen_roughness;

const float SHEEN_SMOOTHEST = 0.05;
const float SHEEN_LOWEST = 1e-6;

float sheen_most()
{
    return max(max(brdf_sheen_color.x, brdf_sheen_color.y), brdf_sheen_color.z);
}

float sheen_roughness()
{
    return max(brdf_sheen_roughness, SHEEN_SMOOTHEST);
}

// in: a cosine above the horizon, and alpha; out: Lambda, of fibres that hide each other.
float sheen_masking(float cosine, float alpha)
{
    float smoothness = (1.0 - alpha) * (1.0 - alpha);
    float a = mix(21.5473, 25.3245, smoothness);
    float b = mix(3.82987, 3.32435, smoothness);
    float c = mix(0.19823, 0.16801, smoothness);
    float d = mix(-1.97760, -1.27393, smoothness);
    float e = mix(-4.32054, -4.85967, smoothness);
    float x = cosine < 0.5 ? cosine : max(1.0 - cosine, 0.0);
    float exponent = a / (1.0 + b * pow(x, c)) + d * x + e;
    float middle = a / (1.0 + b * pow(0.5, c)) + d * 0.5 + e;
    return exp(cosine < 0.5 ? exponent : 2.0 * middle - exponent);
}

// in: a cosine above the horizon, its Lambda; out: the share of light that white sheen reflects.
float sheen_albedo(float cosine, float masked, float roughness)
{
    float x = 2.0 * sqrt(cosine) - 1.0;
    float y = 1.0 + log(roughness) * (2.0 / 3.0);
    float six = (((-0.380 * y + 1.009) * y - 0.694) * y + 0.461) * y - 0.468;
    float five = (((-1.083 * y + 1.539) * y - 0.199) * y + 0.447) * y - 0.711;
    float four = (((-0.451 * y - 0.717) * y + 1.185) * y + 0.668) * y - 0.722;
    float three = (((0.795 * y - 1.329) * y - 0.879) * y + 2.289) * y - 0.952;
    float two = (((0.039 * y + 1.785) * y - 4.324) * y + 4.150) * y - 1.760;
    float one = (((-1.006 * y + 3.071) * y - 4.521) * y + 4.791) * y - 2.934;
    float none = (((-0.465 * y + 1.332) * y - 1.603) * y + 0.852) * y - 1.027;
    float value = (((((six * x + five) * x + four) * x + three) * x + two) * x + one) * x + none;
    return exp(value) / (cosine * (1.0 + masked));
}

// in: cosines to the light and the viewer, and sin^2 of the half vector;
// out: the lobe D V in 1/sr without its colour, and the share of what lies below that is left.
vec2 sheen(float cosine_i, float cosine_o, float sine2)
{
    float roughness = sheen_roughness();
    float alpha = roughness * roughness;
    float light = max(cosine_i, SHEEN_LOWEST), viewer = max(cosine_o, SHEEN_LOWEST);
    float masked_i = sheen_masking(light, alpha);
    float masked_o = sheen_masking(viewer, alpha);
    float distribution = (2.0 + 1.0 / alpha) * 0.15915494309189535 * pow(sine2, 0.5 / alpha);
    float lobe = distribution / ((1.0 + masked_i + masked_o) * (4.0 * light * viewer));
    float albedo = max(sheen_albedo(light, masked_i, roughness), sheen_albedo(viewer, masked_o, roughness));
    return vec2(lobe, max(1.0 - sheen_most() * albedo, 0.0));
}
