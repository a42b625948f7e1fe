// GGX: kd/pi + F D G2 / (4 n.l n.v), Schlick's F, Smith's height-correlated G2; alpha is the width itself.
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); out: 1/sr, no cosine, 0 below the horizon.

uniform vec3 brdf_kd;
uniform float brdf_alpha;
uniform vec3 brdf_f0;

float ggx_slope_length(vec3 direction, float alpha2)
{
    return sqrt(direction.z * direction.z + alpha2 * dot(direction.xy, direction.xy));
}

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    float alpha2 = brdf_alpha * brdf_alpha;
    vec3 h = wi + wo;
    float size = length(h);
    h /= size;
    float width = dot(h.xy, h.xy) + alpha2 * h.z * h.z;
    float distribution = alpha2 * 0.31830988618379067 / (width * width);
    float visibility = 0.5 / (wi.z * ggx_slope_length(wo, alpha2) + wo.z * ggx_slope_length(wi, alpha2));
    float grazing = max(1.0 - 0.5 * size, 0.0);
    float grazing2 = grazing * grazing;
    vec3 fresnel = brdf_f0 + (1.0 - brdf_f0) * (grazing2 * grazing2 * grazing);
    return brdf_kd * 0.31830988618379067 + fresnel * (distribution * visibility);
}
