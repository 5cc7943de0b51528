/* The path sampler, the bidirectional one and guides, for hosts that answer well, badly, or not at all. */

#include "api.h"

static volgrad_path_sampler_stats no_stats(void) {
    volgrad_path_sampler_stats stats;
    memset(&stats, 0, sizeof stats);
    stats.struct_size = sizeof stats;
    return stats;
}

static volgrad_path_sampler_stats stats;
static volgrad_bidirectional_options bidirectional;
static uint32_t first, pixels;
static uint64_t pass;

static void run_paths(input *in, world *w, volgrad_film *film) {
    volgrad_path_sampler_options options;
    MUST(volgrad_path_sampler_options_default(&options, sizeof options) == VOLGRAD_OK);
    options.max_depth = hostile(in) ? 0 : pick(in, 12);
    options.rr_depth = hostile(in) ? next_word(in) : pick(in, 8);
    options.seed = next_byte(in);
    decode_shift(in, &options.shift);
    options.left_out_first = pick(in, 4);
    options.left_out_last = below(in, 8);
    options.first_vertex = below(in, 8) == 0 ? pick(in, 20) : 0;
    volgrad_error error = {sizeof error, 0, NULL};
    volgrad_path_sampler_options_validate(&options, &error);
    volgrad_shift_options_validate(&options.shift, &error);
    volgrad_bidirectional_options_validate(&bidirectional, &error);
    uint64_t before = stats.paths;
    volgrad_status status = volgrad_path_sampler_run(w->scene, &w->queries, &options, pass, first, pixels, film, &stats);
    MUST(status == VOLGRAD_OK ? stats.paths == before + pixels : stats.paths <= before + pixels);
}

static void run_bidirectional(input *in, world *w, volgrad_film *film) {
    uint32_t light = below(in, 8), camera = below(in, 8), weighted = below(in, 2);
    volgrad_bidirectional_run(w->scene, &w->queries, &bidirectional, pass, first, pixels, film, &stats);
    volgrad_bidirectional_run_technique(w->scene, &w->queries, &bidirectional, light, camera, weighted, pass, first, pixels, film, NULL);
}

/* The scene is the guided one from then on. */
static void run_guides(world *w) {
    uint32_t width, height;
    size_t bytes;
    const volgrad_scene *guided;
    if (volgrad_guide_film_size(w->scene, &width, &height) != VOLGRAD_OK) return;
    volgrad_film *film = take_film(&w->memory, width, height);
    volgrad_guide_learn(w->scene, &w->queries, &bidirectional, pass, first, pixels, film, &stats);
    MUST(volgrad_guide_size(w->scene, &bytes) == VOLGRAD_OK);
    MUST(volgrad_guide_init(take(&w->memory, bytes), bytes, w->scene, film, &guided) == VOLGRAD_OK);
    w->scene = guided;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    input in = {data, size};
    world w;
    if (decode_world(&in, &w) == NULL) return release(&w.memory), 0;
    const volgrad_camera *camera = &w.desc.camera;
    volgrad_film *film = take_film(&w.memory, camera->width, camera->height);
    if (film == NULL) return release(&w.memory), 0;
    stats = no_stats();
    pass = pick(&in, 4);
    uint32_t area = (camera->crop_x1 - camera->crop_x0) * (camera->crop_y1 - camera->crop_y0);
    first = pick(&in, area < 200 ? area : 200), pixels = area - first;
    if (hostile(&in)) first = below(&in, area);
    if (pixels > 20) pixels = 20;
    MUST(volgrad_bidirectional_options_default(&bidirectional, sizeof bidirectional) == VOLGRAD_OK);
    bidirectional.max_length = hostile(&in) ? below(&in, 65) : 2 + pick(&in, 8);
    bidirectional.rr_depth = pick(&in, 8);
    bidirectional.heuristic = below(&in, 2);
    bidirectional.light_vertices = hostile(&in) ? below(&in, 64) : pick(&in, 4);
    bidirectional.roulette = pick(&in, 2) ? 0 : number(&in, 0, 2);
    decode_shift(&in, &bidirectional.shift);
    for (int i = 0; i < 3; i++) {
        w.patience = MOST_RAYS;
        switch (pick(&in, 3)) {
        case 0: if (pixels + (uint64_t)first <= area) run_paths(&in, &w, film); break;
        case 1: run_bidirectional(&in, &w, film); break;
        default: run_guides(&w); break;
        }
    }
    check_film(&w.memory, film, camera->width, camera->height);
    release(&w.memory);
    return 0;
}
