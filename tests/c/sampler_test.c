/* The path sampler, in fog that callbacks of this file describe: a slab between the camera and a sky of radiance 1. */

#include "open_queries.h"

enum { PIXELS = SIDE * SIDE, FLOATS = 3 * PIXELS, BYTES = 48 * PIXELS + 64 };

static small_scene s;
static const volgrad_scene *scene;
static void *scene_memory;
static open_queries host;
static volgrad_path_sampler_options options;
static alignas(16) unsigned char block[2][BYTES];
static volgrad_film *a, *b;
static float rgb[FLOATS];

/* Sky as the only light, albedo `albedo`, vacuum around the camera. */
static void make_scene(float albedo) {
    free(scene_memory);
    small_scene_fill(&s);
    s.lights[0] = s.lights[SKY];
    s.desc.light_count = 1;
    s.desc.camera.medium = VOLGRAD_NONE;
    s.media[0].albedo = (volgrad_rgb){albedo, albedo, albedo};
    scene = scene_make(&s.desc, &scene_memory);
    queries_answer(&host, SLAB, 0, SLAB);
    CHECK_STATUS(volgrad_path_sampler_options_default(&options, sizeof options), VOLGRAD_OK);
}

static volgrad_film *clear(int which) {
    volgrad_film *film = NULL;
    CHECK_STATUS(volgrad_film_init(block[which], BYTES, SIDE, SIDE, &film), VOLGRAD_OK);
    return film;
}

static volgrad_status run(uint64_t pass, uint32_t first, uint32_t count, volgrad_film *film, volgrad_path_sampler_stats *stats) {
    return volgrad_path_sampler_run(scene, &host.queries, &options, pass, first, count, film, stats);
}

/* Mean and its standard error over the paths of some passes. */
static double mean_of_passes(int passes, double *error) {
    double sum = 0, squares = 0, n = (double)passes * PIXELS;
    for (int pass = 0; pass < passes; pass++) {
        a = clear(0);
        CHECK_STATUS(run((uint64_t)pass, 0, PIXELS, a, NULL), VOLGRAD_OK);
        CHECK_STATUS(volgrad_film_develop(a, 1, rgb, FLOATS), VOLGRAD_OK);
        for (int i = 1; i < FLOATS; i += 3) {
            sum += rgb[i];
            squares += (double)rgb[i] * rgb[i];
        }
    }
    *error = sqrt((squares / n - sum / n * (sum / n)) / n);
    return sum / n;
}

/* Both tests fail for one in 10^4 seeds (two-sided, 3.9 standard errors); the seed is fixed. */
static void test_mean(void) {
    double error, expected = 0;
    enum { CELLS = 200 };
    for (int i = 0; i < CELLS * CELLS; i++) {
        double x = 2 * (i % CELLS + 0.5) / CELLS - 1, y = 2 * (i / CELLS + 0.5) / CELLS - 1.0;
        expected += exp(-sqrt(1 + x * x + y * y)) / (CELLS * CELLS);
    }
    make_scene(0); /* only transmittance */
    double mean = mean_of_passes(2, &error);
    CHECK_NEAR(mean, expected, 3.9 * error);
    CHECK_NEAR(mean, expected, 1e-3);
    make_scene(1); /* nothing absorbs, so that all is as bright as the sky */
    mean = mean_of_passes(2, &error);
    CHECK_NEAR(mean, 1, 3.9 * error);
    CHECK(error > 0 && error < 0.02);
    for (uint32_t mode = VOLGRAD_SHIFT_EXACT; mode <= VOLGRAD_SHIFT_EXCHANGEABLE; mode++) {
        /* Shifts correlate neighbours, and some leave the image: the error above, of independent pixels, times 4. */
        double unused;
        options.shift.mode = mode;
        CHECK_NEAR(mean_of_passes(1, &unused), 1, 4 * 3.9 * error);
    }
}

static void test_ranges(void) {
    make_scene(0.5f);
    options.shift.mode = VOLGRAD_SHIFT_EXCHANGEABLE;
    volgrad_path_sampler_stats whole, parts;
    memset(&whole, 0, sizeof whole);
    whole.struct_size = sizeof whole;
    parts = whole;
    a = clear(0);
    CHECK_STATUS(run(3, 0, PIXELS, a, &whole), VOLGRAD_OK);
    b = clear(1);
    CHECK_STATUS(run(3, 1000, PIXELS - 1000, b, &parts), VOLGRAD_OK);
    CHECK_STATUS(run(3, 7, 993, b, &parts), VOLGRAD_OK);
    CHECK_STATUS(run(3, 0, 7, b, &parts), VOLGRAD_OK);
    CHECK_STATUS(run(3, PIXELS, 0, b, &parts), VOLGRAD_OK);
    CHECK(memcmp(block[0], block[1], BYTES) == 0);
    CHECK(parts.rays >= whole.rays); /* a tile cut by a range's end has its rays traced twice */
    parts.rays = whole.rays;
    CHECK(memcmp(&whole, &parts, sizeof whole) == 0);
    CHECK(whole.paths == PIXELS && whole.rays >= PIXELS && whole.occlusion_rays > 0);
    CHECK(whole.shifted_paths > 0 && whole.shifts >= 8 * whole.shifted_paths && whole.overflows == 0);
    CHECK_STATUS(run(4, 0, PIXELS, clear(1), NULL), VOLGRAD_OK);
    CHECK(memcmp(block[0], block[1], BYTES) != 0);

    const uint32_t most = UINT32_MAX;
    const uint32_t bad[][2] = {{0, PIXELS + 1}, {PIXELS, 1}, {PIXELS + 1, 0}, {most, 1}, {1, most}, {most, most}};
    FILL(parts);
    parts.struct_size = offsetof(volgrad_path_sampler_stats, paths);
    memcpy(block[1], block[0], BYTES);
    for (int i = 0; i < 6; i++) CHECK_STATUS(run(3, bad[i][0], bad[i][1], a, &parts), VOLGRAD_ERROR_RANGE);
    CHECK(memcmp(block[0], block[1], BYTES) == 0);
    CHECK(untouched(&parts.reserved, sizeof parts - offsetof(volgrad_path_sampler_stats, reserved)));

    /* Pixels are counted within the crop. */
    s.desc.camera.crop_x0 = 10, s.desc.camera.crop_x1 = 20;
    s.desc.camera.crop_y0 = 5, s.desc.camera.crop_y1 = 8;
    free(scene_memory);
    scene = scene_make(&s.desc, &scene_memory);
    options.shift.mode = VOLGRAD_SHIFT_NONE;
    a = clear(0);
    CHECK_STATUS(run(0, 0, 31, a, NULL), VOLGRAD_ERROR_RANGE);
    CHECK_STATUS(run(0, 0, 30, a, NULL), VOLGRAD_OK);
    CHECK_STATUS(volgrad_film_develop(a, 1, rgb, FLOATS), VOLGRAD_OK);
    for (int i = 0; i < PIXELS; i++) {
        int x = i % SIDE, y = i / SIDE;
        CHECK((rgb[3 * i] > 0) == (x >= 10 && x < 20 && y >= 5 && y < 8));
    }
}

static void test_stats(void) {
    struct {
        volgrad_path_sampler_stats stats;
        unsigned char tail[16];
    } larger;
    make_scene(0);
    a = clear(0);
    memset(&larger, 0, sizeof larger);
    larger.stats.struct_size = sizeof larger;
    larger.stats.paths = 100, larger.stats.stays = 5;
    CHECK_STATUS(run(0, 0, 10, a, &larger.stats), VOLGRAD_OK);
    CHECK_STATUS(run(1, 0, 10, a, &larger.stats), VOLGRAD_OK);
    CHECK(larger.stats.struct_size == sizeof larger && larger.stats.paths == 120 && larger.stats.rays == 20);
    CHECK(larger.stats.stays == 5 && larger.stats.shifts == 0);
    FILL(larger);
    larger.stats.struct_size = offsetof(volgrad_path_sampler_stats, rays);
    larger.stats.paths = 1;
    CHECK_STATUS(run(0, 0, 10, a, &larger.stats), VOLGRAD_OK);
    CHECK(larger.stats.paths == 11 && larger.stats.struct_size == offsetof(volgrad_path_sampler_stats, rays));
    CHECK(untouched(&larger.stats.rays, sizeof larger - offsetof(volgrad_path_sampler_stats, rays)));

    memcpy(block[1], block[0], BYTES);
    const uint32_t sizes[] = {0, 3, sizeof larger, 4097, UINT32_MAX}; /* the third has a tail of a newer version */
    for (int i = 0; i < 5; i++) {
        larger.stats.struct_size = sizes[i];
        CHECK_STATUS(run(0, 0, 10, a, &larger.stats), VOLGRAD_ERROR_STRUCT_SIZE);
    }
    CHECK(larger.stats.paths == 11 && memcmp(block[0], block[1], BYTES) == 0);
    CHECK_STATUS(run(0, 0, 1, a, (void *)(larger.tail + 2)), VOLGRAD_ERROR_MISALIGNED);
}

static void test_refusals(void) {
    static alignas(16) const unsigned char zeros[1 << 12];
    static alignas(16) unsigned char small[48 * 4 * 4 + 64];
    make_scene(0);
    a = clear(0);
    memcpy(block[1], block[0], BYTES);
    const volgrad_path_sampler_options good = options;
    volgrad_queries *q = &host.queries;
    volgrad_film *film;
#define RUN(scene, queries, options, film) volgrad_path_sampler_run(scene, queries, options, 0, 0, 10, film, NULL)
    CHECK_STATUS(RUN(NULL, q, &options, a), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(RUN(scene, NULL, &options, a), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(RUN(scene, q, NULL, a), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(RUN(scene, q, &options, NULL), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(RUN((const void *)zeros, q, &options, a), VOLGRAD_ERROR_NOT_INITIALISED);
    CHECK_STATUS(RUN((const void *)(zeros + 4), q, &options, a), VOLGRAD_ERROR_MISALIGNED);
    CHECK_STATUS(RUN(scene, q, &options, (volgrad_film *)(void *)small), VOLGRAD_ERROR_NOT_INITIALISED);
    CHECK_STATUS(RUN(scene, q, &options, (volgrad_film *)(void *)(small + 8)), VOLGRAD_ERROR_MISALIGNED);
    CHECK_STATUS(volgrad_film_init(small, sizeof small, 4, 4, &film), VOLGRAD_OK);
    CHECK_STATUS(RUN(scene, q, &options, film), VOLGRAD_ERROR_SIZE_MISMATCH);
#define BAD(set, status) \
    ((set), CHECK_STATUS(RUN(scene, q, &options, a), status), options = good, queries_answer(&host, SLAB, 0, SLAB))
    BAD(q->intersect = NULL, VOLGRAD_ERROR_NULL);
    BAD(q->occluded = NULL, VOLGRAD_ERROR_NULL);
    BAD(q->struct_size = 0, VOLGRAD_ERROR_STRUCT_SIZE);
    BAD(q->struct_size = offsetof(volgrad_queries, occluded) + 4, VOLGRAD_ERROR_STRUCT_SIZE); /* half a pointer */
    BAD(options.struct_size = 3, VOLGRAD_ERROR_STRUCT_SIZE);
    BAD(options.struct_size = 4097, VOLGRAD_ERROR_STRUCT_SIZE);
    BAD(options.shift.struct_size = 0, VOLGRAD_ERROR_STRUCT_SIZE);
    for (uint32_t mode = VOLGRAD_SHIFT_THESIS; mode <= 10; mode++) { /* of chains, and none */
        options.shift.kernel = VOLGRAD_KERNEL_BALL, options.shift.radius_unit = VOLGRAD_RADIUS_WORLD;
        BAD(options.shift.mode = mode, VOLGRAD_ERROR_KIND);
    }
    BAD((options.shift.mode = VOLGRAD_SHIFT_EXACT, options.shift.kernel = 3), VOLGRAD_ERROR_KIND);
    BAD(options.first_vertex = 2 * VOLGRAD_FIRST_VERTEX_NONE, VOLGRAD_ERROR_KIND);
    BAD((options.shift.mode = VOLGRAD_SHIFT_EXACT, options.shift.kernel = VOLGRAD_KERNEL_TILE, options.shift.count = 9), VOLGRAD_ERROR_RANGE);
    BAD((options.shift.mode = VOLGRAD_SHIFT_EXACT, options.shift.run = 0), VOLGRAD_ERROR_RANGE);
    BAD((options.shift.mode = VOLGRAD_SHIFT_EXACT, options.shift.kernel = VOLGRAD_KERNEL_BALL), VOLGRAD_ERROR_KIND);
    BAD((options.shift.mode = VOLGRAD_SHIFT_EXACT, options.shift.kernel = VOLGRAD_KERNEL_DISK, options.shift.radius = NAN),
        VOLGRAD_ERROR_NOT_FINITE);
    BAD((options.shift.mode = VOLGRAD_SHIFT_EXACT, options.shift.count = VOLGRAD_MAX_SHIFTS + 1), VOLGRAD_ERROR_RANGE);
    CHECK(memcmp(block[0], block[1], BYTES) == 0);

    volgrad_path_sampler_options o;
    CHECK(options.struct_size == sizeof o && options.max_depth == 0 && options.rr_depth == 5 && options.seed == 0);
    CHECK(options.shift.struct_size == sizeof o.shift && options.shift.mode == VOLGRAD_SHIFT_NONE);
    FILL(o);
    CHECK_STATUS(volgrad_path_sampler_options_default(&o, offsetof(volgrad_path_sampler_options, seed)), VOLGRAD_OK);
    CHECK(o.struct_size == offsetof(volgrad_path_sampler_options, seed) && UNTOUCHED(o.seed) && UNTOUCHED(o.shift));
    CHECK_STATUS(volgrad_path_sampler_run(scene, q, &o, 0, 0, 10, a, NULL), VOLGRAD_OK); /* an older caller */
    REFUSED(o, volgrad_path_sampler_options_default(&o, 3), VOLGRAD_ERROR_STRUCT_SIZE);
    REFUSED(o, volgrad_path_sampler_options_default(&o, 4097), VOLGRAD_ERROR_STRUCT_SIZE);
    CHECK_STATUS(volgrad_path_sampler_options_default(NULL, sizeof o), VOLGRAD_ERROR_NULL);
}

/* Never the first, good answer of `user`. */
static int32_t answer_badly(void *user, const volgrad_ray *rays, volgrad_hit *hits, uint32_t count) {
    open_queries bad = *(const open_queries *)user;
    bad.good = 0;
    return answer_rays(&bad, rays, hits, count);
}

/* Without scattering a path asks once: on an error, film and stats hold the ten paths before it. */
static void test_callbacks(void) {
    make_scene(0);
    for (int answer = STOPS; answer < ANSWERS; answer++) {
        volgrad_path_sampler_stats stats;
        memset(&stats, 0, sizeof stats);
        stats.struct_size = sizeof stats;
        queries_answer(&host, SLAB, 10, (enum answer)answer);
        CHECK_STATUS(run(0, 0, PIXELS, clear(0), &stats), answer_status((enum answer)answer));
        CHECK(stats.paths == 10 && host.calls == 11);
        queries_answer(&host, SLAB, 0, SLAB);
        CHECK_STATUS(run(0, 0, 10, clear(1), NULL), VOLGRAD_OK);
        CHECK(memcmp(block[0], block[1], BYTES) == 0);
    }
    volgrad_path_sampler_stats stats;
    memset(&stats, 0, sizeof stats);
    stats.struct_size = sizeof stats;
    queries_answer(&host, SLAB, 10, OVERFLOWS);
    CHECK_STATUS(run(0, 0, 30, a = clear(0), &stats), VOLGRAD_OK);
    CHECK(stats.paths == 30 && stats.overflows == 20);
    CHECK_STATUS(volgrad_film_develop(a, 1, rgb, FLOATS), VOLGRAD_OK);
    for (int i = 0; i < 30; i++) CHECK((rgb[3 * i] > 0) == (i < 10));

    /* The same rules for occlusion queries, in a slab that scatters. */
    make_scene(1);
    for (int answer = STOPS; answer <= KIND_BEYOND; answer++) {
        queries_answer(&host, SLAB, UINT32_MAX, (enum answer)answer);
        host.queries.occluded = answer_badly;
        CHECK_STATUS(run(0, 0, PIXELS, clear(0), NULL), answer_status((enum answer)answer));
    }
}

int main(void) {
    test_mean();
    test_ranges();
    test_stats();
    test_refusals();
    test_callbacks();
    free(scene_memory);
    return check_end();
}
