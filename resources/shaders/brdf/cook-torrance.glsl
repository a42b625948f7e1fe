// Cook-Torrance: kd/pi + ks F D G / (4 n.l n.v), Schlick's F, Beckmann's D of root mean square slope m, V-groove G.
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); out: 1/sr, no cosine, 0 below the horizon.

#include "brdf/highlight.glsl"

uniform vec3 brdf_kd;
uniform vec3 brdf_ks;
uniform float brdf_m;
uniform vec3 brdf_f0;

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    vec3 both = wi + wo;
    float size = length(both);
    vec2 slope = both.xy / both.z;
    float slope2 = dot(slope, slope);
    float m2 = brdf_m * brdf_m;
    float falloff = exp(-slope2 / m2);
    // far from the lobe 0 may meet an infinity
    float distribution = falloff > 0.0 ? falloff * (1.0 + slope2) * (1.0 + slope2) * 0.31830988618379067 / m2 : 0.0;
    float grooves = min(0.25 / (wi.z * wo.z), both.z / (size * size * max(wi.z, wo.z)));
    vec3 fresnel = brdf_f0 + (1.0 - brdf_f0) * schlick(wi, wo, size);
    return brdf_kd * 0.31830988618379067 + brdf_ks * fresnel * (distribution * grooves);
}
