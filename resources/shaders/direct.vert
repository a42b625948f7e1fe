#version 330 core
// One vertex of the model.
// in: position relative to the centre of the mesh, unit normal, texture coordinates (v up); out: the same, and v down;
// with BRUSHED also the tangent, with VERTEX_COLOURS the colour.

uniform mat4 clip_from_model;
uniform float repeats;

in vec3 in_position;
in vec3 in_normal;
in vec2 in_uv;
#if defined(BRUSHED)
in vec3 in_tangent;
out vec3 tangent;
#endif
#if defined(VERTEX_COLOURS)
in vec3 in_colour;
out vec3 colour;
#endif

out vec3 position;
out vec3 normal;
out vec2 uv;

void main()
{
    position = in_position;
    normal = in_normal;
#if defined(BRUSHED)
    tangent = in_tangent;
#endif
#if defined(VERTEX_COLOURS)
    colour = in_colour;
#endif
    uv = vec2(in_uv.x, 1.0 - in_uv.y) * repeats;
    gl_Position = clip_from_model * vec4(in_position, 1.0);
}
