#version 330 core
// One vertex of what casts shadows, seen by a light.
// in: position relative to the centre of the mesh.

uniform mat4 clip_from_model;

in vec3 in_position;

void main()
{
    gl_Position = clip_from_model * vec4(in_position, 1.0);
}
