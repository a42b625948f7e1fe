// Isotropic table in half and difference angles: linear interpolation, as engine/brdf/table_kernel.py does it.
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); out: 1/sr, no cosine, 0 below the horizon.
// brdf_table has columns phi_d, rows theta_d and layers theta_h; row and layer 0 are the means at angle 0.

#include "brdf/angle.glsl"

uniform sampler2DArray brdf_table;

// The range of phi_d: pi, and exchanged directions are one entry; or 2 pi, and they are two.
uniform float brdf_turn;

// Lower node and weight of the upper one, for nodes at 0, 1/2, 3/2 ... bins - 1/2; constant beyond the last.
int table_place(float position, int bins, out float weight)
{
    if (position < 0.5) {
        weight = 2.0 * position;
        return 0;
    }
    int low = min(int(position + 0.5), bins - 1);
    weight = min(position + 0.5 - float(low), 1.0);
    return low;
}

// The same for bins - position, which is known better near the last node, where reflectance changes most.
int table_place_from_end(float position, int bins, out float weight)
{
    int low = min(bins - int(ceil(position - 0.5)), bins - 1);
    weight = min(float(bins - low) + 0.5 - position, 1.0);
    return low;
}

vec3 table_row(int first, int second, float weight, int row, int layer)
{
    return mix(texelFetch(brdf_table, ivec3(first, row, layer), 0).rgb,
               texelFetch(brdf_table, ivec3(second, row, layer), 0).rgb, weight);
}

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    vec3 both = wi + wo;
    vec3 between = wi - wo;
    float size = length(both);
    if (size <= 1e-11)
        both = vec3(0.0, 0.0, size);
    float across = length(both.xy);
    vec2 turn = across > 0.0 ? both.xy / across : vec2(1.0, 0.0);
    float x = both.z * dot(turn, between.xy) - across * between.z;
    float y = size * (turn.x * between.y - turn.y * between.x);
    bool other = y < 0.0 || (y == 0.0 && x < 0.0);
    int quarters;
    float beyond = other ? precise_quarter(-y, -x, quarters) : precise_quarter(y, x, quarters);
    if (other && brdf_turn > 4.0)
        quarters += 2;
    ivec3 bins = textureSize(brdf_table, 0) - ivec3(0, 1, 1);
    float weight_h, weight_d;
    int layer = table_place(sqrt(precise_angle(across, both.z) * 0.63661977) * float(bins.z), bins.z, weight_h);
    float apart = length(between);
    int row = apart < size ? table_place(precise_angle(apart, size) * 0.63661977 * float(bins.y), bins.y, weight_d)
        : table_place_from_end(precise_angle(size, apart) * 0.63661977 * float(bins.y), bins.y, weight_d);
    // whole columns apart from the rest, which is small and so keeps its digits
    float whole = float(quarters * bins.x) * (brdf_turn > 4.0 ? 0.25 : 0.5);
    float column = beyond / brdf_turn * float(bins.x) + (whole - floor(whole)) - 0.5;
    float low = floor(column);
    int first = (int(whole) + int(low) + bins.x) % bins.x;
    int second = (first + 1) % bins.x;
    float weight_p = column - low;
    vec3 lower = mix(table_row(first, second, weight_p, row, layer),
                     table_row(first, second, weight_p, row + 1, layer), weight_d);
    vec3 upper = mix(table_row(first, second, weight_p, row, layer + 1),
                     table_row(first, second, weight_p, row + 1, layer + 1), weight_d);
    return mix(lower, upper, weight_h);
}
