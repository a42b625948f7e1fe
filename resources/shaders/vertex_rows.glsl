// Colours of vertices, 2 to the power of `row_bits` beside each other in each line of a texture (engine.gl.buffers).
// in: the number of a colour; out: it, and whether it is marked.

uniform sampler2D rows;
uniform int row_bits;

vec3 row(int number)
{
    return texelFetch(rows, ivec2(number & ((1 << row_bits) - 1), number >> row_bits), 0).rgb;
}

bool marked(int number)
{
    return texelFetch(rows, ivec2(number & ((1 << row_bits) - 1), number >> row_bits), 0).a > 0.0;
}
