/* A sphere around all shapes: its centre is that of their box. */
#include "reader.h"
#include "transform.h"

typedef struct {
    vec3d low, high;
} box;

static void grow(box *b, vec3d point, double reach)
{
    b->low = (vec3d){fmin(b->low.x, point.x - reach), fmin(b->low.y, point.y - reach), fmin(b->low.z, point.z - reach)};
    b->high = (vec3d){fmax(b->high.x, point.x + reach), fmax(b->high.y, point.y + reach), fmax(b->high.z, point.z + reach)};
}

static box box_of(const scene *s)
{
    box b = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (const shape *i = s->shapes; i < s->shapes + s->shape_count; i++) {
        if (i->kind == SHAPE_SPHERE) {
            grow(&b, vec3d_from(i->center), i->radius);
        }
        for (uint32_t v = 0; v < i->vertex_count; v++) {
            grow(&b, vec3d_load(i->positions + 3 * (size_t)v), 0);
        }
    }
    return b;
}

static double radius_around(const scene *s, vec3d centre)
{
    double radius = 0;
    for (const shape *i = s->shapes; i < s->shapes + s->shape_count; i++) {
        if (i->kind == SHAPE_SPHERE) {
            radius = fmax(radius, vec3d_length(vec3d_sub(vec3d_from(i->center), centre)) + i->radius);
        }
        for (uint32_t v = 0; v < i->vertex_count; v++) {
            radius = fmax(radius, vec3d_length(vec3d_sub(vec3d_load(i->positions + 3 * (size_t)v), centre)));
        }
    }
    return radius;
}

void reader_bounds(scene *s)
{
    const double slack = 1e-3; /* more than single precision rounds, too little to waste light */
    if (s->shape_count > 0) {
        box b = box_of(s);
        vec3d centre = vec3d_scaled(vec3d_along(b.low, 1, b.high), .5);
        s->desc.bounds_centre = vec3d_round(centre);
        s->desc.bounds_radius = (float)((1 + slack) * radius_around(s, centre));
    }
}
