// S(r): the shading map from its slices, from the compressed pair scale (r / r_max)^exponent, or from the pair with
// some tiles kept as slices, which are 0 elsewhere and have their coverage in alpha.
// in: share = r / r_max, texture coordinates (v down, repeating); out: linear radiance under unit light.
// Share is clamped to [0, 1] here; what lies above it is the caller's choice. A share that is not positive and finite
// is black.
// The slices are the layers of an array texture: each is filtered at its own texel centres and the two nearest are
// mixed here, so a share that belongs to a slice gives exactly this slice.
// With HEX_TILING, begin_cells comes before all else.

// Level of detail of an isotropic filter, as the OpenGL specification defines it; texels per texture in `size`.
float level_of_detail(vec2 uv, ivec2 size)
{
    vec2 across = dFdx(uv) * vec2(size);
    vec2 down = dFdy(uv) * vec2(size);
    return 0.5 * log2(max(max(dot(across, across), dot(down, down)), 1e-30));
}

#if defined(HEX_TILING)
#include "hex_cells.glsl"
#endif

#if defined(SOURCE_SLICES)
uniform sampler2DArray slices;
uniform float layers;

vec3 slice_at(float layer, vec2 uv, float detail)
{
#if defined(HEX_TILING)
    return blended_layer(slices, layer, detail);
#else
    return textureLod(slices, vec3(uv, layer), detail).rgb;
#endif
}

vec3 shading_map(float share, vec2 uv)
{
    float layer = (share > 0.0 && share < 3.4e38 ? min(share, 1.0) : 0.0) * (layers - 1.0);
    float lower = min(floor(layer), layers - 2.0);
    float detail = level_of_detail(uv, textureSize(slices, 0).xy);
    vec3 below = slice_at(lower, uv, detail);
    vec3 beyond = slice_at(lower + 1.0, uv, detail);
    float weight = layer - lower;
    return below * (1.0 - weight) + beyond * weight;
}

#elif defined(SOURCE_POWER_LAW) || defined(SOURCE_MIXED)
uniform sampler2D scale_map;
uniform sampler2D exponent_map;

vec3 scale_at(vec2 uv, float detail)
{
#if defined(HEX_TILING)
    return blended_map(scale_map, 0.0, detail);
#else
    return textureLod(scale_map, uv, detail).rgb;
#endif
}

vec3 exponent_at(vec2 uv, float detail)
{
#if defined(HEX_TILING)
    return max(blended_map(exponent_map, 1.0, detail), 0.0);
#else
    return max(textureLod(exponent_map, uv, detail).rgb, 0.0);
#endif
}

vec3 power_of(float share, vec3 exponent)
{
    return share > 0.0 && share < 3.4e38 ? exp2(exponent * log2(min(share, 1.0))) : vec3(0.0);
}

#if defined(GAINS)
uniform sampler2DArray share_gains;

// What keeps the mean radiance at a mip level (engine.render.gains), whose shares are powers of 2 from -16 to 0.
vec3 gain_at(float share, float detail)
{
    vec2 size = vec2(textureSize(share_gains, 0).xy);
    float place = 1.0 + clamp(log2(max(share, 1e-30)), -16.0, 0.0) / 16.0;
    float level = (clamp(detail, 0.0, size.y - 1.0) + 0.5) / size.y;
    return textureLod(share_gains, vec3((place * (size.x - 1.0) + 0.5) / size.x, level, 0.0), 0.0).rgb;
}
#else
vec3 gain_at(float share, float detail)
{
    return vec3(1.0);
}
#endif

#if defined(SOURCE_MIXED)
uniform sampler2DArray kept_tiles;
uniform float layers;

// Radiance of the kept tiles, and their coverage.
vec4 kept_at(float share, vec2 uv, float detail)
{
    float layer = (share > 0.0 && share < 3.4e38 ? min(share, 1.0) : 0.0) * (layers - 1.0);
    float lower = min(floor(layer), layers - 2.0);
    vec4 below = textureLod(kept_tiles, vec3(uv, lower), detail);
    vec4 beyond = textureLod(kept_tiles, vec3(uv, lower + 1.0), detail);
    float weight = layer - lower;
    return below * (1.0 - weight) + beyond * weight;
}
#endif

vec3 shading_map(float share, vec2 uv)
{
    float detail = level_of_detail(uv, textureSize(scale_map, 0));
    vec3 radiance = gain_at(share, detail) * scale_at(uv, detail) * power_of(share, exponent_at(uv, detail));
#if defined(SOURCE_MIXED)
    vec4 kept = kept_at(share, uv, detail);
    radiance = radiance * (1.0 - kept.a) + kept.rgb;
#endif
    return radiance;
}
#endif
