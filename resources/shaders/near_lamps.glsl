// Light near the model (engine.render.near_light has the formulas); with SHADOWS times the share that is seen of it.
// in: position relative to the mesh, frame, wo in that frame; out: radiance of facets of GGX over a diffuse part, or the
// points of each light for any other BRDF. Lights are rows of six texels: centre and shape (0 sphere, 1 rectangle,
// 2 disc), the two half sides with extent and radius, the direction faced, intensity, and radiance (0 of a point).
// Included after a BRDF, whose parameters FACETS_… names; PBR_MAPS are facets as well.

uniform sampler2D near_lamps;
uniform int near_count;
uniform int near_points;

const float NEAR_GOLDEN = 0.6180339887498949;
const int NEAR_CORNERS = 32;
const int NEAR_ON_HORIZON = 8;
const float NEAR_SMALL = 1e-3;
const float NEAR_PI = 3.14159265358979;

struct NearLamp {
    vec3 centre; // seen from the point that is lit
    int shape;
    mat2x3 sides;
    float extent;
    float radius;
    vec3 facing;
    vec3 intensity;
    vec3 radiance;
    vec3 axis; // of a sphere: unit, towards its centre
    float deficit; // of a sphere: one less the cosine of the angle in which it is seen
};

NearLamp near_lamp(int number, vec3 place)
{
    NearLamp lamp;
    vec4 one = texelFetch(near_lamps, ivec2(0, number), 0);
    vec4 two = texelFetch(near_lamps, ivec2(1, number), 0);
    vec4 three = texelFetch(near_lamps, ivec2(2, number), 0);
    lamp.centre = one.xyz - place;
    lamp.shape = int(one.w + 0.5);
    lamp.sides = mat2x3(two.xyz, three.xyz);
    lamp.extent = two.w;
    lamp.radius = three.w;
    lamp.facing = texelFetch(near_lamps, ivec2(3, number), 0).xyz;
    lamp.intensity = texelFetch(near_lamps, ivec2(4, number), 0).rgb;
    lamp.radiance = texelFetch(near_lamps, ivec2(5, number), 0).rgb;
    lamp.axis = safe_normalize(lamp.centre, vec3(0.0, 1.0, 0.0));
    lamp.deficit = 0.0;
    if (lamp.shape == 0 && lamp.radius > 0.0) {
        float sine = min(lamp.radius / max(length(lamp.centre), lamp.radius), 1.0);
        lamp.deficit = sine * sine / (1.0 + sqrt(max(1.0 - sine * sine, 0.0)));
    }
    return lamp;
}

int near_points_of(NearLamp lamp, int points)
{
    return lamp.extent > 0.0 ? points : 1;
}

// Point i of so many: the direction towards it in the world, and its irradiance.
void near_light(NearLamp lamp, int i, int count, out vec3 direction, out vec3 irradiance)
{
    float part = (float(i) + 0.5) / float(count);
    float turn = fract(float(i) * NEAR_GOLDEN);
    float angle = 2.0 * NEAR_PI * turn;
    vec2 inside = sqrt(part) * vec2(cos(angle), sin(angle));
    if (lamp.shape == 0 && lamp.extent > 0.0) {
        float lower = part * lamp.deficit;
        float scale = sqrt(max(lamp.deficit * (2.0 - lower), 0.0));
        direction = world_from_tangent(lamp.axis) * vec3(inside * scale, 1.0 - lower);
        irradiance = lamp.radiance * (2.0 * NEAR_PI / float(count) * lamp.deficit);
        return;
    }
    if (lamp.shape == 1)
        inside = vec2(2.0 * part, 2.0 * fract(turn + 0.5)) - 1.0;
    vec3 offset = lamp.centre + (lamp.extent > 0.0 ? lamp.sides * inside : vec3(0.0));
    float squared = dot(offset, offset);
    direction = safe_normalize(offset, vec3(0.0));
    float share = squared > 0.0 ? 1.0 / (float(count) * squared) : 0.0;
    if (lamp.shape != 0)
        share *= max(-dot(direction, lamp.facing), 0.0);
    irradiance = share * lamp.intensity;
}

#if defined(FACETS)
// Parameters of the facets, which near_facets() fills in.
vec3 facet_diffuse;
vec3 facet_f0;
vec2 facet_alpha;
float facet_length;
float facet_again;

void near_facets()
{
    facet_length = 1.0;
    facet_again = 0.0;
#if defined(PBR_MAPS)
    float metallic = gloss_here.y;
    float roughness = max(gloss_here.x, pbr_smoothest);
    vec2 wide = vec2(roughness * roughness * roughness * roughness) + 2.0 * spread_here.xy;
    float slanted = clamp(1.0 - 4.0 * spread_here.z * spread_here.z / (wide.x * wide.y), 1e-6, 1.0);
    facet_diffuse = (1.0 - metallic) * base_here;
    facet_f0 = gloss_here.z * (1.0 - metallic) + base_here * metallic;
    facet_alpha = min(sqrt(wide) * sqrt(sqrt(slanted)), 1.0);
    facet_length = length_here;
#if !defined(SINGLE_SCATTERING)
    facet_again = 1.0;
#endif
#elif defined(FACETS_LAMBERT)
    facet_diffuse = brdf_albedo;
    facet_f0 = vec3(0.0);
    facet_alpha = vec2(1.0);
#elif defined(FACETS_METALLIC_ROUGHNESS)
    float roughness = max(brdf_roughness, 0.02);
    facet_diffuse = (1.0 - brdf_metallic) * brdf_base_color;
    facet_f0 = 0.04 + (brdf_base_color - 0.04) * brdf_metallic;
    facet_alpha = vec2(roughness * roughness);
    facet_again = brdf_multiple_scattering;
#else
    facet_diffuse = brdf_kd;
    facet_f0 = brdf_f0;
#if defined(FACETS_GGX)
    facet_alpha = vec2(brdf_alpha);
#else
    facet_alpha = vec2(brdf_alpha_x, brdf_alpha_y);
#endif
#endif
}

float near_slope_length(vec3 direction)
{
    vec2 across = facet_alpha * direction.xy;
    return sqrt(direction.z * direction.z + dot(across, across));
}

// f cos as factors times lobes: what is diffuse times the cosine, and W times D cos(theta_h) / (4 h.o).
void near_split(vec3 wi, vec3 wo, out vec3 factors[2], out vec2 densities)
{
    vec3 both = wi + wo;
    float size = max(length(both), 1e-6);
    vec3 h = both / size;
    float grazing = clamp(1.0 - 0.5 * size, 0.0, 1.0);
    float squared = grazing * grazing;
    vec3 fresnel = facet_f0 + (1.0 - facet_f0) * (squared * squared * grazing);
    factors[0] = facet_diffuse / NEAR_PI;
#if defined(PBR_MAPS) || defined(FACETS_METALLIC_ROUGHNESS)
    factors[0] *= 1.0 - fresnel;
    float shadowing = (wi.z + near_slope_length(wi)) * (wo.z + near_slope_length(wo));
#else
    float shadowing = 2.0 * (wi.z * near_slope_length(wo) + wo.z * near_slope_length(wi));
#endif
#if defined(PBR_MAPS) || defined(FACETS_METALLIC_ROUGHNESS)
    if (facet_again > 0.0)
        factors[0] += facet_again * multiple_scattering(wi.z, wo.z, facet_alpha.x, facet_f0);
#endif
    factors[0] *= facet_length;
#if defined(FACETS_LAMBERT)
    factors[1] = vec3(0.0);
#else
    factors[1] = fresnel * (2.0 * size * wi.z / (max(h.z, 1e-6) * shadowing));
#endif
    vec3 scaled = vec3(h.xy / facet_alpha, h.z);
    float whole = dot(scaled, scaled);
    densities = vec2(wi.z, h.z / (2.0 * NEAR_PI * size * facet_alpha.x * facet_alpha.y * whole * whole));
#if defined(PBR_MAPS)
    if (spread_here.x + spread_here.y > ALIKE)
        factors[1] = fresnel * (spread_lobe(wi, wo, h) / max(densities.y, 1e-30));
#endif
}

vec3 near_direction; // of a corner, and of its half vector over the widths of facets
vec3 near_half;
vec3 near_cosine_sum; // the angles of edges times their unit normals, of directions and of half vectors
vec3 near_facet_sum;

void near_put(vec3 corner, vec3 wo)
{
    near_direction = safe_normalize(corner, vec3(0.0, 0.0, 1.0));
    near_half = near_direction + wo;
    near_half = normalize(vec3(near_half.xy / facet_alpha, near_half.z));
}

// The angle between two unit vectors times the unit normal of both: polynomials for the angle over its sine (Heitz2016).
vec3 near_edge(vec3 one, vec3 two)
{
    float x = dot(one, two);
    float y = abs(x);
    float a = 0.8543985 + (0.4965155 + 0.0145206 * y) * y;
    float b = 3.4175940 + (4.1616724 + y) * y;
    float v = 2.0 * NEAR_PI * a / b;
    return cross(one, two - one) * (x > 0.0 ? v : NEAR_PI * inversesqrt(max(1.0 - x * x, 1e-7)) - v);
}

// Add the edge from a corner to the one that near_put was given last.
void near_add_edge(vec3 direction, vec3 half_vector)
{
    near_cosine_sum += near_edge(direction, near_direction);
    near_facet_sum += near_edge(half_vector, near_half);
}

// The sums over the edges of the polygon of a lamp. It is convex: it meets the horizon where it leaves and where it
// enters, and between them has an edge along the horizon.
void near_polygon(int shape, vec3 centre, mat2x3 sides, vec3 wo)
{
    near_cosine_sum = near_facet_sum = vec3(0.0);
    float turn = 2.0 * NEAR_PI / float(NEAR_CORNERS);
    mat2 rotation = mat2(cos(turn), sin(turn), -sin(turn), cos(turn));
    vec2 at = shape == 1 ? vec2(-1.0) : vec2(sqrt(turn / sin(turn)), 0.0);
    vec2 step = vec2(8.0 / float(NEAR_CORNERS), 0.0);
    bool is_cut = false;
    vec3 leaves = vec3(0.0), enters = vec3(0.0), before = centre + sides * at;
    near_put(before, wo);
    vec3 direction = near_direction, half_vector = near_half;
    for (int k = 1; k <= NEAR_CORNERS; ++k) {
        if (shape == 1) {
            at += step;
            if (k % (NEAR_CORNERS / 4) == 0)
                step = vec2(-step.y, step.x);
        } else {
            at = rotation * at;
        }
        vec3 corner = centre + sides * at;
        if ((before.z > 0.0) != (corner.z > 0.0)) {
            vec3 cut = before + before.z / (before.z - corner.z) * (corner - before);
            cut.z = 0.0;
            is_cut = true;
            near_put(cut, wo);
            if (corner.z > 0.0) {
                enters = cut;
                direction = near_direction;
                half_vector = near_half;
            } else {
                leaves = cut;
                near_add_edge(direction, half_vector);
            }
        }
        if (corner.z > 0.0) {
            near_put(corner, wo);
            near_add_edge(direction, half_vector);
            direction = near_direction;
            half_vector = near_half;
        }
        before = corner;
    }
    if (!is_cut)
        return;
    near_put(leaves, wo);
    for (int k = 1; k <= NEAR_ON_HORIZON; ++k) {
        direction = near_direction;
        half_vector = near_half;
        near_put(mix(leaves, enters, float(k) / float(NEAR_ON_HORIZON)), wo);
        near_add_edge(direction, half_vector);
    }
}

const int NEAR_FACET_POINTS = 16;

vec3 near_radiance(vec3 place, mat3 frame, vec3 wo)
{
    near_facets();
    vec3 total = vec3(0.0);
    for (int number = 0; number < near_count; ++number) {
        NearLamp lamp = near_lamp(number, place);
        if (lamp.shape != 0 && dot(lamp.centre, lamp.facing) >= 0.0)
            continue;
#if defined(SHADOWS)
        float lit = lit_by_near(number, place, shadow_normal);
        if (lit == 0.0)
            continue;
#else
        const float lit = 1.0;
#endif
        vec3 sums[2];
        sums[0] = sums[1] = vec3(0.0);
        vec2 lobes = vec2(0.0);
        vec3 factors[2];
        vec2 densities;
        int count = near_points_of(lamp, NEAR_FACET_POINTS);
        for (int i = 0; i < count; ++i) {
            vec3 direction, irradiance;
            near_light(lamp, i, count, direction, irradiance);
            vec3 wi = direction * frame;
            if (wi.z <= 0.0)
                continue;
            near_split(wi, wo, factors, densities);
            sums[0] += factors[0] * (densities.x * irradiance);
            sums[1] += factors[1] * (densities.y * irradiance);
            lobes += densities * max(irradiance.r, max(irradiance.g, irradiance.b));
        }
        float distance = length(lamp.centre);
        if (!(lamp.extent > NEAR_SMALL * distance)) {
            total += lit * (sums[0] + sums[1]);
            continue;
        }
        vec3 centre = lamp.centre;
        mat2x3 sides = lamp.sides;
        if (lamp.shape == 0) {
            float sine = min(lamp.radius / max(distance, lamp.radius), 0.99999);
            mat3 about = world_from_tangent(lamp.axis);
            centre = lamp.axis;
            sides = mat2x3(about[0], about[1]) * (sine / sqrt(1.0 - sine * sine));
        }
        near_polygon(lamp.shape, centre * frame, mat2x3(sides[0] * frame, sides[1] * frame), wo);
        float brightest = max(lamp.radiance.r, max(lamp.radiance.g, lamp.radiance.b));
        vec3 colour = brightest > 0.0 ? lamp.radiance / brightest : vec3(0.0);
        for (int k = 0; k < 2; ++k) {
            vec3 vector = k == 0 ? near_cosine_sum : near_facet_sum;
            vector *= vector.z < 0.0 ? -1.0 : 1.0;
            float wanted = vector.z * (k == 0 ? 0.5 : 0.5 / NEAR_PI) * brightest;
            float known = k == 0 ? lobes.x : lobes.y;
            if (known > 0.0)
                total += lit * sums[k] * (min(wanted, known) / known);
            if (wanted <= known)
                continue;
            vec3 middle = safe_normalize(vector, vec3(0.0, 0.0, 1.0));
            if (k == 1) {
                vec3 h = safe_normalize(vec3(vector.xy * facet_alpha, vector.z), vec3(0.0, 0.0, 1.0));
                middle = 2.0 * dot(h, wo) * h - wo;
            }
            if (middle.z > 0.0) {
                near_split(middle, wo, factors, densities);
                total += lit * factors[k] * ((wanted - known) * colour);
            }
        }
    }
    return total;
}
#endif
