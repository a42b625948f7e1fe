// The base of Lafortune's lobes.
// in: directions, and weights of which one is not 0; m = max(|cxy|, |cz|).
// out: 1 - (cxy (wi.x wo.x + wi.y wo.y) + cz wi.z wo.z) / m. No units. Directions are unit vectors, so this is
// half of the sum over the axes of p^2 + q^2 - 2 w p q / m = (|w| (p -+ q)^2 + (m - |w|)(p^2 + q^2)) / m.

float lobe_deficit(vec3 wi, vec3 wo, float cxy, float cz, float m)
{
    vec3 weight = vec3(cxy, cxy, cz);
    vec3 size = abs(weight);
    vec3 difference = wi - sign(weight) * wo;
    return 0.5 * dot(size * difference * difference + (m - size) * (wi * wi + wo * wo), vec3(1.0)) / m;
}
