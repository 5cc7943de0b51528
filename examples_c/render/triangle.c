#include "triangle.h"

triangle triangle_load(const shape *mesh, uint32_t index, vec3d origin)
{
    const uint32_t *corner = mesh->triangles + 3 * (size_t)index;
    return (triangle){vec3d_sub(vec3d_load(mesh->positions + 3 * (size_t)corner[0]), origin),
                      vec3d_sub(vec3d_load(mesh->positions + 3 * (size_t)corner[1]), origin),
                      vec3d_sub(vec3d_load(mesh->positions + 3 * (size_t)corner[2]), origin)};
}

vec3d triangle_normal(const triangle *t)
{
    return vec3d_unit(vec3d_cross(vec3d_sub(t->b, t->a), vec3d_sub(t->c, t->a)));
}

double triangle_distance(const triangle *t, vec3d normal, vec3d direction)
{
    double length2 = vec3d_dot(direction, direction); /* a rounded unit vector is not quite one */
    double a = vec3d_dot(t->a, direction) / length2;
    double b = vec3d_dot(t->b, direction) / length2;
    double c = vec3d_dot(t->c, direction) / length2;
    /* Seen from its edge a triangle leaves the distance open; the corners still bound it. fmin and fmax drop the NaN of 0/0. */
    double plane = vec3d_dot(normal, t->a) / vec3d_dot(normal, direction);
    return fmin(fmax(plane, fmin(a, fmin(b, c))), fmax(a, fmax(b, c)));
}

static int comes_first(vec3d p, vec3d q)
{
    if (p.x != q.x) {
        return p.x < q.x;
    }
    return p.y != q.y ? p.y < q.y : p.z < q.z;
}

/* On which side of the line the edge from p to q passes: the volume spanned by p, q and the direction. Computed in one order of p
   and q, so that the edge from q to p gets exactly the opposite. */
static double edge_side(vec3d p, vec3d q, vec3d direction)
{
    return comes_first(p, q) ? vec3d_dot(vec3d_cross(p, q), direction) : -vec3d_dot(vec3d_cross(q, p), direction);
}

int triangle_is_met(const triangle *t, vec3d direction)
{
    double ab = edge_side(t->a, t->b, direction);
    double bc = edge_side(t->b, t->c, direction);
    double ca = edge_side(t->c, t->a, direction);
    int same_sign = (ab >= 0.0 && bc >= 0.0 && ca >= 0.0) || (ab <= 0.0 && bc <= 0.0 && ca <= 0.0);
    return same_sign && ab + bc + ca != 0.0;
}
