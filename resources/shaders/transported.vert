#version 330 core
// One vertex whose incoming light was transported beforehand (engine.transport.relit).
// in: position relative to the centre of the mesh, unit normal, with BRUSHED the tangent; vertices from flat_vertex on
// have a radiance of their own in `rows`, the same towards every side.
// out: radiance towards the eye, linear and signed; where light is looked up at each fragment (TERMS), also the view
// in the frame of the vertex, the tangent of that frame, what the light has made of each term, and with KINDS the first
// layer of the maps, which is the same for all vertices of a triangle of the model. The tangent is 0
// where the radiance of the vertices is all there is.

#include "frame.glsl"
#include "vertex_rows.glsl"
#define VERTEX
#include SOURCE

uniform mat4 clip_from_model;
uniform vec3 eye;
uniform int flat_vertex;

in vec3 in_position;
in vec3 in_normal;
#if defined(BRUSHED)
in vec3 in_tangent;
#endif

out vec3 at_vertices;
#if defined(TERMS)
out vec3 view;
out vec3 along;
out vec3 terms[TERMS];
#if defined(KINDS)
flat out int layer_of_maps;
#endif
#endif

// A vertex of a face that is seen may be turned away itself.
const float GRAZING = 0.01;

void main()
{
    gl_Position = clip_from_model * vec4(in_position, 1.0);
    vec3 up = vec3(0.0, 0.0, 1.0);
    vec3 n = safe_normalize(in_normal, up);
#if defined(BRUSHED)
    mat3 frame = frame_along(n, in_tangent);
#else
    mat3 frame = world_from_tangent(n);
#endif
    vec3 wo = safe_normalize(eye - in_position, up) * frame;
    wo = normalize(vec3(wo.xy, max(wo.z, GRAZING)));
    bool is_flat = gl_VertexID >= flat_vertex;
    at_vertices = is_flat ? flat_radiance(gl_VertexID - flat_vertex) : radiance_of(gl_VertexID, wo);
#if defined(TERMS)
    view = wo;
    along = is_flat ? vec3(0.0) : frame[0];
#if defined(KINDS)
    layer_of_maps = is_flat ? 0 : first_layer(gl_VertexID);
#endif
    for (int k = 0; k < TERMS; ++k)
        terms[k] = is_flat ? vec3(0.0) : term_of(gl_VertexID, k);
#endif
}
