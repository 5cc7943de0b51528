/* Scene descriptions that are wrong in every way, and the kernels on what comes of them: lines, estimates, phase functions. */

#include "api.h"

enum { MOST_SEGMENTS = 5, MOST_LINES = 8, UNINITIALISED = 4096 };

/* Memory that is too small, misaligned or NULL is refused before it is touched. */
static void refuse_memory(world *w) {
    size_t bytes = 0;
    if (volgrad_scene_size(&w->desc, &bytes) != VOLGRAD_OK) return;
    const volgrad_scene *scene = NULL;
    char *memory = take(&w->memory, UNINITIALISED);
    MUST(volgrad_scene_init(memory, 16, &w->desc, &scene, NULL) == VOLGRAD_ERROR_TOO_SMALL);
    MUST(volgrad_scene_init(memory + 4, bytes, &w->desc, &scene, NULL) == VOLGRAD_ERROR_MISALIGNED);
    MUST(volgrad_scene_init(NULL, bytes, &w->desc, &scene, NULL) == VOLGRAD_ERROR_NULL);
    volgrad_rgb tau;
    MUST(volgrad_line_tau((const void *)memory, NULL, &tau) == VOLGRAD_ERROR_NOT_INITIALISED && scene == NULL);
}

static void use_line(input *in, world *w, volgrad_line *line) {
    volgrad_optical_depth depth;
    volgrad_flight flight;
    volgrad_rgb tau;
    volgrad_transmittance_options options;
    volgrad_transmittance_estimate estimate;
    double u = number(in, 0, 1);
    if (volgrad_line_tau(w->scene, line, &tau) == VOLGRAD_OK) MUST(tau.r >= 0 && tau.g >= 0 && tau.b >= 0);
    volgrad_line_optical_depth(w->scene, line, &depth);
    if (volgrad_line_sample_distance(w->scene, line, u, &flight) == VOLGRAD_OK) {
        MUST(flight.t >= 0 && flight.t <= line->length && flight.pdf >= 0);
    }
    if (volgrad_line_invert_distance(w->scene, line, &u) == VOLGRAD_OK) MUST(u >= 0 && u <= 1);
    MUST(volgrad_transmittance_options_default(&options, sizeof options) == VOLGRAD_OK);
    options.kind = below(in, 3);
    options.steps = below(in, 100) & 0xffff;
    options.jitter = below(in, 2);
    volgrad_line_transmittance_estimate(w->scene, line, &options, next_byte(in), next_word(in), &estimate);
}

static void lines(input *in, world *w) {
    volgrad_line line;
    memset(&line, 0, sizeof line);
    line.origin = point(in), line.direction = direction(in);
    line.length = number(in, 0.1f, 10);
    line.segment_count = pick(in, MOST_SEGMENTS);
    volgrad_segment *segments = take_array(&w->memory, line.segment_count * sizeof *segments);
    float end = 0;
    for (uint32_t i = 0; i < line.segment_count; i++) {
        end = hostile(in) ? number(in, 0, 10) : i + 1 == line.segment_count ? line.length : end + number(in, 0, 2);
        segments[i].end = end;
        segments[i].medium = next_byte(in) & 1 ? VOLGRAD_NONE : below(in, w->desc.media_count);
        segments[i].normal = direction(in);
    }
    line.segments = hostile(in) ? NULL : segments;
    use_line(in, w, &line);
}

static void phases(input *in) {
    volgrad_phase phase = {below(in, 3), number(in, -0.99f, 0.99f)};
    volgrad_vec3 previous = hostile(in) ? point(in) : direction(in), next = direction(in);
    volgrad_phase_value value;
    double u0 = number(in, 0, 1), u1 = number(in, 0, 1);
    if (volgrad_phase_eval(&phase, previous, next, &value) == VOLGRAD_OK) MUST(value.value >= 0);
    if (volgrad_phase_invert(&phase, previous, next, &u0, &u1) == VOLGRAD_OK) MUST(u0 >= 0 && u0 <= 1 && u1 >= 0 && u1 <= 1);
    volgrad_phase_sample(&phase, previous, u0, u1, &next);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    input in = {data, size};
    world w;
    int with_scene = decode_world(&in, &w) != NULL;
    refuse_memory(&w);
    for (int i = 0; with_scene && i < MOST_LINES && in.size > 0; i++) lines(&in, &w);
    phases(&in);
    uint64_t dropped;
    MUST((volgrad_scene_dropped_densities(w.scene, &dropped) == VOLGRAD_OK) == with_scene);
    MUST((volgrad_scene_dropped_values(w.scene, &dropped) == VOLGRAD_OK) == with_scene);
    release(&w.memory);
    return 0;
}
