#version 330 core
// One vertex of Gaussian transport: its lobes towards the eye, mixed between the three nearest views (Green et al. 2006,
// section 5; engine.transport.gaussian.transfer).
// in: position relative to the centre of the mesh, unit normal; `rows` has the diffuse radiance of each vertex; vertices
// from flat_vertex on have no lobes.
// out: diffuse radiance; for each lobe the mean, a unit vector, with the logarithm of sigma, and the energy.

#include "frame.glsl"
#include "vertex_rows.glsl"
#include "gaussian_views.glsl"

uniform mat4 clip_from_model;
uniform vec3 eye;
uniform int flat_vertex;
uniform bool grazing;

in vec3 in_position;
in vec3 in_normal;

out vec3 at_vertices;
#if defined(LOBES)
out vec4 mean_width[LOBES];
out vec3 energy[LOBES];
#endif

// A vertex of a face that is seen may be turned away itself.
const float GRAZING = 0.01;

// Squared length of a mean of means below which it points nowhere.
const float NOWHERE = 1e-12;

void main()
{
    gl_Position = clip_from_model * vec4(in_position, 1.0);
    vec3 up = vec3(0.0, 0.0, 1.0);
    vec3 n = safe_normalize(in_normal, up);
    vec3 wo = safe_normalize(eye - in_position, up);
    wo = normalize(wo + max(GRAZING - dot(n, wo), 0.0) * n);
    bool is_flat = gl_VertexID >= flat_vertex;
    at_vertices = row(gl_VertexID);
    if (grazing && !is_flat) {
        float rest = 1.0 - 0.5 * max(dot(n, wo), 0.0);
        at_vertices *= 1.0 - rest * rest * rest * rest * rest;
    }
#if defined(LOBES)
    for (int k = 0; k < LOBES; ++k) {
        mean_width[k] = vec4(n, 0.0);
        energy[k] = vec3(0.0);
    }
    if (is_flat)
        return;
    Views views = views_around(wo);
    vec3 counted = views.share;
    for (int j = 0; j < 3; ++j)
        counted[j] = dot(view_direction(views.index[j]), n) > 0.0 ? counted[j] : 0.0;
    float total = counted.x + counted.y + counted.z;
    counted = total > 0.0 ? counted / total : vec3(0.0);
    for (int k = 0; k < LOBES; ++k) {
        vec3 nearest = n;
        vec3 sum = vec3(0.0);
        float largest = -1.0;
        float log_sigma = 0.0;
        for (int j = 0; j < 3; ++j) {
            Lobe lobe = lobe_of(gl_VertexID, views.index[j], k);
            sum += views.share[j] * lobe.mean;
            log_sigma += views.share[j] * lobe.log_sigma;
            energy[k] += counted[j] * lobe.energy;
            nearest = views.share[j] > largest ? lobe.mean : nearest;
            largest = max(views.share[j], largest);
        }
        float squared = dot(sum, sum);
        mean_width[k] = vec4(squared > NOWHERE ? sum * inversesqrt(squared) : nearest, log_sigma);
    }
#endif
}
