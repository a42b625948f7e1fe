// The directional map: a few planes for each texel, whose weighted sum is the sRGB code of its radiance
// (engine.shading.directional.planes).
// in: PLANE_LAYERS, three planes each; the cosine of light seen from above, its azimuth along the axes of the texture;
// out: linear radiance under unit light. Planes are filtered, then summed, then decoded. With GAINS, the layers of
// plane_weights after those of the planes are the gains of each size (engine.render.gains).

#include "texture_axes.glsl"

uniform sampler2DArray planes;
uniform sampler2DArray plane_weights;
uniform float lowest_cosine;

const float TWO_PI = 6.28318530717958648;

vec3 planes_here[PLANE_LAYERS];
float detail_of_planes;

void fetch_planes(vec2 uv)
{
    float detail = level_of_detail(uv, textureSize(planes, 0).xy);
    detail_of_planes = detail;
    for (int i = 0; i < PLANE_LAYERS; ++i)
#if defined(HEX_MEANS)
        planes_here[i] = 255.0 * blended_layer(planes, float(i), detail);
#elif defined(HEX_TILING)
        planes_here[i] = blended_layer(planes, float(i), detail);
#else
        planes_here[i] = 255.0 * textureLod(planes, vec3(uv, float(i)), detail).rgb;
#endif
}

float turn_of(vec2 heading)
{
    return dot(heading, heading) > 0.0 ? atan(heading.y, heading.x) / TWO_PI : 0.0;
}

vec3 decoded(vec3 code)
{
    code = max(code, 0.0);
    return mix(pow((max(code, 0.04045) + 0.055) / 1.055, vec3(2.4)), code / 12.92, lessThanEqual(code, vec3(0.04045)));
}

// Radiance under light from above at this cosine and azimuth; dimmed below the lowest lamp of the capture.
vec3 directional_map(float cosine, float turn)
{
    if (!(cosine > 0.0))
        return vec3(0.0);
    ivec2 size = textureSize(plane_weights, 0).xy;
    float tilt = acos(min(cosine, 1.0)) / (0.25 * TWO_PI);
    vec2 at = vec2(turn + 0.5 / float(size.x), (tilt * float(size.y - 1) + 0.5) / float(size.y));
    vec3 code = textureLod(plane_weights, vec3(at, 0.0), 0.0).rgb;
    for (int i = 0; i < PLANE_LAYERS; ++i)
        for (int k = 0; k < 3; ++k)
            code += planes_here[i][k] * textureLod(plane_weights, vec3(at, float(1 + 3 * i + k)), 0.0).rgb;
    vec3 radiance = min(cosine / lowest_cosine, 1.0) * decoded(code / 255.0);
#if defined(GAINS)
    float last = float(textureSize(plane_weights, 0).z - 3 * PLANE_LAYERS - 2);
    float level = clamp(detail_of_planes, 0.0, last);
    float finer = 1.0 + 3.0 * float(PLANE_LAYERS) + floor(level);
    radiance *= mix(textureLod(plane_weights, vec3(at, finer), 0.0).rgb,
                    textureLod(plane_weights, vec3(at, finer + ceil(fract(level))), 0.0).rgb, fract(level));
#endif
    return radiance;
}
