// Radiance from wavelet transport under its light: the sum over terms of view map times what the light has made of
// the term (Wang, Tran and Luebke 2004, Eq. 6).
// in: number of a vertex, unit direction to the eye in its frame (normal +z); out: linear radiance, signed. In `rows`
// are all terms of one vertex after the other, then one for each vertex of the ground. Where fragments look terms up,
// the sum at a vertex is only worked out where its first term is marked: beside others, no fragment asks for it.

#include "direction_map.glsl"

uniform sampler2DArray view_maps;

vec3 view_map(Taps taps, int k)
{
    vec3 value = vec3(0.0);
    for (int i = 0; i < 4; ++i)
        value += taps.weight[i] * texelFetch(view_maps, ivec3(taps.place[i], k), 0).rgb;
    return value;
}

#if defined(VERTEX)
uniform int term_count;
uniform int flat_row;
uniform float flat_factor;

vec3 term_of(int vertex, int k)
{
    return row(vertex * term_count + k);
}

vec3 flat_radiance(int number)
{
    return flat_factor * row(flat_row + number);
}

vec3 radiance_of(int vertex, vec3 wo)
{
#if defined(TERMS)
    if (!marked(vertex * term_count))
        return vec3(0.0);
#endif
    Taps taps = taps_of(wo);
    vec3 sum = vec3(0.0);
    for (int k = 0; k < term_count; ++k)
        sum += term_of(vertex, k) * view_map(taps, k);
    return sum;
}
#endif
