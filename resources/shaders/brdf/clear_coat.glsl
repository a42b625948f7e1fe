// A clear coat as glTF defines it (engine.brdf.models.clear_coat has the formulas and their source).

#include "brdf/multiple_scattering.glsl"

uniform float brdf_coat_weight;
uniform float brdf_coat_roughness;

const float COAT_SMOOTHEST = 0.02;

// in: the cosine between the normal of the coat and the viewer; out: the share of the mixture that is coat.
float coat_share(float cosine_o)
{
    float grazing = clamp(1.0 - cosine_o, 0.0, 1.0);
    float grazing2 = grazing * grazing;
    return brdf_coat_weight * (0.04 + 0.96 * grazing2 * grazing2 * grazing);
}

float coat_smith(float cosine, float alpha2)
{
    return cosine + sqrt(alpha2 + (1.0 - alpha2) * cosine * cosine);
}

// in: cosines above the horizon, sin^2 of the half vector, and the share of light scattered again between facets;
// out: D G / (4 n.l n.v) in 1/sr.
float coat_lobe(float cosine_i, float cosine_o, float sine2, float again)
{
    float roughness = max(brdf_coat_roughness, COAT_SMOOTHEST);
    float alpha = roughness * roughness;
    float alpha2 = alpha * alpha;
    float width = sine2 + alpha2 * (1.0 - sine2);
    float lobe = alpha2 * 0.31830988618379067 / (width * width);
    lobe /= coat_smith(cosine_i, alpha2) * coat_smith(cosine_o, alpha2);
#if !defined(SINGLE_SCATTERING)
    if (again > 0.0)
        lobe += again * multiple_scattering(cosine_i, cosine_o, alpha, vec3(1.0)).x;
#endif
    return lobe;
}
