// Local frames.
// in: unit normal in the world; out: columns tangent, bitangent, normal (Wang et al. 2004, section 3.1, in the form
// of engine.core.directions.world_from_tangent, which is stable at its singularity n = (0, -1, 0)).

mat3 world_from_tangent(vec3 n)
{
    float across = n.x * n.x + n.z * n.z;
    if (across == 0.0 && n.y < 0.0)
        return mat3(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0);
    float scale = 1.0 / (n.y < 0.0 ? across / (1.0 - n.y) : 1.0 + n.y);
    vec3 tangent = vec3(1.0 - n.x * n.x * scale, -n.x, -n.x * n.z * scale);
    vec3 bitangent = vec3(n.x * n.z * scale, n.z, n.z * n.z * scale - 1.0);
    return mat3(tangent, bitangent, n);
}

// The frame whose tangent is a direction of any length, projected into the surface; world_from_tangent where that
// leaves nothing (engine.core.directions.frames_along).
mat3 frame_along(vec3 n, vec3 direction)
{
    vec3 inside = direction - dot(n, direction) * n;
    float squared = dot(inside, inside);
    if (!(squared > 1e-12 * dot(direction, direction)))
        return world_from_tangent(n);
    vec3 tangent = inside * inversesqrt(squared);
    return mat3(tangent, cross(n, tangent), n);
}

// Unit vector, or the fallback where the length is 0 or not finite.
vec3 safe_normalize(vec3 v, vec3 fallback)
{
    float squared = dot(v, v);
    return squared > 0.0 && squared < 3.4e38 ? v * inversesqrt(squared) : fallback;
}
