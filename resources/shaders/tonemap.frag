#version 330 core
// in: radiance times coverage and coverage, `samples` texels along each side of a pixel; out: sRGB-coded, opaque.

#include "resolve.glsl"
#include "tonemap.glsl"

out vec4 display;

void main()
{
    display = shown(resolved());
}
