// A cube map under spherical Gaussians of rising width (engine.light.gaussian_prefilter).
// in: direction of any length but 0 in the map's axes, logarithm of sigma in rad; out: mean radiance under the Gaussian.
// The six faces are layers, and on each the levels lie below one another: the corner nodes of a level lie on the edges
// of its face, so that a look-up never leaves it.

uniform sampler2DArray filtered;
uniform vec4 levels[MAX_LEVELS];    // sigma, its logarithm, cells along an edge, first line
uniform int last_level;
uniform float levels_per_log;
uniform vec2 filtered_texel;    // 1 / size
uniform vec3 filtered_mean;

vec3 level_value(vec4 level, vec3 place)
{
    vec2 texel = place.xy * level.z + vec2(0.5, 0.5 + level.w);
    return textureLod(filtered, vec3(texel * filtered_texel, place.z), 0.0).rgb;
}

// Coordinates on a face in [0, 1], and its number.
vec3 on_face(vec3 d)
{
    vec3 a = abs(d);
    vec3 place;
    if (a.x >= a.y && a.x >= a.z)
        place = vec3(d.x >= 0.0 ? -d.z : d.z, -d.y, d.x >= 0.0 ? 0.0 : 1.0);
    else if (a.y >= a.z)
        place = vec3(d.x, d.y >= 0.0 ? d.z : -d.z, d.y >= 0.0 ? 2.0 : 3.0);
    else
        place = vec3(d.z >= 0.0 ? d.x : -d.x, -d.y, d.z >= 0.0 ? 4.0 : 5.0);
    float longest = max(a.x, max(a.y, a.z));
    return vec3(clamp(0.5 + 0.5 * place.xy / longest, 0.0, 1.0), place.z);
}

// Between two levels the height is that of the Gaussian asked for, which is linear in 1 / sigma²; beyond the last one,
// the mean over the sphere takes over. Where levels are evenly spaced (but for rounding, which the limits of the share
// take up) the one below is known, and searching costs as much as the look-up.
vec3 mean_under(vec3 d, float log_sigma)
{
    vec3 place = on_face(d);
    int low = clamp(int((log_sigma - levels[0].y) * levels_per_log), 0, last_level - 1);
#if defined(UNEVEN)
    while (low < last_level - 1 && log_sigma >= levels[low + 1].y)
        ++low;
    while (low > 0 && log_sigma < levels[low].y)
        --low;
#endif
    vec4 below = levels[low];
    vec4 above = levels[low + 1];
    float inverse = exp(-2.0 * log_sigma);
    float share = (1.0 - below.x * below.x * inverse) * above.x * above.x / ((above.x - below.x) * (above.x + below.x));
    vec3 value = mix(level_value(below, place), level_value(above, place), clamp(share, 0.0, 1.0));
    float last = levels[last_level].x;
    return mix(filtered_mean, value, min(last * last * inverse, 1.0));
}
