// Colours of vertices, `row_width` beside each other in each line of a texture (engine.gl.buffers).
// in: the number of a colour; out: it, and whether it is marked.

uniform sampler2D rows;
uniform int row_width;

vec3 row(int number)
{
    return texelFetch(rows, ivec2(number % row_width, number / row_width), 0).rgb;
}

bool marked(int number)
{
    return texelFetch(rows, ivec2(number % row_width, number / row_width), 0).a > 0.0;
}
