// PBR maps in hexagonal cells (engine.render.hex_tiling, which has the formulas). pbr_maps holds Gaussian numbers in its
// first two layers; the others are as in a grid.

#include "hex_cells.glsl"

uniform vec3 hex_mean_normal;

const float STEEPEST = 0.98;

void blend_cells(vec2 uv, float detail, out vec3 tilt, out vec3 square)
{
    begin_cells(uv, textureSize(pbr_maps, 0).xy);
    base_here = blended_layer(pbr_maps, 0.0, detail);
    gloss_here = blended_layer(pbr_maps, 1.0, detail);
    vec3 apart = vec3(0.0);
    vec4 covariance = vec4(0.0);
    for (int cell = 0; cell < 3; cell++) {
        float own = cell_share[cell];
        if (own <= 0.0)
            continue;
        vec3 m, s;
        normals_at(cell_uv[cell], detail, m, s);
        apart += own * (m - hex_mean_normal);
        vec3 about = s - vec3(m.x * m.x, m.y * m.y, m.x * m.y);
        float zz = max(1.0 - s.x - s.y - m.z * m.z, 0.0);
        if (detail > 0.0) {
            joint_here += own * own * textureLod(pbr_maps, vec3(cell_uv[cell], 4.0), detail).rgb;
            apart_here += own * own * textureLod(pbr_maps, vec3(cell_uv[cell], 5.0), detail).rgb;
        }
        covariance += own * own * vec4(max(about.xy, 0.0), about.z, zz);
    }
    vec2 bent = hex_mean_normal.xy + apart.xy;
    bent *= min(1.0, STEEPEST / max(length(bent), 1e-12));
    float rise = 1.0 - dot(bent, bent) - covariance.x - covariance.y - covariance.w;
    tilt = vec3(bent, sqrt(max(rise, 1.0 - STEEPEST * STEEPEST)));
    square = covariance.xyz + vec3(bent.x * bent.x, bent.y * bent.y, bent.x * bent.y);
}
