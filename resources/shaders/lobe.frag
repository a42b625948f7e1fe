#version 330 core
// A lobe in its own colour, lit from the eye, with thin lines every 15 degrees of theta and 30 of phi.
// in: point in the surface frame, angles in degrees; out: sRGB-coded colour.

uniform vec3 eye;
uniform vec3 colour;
uniform bool lit;
uniform float opacity;

in vec3 point;
in vec2 angles;

out vec4 shown;

void main()
{
    if (!lit) {
        shown = vec4(colour, 1.0);
        return;
    }
    vec3 across = cross(dFdx(point), dFdy(point));
    float size = length(across);
    float facing = size > 0.0 ? abs(dot(across / size, normalize(eye - point))) : 1.0;
    vec2 lines = angles / vec2(15.0, 30.0);
    vec2 distance_px = abs(fract(lines - 0.5) - 0.5) / max(fwidth(lines), vec2(1e-6));
    float line = 1.0 - min(min(distance_px.x, distance_px.y), 1.0);
    shown = vec4(colour * (0.35 + 0.65 * facing) * (1.0 - 0.35 * line), opacity);
}
