// Light that facets of GGX scatter more than once (engine.brdf.models.multiple_scattering has the formulas and the fit).

// in: cosine, width and its root; out: 1 - E, the share of light that one reflection of white facets loses.
float facet_loss(float cosine, float alpha, float root)
{
    float s = cosine / (cosine + alpha);
    float r = root;
    float five = ((((170.569 * r + 43.018) * r - 94.766) * r + 43.709) * r) - 15.464;
    float four = ((((-1.991 * r - 400.0) * r + 350.285) * r - 115.584) * r) + 23.078;
    float three = ((((-126.242 * r + 400.0) * r - 284.447) * r + 79.890) * r) - 9.349;
    float two = ((((25.925 * r - 62.622) * r + 37.538) * r - 8.421) * r) + 1.211;
    float one = ((((-0.758 * r + 0.468) * r + 3.963) * r - 2.409) * r) + 0.581;
    float none = ((((-0.899 * r + 2.287) * r - 1.475) * r + 0.456) * r) + 0.010;
    float value = ((((five * s + four) * s + three) * s + two) * s + one) * s + none;
    return max((1.0 - s) * (1.0 - s) * value, 0.0);
}

// in: cosines to the light and the viewer, width, and reflectance at normal incidence; out: 1/sr, no cosine.
vec3 multiple_scattering(float cosine_i, float cosine_o, float alpha, vec3 f0)
{
    float r = sqrt(alpha);
    float mean = 0.9378 + (11.7371 + (-52.2862 + (105.2860 + (-119.4194 + (72.3249 - 17.9577 * r) * r) * r) * r) * r) * r;
    float lost = alpha * alpha * (mean - 0.6869 * log(r));
    vec3 fresnel = f0 + (1.0 - f0) / 21.0;
    vec3 again = fresnel * fresnel * (1.0 - lost) / (1.0 - fresnel * lost);
    return again * (facet_loss(cosine_i, alpha, r) * facet_loss(cosine_o, alpha, r) * 0.31830988618379067 / lost);
}
