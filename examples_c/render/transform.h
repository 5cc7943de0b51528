/* Affine maps as 4x4 matrices in double precision, with the meaning that Mitsuba gives to rotate, scale, translate and lookat. */
#ifndef RENDER_TRANSFORM_H
#define RENDER_TRANSFORM_H

#include "vec3d.h"

/* Row-major; points are columns: p' = m p. The last row is 0 0 0 1. */
typedef struct {
    double m[4][4];
} transform;

double vec3d_length(vec3d a);
vec3d vec3d_difference(vec3d a, vec3d b); /* a - b */
vec3d vec3d_scaled(vec3d a, double factor);

transform transform_identity(void);

/* First b, then a. */
transform transform_multiply(const transform *a, const transform *b);

transform transform_translate(vec3d offset);
transform transform_scale(vec3d factors);

/* Right-handed rotation about a unit axis. */
transform transform_rotate(vec3d axis, double degrees);

/* Maps +z to the direction from origin to target, +y towards up and +x to their left (up x direction). 0 if that is undefined. */
int transform_lookat(vec3d origin, vec3d target, vec3d up, transform *out);

vec3d transform_point(const transform *t, vec3d p);

/* Image of the axis 0, 1 or 2 (no translation). */
vec3d transform_axis(const transform *t, int axis);

vec3d transform_translation(const transform *t);

double transform_determinant(const transform *t);

/* Whether it keeps all lengths: rotations, mirrors and translations. */
int transform_is_rigid(const transform *t);

/* Whether the map has an inverse, with room for rounding. */
int transform_is_invertible(const transform *t);

/* Whether it maps axis-aligned boxes to axis-aligned boxes. */
int transform_is_axis_aligned(const transform *t);

#endif
