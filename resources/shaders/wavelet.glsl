// Radiance from wavelet transport under its light: the sum over terms of view map times what the light has made of
// the term (Wang, Tran and Luebke 2004, Eq. 6).
// in: number of a vertex, unit direction to the eye in its frame (normal +z); out: linear radiance, signed. In `rows`
// are all terms of one vertex after the other, then one for each vertex of the ground. Where fragments look terms up,
// the sum at a vertex is only worked out where its first term is marked: beside others, no fragment asks for it.
// With KINDS, the kinds of BRDFs of the vertices follow, and the maps of each kind begin with a layer of their own.

#include "direction_map.glsl"

// PLANES numbers for each term, 1 where the maps have no colour and else 3, all beside each other, four in a texel.
uniform sampler2DArray view_maps;

vec4 numbers(Taps taps, int layer)
{
    vec4 value = vec4(0.0);
    for (int i = 0; i < 4; ++i)
        value += taps.weight[i] * texelFetch(view_maps, ivec3(taps.place[i], layer), 0);
    return value;
}

#if defined(TERMS)
vec3 mixed(vec3 wo, vec3 terms[TERMS], int first)
{
    Taps taps = taps_of(wo);
    vec4 found[(TERMS * PLANES + 3) / 4];
    for (int layer = 0; layer < found.length(); ++layer)
        found[layer] = numbers(taps, first + layer);
    vec3 sum = vec3(0.0);
    for (int k = 0; k < TERMS; ++k)
#if PLANES == 1
        sum += terms[k] * found[k / 4][k % 4];
#else
        for (int c = 0; c < 3; ++c)
            sum[c] += terms[k][c] * found[(3 * k + c) / 4][(3 * k + c) % 4];
#endif
    return sum;
}
#endif

#if defined(VERTEX)
uniform int term_count;
uniform int flat_row;
uniform float flat_factor;

#if defined(KINDS)
uniform int kind_row;

// The first layer of the maps of a vertex of the model.
int first_layer(int vertex)
{
    return int(row(kind_row + vertex).r + 0.5) * ((term_count * PLANES + 3) / 4);
}
#else
int first_layer(int vertex)
{
    return 0;
}
#endif

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
    vec4 four;
    int first = first_layer(vertex);
    for (int number = 0; number < term_count * PLANES; ++number) {
        if (number % 4 == 0)
            four = numbers(taps, first + number / 4);
        vec3 term = term_of(vertex, number / PLANES) * four[number % 4];
#if PLANES == 1
        sum += term;
#else
        sum[number % 3] += term[number % 3];
#endif
    }
    return sum;
}
#endif
