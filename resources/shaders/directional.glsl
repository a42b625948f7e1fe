// The directional map: a few planes for each texel, whose weighted sum is the sRGB code of its radiance
// (engine.shading.directional.planes).
// in: PLANE_LAYERS, three planes each; the cosine of light seen from above, its azimuth along the axes of the texture;
// out: linear radiance under unit light. Planes are filtered, then summed, then decoded.

#include "texture_axes.glsl"

uniform sampler2DArray planes;
uniform sampler2DArray plane_weights;
uniform float lowest_cosine;

const float TWO_PI = 6.28318530717958648;

vec3 planes_here[PLANE_LAYERS];

void fetch_planes(vec2 uv)
{
    float detail = level_of_detail(uv, textureSize(planes, 0).xy);
    for (int i = 0; i < PLANE_LAYERS; ++i)
        planes_here[i] = 255.0 * textureLod(planes, vec3(uv, float(i)), detail).rgb;
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
    return min(cosine / lowest_cosine, 1.0) * decoded(code / 255.0);
}
