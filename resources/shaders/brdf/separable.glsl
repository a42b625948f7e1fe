// Sums of products of two textures, as engine/factor/separable_factors.py looks them up.
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); out: 1/sr, no cosine, 0 below the horizon.
// A layer per term; the map of the textures and what lies in them are described in engine/factor/maps.py.

#include "brdf/angle.glsl"

uniform sampler2DArray brdf_first;
uniform sampler2DArray brdf_second;
uniform int brdf_terms;

// 0 orthographic, 1 polar, 2 parabolic; texels a side, which is one less than the rows of a polar map.
uniform int brdf_map;
uniform int brdf_size;

// 1 where the textures belong to half and difference vector, 0 to viewer and light.
uniform int brdf_of_half;

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

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    vec3 one = wo;
    vec3 other = wi;
    if (brdf_of_half == 1) {
        vec3 both = wi + wo;
        vec3 between = wi - wo;
        float size = length(both);
        one = size > 1e-11 ? both / size : vec3(0.0, 0.0, 1.0);
        float across = length(one.xy);
        vec2 turn = across > 0.0 ? one.xy / across : vec2(1.0, 0.0);
        other = 0.5 * vec3(one.z * dot(turn, between.xy) - across * between.z,
                           turn.x * between.y - turn.y * between.x, size);
    }
    Taps first = taps_of(one);
    Taps second = taps_of(other);
    vec3 sum = vec3(0.0);
    for (int term = 0; term < brdf_terms; ++term) {
        vec3 a = vec3(0.0);
        vec3 b = vec3(0.0);
        for (int k = 0; k < 4; ++k) {
            a += first.weight[k] * texelFetch(brdf_first, ivec3(first.place[k], term), 0).rgb;
            b += second.weight[k] * texelFetch(brdf_second, ivec3(second.place[k], term), 0).rgb;
        }
        sum += a * b;
    }
    return max(sum, 0.0);
}
