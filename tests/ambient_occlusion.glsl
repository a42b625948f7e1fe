// One radiance for each vertex, the same towards every side (tests.ambient_occlusion).
#if defined(VERTEX)
vec3 flat_radiance(int number)
{
    return row(number);
}

vec3 radiance_of(int vertex, vec3 wo)
{
    return row(vertex);
}
#endif
