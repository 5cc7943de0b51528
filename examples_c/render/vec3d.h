/* Double-precision vectors: scenes are read, and distances and normals computed, in double precision. */
#ifndef RENDER_VEC3D_H
#define RENDER_VEC3D_H

#include <math.h>

#include "volgrad.h"

typedef struct {
    double x, y, z;
} vec3d;

static inline vec3d vec3d_from(volgrad_vec3 v)
{
    return (vec3d){v.x, v.y, v.z};
}

static inline vec3d vec3d_load(const float *p)
{
    return (vec3d){p[0], p[1], p[2]};
}

static inline volgrad_vec3 vec3d_round(vec3d v)
{
    return (volgrad_vec3){(float)v.x, (float)v.y, (float)v.z};
}

/* a + t b */
static inline vec3d vec3d_along(vec3d a, double t, vec3d b)
{
    return (vec3d){a.x + t * b.x, a.y + t * b.y, a.z + t * b.z};
}

static inline vec3d vec3d_sub(vec3d a, vec3d b)
{
    return (vec3d){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline double vec3d_dot(vec3d a, vec3d b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline vec3d vec3d_cross(vec3d a, vec3d b)
{
    return (vec3d){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* The unit vector along v; of a zero vector not a number. */
static inline vec3d vec3d_unit(vec3d v)
{
    double length = sqrt(vec3d_dot(v, v));
    return (vec3d){v.x / length, v.y / length, v.z / length};
}

static inline int vec3d_finite(vec3d v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

#endif
