/* Paths: contribution, factors, gradient, and what volgrad_path_validate says. */

#include "small_scene.h"

static const double PI = 3.14159265358979323846;
static const volgrad_scene *scene;
static alignas(16) unsigned char zeros[1 << 12]; /* memory that is no scene */

#define NO_SCENE ((const volgrad_scene *)(const void *)zeros)
#define ODD_SCENE ((const volgrad_scene *)(const void *)(zeros + 1))

/* Camera at the origin, a vertex in the fog, a point light. */
static volgrad_vertex vertices[3];
static volgrad_segment segments[2];
static uint32_t ends[2];
static volgrad_path path;

static void fill_path(void) {
    memset(vertices, 0, sizeof vertices);
    memset(segments, 0, sizeof segments);
    vertices[1].kind = VOLGRAD_VERTEX_MEDIUM, vertices[1].position = vec(0, 0, 3);
    vertices[2].kind = VOLGRAD_VERTEX_LIGHT, vertices[2].position = vec(0, 2, 3), vertices[2].index = POINT_LIGHT;
    segments[0].end = 3, segments[1].end = 2;
    ends[0] = 1, ends[1] = 2;
    path = (volgrad_path){vertices, segments, ends, 3, 2};
}

/* All functions of a path refuse it, or (where validate alone can tell) `volgrad_path_validate`; the error's index is `index`. */
static void refuse_path(const volgrad_scene *in, const volgrad_path *p, volgrad_status status, int64_t index, int all,
                        const char *what, int at) {
    volgrad_error error = {sizeof error, 77, NULL};
    check_status(volgrad_path_validate(in, p, &error), status, what, __FILE__, at);
    check_that(index < 0 || error.index == index, "the index of the error", __FILE__, at);
    if (error.index != index && index >= 0) fprintf(stderr, "  %s: blamed %u\n", what, (unsigned)error.index);
    check_status(volgrad_path_validate(in, p, NULL), status, what, __FILE__, at);
    double rgb[3];
    volgrad_path_factor factors[3];
    volgrad_gradient gradient;
    volgrad_derivative derivative;
    FILL(rgb), FILL(factors), FILL(gradient), FILL(derivative);
    volgrad_status got[4] = {volgrad_path_contribution(in, p, rgb), volgrad_path_factors(in, p, factors, 3),
                             volgrad_path_log_gradient(in, p, 1, &gradient),
                             volgrad_path_run_log_gradient(in, p, 1, 1, &gradient)};
    for (int i = 0; i < 4 && all; i++) check_status(got[i], status, what, __FILE__, at);
    check_that(!all || (UNTOUCHED(rgb) && UNTOUCHED(factors) && UNTOUCHED(gradient)), what, __FILE__, at);
    check_that(volgrad_path_run_log_derivative(in, p, 1, 1, &derivative) != VOLGRAD_OK && UNTOUCHED(derivative), what, __FILE__, at);
    fill_path();
}

#define BAD_PATH(set, status, index) ((set), refuse_path(scene, &path, (status), (index), 1, #set, __LINE__))
#define INVALID_PATH(set, status, index) ((set), refuse_path(scene, &path, (status), (index), 0, #set, __LINE__))

static void test_path_errors(void) {
    refuse_path(NULL, &path, VOLGRAD_ERROR_NULL, -1, 1, "scene NULL", __LINE__);
    refuse_path(scene, NULL, VOLGRAD_ERROR_NULL, -1, 1, "path NULL", __LINE__);
    refuse_path(ODD_SCENE, &path, VOLGRAD_ERROR_MISALIGNED, -1, 1, "scene misaligned", __LINE__);
    refuse_path(NO_SCENE, &path, VOLGRAD_ERROR_NOT_INITIALISED, -1, 1, "scene of zeros", __LINE__);
    BAD_PATH(path.vertices = NULL, VOLGRAD_ERROR_NULL, -1);
    BAD_PATH(path.segments = NULL, VOLGRAD_ERROR_NULL, -1);
    BAD_PATH(path.edge_ends = NULL, VOLGRAD_ERROR_NULL, -1);
    BAD_PATH(path.vertices = (const void *)(zeros + 1), VOLGRAD_ERROR_MISALIGNED, -1);
    BAD_PATH(path.vertex_count = 0, VOLGRAD_ERROR_RANGE, -1);
    BAD_PATH(path.vertex_count = 1, VOLGRAD_ERROR_RANGE, -1);
    BAD_PATH(vertices[1].kind = 4, VOLGRAD_ERROR_KIND, 1);
    BAD_PATH(vertices[1].kind = VOLGRAD_VERTEX_LIGHT, VOLGRAD_ERROR_KIND, 1);
    BAD_PATH(vertices[2].kind = VOLGRAD_VERTEX_MEDIUM, VOLGRAD_ERROR_KIND, 2);
    INVALID_PATH(vertices[0].kind = VOLGRAD_VERTEX_MEDIUM, VOLGRAD_ERROR_KIND, 0);
    BAD_PATH(vertices[1].index = 1, VOLGRAD_ERROR_INDEX, 1);
    double rgb[3];
    FILL(rgb), vertices[1].position.x = INFINITY;
    CHECK_STATUS(volgrad_path_contribution(scene, &path, rgb), VOLGRAD_ERROR_ZERO_LENGTH);
    CHECK(UNTOUCHED(rgb));
    fill_path();
    BAD_PATH(vertices[1].index = VOLGRAD_NONE, VOLGRAD_ERROR_INDEX, 1);
    BAD_PATH(vertices[2].index = LIGHTS, VOLGRAD_ERROR_INDEX, 2);
    BAD_PATH(path.segment_count = 1, VOLGRAD_ERROR_SEGMENTS, 1);
    BAD_PATH(path.segment_count = 0, VOLGRAD_ERROR_SEGMENTS, 0);
    BAD_PATH(ends[0] = 0, VOLGRAD_ERROR_SEGMENTS, 0);
    BAD_PATH(ends[0] = 3, VOLGRAD_ERROR_SEGMENTS, 0);
    BAD_PATH(ends[1] = 0, VOLGRAD_ERROR_SEGMENTS, 1);
    BAD_PATH(ends[1] = UINT32_MAX, VOLGRAD_ERROR_SEGMENTS, 1);
    BAD_PATH(vertices[1].position = vec(0, 0, 0), VOLGRAD_ERROR_ZERO_LENGTH, 0);
    BAD_PATH(vertices[2].position = vertices[1].position, VOLGRAD_ERROR_ZERO_LENGTH, 1);

    INVALID_PATH(vertices[1].position.x = NAN, VOLGRAD_ERROR_NOT_FINITE, 1);
    INVALID_PATH(vertices[2].position.z = INFINITY, VOLGRAD_ERROR_NOT_FINITE, 2);
    INVALID_PATH((vertices[2].index = SKY, segments[1].end = INFINITY), VOLGRAD_ERROR_NOT_FINITE, 2); /* not a unit vector */
    INVALID_PATH((vertices[1].kind = VOLGRAD_VERTEX_SURFACE), VOLGRAD_ERROR_NOT_FINITE, 1);           /* nor this normal */
    INVALID_PATH((vertices[2].position.x = 0.5f, segments[1].end = 4), VOLGRAD_ERROR_RANGE, 2); /* not where the light is */
    volgrad_segment many[VOLGRAD_MAX_SEGMENTS + 2];
    for (int i = 0; i < VOLGRAD_MAX_SEGMENTS + 2; i++) many[i] = (volgrad_segment){4, 0, {0, 0, 1}};
    INVALID_PATH((path.segments = many, path.segment_count = 17, ends[0] = 16, ends[1] = 17), VOLGRAD_OK, -1);
    INVALID_PATH((path.segments = many, path.segment_count = 18, ends[0] = 17, ends[1] = 18), VOLGRAD_ERROR_SEGMENTS, 0);
    INVALID_PATH(segments[1].medium = 1, VOLGRAD_ERROR_INDEX, 1);
    INVALID_PATH(segments[0].medium = VOLGRAD_NONE, VOLGRAD_ERROR_SEGMENTS, 0);
    INVALID_PATH(segments[1].medium = VOLGRAD_NONE, VOLGRAD_ERROR_SEGMENTS, 1);
    INVALID_PATH(segments[0].end = 2.9f, VOLGRAD_ERROR_SEGMENTS, 0);
    INVALID_PATH(segments[1].end = NAN, VOLGRAD_ERROR_SEGMENTS, 1);
    INVALID_PATH(segments[0].normal.y = NAN, VOLGRAD_OK, -1); /* the last of its edge: unused */
    INVALID_PATH(vertices[0].position.y = NAN, VOLGRAD_OK, -1); /* the scene knows where the camera is */
    volgrad_segment three[3] = {{2, 0, {0, 0, 1}}, {1, 0, {0, 0, 1}}, {2, 0, {0, 0, 0}}};
    INVALID_PATH((path.segments = three, path.segment_count = 3, ends[0] = 2, ends[1] = 3), VOLGRAD_ERROR_SEGMENTS, 0);
    three[1].end = 3;
    INVALID_PATH((path.segments = three, path.segment_count = 3, ends[0] = 2, ends[1] = 3), VOLGRAD_OK, -1);
    three[0].normal = vec(0, 0, 2);
    path.segments = three, path.segment_count = 3, ends[0] = 2, ends[1] = 3; /* a normal twice as long as it should be */
    CHECK(volgrad_path_validate(scene, &path, NULL) != VOLGRAD_OK);
    three[0].normal = vec(0, NAN, 0);
    CHECK(volgrad_path_validate(scene, &path, NULL) != VOLGRAD_OK);
    fill_path();
}

static void test_path_values(void) {
    double f[3];
    volgrad_path_factor factors[4];
    volgrad_gradient gradient;
    CHECK_STATUS(volgrad_path_validate(scene, &path, NULL), VOLGRAD_OK);
    CHECK_STATUS(volgrad_path_contribution(scene, &path, f), VOLGRAD_OK);
    /* We = 1/4; G = 1/9, 1/4; Tr = exp(-3), exp(-2); sigma_s = 1/2. */
    double expected = exp(-5) * 0.25 / 9 / 4 * 0.5 / (4 * PI);
    CHECK_NEAR(f[0], expected, 1e-7 * expected);
    CHECK_NEAR(f[2], expected, 1e-7 * expected);

    FILL(factors);
    CHECK_STATUS(volgrad_path_factors(scene, &path, factors, 4), VOLGRAD_OK);
    CHECK(UNTOUCHED(factors[3]));
    double product = 1;
    for (int i = 0; i < 3; i++) product *= factors[i].vertex.g * factors[i].transmittance.g * factors[i].geometry;
    CHECK_NEAR(product, f[1], 1e-6 * f[1]);
    CHECK_NEAR(factors[0].transmittance.r, exp(-3), 1e-7);
    CHECK(factors[2].geometry == 1 && factors[2].transmittance.r == 1);

    CHECK_STATUS(volgrad_path_log_gradient(scene, &path, 1, &gradient), VOLGRAD_OK);
    const volgrad_vec3 got[2] = {gradient.luminance, gradient.rgb[0]};
    for (int i = 0; i < 2; i++) {
        CHECK_NEAR(got[i].x, 0, 1e-6);
        CHECK_NEAR(got[i].y, 2, 1e-6);
        CHECK_NEAR(got[i].z, -5.0 / 3, 1e-6);
    }
    CHECK_NEAR(gradient.transmittance_previous[1].z, -1, 1e-6);
    CHECK_NEAR(gradient.geometry_next.y, 1, 1e-6);

    CHECK_STATUS(volgrad_path_contribution(scene, &path, NULL), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_path_factors(scene, &path, NULL, 3), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_path_log_gradient(scene, &path, 1, NULL), VOLGRAD_ERROR_NULL);
    REFUSED(factors, volgrad_path_factors(scene, &path, factors, 2), VOLGRAD_ERROR_TOO_SMALL);
    REFUSED(factors, volgrad_path_factors(scene, &path, factors, 0), VOLGRAD_ERROR_TOO_SMALL);
    REFUSED(gradient, volgrad_path_log_gradient(scene, &path, 0, &gradient), VOLGRAD_ERROR_NOT_MOVABLE);
    REFUSED(gradient, volgrad_path_log_gradient(scene, &path, 2, &gradient), VOLGRAD_ERROR_NOT_MOVABLE);
    REFUSED(gradient, volgrad_path_log_gradient(scene, &path, 3, &gradient), VOLGRAD_ERROR_INDEX);
    REFUSED(gradient, volgrad_path_log_gradient(scene, &path, UINT32_MAX, &gradient), VOLGRAD_ERROR_INDEX);

    /* Behind the camera nothing is seen. */
    vertices[1].position.z = -3, vertices[2].position.z = -3;
    CHECK_STATUS(volgrad_path_contribution(scene, &path, f), VOLGRAD_OK);
    CHECK(f[0] == 0 && f[1] == 0 && f[2] == 0);
    REFUSED(gradient, volgrad_path_log_gradient(scene, &path, 1, &gradient), VOLGRAD_ERROR_ZERO_CONTRIBUTION);
    fill_path();

    /* Camera, fog, a surface with its back or its mirror to the fog, light. */
    volgrad_vertex four[4] = {vertices[0], vertices[1], vertices[2], vertices[2]};
    volgrad_segment media[3] = {{3, 0, {0, 0, 0}}, {1, 0, {0, 0, 0}}, {1, 0, {0, 0, 0}}};
    const uint32_t three_ends[3] = {1, 2, 3};
    four[2].kind = VOLGRAD_VERTEX_SURFACE, four[2].position = vec(0, 0, 4), four[2].normal = vec(0, 0, 1);
    four[3].position = vec(0, 0, 5);
    volgrad_path longer = {four, media, three_ends, 4, 3};
    four[2].index = DIFFUSE;
    REFUSED(gradient, volgrad_path_log_gradient(scene, &longer, 1, &gradient), VOLGRAD_ERROR_ZERO_CONTRIBUTION);
    REFUSED(gradient, volgrad_path_log_gradient(scene, &longer, 2, &gradient), VOLGRAD_ERROR_NOT_MOVABLE);
    for (uint32_t specular = MIRROR; specular <= GLASS; specular++) {
        four[2].index = specular;
        REFUSED(gradient, volgrad_path_log_gradient(scene, &longer, 1, &gradient), VOLGRAD_ERROR_NOT_MOVABLE);
    }
    four[2].index = MATERIALS;
    REFUSED(f, volgrad_path_contribution(scene, &longer, f), VOLGRAD_ERROR_INDEX);
}

/* Camera, two vertices in the fog, and a third: a light, or a surface and then the light. */
static volgrad_vertex long_vertices[5];
static volgrad_segment long_segments[4];
static const uint32_t long_ends[4] = {1, 2, 3, 4};

static volgrad_path long_path(volgrad_vertex third) {
    memset(long_vertices, 0, sizeof long_vertices);
    memset(long_segments, 0, sizeof long_segments);
    for (int i = 0; i < 4; i++) long_segments[i].end = 4;
    long_vertices[1] = long_vertices[2] = vertices[1];
    long_vertices[2].position = vec(0, 1, 3);
    long_vertices[3] = third;
    long_vertices[4] = vertices[2];
    uint32_t count = third.kind == VOLGRAD_VERTEX_LIGHT ? 4 : 5;
    return (volgrad_path){long_vertices, long_segments, long_ends, count, count - 1};
}

static void test_runs(void) {
    volgrad_path lit = long_path(vertices[2]);
    volgrad_gradient run, one, two;
    CHECK_STATUS(volgrad_path_validate(scene, &lit, NULL), VOLGRAD_OK);
    CHECK_STATUS(volgrad_path_run_log_gradient(scene, &lit, 1, 2, &run), VOLGRAD_OK);
    /* The camera's edge as in test_path_values, one of length 1 to the light, and nothing of the one between. */
    CHECK_NEAR(run.luminance.x, 0, 1e-6);
    CHECK_NEAR(run.luminance.y, 3, 1e-6);
    CHECK_NEAR(run.luminance.z, -5.0 / 3, 1e-6);
    CHECK(run.transmittance_inside[0].y == 0);
    CHECK_STATUS(volgrad_path_run_log_gradient(scene, &lit, 1, 1, &one), VOLGRAD_OK);
    CHECK_STATUS(volgrad_path_log_gradient(scene, &lit, 1, &two), VOLGRAD_OK);
    CHECK(memcmp(&one, &two, sizeof one) == 0);
    CHECK_STATUS(volgrad_path_log_gradient(scene, &lit, 2, &two), VOLGRAD_OK);
    CHECK_NEAR(one.rgb[1].y + two.rgb[1].y, run.rgb[1].y, 1e-6);

    CHECK_STATUS(volgrad_path_run_log_gradient(scene, &lit, 1, 2, NULL), VOLGRAD_ERROR_NULL);
    REFUSED(run, volgrad_path_run_log_gradient(scene, &lit, 1, 0, &run), VOLGRAD_ERROR_INDEX);
    REFUSED(run, volgrad_path_run_log_gradient(scene, &lit, 4, 1, &run), VOLGRAD_ERROR_INDEX);
    REFUSED(run, volgrad_path_run_log_gradient(scene, &lit, 1, 4, &run), VOLGRAD_ERROR_INDEX);
    REFUSED(run, volgrad_path_run_log_gradient(scene, &lit, 1, UINT32_MAX, &run), VOLGRAD_ERROR_INDEX);
    REFUSED(run, volgrad_path_run_log_gradient(scene, &lit, UINT32_MAX, UINT32_MAX, &run), VOLGRAD_ERROR_INDEX);
    REFUSED(run, volgrad_path_run_log_gradient(scene, &lit, 0, 2, &run), VOLGRAD_ERROR_NOT_MOVABLE);
    REFUSED(run, volgrad_path_run_log_gradient(scene, &lit, 1, 3, &run), VOLGRAD_ERROR_NOT_MOVABLE);
}

static void test_runs_beside_mirrors(void) {
    volgrad_vertex mirror = {0};
    mirror.kind = VOLGRAD_VERTEX_SURFACE, mirror.index = MIRROR;
    mirror.position = vec(0, 1, 4), mirror.normal = vec(0, 0, -1);
    volgrad_path mirrored = long_path(mirror);
    volgrad_gradient gradient;
    volgrad_derivative d;
    CHECK_STATUS(volgrad_path_validate(scene, &mirrored, NULL), VOLGRAD_OK);
    CHECK_STATUS(volgrad_path_run_log_derivative(scene, &mirrored, 1, 2, &d), VOLGRAD_OK);
    CHECK_NEAR(d.direction.z, 1, 1e-6);
    /* The camera's edge gets longer by as much as the mirror's gets shorter. */
    CHECK_NEAR(d.luminance, -2.0 / 3, 1e-6);
    CHECK_NEAR(d.rgb.b, -2.0 / 3, 1e-6);
    CHECK_NEAR(d.transmittance_previous.r, -1, 1e-6);
    CHECK_NEAR(d.transmittance_next.r, 1, 1e-6);
    CHECK_NEAR(d.geometry_previous, -2.0 / 3, 1e-6);
    CHECK(d.geometry_next == 0 && d.phase_next == 0 && d.transmittance_inside.g == 0);

    CHECK_STATUS(volgrad_path_run_log_derivative(scene, &mirrored, 1, 2, NULL), VOLGRAD_ERROR_NULL);
    REFUSED(d, volgrad_path_run_log_derivative(scene, &mirrored, 1, 0, &d), VOLGRAD_ERROR_INDEX);
    REFUSED(d, volgrad_path_run_log_derivative(scene, &mirrored, 1, 5, &d), VOLGRAD_ERROR_INDEX);
    REFUSED(d, volgrad_path_run_log_derivative(scene, &mirrored, 1, 1, &d), VOLGRAD_ERROR_NOT_MOVABLE); /* free */
    REFUSED(d, volgrad_path_run_log_derivative(scene, &mirrored, 3, 1, &d), VOLGRAD_ERROR_NOT_MOVABLE);
    REFUSED(gradient, volgrad_path_run_log_gradient(scene, &mirrored, 1, 2, &gradient), VOLGRAD_ERROR_NOT_MOVABLE);
    long_vertices[3].normal = vec(0, 0, 1); /* its back */
    REFUSED(d, volgrad_path_run_log_derivative(scene, &mirrored, 1, 2, &d), VOLGRAD_ERROR_ZERO_CONTRIBUTION);
    long_vertices[1] = mirror;
    REFUSED(d, volgrad_path_run_log_derivative(scene, &mirrored, 2, 1, &d), VOLGRAD_ERROR_NOT_MOVABLE); /* held at both ends */
}

/* The factors add up to the whole, with a rough metal in the place of the mirror. */
static void test_sums(small_scene *s) {
    void *memory;
    s->materials[MIRROR].kind = VOLGRAD_MATERIAL_CONDUCTOR, s->materials[MIRROR].roughness = 0.5f;
    s->materials[MIRROR].conductor_eta = GREY, s->materials[MIRROR].conductor_k = WHITE;
    const volgrad_scene *rough = scene_make(&s->desc, &memory);
    volgrad_vertex metal = {0};
    metal.kind = VOLGRAD_VERTEX_SURFACE, metal.index = MIRROR;
    metal.position = vec(1, 1, 4), metal.normal = vec(0, 0, -1);
    volgrad_path scattered = long_path(metal);
    volgrad_gradient g;
    CHECK_STATUS(volgrad_path_run_log_gradient(rough, &scattered, 2, 1, &g), VOLGRAD_OK);
    CHECK(g.profile_next[0].x != 0 && g.profile_next[2].z != 0 && g.profile_previous[0].x == 0);
    for (int c = 0; c < 3; c++) {
        float transmittance = g.transmittance_previous[c].z + g.transmittance_inside[c].z + g.transmittance_next[c].z;
        float phases = g.phase_previous.z + g.phase_apex.z + g.phase_next.z;
        float rest = g.scattering.z + g.geometry_previous.z + g.geometry_next.z + g.importance.z;
        float profiles = g.profile_previous[c].z + g.profile_next[c].z;
        CHECK_NEAR(g.rgb[c].z, transmittance + phases + rest + profiles, 1e-5);
    }
    free(memory);
}

/* As snprintf: what fits, ended by a 0, and how long all of it is. */
static void test_report(void) {
    char all[8192], some[100];
    size_t length = 0, again = 0;
    CHECK_STATUS(volgrad_path_report(scene, &path, NULL, 0, &length), VOLGRAD_OK);
    CHECK(length > sizeof some && length < sizeof all);
    FILL(all);
    CHECK_STATUS(volgrad_path_report(scene, &path, all, sizeof all, &again), VOLGRAD_OK);
    CHECK(again == length && strlen(all) == length && (unsigned char)all[length + 1] == 0xA5);
    CHECK(strstr(all, "vertex 1: medium 0 at 0.0 0.0 3.0\n") != NULL && strstr(all, "not valid") == NULL);
    for (size_t capacity = 1; capacity <= sizeof some; capacity++) {
        FILL(some);
        CHECK_STATUS(volgrad_path_report(scene, &path, some, capacity, &again), VOLGRAD_OK);
        CHECK(again == length && strlen(some) == capacity - 1 && memcmp(some, all, capacity - 1) == 0);
        CHECK(capacity == sizeof some || (unsigned char)some[capacity] == 0xA5);
    }
    vertices[1].index = 7;
    CHECK_STATUS(volgrad_path_report(scene, &path, all, sizeof all, &length), VOLGRAD_OK);
    CHECK(strstr(all, "not valid: an index past its array (vertex or edge 1)") != NULL);
    fill_path();
    CHECK_STATUS(volgrad_path_report(scene, &path, NULL, 9, &length), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_path_report(scene, &path, all, sizeof all, NULL), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_path_report(NULL, &path, all, sizeof all, &length), VOLGRAD_ERROR_NULL);
}

int main(void) {
    small_scene s;
    void *memory;
    scene = scene_make(small_scene_fill(&s), &memory);
    fill_path();
    test_path_values();
    fill_path();
    test_path_errors();
    test_report();
    test_runs();
    test_runs_beside_mirrors();
    free(memory);
    test_sums(&s);
    return check_end();
}
