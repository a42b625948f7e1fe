#version 330 core
// Radiance of one fragment of transported light.
// in: of transported.vert; out: linear radiance, clamped at 0 here and nowhere before, and coverage 1. Faces that are
// seen from behind are black, and so is what is not finite; in debug builds that is magenta with coverage 2.

#if defined(TERMS)
#include SOURCE
#endif

in vec3 at_vertices;
#if defined(TERMS)
in vec3 view;
in vec3 along;
in vec3 terms[TERMS];
#if defined(KINDS)
flat in int layer_of_maps;
#else
const int layer_of_maps = 0;
#endif
#endif

out vec4 radiance;

// Terms belong to the frame of their vertex, so they may be mixed only where the frames of the three corners are
// nearly one. Around the one point where frames turn about, the tangents cancel, and the radiance of the corners is
// mixed instead; at the corners themselves both are the same.
vec3 value()
{
#if defined(TERMS)
    float one_frame = smoothstep(0.75, 0.93, dot(along, along));
    if (one_frame > 0.0)
        return mix(at_vertices, mixed(normalize(view), terms, layer_of_maps), one_frame);
#endif
    return at_vertices;
}

void main()
{
    vec3 signed_value = gl_FrontFacing ? value() : vec3(0.0);
    radiance = vec4(max(signed_value, 0.0), 1.0);
    if (any(isnan(signed_value)) || any(isinf(signed_value)))
#if defined(DEBUG)
        radiance = vec4(1.0, 0.0, 1.0, 2.0);
#else
        radiance = vec4(0.0, 0.0, 0.0, 1.0);
#endif
}
