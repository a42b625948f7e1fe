// Minnaert: albedo/pi (cos i cos o)^(k-1).
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); out: 1/sr, no cosine, 0 below the horizon.

uniform vec3 brdf_albedo;
uniform float brdf_k;

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    return brdf_albedo * (0.31830988618379067 * pow(wi.z * wo.z, brdf_k - 1.0));
}
