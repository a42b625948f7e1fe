// S(r): the shading map from its slices, from the compressed pair scale (r / r_max)^exponent, or from the pair with
// some tiles kept as slices, which are 0 elsewhere and have their coverage in alpha.
// in: share = r / r_max, texture coordinates (v down, repeating); out: linear radiance under unit light.
// Share is clamped to [0, 1] here; what lies above it is the caller's choice. A share that is not positive and finite
// is black.
// The slices are the layers of an array texture: each is filtered at its own texel centres and the two nearest are
// mixed here, so a share that belongs to a slice gives exactly this slice.

// Level of detail of an isotropic filter, as the OpenGL specification defines it; texels per texture in `size`.
float level_of_detail(vec2 uv, ivec2 size)
{
    vec2 across = dFdx(uv) * vec2(size);
    vec2 down = dFdy(uv) * vec2(size);
    return 0.5 * log2(max(max(dot(across, across), dot(down, down)), 1e-30));
}

#if defined(SOURCE_SLICES)
uniform sampler2DArray slices;
uniform float layers;

vec3 shading_map(float share, vec2 uv)
{
    float layer = (share > 0.0 && share < 3.4e38 ? min(share, 1.0) : 0.0) * (layers - 1.0);
    float lower = min(floor(layer), layers - 2.0);
    float detail = level_of_detail(uv, textureSize(slices, 0).xy);
    vec3 below = textureLod(slices, vec3(uv, lower), detail).rgb;
    vec3 beyond = textureLod(slices, vec3(uv, lower + 1.0), detail).rgb;
    float weight = layer - lower;
    return below * (1.0 - weight) + beyond * weight;
}

#elif defined(SOURCE_POWER_LAW) || defined(SOURCE_MIXED)
uniform sampler2D scale_map;
uniform sampler2D exponent_map;

vec3 power_of(float share, vec3 exponent)
{
    return share > 0.0 && share < 3.4e38 ? exp2(exponent * log2(min(share, 1.0))) : vec3(0.0);
}

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
    vec3 exponent = max(textureLod(exponent_map, uv, detail).rgb, 0.0);
    vec3 radiance = textureLod(scale_map, uv, detail).rgb * power_of(share, exponent);
#if defined(SOURCE_MIXED)
    vec4 kept = kept_at(share, uv, detail);
    radiance = radiance * (1.0 - kept.a) + kept.rgb;
#endif
    return radiance;
}
#endif
