// PBR maps in hexagonal cells, each shifted by a hash, blended by their values (engine.render.hex_tiling, which has the
// formulas). pbr_maps holds Gaussian numbers in its first two layers, hex_tables their values at each mip level.

uniform sampler2DArray hex_tables;
uniform vec3 hex_mean_normal;

const float CELLS = 3.4641016151377544;
const float SHARPNESS = 4.0;
const float REACH = 3.5;
const float STEEPEST = 0.98;

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

void blend_cells(vec2 uv, float detail, out vec3 tilt, out vec3 square)
{
    vec2 st = CELLS * uv;
    vec2 skewed = vec2(st.x, (2.0 * st.y - st.x) / 1.7320508075688772);
    ivec2 base = ivec2(floor(skewed));
    vec2 within = fract(skewed);
    float rest = 1.0 - within.x - within.y;
    int far = rest <= 0.0 ? 1 : 0;
    float sign_of = 2.0 * float(far) - 1.0;
    vec3 weight = vec3(-rest * sign_of, float(far) - within.y * sign_of, float(far) - within.x * sign_of);
    weight = pow(max(weight, 0.0), vec3(SHARPNESS));
    weight /= weight.x + weight.y + weight.z;
    vec3 share = weight / length(weight);
    ivec2 corners[3] = ivec2[3](ivec2(far, far), ivec2(far, 1 - far), ivec2(1 - far, far));
    vec2 size = vec2(textureSize(pbr_maps, 0).xy);
    vec3 colour = vec3(0.0), gloss = vec3(0.0), apart = vec3(0.0);
    vec4 covariance = vec4(0.0);
    for (int cell = 0; cell < 3; cell++) {
        vec2 at = uv + floor(hash_cell(base + corners[cell]) * size) / size;
        float own = share[cell];
        colour += own * textureLod(pbr_maps, vec3(at, 0.0), detail).rgb;
        gloss += own * textureLod(pbr_maps, vec3(at, 1.0), detail).rgb;
        vec3 m, s;
        normals_at(at, detail, m, s);
        apart += own * (m - hex_mean_normal);
        vec3 about = s - vec3(m.x * m.x, m.y * m.y, m.x * m.y);
        float zz = max(1.0 - s.x - s.y - m.z * m.z, 0.0);
        covariance += own * own * vec4(max(about.xy, 0.0), about.z, zz);
    }
    base_here = values_of(colour, 0.0, detail);
    gloss_here = values_of(gloss, 1.0, detail);
    vec2 bent = hex_mean_normal.xy + apart.xy;
    bent *= min(1.0, STEEPEST / max(length(bent), 1e-12));
    float rise = 1.0 - dot(bent, bent) - covariance.x - covariance.y - covariance.w;
    tilt = vec3(bent, sqrt(max(rise, 1.0 - STEEPEST * STEEPEST)));
    square = covariance.xyz + vec3(bent.x * bent.x, bent.y * bent.y, bent.x * bent.y);
}
