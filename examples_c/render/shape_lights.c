/* The lights of an emitting shape: a parallelogram per quad, a triangle per face of a mesh, or a sphere. */
#include "reader.h"

static vec3d corner(const shape *s, uint32_t triangle, int i)
{
    return vec3d_load(s->positions + 3 * (size_t)s->triangles[3 * (size_t)triangle + i]);
}

/* Of a quad's two triangles a b c and a c d: a, b - a and d - a; of a single triangle: a, b - a and c - a. */
static volgrad_light flat_light(const shape *s, uint32_t first_triangle)
{
    int is_quad = s->primitives_per_light == 2;
    vec3d a = corner(s, first_triangle, 0), b = corner(s, first_triangle, 1),
          last = corner(s, first_triangle + (is_quad ? 1 : 0), 2);
    volgrad_light light = {.kind = is_quad ? VOLGRAD_LIGHT_PARALLELOGRAM : VOLGRAD_LIGHT_TRIANGLE};
    light.position = vec3d_round(a);
    light.edge_u = vec3d_round(vec3d_difference(b, a));
    light.edge_v = vec3d_round(vec3d_difference(last, a));
    return light;
}

/* Up to a factor that is the same for all lights of one shape. */
static double relative_area(const volgrad_light *light)
{
    return vec3d_length(vec3d_cross(vec3d_from(light->edge_u), vec3d_from(light->edge_v)));
}

static double whole_area(const shape *s)
{
    double area = 0;
    for (uint32_t t = 0; t < s->triangle_count; t += s->primitives_per_light) {
        volgrad_light light = flat_light(s, t);
        area += relative_area(&light);
    }
    return area;
}

/* The shape is picked with its sampling weight and a point on it by area, as in Mitsuba: so the lights share the weight by area.
 */
static void add_flat_lights(reader *r, const xml_node *node, const shape *s, area_emission emission)
{
    double area = whole_area(s);
    for (uint32_t t = 0; t < s->triangle_count; t += s->primitives_per_light) {
        volgrad_light light = flat_light(s, t);
        light.emission = emission.radiance;
        light.sampling_weight = (float)(emission.sampling_weight * (relative_area(&light) / area));
        if (reader_add_light(r, node, &light) == VOLGRAD_NONE) {
            return;
        }
    }
}

static void add_sphere_light(reader *r, const xml_node *node, const shape *s, area_emission emission)
{
    volgrad_light light = {
        .kind = VOLGRAD_LIGHT_SPHERE, .emission = emission.radiance, .position = s->center, .radius = s->radius};
    light.sampling_weight = (float)emission.sampling_weight;
    reader_add_light(r, node, &light);
}

void reader_shape_lights(reader *r, const xml_node *node, shape *s, area_emission emission)
{
    s->first_light = r->scene->desc.light_count;
    if (s->kind == SHAPE_SPHERE) {
        add_sphere_light(r, node, s, emission);
    } else {
        add_flat_lights(r, node, s, emission);
    }
}
