/* Estimators of transmittance as C calls; tests/estimators.rs has the statistics. */

#include "small_scene.h"

enum { SAMPLES = 20000 };

static const float densities[8] = {0.2f, 1, 0.7f, 0.1f, 0.9f, 0.3f, 0.5f, 0.8f};
static small_scene s;
static const volgrad_scene *scene;
static volgrad_segment segments[2] = {{1, 0, {0, 0.6f, 0.8f}}, {INFINITY, 1, {0, 0, 0}}};
static const volgrad_line line = {{0.4f, 0.5f, -1}, {0, 0, 1}, 1.7f, 2, segments}; /* homogeneous, then into a grid */
static volgrad_transmittance_options options;

static void fill(void) {
    CHECK_STATUS(volgrad_transmittance_options_default(&options, sizeof options), VOLGRAD_OK);
}

static void test_defaults(void) {
    struct {
        volgrad_transmittance_options options;
        unsigned char tail[8];
    } larger;
    fill();
    CHECK(options.struct_size == sizeof options && options.kind == VOLGRAD_TRANSMITTANCE_RATIO_TRACKING);
    CHECK(options.steps == 64 && options.jitter == 1);
    FILL(larger);
    CHECK_STATUS(volgrad_transmittance_options_default(&larger.options, sizeof larger), VOLGRAD_OK);
    CHECK(larger.options.struct_size == sizeof larger && larger.tail[0] == 0 && larger.tail[7] == 0);
    CHECK_STATUS(volgrad_transmittance_options_default(NULL, sizeof options), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_transmittance_options_default(&options, 2), VOLGRAD_ERROR_STRUCT_SIZE);
}

/* The means of all kinds are near the exact values: six standard errors of these estimators are less than what is allowed. */
static void test_means(void) {
    volgrad_optical_depth exact;
    CHECK_STATUS(volgrad_line_optical_depth(scene, &line, &exact), VOLGRAD_OK);
    double t = exp(-exact.tau.r);
    for (uint32_t kind = 0; kind < 3; kind++) {
        options.kind = kind;
        double sum = 0, origin = 0, end = 0;
        for (uint64_t i = 0; i < SAMPLES; i++) {
            volgrad_transmittance_estimate e;
            volgrad_status status = volgrad_line_transmittance_estimate(scene, &line, &options, 5, i, &e);
            if (status != VOLGRAD_OK) CHECK_STATUS(status, VOLGRAD_OK);
            sum += e.transmittance.r, origin += e.origin_gradient[0].y, end += e.end_gradient[0].z;
        }
        CHECK_NEAR(sum / SAMPLES, t, 6e-3);
        CHECK_NEAR(origin / SAMPLES, -t * exact.origin_gradient[0].y, 2e-2);
        CHECK_NEAR(end / SAMPLES, -t * exact.end_gradient[0].z, 6e-3);
    }
    fill();
}

static void test_numbers(void) {
    volgrad_transmittance_estimate a, b, c, d;
    CHECK_STATUS(volgrad_line_transmittance_estimate(scene, &line, &options, 1, 7, &a), VOLGRAD_OK);
    CHECK_STATUS(volgrad_line_transmittance_estimate(scene, &line, &options, 1, 7, &b), VOLGRAD_OK);
    CHECK(memcmp(&a, &b, sizeof a) == 0);
    options.kind = VOLGRAD_TRANSMITTANCE_RAY_MARCHING;
    CHECK_STATUS(volgrad_line_transmittance_estimate(scene, &line, &options, 1, 7, &a), VOLGRAD_OK);
    CHECK_STATUS(volgrad_line_transmittance_estimate(scene, &line, &options, 1, 8, &b), VOLGRAD_OK);
    CHECK_STATUS(volgrad_line_transmittance_estimate(scene, &line, &options, 2, 7, &c), VOLGRAD_OK);
    CHECK(a.transmittance.r != b.transmittance.r && a.transmittance.r != c.transmittance.r);
    CHECK(a.evaluations == 65); /* one for the homogeneous medium */
    options.jitter = 0;
    CHECK_STATUS(volgrad_line_transmittance_estimate(scene, &line, &options, 1, 7, &c), VOLGRAD_OK);
    CHECK_STATUS(volgrad_line_transmittance_estimate(scene, &line, &options, 2, 8, &d), VOLGRAD_OK);
    CHECK(memcmp(&c, &d, sizeof c) == 0);
    fill();
}

#define BAD(set, status) \
    ((set), REFUSED(result, volgrad_line_transmittance_estimate(scene, &line, &options, 1, 1, &result), status), fill())

static void test_refusals(void) {
    volgrad_transmittance_estimate result;
    volgrad_line bad = line;
    BAD(options.kind = 3, VOLGRAD_ERROR_KIND);
    BAD(options.struct_size = 3, VOLGRAD_ERROR_STRUCT_SIZE);
    BAD((options.kind = VOLGRAD_TRANSMITTANCE_RAY_MARCHING, options.steps = 0), VOLGRAD_ERROR_RANGE);
    BAD((options.kind = VOLGRAD_TRANSMITTANCE_RAY_MARCHING, options.steps = UINT32_MAX), VOLGRAD_ERROR_RANGE);
    BAD((options.kind = VOLGRAD_TRANSMITTANCE_RAY_MARCHING, options.jitter = 2), VOLGRAD_ERROR_RANGE);
    bad.length = NAN;
    REFUSED(result, volgrad_line_transmittance_estimate(scene, &bad, &options, 1, 1, &result), VOLGRAD_ERROR_NOT_FINITE);
    REFUSED(result, volgrad_line_transmittance_estimate(scene, NULL, &options, 1, 1, &result), VOLGRAD_ERROR_NULL);
    REFUSED(result, volgrad_line_transmittance_estimate(NULL, &line, &options, 1, 1, &result), VOLGRAD_ERROR_NULL);
    REFUSED(result, volgrad_line_transmittance_estimate(scene, &line, NULL, 1, 1, &result), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_line_transmittance_estimate(scene, &line, &options, 1, 1, NULL), VOLGRAD_ERROR_NULL);
    options.struct_size = 8; /* an older caller, who knows the kind only */
    CHECK_STATUS(volgrad_line_transmittance_estimate(scene, &line, &options, 1, 1, &result), VOLGRAD_OK);
    fill();

    /* Too dense to be tracked, but not to be marched. */
    void *memory;
    const volgrad_scene *before = scene;
    s.media[1].sigma_t.g = 1e8f;
    scene = scene_make(&s.desc, &memory);
    BAD((void)0, VOLGRAD_ERROR_RANGE);
    options.kind = VOLGRAD_TRANSMITTANCE_RAY_MARCHING;
    CHECK_STATUS(volgrad_line_transmittance_estimate(scene, &line, &options, 1, 1, &result), VOLGRAD_OK);
    CHECK(result.transmittance.g == 0 && result.transmittance.r > 0 && result.end_gradient[1].z == 0);
    free(memory);
    scene = before;
    fill();
}

int main(void) {
    void *memory;
    small_scene_fill(&s);
    small_scene_add_grid(&s, densities);
    scene = scene_make(&s.desc, &memory);
    test_defaults();
    test_means();
    test_numbers();
    test_refusals();
    free(memory);
    return check_end();
}
