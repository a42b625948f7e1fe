const DECODE = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D high, low;
uniform float largest;
out vec4 value;
void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  vec3 code = 255.0 * (256.0 * texelFetch(high, texel, 0).rgb + texelFetch(low, texel, 0).rgb);
  value = vec4(largest * code / 65535.0, 1.0);
}`;

// One layer of an array of maps: values are lowest + width code, of the rows from `first` on in two pictures.
const DECODE_LAYER = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D high, low;
uniform float lowest, width;
uniform int first;
out vec4 value;
void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy) + ivec2(0, first);
  vec3 code = 255.0 * (256.0 * texelFetch(high, texel, 0).rgb + texelFetch(low, texel, 0).rgb);
  value = vec4(lowest + width * code, 1.0);
}`;

// A picture of 8 bits of a tile: codes of sRGB of the largest value, or where `lowest` is above 0 the logarithm between
// the two (engine.bundle.pyramid).
const DECODE_TILE = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D codes;
uniform float lowest, largest;
out vec4 value;
void main() {
  vec3 code = texelFetch(codes, ivec2(gl_FragCoord.xy), 0).rgb;
  vec3 linear = mix(pow((max(code, 0.04045) + 0.055) / 1.055, vec3(2.4)), code / 12.92,
    lessThanEqual(code, vec3(0.04045)));
  vec3 power = lowest * pow(vec3(largest / max(lowest, 1e-9)), (255.0 * code - 1.0) / 254.0);
  value = vec4(lowest > 0.0 ? mix(power, vec3(0.0), lessThan(code, vec3(0.5 / 255.0))) : largest * linear, 1.0);
}`;

const SCREEN = `#version 300 es
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}`;

const LUMINANCE = "const vec3 LUMINANCE = vec3(0.21263900587151036, 0.71516867876775593, 0.072192315360733714);\n";

// Once per vertex: sigma such that the largest r over the lights of the capture, seen from above, is r_max.
const vertexSource = (model) => `#version 300 es
${model.glsl}
${LUMINANCE}
uniform float fixed_sigma, r_max;
uniform vec3 arc[64];
uniform int arc_count;
flat out float sigma, above;
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
  float largest = 0.0;
  for (int i = 0; i < arc_count; ++i)
    largest = max(largest, dot(brdf(arc[i], vec3(0.0, 0.0, 1.0)), LUMINANCE) * arc[i].z);
  above = largest;
  sigma = fixed_sigma > 0.0 ? fixed_sigma : largest > 0.0 ? r_max / largest : 1.0;
}`;

// The shading map, or planes that are looked up by the light that gives the same product from above.
const lookUp = () => data.planes ? `
#define HEX_TILING
#define HEX_MEANS
#define PLANE_LAYERS ${data.planes.layers.length}
precision highp sampler2DArray;
${data.sources.shading_map}
${data.sources.directional}
${data.sources.effective_light}
vec3 looked_up(vec3 wi, float r, vec2 heading, vec2 uv) {
  fetch_planes(uv);
  return directional_map(searched_cosine(wi, r / r_max * above), turn_of(heading));
}` : `
#define HEX_TILING
#define HEX_MEANS
#define SOURCE_POWER_LAW
precision highp sampler2DArray;
${data.sources.shading_map}
vec3 looked_up(vec3 wi, float r, vec2 heading, vec2 uv) { return shading_map(r / r_max, uv); }`;

// Numbers of channels in the shader, by their names in the data of the page.
const CHANNELS = {
  picture: 0, brightest: 1, exponent: 2, base_colour: 3, normal: 4, roughness: 5, metallic: 6, occlusion: 7,
  relief: 8, enhanced: 9,
};

// Channels of the look-up itself: linear radiance, and an exponent K as K / (1 + K), the reflectance of a grey.
const ofLookUp = () => data.planes ? "radiance(position, n, right, uv)" :
  "channel == 1 ? scale_at(uv, detail) : channel == 2 ? exponent_at(uv, detail) / " +
  "(1.0 + exponent_at(uv, detail)) : radiance(position, n, right, uv)";

// Channels of the surface: base colour in codes of sRGB, normals, and roughness, metallic and occlusion, each a layer.
const SURFACE = `
precision highp sampler2DArray;
uniform sampler2DArray surface;
uniform float strength, sharpness;

vec3 of_surface(vec3 position, vec3 n, vec3 right, vec2 uv) {
  float detail = level_of_detail(uv, textureSize(surface, 0).xy);
  vec3 base = srgb_decode(blended_layer(surface, 0.0, detail)), code = blended_layer(surface, 1.0, detail);
  vec3 others = min(blended_layer(surface, 2.0, detail), 1.0);
  if (channel == ${CHANNELS.base_colour}) return base;
  if (channel == ${CHANNELS.normal}) return srgb_decode(code);
  if (channel < ${CHANNELS.relief}) return srgb_decode(vec3(others[channel - ${CHANNELS.roughness}]));
  vec3 local = safe_normalize(code * 255.0 / 127.0 - 128.0 / 127.0, vec3(0.0, 0.0, 1.0));
  vec3 normal = mat3(right, cross(n, right), n) * local;
  float facing = max(dot(normal, light), 0.0);
  if (channel == ${CHANNELS.relief}) return vec3(0.8 * facing);
  vec3 half_way = normalize(light + normalize(vec3(0.0, 0.0, 3.0) - position));
  float seen = min(16.0 * dot(base, LUMINANCE), 1.0);  // what is black in all photographs shows no slope
  return (1.0 - strength) * base * facing + strength * seen * pow(max(dot(normal, half_way), 0.0), sharpness);
}`;

// A plane and a sphere seen from a distance of 3; the plane is 2 high, the sphere has the radius 1. The picture shows
// what lies around `centre`, up to `span` above and below it. A tile covers a part of the texture coordinates (its corner
// and size), which lies at `inner` in pictures of its own.
const fragmentSource = (model) => `#version 300 es
precision highp float;
precision highp sampler2D;
${data.sources.frame}
${model.glsl}
${LUMINANCE}
uniform vec2 half_picture, half_plane, centre;
uniform vec3 light;
uniform float r_max, gain, repeats, span;
uniform bool sphere, neutral_curve;
uniform int channel;
uniform bool is_tile;
uniform vec4 part, inner;
flat in float sigma, above;
${lookUp()}
out vec4 colour;
const float PI = 3.14159265358979;

vec3 neutral(vec3 c) {
  const float start = 0.8 - 0.04;
  float low = min(c.r, min(c.g, c.b));
  c -= low < 0.08 ? low - 6.25 * low * low : 0.04;
  float peak = max(c.r, max(c.g, c.b));
  if (peak < start) return c;
  float compressed = 1.0 - (1.0 - start) * (1.0 - start) / (peak + 1.0 - 2.0 * start);
  return mix(c * (compressed / peak), vec3(compressed), 1.0 - 1.0 / (0.15 * (peak - compressed) + 1.0));
}

vec3 srgb_encode(vec3 c) {
  return mix(1.055 * pow(max(c, 0.0031308), vec3(1.0 / 2.4)) - 0.055, c * 12.92, lessThanEqual(c, vec3(0.0031308)));
}

vec3 srgb_decode(vec3 c) {
  return mix(pow((max(c, 0.04045) + 0.055) / 1.055, vec3(2.4)), c / 12.92, lessThanEqual(c, vec3(0.04045)));
}
${data.surface ? SURFACE : ""}
${data.cover ? "precision highp sampler2DArray;\nuniform sampler2DArray cover;" : ""}
// The texture runs along right, perpendicular to n.
vec3 radiance(vec3 position, vec3 n, vec3 right, vec2 uv) {
  mat3 frame = world_from_tangent(n);
  vec3 wi = light * frame;
  vec3 wo = normalize(vec3(0.0, 0.0, 3.0) - position) * frame;
  vec2 heading = vec2(dot(light, right), dot(light, cross(n, right)));
  return looked_up(wi, sigma * dot(brdf(wi, wo), LUMINANCE) * max(wi.z, 0.0), heading, uv);
}

void main() {
  vec2 at = (gl_FragCoord.xy / half_picture.xy - 1.0) * half_picture / half_picture.y;
  vec3 position = vec3(centre + at * span, 0.0), n = vec3(0.0, 0.0, 1.0), right = vec3(1.0, 0.0, 0.0);
  float edge = span / half_picture.y, coverage;
  vec2 uv;
  if (sphere) {
    vec3 ray = normalize(position - vec3(0.0, 0.0, 3.0));
    float along = -3.0 * ray.z, inside = along * along - 8.0;
    coverage = clamp(inside / max(fwidth(inside), 1e-9) + 0.5, 0.0, 1.0);
    position = n = normalize(vec3(0.0, 0.0, 3.0) + (along - sqrt(max(inside, 0.0))) * ray);
    right = safe_normalize(vec3(n.z, 0.0, -n.x), right);
    uv = 0.5 + repeats * vec2(atan(n.x, n.z) * half_plane.y / half_plane.x, -asin(clamp(n.y, -1.0, 1.0))) / PI;
  } else {
    vec2 beyond = (half_plane - abs(position.xy)) / edge + 0.5;
    coverage = clamp(beyond.x, 0.0, 1.0) * clamp(beyond.y, 0.0, 1.0);
    uv = 0.5 + repeats * position.xy / half_plane * vec2(0.5, -0.5);
  }
  ${data.cover ? "coverage *= texture(cover, vec3(uv, 0.0)).r;" : ""}
  bool is_outside = false;
  if (is_tile) {
    vec2 share = (uv - part.xy) / part.zw;
    is_outside = any(lessThan(share, vec2(0.0))) || any(greaterThanEqual(share, vec2(1.0)));
    uv = inner.xy + share * inner.zw;
  }
  ivec2 texels = ${data.planes ? "textureSize(planes, 0).xy" : "textureSize(scale_map, 0)"};
  float detail = level_of_detail(uv, texels);
  begin_cells(uv, texels);
  vec3 value = max(${data.surface ? "channel > 2 ? of_surface(position, n, right, uv) : " : ""}${ofLookUp()}, 0.0);
  if (channel == 0 || channel == ${CHANNELS.enhanced}) {
    value *= gain;
    value = neutral_curve ? neutral(value) : value;
  }
  value = clamp(value, 0.0, 1.0);
  const vec3 background = vec3(0.0091340587);
  colour = vec4(srgb_encode(mix(background, value, coverage)), 1.0);
  if (is_outside) discard;  // last, for filters need the neighbours until here
}`;

