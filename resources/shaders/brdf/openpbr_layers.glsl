// What the layers of an OpenPBR surface reflect (engine.brdf.models.openpbr has the formulas and their sources).
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); 1/sr, no cosine, 0 below the horizon.
// Renderers without a graphics card take the time of all branches: NO_COAT, NO_FUZZ, NO_FILM, NO_METAL and NO_DIELECTRIC
// leave out what a material has not.

#include "brdf/microfacet.glsl"

uniform float brdf_base_weight;
uniform float brdf_base_diffuse_roughness;
uniform float brdf_specular_weight;
uniform vec3 brdf_specular_color;
uniform float brdf_coat_weight;
uniform vec3 brdf_coat_color;
uniform float brdf_coat_roughness;
uniform float brdf_coat_ior;
uniform float brdf_coat_darkening;
uniform float brdf_fuzz_weight;
uniform vec3 brdf_fuzz_color;
uniform float brdf_fuzz_roughness;
uniform float brdf_thin_film_weight;
uniform float brdf_thin_film_thickness;
uniform float brdf_thin_film_ior;

const float LAYER_PI = 3.14159265358979;
const float LAYER_SMOOTHEST = 0.02;
const float FUJII = 0.2877934;
const float FUJII_MEAN = 0.0724882;

float layer_square(float x)
{
    return x * x;
}

float f0_of_index(float ior)
{
    return layer_square((ior - 1.0) / (ior + 1.0));
}

// 1 - E, the share that one reflection of white facets loses (engine.brdf.models.multiple_scattering, correlated).
float correlated_loss(float cosine, float alpha)
{
    float r = sqrt(alpha);
    float s = cosine / (cosine + alpha);
    float five = (((400.0 * r - 265.685) * r + 68.600) * r + 4.042) * r - 11.805;
    float four = (((-396.618 * r + 197.341) * r - 23.419) * r - 10.436) * r + 13.166;
    float three = (((147.274 * r - 65.560) * r + 42.627) * r - 18.654) * r - 0.204;
    float two = (((-60.129 * r + 94.568) * r - 79.914) * r + 27.925) * r - 1.957;
    float one = (((8.764 * r - 15.875) * r + 16.931) * r - 6.520) * r + 0.927;
    float none = (((-0.514 * r + 1.298) * r - 1.145) * r + 0.412) * r - 0.051;
    float lost = ((((five * s + four) * s + three) * s + two) * s + one) * s + none;
    return max((1.0 - s) * (1.0 - s) * lost, 0.0);
}

float correlated_mean_loss(float alpha)
{
    float r = sqrt(alpha);
    float mean = -0.8008 + (25.0674 + (-107.6096 + (226.4853 + (-261.2855 + (156.8873 - 38.1516 * r) * r) * r) * r) * r) * r;
    return alpha * alpha * (mean - 1.0537 * log(r));
}

vec3 further_reflectance(vec3 fresnel, float lost)
{
    return fresnel * fresnel * (1.0 - lost) / (1.0 - fresnel * lost);
}

// Light that facets scatter more than once, for the mean of Fresnel's term.
vec3 scatter_again(vec3 wi, vec3 wo, float alpha, vec3 fresnel)
{
    float lost = correlated_mean_loss(alpha);
    float lobe = correlated_loss(wi.z, alpha) * correlated_loss(wo.z, alpha) / (LAYER_PI * lost);
    return further_reflectance(fresnel, lost) * lobe;
}

vec3 schlick_mean(vec3 f0)
{
    return f0 + (1.0 - f0) / 21.0;
}

// The mean of (1 - h.v)^5 over what GGX with F = 1 reflects.
float grazing_share(float cosine, float alpha)
{
    float r = sqrt(alpha);
    float t = 1.0 - cosine;
    float five = (((85.940 * r - 200.0) * r + 200.0) * r - 61.973) * r - 10.579;
    float four = (((-115.445 * r + 163.122) * r - 185.269) * r + 59.230) * r + 35.310;
    float three = (((20.017 * r + 200.0) * r - 175.510) * r + 47.916) * r - 40.193;
    float two = (((-29.148 * r - 146.569) * r + 186.615) * r - 61.168) * r + 20.696;
    float one = (((41.822 * r - 17.211) * r - 27.295) * r + 14.840) * r - 4.467;
    float none = (((-9.112 * r + 11.694) * r - 3.209) * r - 0.339) * r + 0.294;
    return clamp(t * (((((five * t + four) * t + three) * t + two) * t + one) * t + none), 0.0, 1.0);
}

// Albedo of a highlight of which one reflection takes this first share.
vec3 reflected_share(float cosine, float alpha, vec3 first, vec3 average)
{
    float lost = correlated_loss(cosine, alpha);
    return first * (1.0 - lost) + further_reflectance(average, correlated_mean_loss(alpha)) * lost;
}

// D G2 / (4 n.l n.v) of GGX with Smith's height-correlated term.
float layer_ggx(vec3 wi, vec3 wo, vec3 h, vec2 alpha)
{
    float slopes = wi.z * ggx_slope_length(wo, alpha) + wo.z * ggx_slope_length(wi, alpha);
    return 0.5 * ggx_distribution(h, alpha) / slopes;
}

// Reflectance of both polarisations, across the plane of incidence and in it; 1 where all is reflected.
vec2 fresnel_polarised(float cosine, float ior)
{
    float square = ior * ior + cosine * cosine - 1.0;
    if (square <= 0.0)
        return vec2(1.0);
    float inner = sqrt(square);
    float across = (cosine - inner) / (cosine + inner);
    float along = (ior * ior * cosine - inner) / (ior * ior * cosine + inner);
    return vec2(across * across, along * along);
}

float fresnel_dielectric(float cosine, float ior)
{
    vec2 both = fresnel_polarised(cosine, ior);
    return 0.5 * (both.x + both.y);
}

float fresnel_mean(float ior)
{
    return (ior - 1.0) / (4.08567 + 1.00071 * ior);
}

// An h.v that stands for those of the facets that a viewer sees.
float typical_cosine(float cosine, float alpha)
{
    return sqrt(cosine * cosine + 0.28 * alpha * (1.0 - cosine * cosine));
}

vec3 share_of_dielectric(float cosine, float alpha, float ior)
{
    float first = fresnel_dielectric(1.0 - pow(grazing_share(cosine, alpha), 0.2), ior);
    return reflected_share(cosine, alpha, vec3(first), vec3(fresnel_mean(ior)));
}

// Schlick's term with a tint at 82 degrees.
vec3 fresnel_hoffman(float cosine, vec3 f0, vec3 tint)
{
    float aside = 1.0 - cosine;
    float aside2 = aside * aside;
    vec3 there = f0 + (1.0 - f0) * 0.46266436; // (6/7)^5
    vec3 lowered = there * (1.0 - tint) * (17.651412 * cosine * aside2 * aside2 * aside2); // 7 / (6/7)^6
    return max(f0 + (1.0 - f0) * (aside2 * aside2 * aside) - lowered, 0.0);
}

vec3 eye_sensitivity(float path, vec3 shift)
{
    float phase = 2.0 * LAYER_PI * path;
    vec3 height = vec3(5.4856e-13, 4.4201e-13, 5.2481e-13);
    vec3 place = vec3(1.6810e6, 1.7953e6, 2.2084e6);
    vec3 variance = vec3(4.3278e9, 9.3046e9, 6.6121e9);
    vec3 value = height * sqrt(2.0 * LAYER_PI * variance) * cos(place * phase + shift) * exp(-variance * phase * phase);
    value.x += 9.7470e-14 * sqrt(2.0 * LAYER_PI * 4.5282e9) * cos(2.2399e6 * phase + shift.x) *
               exp(-4.5282e9 * phase * phase);
    return value / 1.0685e-7;
}

// Light between the faces of a thin film: reflectances of the lower face and the phases that it adds, in polarisations.
vec3 fresnel_airy(float cosine, vec3 lower_across, vec3 lower_along, vec3 turned_across, vec3 turned_along)
{
    float index = brdf_thin_film_ior;
    vec2 upper = fresnel_polarised(cosine, index);
    float path = 2e-6 * brdf_thin_film_thickness * index * sqrt(1.0 - (1.0 - cosine * cosine) / (index * index));
    float phase_along = cosine < inversesqrt(1.0 + index * index) ? 0.0 : LAYER_PI;
    vec3 total = vec3(0.0);
    for (int way = 0; way < 2; way++) {
        float face = way == 0 ? upper.x : upper.y;
        vec3 lower = way == 0 ? lower_across : lower_along;
        vec3 turned = way == 0 ? turned_across + LAYER_PI : turned_along + phase_along;
        float let = 1.0 - face;
        vec3 constant = let * let * lower / max(1.0 - face * lower, 1e-9);
        vec3 product = sqrt(face * lower);
        vec3 swing = (constant - let) * product;
        vec3 xyz = face + constant + 2.0 * swing * eye_sensitivity(path, turned);
        xyz += 2.0 * swing * product * eye_sensitivity(2.0 * path, 2.0 * turned);
        total += 0.5 * xyz;
    }
    mat3 rgb_from_xyz = mat3(2.3706743, -0.5138850, 0.0052982, -0.9000405, 1.4253036, -0.0146949, -0.4706338, 0.0885814,
                             1.0093968);
    return clamp(rgb_from_xyz * total, 0.0, 1.0);
}

vec3 film_on_dielectric(float cosine, float ior)
{
    float index = brdf_thin_film_ior;
    float inner = sqrt(1.0 - (1.0 - cosine * cosine) / (index * index));
    float ratio = ior / index;
    vec2 lower = fresnel_polarised(inner, ratio);
    float slow = sqrt(max(ratio * ratio + inner * inner - 1.0, 0.0));
    float turned_along = ratio * ratio * inner < slow ? LAYER_PI : 0.0;
    float turned_across = ratio < 1.0 ? LAYER_PI : 0.0;
    return fresnel_airy(cosine, vec3(lower.x), vec3(lower.y), vec3(turned_across), vec3(turned_along));
}

float fujii_loss(float cosine)
{
    float sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    float steep = sine * cosine * (1.0 + sine + sine * sine) / (1.0 + sine);
    float gain = sine * (acos(min(cosine, 1.0)) - sine * cosine) + 2.0 / 3.0 * (steep - sine);
    return FUJII - gain / LAYER_PI;
}

vec3 layer_diffuse(vec3 wi, vec3 wo, vec3 colour, float roughness)
{
    float level = 1.0 / (1.0 + FUJII * roughness);
    float turn = dot(wi.xy, wo.xy);
    float leaning = turn > 0.0 ? turn / max(wi.z, wo.z) : turn;
    float lost = fujii_loss(wi.z) * fujii_loss(wo.z) * (level * roughness / (FUJII - FUJII_MEAN));
    float mean = level * (1.0 + FUJII_MEAN * roughness);
    vec3 again = colour * colour * mean / (1.0 - colour * (1.0 - mean));
    return (colour * (level * (1.0 + roughness * leaning)) + again * lost) / LAYER_PI;
}

// The lobe of white fuzz in 1/sr, and its albedo.
vec2 fuzz_lobe(vec3 wi, vec3 wo, float roughness)
{
    float x = wo.z;
    float y = clamp(roughness, 0.01, 1.0);
    float deviation = y * (0.0206607 + 1.58491 * y) / (0.0379424 + y * (1.32227 + y));
    float middle = y * (-0.193854 + y * (-1.14885 + y * (1.7932 - 0.95943 * y * y))) / (0.046391 + y);
    float offset = y * (0.000654023 + (-0.0207818 + 0.119681 * y) * y) / (1.26264 + y * (-1.92021 + y));
    float reflected = exp(-0.5 * layer_square((x - middle) / deviation)) / (deviation * sqrt(2.0 * LAYER_PI)) + offset;
    reflected = clamp(reflected, 0.0, 1.0);
    float scale = (2.58126 * x + 0.813703 * y) * y / (1.0 + 0.310327 * x * x + 2.60994 * x * y);
    float shear = sqrt(1.0 - min(x, 1.0)) * (y - 1.0) * y * y * y;
    shear /= 0.0000254053 + 1.71228 * x - 1.71506 * x * y + 1.34174 * y * y;
    float across = length(wo.xy);
    float along = across > 1e-6 ? dot(wi.xy, wo.xy) / across : wi.x;
    float aside2 = max(dot(wi.xy, wi.xy) - along * along, 0.0);
    float size2 = layer_square(scale * along + shear * wi.z) + scale * scale * aside2 + wi.z * wi.z;
    return vec2(reflected * layer_square(scale / size2) / LAYER_PI, reflected);
}

// The width of the base, which a rough coat widens.
float base_width(float roughness)
{
    float own = max(roughness, LAYER_SMOOTHEST);
    float coat2 = brdf_coat_roughness * brdf_coat_roughness;
    float widened = sqrt(sqrt(min(1.0, own * own * own * own + 2.0 * coat2 * coat2)));
    return layer_square(mix(own, widened, brdf_coat_weight));
}

// Widths along tangent and bitangent of an anisotropy.
vec2 two_widths(float width, float anisotropy)
{
    float across = 1.0 - anisotropy;
    float along = width * sqrt(2.0 / (1.0 + across * across));
    return vec2(min(along, 1.0), max(across * along, LAYER_SMOOTHEST * LAYER_SMOOTHEST));
}

vec3 base_layers(vec3 wi, vec3 wo, vec3 h, float facing, vec3 colour, float metalness, vec2 widths, float ior)
{
    float lobe = layer_ggx(wi, wo, h, widths);
    float mean = sqrt(widths.x * widths.y);
    vec3 value = vec3(0.0);
#if !defined(NO_METAL)
    if (metalness > 0.0) {
        vec3 f0 = brdf_base_weight * colour;
        vec3 mirror = fresnel_hoffman(facing, f0, brdf_specular_color);
#if !defined(NO_FILM)
        if (brdf_thin_film_weight > 0.0) {
            float index = brdf_thin_film_ior;
            float inner = sqrt(1.0 - (1.0 - facing * facing) / (index * index));
            vec3 root = sqrt(clamp(f0, 0.01, 0.99));
            vec3 turned = LAYER_PI * vec3(lessThan((1.0 + root) / (1.0 - root), vec3(index)));
            vec3 below = fresnel_hoffman(inner, f0, brdf_specular_color);
            mirror = mix(mirror, fresnel_airy(facing, below, below, turned, turned), brdf_thin_film_weight);
        }
#endif
        vec3 there = f0 + (1.0 - f0) * 0.46266436;
        vec3 average = max(schlick_mean(f0) - there * (1.0 - brdf_specular_color) * 0.14009057, 0.0); // 7/(6/7)^6/126
        value += metalness * brdf_specular_weight * (mirror * lobe + scatter_again(wi, wo, mean, average));
    }
#endif
#if !defined(NO_DIELECTRIC)
    if (metalness < 1.0) {
        float ratio = ior / brdf_coat_ior;
        float relative = mix(ior, max(ratio, 1.0 / ratio), brdf_coat_weight);
        float root = sqrt(min(brdf_specular_weight * f0_of_index(relative), 0.99999)) * sign(relative - 1.0);
        float index = (1.0 + root) / (1.0 - root);
        vec3 mirror = vec3(fresnel_dielectric(facing, index));
        vec3 average = vec3(fresnel_mean(index));
        vec3 reflected = share_of_dielectric(wo.z, mean, index);
#if !defined(NO_FILM)
        if (brdf_thin_film_weight > 0.0) {
            mirror = mix(mirror, film_on_dielectric(facing, index), brdf_thin_film_weight);
            vec3 first = film_on_dielectric(typical_cosine(wo.z, mean), index);
            vec3 own = schlick_mean(film_on_dielectric(1.0, index));
            vec3 coloured = reflected_share(wo.z, mean, first, own);
            average = mix(average, own, brdf_thin_film_weight);
            reflected = mix(reflected, coloured, brdf_thin_film_weight);
        }
#endif
        vec3 under = (1.0 - reflected) * layer_diffuse(wi, wo, colour, brdf_base_diffuse_roughness);
        vec3 again = scatter_again(wi, wo, mean, average);
        vec3 highlight = brdf_specular_color * (mirror * lobe + again);
        value += (1.0 - metalness) * (highlight + brdf_base_weight * under);
    }
#endif
    return value;
}

// A direction in a frame that is turned about the normal.
vec3 turn_frame(vec3 direction, float angle_deg)
{
    float c = cos(radians(angle_deg)), s = sin(radians(angle_deg));
    return vec3(c * direction.x + s * direction.y, c * direction.y - s * direction.x, direction.z);
}

// All layers over a base of this colour, metalness, widths and index; the coat has widths of its own, and both run along
// a direction at this angle.
vec3 reflect_layers(vec3 wi, vec3 wo, vec3 colour, float metalness, vec2 widths, float ior, vec2 coat_widths,
                    float angle_deg)
{
    vec3 both = wi + wo;
    float size = length(both);
    vec3 h = turn_frame(both, angle_deg) / size;
    wi = turn_frame(wi, angle_deg);
    wo = turn_frame(wo, angle_deg);
    float facing = min(0.5 * size, 1.0);
    vec3 value = base_layers(wi, wo, h, facing, colour, metalness, widths, ior);
#if !defined(NO_COAT)
    if (brdf_coat_weight > 0.0) {
        float mean = sqrt(coat_widths.x * coat_widths.y);
        float f0 = f0_of_index(brdf_coat_ior);
        vec3 through = 1.0 - brdf_coat_weight * share_of_dielectric(wo.z, mean, brdf_coat_ior);
        vec3 tint = mix(vec3(1.0), brdf_coat_color, brdf_coat_weight);
        float inside = 1.0 - (1.0 - f0) / (brdf_coat_ior * brdf_coat_ior);
        vec3 reflected = colour * (1.0 + metalness * (brdf_specular_weight - 1.0));
        vec3 darkened = mix(vec3(1.0), (1.0 - inside) / (1.0 - inside * reflected), brdf_coat_weight * brdf_coat_darkening);
        value *= through * tint * darkened;
        float highlight = fresnel_dielectric(facing, brdf_coat_ior) * layer_ggx(wi, wo, h, coat_widths);
        value += brdf_coat_weight * (highlight + scatter_again(wi, wo, mean, vec3(fresnel_mean(brdf_coat_ior))));
    }
#endif
#if !defined(NO_FUZZ)
    if (brdf_fuzz_weight > 0.0) {
        vec2 found = fuzz_lobe(wi, wo, brdf_fuzz_roughness);
        value = (1.0 - brdf_fuzz_weight * found.y) * value + brdf_fuzz_weight * brdf_fuzz_color * found.x;
    }
#endif
    return value;
}
