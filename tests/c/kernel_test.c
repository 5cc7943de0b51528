/* Kernels: lines and phase functions. */

#include "small_scene.h"

static const double PI = 3.14159265358979323846;
static const volgrad_scene *scene;
static alignas(16) unsigned char zeros[1 << 12]; /* memory that is no scene */

#define NO_SCENE ((const volgrad_scene *)(const void *)zeros)
#define ODD_SCENE ((const volgrad_scene *)(const void *)(zeros + 1))

/* All functions of a line refuse it alike. */
static void refuse_line(const volgrad_scene *in, const volgrad_line *line, volgrad_status status, const char *what, int at) {
    volgrad_optical_depth depth;
    volgrad_flight flight;
    volgrad_rgb tau;
    double u;
    FILL(depth), FILL(flight), FILL(tau), FILL(u);
    check_status(volgrad_line_optical_depth(in, line, &depth), status, what, __FILE__, at);
    check_status(volgrad_line_sample_distance(in, line, 0.5, &flight), status, what, __FILE__, at);
    check_status(volgrad_line_invert_distance(in, line, &u), status, what, __FILE__, at);
    check_status(volgrad_line_tau(in, line, &tau), status, what, __FILE__, at);
    check_that(UNTOUCHED(depth) && UNTOUCHED(flight) && UNTOUCHED(tau) && UNTOUCHED(u), what, __FILE__, at);
}

static void test_lines(void) {
    volgrad_segment segments[2] = {{1, 0, {0, 0, 1}}, {1, VOLGRAD_NONE, {0, 0, 1}}};
    const volgrad_line good = {{0, 0, 0}, {0, 0, 1}, 1, 1, segments};
    volgrad_line line = good;
    volgrad_rgb tau;
    volgrad_flight flight;
    volgrad_optical_depth depth;
    CHECK_STATUS(volgrad_line_tau(scene, &line, &tau), VOLGRAD_OK);
    CHECK_NEAR(exp(-tau.r), exp(-1), 1e-6);
    CHECK_NEAR(exp(-tau.b), exp(-1), 1e-6);
    CHECK_STATUS(volgrad_line_optical_depth(scene, &line, &depth), VOLGRAD_OK);
    CHECK_NEAR(depth.tau.g, 1, 1e-6);
    CHECK_NEAR(depth.origin_gradient[2].z, -1, 1e-6);
    CHECK_NEAR(depth.end_gradient[0].z, 1, 1e-6);

    /* u -> t -> u */
    for (int i = 1; i < 6; i++) {
        double from = i / 10.0, back = 0;
        CHECK_STATUS(volgrad_line_sample_distance(scene, &line, from, &flight), VOLGRAD_OK);
        CHECK(flight.medium == 0);
        CHECK_NEAR(flight.pdf, exp(-flight.t), 1e-6);
        volgrad_line shorter = line;
        segments[0].end = shorter.length = flight.t;
        CHECK_STATUS(volgrad_line_invert_distance(scene, &shorter, &back), VOLGRAD_OK);
        CHECK_NEAR(back, from, 1e-6);
        segments[0].end = 1;
    }
    int passed = 0;
    for (int i = 0; i < 1000; i++) {
        CHECK_STATUS(volgrad_line_sample_distance(scene, &line, (i + 0.5) / 1000, &flight), VOLGRAD_OK);
        passed += flight.medium == VOLGRAD_NONE;
    }
    CHECK_NEAR(passed / 1000.0, exp(-1), 2e-3);

    CHECK_STATUS(volgrad_line_tau(scene, &line, NULL), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_line_optical_depth(scene, &line, NULL), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_line_sample_distance(scene, &line, 0.5, NULL), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_line_invert_distance(scene, &line, NULL), VOLGRAD_ERROR_NULL);
    const double outside[] = {0, 1, -0.5, 2, INFINITY};
    for (int i = 0; i < 5; i++) {
        REFUSED(flight, volgrad_line_sample_distance(scene, &line, outside[i], &flight), VOLGRAD_ERROR_RANGE);
    }
    REFUSED(flight, volgrad_line_sample_distance(scene, &line, NAN, &flight), VOLGRAD_ERROR_NOT_FINITE);
    CHECK_STATUS(volgrad_line_invert_distance(scene, &line, (double *)(void *)(zeros + 1)), VOLGRAD_ERROR_MISALIGNED);

#define BAD_LINE(set, status) ((set), refuse_line(scene, &line, (status), #set, __LINE__), line = good)
    refuse_line(NULL, &line, VOLGRAD_ERROR_NULL, "scene NULL", __LINE__);
    refuse_line(scene, NULL, VOLGRAD_ERROR_NULL, "line NULL", __LINE__);
    refuse_line(ODD_SCENE, &line, VOLGRAD_ERROR_MISALIGNED, "scene misaligned", __LINE__);
    refuse_line(NO_SCENE, &line, VOLGRAD_ERROR_NOT_INITIALISED, "scene of zeros", __LINE__);
    BAD_LINE(line.segments = NULL, VOLGRAD_ERROR_NULL);
    BAD_LINE(line.segment_count = 0, VOLGRAD_ERROR_SEGMENTS);
    BAD_LINE(line.length = 0, VOLGRAD_ERROR_ZERO_LENGTH);
    BAD_LINE(line.length = NAN, VOLGRAD_ERROR_NOT_FINITE);
    BAD_LINE(line.length = 2, VOLGRAD_ERROR_SEGMENTS);
    BAD_LINE(line.length = INFINITY, VOLGRAD_ERROR_SEGMENTS);
    BAD_LINE(line.origin.y = NAN, VOLGRAD_ERROR_NOT_FINITE);
    BAD_LINE(line.origin.x = INFINITY, VOLGRAD_ERROR_NOT_FINITE);
    BAD_LINE(line.direction.z = 0, VOLGRAD_ERROR_NOT_FINITE);
    BAD_LINE(line.direction.z = 1.1f, VOLGRAD_ERROR_NOT_FINITE);
    BAD_LINE(line.direction.x = NAN, VOLGRAD_ERROR_NOT_FINITE);
    BAD_LINE((segments[0].end = NAN), VOLGRAD_ERROR_SEGMENTS);
    BAD_LINE((segments[0].end = -1), VOLGRAD_ERROR_SEGMENTS);
    BAD_LINE((segments[0].end = 2, line.segment_count = 2), VOLGRAD_ERROR_SEGMENTS);
    segments[0].end = 1;
    BAD_LINE(segments[0].medium = 1, VOLGRAD_ERROR_INDEX);
    segments[0].medium = 0;
    segments[0].end = INFINITY, line.length = INFINITY;
    CHECK_STATUS(volgrad_line_tau(scene, &line, &tau), VOLGRAD_OK);
    CHECK(isinf(tau.r) && tau.r > 0);
}

static void test_phase(void) {
    volgrad_phase phase = {VOLGRAD_PHASE_ISOTROPIC, NAN};
    volgrad_phase_value value;
    const volgrad_vec3 back = vec(0, 0, -1), bad = vec(NAN, 0, 1), none = vec(0, 0, 0);
    volgrad_vec3 next;
    double u0, u1;
    CHECK_STATUS(volgrad_phase_eval(&phase, vec(0, 0, -3), vec(5, 0, 0), &value), VOLGRAD_OK);
    CHECK_NEAR(value.value, 1 / (4 * PI), 1e-7);
    CHECK(value.apex_gradient.x == 0 && value.previous_gradient.z == 0 && value.next_gradient.y == 0);
    phase.kind = VOLGRAD_PHASE_HENYEY_GREENSTEIN, phase.g = 0.5f;
    CHECK_STATUS(volgrad_phase_eval(&phase, back, vec(0, 0, 1), &value), VOLGRAD_OK);
    CHECK_NEAR(value.value, 0.75 / (4 * PI * 0.125), 1e-6); /* straight on is the most */
    CHECK_STATUS(volgrad_phase_sample(&phase, back, 0.3, 0.7, &next), VOLGRAD_OK);
    CHECK_STATUS(volgrad_phase_invert(&phase, back, next, &u0, &u1), VOLGRAD_OK);
    CHECK_NEAR(u0, 0.3, 1e-5);
    CHECK_NEAR(u1, 0.7, 1e-5);

    REFUSED(value, volgrad_phase_eval(NULL, back, back, &value), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_phase_eval(&phase, back, back, NULL), VOLGRAD_ERROR_NULL);
    REFUSED(value, volgrad_phase_eval(&phase, bad, back, &value), VOLGRAD_ERROR_NOT_FINITE);
    REFUSED(value, volgrad_phase_eval(&phase, back, bad, &value), VOLGRAD_ERROR_NOT_FINITE);
    REFUSED(value, volgrad_phase_eval(&phase, none, back, &value), VOLGRAD_ERROR_ZERO_LENGTH);
    REFUSED(value, volgrad_phase_eval(&phase, back, none, &value), VOLGRAD_ERROR_ZERO_LENGTH);
    REFUSED(next, volgrad_phase_sample(&phase, vec(0, 0, 2), 0.5, 0.5, &next), VOLGRAD_ERROR_NOT_FINITE);
    REFUSED(next, volgrad_phase_sample(&phase, back, NAN, 0.5, &next), VOLGRAD_ERROR_NOT_FINITE);
    REFUSED(next, volgrad_phase_sample(&phase, back, 0.5, 1, &next), VOLGRAD_ERROR_RANGE);
    REFUSED(next, volgrad_phase_sample(&phase, back, -1e-9, 0, &next), VOLGRAD_ERROR_RANGE);
    CHECK_STATUS(volgrad_phase_sample(&phase, back, 0, 0, NULL), VOLGRAD_ERROR_NULL);
    REFUSED(u0, volgrad_phase_invert(&phase, back, none, &u0, &u1), VOLGRAD_ERROR_NOT_FINITE);
    REFUSED(u0, volgrad_phase_invert(&phase, back, back, &u0, NULL), VOLGRAD_ERROR_NULL);
    REFUSED(u1, volgrad_phase_invert(&phase, back, back, NULL, &u1), VOLGRAD_ERROR_NULL);
    phase.g = 1;
    REFUSED(value, volgrad_phase_eval(&phase, back, back, &value), VOLGRAD_ERROR_RANGE);
    phase.g = NAN;
    REFUSED(value, volgrad_phase_eval(&phase, back, back, &value), VOLGRAD_ERROR_NOT_FINITE);
    phase.kind = 2;
    REFUSED(value, volgrad_phase_eval(&phase, back, back, &value), VOLGRAD_ERROR_KIND);
}

int main(void) {
    small_scene s;
    void *memory;
    scene = scene_make(small_scene_fill(&s), &memory);
    test_lines();
    test_phase();
    free(memory);
    return check_end();
}
