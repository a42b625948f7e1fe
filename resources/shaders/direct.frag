#version 330 core
// Radiance of one fragment under one directional light; see engine.scene for the formulas.
// in: position and normal relative to the mesh, world axes; out: linear radiance and coverage 1.
// A result that is not finite is 0; in debug builds magenta with coverage 2, so that it can be seen and counted.

#include "frame.glsl"
#include BRDF
#include "shading_map.glsl"

uniform vec3 eye;
uniform vec3 light;
uniform float irradiance;
uniform float sigma;
uniform float r_max;

in vec3 position;
in vec3 normal;
in vec2 uv;

out vec4 radiance;

const vec3 LUMINANCE = vec3(0.21263900587151036, 0.71516867876775593, 0.072192315360733714);

#if !defined(SOURCE_NONE)
vec3 scaled_shading_map(float r)
{
#if defined(ABOVE_SCALE)
    return shading_map(r / r_max, uv) * max(r / r_max, 1.0);
#else
    return shading_map(r / r_max, uv);
#endif
}
#endif

vec3 shade(vec3 f, float cos_theta)
{
#if defined(SOURCE_NONE)
    return f * (cos_theta * irradiance);
#else
    float r = sigma * dot(f, LUMINANCE) * cos_theta;
#if defined(LOOKUP_TEXTURE)
    return shading_map(1.0, uv) * (r / r_max * irradiance);
#elif defined(LOOKUP_OUTGOING)
    return scaled_shading_map(r * irradiance);
#elif defined(LOOKUP_ANGLE)
    return shading_map(cos_theta, uv) * (sigma * dot(f, LUMINANCE) / r_max * irradiance);
#else
    return scaled_shading_map(r) * irradiance;
#endif
#endif
}

// The shading normal on the side that is seen. An interpolated normal may point away from the viewer near the
// silhouette, where a BRDF is 0 and a dark fringe would show: it is bent until it just faces the viewer.
vec3 visible_normal(vec3 wo)
{
    vec3 flat_normal = safe_normalize(cross(dFdx(position), dFdy(position)), wo);
    flat_normal *= dot(flat_normal, wo) < 0.0 ? -1.0 : 1.0;
    vec3 n = safe_normalize(normal, flat_normal) * (gl_FrontFacing ? 1.0 : -1.0);
    float facing = dot(n, wo);
    return facing < 0.01 ? safe_normalize(n + (0.01 - facing) * wo, wo) : n;
}

void main()
{
    vec3 wo = safe_normalize(eye - position, vec3(0.0, 0.0, 1.0));
    mat3 frame = world_from_tangent(visible_normal(wo));
    vec3 wi_local = light * frame;
    vec3 value = shade(brdf(wi_local, wo * frame), wi_local.z);
    radiance = vec4(max(value, 0.0), 1.0);
    if (any(isnan(value)) || any(isinf(value)))
#if defined(DEBUG)
        radiance = vec4(1.0, 0.0, 1.0, 2.0);
#else
        radiance = vec4(0.0, 0.0, 0.0, 1.0);
#endif
}
