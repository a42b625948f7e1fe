// The table of the light that shows a texel from above as it is seen (engine.shading.directional.effective_light).
// in: share of f cos(theta) in its largest value from above, azimuth over a whole turn; out: the cosine of that light.

uniform sampler2D cosine_powers;
uniform float lowest_power;

float effective_cosine(float share, float turn)
{
    if (!(share > exp2(lowest_power)))
        return 0.0;
    ivec2 size = textureSize(cosine_powers, 0);
    float place = (1.0 - log2(min(share, 1.0)) / lowest_power) * float(size.x - 1);
    vec2 at = vec2((place + 0.5) / float(size.x), turn + 0.5 / float(size.y));
    return exp2(textureLod(cosine_powers, at, 0.0).r);
}
