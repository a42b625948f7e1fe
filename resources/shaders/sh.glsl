// Radiance from transported light as spherical harmonics: the sum of the coefficients of the reflectance towards the
// eye times those of the light (Kautz, Sloan and Snyder 2002, Eq. 1).
// in: number of a vertex, unit direction to the eye in its frame (normal +z); out: linear radiance, signed. In `rows`
// are the ORDER² coefficients of one vertex after the other, then the radiance of each flat vertex.
// Tables are those of engine.transport.sh_table: a line of coefficients for each row over tan(θ/2), at azimuth 0, of
// which pairs of m turn with the azimuth; or, with PARABOLIC, a layer for each coefficient.

const int COUNT = ORDER * ORDER;

uniform int flat_row;

vec3 flat_radiance(int number)
{
    return row(flat_row + number);
}

#if defined(PARABOLIC)
#include "direction_map.glsl"

uniform sampler2DArray table_map;

vec3 radiance_of(int vertex, vec3 wo)
{
    Taps taps = taps_of(wo);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < COUNT; ++i) {
        vec3 coefficient = vec3(0.0);
        for (int k = 0; k < 4; ++k)
            coefficient += taps.weight[k] * texelFetch(table_map, ivec3(taps.place[k], i), 0).rgb;
        sum += coefficient * row(vertex * COUNT + i);
    }
    return sum;
}

#else
uniform sampler2D table_rows;

vec3 radiance_of(int vertex, vec3 wo)
{
    float across = length(wo.xy);
    int last = textureSize(table_rows, 0).y - 1;
    float place = min(across / (1.0 + wo.z), 1.0) * float(last);
    int low = min(int(place), last - 1);
    float share = place - float(low);
    vec2 turn = across > 0.0 ? wo.xy / across : vec2(1.0, 0.0);
    vec2 wave = vec2(1.0, 0.0);
    int first = vertex * COUNT;
    vec3 sum = vec3(0.0);
    for (int m = 0; m < ORDER; ++m) {
        for (int degree = m; degree < ORDER; ++degree) {
            int at = degree * (degree + 1);
            vec3 below = texelFetch(table_rows, ivec2(at + m, low), 0).rgb;
            vec3 above = texelFetch(table_rows, ivec2(at + m, low + 1), 0).rgb;
            vec3 light = wave.x * row(first + at + m);
            if (m > 0)
                light += wave.y * row(first + at - m);
            sum += mix(below, above, share) * light;
        }
        wave = vec2(wave.x * turn.x - wave.y * turn.y, wave.x * turn.y + wave.y * turn.x);
    }
    return sum;
}
#endif
