#version 330 core
// Shows an image of any number of pixels over the framebuffer. in: sRGB-coded image, size in pixels; out: the same.

uniform vec2 size;
uniform sampler2D picture;

out vec4 display;

void main()
{
    if (vec2(textureSize(picture, 0)) == size)
        display = texelFetch(picture, ivec2(gl_FragCoord.xy), 0);
    else
        display = texture(picture, gl_FragCoord.xy / size);
}
