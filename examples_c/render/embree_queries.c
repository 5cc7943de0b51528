#include "embree_queries.h"

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "traversal.h"

struct embree_queries {
    RTCDevice device;
    RTCScene tree; /* geometry i is shape i */
    const scene *scene;
};

/* ---- building ---- */

/* Embree owns its buffers and pads them; the scene keeps its own arrays for double precision. Returns 0 when out of memory. */
static int copy_buffer(RTCGeometry geometry, enum RTCBufferType type, enum RTCFormat format, const void *from, size_t count)
{
    const size_t item = 3 * sizeof(uint32_t); /* three floats or three indices */
    void *to = rtcSetNewGeometryBuffer(geometry, type, 0, format, item, count);
    if (to == NULL) {
        return 0;
    }
    memcpy(to, from, item * count);
    return 1;
}

/* Opaque meshes: Embree's own triangles. */
static int describe_triangles(RTCGeometry geometry, const shape *mesh)
{
    rtcSetGeometryIntersectFilterFunction(geometry, traversal_filter);
    rtcSetGeometryOccludedFilterFunction(geometry, traversal_filter);
    return copy_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, mesh->positions, mesh->vertex_count) &&
           copy_buffer(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, mesh->triangles, mesh->triangle_count);
}

/* Spheres and null meshes. */
static void describe_user(RTCGeometry geometry, const shape *s)
{
    rtcSetGeometryUserPrimitiveCount(geometry, s->kind == SHAPE_SPHERE ? 1 : s->triangle_count);
    rtcSetGeometryBoundsFunction(geometry, traversal_bounds, NULL);
    rtcSetGeometryIntersectFunction(geometry, traversal_intersect);
    rtcSetGeometryOccludedFunction(geometry, traversal_occluded);
}

/* Returns 0 when out of memory. */
static int attach_shape(embree_queries *queries, uint32_t index)
{
    shape *s = &queries->scene->shapes[index];
    int is_user = s->kind == SHAPE_SPHERE || s->is_null;
    int ok = 1;
    RTCGeometry geometry =
        rtcNewGeometry(queries->device, is_user ? RTC_GEOMETRY_TYPE_USER : RTC_GEOMETRY_TYPE_TRIANGLE);
    if (geometry == NULL) {
        return 0;
    }
    rtcSetGeometryUserData(geometry, s);
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
    if (is_user) {
        describe_user(geometry, s);
    } else {
        ok = describe_triangles(geometry, s);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(queries->tree, geometry, index);
    rtcReleaseGeometry(geometry);
    return ok;
}

/* A mesh without triangles needs no geometry, and Embree refuses empty buffers. */
static int is_empty(const shape *s)
{
    return s->kind == SHAPE_MESH && (s->triangle_count == 0 || s->vertex_count == 0);
}

/* Returns 0 when out of memory. */
static int build_tree(embree_queries *queries)
{
    queries->tree = rtcNewScene(queries->device);
    if (queries->tree == NULL) {
        return 0;
    }
    rtcSetSceneFlags(queries->tree, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(queries->tree, RTC_BUILD_QUALITY_HIGH);
    for (uint32_t i = 0; i < queries->scene->shape_count; ++i) {
        if (!is_empty(&queries->scene->shapes[i]) && !attach_shape(queries, i)) {
            return 0;
        }
    }
    rtcCommitScene(queries->tree);
    return 1;
}

static const char *error_text(enum RTCError error)
{
    switch (error) {
    case RTC_ERROR_OUT_OF_MEMORY:
        return "out of memory";
    case RTC_ERROR_UNSUPPORTED_CPU:
        return "this processor is not supported";
    case RTC_ERROR_CANCELLED:
        return "cancelled";
    case RTC_ERROR_INVALID_ARGUMENT:
    case RTC_ERROR_INVALID_OPERATION:
        return "invalid geometry";
    default:
        return "unknown error";
    }
}

embree_queries *embree_queries_create(const scene *scene, unsigned threads, const char **problem)
{
    char config[32];
    snprintf(config, sizeof config, "threads=%u", threads);
    embree_queries *queries = calloc(1, sizeof *queries);
    if (queries == NULL) {
        *problem = error_text(RTC_ERROR_OUT_OF_MEMORY);
        return NULL;
    }
    queries->scene = scene;
    queries->device = rtcNewDevice(config);
    int built = queries->device != NULL && build_tree(queries);
    enum RTCError error = rtcGetDeviceError(queries->device);
    if (!built || error != RTC_ERROR_NONE) {
        *problem = error_text(error != RTC_ERROR_NONE ? error : RTC_ERROR_OUT_OF_MEMORY);
        embree_queries_destroy(queries);
        return NULL;
    }
    return queries;
}

void embree_queries_destroy(embree_queries *queries)
{
    if (queries == NULL) {
        return;
    }
    if (queries->tree != NULL) {
        rtcReleaseScene(queries->tree);
    }
    if (queries->device != NULL) {
        rtcReleaseDevice(queries->device);
    }
    free(queries);
}

void embree_queries_version(char *text, size_t size)
{
    snprintf(text, size, "%d.%d.%d", RTC_VERSION_MAJOR, RTC_VERSION_MINOR, RTC_VERSION_PATCH);
}

/* ---- asking ---- */

/* Only t_max may be infinite. False for a NaN anywhere. */
static int is_ray(const volgrad_ray *ray)
{
    return vec3d_finite(vec3d_from(ray->origin)) && vec3d_finite(vec3d_from(ray->direction)) && isfinite(ray->t_min) &&
           ray->t_max >= 0.0f;
}

static void traversal_start(traversal *ray, const scene *scene, const volgrad_ray *asked)
{
    ray->scene = scene;
    ray->origin = vec3d_from(asked->origin);
    ray->direction = vec3d_from(asked->direction);
    ray->t_min = asked->t_min;
    ray->t_max = asked->t_max;
    ray->shear = shear_of(ray->origin, ray->direction);
    ray->passes_all = 0;
    ray->shape = VOLGRAD_NONE;
    crossings_clear(&ray->crossings);
}

/* From 0 and not from t_min: t_min skips the opaque surface that the ray starts from, but no medium. */
static struct RTCRay embree_ray(const volgrad_ray *ray)
{
    return (struct RTCRay){.org_x = ray->origin.x,
                           .org_y = ray->origin.y,
                           .org_z = ray->origin.z,
                           .tnear = 0.0f,
                           .dir_x = ray->direction.x,
                           .dir_y = ray->direction.y,
                           .dir_z = ray->direction.z,
                           .tfar = ray->t_max,
                           .mask = 0xFFFFFFFFu};
}

/* A ray that is no ray: volgrad drops and counts the path. */
static volgrad_hit unanswerable(const volgrad_ray *ray)
{
    volgrad_hit hit = {.kind = VOLGRAD_HIT_OVERFLOW, .light = VOLGRAD_NONE, .segment_count = 1};
    hit.segments[0] = (volgrad_segment){.end = INFINITY, .medium = ray->medium};
    return hit;
}

/* The media up to `end`, in a hit that has none yet. */
static void set_segments(volgrad_hit *hit, traversal *ray, uint32_t medium, double end)
{
    hit->segment_count = crossings_segments(&ray->crossings, medium, end, hit->segments);
    if (hit->segment_count == 0) {
        hit->kind = VOLGRAD_HIT_OVERFLOW;
    }
}

/* No surface. Segments are what makes hits large, and stay as they are. */
static void clear(volgrad_hit *hit)
{
    memset(hit, 0, offsetof(volgrad_hit, segments));
    hit->kind = VOLGRAD_HIT_NONE;
    hit->light = VOLGRAD_NONE;
}

/* A collision so close to a surface that single precision puts it there: volgrad takes distances > 0 only. */
static const double NEAREST = FLT_MIN;

/* Returns the distance before rounding. */
static double set_surface(volgrad_hit *hit, const traversal *ray)
{
    const shape *surface = &ray->scene->shapes[ray->shape];
    hit->kind = VOLGRAD_HIT_SURFACE;
    hit->material = surface->material;
    if (surface->first_light != VOLGRAD_NONE) {
        uint32_t per_light = surface->primitives_per_light > 0 ? surface->primitives_per_light : 1;
        hit->light = surface->first_light + ray->primitive / per_light;
    }
    double t = fmax(ray->point.t, NEAREST);
    hit->t = (float)t;
    hit->normal = vec3d_round(vec3d_unit(ray->point.normal));
    hit->shading_normal = hit->normal;
    hit->medium_outside = surface->medium_outside;
    hit->medium_inside = surface->medium_inside;
    return t;
}

static void intersect_one(const embree_queries *queries, const volgrad_ray *asked, volgrad_hit *hit)
{
    traversal ray;
    traversal_start(&ray, queries->scene, asked);
    struct RTCRayHit rayhit = {.ray = embree_ray(asked), .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
    embree_intersect(queries->tree, &ray.context, &rayhit);
    double end = ray.t_max;
    clear(hit);
    if (ray.shape != VOLGRAD_NONE) {
        end = set_surface(hit, &ray);
    }
    set_segments(hit, &ray, asked->medium, end);
}

static void occluded_one(const embree_queries *queries, const volgrad_ray *asked, volgrad_hit *hit)
{
    traversal ray;
    traversal_start(&ray, queries->scene, asked);
    struct RTCRay embree = embree_ray(asked);
    embree_occluded(queries->tree, &ray.context, &embree);
    clear(hit);
    if (embree.tfar < 0.0f) { /* Embree's sign for occluded */
        hit->kind = VOLGRAD_HIT_SURFACE;
    } else {
        set_segments(hit, &ray, asked->medium, ray.t_max);
    }
}

static int32_t intersect(void *user, const volgrad_ray *rays, volgrad_hit *hits, uint32_t count)
{
    for (uint32_t i = 0; i < count; ++i) {
        if (is_ray(&rays[i])) {
            intersect_one(user, &rays[i], &hits[i]);
        } else {
            hits[i] = unanswerable(&rays[i]);
        }
    }
    return 0;
}

static int32_t occluded(void *user, const volgrad_ray *rays, volgrad_hit *hits, uint32_t count)
{
    for (uint32_t i = 0; i < count; ++i) {
        if (is_ray(&rays[i])) {
            occluded_one(user, &rays[i], &hits[i]);
        } else {
            hits[i] = unanswerable(&rays[i]);
        }
    }
    return 0;
}

/* ---- media ---- */

/* A point around which the camera's medium is. */
static vec3d camera_point(const volgrad_camera *camera)
{
    return vec3d_along(vec3d_from(camera->position), camera->near_clip, vec3d_from(camera->forward));
}

/* On the way to the camera, the side of the first surface between media; without one, the camera is in the same medium. */
uint32_t embree_queries_medium_at(const embree_queries *queries, volgrad_vec3 point)
{
    const volgrad_camera *camera = &queries->scene->desc.camera;
    vec3d way = vec3d_sub(camera_point(camera), vec3d_from(point));
    double distance = sqrt(vec3d_dot(way, way));
    if (!(distance > 0.0)) {
        return camera->medium;
    }
    volgrad_ray asked = {.origin = point, .direction = vec3d_round(vec3d_unit(way)), .t_max = (float)distance};
    traversal ray;
    traversal_start(&ray, queries->scene, &asked);
    ray.passes_all = 1;
    struct RTCRay embree = embree_ray(&asked);
    embree_occluded(queries->tree, &ray.context, &embree);
    const crossing *first = crossings_first(&ray.crossings);
    if (first == NULL) {
        return camera->medium;
    }
    const shape *surface = &queries->scene->shapes[first->shape];
    return first->leaves ? surface->medium_inside : surface->medium_outside;
}

volgrad_queries embree_queries_table(embree_queries *queries)
{
    return (volgrad_queries){
        .struct_size = sizeof(volgrad_queries), .user = queries, .intersect = intersect, .occluded = occluded};
}
