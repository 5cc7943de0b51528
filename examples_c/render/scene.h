/* A scene as read from a file: what volgrad needs (desc) and the geometry that stays with the host. */
#ifndef RENDER_SCENE_H
#define RENDER_SCENE_H

#include <stddef.h>
#include <stdint.h>

#include "volgrad.h"

typedef enum { SHAPE_MESH, SHAPE_SPHERE } shape_kind;

typedef struct {
    shape_kind kind;
    /* Mesh: world-space corners; triangles counter-clockwise seen from the side that the normal points to. */
    float *positions; /* 3 * vertex_count */
    uint32_t vertex_count;
    uint32_t *triangles; /* 3 * triangle_count */
    uint32_t triangle_count;
    /* Sphere: world space; the normal points outwards. */
    volgrad_vec3 center;
    float radius;
    int is_null;       /* index-matched surface: only changes the medium */
    uint32_t material; /* unused if is_null */
    /* Area light: primitive p of this shape is light first_light + p / primitives_per_light. VOLGRAD_NONE: no light. */
    uint32_t first_light;
    uint32_t primitives_per_light;
    /* Media behind and before the surface, or VOLGRAD_NONE (vacuum); both VOLGRAD_KEEP_MEDIUM if it bounds none. */
    uint32_t medium_inside;
    uint32_t medium_outside;
} shape;

typedef struct {
    volgrad_scene_desc desc; /* its arrays and grids belong to the scene */
    shape *shapes;
    uint32_t shape_count;
    uint32_t max_depth; /* of the file's integrator; 0: no limit */
    uint32_t rr_depth;
    uint32_t sample_count; /* of the file's sampler, samples per pixel */
} scene;

/* Reads a Mitsuba 3 scene file (the subset in scenes/README.md). On an error prints `file:line:column: what, and what would be
   right` to stderr and returns 0; nothing needs to be freed then. */
int scene_load(const char *path, scene *out);

void scene_free(scene *s);

#endif
