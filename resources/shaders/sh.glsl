// Radiance from transported light as spherical harmonics: the sum of the coefficients of the reflectance towards the
// eye times those of the light (Kautz, Sloan and Snyder 2002, Eq. 1).
// in: number of a vertex, unit direction to the eye in its frame (normal +z); out: linear radiance, signed. In `rows`
// are the ORDER² coefficients of one vertex after the other, then the radiance of each flat vertex.
// Tables are those of engine.transport.sh.brdf_table: a line of coefficients for each row over tan(θ/2), at azimuth 0, of
// which pairs of m turn with the azimuth, and a layer for each table; or, with PARABOLIC, maps of the hemisphere, in
// whose texels the coefficients lie beside each other.
// Where parameters vary (VARIED, 1 or 2 of them) there are several tables, a grid of `steps`, in which each vertex has
// its place in `rows` after all radiance (engine.transport.sh.brdf_table_varying).

const int COUNT = ORDER * ORDER;

uniform int flat_row;

vec3 flat_radiance(int number)
{
    return row(flat_row + number);
}

#if defined(VARIED)
const int TABLES = 2 * VARIED;

uniform ivec2 steps;
uniform int place_row;

int table_at[TABLES];
float table_share[TABLES];

// The tables between which a vertex lies, and their shares.
void find_tables(int vertex)
{
    vec2 place = row(place_row + vertex).xy;
    ivec2 low = clamp(ivec2(place), ivec2(0), max(steps - 2, 0));
    ivec2 high = min(low + 1, steps - 1);
    vec2 share = place - vec2(low);
    for (int k = 0; k < TABLES; ++k) {
        bool first = VARIED == 1 ? k == 1 : k >= 2;
        bool second = VARIED == 2 && k % 2 == 1;
        table_at[k] = (first ? high.x : low.x) * steps.y + (second ? high.y : low.y);
        table_share[k] = (first ? share.x : 1.0 - share.x) * (second ? share.y : 1.0 - share.y);
    }
}
#else
const int TABLES = 1;
const int table_at[1] = int[1](0);
const float table_share[1] = float[1](1.0);

void find_tables(int vertex) {}
#endif

#if defined(PARABOLIC)
#include "direction_map.glsl"

// Coefficients of a texel beside each other, and layers of a table (engine.gl.sh).
const int BESIDE = 32;
const int LAYERS = (COUNT + BESIDE - 1) / BESIDE;

uniform sampler2DArray table_map;

vec3 radiance_of(int vertex, vec3 wo)
{
    find_tables(vertex);
    Taps taps = taps_of(wo);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < COUNT; ++i) {
        vec3 coefficient = vec3(0.0);
        for (int t = 0; t < TABLES; ++t)
            for (int k = 0; k < 4; ++k) {
                ivec2 texel = ivec2(taps.place[k].x * BESIDE + i % BESIDE, taps.place[k].y);
                int layer = table_at[t] * LAYERS + i / BESIDE;
                coefficient += table_share[t] * taps.weight[k] * texelFetch(table_map, ivec3(texel, layer), 0).rgb;
            }
        sum += coefficient * row(vertex * COUNT + i);
    }
    return sum;
}

#else
#if defined(VARIED)
uniform sampler2DArray table_rows;

vec3 entry(int column, int line, int t)
{
    return texelFetch(table_rows, ivec3(column, line, table_at[t]), 0).rgb;
}
#else
uniform sampler2D table_rows;

vec3 entry(int column, int line, int t)
{
    return texelFetch(table_rows, ivec2(column, line), 0).rgb;
}
#endif

vec3 radiance_of(int vertex, vec3 wo)
{
    find_tables(vertex);
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
            vec3 coefficient = vec3(0.0);
            for (int t = 0; t < TABLES; ++t) {
                vec3 between = mix(entry(at + m, low, t), entry(at + m, low + 1, t), share);
                coefficient += table_share[t] * between;
            }
            vec3 light = wave.x * row(first + at + m);
            if (m > 0)
                light += wave.y * row(first + at - m);
            sum += coefficient * light;
        }
        wave = vec2(wave.x * turn.x - wave.y * turn.y, wave.x * turn.y + wave.y * turn.x);
    }
    return sum;
}
#endif
