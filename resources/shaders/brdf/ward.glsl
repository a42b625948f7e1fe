// Ward with bounded albedo: kd/pi + ks/(pi ax ay) exp(-(Hx^2/ax^2 + Hy^2/ay^2)/Hz^2) (H.H)/Hz^4, H = wi + wo.
// in: wi to the light, wo to the viewer, unit, surface frame (normal +z); out: 1/sr, no cosine, 0 below the horizon.

uniform vec3 brdf_kd;
uniform vec3 brdf_ks;
uniform float brdf_alpha_x;
uniform float brdf_alpha_y;

vec3 brdf(vec3 wi, vec3 wo)
{
    if (wi.z <= 0.0 || wo.z <= 0.0)
        return vec3(0.0);
    vec3 both = wi + wo;
    vec2 slope = both.xy / both.z;
    vec2 width = vec2(brdf_alpha_x, brdf_alpha_y);
    vec2 widths = slope / width;
    float falloff = exp(-dot(widths, widths));
    float spread = (dot(slope, slope) + 1.0) / (both.z * both.z);
    // far from the lobe 0 may meet an infinity
    float lobe = falloff > 0.0 ? falloff * spread * 0.31830988618379067 / (width.x * width.y) : 0.0;
    return brdf_kd * 0.31830988618379067 + brdf_ks * lobe;
}
