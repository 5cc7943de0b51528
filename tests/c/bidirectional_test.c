/* The bidirectional sampler, in a slab of fog that a point light and a sky shine on. */

#include "open_queries.h"

enum { PIXELS = SIDE * SIDE, FLOATS = 3 * PIXELS, BYTES = 48 * PIXELS + 64, LONGEST = 6 };

static small_scene s;
static const volgrad_scene *scene;
static void *scene_memory;
static open_queries host;
static volgrad_bidirectional_options options;
static volgrad_path_sampler_options path_options;
static alignas(16) unsigned char block[2][BYTES];
static float rgb[FLOATS];

/* The light is in the vacuum before the slab, so that no path comes near it. */
static void make_scene(void) {
    free(scene_memory);
    small_scene_fill(&s);
    s.desc.camera.medium = VOLGRAD_NONE;
    s.lights[POINT_LIGHT].position = vec(0.5f, 0, 0);
    s.lights[POINT_LIGHT].medium = VOLGRAD_NONE;
    s.lights[SKY].medium = VOLGRAD_NONE;
    s.media[0].albedo = WHITE;
    scene = scene_make(&s.desc, &scene_memory);
    queries_answer(&host, SLAB, 0, SLAB);
    CHECK_STATUS(volgrad_bidirectional_options_default(&options, sizeof options), VOLGRAD_OK);
    CHECK_STATUS(volgrad_path_sampler_options_default(&path_options, sizeof path_options), VOLGRAD_OK);
    options.max_length = path_options.max_depth = LONGEST;
}

static volgrad_film *clear(int which) {
    volgrad_film *film = NULL;
    CHECK_STATUS(volgrad_film_init(block[which], BYTES, SIDE, SIDE, &film), VOLGRAD_OK);
    return film;
}

static volgrad_status run(uint64_t pass, uint32_t first, uint32_t count, volgrad_film *film, volgrad_path_sampler_stats *stats) {
    return volgrad_bidirectional_run(scene, &host.queries, &options, pass, first, count, film, stats);
}

static volgrad_path_sampler_stats no_stats(void) {
    volgrad_path_sampler_stats stats;
    memset(&stats, 0, sizeof stats);
    stats.struct_size = sizeof stats;
    return stats;
}

typedef struct { double mean, squared_error; } estimate;

/* Mean over the film, and its squared standard error, of `passes` passes; with the bidirectional sampler and a path sampler that
   leaves its lengths out, or with a path sampler that does not. */
static estimate mean_of_passes(int passes, int bidirectional) {
    double sum = 0, squares = 0;
    path_options.left_out_first = bidirectional ? 2 : 0;
    path_options.left_out_last = bidirectional ? LONGEST : 0;
    for (int pass = 0; pass < passes; pass++) {
        volgrad_film *film = clear(0);
        if (bidirectional) CHECK_STATUS(run((uint64_t)pass, 0, PIXELS, film, NULL), VOLGRAD_OK);
        CHECK_STATUS(volgrad_path_sampler_run(scene, &host.queries, &path_options, (uint64_t)pass, 0, PIXELS, film, NULL), VOLGRAD_OK);
        CHECK_STATUS(volgrad_film_develop(film, 1, rgb, FLOATS), VOLGRAD_OK);
        double mean = 0;
        for (int i = 1; i < FLOATS; i += 3) mean += rgb[i] / (double)PIXELS;
        sum += mean;
        squares += mean * mean;
    }
    estimate e = {sum / passes, 0};
    e.squared_error = (squares / passes - e.mean * e.mean) / (passes - 1);
    return e;
}

/* Fails for one in 10^4 seeds or so (two-sided, 4.5 standard errors that 24 passes tell); the seed is fixed. */
static void test_mean(void) {
    make_scene();
    path_options.seed = 1; /* other numbers than the bidirectional sampler's */
    estimate path = mean_of_passes(24, 0);
    for (uint32_t heuristic = VOLGRAD_HEURISTIC_BALANCE; heuristic <= VOLGRAD_HEURISTIC_POWER; heuristic++) {
        options.heuristic = heuristic;
        estimate both = mean_of_passes(24, 1);
        double error = sqrt(path.squared_error + both.squared_error);
        CHECK_NEAR(both.mean, path.mean, 4.5 * error);
        CHECK(error > 0 && error < 0.01 * path.mean);
    }
    for (uint32_t lights = 1; lights <= 3; lights += 2) {
        options.light_vertices = lights;
        options.roulette = (float)path.mean;
        options.shift.mode = lights == 1 ? VOLGRAD_SHIFT_NONE : VOLGRAD_SHIFT_EXCHANGEABLE;
        estimate few = mean_of_passes(24, 1);
        double error = sqrt(path.squared_error + few.squared_error);
        CHECK_NEAR(few.mean, path.mean, 4.5 * error);
        CHECK(error > 0 && error < 0.02 * path.mean);
    }
}

/* Each option makes another image; without a limit, lights' subpaths that are shifted have three vertices. */
static void test_options(void) {
    make_scene();
    volgrad_path_sampler_stats stats = no_stats();
    CHECK_STATUS(run(3, 0, PIXELS, clear(0), NULL), VOLGRAD_OK);
    options.light_vertices = 1;
    CHECK_STATUS(run(3, 0, PIXELS, clear(1), NULL), VOLGRAD_OK);
    CHECK(memcmp(block[0], block[1], BYTES) != 0);
    options.light_vertices = 0;
    options.roulette = 1;
    CHECK_STATUS(run(3, 0, PIXELS, clear(1), NULL), VOLGRAD_OK);
    CHECK(memcmp(block[0], block[1], BYTES) != 0);
    options.shift.mode = VOLGRAD_SHIFT_EXACT;
    options.roulette = 0;
    CHECK_STATUS(run(3, 0, PIXELS, clear(1), &stats), VOLGRAD_OK);
    CHECK(memcmp(block[0], block[1], BYTES) != 0 && stats.shifted_paths > PIXELS / 4 && stats.shifts > stats.shifted_paths);
    options.light_vertices = 3;
    CHECK_STATUS(run(3, 0, PIXELS, clear(0), NULL), VOLGRAD_OK);
    CHECK(memcmp(block[0], block[1], BYTES) == 0);
    options.shift.run = 5; /* one vertex moves, whatever it says */
    CHECK_STATUS(run(3, 0, PIXELS, clear(0), NULL), VOLGRAD_OK);
    CHECK(memcmp(block[0], block[1], BYTES) == 0);
}

static void test_ranges(void) {
    make_scene();
    volgrad_path_sampler_stats whole = no_stats(), parts = no_stats();
    volgrad_film *a = clear(0), *b = clear(1);
    CHECK_STATUS(run(3, 0, PIXELS, a, &whole), VOLGRAD_OK);
    CHECK_STATUS(run(3, 1000, PIXELS - 1000, b, &parts), VOLGRAD_OK);
    CHECK_STATUS(run(3, 0, 1000, b, &parts), VOLGRAD_OK);
    CHECK_STATUS(run(3, PIXELS, 0, b, &parts), VOLGRAD_OK);
    CHECK(memcmp(block[0], block[1], BYTES) == 0 && memcmp(&whole, &parts, sizeof whole) == 0);
    CHECK(whole.paths == PIXELS && whole.rays >= PIXELS && whole.occlusion_rays > 0 && whole.shifted_paths == 0);
    CHECK_STATUS(run(4, 0, PIXELS, clear(1), NULL), VOLGRAD_OK);
    CHECK(memcmp(block[0], block[1], BYTES) != 0);
    options.seed = 1;
    CHECK_STATUS(run(3, 0, PIXELS, clear(1), NULL), VOLGRAD_OK);
    CHECK(memcmp(block[0], block[1], BYTES) != 0);

    memcpy(block[1], block[0], BYTES);
    const uint32_t most = UINT32_MAX;
    const uint32_t bad[][2] = {{0, PIXELS + 1}, {PIXELS, 1}, {PIXELS + 1, 0}, {most, 1}, {1, most}, {most, most}};
    for (int i = 0; i < 6; i++) REFUSED(parts.paths, run(3, bad[i][0], bad[i][1], a, NULL), VOLGRAD_ERROR_RANGE);
    CHECK(memcmp(block[0], block[1], BYTES) == 0);
}

static void test_refusals(void) {
    static alignas(16) const unsigned char zeros[1 << 12];
    static alignas(16) unsigned char small[48 * 4 * 4 + 64];
    make_scene();
    volgrad_film *a = clear(0), *film;
    memcpy(block[1], block[0], BYTES);
    const volgrad_bidirectional_options good = options;
    volgrad_queries *q = &host.queries;
    volgrad_path_sampler_stats stats = no_stats();
#define RUN(scene, queries, options, film, stats) volgrad_bidirectional_run(scene, queries, options, 0, 0, 10, film, stats)
    CHECK_STATUS(RUN(NULL, q, &options, a, &stats), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(RUN(scene, NULL, &options, a, &stats), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(RUN(scene, q, NULL, a, &stats), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(RUN(scene, q, &options, NULL, &stats), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(RUN((const void *)zeros, q, &options, a, &stats), VOLGRAD_ERROR_NOT_INITIALISED);
    CHECK_STATUS(RUN((const void *)(zeros + 4), q, &options, a, &stats), VOLGRAD_ERROR_MISALIGNED);
    CHECK_STATUS(RUN(scene, (const void *)(zeros + 1), &options, a, &stats), VOLGRAD_ERROR_MISALIGNED);
    CHECK_STATUS(RUN(scene, q, (const void *)(zeros + 1), a, &stats), VOLGRAD_ERROR_MISALIGNED);
    CHECK_STATUS(RUN(scene, q, &options, a, (void *)(small + 1)), VOLGRAD_ERROR_MISALIGNED);
    CHECK_STATUS(RUN(scene, q, &options, (volgrad_film *)(void *)small, &stats), VOLGRAD_ERROR_NOT_INITIALISED);
    CHECK_STATUS(RUN(scene, q, &options, (volgrad_film *)(void *)(small + 8), &stats), VOLGRAD_ERROR_MISALIGNED);
    CHECK_STATUS(volgrad_film_init(small, sizeof small, 4, 4, &film), VOLGRAD_OK);
    CHECK_STATUS(RUN(scene, q, &options, film, &stats), VOLGRAD_ERROR_SIZE_MISMATCH);
#define BAD(set, status) ((set), CHECK_STATUS(RUN(scene, q, &options, a, &stats), status), options = good, \
                          stats = no_stats(), queries_answer(&host, SLAB, 0, SLAB))
    BAD(q->intersect = NULL, VOLGRAD_ERROR_NULL);
    BAD(q->occluded = NULL, VOLGRAD_ERROR_NULL);
    BAD(q->struct_size = 0, VOLGRAD_ERROR_STRUCT_SIZE);
    BAD(options.struct_size = 3, VOLGRAD_ERROR_STRUCT_SIZE);
    BAD(options.struct_size = 4097, VOLGRAD_ERROR_STRUCT_SIZE);
    BAD(stats.struct_size = 3, VOLGRAD_ERROR_STRUCT_SIZE);
    BAD(options.max_length = 1, VOLGRAD_ERROR_RANGE);
    BAD(options.max_length = VOLGRAD_MAX_LENGTH + 1, VOLGRAD_ERROR_RANGE);
    BAD(options.heuristic = 2, VOLGRAD_ERROR_KIND);
    BAD(options.roulette = -0.5f, VOLGRAD_ERROR_RANGE);
    BAD(options.roulette = NAN, VOLGRAD_ERROR_NOT_FINITE);
    BAD(options.roulette = INFINITY, VOLGRAD_ERROR_NOT_FINITE);
    BAD(options.shift.struct_size -= 4, VOLGRAD_ERROR_STRUCT_SIZE);
    BAD(options.shift.struct_size = 0, VOLGRAD_ERROR_STRUCT_SIZE);
    BAD(options.shift.mode = 99, VOLGRAD_ERROR_KIND);
    BAD((options.shift.mode = VOLGRAD_SHIFT_THESIS, options.shift.kernel = VOLGRAD_KERNEL_BALL,
         options.shift.radius_unit = VOLGRAD_RADIUS_WORLD), VOLGRAD_ERROR_KIND);
    BAD((options.shift.mode = VOLGRAD_SHIFT_EXACT, options.light_vertices = 4), VOLGRAD_ERROR_RANGE);
    BAD((options.shift.mode = VOLGRAD_SHIFT_EXACT, options.light_vertices = UINT32_MAX), VOLGRAD_ERROR_RANGE);
    CHECK(memcmp(block[0], block[1], BYTES) == 0);

    volgrad_bidirectional_options o;
    CHECK_STATUS(volgrad_bidirectional_options_default(&o, sizeof o), VOLGRAD_OK);
    CHECK(o.struct_size == sizeof o && o.max_length == VOLGRAD_MAX_LENGTH && o.rr_depth == 5 && o.seed == 0);
    CHECK(o.heuristic == VOLGRAD_HEURISTIC_BALANCE && o.light_vertices == 0 && o.roulette == 0);
    CHECK(o.shift.mode == VOLGRAD_SHIFT_NONE && o.shift.struct_size == sizeof o.shift);
    FILL(o);
    CHECK_STATUS(volgrad_bidirectional_options_default(&o, offsetof(volgrad_bidirectional_options, heuristic)), VOLGRAD_OK);
    CHECK(UNTOUCHED(o.heuristic) && UNTOUCHED(o.seed));
    CHECK_STATUS(RUN(scene, q, &o, a, NULL), VOLGRAD_OK); /* an older caller */
    REFUSED(o, volgrad_bidirectional_options_default(&o, 3), VOLGRAD_ERROR_STRUCT_SIZE);
    REFUSED(o, volgrad_bidirectional_options_default(&o, 4097), VOLGRAD_ERROR_STRUCT_SIZE);
    CHECK_STATUS(volgrad_bidirectional_options_default(NULL, sizeof o), VOLGRAD_ERROR_NULL);
}

/* Adds one technique's film to `film`. */
static void add_technique(uint32_t lights, uint32_t cameras, uint32_t weighted, volgrad_film *film) {
    volgrad_film *alone = clear(1);
    CHECK_STATUS(volgrad_bidirectional_run_technique(scene, &host.queries, &options, lights, cameras, weighted, 3, 0, PIXELS, alone, NULL),
                 VOLGRAD_OK);
    CHECK_STATUS(volgrad_film_merge(film, alone), VOLGRAD_OK);
}

/* All techniques together are the whole, but for the rounding of splats; one without its weight is more than with it. */
static void test_techniques(void) {
    static float sum[FLOATS], with[FLOATS];
    make_scene();
    options.max_length = 4;
    CHECK_STATUS(run(3, 0, PIXELS, clear(0), NULL), VOLGRAD_OK);
    CHECK_STATUS(volgrad_film_develop((volgrad_film *)(void *)block[0], 1, rgb, FLOATS), VOLGRAD_OK);
    volgrad_film *film = clear(0);
    for (uint32_t edges = 2; edges <= 4; edges++)
        for (uint32_t lights = 0; lights <= edges; lights++) add_technique(lights, edges + 1 - lights, 1, film);
    CHECK_STATUS(volgrad_film_develop(film, 1, sum, FLOATS), VOLGRAD_OK);
    for (int i = 0; i < FLOATS; i++) CHECK_NEAR(sum[i], rgb[i], 1e-6 * rgb[i]);

    for (uint32_t lights = 1; lights <= 2; lights++) {
        add_technique(lights, 3 - lights, 1, film = clear(0));
        CHECK_STATUS(volgrad_film_develop(film, 1, with, FLOATS), VOLGRAD_OK);
        add_technique(lights, 3 - lights, 0, film = clear(0));
        CHECK_STATUS(volgrad_film_develop(film, 1, rgb, FLOATS), VOLGRAD_OK);
        double more = 0, all = 0;
        for (int i = 0; i < FLOATS; i++) {
            CHECK(rgb[i] >= with[i]);
            more += rgb[i] - with[i];
            all += rgb[i];
        }
        CHECK(more > 0.1 * all);
    }
}

static void test_technique_refusals(void) {
    make_scene();
    volgrad_film *film = clear(0);
    memcpy(block[1], block[0], BYTES);
    volgrad_path_sampler_stats stats = no_stats();
#define ONE(scene, lights, cameras, weighted) \
    volgrad_bidirectional_run_technique(scene, &host.queries, &options, lights, cameras, weighted, 0, 0, 10, film, &stats)
    const uint32_t bad[][2] = {{0, 2}, {1, 1}, {2, 0}, {3, 0}, {0, LONGEST + 2}, {LONGEST, 2}, {UINT32_MAX, 4}, {4, UINT32_MAX}};
    for (int i = 0; i < 8; i++) CHECK_STATUS(ONE(scene, bad[i][0], bad[i][1], 1), VOLGRAD_ERROR_RANGE);
    CHECK_STATUS(ONE(scene, 1, 2, 2), VOLGRAD_ERROR_RANGE);
    CHECK_STATUS(ONE(NULL, 1, 2, 1), VOLGRAD_ERROR_NULL);
    CHECK(stats.paths == 0 && memcmp(block[0], block[1], BYTES) == 0);
    const uint32_t good[][2] = {{0, 3}, {2, 1}, {0, LONGEST + 1}, {LONGEST, 1}};
    for (int i = 0; i < 4; i++) CHECK_STATUS(ONE(scene, good[i][0], good[i][1], 0), VOLGRAD_OK);
    CHECK(stats.paths == 40);
}

/* Stops the run at a call, and lets it go on: the whole samples before are in film and stats, and nothing else. */
static void check_stop(enum answer answer, uint32_t good) {
    volgrad_path_sampler_stats stats = no_stats();
    volgrad_film *film = clear(0);
    queries_answer(&host, SLAB, good, answer);
    CHECK_STATUS(run(0, 0, 100, film, &stats), answer_status(answer));
    uint32_t done = (uint32_t)stats.paths;
    CHECK(done < 100);
    queries_answer(&host, SLAB, 0, SLAB);
    CHECK_STATUS(run(0, done, 100 - done, film, &stats), VOLGRAD_OK);
    CHECK(stats.paths == 100 && memcmp(block[0], block[1], BYTES) == 0);
}

static void test_callbacks(void) {
    make_scene();
    CHECK_STATUS(run(0, 0, 100, clear(1), NULL), VOLGRAD_OK);
    for (int answer = STOPS; answer < ANSWERS; answer++) check_stop((enum answer)answer, 150);
    for (uint32_t good = 0; good < 150; good++) check_stop(STOPS, good);
    volgrad_path_sampler_stats stats = no_stats();
    queries_answer(&host, SLAB, 0, OVERFLOWS);
    CHECK_STATUS(run(0, 0, 30, clear(0), &stats), VOLGRAD_OK);
    CHECK(stats.paths == 30 && stats.overflows >= 30);
}

int main(void) {
    test_mean();
    test_options();
    test_ranges();
    test_refusals();
    test_techniques();
    test_technique_refusals();
    test_callbacks();
    free(scene_memory);
    return check_end();
}
