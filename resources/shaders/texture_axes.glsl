// Texture coordinates on a surface: the axes along which a texture runs there. Includes frame.glsl.
// in: place, coordinates (v down) and unit normal of a fragment; out: unit vectors to the right and upwards.

#include "frame.glsl"

// Axes of the texture to the right and upwards, perpendicular to n, from how place and coordinates (v down) change
// between neighbouring pixels; where the texture is seen mirrored, the second is -n x the first.
mat2x3 texture_axes(vec3 place, vec2 uv, vec3 n)
{
    vec3 across = dFdx(place), down = dFdy(place);
    vec2 one = dFdx(uv), two = dFdy(uv);
    float turned = one.x * two.y - one.y * two.x < 0.0 ? -1.0 : 1.0;
    mat3 frame = frame_along(n, turned * (across * two.y - down * one.y));
    float mirrored = dot(frame[1], turned * (across * two.x - down * one.x)) < 0.0 ? -1.0 : 1.0;
    return mat2x3(frame[0], mirrored * frame[1]);
}
