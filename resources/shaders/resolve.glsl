// The mean of the sub-pixels of a pixel: radiance times coverage, and coverage.

uniform sampler2D radiance_map;
uniform ivec2 first_pixel;
uniform int samples;

vec4 resolved()
{
    vec4 sum = vec4(0.0);
    ivec2 corner = (ivec2(gl_FragCoord.xy) - first_pixel) * samples;
    for (int y = 0; y < samples; ++y)
        for (int x = 0; x < samples; ++x) {
            vec4 texel = texelFetch(radiance_map, corner + ivec2(x, y), 0);
            sum += vec4(texel.rgb, min(texel.a, 1.0));
        }
    return sum / float(samples * samples);
}
