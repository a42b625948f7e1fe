// What several models share. Directions are unit vectors; both = wi + wo. No units.

// in: directions and |wi + wo|; out: (1 - h.wi)^5. 1 - h.wi is |wi - wo|^2 / (2 (2 + |wi + wo|)), exact at both ends.
float schlick(vec3 wi, vec3 wo, float size)
{
    vec3 difference = wi - wo;
    float grazing = min(dot(difference, difference) / (2.0 * (2.0 + size)), 1.0);
    float grazing2 = grazing * grazing;
    return grazing2 * grazing2 * grazing;
}

// in: wi + wo and its length; out: 1 - n.h, without cancellation.
float half_deficit(vec3 both, float size)
{
    return dot(both.xy, both.xy) / (size * (size + both.z));
}
