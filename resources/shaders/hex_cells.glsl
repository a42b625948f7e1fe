// Maps in hexagonal cells, each shifted by a hash, blended as Gaussian numbers (engine.render.hex_tiling, which has the
// formulas). Maps hold the numbers, hex_tables the values of numbers at each mip level, a layer for each of the maps.
// begin_cells comes before all else. With HEX_MEANS, maps hold values, and blends keep their mean and their variance, not
// their histogram; is_hexagonal is false where maps repeat in a grid.

#if defined(HEX_MEANS)
uniform bool is_hexagonal;
#else
uniform sampler2DArray hex_tables;
#endif

const float CELLS = 3.4641016151377544;
const float SHARPNESS = 4.0;
const float MIN_SHARE = 2e-3;
const float REACH = 3.5;

vec2 cell_uv[3];
vec3 cell_share;

// The shift of the cell about a vertex, in [0, 1).
vec2 hash_cell(ivec2 vertex)
{
    uvec2 v = uvec2(vertex) * 1664525u + 1013904223u;
    for (int turn = 0; turn < 2; turn++) {
        v.x += v.y * 1664525u;
        v.y += v.x * 1664525u;
        v ^= v >> 16u;
    }
    return vec2(v >> 8u) / 16777216.0;
}

// Coordinates in the three cells around uv of maps with so many texels, and factors of deviations from the mean.
void begin_cells(vec2 uv, ivec2 texels)
{
#if defined(HEX_MEANS)
    cell_share = vec3(1.0, 0.0, 0.0);
    cell_uv = vec2[3](uv, uv, uv);
    if (!is_hexagonal)
        return;
#endif
    vec2 st = CELLS * uv;
    vec2 skewed = vec2(st.x, (2.0 * st.y - st.x) / 1.7320508075688772);
    ivec2 base = ivec2(floor(skewed));
    vec2 within = fract(skewed);
    float rest = 1.0 - within.x - within.y;
    int far = rest <= 0.0 ? 1 : 0;
    float sign_of = 2.0 * float(far) - 1.0;
    vec3 weight = vec3(-rest * sign_of, float(far) - within.y * sign_of, float(far) - within.x * sign_of);
    weight = pow(max(weight, 0.0), vec3(SHARPNESS));
    weight = max(weight - MIN_SHARE * (weight.x + weight.y + weight.z), 0.0);
    cell_share = weight / length(weight);
    vec2 size = vec2(texels);
    cell_uv[0] = uv + floor(hash_cell(base + ivec2(far)) * size) / size;
    cell_uv[1] = uv + floor(hash_cell(base + ivec2(far, 1 - far)) * size) / size;
    cell_uv[2] = uv + floor(hash_cell(base + ivec2(1 - far, far)) * size) / size;
}

#if defined(HEX_MEANS)
// A layer of maps, blended; its mean is the smallest size.
vec3 blended_layer(sampler2DArray maps, float layer, float detail)
{
    vec3 mean = textureLod(maps, vec3(cell_uv[0], layer), 32.0).rgb, apart = vec3(0.0);
    for (int cell = 0; cell < 3; ++cell)
        if (cell_share[cell] > 0.0)
            apart += cell_share[cell] * (textureLod(maps, vec3(cell_uv[cell], layer), detail).rgb - mean);
    return max(mean + apart, 0.0);
}

// A map alone, blended.
vec3 blended_map(sampler2D map, float layer, float detail)
{
    vec3 mean = textureLod(map, cell_uv[0], 32.0).rgb, apart = vec3(0.0);
    for (int cell = 0; cell < 3; ++cell)
        if (cell_share[cell] > 0.0)
            apart += cell_share[cell] * (textureLod(map, cell_uv[cell], detail).rgb - mean);
    return max(mean + apart, 0.0);
}
#else
// The values of Gaussian numbers of a layer at a mip level.
vec3 values_of(vec3 numbers, float layer, float detail)
{
    vec2 size = vec2(textureSize(hex_tables, 0).xy);
    vec3 place = (clamp((numbers + REACH) / (2.0 * REACH), 0.0, 1.0) * (size.x - 1.0) + 0.5) / size.x;
    float level = (clamp(detail, 0.0, size.y - 1.0) + 0.5) / size.y;
    return vec3(textureLod(hex_tables, vec3(place.x, level, layer), 0.0).r,
                textureLod(hex_tables, vec3(place.y, level, layer), 0.0).g,
                textureLod(hex_tables, vec3(place.z, level, layer), 0.0).b);
}

// A layer of maps, blended.
vec3 blended_layer(sampler2DArray maps, float layer, float detail)
{
    vec3 numbers = vec3(0.0);
    for (int cell = 0; cell < 3; ++cell)
        if (cell_share[cell] > 0.0)
            numbers += cell_share[cell] * textureLod(maps, vec3(cell_uv[cell], layer), detail).rgb;
    return values_of(numbers, layer, detail);
}

// A map alone, blended, whose table is `layer`.
vec3 blended_map(sampler2D map, float layer, float detail)
{
    vec3 numbers = vec3(0.0);
    for (int cell = 0; cell < 3; ++cell)
        if (cell_share[cell] > 0.0)
            numbers += cell_share[cell] * textureLod(map, cell_uv[cell], detail).rgb;
    return values_of(numbers, layer, detail);
}
#endif
