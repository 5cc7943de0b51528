#include "transform.h"

/* A volume this small against its edges' product is flat but for rounding. */
#define FLAT 1e-10
/* Off-axis parts this small against the axis come from rounding, such as cos 90 degrees. */
#define ALIGNED 1e-9
/* Unit vectors of scene files are rounded by hand. */
#define UNIT_TOLERANCE 1e-3

static const double RADIANS_PER_DEGREE = 3.14159265358979323846 / 180.0;

double vec3d_length(vec3d a)
{
    return sqrt(vec3d_dot(a, a));
}

vec3d vec3d_difference(vec3d a, vec3d b)
{
    return (vec3d){a.x - b.x, a.y - b.y, a.z - b.z};
}

vec3d vec3d_scaled(vec3d a, double factor)
{
    return (vec3d){a.x * factor, a.y * factor, a.z * factor};
}

static transform from_columns(vec3d x, vec3d y, vec3d z, vec3d translation)
{
    return (transform){
        {{x.x, y.x, z.x, translation.x}, {x.y, y.y, z.y, translation.y}, {x.z, y.z, z.z, translation.z}, {0, 0, 0, 1}}};
}

transform transform_identity(void)
{
    return transform_scale((vec3d){1, 1, 1});
}

transform transform_multiply(const transform *a, const transform *b)
{
    transform product = {{{0}}};
    for (int row = 0; row < 4; row++) {
        for (int column = 0; column < 4; column++) {
            for (int i = 0; i < 4; i++) {
                product.m[row][column] += a->m[row][i] * b->m[i][column];
            }
        }
    }
    return product;
}

transform transform_translate(vec3d offset)
{
    return from_columns((vec3d){1, 0, 0}, (vec3d){0, 1, 0}, (vec3d){0, 0, 1}, offset);
}

transform transform_scale(vec3d factors)
{
    return from_columns((vec3d){factors.x, 0, 0}, (vec3d){0, factors.y, 0}, (vec3d){0, 0, factors.z}, (vec3d){0, 0, 0});
}

/* Rodrigues: v cos + (axis x v) sin + axis (axis . v)(1 - cos), for each of the three axes v. */
static vec3d rotated(vec3d v, vec3d axis, double sine, double cosine)
{
    vec3d across = vec3d_cross(axis, v);
    double along = vec3d_dot(axis, v) * (1 - cosine);
    return (vec3d){v.x * cosine + across.x * sine + axis.x * along, v.y * cosine + across.y * sine + axis.y * along,
                   v.z * cosine + across.z * sine + axis.z * along};
}

transform transform_rotate(vec3d axis, double degrees)
{
    double sine = sin(degrees * RADIANS_PER_DEGREE), cosine = cos(degrees * RADIANS_PER_DEGREE);
    return from_columns(rotated((vec3d){1, 0, 0}, axis, sine, cosine), rotated((vec3d){0, 1, 0}, axis, sine, cosine),
                        rotated((vec3d){0, 0, 1}, axis, sine, cosine), (vec3d){0, 0, 0});
}

int transform_lookat(vec3d origin, vec3d target, vec3d up, transform *out)
{
    vec3d direction = vec3d_difference(target, origin);
    vec3d left = vec3d_cross(up, direction);
    double length = vec3d_length(direction), left_length = vec3d_length(left);
    if (!(left_length > FLAT * length * vec3d_length(up))) {
        return 0;
    }
    direction = vec3d_scaled(direction, 1 / length);
    left = vec3d_scaled(left, 1 / left_length);
    *out = from_columns(left, vec3d_cross(direction, left), direction, origin);
    return 1;
}

vec3d transform_point(const transform *t, vec3d p)
{
    const double(*m)[4] = t->m;
    return (vec3d){m[0][0] * p.x + m[0][1] * p.y + m[0][2] * p.z + m[0][3],
                   m[1][0] * p.x + m[1][1] * p.y + m[1][2] * p.z + m[1][3],
                   m[2][0] * p.x + m[2][1] * p.y + m[2][2] * p.z + m[2][3]};
}

vec3d transform_axis(const transform *t, int axis)
{
    return (vec3d){t->m[0][axis], t->m[1][axis], t->m[2][axis]};
}

vec3d transform_translation(const transform *t)
{
    return transform_axis(t, 3);
}

double transform_determinant(const transform *t)
{
    return vec3d_dot(vec3d_cross(transform_axis(t, 0), transform_axis(t, 1)), transform_axis(t, 2));
}

int transform_is_rigid(const transform *t)
{
    for (int axis = 0; axis < 3; axis++) {
        vec3d image = transform_axis(t, axis), next = transform_axis(t, (axis + 1) % 3);
        if (fabs(vec3d_length(image) - 1) > UNIT_TOLERANCE || fabs(vec3d_dot(image, next)) > UNIT_TOLERANCE) {
            return 0;
        }
    }
    return 1;
}

int transform_is_invertible(const transform *t)
{
    double edges = 1;
    for (int axis = 0; axis < 3; axis++) {
        edges *= vec3d_length(transform_axis(t, axis));
    }
    return fabs(transform_determinant(t)) > FLAT * edges;
}

int transform_is_axis_aligned(const transform *t)
{
    for (int axis = 0; axis < 3; axis++) {
        vec3d image = transform_axis(t, axis);
        double longest = fmax(fabs(image.x), fmax(fabs(image.y), fabs(image.z)));
        if (vec3d_length(image) > longest * (1 + ALIGNED)) {
            return 0;
        }
    }
    return 1;
}
