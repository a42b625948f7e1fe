#version 330 core
// Texels of a material in the light of a bake: L = B · T / T_0 (engine.render.shadowed).
// in: images of equal size, radiance times coverage, and coverage: T and T_0 with mip-maps, and B; out: the same, L.

uniform sampler2D texels;
uniform sampler2D plain;
uniform sampler2D baked;
uniform float least;
uniform float most;

const vec3 LUMINANCE = vec3(0.21263900587151036, 0.71516867876775593, 0.072192315360733714);
const float ALL = 32.0;

out vec4 radiance;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec3 without = texelFetch(plain, at, 0).rgb;
    vec3 below = max(without, least * dot(without, LUMINANCE));
    bvec3 known = greaterThan(below, vec3(0.0));
    vec3 share = mix(vec3(1.0), texelFetch(texels, at, 0).rgb / mix(vec3(1.0), below, known), known);
    vec4 light = texelFetch(baked, at, 0);
    float coverage = min(light.a, texelFetch(texels, at, 0).a);
    vec3 whole = textureLod(texels, vec2(0.5), ALL).rgb / max(textureLod(plain, vec2(0.5), ALL).rgb, 1e-30);
    vec3 direct = min(light.rgb, below);
    light.rgb = direct * share + min(share, most * whole) * (light.rgb - direct);
    radiance = light.a > 0.0 ? vec4(min(light.rgb * (coverage / light.a), 3.402823e38), coverage) : vec4(0.0);
}
