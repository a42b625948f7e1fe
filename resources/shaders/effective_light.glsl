// The light that, seen from above, shows a texel as it is seen (engine.shading.directional.effective_light), searched
// with the BRDF itself where no table of it is at hand.
// in: brdf() and LUMINANCE; the direction to the light in the local frame, and the f cos(theta) that is wanted;
// out: the cosine of the lowest light of equal azimuth that gives it from above; 1 where none does.

float product_from_above(float tilt, vec2 heading)
{
    vec3 light = vec3(sin(tilt) * heading.x, sin(tilt) * heading.y, cos(tilt));
    return dot(brdf(light, vec3(0.0, 0.0, 1.0)), LUMINANCE) * light.z;
}

float searched_cosine(vec3 wi, float product)
{
    if (!(product > 0.0))
        return 0.0;
    const float STEP = 1.57079632679489662 / 48.0;
    vec2 heading = dot(wi.xy, wi.xy) > 0.0 ? normalize(wi.xy) : vec2(1.0, 0.0);
    float below = 48.0 * STEP, reached = 0.0;
    for (int i = 47; i >= 0; --i) {
        float tilt = float(i) * STEP;
        if (product_from_above(tilt, heading) >= product) {
            reached = tilt;
            break;
        }
        below = tilt;
    }
    for (int i = 0; i < 12; ++i) {
        float middle = 0.5 * (below + reached);
        if (product_from_above(middle, heading) >= product)
            reached = middle;
        else
            below = middle;
    }
    return cos(reached);
}
