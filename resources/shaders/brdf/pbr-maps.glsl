// PBR maps: the BRDF of metallic-roughness.glsl at each texel, with the f0 of dielectrics beside it, and the normal that
// bends the frame (engine.render.pbr), averaged over the normals that a pixel covers (engine.surface.normal_spread,
// which has the formulas). begin_texels and fetch_texel come before product_of_texel.
// in: the layers base colour; roughness, metallic and f0; mean normal; means of its products xx, yy, xy; covariances of
// base colour and metallic; variance and third moment of the logarithm of roughness, and variance of metallic.
// out of brdf: 1/sr, no cosine, 0 below the horizon; of product_of_texel: 1/sr with the cosine.

#include "brdf/highlight.glsl"
#include "brdf/microfacet.glsl"
#include "brdf/multiple_scattering.glsl"
#include "texture_axes.glsl"

uniform sampler2DArray pbr_maps;
uniform float pbr_smoothest;

vec3 base_here;
vec3 gloss_here;
vec3 spread_here;
float length_here;
#if defined(PBR_COAT)
vec3 upright_here;
#endif
vec3 joint_here;
vec3 apart_here;

const float ALIKE_GLOSS = 1e-4;
const float MAX_SKEW = 4.0;
const float ALIKE = 1e-6;
const float MUCH = 0.1;
const float MIN_COSINE = 0.01;
const float MIN_RISE = 0.2;

// The covariance xx, yy, xy of slopes about the mean normal, from the means of its components and of their products.
vec3 spread_slopes(vec3 mean, vec3 square, float size)
{
    vec3 n = mean / max(size, 1e-12);
    float root = sqrt(max(1.0 - n.x * n.x, 1e-6));
    float rise = max(n.z, MIN_RISE);
    float three = n.x * n.y / (rise * root);
    float four = root / rise;
    vec3 about = square - vec3(mean.x * mean.x, mean.y * mean.y, mean.x * mean.y);
    float along = three * three * about.x + 2.0 * three * four * about.z + four * four * about.y;
    vec3 covariance = vec3(max(about.x / (root * root), 0.0), max(along, 0.0), (three * about.x + four * about.z) / root);
    float trace = min(covariance.x + covariance.y, 1.0);
    return covariance / max(1.0 - trace * (2.05 + trace * (1.15 * trace - 1.9)), 0.15);
}

mat2x3 axes_here;
float detail_here;

// What a pixel covers, at these coordinates (v down) on a surface with the normal n.
void begin_texels(vec3 place, vec2 uv, vec3 n)
{
    vec2 size = vec2(textureSize(pbr_maps, 0).xy);
    vec2 across = dFdx(uv) * size;
    vec2 down = dFdy(uv) * size;
    detail_here = 0.5 * log2(max(max(dot(across, across), dot(down, down)), 1e-30));
    axes_here = texture_axes(place, uv, n);
}

// True where normals within the pixel differ by more than the highlight is wide: it is looked up in four parts then.
bool differ_within()
{
    float roughness = max(gloss_here.x, pbr_smoothest);
    return spread_here.x + spread_here.y > MUCH * roughness * roughness * roughness * roughness;
}

// The mean normal and the means of its products.
void normals_at(vec2 uv, float detail, out vec3 tilt, out vec3 square)
{
    tilt = textureLod(pbr_maps, vec3(uv, 2.0), detail).xyz;
    square = textureLod(pbr_maps, vec3(uv, 3.0), detail).xyz;
    if (detail < 1.0) { // between texels of full size the surface is smooth, and normals of unit length
        vec3 near = textureLod(pbr_maps, vec3(uv, 2.0), 0.0).xyz;
        vec3 unit = safe_normalize(near, vec3(0.0, 0.0, 1.0));
        float share = 1.0 - max(detail, 0.0);
        vec3 products = vec3(unit.x * unit.x, unit.y * unit.y, unit.x * unit.y);
        tilt += share * (unit - near);
        square += share * (products - textureLod(pbr_maps, vec3(uv, 3.0), 0.0).xyz);
    }
}

#ifdef HEX_TILING
#include "hex_tiling.glsl"
#endif

// The frame about the normal of the map at these coordinates, from that of the surface, so many levels finer.
mat3 fetch_texel(vec2 uv, float finer, mat3 frame, vec3 wo)
{
    float detail = detail_here - finer;
    vec3 tilt, square;
    joint_here = vec3(0.0);
    apart_here = vec3(0.0);
#ifdef HEX_TILING
    blend_cells(uv, detail, tilt, square);
#else
    if (detail > 0.0) {
        joint_here = textureLod(pbr_maps, vec3(uv, 4.0), detail).rgb;
        apart_here = textureLod(pbr_maps, vec3(uv, 5.0), detail).rgb;
    }
    base_here = textureLod(pbr_maps, vec3(uv, 0.0), detail).rgb;
    gloss_here = textureLod(pbr_maps, vec3(uv, 1.0), detail).rgb;
    normals_at(uv, detail, tilt, square);
#endif
    length_here = length(tilt);
    spread_here = spread_slopes(tilt, square, length_here);
    vec3 n = safe_normalize(axes_here * tilt.xy + tilt.z * frame[2], frame[2]);
    float facing = dot(n, wo);
    mat3 bent = frame_along(facing < 0.01 ? safe_normalize(n + (0.01 - facing) * wo, wo) : n, axes_here[0]);
    bent[1] *= dot(cross(axes_here[0], axes_here[1]), frame[2]) < 0.0 ? -1.0 : 1.0;
#if defined(PBR_COAT)
    upright_here = frame[2] * bent;
#endif
    return bent;
}

#if defined(PBR_LAYERS)
#include "brdf/openpbr_layers.glsl"

uniform float brdf_specular_roughness_anisotropy;
uniform float brdf_coat_roughness_anisotropy;
uniform float brdf_rotation_deg;

// The layers over the texel (engine.surface.layered), with this sum of the variances of slopes.
vec3 layered(vec3 wi, vec3 wo, float variance)
{
    float root = sqrt(min(gloss_here.z, 0.9));
    vec2 widths = two_widths(base_width(gloss_here.x), brdf_specular_roughness_anisotropy);
    float coat = layer_square(max(brdf_coat_roughness, LAYER_SMOOTHEST));
    vec2 coat_widths = two_widths(coat, brdf_coat_roughness_anisotropy);
    widths = min(sqrt(widths * widths + variance), 1.0);
    coat_widths = min(sqrt(coat_widths * coat_widths + variance), 1.0);
    float ior = (1.0 + root) / (1.0 - root);
    return reflect_layers(wi, wo, base_here, gloss_here.y, widths, ior, coat_widths, brdf_rotation_deg);
}
#endif

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
#if defined(PBR_LAYERS)
    return layered(wi, wo, 0.0);
#endif
    float roughness = max(gloss_here.x, pbr_smoothest);
    float metallic = gloss_here.y;
    vec2 alpha = vec2(roughness * roughness);
    vec3 both = wi + wo;
    float size = length(both);
    float shadowing = (wi.z + ggx_slope_length(wi, alpha)) * (wo.z + ggx_slope_length(wo, alpha));
    vec3 f0 = gloss_here.z * (1.0 - metallic) + base_here * metallic;
    vec3 fresnel = f0 + (1.0 - f0) * schlick(wi, wo, size);
    vec3 diffuse = (1.0 - fresnel) * ((1.0 - metallic) * 0.31830988618379067 * base_here);
    vec3 value = diffuse + fresnel * (ggx_distribution(both / size, alpha) / shadowing);
#if !defined(SINGLE_SCATTERING)
    value += multiple_scattering(wi.z, wo.z, alpha.x, f0);
#endif
    return value;
}

// 1 - x e^x E1(x) for x > 0 (Abramowitz 1964, 5.1.53 and 5.1.56).
float lowering(float x)
{
    if (x > 1.0)
        return (((0.9999936053 * x + 7.5739391756) * x + 12.4648921902) * x + 3.6907231885) /
               ((((x + 9.5733223454) * x + 25.6329561486) * x + 21.0996530827) * x + 3.9584969228);
    float series = ((((0.00107857 * x - 0.00976004) * x + 0.05519968) * x - 0.24991055) * x + 0.99999193) * x;
    return 1.0 - x * exp(x) * (series - 0.57721566 - log(x));
}

// D G / (4 n.v), averaged over normals.
float spread_lobe(vec3 wi, vec3 wo, vec3 h)
{
    if (h.z <= MIN_COSINE)
        return 0.0;
    float roughness = max(gloss_here.x, pbr_smoothest);
    float alpha2 = roughness * roughness * roughness * roughness;
    float own = 0.5 * alpha2;
    mat2 slopes = mat2(spread_here.x, spread_here.z, spread_here.z, spread_here.y);
    vec2 s = h.xy / h.z;
    mat2 other = mat2(own + slopes[1][1], -slopes[0][1], -slopes[0][1], own + slopes[0][0]);
    vec2 solved = other * s / max(other[0][0] * other[1][1] - other[0][1] * other[0][1], 1e-24);
    vec3 reflecting = normalize(vec3(slopes * solved, 1.0));
    float steep = reflecting.z * reflecting.z * reflecting.z;
    float wider2 = alpha2 / steep;
    float a = wider2 + 2.0 * slopes[0][0], b = wider2 + 2.0 * slopes[1][1], c = 2.0 * slopes[0][1];
    float width = sqrt(max(a * b - c * c, 1e-24));
    float quadratic = (b * s.x * s.x - 2.0 * c * s.x * s.y + a * s.y * s.y) / (width * width);
    float more = max(width / wider2 - 1.0, 1e-6);
    float peak = (1.0 + 1.0 / more) * lowering(1.0 / more);
    float exponent = 2.0 + more * (0.88 + 1.32 / (1.0 + pow(more / 1.455, 0.618)));
    float trace = 0.5 * (slopes[0][0] + slopes[1][1]);
    float left = trace * own / (own + trace) * (1.0 + 0.35 * sqrt(trace / own));
    float facing = max(dot(reflecting, h), MIN_COSINE);
    float distribution = peak / (3.14159265358979 * width) * pow(1.0 + quadratic * peak / (exponent - 1.0), -exponent);
    distribution *= (1.0 + 4.0 * left + 8.0 * left * left) / (facing * facing * facing * facing * steep);
    float light = max(dot(reflecting, wi), 0.0);
    float viewer = max(dot(reflecting, wo), MIN_COSINE);
    float shadowing = (light + sqrt(alpha2 + (1.0 - alpha2) * light * light)) *
                      (viewer + sqrt(alpha2 + (1.0 - alpha2) * viewer * viewer));
    return distribution * light / shadowing;
}

// The reflectance times the cosine, but for sheen and a clear coat.
vec3 product_of_base(vec3 wi, vec3 wo)
{
    float trace = spread_here.x + spread_here.y;
    if (trace <= ALIKE)
        return wi.z > 0.0 ? brdf(wi, wo) * wi.z : vec3(0.0);
#if defined(PBR_LAYERS)
    return wi.z > 0.0 && wo.z > 0.0 ? layered(wi, wo, trace) * wi.z : vec3(0.0);
#endif
    float metallic = gloss_here.y;
    vec3 both = wi + wo;
    float size = length(both);
    vec3 f0 = gloss_here.z * (1.0 - metallic) + base_here * metallic;
    vec3 fresnel = f0 + (1.0 - f0) * schlick(wi, wo, size);
    float cosine = max(wi.z, 0.0) * length_here;
    vec3 diffuse = (1.0 - fresnel) * ((1.0 - metallic) * 0.31830988618379067 * cosine * base_here);
    vec3 value = diffuse + fresnel * spread_lobe(wi, wo, both / max(size, 1e-12));
#if !defined(SINGLE_SCATTERING)
    float roughness = max(gloss_here.x, pbr_smoothest);
    value += cosine * multiple_scattering(max(wi.z, 0.0), max(wo.z, 0.0), roughness * roughness, f0);
#endif
    return value;
}

#if defined(PBR_SHEEN)
#include "brdf/sheen.glsl"

// The product of the base under sheen, about the mean normal (engine.surface.layered, lay_sheen).
vec3 lay_sheen(vec3 value, vec3 wi, vec3 wo)
{
    vec3 both = wi + wo;
    vec2 fibres = sheen(wi.z, wo.z, dot(both.xy, both.xy) / max(dot(both, both), 1e-12));
    float share = spread_here.x + spread_here.y <= ALIKE ? 1.0 : length_here;
    float cosine = wi.z > 0.0 && wo.z > 0.0 ? share * wi.z : 0.0;
    return fibres.y * value + cosine * fibres.x * brdf_sheen_color;
}
#endif

#if defined(PBR_COAT)
#include "brdf/clear_coat.glsl"

// The product of the base under a clear coat, whose normal is that of the surface (engine.surface.layered, cover).
vec3 cover(vec3 value, vec3 wi, vec3 wo)
{
    float light = dot(wi, upright_here), viewer = dot(wo, upright_here), coat = 0.0;
    if (light > 0.0 && viewer > 0.0) {
        vec3 both = wi + wo, aside = cross(upright_here, both);
        coat = light * coat_lobe(light, viewer, dot(aside, aside) / dot(both, both), 1.0);
    }
    return mix(value, vec3(coat), coat_share(viewer));
}
#endif

// The reflectance times the cosine; wi may lie below the horizon of the mean normal.
vec3 product_of_texel(vec3 wi, vec3 wo)
{
    vec3 value = product_of_base(wi, wo);
#if defined(PBR_SHEEN)
    value = lay_sheen(value, wi, wo);
#endif
#if defined(PBR_COAT)
    value = cover(value, wi, wo);
#endif
    return value;
}

// What a point shows is a sum of texels of one roughness (engine.render.pbr, Texels.parts): metal, what is none, and a
// mixture, in two roughnesses each. How many, and number `part` in place of the point, with its weight.
int parts_of_texel()
{
    return apart_here == vec3(0.0) ? 1 : 6;
}

float choose_part(int part, vec3 base, vec3 gloss)
{
    float most = gloss.y * (1.0 - gloss.y);
    float share = apart_here.z > ALIKE ? clamp(apart_here.z / max(most, 1e-9), 0.0, 1.0) : 0.0;
#if defined(PBR_LAYERS)
    share = 0.0;
#endif
    base_here = base;
    gloss_here = gloss;
    float weight = 1.0 - share;
    if (part / 2 > 0) {
        bool is_metal = part / 2 == 1;
        weight = share * (is_metal ? gloss.y : 1.0 - gloss.y);
        base_here = clamp(base + (is_metal ? 1.0 : -1.0) * joint_here / max(weight, 1e-6), 0.0, 1.0);
        gloss_here.y = is_metal ? 1.0 : 0.0;
    }
    if (apart_here.x <= ALIKE_GLOSS)
        return part % 2 == 0 ? weight : 0.0;
    float deviation = sqrt(apart_here.x);
    float skew = clamp(0.5 * apart_here.y / (deviation * apart_here.x), -MAX_SKEW, MAX_SKEW);
    float root = sqrt(1.0 + skew * skew);
    float rougher = 0.5 * (1.0 - skew / root);
    vec2 values = exp(deviation * (skew + vec2(root, -root)));
    float scale = max(gloss.x, pbr_smoothest) / (rougher * values.x + (1.0 - rougher) * values.y);
    gloss_here.x = min(scale * (part % 2 == 0 ? values.x : values.y), 1.0);
    return weight * (part % 2 == 0 ? rougher : 1.0 - rougher);
}
