/* Ray queries of the Embree host on scenes made by hand, and against a slow double-precision search through all primitives.
   Prints `N passed, N failed`; the exit status is 1 if any failed. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../examples_c/render/crossings.h"
#include "../../examples_c/render/embree_queries.h"
#include "../../examples_c/render/light_media.h"

enum { FOG = 0, SMOKE = 1, GLASS_INSIDE = 2, MEDIA = 3, VACUUM_SLOT = MEDIA }; /* media; the slot counts vacuum's length */
enum { MAX_SHAPES = 8, MAX_VERTICES = 8, MAX_TRIANGLES = 12 };

typedef struct {
    int passed, failed;
} tally;

#define CHECK(t, condition) check(t, condition, #condition, __func__, __LINE__)

static void check(tally *t, int condition, const char *text, const char *function, int line)
{
    if (condition) {
        t->passed++;
    } else {
        t->failed++;
        printf("%s:%d: %s\n", function, line, text);
    }
}

/* ---- scenes ---- */

typedef struct {
    scene scene;
    shape shapes[MAX_SHAPES];
    float positions[MAX_SHAPES][3 * MAX_VERTICES];
    uint32_t triangles[MAX_SHAPES][3 * MAX_TRIANGLES];
    embree_queries *queries;
    volgrad_queries table;
} test_scene;

static void begin(test_scene *s)
{
    memset(s, 0, sizeof *s);
    s->scene.shapes = s->shapes;
}

static shape *add_shape(test_scene *s, shape_kind kind, int is_null, uint32_t outside, uint32_t inside)
{
    shape *added = &s->shapes[s->scene.shape_count++];
    added->kind = kind;
    added->is_null = is_null;
    added->first_light = VOLGRAD_NONE;
    added->medium_outside = outside;
    added->medium_inside = inside;
    return added;
}

static shape *add_mesh(test_scene *s, int is_null, uint32_t outside, uint32_t inside, uint32_t vertices, uint32_t triangles)
{
    uint32_t index = s->scene.shape_count;
    shape *mesh = add_shape(s, SHAPE_MESH, is_null, outside, inside);
    mesh->positions = s->positions[index];
    mesh->triangles = s->triangles[index];
    mesh->vertex_count = vertices;
    mesh->triangle_count = triangles;
    return mesh;
}

/* The cube of half side `half` about `center`, turned by `angle` about x and then about z. */
static shape *add_cube(test_scene *s, int is_null, uint32_t outside, uint32_t inside, volgrad_vec3 center, float half, double angle)
{
    static const uint32_t faces[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                       2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    shape *cube = add_mesh(s, is_null, outside, inside, 8, 12);
    for (int i = 0; i < 8; ++i) {
        double x = i & 1 ? half : -half, y = i & 2 ? half : -half, z = i & 4 ? half : -half;
        double y1 = y * cos(angle) - z * sin(angle), z1 = y * sin(angle) + z * cos(angle);
        cube->positions[3 * i] = (float)(center.x + x * cos(angle) - y1 * sin(angle));
        cube->positions[3 * i + 1] = (float)(center.y + x * sin(angle) + y1 * cos(angle));
        cube->positions[3 * i + 2] = (float)(center.z + z1);
    }
    memcpy(cube->triangles, faces, sizeof faces);
    return cube;
}

/* [-half, half]^2 at height z, normal up. */
static shape *add_rectangle(test_scene *s, float half, float z)
{
    shape *rectangle = add_mesh(s, 0, VOLGRAD_KEEP_MEDIUM, VOLGRAD_KEEP_MEDIUM, 4, 2);
    const float corners[12] = {-half, -half, z, half, -half, z, half, half, z, -half, half, z};
    const uint32_t triangles[6] = {0, 1, 2, 0, 2, 3};
    memcpy(rectangle->positions, corners, sizeof corners);
    memcpy(rectangle->triangles, triangles, sizeof triangles);
    return rectangle;
}

static shape *add_sphere(test_scene *s, int is_null, uint32_t outside, uint32_t inside, volgrad_vec3 center, float radius)
{
    shape *sphere = add_shape(s, SHAPE_SPHERE, is_null, outside, inside);
    sphere->center = center;
    sphere->radius = radius;
    return sphere;
}

static void finish(test_scene *s)
{
    const char *problem = "";
    s->queries = embree_queries_create(&s->scene, 1, &problem);
    if (s->queries == NULL) {
        printf("Embree: %s\n", problem);
        exit(1);
    }
    s->table = embree_queries_table(s->queries);
}

static void end(test_scene *s)
{
    embree_queries_destroy(s->queries);
}

/* ---- rays ---- */

static const volgrad_vec3 ORIGIN = {0, 0, 0};

static volgrad_ray ray_from(volgrad_vec3 origin, double x, double y, double z, uint32_t medium)
{
    double length = sqrt(x * x + y * y + z * z);
    return (volgrad_ray){.origin = origin,
                         .direction = {(float)(x / length), (float)(y / length), (float)(z / length)},
                         .t_max = INFINITY,
                         .medium = medium};
}

static volgrad_hit ask(const test_scene *s, volgrad_query_fn query, volgrad_ray ray)
{
    volgrad_hit hit;
    memset(&hit, 0xAB, sizeof hit); /* hits come uninitialised */
    query(s->table.user, &ray, &hit, 1);
    return hit;
}

static volgrad_hit intersect(const test_scene *s, volgrad_ray ray)
{
    return ask(s, s->table.intersect, ray);
}

static volgrad_hit occluded(const test_scene *s, volgrad_ray ray)
{
    return ask(s, s->table.occluded, ray);
}

static int near(double a, double b)
{
    return fabs(a - b) <= 2e-6 * (1.0 + fabs(b));
}

static int is_normal(volgrad_vec3 n, double x, double y, double z)
{
    return near(n.x, x) && near(n.y, y) && near(n.z, z);
}

static int is_segment(const volgrad_hit *hit, uint32_t index, uint32_t medium, double segment_end)
{
    const volgrad_segment *s = &hit->segments[index];
    return index < hit->segment_count && s->medium == medium && (near(s->end, segment_end) || s->end == segment_end);
}

/* xorshift64* [Vigna 2016]; in [0, 1). */
static double uniform(uint64_t *state)
{
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return (double)((*state * 0x2545F4914F6CDD1DULL) >> 11) * 0x1p-53;
}

static volgrad_vec3 random_point(uint64_t *state, double half)
{
    return (volgrad_vec3){(float)(half * (2 * uniform(state) - 1)), (float)(half * (2 * uniform(state) - 1)),
                          (float)(half * (2 * uniform(state) - 1))};
}

/* ---- opaque surfaces ---- */

static void test_rectangle(tally *t)
{
    test_scene s;
    begin(&s);
    shape *lamp = add_rectangle(&s, 1.0f, 2.0f);
    lamp->material = 3;
    lamp->first_light = 7;
    lamp->primitives_per_light = 2;
    finish(&s);
    volgrad_hit hit = intersect(&s, ray_from((volgrad_vec3){.3f, .2f, 0}, 0, 0, 1, FOG));
    CHECK(t, hit.kind == VOLGRAD_HIT_SURFACE && hit.t == 2.0f && hit.material == 3 && hit.light == 7);
    CHECK(t, is_normal(hit.normal, 0, 0, 1) && is_normal(hit.shading_normal, 0, 0, 1));
    CHECK(t, hit.medium_outside == VOLGRAD_KEEP_MEDIUM && hit.medium_inside == VOLGRAD_KEEP_MEDIUM);
    CHECK(t, hit.segment_count == 1 && is_segment(&hit, 0, FOG, 2.0));
    CHECK(t, intersect(&s, ray_from((volgrad_vec3){1.1f, 0, 0}, 0, 0, 1, FOG)).kind == VOLGRAD_HIT_NONE);

    lamp->primitives_per_light = 1; /* two triangle lights */
    CHECK(t, intersect(&s, ray_from((volgrad_vec3){.5f, -.5f, 0}, 0, 0, 1, FOG)).light == 7);
    CHECK(t, intersect(&s, ray_from((volgrad_vec3){-.5f, .5f, 0}, 0, 0, 1, FOG)).light == 8);
    end(&s);
}

static void test_distance_limits(tally *t)
{
    test_scene s;
    begin(&s);
    add_rectangle(&s, 1.0f, 0.0f);
    add_rectangle(&s, 1.0f, 2.0f);
    finish(&s);
    volgrad_ray ray = ray_from((volgrad_vec3){.1f, .2f, -1e-5f}, 0, 0, 1, FOG);
    CHECK(t, near(intersect(&s, ray).t, 1e-5));
    ray.t_min = 1e-4f; /* leaves the surface that it starts on */
    CHECK(t, near(intersect(&s, ray).t, 2.00001));
    ray.t_max = 2.0f;
    CHECK(t, intersect(&s, ray).kind == VOLGRAD_HIT_NONE && occluded(&s, ray).kind == VOLGRAD_HIT_NONE);
    CHECK(t, intersect(&s, ray).segments[0].end >= 2.0f && occluded(&s, ray).segments[0].end >= 2.0f);
    ray.t_max = 2.1f;
    CHECK(t, intersect(&s, ray).kind == VOLGRAD_HIT_SURFACE && occluded(&s, ray).kind == VOLGRAD_HIT_SURFACE);
    ray.t_max = 0.0f;
    CHECK(t, intersect(&s, ray).kind == VOLGRAD_HIT_NONE && occluded(&s, ray).kind == VOLGRAD_HIT_NONE);
    end(&s);
}

/* From a point that rounding put on the surface before it: volgrad takes distances > 0 only. */
static void test_start_on_surface(tally *t)
{
    test_scene s;
    begin(&s);
    add_rectangle(&s, 1.0f, 1.98f);
    finish(&s);
    int hits = 0, good = 0;
    uint64_t random = 1;
    for (int i = 0; i < 1000; ++i) {
        volgrad_vec3 origin = random_point(&random, 0.9);
        origin.z = 1.98f;
        volgrad_hit hit = intersect(&s, ray_from(origin, uniform(&random), uniform(&random), 1, FOG));
        hits += hit.kind == VOLGRAD_HIT_SURFACE;
        good += hit.kind == VOLGRAD_HIT_NONE || (hit.t > 0.0f && hit.segments[0].end >= hit.t);
    }
    CHECK(t, hits > 0 && good == 1000);
    end(&s);
}

static void test_ray_to_infinity(tally *t)
{
    test_scene s;
    begin(&s);
    finish(&s);
    volgrad_hit hit = intersect(&s, ray_from(ORIGIN, 1, 2, 3, SMOKE));
    CHECK(t, hit.kind == VOLGRAD_HIT_NONE && hit.light == VOLGRAD_NONE && hit.segment_count == 1);
    CHECK(t, is_segment(&hit, 0, SMOKE, INFINITY));
    end(&s);
}

static void test_bad_rays(tally *t)
{
    test_scene s;
    begin(&s);
    add_cube(&s, 1, VOLGRAD_NONE, FOG, ORIGIN, 1.0f, 0.0);
    finish(&s);
    volgrad_ray good = ray_from(ORIGIN, 0, 0, 1, FOG), bad[4] = {good, good, good, good};
    bad[0].origin.x = NAN;
    bad[1].direction.y = INFINITY;
    bad[2].t_max = NAN;
    bad[3].t_min = NAN;
    for (int i = 0; i < 4; ++i) {
        CHECK(t, intersect(&s, bad[i]).kind == VOLGRAD_HIT_OVERFLOW);
        CHECK(t, occluded(&s, bad[i]).kind == VOLGRAD_HIT_OVERFLOW);
    }
    good.direction = (volgrad_vec3){0, 0, 0}; /* any answer, but one */
    CHECK(t, intersect(&s, good).kind <= VOLGRAD_HIT_OVERFLOW);
    end(&s);
}

/* ---- null surfaces ---- */

static void test_null_cube(tally *t)
{
    test_scene s;
    begin(&s);
    add_cube(&s, 1, VOLGRAD_NONE, FOG, ORIGIN, 1.0f, 0.0);
    finish(&s);
    volgrad_hit hit = intersect(&s, ray_from((volgrad_vec3){-3, .3f, .2f}, 1, 0, 0, VOLGRAD_NONE));
    CHECK(t, hit.kind == VOLGRAD_HIT_NONE && hit.segment_count == 3);
    CHECK(t, is_segment(&hit, 0, VOLGRAD_NONE, 2) && is_normal(hit.segments[0].normal, -1, 0, 0));
    CHECK(t, is_segment(&hit, 1, FOG, 4) && is_normal(hit.segments[1].normal, 1, 0, 0));
    CHECK(t, is_segment(&hit, 2, VOLGRAD_NONE, INFINITY));
    hit = intersect(&s, ray_from(ORIGIN, 0, 0, -1, FOG)); /* through the diagonal of a face, from inside */
    CHECK(t, hit.segment_count == 2 && is_segment(&hit, 0, FOG, 1) && is_segment(&hit, 1, VOLGRAD_NONE, INFINITY));
    end(&s);
}

/* Rays at which two or more triangles are hit at once. */
static void test_edges_and_corners(tally *t)
{
    test_scene s;
    begin(&s);
    add_cube(&s, 1, VOLGRAD_NONE, FOG, ORIGIN, 1.0f, 0.0);
    finish(&s);
    volgrad_hit hit = intersect(&s, ray_from((volgrad_vec3){-2, -2, .25f}, 1, 1, 0, VOLGRAD_NONE)); /* edge to edge */
    CHECK(t, hit.segment_count == 3 && is_segment(&hit, 0, VOLGRAD_NONE, sqrt(2)) && is_segment(&hit, 1, FOG, 3 * sqrt(2)));
    hit = intersect(&s, ray_from((volgrad_vec3){-2, -2, -2}, 1, 1, 1, VOLGRAD_NONE)); /* corner to corner */
    CHECK(t, hit.segment_count == 3 && is_segment(&hit, 0, VOLGRAD_NONE, sqrt(3)) && is_segment(&hit, 1, FOG, 3 * sqrt(3)));
    hit = intersect(&s, ray_from((volgrad_vec3){2, 0, .25f}, -1, 1, 0, VOLGRAD_NONE)); /* brushes an edge */
    CHECK(t, hit.segment_count == 1 && hit.segments[0].medium == VOLGRAD_NONE);
    hit = intersect(&s, ray_from((volgrad_vec3){2, 0, 0}, -1, 1, 1, VOLGRAD_NONE)); /* brushes a corner */
    CHECK(t, hit.segment_count == 1 && hit.segments[0].medium == VOLGRAD_NONE);
    hit = intersect(&s, ray_from((volgrad_vec3){-2, -2, 1}, 1, 1, 0, VOLGRAD_NONE)); /* along a face's diagonal */
    CHECK(t, hit.kind == VOLGRAD_HIT_NONE && hit.segments[hit.segment_count - 1].medium == VOLGRAD_NONE);
    end(&s);
}

static const int EDGES[12][2] = {{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3}, {4, 6}, {5, 7}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};

/* Rays from outside aimed at the edges of a turned cube must be outside again in the end. */
static void test_aimed_at_edges(tally *t)
{
    enum { RAYS = 200000 };
    uint64_t random = 1;
    int leaks = 0;
    test_scene s;
    begin(&s);
    shape *cube = add_cube(&s, 1, VOLGRAD_NONE, FOG, (volgrad_vec3){.1f, .2f, .3f}, .7f, 0.5);
    finish(&s);
    for (int i = 0; i < RAYS; ++i) {
        volgrad_vec3 from = random_point(&random, 4.0);
        if (hypot(hypot(from.x, from.y), from.z) < 2.0) {
            continue;
        }
        const int *edge = EDGES[(int)(12 * uniform(&random))];
        const float *a = cube->positions + 3 * edge[0], *b = cube->positions + 3 * edge[1];
        double u = uniform(&random);
        volgrad_hit hit = intersect(&s, ray_from(from, a[0] + u * (b[0] - a[0]) - from.x, a[1] + u * (b[1] - a[1]) - from.y,
                                                 a[2] + u * (b[2] - a[2]) - from.z, VOLGRAD_NONE));
        leaks += hit.segments[hit.segment_count - 1].medium != VOLGRAD_NONE;
    }
    printf("of %d rays aimed at the edges of a null cube %d end in the wrong medium\n", RAYS, leaks);
    CHECK(t, leaks == 0);
    end(&s);
}

/* The same in small integers, so that rays meet edges without rounding: sides are zero, or what roundings leave. */
static void test_exactly_at_edges(tally *t)
{
    enum { RAYS = 200000, HALF = 3 };
    uint64_t random = 1;
    int leaks = 0;
    test_scene s;
    begin(&s);
    shape *cube = add_cube(&s, 1, VOLGRAD_NONE, FOG, ORIGIN, HALF, 0.0);
    finish(&s);
    for (int i = 0; i < RAYS; ++i) {
        const int *edge = EDGES[(int)(12 * uniform(&random))];
        const float *a = cube->positions + 3 * edge[0], *b = cube->positions + 3 * edge[1];
        float from[3], way[3], step = floorf((float)(2 * HALF + 1) * (float)uniform(&random)) / (2 * HALF), far = 0.0f;
        for (int k = 0; k < 3; ++k) {
            from[k] = floorf(41.0f * (float)uniform(&random)) - 20.0f;
            way[k] = roundf(a[k] + step * (b[k] - a[k])) - from[k];
            far = fmaxf(far, fabsf(from[k]));
        }
        if (far <= HALF) {
            continue;
        }
        volgrad_ray ray = {{from[0], from[1], from[2]}, {way[0], way[1], way[2]}, 0.0f, INFINITY, VOLGRAD_NONE};
        volgrad_hit hit = intersect(&s, ray);
        leaks += hit.segments[hit.segment_count - 1].medium != VOLGRAD_NONE;
    }
    printf("of %d rays exactly at the edges of a null cube %d end in the wrong medium\n", RAYS, leaks);
    CHECK(t, leaks == 0);
    end(&s);
}

static void test_nested_cubes(tally *t)
{
    test_scene s;
    begin(&s);
    add_cube(&s, 1, VOLGRAD_NONE, FOG, ORIGIN, 2.0f, 0.0);
    add_cube(&s, 1, FOG, SMOKE, ORIGIN, 1.0f, 0.0);
    add_cube(&s, 1, VOLGRAD_KEEP_MEDIUM, VOLGRAD_KEEP_MEDIUM, ORIGIN, 1.5f, 0.0); /* bounds nothing */
    finish(&s);
    volgrad_hit hit = intersect(&s, ray_from((volgrad_vec3){.2f, .1f, -3}, 0, 0, 1, VOLGRAD_NONE));
    CHECK(t, hit.segment_count == 5 && is_segment(&hit, 0, VOLGRAD_NONE, 1) && is_segment(&hit, 1, FOG, 2));
    CHECK(t, is_segment(&hit, 2, SMOKE, 4) && is_segment(&hit, 3, FOG, 5) && is_segment(&hit, 4, VOLGRAD_NONE, INFINITY));
    volgrad_ray ray = ray_from((volgrad_vec3){.2f, .1f, 0}, 0, 0, 1, SMOKE);
    ray.t_max = 1.25f;
    hit = occluded(&s, ray);
    CHECK(t, hit.kind == VOLGRAD_HIT_NONE && hit.segment_count == 2);
    CHECK(t, is_segment(&hit, 0, SMOKE, 1) && is_segment(&hit, 1, FOG, 1.25));
    end(&s);
}

/* Two boxes of media that share a face: leaving one to vacuum and entering the other happen at the same distance. */
static void test_touching_cubes(tally *t)
{
    uint64_t random = 3;
    int wrong = 0;
    test_scene s;
    begin(&s);
    add_cube(&s, 1, VOLGRAD_NONE, FOG, (volgrad_vec3){-1, 0, 0}, 1.0f, 0.0);
    add_cube(&s, 1, VOLGRAD_NONE, SMOKE, (volgrad_vec3){1, 0, 0}, 1.0f, 0.0);
    finish(&s);
    for (int i = 0; i < 1000; ++i) {
        volgrad_vec3 to = random_point(&random, 0.5);
        volgrad_ray ray = ray_from((volgrad_vec3){-1.5f, .1f, .2f}, 1.5 + .1 * to.x, to.y, to.z, FOG);
        volgrad_hit hit = intersect(&s, ray);
        wrong += hit.segment_count != 3 || hit.segments[1].medium != SMOKE;
        ray.origin.x = 1.5f;
        ray.direction.x = -ray.direction.x;
        ray.medium = SMOKE;
        hit = intersect(&s, ray);
        wrong += hit.segment_count != 3 || hit.segments[1].medium != FOG;
    }
    CHECK(t, wrong == 0);
    end(&s);
}

static void test_null_before_t_min(tally *t)
{
    test_scene s;
    begin(&s);
    add_cube(&s, 1, VOLGRAD_NONE, FOG, ORIGIN, 1.0f, 0.0);
    add_rectangle(&s, 1.0f, 0.99995f);
    finish(&s);
    volgrad_ray ray = ray_from((volgrad_vec3){.2f, .1f, .9999f}, 0, 0, 1, FOG);
    ray.t_min = 1e-3f; /* skips the rectangle and not the fog's end, both nearer than this */
    volgrad_hit hit = intersect(&s, ray);
    CHECK(t, hit.kind == VOLGRAD_HIT_NONE && hit.segment_count == 2);
    CHECK(t, hit.segments[0].medium == FOG && hit.segments[1].medium == VOLGRAD_NONE);
    ray.t_min = 0.0f;
    CHECK(t, intersect(&s, ray).kind == VOLGRAD_HIT_SURFACE && intersect(&s, ray).segment_count == 1);
    end(&s);
}

static void test_overflow(tally *t)
{
    crossing_list list;
    volgrad_segment segments[VOLGRAD_MAX_SEGMENTS];
    crossings_clear(&list);
    for (uint32_t i = 0; i < 2 * CROSSINGS_CAPACITY; ++i) {
        uint32_t place = (i * 37) % (2 * CROSSINGS_CAPACITY); /* any order */
        crossings_add(&list, &(crossing){.t = 1.0 + place, .medium = place % 2, .shape = place});
    }
    CHECK(t, crossings_segments(&list, VOLGRAD_NONE, INFINITY, segments) == 0);
    CHECK(t, crossings_segments(&list, VOLGRAD_NONE, CROSSINGS_CAPACITY + 0.5, segments) == 0);
    CHECK(t, crossings_segments(&list, VOLGRAD_NONE, VOLGRAD_MAX_SEGMENTS - 0.5, segments) == VOLGRAD_MAX_SEGMENTS);
    CHECK(t, crossings_segments(&list, VOLGRAD_NONE, VOLGRAD_MAX_SEGMENTS + 0.5, segments) == 0);
}

/* ---- the medium at a point ---- */

static uint32_t medium_at(const test_scene *s, float x, float y, float z)
{
    return embree_queries_medium_at(s->queries, (volgrad_vec3){x, y, z});
}

/* Seen from a camera in the fog of the outer cube: null and opaque surfaces tell media apart, those that bound none do not. */
static void test_medium_at(tally *t)
{
    test_scene s;
    begin(&s);
    add_cube(&s, 1, VOLGRAD_NONE, FOG, ORIGIN, 4.0f, 0.0);
    add_sphere(&s, 1, FOG, SMOKE, (volgrad_vec3){2, 0, 0}, 1.0f);
    add_sphere(&s, 0, FOG, GLASS_INSIDE, (volgrad_vec3){-2, 0, 0}, 1.0f);
    add_cube(&s, 0, FOG, VOLGRAD_NONE, (volgrad_vec3){0, 2, 0}, .5f, .3);
    add_cube(&s, 0, VOLGRAD_KEEP_MEDIUM, VOLGRAD_KEEP_MEDIUM, (volgrad_vec3){0, -2, 0}, .5f, .3);
    add_rectangle(&s, 9.0f, -1.5f);
    s.scene.desc.camera.medium = FOG;
    s.scene.desc.camera.position = (volgrad_vec3){.1f, .2f, -3};
    finish(&s);
    CHECK(t, medium_at(&s, .1f, .2f, -3) == FOG && medium_at(&s, .3f, .1f, .2f) == FOG && medium_at(&s, 0, 0, 3.9f) == FOG);
    CHECK(t, medium_at(&s, 2, 0, 0) == SMOKE && medium_at(&s, 2.9f, 0, 0) == SMOKE && medium_at(&s, 2, 0, 1.1f) == FOG);
    CHECK(t, medium_at(&s, -2, 0, 0) == GLASS_INSIDE && medium_at(&s, -2.8f, .1f, .2f) == GLASS_INSIDE);
    CHECK(t, medium_at(&s, -3.5f, .2f, 3) == FOG); /* beyond the glass */
    CHECK(t, medium_at(&s, .1f, 2, .1f) == VOLGRAD_NONE && medium_at(&s, .1f, 3, .1f) == FOG);
    CHECK(t, medium_at(&s, .1f, -2, .1f) == FOG); /* inside what bounds no medium */
    CHECK(t, medium_at(&s, 5, 0, 0) == VOLGRAD_NONE && medium_at(&s, 3, 0, 60) == VOLGRAD_NONE);
    end(&s);
}

static void test_camera_outside(tally *t)
{
    test_scene s;
    begin(&s);
    add_cube(&s, 1, VOLGRAD_NONE, FOG, ORIGIN, 1.0f, 0.2);
    s.scene.desc.camera.medium = VOLGRAD_NONE;
    s.scene.desc.camera.position = (volgrad_vec3){0, 0, -9};
    s.scene.desc.camera.forward = (volgrad_vec3){0, 0, 1};
    finish(&s);
    CHECK(t, medium_at(&s, 0, 0, 0) == FOG && medium_at(&s, .1f, 0, 7) == VOLGRAD_NONE && medium_at(&s, 3, 0, 0) == VOLGRAD_NONE);
    s.scene.desc.camera.near_clip = 9; /* a camera in vacuum whose near plane is in the fog */
    s.scene.desc.camera.medium = FOG;
    CHECK(t, medium_at(&s, 0, .1f, 0) == FOG && medium_at(&s, 1, 0, -9) == VOLGRAD_NONE);
    end(&s);
}

static void check_light_medium(tally *t, const char *file, uint32_t light, uint32_t medium)
{
    scene s;
    const char *problem = "";
    CHECK(t, scene_load(file, &s));
    embree_queries *queries = embree_queries_create(&s, 1, &problem);
    CHECK(t, queries != NULL && s.desc.lights[light].medium == VOLGRAD_NONE);
    light_media_find(&s, queries);
    CHECK(t, s.desc.lights[light].medium == medium);
    embree_queries_destroy(queries);
    scene_free(&s);
}

static void test_lights_of_scenes(tally *t)
{
    check_light_medium(t, "scenes/caustic.xml", 0, 0);         /* a lamp in the fog, the camera outside */
    check_light_medium(t, "scenes/room.xml", 0, VOLGRAD_NONE); /* a lamp outside, the camera in the smoke */
}

/* Lights of each kind on both sides of the surface of a ball of fog. */
static void test_kinds_of_lights(tally *t)
{
    const volgrad_light lights[] = {
        {.kind = VOLGRAD_LIGHT_POINT, .position = {0, 0, .9f}},
        {.kind = VOLGRAD_LIGHT_SPOT, .position = {0, 0, 1.1f}},
        {.kind = VOLGRAD_LIGHT_SPHERE, .position = {0, 0, 0}, .radius = .5f},
        {.kind = VOLGRAD_LIGHT_SPHERE, .position = {0, 0, 3}, .radius = 1.9f},
        {.kind = VOLGRAD_LIGHT_TRIANGLE, .position = {-.1f, .2f, .9f}, .edge_u = {.2f, 0, 0}, .edge_v = {0, .2f, 0}},
        {.kind = VOLGRAD_LIGHT_PARALLELOGRAM, .position = {-1, 1, 1.01f}, .edge_u = {2, 0, 0}, .edge_v = {0, -2, 0}},
        {.kind = VOLGRAD_LIGHT_DIRECTIONAL, .medium = VOLGRAD_NONE},
        {.kind = VOLGRAD_LIGHT_ENVIRONMENT, .medium = VOLGRAD_NONE}};
    const uint32_t media[] = {FOG, VOLGRAD_NONE, FOG, VOLGRAD_NONE, FOG, VOLGRAD_NONE, VOLGRAD_NONE, VOLGRAD_NONE};
    volgrad_light found[sizeof lights / sizeof *lights];
    memcpy(found, lights, sizeof lights);
    test_scene s;
    begin(&s);
    add_sphere(&s, 1, VOLGRAD_NONE, FOG, ORIGIN, 1.0f);
    s.scene.desc.camera.medium = VOLGRAD_NONE;
    s.scene.desc.camera.position = (volgrad_vec3){.1f, .2f, -5};
    s.scene.desc.lights = found;
    s.scene.desc.light_count = sizeof lights / sizeof *lights;
    finish(&s);
    light_media_find(&s.scene, s.queries);
    for (uint32_t i = 0; i < s.scene.desc.light_count; ++i) {
        CHECK(t, found[i].medium == media[i]);
    }
    end(&s);
}

/* Lights whose own surface bounds the medium begin in what is in front of it, also when they look away from the camera. */
static void test_surface_that_is_a_light(tally *t)
{
    test_scene s;
    volgrad_light lamps[] = {
        {.kind = VOLGRAD_LIGHT_PARALLELOGRAM, .position = {-1, -1, 2}, .edge_u = {2, 0, 0}, .edge_v = {0, 2, 0}},
        {.kind = VOLGRAD_LIGHT_SPHERE, .position = {0, 0, -4}, .radius = 1}};
    begin(&s);
    add_sphere(&s, 0, FOG, SMOKE, lamps[1].position, lamps[1].radius);
    shape *surface = add_rectangle(&s, 1.0f, 2.0f);
    surface->medium_outside = SMOKE, surface->medium_inside = FOG;
    s.scene.desc.camera.medium = FOG;
    s.scene.desc.lights = lamps;
    s.scene.desc.light_count = 2;
    finish(&s);
    light_media_find(&s.scene, s.queries);
    CHECK(t, lamps[0].medium == SMOKE && lamps[1].medium == FOG);
    end(&s);
}

/* ---- spheres ---- */

static void test_null_sphere(tally *t)
{
    test_scene s;
    begin(&s);
    add_sphere(&s, 1, VOLGRAD_NONE, FOG, (volgrad_vec3){0, 0, 5}, 2.0f);
    finish(&s);
    volgrad_hit hit = intersect(&s, ray_from(ORIGIN, 0, 0, 1, VOLGRAD_NONE)); /* both its sides end a segment */
    CHECK(t, hit.segment_count == 3 && is_segment(&hit, 0, VOLGRAD_NONE, 3) && is_segment(&hit, 1, FOG, 7));
    CHECK(t, is_normal(hit.segments[0].normal, 0, 0, -1) && is_normal(hit.segments[1].normal, 0, 0, 1));
    hit = intersect(&s, ray_from((volgrad_vec3){0, 0, 6}, 0, 0, 1, FOG));
    CHECK(t, hit.segment_count == 2 && is_segment(&hit, 0, FOG, 1) && is_segment(&hit, 1, VOLGRAD_NONE, INFINITY));
    end(&s);
}

static void test_glass_sphere(tally *t)
{
    test_scene s;
    begin(&s);
    add_sphere(&s, 0, FOG, VOLGRAD_NONE, ORIGIN, 1.0f)->material = 5;
    finish(&s);
    volgrad_hit hit = intersect(&s, ray_from((volgrad_vec3){0, 0, -3}, 0, 0, 1, FOG));
    CHECK(t, hit.kind == VOLGRAD_HIT_SURFACE && near(hit.t, 2) && hit.material == 5 && is_normal(hit.normal, 0, 0, -1));
    CHECK(t, hit.medium_outside == FOG && hit.medium_inside == VOLGRAD_NONE && is_segment(&hit, 0, FOG, 2));
    volgrad_ray inside = ray_from((volgrad_vec3){0, 0, -1}, 0, .6, .8, VOLGRAD_NONE); /* refracted into the sphere */
    inside.t_min = 1e-4f;
    hit = intersect(&s, inside);
    CHECK(t, hit.kind == VOLGRAD_HIT_SURFACE && near(hit.t, 1.6) && is_segment(&hit, 0, VOLGRAD_NONE, 1.6));
    CHECK(t, is_normal(hit.normal, 0, .96, .28) && hit.light == VOLGRAD_NONE);
    inside.t_max = 1.5f;
    hit = occluded(&s, inside);
    CHECK(t, hit.kind == VOLGRAD_HIT_NONE && hit.segment_count == 1 && is_segment(&hit, 0, VOLGRAD_NONE, 1.5));
    inside.t_max = 1.7f;
    CHECK(t, occluded(&s, inside).kind == VOLGRAD_HIT_SURFACE);
    end(&s);
}

/* ---- against a slow search ---- */

typedef struct {
    double t;
    uint32_t medium;
} change;

typedef struct {
    double hit; /* INFINITY: none */
    change changes[64];
    int count;
} slow_answer;

static void slow_meet(slow_answer *answer, const shape *s, const volgrad_ray *ray, double t, int leaves)
{
    if (s->is_null && t > 0.0) {
        answer->changes[answer->count++] = (change){t, leaves ? s->medium_outside : s->medium_inside};
    } else if (!s->is_null && t >= ray->t_min && t < ray->t_max && t < answer->hit) {
        answer->hit = t;
    }
}

/* Solves origin + t d = a + u e1 + v e2 by Cramer's rule. */
static void slow_triangle(slow_answer *answer, const shape *s, const volgrad_ray *ray, uint32_t triangle)
{
    double a[3], e1[3], e2[3], o[3], n[3], q[3];
    const double d[3] = {ray->direction.x, ray->direction.y, ray->direction.z};
    const double origin[3] = {ray->origin.x, ray->origin.y, ray->origin.z};
    const uint32_t *index = s->triangles + 3 * triangle;
    for (int k = 0; k < 3; ++k) {
        a[k] = s->positions[3 * index[0] + k];
        e1[k] = s->positions[3 * index[1] + k] - a[k];
        e2[k] = s->positions[3 * index[2] + k] - a[k];
        o[k] = origin[k] - a[k];
    }
    for (int k = 0; k < 3; ++k) {
        int l = (k + 1) % 3, m = (k + 2) % 3;
        n[k] = e1[l] * e2[m] - e1[m] * e2[l];
        q[k] = o[l] * d[m] - o[m] * d[l];
    }
    double determinant = -(n[0] * d[0] + n[1] * d[1] + n[2] * d[2]);
    double u = (e2[0] * q[0] + e2[1] * q[1] + e2[2] * q[2]) / determinant;
    double v = -(e1[0] * q[0] + e1[1] * q[1] + e1[2] * q[2]) / determinant;
    if (u >= 0 && v >= 0 && u + v <= 1) {
        slow_meet(answer, s, ray, (o[0] * n[0] + o[1] * n[1] + o[2] * n[2]) / determinant, determinant < 0);
    }
}

static void slow_sphere(slow_answer *answer, const shape *s, const volgrad_ray *ray)
{
    double dx = ray->direction.x, dy = ray->direction.y, dz = ray->direction.z;
    double x = ray->origin.x - (double)s->center.x, y = ray->origin.y - (double)s->center.y, z = ray->origin.z - (double)s->center.z;
    double a = dx * dx + dy * dy + dz * dz, b = x * dx + y * dy + z * dz;
    double root = b * b - a * (x * x + y * y + z * z - (double)s->radius * s->radius);
    if (root > 0) {
        slow_meet(answer, s, ray, (-b - sqrt(root)) / a, 0);
        slow_meet(answer, s, ray, (-b + sqrt(root)) / a, 1);
    }
}

static int by_distance(const void *a, const void *b)
{
    double ta = ((const change *)a)->t, tb = ((const change *)b)->t;
    return (ta > tb) - (ta < tb);
}

static slow_answer slow_search(const test_scene *s, const volgrad_ray *ray)
{
    slow_answer answer = {.hit = INFINITY};
    for (uint32_t i = 0; i < s->scene.shape_count; ++i) {
        if (s->shapes[i].kind == SHAPE_SPHERE) {
            slow_sphere(&answer, &s->shapes[i], ray);
        }
        for (uint32_t k = 0; s->shapes[i].kind == SHAPE_MESH && k < s->shapes[i].triangle_count; ++k) {
            slow_triangle(&answer, &s->shapes[i], ray, k);
        }
    }
    qsort(answer.changes, (size_t)answer.count, sizeof answer.changes[0], by_distance);
    return answer;
}

static uint32_t slot(uint32_t medium)
{
    return medium == VOLGRAD_NONE ? VACUUM_SLOT : medium;
}

static void slow_lengths(const slow_answer *answer, uint32_t medium, double ray_end, double lengths[MEDIA + 1])
{
    double at = 0.0;
    for (int i = 0; i < answer->count && answer->changes[i].t < ray_end; ++i) {
        lengths[slot(medium)] += answer->changes[i].t - at;
        at = answer->changes[i].t;
        medium = answer->changes[i].medium;
    }
    lengths[slot(medium)] += ray_end - at;
}

static double lengths_error(const volgrad_hit *hit, const slow_answer *slow, uint32_t medium, double ray_end)
{
    double lengths[MEDIA + 1] = {0}, expected[MEDIA + 1] = {0}, at = 0.0, worst = 0.0;
    slow_lengths(slow, medium, ray_end, expected);
    for (uint32_t i = 0; i < hit->segment_count; ++i) {
        lengths[slot(hit->segments[i].medium)] += hit->segments[i].end - at;
        at = hit->segments[i].end;
    }
    for (int i = 0; i <= MEDIA; ++i) {
        worst = fmax(worst, fabs(lengths[i] - expected[i]));
    }
    return worst;
}

static void make_crowd(test_scene *s)
{
    begin(s);
    add_cube(s, 1, VOLGRAD_NONE, FOG, ORIGIN, 2.0f, 0.3);
    add_cube(s, 1, FOG, SMOKE, (volgrad_vec3){.3f, .2f, -.1f}, 1.0f, 0.7);
    add_sphere(s, 1, SMOKE, FOG, (volgrad_vec3){.3f, .2f, -.1f}, .6f);
    add_sphere(s, 0, FOG, GLASS_INSIDE, (volgrad_vec3){-.9f, -1.f, 1.f}, .4f);
    add_cube(s, 0, FOG, VOLGRAD_NONE, (volgrad_vec3){1.2f, -1.2f, .9f}, .2f, 0.1);
    add_rectangle(s, 5.0f, -4.0f);
    finish(s);
}

static void test_random_rays(tally *t)
{
    enum { RAYS = 100000 };
    uint64_t random = 20;
    int wrong = 0, hits = 0;
    double worst = 0.0, worst_t = 0.0;
    test_scene s;
    make_crowd(&s);
    for (int i = 0; i < RAYS; ++i) {
        volgrad_vec3 from = random_point(&random, 6.0), to = random_point(&random, 2.0);
        volgrad_ray ray = ray_from(from, to.x - from.x, to.y - from.y, to.z - from.z, VOLGRAD_NONE);
        ray.t_max = (float)(20.0 * uniform(&random));
        slow_answer slow = slow_search(&s, &ray);
        volgrad_hit hit = intersect(&s, ray), shadow = occluded(&s, ray);
        int slow_hits = slow.hit < ray.t_max;
        hits += slow_hits;
        if ((hit.kind == VOLGRAD_HIT_SURFACE) != slow_hits || hit.kind != shadow.kind) {
            wrong++;
            continue;
        }
        double error = lengths_error(&hit, &slow, ray.medium, slow_hits ? slow.hit : ray.t_max);
        if (slow_hits) {
            worst_t = fmax(worst_t, fabs(hit.t - slow.hit) / slow.hit);
        } else {
            error = fmax(error, lengths_error(&shadow, &slow, ray.medium, ray.t_max));
        }
        wrong += error > 1e-5;
        worst = error > 1e-5 ? worst : fmax(worst, error);
    }
    printf("of %d random rays (%d hits) %d differ; otherwise distances agree to %.1e, lengths in media to %.1e\n", RAYS, hits, wrong,
           worst_t, worst);
    CHECK(t, wrong == 0);
    end(&s);
}

/* How exact spheres are from afar: 40 and 2000 radii. */
static void test_sphere_precision(tally *t)
{
    uint64_t random = 5;
    for (double distance = 20.0; distance < 1001.0; distance *= 50.0) {
        double worst = 0.0;
        test_scene s;
        begin(&s);
        add_sphere(&s, 0, VOLGRAD_NONE, VOLGRAD_NONE, (volgrad_vec3){.3f, -.2f, .1f}, .5f);
        finish(&s);
        for (int i = 0; i < 50000; ++i) {
            volgrad_vec3 from = random_point(&random, distance), to = random_point(&random, .8);
            volgrad_ray ray = ray_from(from, to.x - from.x, to.y - from.y, to.z - from.z, VOLGRAD_NONE);
            volgrad_hit hit = intersect(&s, ray);
            slow_answer slow = slow_search(&s, &ray);
            double error = hit.kind == VOLGRAD_HIT_NONE && slow.hit == INFINITY ? 0.0 : fabs(hit.t - slow.hit) / slow.hit;
            worst = fmax(worst, error);
        }
        printf("a sphere seen from %g radii: distances agree to %.1e of themselves\n", 2 * distance, worst);
        CHECK(t, worst < 2e-7); /* the rounding of t itself, and of the slow root */
        end(&s);
    }
}

int main(void)
{
    tally t = {0, 0};
    test_rectangle(&t);
    test_distance_limits(&t);
    test_start_on_surface(&t);
    test_ray_to_infinity(&t);
    test_bad_rays(&t);
    test_null_cube(&t);
    test_edges_and_corners(&t);
    test_aimed_at_edges(&t);
    test_exactly_at_edges(&t);
    test_nested_cubes(&t);
    test_touching_cubes(&t);
    test_null_before_t_min(&t);
    test_overflow(&t);
    test_medium_at(&t);
    test_camera_outside(&t);
    test_lights_of_scenes(&t);
    test_kinds_of_lights(&t);
    test_surface_that_is_a_light(&t);
    test_null_sphere(&t);
    test_glass_sphere(&t);
    test_random_rays(&t);
    test_sphere_precision(&t);
    printf("%d passed, %d failed\n", t.passed, t.failed);
    return t.failed > 0;
}
