// The three of the 92 views around a direction, and the lobes stored for them (engine.gl.gaussian).
// in: direction of any length but 0; out: numbers of the views and the shares with which they add up to it.
// `view_table` holds, three texels in a row: for each of the 20 faces of the icosahedron the inverse of its corners; for
// each of the nine triangles of a face, twice, because half of them stand on their heads, the inverse of its views, and
// in w their numbers; then the directions of the views.

const int FACES = 20;
const int TRIANGLES = 18 * FACES;

uniform sampler2D view_table;
uniform vec3 view_centres[FACES];

struct Views
{
    ivec3 index;
    vec3 share;
};

Views views_around(vec3 d)
{
    int face = 0;
    float nearest = -1e30;
    for (int f = 0; f < FACES; ++f) {
        float along = dot(view_centres[f], d);
        face = along > nearest ? f : face;
        nearest = max(along, nearest);
    }
    vec3 on_face;
    for (int k = 0; k < 3; ++k)
        on_face[k] = dot(texelFetch(view_table, ivec2(k, face), 0).xyz, d);
    vec2 place = max(3.0 * on_face.xy / (on_face.x + on_face.y + on_face.z), 0.0);
    int i = min(int(place.x), 2);
    int j = min(int(place.y), 2 - i);
    vec2 within = place - vec2(i, j);
    int turned = within.x + within.y > 1.0 && i + j < 2 ? 1 : 0;
    int line = FACES + ((face * 3 + i) * 3 + j) * 2 + turned;
    Views views;
    for (int k = 0; k < 3; ++k) {
        vec4 row = texelFetch(view_table, ivec2(k, line), 0);
        views.share[k] = max(dot(row.xyz, d), 0.0);
        views.index[k] = int(row.w);
    }
    views.share /= views.share.x + views.share.y + views.share.z;
    return views;
}

vec3 view_direction(int view)
{
    return texelFetch(view_table, ivec2(view % 3, FACES + TRIANGLES + view / 3), 0).xyz;
}

#if defined(LOBES)
// A lobe in three words: its mean on an octahedron, 16 bits to an axis; then 16 bits for the logarithm of its width,
// from `sigma_span.x` on in steps of `sigma_span.y`, and three half floats for its energy.
uniform usampler2D lobe_texels;
uniform int lobes_width;
uniform vec2 sigma_span;

struct Lobe
{
    vec3 mean;
    float log_sigma;
    vec3 energy;
};

// Half floats without sign, subnormal ones too; the product puts their exponent right.
vec3 halves(uvec3 bits)
{
    return vec3(uintBitsToFloat(bits.x << 13), uintBitsToFloat(bits.y << 13), uintBitsToFloat(bits.z << 13)) * 5.192296858534828e33;
}

vec3 from_octahedron(uint bits)
{
    vec2 place = vec2(bits & 65535u, bits >> 16) * (2.0 / 65535.0) - 1.0;
    vec3 d = vec3(place, 1.0 - abs(place.x) - abs(place.y));
    float below = max(-d.z, 0.0);
    d.xy -= vec2(d.x >= 0.0 ? below : -below, d.y >= 0.0 ? below : -below);
    return normalize(d);
}

Lobe lobe_of(int vertex, int view, int k)
{
    int number = (vertex * VIEWS + view) * LOBES + k;
    uvec3 words = texelFetch(lobe_texels, ivec2(number % lobes_width, number / lobes_width), 0).xyz;
    Lobe lobe;
    lobe.mean = from_octahedron(words.x);
    lobe.log_sigma = sigma_span.x + sigma_span.y * float(words.y & 65535u);
    lobe.energy = halves(uvec3(words.y >> 16, words.z & 65535u, words.z >> 16));
    return lobe;
}
#endif
