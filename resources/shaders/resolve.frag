#version 330 core
// in: radiance times coverage and coverage, `samples` texels along each side of a pixel; out: their mean, linear.

#include "resolve.glsl"

out vec4 picture;

void main()
{
    picture = resolved();
}
