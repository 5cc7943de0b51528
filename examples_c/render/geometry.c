/* Rectangles, cubes and spheres in world space. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reader.h"

/* How much a sphere's three axes may differ in length, and how far from right angles they may be, before it counts as stretched.
 */
#define ROUND 1e-5

/* Corners by bits: bit i of a corner's number says whether axis i is +1 or -1. Each quad is a, b, c, d with (b - a) x (d - a)
 * outward. */
static const uint32_t CUBE_QUADS[6][4] = {{1, 3, 7, 5}, {0, 4, 6, 2}, {2, 6, 7, 3}, {0, 1, 5, 4}, {4, 5, 7, 6}, {0, 2, 3, 1}};
static const uint32_t RECTANGLE_QUAD[1][4] = {{0, 1, 3, 2}};

int reader_is_mesh_type(const char *type)
{
    return strcmp(type, "ply") == 0 || strcmp(type, "obj") == 0;
}

int reader_mesh_room(const xml_node *node, shape *out, uint32_t vertices, uint32_t triangles)
{
    out->kind = SHAPE_MESH;
    out->positions = calloc(vertices, 3 * sizeof *out->positions);
    out->triangles = calloc(triangles, 3 * sizeof *out->triangles);
    if (!out->positions || !out->triangles) {
        return xml_out_of_memory(node);
    }
    out->vertex_count = vertices;
    out->triangle_count = triangles;
    return 1;
}

void reader_set_corner(shape *s, uint32_t vertex, vec3d position)
{
    volgrad_vec3 rounded = vec3d_round(position);
    memcpy(s->positions + 3 * (size_t)vertex, &rounded, sizeof rounded);
}

/* Two triangles a b c and a c d per quad; a mirroring map turns them around, so that the normal stays the one of the inverse
 * transpose. */
static void set_quads(shape *s, const uint32_t (*quads)[4], uint32_t count, int mirrored)
{
    for (uint32_t i = 0; i < count; i++) {
        uint32_t a = quads[i][0], b = quads[i][mirrored ? 3 : 1], c = quads[i][2], d = quads[i][mirrored ? 1 : 3];
        const uint32_t corners[6] = {a, b, c, a, c, d};
        memcpy(s->triangles + 6 * i, corners, sizeof corners);
    }
}

static void read_quads(xml_node *node, const uint32_t (*quads)[4], uint32_t count, int flat, shape *out, int *mirrored)
{
    transform to_world = param_transform(node, "to_world");
    uint32_t corners = flat ? 4 : 8;
    *mirrored = transform_determinant(&to_world) < 0;
    if (!reader_mesh_room(node, out, corners, 2 * count)) {
        return;
    }
    for (uint32_t i = 0; i < corners; i++) {
        vec3d corner = {i & 1 ? 1 : -1, i & 2 ? 1 : -1, flat ? 0 : i & 4 ? 1 : -1};
        reader_set_corner(out, i, transform_point(&to_world, corner));
    }
    set_quads(out, quads, count, *mirrored);
    out->primitives_per_light = 2;
}

/* The factor by which the map scales if it keeps spheres round and the outside outside; 0 otherwise. */
static double uniform_scale(const transform *t)
{
    double scale = vec3d_length(transform_axis(t, 0));
    for (int i = 0; i < 3; i++) {
        vec3d axis = transform_axis(t, i), next = transform_axis(t, (i + 1) % 3);
        if (fabs(vec3d_length(axis) - scale) > ROUND * scale) {
            return 0;
        }
        if (fabs(vec3d_dot(axis, next)) > ROUND * scale * scale) {
            return 0;
        }
    }
    return transform_determinant(t) > 0 ? scale : 0;
}

static void read_sphere(xml_node *node, shape *out)
{
    static const double unit_radius = 1;
    transform to_world = param_transform(node, "to_world");
    vec3d center = {0, 0, 0};
    param_vec3d(node, "point", "center", 0, &center);
    double radius = param_float(node, "radius", &unit_radius, PARAM_POSITIVE), scale = uniform_scale(&to_world);
    if (scale == 0) {
        xml_error(
            param_find(node, "to_world"),
            "to_world stretches or mirrors this sphere; only rotation, translation and uniform positive scale are supported");
    }
    out->kind = SHAPE_SPHERE;
    out->center = vec3d_round(transform_point(&to_world, center));
    out->radius = (float)(radius * scale);
    out->primitives_per_light = 1;
}

void reader_geometry(xml_node *node, const char *type, shape *out, int *mirrored)
{
    *mirrored = 0;
    if (reader_is_mesh_type(type)) {
        reader_mesh_file(node, type, out);
    } else if (strcmp(type, "rectangle") == 0) {
        read_quads(node, RECTANGLE_QUAD, 1, 1, out, mirrored);
    } else if (strcmp(type, "cube") == 0) {
        read_quads(node, CUBE_QUADS, 6, 0, out, mirrored);
    } else if (strcmp(type, "sphere") == 0) {
        read_sphere(node, out);
    } else {
        xml_error(node, "shape \"%s\" is not supported; write rectangle, cube, sphere, ply or obj", type);
    }
}
