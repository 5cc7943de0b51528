/* What is wrong with options, or with a host's answer, is named. */

#include "small_scene.h"

static volgrad_error error = {sizeof error, 99, NULL};

/* A fault's status, field and index. */
#define WRONG(call, status, name, i)                                                                                            \
    do {                                                                                                                        \
        CHECK_STATUS(call, status);                                                                                             \
        CHECK(error.field != NULL && strcmp(error.field, name) == 0 && error.index == (i));                                     \
    } while (0)

static void options_are_checked(void) {
    volgrad_shift_options shift;
    CHECK_STATUS(volgrad_shift_options_default(&shift, sizeof shift), VOLGRAD_OK);
    CHECK_STATUS(volgrad_shift_options_validate(&shift, &error), VOLGRAD_OK);
    CHECK_STATUS(volgrad_shift_options_validate(NULL, &error), VOLGRAD_ERROR_NULL);
    shift.mode = VOLGRAD_SHIFT_EXACT, shift.count = 4;
    WRONG(volgrad_shift_options_validate(&shift, &error), VOLGRAD_ERROR_RANGE, "shift.count", 0);
    CHECK_STATUS(volgrad_shift_options_validate(&shift, NULL), VOLGRAD_ERROR_RANGE);
    shift.struct_size = 3;
    CHECK_STATUS(volgrad_shift_options_validate(&shift, &error), VOLGRAD_ERROR_STRUCT_SIZE);

    volgrad_path_sampler_options path;
    CHECK_STATUS(volgrad_path_sampler_options_default(&path, sizeof path), VOLGRAD_OK);
    CHECK_STATUS(volgrad_path_sampler_options_validate(&path, &error), VOLGRAD_OK);
    path.first_vertex = 16;
    WRONG(volgrad_path_sampler_options_validate(&path, &error), VOLGRAD_ERROR_KIND, "first_vertex", 0);
    path.first_vertex = 0, path.shift.mode = VOLGRAD_SHIFT_EXACT, path.shift.run = 0;
    WRONG(volgrad_path_sampler_options_validate(&path, &error), VOLGRAD_ERROR_RANGE, "shift.run", 0);

    volgrad_bidirectional_options both;
    CHECK_STATUS(volgrad_bidirectional_options_default(&both, sizeof both), VOLGRAD_OK);
    CHECK_STATUS(volgrad_bidirectional_options_validate(&both, &error), VOLGRAD_OK);
    both.max_length = 1;
    WRONG(volgrad_bidirectional_options_validate(&both, &error), VOLGRAD_ERROR_RANGE, "max_length", 0);

    volgrad_chain_options chain;
    CHECK_STATUS(volgrad_chain_options_default(&chain, sizeof chain), VOLGRAD_OK);
    CHECK_STATUS(volgrad_chain_options_validate(&chain, &error), VOLGRAD_OK);
    chain.large_step = 0;
    WRONG(volgrad_chain_options_validate(&chain, &error), VOLGRAD_ERROR_RANGE, "large_step", 0);
}

static const volgrad_scene *scene;
static volgrad_ray ray;
static volgrad_hit hit;

static void answer(void) {
    ray = (volgrad_ray){{0, 0, 0}, {0, 0, 1}, 0.5f, 4, 0};
    memset(&hit, 0, sizeof hit);
    hit.kind = VOLGRAD_HIT_SURFACE, hit.material = DIFFUSE, hit.light = VOLGRAD_NONE, hit.t = 3;
    hit.normal = vec(0, 0, -1);
    hit.medium_outside = hit.medium_inside = VOLGRAD_KEEP_MEDIUM;
    hit.segment_count = 2;
    hit.segments[0] = (volgrad_segment){1, 0, {0, 0, 1}};
    hit.segments[1] = (volgrad_segment){3, VOLGRAD_NONE, {0, 0, 0}};
}

/* With one thing changed. */
#define HIT(change, status, name, i)                                                                                            \
    do {                                                                                                                        \
        answer();                                                                                                               \
        change;                                                                                                                 \
        WRONG(volgrad_hit_validate(scene, &ray, &hit, &error), status, name, i);                                                \
    } while (0)

static void hits_are_checked(void) {
    answer();
    CHECK_STATUS(volgrad_hit_validate(scene, &ray, &hit, &error), VOLGRAD_OK);
    hit.kind = VOLGRAD_HIT_NONE, hit.t = NAN, hit.segments[1].end = 4;
    CHECK_STATUS(volgrad_hit_validate(scene, &ray, &hit, &error), VOLGRAD_OK);
    ray.t_max = INFINITY, hit.segments[1].end = INFINITY;
    CHECK_STATUS(volgrad_hit_validate(scene, &ray, &hit, &error), VOLGRAD_OK);
    hit.kind = VOLGRAD_HIT_OVERFLOW, hit.segment_count = 0;
    CHECK_STATUS(volgrad_hit_validate(scene, &ray, &hit, NULL), VOLGRAD_OK);

    HIT(hit.kind = 7, VOLGRAD_ERROR_KIND, "hit.kind", 0);
    HIT(hit.material = MATERIALS, VOLGRAD_ERROR_INDEX, "hit.material", 0);
    HIT(hit.light = LIGHTS, VOLGRAD_ERROR_INDEX, "hit.light", 0);
    HIT(hit.light = SKY, VOLGRAD_ERROR_INDEX, "hit.light", 0); /* no area light */
    HIT(hit.medium_inside = 1, VOLGRAD_ERROR_INDEX, "hit.medium_outside, medium_inside", 0);
    HIT(hit.t = 0, VOLGRAD_ERROR_RANGE, "hit.t", 0);
    HIT(hit.t = NAN, VOLGRAD_ERROR_RANGE, "hit.t", 0);
    HIT(hit.t = 0.4f, VOLGRAD_ERROR_RANGE, "hit.t", 0); /* before t_min */
    HIT(hit.t = 4, VOLGRAD_ERROR_RANGE, "hit.t", 0);    /* at t_max */
    HIT(hit.normal = vec(0, 0, -2), VOLGRAD_ERROR_NOT_FINITE, "hit.normal", 0);
    HIT(hit.segment_count = 0, VOLGRAD_ERROR_RANGE, "hit.segment_count", 0);
    HIT(hit.segment_count = VOLGRAD_MAX_SEGMENTS + 1, VOLGRAD_ERROR_RANGE, "hit.segment_count", 0);
    HIT(hit.segments[0].medium = 1, VOLGRAD_ERROR_SEGMENTS, "hit.segments", 0);
    HIT(hit.segments[1].end = 0.9f, VOLGRAD_ERROR_SEGMENTS, "hit.segments", 1); /* out of order */
    HIT(hit.segments[1].end = 2.9f, VOLGRAD_ERROR_SEGMENTS, "hit.segments", 1); /* too short */
    HIT((hit.kind = VOLGRAD_HIT_NONE, ray.t_max = INFINITY), VOLGRAD_ERROR_SEGMENTS, "hit.segments", 1);
    CHECK_STATUS(volgrad_hit_validate(scene, NULL, &hit, NULL), VOLGRAD_ERROR_NULL);
}

int main(void) {
    small_scene s;
    void *memory;
    scene = scene_make(small_scene_fill(&s), &memory);
    options_are_checked();
    hits_are_checked();
    free(memory);
    printf("%d passed, %d failed\n", check_passed, check_failed);
    return check_failed != 0;
}
