// Poulin-Fournier: parallel cylinders of radius 1 along x on a floor, with shadowing and masking; the same quadrature as
// engine/brdf/poulin_fournier.py, which derives it. Where a sliver of the floor is left between two shadows, its width
// is a difference of larger numbers, and float32 keeps it to about 1e-7 of the spacing.
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); out: 1/sr, no cosine, 0 below the horizon.

#include "brdf/power.glsl"

uniform vec3 brdf_kd;
uniform vec3 brdf_ks;
uniform float brdf_exponent;
uniform float brdf_spacing;
uniform float brdf_floor;

// Gauss-Legendre nodes within (0, 1) and their weights; the other half mirrors.
const float HIGHLIGHT_NODES[10] = float[10](
    0.0765265211, 0.2277858511, 0.3737060887, 0.5108670020, 0.6360536807,
    0.7463319065, 0.8391169718, 0.9122344283, 0.9639719273, 0.9931285992);
const float HIGHLIGHT_WEIGHTS[10] = float[10](
    0.1527533871, 0.1491729865, 0.1420961093, 0.1316886384, 0.1181945320,
    0.1019301198, 0.0832767416, 0.0626720483, 0.0406014298, 0.0176140071);
const float DIFFUSE_NODES[7] = float[7](
    0.1080549487, 0.3191123689, 0.5152486364, 0.6872929048, 0.8272013151,
    0.9284348837, 0.9862838087);
const float DIFFUSE_WEIGHTS[7] = float[7](
    0.2152638535, 0.2051984637, 0.1855383975, 0.1572031672, 0.1215185707,
    0.0801580872, 0.0351194603);

// (cos, sin) of the angle at which the neighbour's shadow begins, for a direction of elevation (cos, sin).
vec2 groove_shadow(vec2 elevation)
{
    float q = min(1.0, 0.5 * brdf_spacing * elevation.y);
    vec2 seen = vec2(1.0 - 2.0 * q, 2.0 * sqrt(q * (1.0 - q)));
    return vec2(dot(seen, elevation), seen.y * elevation.x - seen.x * elevation.y);
}

vec2 smaller_angle(vec2 a, vec2 b)
{
    return a.x >= b.x ? a : b;
}

// (n.wi) (n.wo) dphi at t = tan(phi / 2), phi the angle of the cylinder's normal
float groove_cosines(float t, vec2 i, vec2 o)
{
    float scale = 1.0 / (1.0 + t * t);
    vec2 normal = vec2(2.0 * t, 1.0 - t * t);
    return dot(normal, i) * dot(normal, o) * scale * scale * scale;
}

float groove_diffuse(float low, float high, vec2 i, vec2 o)
{
    float middle = 0.5 * (low + high), extent = 0.5 * (high - low);
    float total = 0.0;
    for (int k = 0; k < 7; ++k) {
        float reach = extent * DIFFUSE_NODES[k];
        total += DIFFUSE_WEIGHTS[k] * (groove_cosines(middle - reach, i, o) + groove_cosines(middle + reach, i, o));
    }
    return 2.0 * extent * total;
}

// (1 - deficit - rise sin^2)^exponent (c^2 - sin^2) dangle at t = tan(angle / 2), the angle from the bisector
float groove_gloss(float t, float c, float deficit, float rise)
{
    float scale = 1.0 / (1.0 + t * t);
    float sine2 = 4.0 * t * t * scale * scale;
    return power_of_one_minus(deficit + rise * sine2, brdf_exponent) * max(c * c - sine2, 0.0) * scale;
}

float groove_highlight(float low, float high, float c, float deficit, float rise)
{
    if (!(high > low))
        return 0.0;
    float middle = 0.5 * (low + high), extent = 0.5 * (high - low);
    float total = 0.0;
    for (int k = 0; k < 10; ++k) {
        float reach = extent * HIGHLIGHT_NODES[k];
        total += HIGHLIGHT_WEIGHTS[k]
            * (groove_gloss(middle - reach, c, deficit, rise) + groove_gloss(middle + reach, c, deficit, rise));
    }
    return 2.0 * extent * total;
}

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    float edge = sqrt((1.0 - brdf_floor) * (1.0 + brdf_floor));
    float length_i = length(wi.yz), length_o = length(wo.yz);
    bool right_i = wi.y >= 0.0, right_o = wo.y >= 0.0;
    vec2 i = vec2(abs(wi.y), wi.z) / length_i, o = vec2(abs(wo.y), wo.z) / length_o;

    // what both see of the cylinder: normal angles from -low to high
    vec2 shadow_i = groove_shadow(i), shadow_o = groove_shadow(o);
    vec2 end = vec2(brdf_floor, edge);
    vec2 high = smaller_angle(smaller_angle(end, right_i ? shadow_i : i), right_o ? shadow_o : o);
    vec2 low = smaller_angle(smaller_angle(end, right_i ? i : shadow_i), right_o ? o : shadow_o);

    // the bisector of the two directions across the cylinders, and the cosine c of half the angle between them
    vec2 middle = i + o;
    float size = length(middle);
    float c = right_i == right_o ? 0.5 * size : middle.y / size;
    vec2 bisector = right_i == right_o ? middle.yx / size : vec2(0.5 * size, (i.x * o.y - i.y * o.x) / size);
    bisector.y = right_i ? bisector.y : -bisector.y;
    float t_low = (-low.y * bisector.x - low.x * bisector.y) / (1.0 + low.x * bisector.x - low.y * bisector.y);
    float t_high = (high.y * bisector.x - high.x * bisector.y) / (1.0 + dot(high, bisector));

    // what both see of the floor
    float reach_i = i.x > brdf_floor ? (1.0 - brdf_floor * i.x) / i.y : edge;
    float reach_o = o.x > brdf_floor ? (1.0 - brdf_floor * o.x) / o.y : edge;
    float right = max(right_i ? reach_i : edge, right_o ? reach_o : edge);
    float left = max(right_i ? edge : reach_i, right_o ? edge : reach_o);
    float flat_part = max(0.0, brdf_spacing - (left + right)) / brdf_spacing;

    float both = length_i * length_o;
    float across = 1.0 / (brdf_spacing * wi.z * wo.z);
    float diffuse = flat_part
        + across * groove_diffuse(-low.y / (1.0 + low.x), high.y / (1.0 + high.x), wi.yz, wo.yz);
    float highlight = 0.0;
    float along = wi.x + wo.x;
    float deficit = 0.5 * (along * along + (length_i - length_o) * (length_i - length_o));
    if (deficit < 1.0) {
        float reach2 = min(1.0, (1.0 - exp(-20.0 / brdf_exponent)) * (1.0 - deficit) / (2.0 * both));
        float reach = sqrt(reach2) / (1.0 + sqrt(1.0 - reach2));
        highlight = across * both * groove_highlight(max(t_low, -reach), min(t_high, reach), c, deficit, 2.0 * both);
    }
    vec3 difference = wi * vec3(-1.0, -1.0, 1.0) - wo;
    highlight += flat_part * power_of_one_minus(0.5 * dot(difference, difference), brdf_exponent);
    return brdf_kd * (0.31830988618379067 * diffuse)
        + brdf_ks * ((brdf_exponent + 2.0) * 0.15915494309189535 * highlight);
}
