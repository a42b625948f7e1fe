#version 330 core
// Shows a picture of fewer pixels over the whole framebuffer. in: sRGB-coded picture, size in pixels; out: the same.

uniform sampler2D picture;
uniform vec2 size;

out vec4 display;

void main()
{
    display = texture(picture, gl_FragCoord.xy / size);
}
