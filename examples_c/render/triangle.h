/* A triangle and a ray in double precision.

   Embree accepts a ray that misses a triangle by a few roundings, and each triangle by its own few: measured with Embree 3.13, 3 %
   of the rays aimed at the edges of a cube enter through one of the two faces there without leaving through the other, and would be
   in the wrong medium ever after. The test here gives an edge's two triangles exactly opposite signs. */
#ifndef RENDER_TRIANGLE_H
#define RENDER_TRIANGLE_H

#include "scene.h"
#include "vec3d.h"

typedef struct {
    vec3d a, b, c; /* counter-clockwise seen from the side that the normal points to */
} triangle;

/* Relative to a ray's origin; pass the zero vector for world space. */
triangle triangle_load(const shape *mesh, uint32_t index, vec3d origin);

/* Unit normal; not finite for a triangle without area. */
vec3d triangle_normal(const triangle *t);

/* Distance along the ray from (0, 0, 0) to the triangle's plane, within the triangle's reach. */
double triangle_distance(const triangle *t, vec3d normal, vec3d direction);

/* Whether the line through (0, 0, 0) meets the triangle, its edges and corners included. A line through the edge of two triangles,
   or beside it, gets answers that fit together. A triangle seen from its edge is not met. */
int triangle_is_met(const triangle *t, vec3d direction);

#endif
