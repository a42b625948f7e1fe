#version 330 core
// One point of a lobe, or of the lines around it.
// in: point in the surface frame (normal +z), angles (theta, phi) in degrees of its direction; out: the same.

uniform mat4 clip_from_surface;

in vec3 in_point;
in vec2 in_angles;

out vec3 point;
out vec2 angles;

void main()
{
    point = in_point;
    angles = in_angles;
    gl_Position = clip_from_surface * vec4(in_point, 1.0);
}
