/* A triangle and a ray in double precision.

   Embree accepts a ray that misses a triangle by a few roundings, and each triangle by its own few: measured with Embree 3.13, 3 %
   of the rays aimed at the edges of a cube enter through one of the two faces there without leaving through the other, and would be
   in the wrong medium ever after. So null surfaces are met or missed here, as [WBW13] do it: space is sheared until the ray is an
   axis; what is left of a corner is a point of a plane, the same for all triangles around it, and an edge passes the ray on the
   side that a difference of two products says. Rounding is monotone, so that its sign is right or it is zero, and for the edge's
   other triangle exactly the opposite. A compiler that fuses the products breaks this: compile with -ffp-contract=off. */
#ifndef RENDER_TRIANGLE_H
#define RENDER_TRIANGLE_H

#include "scene.h"
#include "vec3d.h"

/* ---- met or missed ---- */

/* Takes a ray to the axis `along` from the origin. */
typedef struct {
    double origin[3];
    int along, across, up; /* axes; the direction is longest in `along` */
    double shear_across, shear_up;
} shear;

typedef struct {
    double x, y;
} vec2d;

static inline shear shear_of(vec3d origin, vec3d direction)
{
    static const int next[] = {1, 2, 0};
    const double d[3] = {direction.x, direction.y, direction.z};
    int along = fabs(d[1]) > fabs(d[0]);
    along = fabs(d[2]) > fabs(d[along]) ? 2 : along;
    int across = next[along], up = next[across];
    return (shear){{origin.x, origin.y, origin.z}, along, across, up, d[across] / d[along], d[up] / d[along]};
}

/* Where a corner is beside the ray. */
static inline vec2d shear_corner(const shear *s, const float *position)
{
    double along = position[s->along] - s->origin[s->along];
    return (vec2d){position[s->across] - s->origin[s->across] - s->shear_across * along,
                   position[s->up] - s->origin[s->up] - s->shear_up * along};
}

/* On which side of the ray the edge from p to q passes. */
static inline double edge_side(vec2d p, vec2d q)
{
    return p.x * q.y - p.y * q.x;
}

/* Unlike fmin and fmax one instruction each: for NaN they promise nothing. */
static inline double least(double a, double b)
{
    return a < b ? a : b;
}

static inline double greatest(double a, double b)
{
    return a > b ? a : b;
}

/* Whether the ray's line meets the triangle of these corners, its edges and corners included. A triangle seen from its edge is not
   met. By least and greatest: no branch here could be predicted. */
static inline int triangle_is_met(vec2d a, vec2d b, vec2d c)
{
    double ab = edge_side(a, b), bc = edge_side(b, c), ca = edge_side(c, a);
    return (least(least(ab, bc), ca) >= 0.0) != (greatest(greatest(ab, bc), ca) <= 0.0);
}

/* ---- where ---- */

typedef struct {
    vec3d a, b, c; /* relative to a ray's origin; counter-clockwise seen from the side that the normal points to */
} triangle;

static inline triangle triangle_load(const shape *mesh, uint32_t index, vec3d origin)
{
    const uint32_t *corner = mesh->triangles + 3 * (size_t)index;
    return (triangle){vec3d_sub(vec3d_load(mesh->positions + 3 * (size_t)corner[0]), origin),
                      vec3d_sub(vec3d_load(mesh->positions + 3 * (size_t)corner[1]), origin),
                      vec3d_sub(vec3d_load(mesh->positions + 3 * (size_t)corner[2]), origin)};
}

/* Along the normal, not of unit length; zero for a triangle without area. */
static inline vec3d triangle_normal(const triangle *t)
{
    return vec3d_cross(vec3d_sub(t->b, t->a), vec3d_sub(t->c, t->a));
}

/* `plane`, or the nearest distance within the triangle's reach: seen from its edge a triangle leaves the distance open (0/0), but
   the corners still bound it. */
static inline double triangle_clamp(const triangle *t, vec3d direction, double plane)
{
    double length2 = vec3d_dot(direction, direction); /* a rounded unit vector is not quite one */
    double a = vec3d_dot(t->a, direction), b = vec3d_dot(t->b, direction), c = vec3d_dot(t->c, direction);
    return fmin(fmax(plane, fmin(a, fmin(b, c)) / length2), fmax(a, fmax(b, c)) / length2);
}

/* Distance along the ray to the triangle; not a number for a triangle without area. `approach`: normal times direction. */
static inline double triangle_distance(const triangle *t, vec3d normal, vec3d direction, double approach)
{
    const double grazing = 1e-3; /* the cosine */
    double plane = vec3d_dot(normal, t->a) / approach;
    int grazes = approach * approach < grazing * grazing * vec3d_dot(normal, normal);
    return grazes ? triangle_clamp(t, direction, plane) : plane;
}

#endif
