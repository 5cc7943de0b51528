#include "traversal.h"

#include <float.h>

#include "sphere.h"

static int in_range(const traversal *ray, double t)
{
    return t >= ray->t_min && t < ray->t_max;
}

/* ---- opaque surfaces ---- */

static surface_point triangle_point(const traversal *ray, const shape *mesh, uint32_t index)
{
    triangle corners = triangle_load(mesh, index, ray->origin);
    vec3d normal = triangle_normal(&corners);
    double approach = vec3d_dot(normal, ray->direction);
    double t = triangle_distance(&corners, normal, ray->direction, approach);
    return (surface_point){.t = t, .normal = normal, .leaves = approach > 0.0};
}

static surface_point sphere_point(const shape *sphere, const traversal *ray, double t, int leaves)
{
    vec3d normal = vec3d_sub(vec3d_along(ray->origin, t, ray->direction), vec3d_from(sphere->center));
    return (surface_point){.t = t, .normal = normal, .leaves = leaves};
}

/* The nearest point of an opaque sphere that the ray may hit. Returns 0 if there is none. */
static int visible_sphere_point(const shape *sphere, const traversal *ray, surface_point *point)
{
    double entry, exit;
    if (!sphere_roots(vec3d_from(sphere->center), sphere->radius, ray->origin, ray->direction, &entry, &exit)) {
        return 0;
    }
    int leaves = !in_range(ray, entry);
    *point = sphere_point(sphere, ray, leaves ? exit : entry, leaves);
    return in_range(ray, point->t);
}

/* Embree asks in any order, but always about a point that is nearer than the last one accepted. */
static void accept(traversal *ray, uint32_t shape_index, uint32_t primitive, const surface_point *point)
{
    ray->shape = shape_index;
    ray->primitive = primitive;
    ray->point = *point;
}

/* ---- crossed surfaces ---- */

/* How far along the ray a rounding of relative size 1 moves the surface: over the cosine of incidence (no less than one thousandth,
   so that grazing rays do not skip whole objects). */
static double place_error(const traversal *ray, double t, vec3d normal)
{
    double size = fabs(ray->origin.x) + fabs(ray->origin.y) + fabs(ray->origin.z) + t;
    double cosine = fabs(vec3d_dot(normal, ray->direction));
    return size / (cosine > 1e-3 ? cosine : 1e-3);
}

static void note_crossing(traversal *ray, uint32_t shape_index, uint32_t primitive, const surface_point *point)
{
    const shape *surface = &ray->scene->shapes[shape_index];
    const double roundings = 8.0;
    uint32_t medium = point->leaves ? surface->medium_outside : surface->medium_inside;
    if (point->t > 0.0 && point->t < ray->t_max && medium != VOLGRAD_KEEP_MEDIUM) {
        vec3d normal = vec3d_unit(point->normal);
        double error = roundings * place_error(ray, point->t, normal);
        crossings_add(&ray->crossings,
                      &(crossing){.t = point->t,
                                  .t_error = DBL_EPSILON * error, /* what is computed here */
                                  .gap = FLT_EPSILON * error,     /* corners as they are stored */
                                  .normal = vec3d_round(normal),
                                  .medium = medium,
                                  .shape = shape_index,
                                  .primitive = primitive,
                                  .leaves = point->leaves});
    }
}

static void cross_triangle(traversal *ray, uint32_t shape_index, uint32_t primitive)
{
    const shape *mesh = &ray->scene->shapes[shape_index];
    const uint32_t *corner = mesh->triangles + 3 * (size_t)primitive;
    if (triangle_is_met(shear_corner(&ray->shear, mesh->positions + 3 * (size_t)corner[0]),
                        shear_corner(&ray->shear, mesh->positions + 3 * (size_t)corner[1]),
                        shear_corner(&ray->shear, mesh->positions + 3 * (size_t)corner[2]))) {
        surface_point point = triangle_point(ray, mesh, primitive);
        note_crossing(ray, shape_index, primitive, &point);
    }
}

static void cross_sphere(traversal *ray, uint32_t shape_index)
{
    const shape *sphere = &ray->scene->shapes[shape_index];
    double entry, exit;
    if (sphere_roots(vec3d_from(sphere->center), sphere->radius, ray->origin, ray->direction, &entry, &exit)) {
        surface_point in = sphere_point(sphere, ray, entry, 0);
        surface_point out = sphere_point(sphere, ray, exit, 1);
        note_crossing(ray, shape_index, 0, &in);
        note_crossing(ray, shape_index, 0, &out);
    }
}

/* ---- what Embree calls ---- */

/* Called for each triangle that Embree would hit, for one ray at a time; clearing `valid` lets the ray go on. */
void traversal_filter(const struct RTCFilterFunctionNArguments *args)
{
    traversal *ray = (traversal *)(void *)args->context;
    const struct RTCHit *hit = (const struct RTCHit *)(const void *)args->hit;
    if (args->valid[0] && ray->passes_all) {
        cross_triangle(ray, hit->geomID, hit->primID);
        args->valid[0] = 0;
    } else if (args->valid[0]) {
        surface_point point = triangle_point(ray, args->geometryUserPtr, hit->primID);
        if (in_range(ray, point.t)) {
            accept(ray, hit->geomID, hit->primID, &point);
        } else {
            args->valid[0] = 0;
        }
    }
}

/* Wider than what rounding and the tree's own arithmetic can lose. */
static float padding(float coordinate, float reach)
{
    return 4.0f * FLT_EPSILON * (fabsf(coordinate) + reach);
}

static void sphere_bounds(const shape *sphere, float low[3], float high[3])
{
    const float center[3] = {sphere->center.x, sphere->center.y, sphere->center.z};
    for (int k = 0; k < 3; ++k) {
        float reach = sphere->radius + padding(center[k], sphere->radius);
        low[k] = center[k] - reach;
        high[k] = center[k] + reach;
    }
}

static void triangle_bounds(const shape *mesh, uint32_t index, float low[3], float high[3])
{
    const uint32_t *corner = mesh->triangles + 3 * (size_t)index;
    for (int k = 0; k < 3; ++k) {
        float a = mesh->positions[3 * (size_t)corner[0] + k];
        float b = mesh->positions[3 * (size_t)corner[1] + k];
        float c = mesh->positions[3 * (size_t)corner[2] + k];
        low[k] = fminf(a, fminf(b, c));
        high[k] = fmaxf(a, fmaxf(b, c));
        low[k] -= padding(low[k], 0.0f);
        high[k] += padding(high[k], 0.0f);
    }
}

void traversal_bounds(const struct RTCBoundsFunctionArguments *args)
{
    const shape *surface = args->geometryUserPtr;
    float low[3], high[3];
    if (surface->kind == SHAPE_SPHERE) {
        sphere_bounds(surface, low, high);
    } else {
        triangle_bounds(surface, args->primID, low, high);
    }
    *args->bounds_o = (struct RTCBounds){.lower_x = low[0],
                                         .lower_y = low[1],
                                         .lower_z = low[2],
                                         .upper_x = high[0],
                                         .upper_y = high[1],
                                         .upper_z = high[2]};
}

/* Whether the primitive stops the ray nearer than t_far, which then is its distance. Null surfaces never do, and no surface stops a
   ray that passes all. */
static int visit(traversal *ray, uint32_t shape_index, uint32_t primitive, float *t_far)
{
    const shape *surface = &ray->scene->shapes[shape_index];
    surface_point point;
    int is_crossed = surface->is_null || ray->passes_all;
    if (is_crossed && surface->kind == SHAPE_SPHERE) {
        cross_sphere(ray, shape_index);
        return 0;
    }
    if (is_crossed) {
        cross_triangle(ray, shape_index, primitive);
        return 0;
    }
    if (!visible_sphere_point(surface, ray, &point) || !(point.t < *t_far)) {
        return 0;
    }
    accept(ray, shape_index, primitive, &point);
    *t_far = (float)point.t;
    return 1;
}

void traversal_intersect(const struct RTCIntersectFunctionNArguments *args)
{
    struct RTCRayHit *rayhit = (struct RTCRayHit *)(void *)args->rayhit;
    if (args->valid[0] && visit((traversal *)(void *)args->context, args->geomID, args->primID, &rayhit->ray.tfar)) {
        rayhit->hit = (struct RTCHit){.primID = args->primID, .geomID = args->geomID};
        rayhit->hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    }
}

void traversal_occluded(const struct RTCOccludedFunctionNArguments *args)
{
    struct RTCRay *ray = (struct RTCRay *)(void *)args->ray;
    if (args->valid[0] && visit((traversal *)(void *)args->context, args->geomID, args->primID, &ray->tfar)) {
        ray->tfar = -INFINITY; /* Embree's sign for occluded */
    }
}
