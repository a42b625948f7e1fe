// Sums over lights of S(r_j) E_j, with the look-up inside the sum.
// in: for each light the share r_j / r_max and its weight, linear RGB; out: linear radiance.
// S is linear between two slices, so the weights are summed for each slice and each slice is fetched once, however
// many lights there are. The compressed pair is fetched once and evaluated for each light. With ONE_LOOKUP, add_light
// is called at most once.
// Planes are fetched once and summed for each light, of which light_turn is the azimuth over a whole turn.
// The layout is: begin_light_sum, add_light for each light, light_sum.

#include "shading_map.glsl"

#if defined(SOURCE_PLANES)
#include "directional.glsl"
#include "cosine_table.glsl"

float light_turn;
vec3 plane_sum;

void begin_light_sum(vec2 uv)
{
#if defined(HEX_TILING)
    begin_cells(uv, textureSize(planes, 0).xy);
#endif
    fetch_planes(uv);
    light_turn = 0.0;
    plane_sum = vec3(0.0);
}

void add_light(float share, vec3 weight)
{
#if defined(LOOKUP_ANGLE)
    plane_sum += weight * directional_map(share, light_turn);
#else
    plane_sum += weight * directional_map(effective_cosine(share, light_turn), light_turn);
#endif
}

vec3 light_sum(vec2 uv)
{
    return plane_sum;
}

#elif defined(ONE_LOOKUP) && !defined(SOURCE_NONE)
float only_share;
vec3 only_weight;

void begin_light_sum(vec2 uv)
{
#if defined(HEX_TILING) && defined(SOURCE_SLICES)
    begin_cells(uv, textureSize(slices, 0).xy);
#elif defined(HEX_TILING)
    begin_cells(uv, textureSize(scale_map, 0));
#endif
    only_share = 0.0;
    only_weight = vec3(0.0);
}

void add_light(float share, vec3 weight)
{
    only_share = share;
    only_weight = weight;
}

vec3 light_sum(vec2 uv)
{
    return only_weight * shading_map(only_share, uv);
}

#elif defined(SOURCE_SLICES)
vec3 slice_weights[LAYERS];
int first_slice;
int last_slice;

void begin_light_sum(vec2 uv)
{
#if defined(HEX_TILING)
    begin_cells(uv, textureSize(slices, 0).xy);
#endif
    for (int i = 0; i < LAYERS; ++i)
        slice_weights[i] = vec3(0.0);
    first_slice = LAYERS;
    last_slice = -1;
}

void add_light(float share, vec3 weight)
{
    float layer = (share > 0.0 && share < 3.4e38 ? min(share, 1.0) : 0.0) * float(LAYERS - 1);
    int lower = min(int(layer), LAYERS - 2);
    vec3 beyond = weight * (layer - float(lower));
    slice_weights[lower] += weight - beyond;
    slice_weights[lower + 1] += beyond;
    first_slice = min(first_slice, lower);
    last_slice = max(last_slice, lower + 1);
}

vec3 light_sum(vec2 uv)
{
    float detail = level_of_detail(uv, textureSize(slices, 0).xy);
    vec3 sum = vec3(0.0);
    for (int i = first_slice; i <= last_slice; ++i)
        sum += slice_weights[i] * slice_at(float(i), uv, detail);
    return sum;
}

#elif defined(SOURCE_POWER_LAW)
float detail_here;
vec3 exponent_here;
vec3 power_sum;

void begin_light_sum(vec2 uv)
{
#if defined(HEX_TILING)
    begin_cells(uv, textureSize(scale_map, 0));
#endif
    detail_here = level_of_detail(uv, textureSize(exponent_map, 0));
    exponent_here = exponent_at(uv, detail_here);
    power_sum = vec3(0.0);
}

void add_light(float share, vec3 weight)
{
    if (share > 0.0 && share < 3.4e38)
        power_sum += weight * gain_at(share, detail_here) * exp2(exponent_here * log2(min(share, 1.0)));
}

vec3 light_sum(vec2 uv)
{
    return power_sum * scale_at(uv, detail_here);
}

#elif defined(SOURCE_MIXED)
vec2 uv_here;
float detail_here;
vec3 exponent_here;
float coverage_here;
vec3 power_sum;
vec3 kept_sum;

void begin_light_sum(vec2 uv)
{
    uv_here = uv;
    detail_here = level_of_detail(uv, textureSize(exponent_map, 0));
    exponent_here = exponent_at(uv, detail_here);
    coverage_here = kept_at(0.0, uv, detail_here).a;
    power_sum = vec3(0.0);
    kept_sum = vec3(0.0);
}

void add_light(float share, vec3 weight)
{
    power_sum += weight * gain_at(share, detail_here) * power_of(share, exponent_here);
    if (coverage_here > 0.0)
        kept_sum += weight * kept_at(share, uv_here, detail_here).rgb;
}

vec3 light_sum(vec2 uv)
{
    return (1.0 - coverage_here) * power_sum * scale_at(uv, detail_here) + kept_sum;
}
#endif
