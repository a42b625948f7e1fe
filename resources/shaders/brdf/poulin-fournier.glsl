// Poulin-Fournier: parallel cylinders of radius 1 along x on a floor, with shadowing and masking; the same quadrature as
// engine/brdf/models/poulin_fournier.py, which derives it. Where a sliver of the floor is left between two shadows, its width
// is a difference of larger numbers, and float32 keeps it to about 1e-7 of the spacing.
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); out: 1/sr, no cosine, 0 below the horizon.

#include "brdf/power.glsl"

uniform vec3 brdf_kd;
uniform vec3 brdf_ks;
uniform float brdf_exponent;
uniform float brdf_spacing;
uniform float brdf_floor;

// Gauss-Legendre nodes within (0, 1) and their weights; the other half mirrors.
const float HIGHLIGHT_NODES[9] = float[9](
    0.0847750130, 0.2518862257, 0.4117511615,
    0.5597708311, 0.6916870431, 0.8037049590,
    0.8926024665, 0.9558239496, 0.9915651684);
const float HIGHLIGHT_WEIGHTS[9] = float[9](
    0.1691423830, 0.1642764837, 0.1546846751,
    0.1406429147, 0.1225552067, 0.1009420441,
    0.0764257303, 0.0497145489, 0.0216160135);
const float DIFFUSE_NODES[6] = float[6](
    0.1252334085, 0.3678314990, 0.5873179543, 0.7699026742,
    0.9041172564, 0.9815606342);
const float DIFFUSE_WEIGHTS[6] = float[6](
    0.2491470458, 0.2334925365, 0.2031674267, 0.1600783285,
    0.1069393260, 0.0471753364);

// (cos, sin) of the angle at which the neighbour's shadow begins, for a direction of elevation (cos, sin).
vec2 groove_shadow(vec2 elevation)
{
    float q = min(1.0, 0.5 * brdf_spacing * elevation.y);
    vec2 seen = vec2(1.0 - 2.0 * q, 2.0 * sqrt(q * (1.0 - q)));
    return vec2(dot(seen, elevation), seen.y * elevation.x - seen.x * elevation.y);
}

// by the tangents of their halves, because the cosines of small angles are equal
vec2 smaller_angle(vec2 a, vec2 b)
{
    return a.y * (1.0 + b.x) <= b.y * (1.0 + a.x) ? a : b;
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
    for (int k = 0; k < 6; ++k) {
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
    for (int k = 0; k < 9; ++k) {
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
        float reach2 = min(1.0, (1.0 - exp(-18.0 / brdf_exponent)) * (1.0 - deficit) / (2.0 * both));
        float reach = sqrt(reach2) / (1.0 + sqrt(1.0 - reach2));
        highlight = across * both * groove_highlight(max(t_low, -reach), min(t_high, reach), c, deficit, 2.0 * both);
    }
    vec3 difference = wi * vec3(-1.0, -1.0, 1.0) - wo;
    highlight += flat_part * power_of_one_minus(0.5 * dot(difference, difference), brdf_exponent);
    return brdf_kd * (0.31830988618379067 * diffuse)
        + brdf_ks * ((brdf_exponent + 2.0) * 0.15915494309189535 * highlight);
}
