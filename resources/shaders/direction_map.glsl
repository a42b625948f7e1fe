// Where a direction lies in a square texture; the maps are described in engine/factor/hemisphere_map.py.
// in: unit direction, surface frame (normal +z), at or above the horizon; out: four texels and their weights, sum 1.

#include "brdf/angle.glsl"

// 0 orthographic, 1 polar, 2 parabolic; texels a side, which is one less than the rows of a polar map.
uniform int brdf_map;
uniform int brdf_size;

struct Taps {
    ivec2 place[4];
    vec4 weight;
};

bool inside_disk(ivec2 texel)
{
    ivec2 centre = 2 * texel + 1 - brdf_size;
    return centre.x * centre.x + centre.y * centre.y <= brdf_size * brdf_size;
}

// The four texels between which a direction lies, and their weights.
Taps taps_of(vec3 w)
{
    Taps taps;
    float size = float(brdf_size);
    vec2 part;
    if (brdf_map == 1) {
        float radius = length(w.xy);
        int quarters = 0;
        float rest = radius > 0.0 ? precise_quarter(abs(w.y), w.x, quarters) : 0.0;
        float turn = (0.25 * float(quarters) + rest / 6.28318531) * size;
        float column = (w.y < 0.0 ? size - turn : turn) - 0.5;
        float row = radius / sqrt(1.0 + w.z) * size;
        int left = int(floor(column));
        int low = row < 0.5 ? 0 : min(int(row + 0.5), brdf_size);
        part = vec2(column - float(left), row < 0.5 ? 2.0 * row : low < brdf_size ? row + 0.5 - float(low) : 0.0);
        int first = (left + brdf_size) % brdf_size;
        int second = (first + 1) % brdf_size;
        int high = min(low + 1, brdf_size);
        taps.place = ivec2[4](ivec2(first, low), ivec2(second, low), ivec2(first, high), ivec2(second, high));
    } else {
        vec2 disk = brdf_map == 2 ? w.xy / (1.0 + w.z) : w.xy;
        vec2 position = clamp(0.5 * (disk + 1.0) * size - 0.5, 0.0, size - 1.0);
        ivec2 low = min(ivec2(position), ivec2(max(brdf_size - 2, 0)));
        ivec2 high = min(low + 1, ivec2(brdf_size - 1));
        part = position - vec2(low);
        taps.place = ivec2[4](low, ivec2(high.x, low.y), ivec2(low.x, high.y), high);
    }
    taps.weight = vec4((1.0 - part.x) * (1.0 - part.y), part.x * (1.0 - part.y), (1.0 - part.x) * part.y, part.x * part.y);
    if (brdf_map != 1) {
        for (int k = 0; k < 4; ++k)
            if (!inside_disk(taps.place[k]))
                taps.weight[k] = 0.0;
        float total = dot(taps.weight, vec4(1.0));
        if (total <= 0.0) {
            ivec2 low = taps.place[0];
            int inner = (2 * low.y + 1 < brdf_size ? 2 : 0) + (2 * low.x + 1 < brdf_size ? 1 : 0);
            taps.weight[inner] = total = 1.0;
        }
        taps.weight /= total;
    }
    return taps;
}
