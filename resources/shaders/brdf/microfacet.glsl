// GGX: the distribution and Smith's term. alpha holds the widths along tangent and bitangent. No units.

// out: sqrt(cos^2 + alpha_x^2 x^2 + alpha_y^2 y^2).
float ggx_slope_length(vec3 direction, vec2 alpha)
{
    vec2 across = alpha * direction.xy;
    return sqrt(direction.z * direction.z + dot(across, across));
}

// in: the unit half vector; out: 1 / (pi ax ay (hx^2/ax^2 + hy^2/ay^2 + hz^2)^2), in 1/sr.
float ggx_distribution(vec3 h, vec2 alpha)
{
    float product = alpha.x * alpha.y;
    float width = h.x * h.x * (alpha.y / alpha.x) + h.y * h.y * (alpha.x / alpha.y) + h.z * h.z * product;
    return product * 0.31830988618379067 / (width * width);
}
