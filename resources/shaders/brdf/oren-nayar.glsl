// Oren-Nayar: albedo/pi (A + B max(0, cos dphi) sin a tan b), written over the cosines. sigma in degrees.
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); out: 1/sr, no cosine, 0 below the horizon.

uniform vec3 brdf_albedo;
uniform float brdf_sigma_deg;

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    float sigma = brdf_sigma_deg * 0.017453292519943295;
    float variance = sigma * sigma;
    float facing = 1.0 - 0.5 * variance / (variance + 0.33);
    float retro = 0.45 * variance / (variance + 0.09);
    float along = max(dot(wi.xy, wo.xy), 0.0) / max(wi.z, wo.z);
    return brdf_albedo * ((facing + retro * along) * 0.31830988618379067);
}
