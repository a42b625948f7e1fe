#version 330 core
// Shows an image of any number of pixels over the framebuffer, with another one laid over it by a share.
// in: images of radiance times coverage, and coverage, and the size of the framebuffer in pixels; out: sRGB-coded.
// With BEHIND: an equirectangular environment stands behind the image, seen by the camera of `map_from_camera`.
// With DIFFERENCE: the luminance of the first less that of the second where both are covered, blue where it is
// negative and orange where it is positive, full at `scale`.

#include "tonemap.glsl"

uniform vec2 size;
uniform sampler2D first;
uniform sampler2D first_over;
uniform float first_share;
#if defined(DIFFERENCE)
uniform sampler2D second;
uniform sampler2D second_over;
uniform float second_share;
uniform float scale;
uniform vec3 grey;
uniform vec3 below;
uniform vec3 above;

const vec3 LUMINANCE = vec3(0.21263900587151036, 0.71516867876775593, 0.072192315360733714);
#endif

#if defined(BEHIND)
uniform sampler2D environment;
uniform float environment_gain;
uniform mat3 map_from_camera;
uniform vec2 extent;

const float PI = 3.14159265358979324;

// Radiance along the ray through this pixel; engine.render.background.seen in GLSL.
vec3 behind()
{
    vec3 ray = map_from_camera * vec3((2.0 * gl_FragCoord.xy / size - 1.0) * extent, -1.0);
    ray = normalize(ray);
    vec2 at = vec2(atan(ray.x, -ray.z) / (2.0 * PI), acos(clamp(ray.y, -1.0, 1.0)) / PI);
    return environment_gain * textureLod(environment, at, 0.0).rgb;
}
#endif

out vec4 display;

// An image of as many pixels as the framebuffer is shown as it is.
vec4 stretched(sampler2D picture)
{
    if (vec2(textureSize(picture, 0)) == size)
        return texelFetch(picture, ivec2(gl_FragCoord.xy), 0);
    return texture(picture, gl_FragCoord.xy / size);
}

vec4 at(sampler2D picture, sampler2D over, float share)
{
    vec4 under = stretched(picture);
    return share > 0.0 ? mix(under, stretched(over), share) : under;
}

void main()
{
    vec4 one = at(first, first_over, first_share);
#if defined(DIFFERENCE)
    vec4 other = at(second, second_over, second_share);
    float apart = clamp(dot(one.rgb - other.rgb, LUMINANCE) / scale, -1.0, 1.0);
    vec3 colour = mix(grey, apart < 0.0 ? below : above, abs(apart));
    display = vec4(srgb_encode(min(one.a, other.a) > 0.999 ? colour : background), 1.0);
#else
#if defined(BEHIND)
    one = vec4(one.rgb + (1.0 - one.a) * behind(), 1.0);
#endif
    display = shown(one);
#endif
}
