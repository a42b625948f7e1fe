#version 330 core
// Radiance of one fragment of Gaussian transport: its lobes under the light, and the diffuse part.
// in: of gaussian.vert; out: linear radiance, clamped at 0 here and nowhere before, and coverage 1. Faces that are seen
// from behind are black, and so is what is not finite; in debug builds that is magenta with coverage 2.

#if defined(LOBES)
#include "prefiltered.glsl"

uniform float factor;
uniform mat3 map_from_world;
#endif

// Code for lamps, and for those that are discs, costs time even where it does not run.
#if defined(LAMPS)
uniform int lamp_count;
uniform vec4 lamps[MAX_LAMPS];    // direction, and the radius as a chord
uniform vec3 lamp_light[MAX_LAMPS];    // radiance, or irradiance where the radius is 0
#endif
#if defined(DISCS)
#include "erf.glsl"

uniform vec2 gauss[NODES];    // Gauss's points in [-1, 1] and their shares
#endif

in vec3 at_vertices;
#if defined(LOBES)
in vec4 mean_width[LOBES];
in vec3 energy[LOBES];
#endif

out vec4 radiance;

#if defined(DISCS)
// The integral of the lobe over a disc, on the plane whose distances are chords: strips across the line between both
// middles in closed form, and their sum by Gauss's rule.
float disc(float distance_to, float radius, float sigma)
{
    float low = max(distance_to - radius, -REACH * sigma);
    float high = min(distance_to + radius, REACH * sigma);
    if (!(low < high))
        return 0.0;
    float inverse = 0.70710678 / sigma;
    float sum = 0.0;
    for (int i = 0; i < NODES; ++i) {
        float x = 0.5 * (high + low) + 0.5 * (high - low) * gauss[i].x;
        float chord = sqrt(max(radius * radius - (x - distance_to) * (x - distance_to), 0.0));
        sum += gauss[i].y * exp(-x * x * inverse * inverse) * erf(chord * inverse);
    }
    return sum * 0.5 * (high - low) * sigma * 2.50662827;
}

#endif

#if defined(LAMPS)
vec3 lamps_through(vec3 mean, float sigma)
{
    vec3 sum = vec3(0.0);
    for (int i = 0; i < lamp_count; ++i) {
        vec3 apart = mean - lamps[i].xyz;
        float squared = dot(apart, apart);
        float share = exp(-0.5 * squared / (sigma * sigma));
#if defined(DISCS)
        if (lamps[i].w > 0.0)
            share = disc(sqrt(squared), lamps[i].w, sigma);
#endif
        sum += share * lamp_light[i];
    }
    return sum / (6.28318531 * sigma * sigma * (1.0 - exp(-2.0 / (sigma * sigma))));
}

#endif

#if defined(LOBES)
vec3 glossy()
{
    vec3 sum = vec3(0.0);
    for (int k = 0; k < LOBES; ++k) {
        if (!any(greaterThan(energy[k], vec3(0.0))))
            continue;
        float squared = dot(mean_width[k].xyz, mean_width[k].xyz);
        vec3 mean = squared > 1e-12 ? mean_width[k].xyz * inversesqrt(squared) : vec3(0.0, 1.0, 0.0);
        vec3 light = factor * mean_under(map_from_world * mean, mean_width[k].w);
#if defined(LAMPS)
        light += lamps_through(mean, exp(mean_width[k].w));
#endif
        sum += energy[k] * light;
    }
    return sum;
}
#endif

void main()
{
    vec3 value = at_vertices;
#if defined(LOBES)
    if (gl_FrontFacing)
        value += glossy();
#endif
    vec3 signed_value = gl_FrontFacing ? value : vec3(0.0);
    radiance = vec4(max(signed_value, 0.0), 1.0);
    if (any(isnan(signed_value)) || any(isinf(signed_value)))
#if defined(DEBUG)
        radiance = vec4(1.0, 0.0, 1.0, 2.0);
#else
        radiance = vec4(0.0, 0.0, 0.0, 1.0);
#endif
}
