/* One scene, one guided scene, one set of options and queries, four threads: chains of each thread's own, and films of their own or one that
 * they share; sums as from one thread. Under a thread sanitizer (make test-threads) also: nothing that is const is written to. */

#include <pthread.h>

#include "open_queries.h"

enum { THREADS = 4, PASSES = 8, PIXELS = SIDE * SIDE, LINES = 200, SAMPLES = 2000, MUTATIONS = 300, LONGEST = 4, GRID = 9 };
enum { BYTES = 48 * PIXELS + 64, CHAIN_BYTES = 1 << 13, ROOM = THREADS + VOLGRAD_MAX_LENGTH };

/* What all threads read. */
static small_scene s;
static const volgrad_scene *scene, *guided;
static volgrad_queries queries;
static volgrad_path_sampler_options paths;
static volgrad_bidirectional_options both;
static volgrad_chain_options chains;
static volgrad_chain_techniques techniques;
static volgrad_chain_start starts[ROOM];

/* What each has. */
typedef struct worker {
    int first, step;
    volgrad_film *film;
    alignas(16) unsigned char memory[BYTES];
    alignas(16) unsigned char chain[CHAIN_BYTES];
    double tau;
    int failures;
} worker;

static worker alone, workers[THREADS];

enum { HEAD = 32 };
static alignas(16) unsigned char shared_memory[BYTES];

static int32_t slab(void *user, const volgrad_ray *rays, volgrad_hit *hits, uint32_t count) {
    (void)user;
    for (uint32_t i = 0; i < count; i++) {
        memset(&hits[i], 0, sizeof hits[i]);
        answer_slab(&rays[i], &hits[i]);
    }
    return 0;
}

/* NaN at some places: counted, which all threads do. */
static void density(void *user, const volgrad_vec3 *points, float *values, uint32_t count) {
    (void)user;
    for (uint32_t i = 0; i < count; i++) values[i] = points[i].x > 0.99f ? NAN : 1 + points[i].y;
}

static void gradient(void *user, const volgrad_vec3 *points, volgrad_vec3 *values, uint32_t count) {
    (void)user, (void)points;
    for (uint32_t i = 0; i < count; i++) values[i] = vec(0, 1, 0);
}

static const volgrad_custom_density custom = {
    .struct_size = sizeof custom, .density = density, .gradient = gradient, .step = 0.05f, .majorant = 2};

static void make_scenes(void **memory) {
    static float grid[GRID * GRID * GRID];
    for (int i = 0; i < GRID * GRID * GRID; i++) grid[i] = (float)(i * 7 % 11) / 10;
    small_scene_fill(&s);
    s.desc.media_count = 2;
    s.media[0].kind = VOLGRAD_MEDIUM_GRID;
    s.media[0].density = grid;
    s.media[0].nx = s.media[0].ny = s.media[0].nz = GRID;
    s.media[1].kind = VOLGRAD_MEDIUM_CUSTOM;
    s.media[1].custom = &custom;
    for (int i = 0; i < 3; i++) {
        s.media[0].local_to_world[5 * i] = 8;
        s.media[0].local_to_world[4 * i + 3] = -4;
        s.media[1].local_to_world[5 * i] = 1;
    }
    s.desc.camera.medium = s.lights[POINT_LIGHT].medium = s.lights[SKY].medium = VOLGRAD_NONE;
    s.lights[POINT_LIGHT].position = vec(0.5f, 0, 0);
    s.desc.bounds_radius = 6;
    scene = scene_make(&s.desc, &memory[0]);

    volgrad_film *lesson = NULL;
    uint32_t width, height;
    size_t bytes;
    CHECK_STATUS(volgrad_guide_film_size(scene, &width, &height), VOLGRAD_OK);
    CHECK_STATUS(volgrad_film_size(width, height, &bytes), VOLGRAD_OK);
    memory[1] = aligned_alloc(16, bytes);
    CHECK_STATUS(volgrad_film_init(memory[1], bytes, width, height, &lesson), VOLGRAD_OK);
    CHECK_STATUS(volgrad_guide_learn(scene, &queries, &both, 0, 0, PIXELS, lesson, NULL), VOLGRAD_OK);
    CHECK_STATUS(volgrad_guide_size(scene, &bytes), VOLGRAD_OK);
    memory[2] = aligned_alloc(16, (bytes + 15) / 16 * 16);
    CHECK_STATUS(volgrad_guide_init(memory[2], bytes, scene, lesson, &guided), VOLGRAD_OK);
}

static void set_options(void) {
    queries.struct_size = sizeof queries;
    queries.intersect = queries.occluded = slab;
    CHECK_STATUS(volgrad_path_sampler_options_default(&paths, sizeof paths), VOLGRAD_OK);
    CHECK_STATUS(volgrad_bidirectional_options_default(&both, sizeof both), VOLGRAD_OK);
    CHECK_STATUS(volgrad_chain_options_default(&chains, sizeof chains), VOLGRAD_OK);
    paths.max_depth = both.max_length = chains.max_length = LONGEST;
    paths.shift.mode = both.shift.mode = VOLGRAD_SHIFT_EXCHANGEABLE;
}

static void make_plan(void) {
    static float weights[SAMPLES];
    volgrad_chain_plan_result plan = {sizeof plan, 0, 0, 0};
    CHECK_STATUS(volgrad_chain_bootstrap(guided, &queries, &chains, NULL, 0, SAMPLES, weights, NULL), VOLGRAD_OK);
    CHECK_STATUS(volgrad_chain_learn(&chains, weights, SAMPLES, &techniques), VOLGRAD_OK);
    CHECK_STATUS(volgrad_chain_bootstrap(guided, &queries, &chains, &techniques, 0, SAMPLES, weights, NULL), VOLGRAD_OK);
    CHECK_STATUS(volgrad_chain_plan(&chains, &techniques, weights, SAMPLES, 2 * THREADS, starts, ROOM, &plan), VOLGRAD_OK);
    CHECK(plan.chain_count >= THREADS);
}

/* CHECK counts, so only the main thread may. */
#define DO(call) (w->failures += (call) != VOLGRAD_OK)

static void lines(worker *w) {
    volgrad_transmittance_options options;
    DO(volgrad_transmittance_options_default(&options, sizeof options));
    for (int i = w->first; i < LINES; i += w->step) {
        const float y = (float)i / LINES;
        const volgrad_segment segment = {INFINITY, 1, {0, 0, 0}};
        const volgrad_line line = {{0, y, 0.5f}, {1, 0, 0}, 1, 1, &segment};
        volgrad_optical_depth depth;
        volgrad_transmittance_estimate estimate;
        DO(volgrad_line_optical_depth(scene, &line, &depth));
        DO(volgrad_line_transmittance_estimate(scene, &line, &options, 0, (uint64_t)i, &estimate));
        w->tau += depth.tau.r;
    }
}

static void *work(void *pointer) {
    worker *w = pointer;
    volgrad_chain *chain;
    w->tau = 0;
    for (uint64_t i = (uint64_t)w->first; i < PASSES; i += (uint64_t)w->step) {
        DO(volgrad_path_sampler_run(scene, &queries, &paths, i, 0, PIXELS / 4, w->film, NULL));
        DO(volgrad_bidirectional_run(guided, &queries, &both, i, 0, PIXELS / 8, w->film, NULL));
    }
    for (int i = w->first; i < THREADS; i += w->step) {
        DO(volgrad_chain_init(w->chain, CHAIN_BYTES, guided, &queries, &chains, &techniques, &starts[i], NULL, &chain));
        DO(volgrad_chain_run(chain, guided, &queries, MUTATIONS, w->film, NULL));
        DO(volgrad_chain_flush(chain, guided, &queries, w->film, NULL));
    }
    lines(w);
    return NULL;
}

/* The sum of their taus. */
static double work_in_threads(void) {
    pthread_t threads[THREADS];
    double tau = 0;
    for (int i = 0; i < THREADS; i++) {
        workers[i].first = i, workers[i].step = THREADS;
        CHECK(pthread_create(&threads[i], NULL, work, &workers[i]) == 0);
    }
    for (int i = 0; i < THREADS; i++) {
        CHECK(pthread_join(threads[i], NULL) == 0);
        CHECK(workers[i].failures == 0);
        tau += workers[i].tau;
    }
    return tau;
}

int main(void) {
    void *memory[3];
    uint64_t dropped = 0, after = 0;
    set_options();
    make_scenes(memory);
    make_plan();
    alone.step = 1;
    CHECK_STATUS(volgrad_film_init(alone.memory, BYTES, SIDE, SIDE, &alone.film), VOLGRAD_OK);
    work(&alone);
    CHECK(alone.failures == 0 && alone.tau > 0);
    CHECK_STATUS(volgrad_scene_dropped_densities(scene, &dropped), VOLGRAD_OK);

    for (int i = 0; i < THREADS; i++) CHECK_STATUS(volgrad_film_init(workers[i].memory, BYTES, SIDE, SIDE, &workers[i].film), VOLGRAD_OK);
    CHECK_NEAR(work_in_threads(), alone.tau, 1e-9 * alone.tau);
    for (int i = 1; i < THREADS; i++) CHECK_STATUS(volgrad_film_merge(workers[0].film, workers[i].film), VOLGRAD_OK);
    CHECK(memcmp(alone.memory, workers[0].memory, BYTES) == 0);

    CHECK_STATUS(volgrad_film_init_shared(shared_memory, BYTES, SIDE, SIDE, &workers[0].film), VOLGRAD_OK);
    for (int i = 1; i < THREADS; i++) workers[i].film = workers[0].film;
    CHECK_NEAR(work_in_threads(), alone.tau, 1e-9 * alone.tau);
    CHECK(memcmp(alone.memory + HEAD, shared_memory + HEAD, BYTES - HEAD) == 0);
    CHECK_STATUS(volgrad_scene_dropped_densities(guided, &after), VOLGRAD_OK);
    CHECK(dropped > 0 && after == 3 * dropped);
    for (int i = 0; i < 3; i++) free(memory[i]);
    return check_end();
}
