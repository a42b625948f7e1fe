// Whether sharp lights reach a place, by the depths of what they see (engine.gl.shadow_maps).
// in: place relative to the centre of the mesh, and the normal by which it is moved; out: 1 where it is lit, 0 where
// something is nearer to the light. Views are rows of five texels: the columns of the matrix that leads to their clip
// space, and the width of a texel at w = 1. They lie side by side in a square of shadow_grid² views.

uniform sampler2D shadow_depths;
uniform sampler2D shadow_views;
uniform int shadow_grid;
uniform int first_casting;
uniform int casting_count;
#if defined(NEAR_LAMPS)
uniform ivec3 near_shadows[NEAR_LIGHTS]; // first view, points, and views of each point
#endif

const float SHADOW_OFFSET = 1.5; // texels

// -1 where the view does not show the place.
float lit_in_view(int view, vec3 place, vec3 n)
{
    mat4 clip_from_model = mat4(
        texelFetch(shadow_views, ivec2(0, view), 0), texelFetch(shadow_views, ivec2(1, view), 0),
        texelFetch(shadow_views, ivec2(2, view), 0), texelFetch(shadow_views, ivec2(3, view), 0));
    float texel = texelFetch(shadow_views, ivec2(4, view), 0).x;
    float w = (clip_from_model * vec4(place, 1.0)).w;
    vec4 clip = clip_from_model * vec4(place + n * (SHADOW_OFFSET * texel * w), 1.0);
    if (!(clip.w > 0.0) || max(abs(clip.x), abs(clip.y)) >= clip.w)
        return -1.0;
    vec3 within = 0.5 * clip.xyz / clip.w + 0.5;
    int side = textureSize(shadow_depths, 0).x / shadow_grid;
    ivec2 corner = side * ivec2(view % shadow_grid, view / shadow_grid);
    ivec2 at = min(ivec2(within.xy * float(side)), ivec2(side - 1));
    return within.z <= texelFetch(shadow_depths, corner + at, 0).r ? 1.0 : 0.0;
}

// Distant light number i.
float lit_by_distant(int i, vec3 place, vec3 n)
{
    int view = i - first_casting;
    return view < 0 || view >= casting_count ? 1.0 : abs(lit_in_view(view, place, n));
}

#if defined(NEAR_LAMPS)
// The share of the points of a near light that reach the place.
float lit_by_near(int number, vec3 place, vec3 n)
{
    ivec3 of = near_shadows[number];
    float sum = 0.0;
    for (int point = 0; point < of.y; ++point) {
        float lit = -1.0;
        for (int k = 0; k < of.z && lit < 0.0; ++k)
            lit = lit_in_view(of.x + point * of.z + k, place, n);
        sum += abs(lit);
    }
    return sum / float(of.y);
}
#endif
