/* Metropolis chains, in a slab of fog before a sky: bootstrap, plan, chains. */

#include "open_queries.h"

enum { PIXELS = SIDE * SIDE, FLOATS = 3 * PIXELS, BYTES = 48 * PIXELS + 64, SHORTEST = 2, LONGEST = 6, SAMPLES = 5000 };
enum { WANTED = 40, ROOM = WANTED + VOLGRAD_MAX_LENGTH, CHAIN_BYTES = 1 << 13, BURN_IN = 64 };

static small_scene s;
static const volgrad_scene *scene;
static void *scene_memory;
static open_queries host;
static volgrad_chain_options options;
static alignas(16) unsigned char block[2][BYTES];
static alignas(16) unsigned char memory[ROOM][CHAIN_BYTES];
static float weights[SAMPLES];
static volgrad_chain_start starts[ROOM];
static volgrad_chain_techniques techniques;
static volgrad_chain_plan_result plan;
static float rgb[FLOATS];

static void make_scene(void) {
    free(scene_memory);
    small_scene_fill(&s);
    s.lights[0] = s.lights[SKY];
    s.lights[0].medium = VOLGRAD_NONE;
    s.desc.light_count = 1;
    s.desc.camera.medium = VOLGRAD_NONE;
    s.media[0].albedo = (volgrad_rgb){0.8f, 0.8f, 0.8f};
    scene = scene_make(&s.desc, &scene_memory);
    queries_answer(&host, SLAB, 0, SLAB);
    CHECK_STATUS(volgrad_chain_options_default(&options, sizeof options), VOLGRAD_OK);
    options.min_length = SHORTEST;
    options.max_length = LONGEST;
    options.burn_in = BURN_IN;
}

/* Kernels as they are by default, but for the thesis, which has a ball. */
static void set_shift(uint32_t mode) {
    options.shift.mode = mode;
    if (mode == VOLGRAD_SHIFT_THESIS || mode == VOLGRAD_SHIFT_THESIS_PRINTED) {
        options.shift.kernel = VOLGRAD_KERNEL_BALL;
        options.shift.radius_unit = VOLGRAD_RADIUS_WORLD;
        options.shift.radius = 0.2f;
        options.shift.alpha = 0.25f;
    }
}

static volgrad_film *clear(int which) {
    volgrad_film *film = NULL;
    CHECK_STATUS(volgrad_film_init(block[which], BYTES, SIDE, SIDE, &film), VOLGRAD_OK);
    return film;
}

static volgrad_chain_stats no_stats(void) {
    volgrad_chain_stats stats;
    memset(&stats, 0, sizeof stats);
    stats.struct_size = sizeof stats;
    return stats;
}

static volgrad_status bootstrap_counted(uint64_t first, uint32_t count, float *to, volgrad_chain_stats *stats) {
    return volgrad_chain_bootstrap(scene, &host.queries, &options, &techniques, first, count, to, stats);
}

static volgrad_status bootstrap(uint64_t first, uint32_t count, float *to) {
    return bootstrap_counted(first, count, to, NULL);
}

/* Techniques learned from samples of another seed. */
static void learn_techniques(void) {
    volgrad_chain_options other = options;
    other.seed = ~options.seed;
    CHECK_STATUS(volgrad_chain_bootstrap(scene, &host.queries, &other, NULL, 0, SAMPLES, weights, NULL), VOLGRAD_OK);
    CHECK_STATUS(volgrad_chain_learn(&other, weights, SAMPLES, &techniques), VOLGRAD_OK);
}

static volgrad_status make_plan(volgrad_chain_start *to) {
    memset(&plan, 0, sizeof plan);
    plan.struct_size = sizeof plan;
    return volgrad_chain_plan(&options, &techniques, weights, SAMPLES, WANTED, to, ROOM, &plan);
}

static volgrad_status init(int which, const volgrad_chain_start *start, volgrad_chain_stats *stats, volgrad_chain **chain) {
    return volgrad_chain_init(memory[which], CHAIN_BYTES, scene, &host.queries, &options, &techniques, start, stats, chain);
}

static volgrad_status run(volgrad_chain *chain, uint64_t mutations, volgrad_film *film, volgrad_chain_stats *stats) {
    return volgrad_chain_run(chain, scene, &host.queries, mutations, film, stats);
}

static volgrad_status flush(const volgrad_chain *chain, volgrad_film *film) {
    return volgrad_chain_flush(chain, scene, &host.queries, film, NULL);
}

static volgrad_chain *first_chain(int which) {
    volgrad_chain *chain = NULL;
    CHECK_STATUS(init(which, &starts[0], NULL, &chain), VOLGRAD_OK);
    return chain;
}

static void prepare(void) {
    make_scene();
    learn_techniques();
    CHECK_STATUS(bootstrap(0, SAMPLES, weights), VOLGRAD_OK);
    CHECK_STATUS(make_plan(starts), VOLGRAD_OK);
    CHECK(plan.chain_count > 0);
}

/* ---- options, which every function reads ---- */

static void check_options(volgrad_status expected) {
    static volgrad_chain_techniques learned;
    volgrad_chain *chain;
    size_t bytes;
    float weight;
    volgrad_chain_start start = starts[0];
    REFUSED(weight, bootstrap(0, 1, &weight), expected);
    REFUSED(learned, volgrad_chain_learn(&options, weights, SAMPLES, &learned), expected);
    CHECK_STATUS(make_plan(starts), expected);
    REFUSED(bytes, volgrad_chain_size(&options, &bytes), expected);
    REFUSED(chain, init(0, &start, NULL, &chain), expected);
}

static void test_options(void) {
    prepare();
    volgrad_chain_options o = options;
    CHECK_STATUS(volgrad_chain_options_default(&o, sizeof o), VOLGRAD_OK);
    CHECK(o.struct_size == sizeof o && o.min_length == 2 && o.max_length == 32 && o.burn_in == 512 && o.shift_every == 4);
    CHECK(o.large_step > 0.29f && o.large_step < 0.31f && o.seed == 0 && o.shift.mode == VOLGRAD_SHIFT_NONE);
    CHECK(o.shift.struct_size == sizeof o.shift);
    FILL(o);
    CHECK_STATUS(volgrad_chain_options_default(&o, offsetof(volgrad_chain_options, seed)), VOLGRAD_OK);
    CHECK(UNTOUCHED(o.seed) && UNTOUCHED(o.shift));
    size_t bytes;
    CHECK_STATUS(volgrad_chain_size(&o, &bytes), VOLGRAD_OK); /* an older caller */
    REFUSED(o, volgrad_chain_options_default(&o, 3), VOLGRAD_ERROR_STRUCT_SIZE);
    REFUSED(o, volgrad_chain_options_default(&o, 4097), VOLGRAD_ERROR_STRUCT_SIZE);
    CHECK_STATUS(volgrad_chain_options_default(NULL, sizeof o), VOLGRAD_ERROR_NULL);

    const volgrad_chain_options good = options;
#define BAD(set, status) ((set), check_options(status), options = good)
    BAD(options.struct_size = 3, VOLGRAD_ERROR_STRUCT_SIZE);
    BAD(options.struct_size = 4097, VOLGRAD_ERROR_STRUCT_SIZE);
    BAD(options.min_length = 1, VOLGRAD_ERROR_RANGE);
    BAD((options.min_length = 5, options.max_length = 4), VOLGRAD_ERROR_RANGE);
    BAD(options.max_length = VOLGRAD_MAX_LENGTH + 1, VOLGRAD_ERROR_RANGE);
    BAD(options.large_step = 0, VOLGRAD_ERROR_RANGE);
    BAD(options.large_step = 1.01f, VOLGRAD_ERROR_RANGE);
    BAD(options.large_step = NAN, VOLGRAD_ERROR_RANGE);
    BAD(options.shift_every = 0, VOLGRAD_ERROR_RANGE);
    BAD(options.shift.struct_size = 8, VOLGRAD_ERROR_STRUCT_SIZE);
    BAD(options.shift.mode = 10, VOLGRAD_ERROR_KIND);
    for (uint32_t mode = VOLGRAD_SHIFT_THESIS; mode <= VOLGRAD_SHIFT_THESIS_PRINTED; mode++) {
        set_shift(mode);
        CHECK_STATUS(volgrad_chain_size(&options, &bytes), VOLGRAD_OK);
        options = good;
        BAD(options.shift.mode = mode, VOLGRAD_ERROR_KIND); /* tiles */
        BAD((set_shift(mode), options.shift.kernel = VOLGRAD_KERNEL_DISK), VOLGRAD_ERROR_KIND);
        BAD((set_shift(mode), options.shift.radius_unit = VOLGRAD_RADIUS_PIXELS), VOLGRAD_ERROR_KIND);
        BAD((set_shift(mode), options.shift.radius = 0), VOLGRAD_ERROR_RANGE);
        BAD((set_shift(mode), options.shift.alpha = 2), VOLGRAD_ERROR_RANGE);
        BAD((set_shift(mode), options.shift.clamp = -1), VOLGRAD_ERROR_RANGE);
        BAD((set_shift(mode), options.shift.count = VOLGRAD_MAX_SHIFTS + 1), VOLGRAD_ERROR_RANGE);
    }
    BAD((options.shift.mode = VOLGRAD_SHIFT_EXACT, options.shift.count = VOLGRAD_MAX_SHIFTS + 1), VOLGRAD_ERROR_RANGE);
}

/* ---- bootstrap and plan ---- */

static void test_bootstrap(void) {
    static float parts[SAMPLES];
    prepare();
    CHECK_STATUS(bootstrap(1000, SAMPLES - 1000, parts + 1000), VOLGRAD_OK);
    CHECK_STATUS(bootstrap(7, 993, parts + 7), VOLGRAD_OK);
    CHECK_STATUS(bootstrap(0, 7, parts), VOLGRAD_OK);
    CHECK_STATUS(bootstrap(0, 0, NULL), VOLGRAD_OK);
    CHECK(memcmp(parts, weights, sizeof parts) == 0);
    options.seed = 1;
    CHECK_STATUS(bootstrap(0, SAMPLES, parts), VOLGRAD_OK);
    CHECK(memcmp(parts, weights, sizeof parts) != 0);

    volgrad_queries *q = &host.queries;
    float w;
    REFUSED(w, volgrad_chain_bootstrap(NULL, q, &options, NULL, 0, 1, &w, NULL), VOLGRAD_ERROR_NULL);
    REFUSED(w, volgrad_chain_bootstrap(scene, NULL, &options, NULL, 0, 1, &w, NULL), VOLGRAD_ERROR_NULL);
    REFUSED(w, volgrad_chain_bootstrap(scene, q, NULL, NULL, 0, 1, &w, NULL), VOLGRAD_ERROR_NULL);
    REFUSED(w, volgrad_chain_bootstrap(scene, q, &options, NULL, 0, 1, NULL, NULL), VOLGRAD_ERROR_NULL);
    REFUSED(w, volgrad_chain_bootstrap(scene, q, &options, NULL, 0, 1, (void *)((char *)parts + 1), NULL), VOLGRAD_ERROR_MISALIGNED);
    const volgrad_chain_techniques *misaligned = (const void *)((const char *)&techniques + 2);
    REFUSED(w, volgrad_chain_bootstrap(scene, q, &options, misaligned, 0, 1, &w, NULL), VOLGRAD_ERROR_MISALIGNED);
    volgrad_chain_stats stats = no_stats();
    stats.struct_size = 3;
    REFUSED(w, bootstrap_counted(0, 1, &w, &stats), VOLGRAD_ERROR_STRUCT_SIZE);
}

static void test_bootstrap_stats(void) {
    static float parts[SAMPLES];
    prepare();
    volgrad_chain_stats once = no_stats(), twice = no_stats(), stopped = no_stats();
    CHECK_STATUS(bootstrap_counted(0, SAMPLES, weights, &once), VOLGRAD_OK);
    CHECK(once.samples == SAMPLES && once.rays > 0 && once.occlusion_rays > 0 && once.dropped == 0 && once.overflows == 0);
    CHECK(once.large_steps == 0 && once.burn_in == 0 && once.shifts == 0);
    CHECK_STATUS(bootstrap_counted(0, 999, parts, &twice), VOLGRAD_OK);
    CHECK_STATUS(bootstrap_counted(999, SAMPLES - 999, parts + 999, &twice), VOLGRAD_OK);
    CHECK(memcmp(&once, &twice, sizeof once) == 0);
    /* Stopped, what is there is right. */
    queries_answer(&host, SLAB, 20, STOPS);
    for (int i = 0; i < SAMPLES; i++) parts[i] = -1;
    CHECK_STATUS(bootstrap_counted(0, SAMPLES, parts, &stopped), VOLGRAD_ERROR_CALLBACK);
    CHECK(stopped.samples > 0 && stopped.samples < 20 && parts[stopped.samples] == -1);
    CHECK(memcmp(parts, weights, stopped.samples * sizeof *parts) == 0);
    queries_answer(&host, SLAB, 20, OVERFLOWS);
    CHECK_STATUS(bootstrap_counted(0, 500, parts, &twice), VOLGRAD_OK);
    CHECK(twice.overflows > 0 && twice.samples == SAMPLES + 500);
    /* Under a sky as bright as numbers go. */
    prepare();
    s.lights[0].emission = (volgrad_rgb){3e38f, 3e38f, 3e38f};
    free(scene_memory);
    scene = scene_make(&s.desc, &scene_memory);
    volgrad_chain_stats bright = no_stats();
    CHECK_STATUS(bootstrap_counted(0, SAMPLES, weights, &bright), VOLGRAD_OK);
    uint64_t dark = 0;
    for (int i = 0; i < SAMPLES; i++) {
        CHECK(weights[i] >= 0 && isfinite(weights[i]));
        dark += weights[i] == 0;
    }
    CHECK(bright.dropped > 0 && bright.dropped <= dark);
}

static void test_learn(void) {
    static volgrad_chain_techniques learned, alike;
    prepare();
    for (int row = 0; row < 66; row++) {
        for (int i = 0; i < 65; i++) {
            CHECK(techniques.shares[row][i] <= 1 && techniques.shares[row][i] >= (i > 0 ? techniques.shares[row][i - 1] : 0));
        }
        CHECK(techniques.shares[row][64] == 1);
    }
    CHECK(techniques.shares[0][SHORTEST - 1] == 0 && techniques.shares[0][SHORTEST] > 0 && techniques.shares[0][LONGEST] == 1);
    CHECK(techniques.shares[0][SHORTEST] > techniques.shares[0][LONGEST] - techniques.shares[0][LONGEST - 1]); /* shorter is brighter */
    double learned_error = plan.relative_error;
    CHECK_STATUS(volgrad_chain_bootstrap(scene, &host.queries, &options, NULL, 0, SAMPLES, weights, NULL), VOLGRAD_OK);
    CHECK_STATUS(volgrad_chain_plan(&options, NULL, weights, SAMPLES, 1, NULL, 0, &plan), VOLGRAD_OK);
    CHECK(learned_error < plan.relative_error); /* what it is for */

    CHECK_STATUS(volgrad_chain_learn(&options, NULL, 0, &alike), VOLGRAD_OK); /* nothing to learn from */
    CHECK(alike.shares[0][SHORTEST] > 0.199f && alike.shares[0][SHORTEST] < 0.201f && alike.shares[0][LONGEST] == 1);
    REFUSED(learned, volgrad_chain_learn(NULL, weights, SAMPLES, &learned), VOLGRAD_ERROR_NULL);
    REFUSED(learned, volgrad_chain_learn(&options, NULL, SAMPLES, &learned), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_chain_learn(&options, weights, SAMPLES, NULL), VOLGRAD_ERROR_NULL);
    REFUSED(learned, volgrad_chain_learn(&options, (void *)((char *)weights + 1), 9, &learned), VOLGRAD_ERROR_MISALIGNED);
    CHECK_STATUS(volgrad_chain_learn(&options, weights, SAMPLES, (void *)((char *)&learned + 1)), VOLGRAD_ERROR_MISALIGNED);
    weights[17] = NAN;
    REFUSED(learned, volgrad_chain_learn(&options, weights, SAMPLES, &learned), VOLGRAD_ERROR_NOT_FINITE);
}

static void test_plan(void) {
    prepare();
    uint32_t of_length[LONGEST + 1] = {0};
    double brightness[LONGEST + 1] = {0}, sum = 0;
    CHECK(plan.chain_count >= WANTED - LONGEST && plan.chain_count <= ROOM);
    CHECK(plan.brightness > 0 && plan.relative_error > 0 && plan.relative_error < 0.2);
    for (uint32_t i = 0; i < plan.chain_count; i++) {
        const volgrad_chain_start *start = &starts[i];
        CHECK(start->index == i && start->chains == plan.chain_count && start->others >= 0);
        CHECK(start->length >= SHORTEST && start->length <= LONGEST && start->sample < SAMPLES);
        CHECK(weights[start->sample] > 0);
        of_length[start->length]++;
        brightness[start->length] = start->brightness;
    }
    for (uint32_t i = 0; i < plan.chain_count; i++) {
        CHECK_NEAR(starts[i].share, (double)plan.chain_count / of_length[starts[i].length], 1e-12);
    }
    for (int i = SHORTEST; i <= LONGEST; i++) sum += brightness[i];
    CHECK_NEAR(plan.brightness, sum, 1e-12 * sum);
    volgrad_chain_plan_result first = plan;
    CHECK_STATUS(make_plan(NULL), VOLGRAD_OK); /* only the result */
    CHECK(memcmp(&first, &plan, sizeof plan) == 0);

#define PLAN(options, weights, count, wanted, starts, capacity, result) \
    volgrad_chain_plan(options, &techniques, weights, count, wanted, starts, capacity, result)
    volgrad_chain_start untouched_start;
    REFUSED(untouched_start, PLAN(NULL, weights, SAMPLES, 1, &untouched_start, 1, &plan), VOLGRAD_ERROR_NULL);
    REFUSED(untouched_start, PLAN(&options, NULL, SAMPLES, 1, &untouched_start, 1, &plan), VOLGRAD_ERROR_NULL);
    REFUSED(untouched_start, PLAN(&options, weights, SAMPLES, 1, &untouched_start, 1, NULL), VOLGRAD_ERROR_NULL);
    REFUSED(untouched_start, PLAN(&options, weights, SAMPLES, WANTED, &untouched_start, 1, &plan), VOLGRAD_ERROR_TOO_SMALL);
    REFUSED(untouched_start, PLAN(&options, weights, SAMPLES, 0, &untouched_start, 1, &plan), VOLGRAD_ERROR_RANGE);
    REFUSED(untouched_start, PLAN(&options, weights, SAMPLES, (1u << 24) + 1, &untouched_start, 1, &plan), VOLGRAD_ERROR_RANGE);
    CHECK_STATUS(PLAN(&options, (void *)((char *)weights + 1), 4, 1, starts, ROOM, &plan), VOLGRAD_ERROR_MISALIGNED);
    CHECK_STATUS(PLAN(&options, weights, SAMPLES, 1, (void *)((char *)starts + 4), ROOM, &plan), VOLGRAD_ERROR_MISALIGNED);
    CHECK_STATUS(PLAN(&options, weights, SAMPLES, 1, starts, ROOM, (void *)((char *)&first + 2)), VOLGRAD_ERROR_MISALIGNED);
    const volgrad_chain_techniques *misaligned = (const void *)((const char *)&techniques + 2);
    CHECK_STATUS(volgrad_chain_plan(&options, misaligned, weights, SAMPLES, 1, starts, ROOM, &plan), VOLGRAD_ERROR_MISALIGNED);
    plan.struct_size = 3;
    CHECK_STATUS(PLAN(&options, weights, SAMPLES, 1, starts, ROOM, &plan), VOLGRAD_ERROR_STRUCT_SIZE);
    const float bad[] = {NAN, INFINITY, -1};
    for (int i = 0; i < 3; i++) {
        weights[17] = bad[i];
        CHECK_STATUS(make_plan(starts), VOLGRAD_ERROR_NOT_FINITE);
    }
    memset(weights, 0, sizeof weights); /* all dark */
    CHECK_STATUS(make_plan(starts), VOLGRAD_OK);
    CHECK(plan.chain_count == 0 && plan.brightness == 0 && plan.relative_error == 0);
    CHECK_STATUS(PLAN(&options, NULL, 0, 1, starts, ROOM, &plan), VOLGRAD_OK);
    CHECK(plan.chain_count == 0);
}

/* ---- one chain ---- */

static void test_memory(void) {
    prepare();
    size_t bytes;
    options.max_length = 16;
    CHECK_STATUS(volgrad_chain_size(&options, &bytes), VOLGRAD_OK);
    CHECK(bytes > 0 && bytes <= 8192 && bytes % 16 == 0);
    options.max_length = VOLGRAD_MAX_LENGTH;
    CHECK_STATUS(volgrad_chain_size(&options, &bytes), VOLGRAD_OK);
    CHECK(bytes <= CHAIN_BYTES);
    options.max_length = LONGEST;
    CHECK_STATUS(volgrad_chain_size(NULL, &bytes), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_chain_size(&options, NULL), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_chain_size(&options, &bytes), VOLGRAD_OK);

    /* Not a byte more is written. */
    volgrad_chain *chain;
    memset(memory[0], 0xA5, CHAIN_BYTES);
    CHECK_STATUS(volgrad_chain_init(memory[0], bytes, scene, &host.queries, &options, &techniques, starts, NULL, &chain), VOLGRAD_OK);
    volgrad_film *film = clear(0);
    CHECK_STATUS(run(chain, 100, film, NULL), VOLGRAD_OK);
    CHECK(untouched(memory[0] + bytes, CHAIN_BYTES - bytes));

#define INIT(memory, bytes, start, stats) \
    volgrad_chain_init(memory, bytes, scene, &host.queries, &options, &techniques, start, stats, &chain)
    REFUSED(chain, INIT(memory[0], bytes - 1, starts, NULL), VOLGRAD_ERROR_TOO_SMALL);
    REFUSED(chain, INIT(memory[0] + 8, bytes, starts, NULL), VOLGRAD_ERROR_MISALIGNED);
    REFUSED(chain, INIT(NULL, bytes, starts, NULL), VOLGRAD_ERROR_NULL);
    REFUSED(chain, INIT(memory[0], bytes, NULL, NULL), VOLGRAD_ERROR_NULL);
    REFUSED(chain, volgrad_chain_init(memory[0], bytes, NULL, &host.queries, &options, NULL, starts, NULL, &chain), VOLGRAD_ERROR_NULL);
    REFUSED(chain, volgrad_chain_init(memory[0], bytes, scene, NULL, &options, NULL, starts, NULL, &chain), VOLGRAD_ERROR_NULL);
    REFUSED(chain, volgrad_chain_init(memory[0], bytes, scene, &host.queries, NULL, NULL, starts, NULL, &chain), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_chain_init(memory[0], bytes, scene, &host.queries, &options, NULL, starts, NULL, NULL), VOLGRAD_ERROR_NULL);
    volgrad_chain_start bad = starts[0];
#define BAD_START(set) ((set), (void)REFUSED(chain, INIT(memory[0], bytes, &bad, NULL), VOLGRAD_ERROR_RANGE), bad = starts[0])
    BAD_START(bad.length = LONGEST + 1);
    BAD_START(bad.length = SHORTEST - 1);
    BAD_START(bad.brightness = 0);
    BAD_START(bad.brightness = NAN);
    BAD_START(bad.share = -1);
    BAD_START(bad.sample++); /* a path of another length, or none that a chain could begin with */
    volgrad_chain_stats stats = no_stats();
    stats.struct_size = 3;
    REFUSED(chain, INIT(memory[0], bytes, starts, &stats), VOLGRAD_ERROR_STRUCT_SIZE);
}

static void test_refusals(void) {
    static alignas(16) unsigned char small[48 * 4 * 4 + 64], zeros[CHAIN_BYTES];
    prepare();
    volgrad_chain *chain = first_chain(0), *none = (void *)zeros;
    volgrad_film *film = clear(0), *four;
    volgrad_chain_stats stats = no_stats();
    CHECK_STATUS(volgrad_film_init(small, sizeof small, 4, 4, &four), VOLGRAD_OK);
    memcpy(block[1], block[0], BYTES);
    memcpy(memory[1], memory[0], CHAIN_BYTES);
    CHECK_STATUS(run(NULL, 9, film, &stats), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(run(chain, 9, NULL, &stats), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_chain_run(chain, NULL, &host.queries, 9, film, &stats), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_chain_run(chain, scene, NULL, 9, film, &stats), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(run(none, 9, film, &stats), VOLGRAD_ERROR_NOT_INITIALISED);
    CHECK_STATUS(run((void *)(zeros + 8), 9, film, &stats), VOLGRAD_ERROR_MISALIGNED);
    CHECK_STATUS(run(chain, 9, (void *)zeros, &stats), VOLGRAD_ERROR_NOT_INITIALISED);
    CHECK_STATUS(run(chain, 9, four, &stats), VOLGRAD_ERROR_SIZE_MISMATCH);
    CHECK_STATUS(run(chain, 9, film, (void *)(zeros + 2)), VOLGRAD_ERROR_MISALIGNED);
    stats.struct_size = 3;
    CHECK_STATUS(run(chain, 9, film, &stats), VOLGRAD_ERROR_STRUCT_SIZE);
    CHECK_STATUS(volgrad_chain_flush(chain, scene, &host.queries, film, &stats), VOLGRAD_ERROR_STRUCT_SIZE);
    CHECK_STATUS(flush(NULL, film), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(flush(chain, NULL), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_chain_flush(chain, NULL, &host.queries, film, &stats), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_chain_flush(chain, scene, NULL, film, &stats), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(flush(none, film), VOLGRAD_ERROR_NOT_INITIALISED);
    CHECK_STATUS(flush((void *)(zeros + 8), film), VOLGRAD_ERROR_MISALIGNED);
    CHECK_STATUS(flush(chain, four), VOLGRAD_ERROR_SIZE_MISMATCH);
    CHECK(memcmp(block[0], block[1], BYTES) == 0 && memcmp(memory[0], memory[1], CHAIN_BYTES) == 0);
    /* A chain whose burn-in was stopped is none. */
    queries_answer(&host, SLAB, 20, STOPS);
    REFUSED(chain, init(0, starts, NULL, &chain), VOLGRAD_ERROR_CALLBACK);
    queries_answer(&host, SLAB, 0, SLAB);
    CHECK_STATUS(run((void *)memory[0], 9, film, NULL), VOLGRAD_ERROR_NOT_INITIALISED);
    CHECK_STATUS(flush((void *)memory[0], film), VOLGRAD_ERROR_NOT_INITIALISED);
}

/* A chain and a scene, or a start and samples, that do not belong together. */
static void test_strangers(void) {
    prepare();
    volgrad_chain *chain = first_chain(0), *other;
    volgrad_film *film = clear(0);
    volgrad_chain_stats stats = no_stats();
    CHECK_STATUS(run(chain, 9, film, NULL), VOLGRAD_OK);
    memcpy(memory[1], memory[0], CHAIN_BYTES);
    memcpy(block[1], block[0], BYTES);
    options.seed++;
    volgrad_status status = init(2, &starts[0], NULL, &other);
    CHECK(status == VOLGRAD_ERROR_RANGE || status == VOLGRAD_ERROR_OTHER_PATH); /* of another length, or not */
    options.seed--;
    volgrad_chain_start changed = starts[0];
    changed.value *= 1.1;
    REFUSED(other, init(2, &changed, NULL, &other), VOLGRAD_ERROR_OTHER_PATH);
    changed.value = 0;
    REFUSED(other, init(2, &changed, NULL, &other), VOLGRAD_ERROR_RANGE);
    s.media[0].albedo = (volgrad_rgb){0.5f, 0.5f, 0.5f};
    void *darker_memory;
    const volgrad_scene *own = scene;
    scene = scene_make(&s.desc, &darker_memory);
    CHECK_STATUS(run(chain, 9, film, &stats), VOLGRAD_ERROR_OTHER_PATH);
    CHECK_STATUS(flush(chain, film), VOLGRAD_ERROR_OTHER_PATH);
    REFUSED(other, init(2, &starts[0], NULL, &other), VOLGRAD_ERROR_OTHER_PATH);
    free(darker_memory);
    scene = own;
    CHECK(memcmp(memory[0], memory[1], CHAIN_BYTES) == 0 && memcmp(block[0], block[1], BYTES) == 0);
    CHECK(stats.large_steps + stats.small_steps == 0);
    CHECK_STATUS(run(chain, 9, film, &stats), VOLGRAD_OK);
}

/* 300 mutations at once are 100 and 200, from a copy of the chain's memory too. */
static void test_checkpoint(uint32_t mode) {
    prepare();
    set_shift(mode);
    volgrad_chain *whole = first_chain(0), *parts = first_chain(1), *copy = (void *)memory[2];
    volgrad_chain_stats once = no_stats(), twice = no_stats();
    volgrad_film *a = clear(0), *b = clear(1);
    CHECK_STATUS(run(whole, 300, a, &once), VOLGRAD_OK);
    CHECK_STATUS(run(parts, 100, b, &twice), VOLGRAD_OK);
    memcpy(memory[2], memory[1], CHAIN_BYTES);
    CHECK_STATUS(run(parts, 17, b, NULL), VOLGRAD_OK); /* the original goes another way than the copy */
    b = clear(1);
    parts = first_chain(1);
    CHECK_STATUS(run(parts, 100, b, NULL), VOLGRAD_OK);
    CHECK_STATUS(run(copy, 200, b, &twice), VOLGRAD_OK);
    CHECK(memcmp(block[0], block[1], BYTES) == 0);
    CHECK(once.large_steps + once.small_steps == 300 && once.burn_in == 0);
    CHECK(once.large_steps == twice.large_steps && once.small_accepted == twice.small_accepted && once.dark == twice.dark);
    CHECK(once.large_accepted <= once.large_steps && once.small_accepted <= once.small_steps && once.small_accepted > 0);
    CHECK((once.shifted_paths > 0) == (mode != VOLGRAD_SHIFT_NONE));
    CHECK(once.rays > 0 && once.dropped == 0 && once.overflows == 0);
    CHECK_STATUS(run(copy, 0, b, NULL), VOLGRAD_OK);
    CHECK(memcmp(block[0], block[1], BYTES) == 0);
}

static void test_flush(void) {
    prepare();
    volgrad_chain *chain = first_chain(0);
    volgrad_film *film = clear(0);
    volgrad_chain_stats stats = no_stats();
    CHECK_STATUS(run(chain, 50, film, NULL), VOLGRAD_OK);
    memcpy(memory[1], memory[0], CHAIN_BYTES);
    memcpy(block[1], block[0], BYTES);
    CHECK_STATUS(volgrad_chain_flush(chain, scene, &host.queries, film, &stats), VOLGRAD_OK);
    CHECK(stats.rays > 0 && stats.large_steps + stats.small_steps + stats.burn_in + stats.samples == 0);
    CHECK(memcmp(memory[0], memory[1], CHAIN_BYTES) == 0); /* the chain is as it was, */
    CHECK(memcmp(block[0], block[1], BYTES) != 0);         /* the film is not */
    CHECK_STATUS(flush((void *)memory[1], (void *)block[1]), VOLGRAD_OK);
    CHECK(memcmp(block[0], block[1], BYTES) == 0);
}

/* What is peeked at is what happens, and peeking changes nothing. */
static void test_peek(void) {
    prepare();
    volgrad_chain *chain = first_chain(0);
    volgrad_film *film = clear(0);
    volgrad_chain_mutation next = {.struct_size = sizeof next};
    volgrad_vertex current[LONGEST + 1], proposed[LONGEST + 1], before[LONGEST + 1];
    double target = 0;
    uint32_t accepted = 0;
    for (uint64_t i = 0; i < 200; i++) {
        volgrad_chain_stats stats = no_stats();
        memcpy(memory[1], memory[0], CHAIN_BYTES);
        CHECK_STATUS(volgrad_chain_peek(chain, scene, &host.queries, &next, current, proposed, LONGEST + 1), VOLGRAD_OK);
        CHECK(memcmp(memory[0], memory[1], CHAIN_BYTES) == 0);
        CHECK(next.number == i && next.current.vertex_count == starts[0].length + 1 && next.current.target > 0);
        CHECK(next.current.camera_vertices + next.current.light_vertices == next.current.vertex_count);
        CHECK(current[0].kind == VOLGRAD_VERTEX_CAMERA && current[starts[0].length].kind == VOLGRAD_VERTEX_LIGHT);
        CHECK((next.proposed.target > 0) == (next.proposed.vertex_count > 0) && (next.accepted == 0 || next.acceptance > 0));
        if (i > 0) {
            CHECK_NEAR(next.current.target, target, 1e-9);
            CHECK(memcmp(before, current, next.current.vertex_count * sizeof *current) == 0);
        }
        target = next.accepted ? next.proposed.target : next.current.target;
        memcpy(before, next.accepted ? proposed : current, sizeof before);
        accepted += next.accepted;
        CHECK_STATUS(run(chain, 1, film, &stats), VOLGRAD_OK);
        CHECK(stats.large_steps == next.large && stats.large_accepted + stats.small_accepted == next.accepted);
    }
    CHECK(accepted > 20 && accepted < 190);
    next.struct_size = 3;
    CHECK_STATUS(volgrad_chain_peek(chain, scene, &host.queries, &next, current, proposed, LONGEST + 1), VOLGRAD_ERROR_STRUCT_SIZE);
    next.struct_size = sizeof next;
    CHECK_STATUS(volgrad_chain_peek(chain, scene, &host.queries, &next, current, proposed, starts[0].length), VOLGRAD_ERROR_TOO_SMALL);
    CHECK_STATUS(volgrad_chain_peek(chain, scene, &host.queries, &next, NULL, proposed, LONGEST + 1), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_chain_peek(chain, scene, &host.queries, NULL, current, proposed, LONGEST + 1), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_chain_peek(NULL, scene, &host.queries, &next, current, proposed, LONGEST + 1), VOLGRAD_ERROR_NULL);
}

/* Stopped anywhere, chain and film agree: the rest of the mutations makes the same film as an uninterrupted run. */
static void test_callbacks(uint32_t mode) {
    prepare();
    set_shift(mode);
    options.shift_every = 2;
    volgrad_film *whole = clear(0);
    volgrad_chain *chain = first_chain(0);
    CHECK_STATUS(run(chain, 60, whole, NULL), VOLGRAD_OK);
    CHECK_STATUS(flush(chain, whole), VOLGRAD_OK);
    uint64_t least = 60, most = 0;
    for (uint32_t calls = 1; calls < 200; calls++) {
        volgrad_chain_stats stats = no_stats();
        volgrad_film *film = clear(1);
        chain = first_chain(1);
        queries_answer(&host, SLAB, calls, calls % 2 ? STOPS : END_NAN);
        volgrad_status status = run(chain, 60, film, &stats);
        uint64_t done = stats.large_steps + stats.small_steps;
        if (status == VOLGRAD_OK) {
            CHECK(done == 60);
        } else {
            CHECK_STATUS(status, answer_status(calls % 2 ? STOPS : END_NAN));
            CHECK(done < 60);
            least = done < least ? done : least;
            most = done > most ? done : most;
        }
        queries_answer(&host, SLAB, 0, SLAB);
        CHECK_STATUS(run(chain, 60 - done, film, &stats), VOLGRAD_OK);
        CHECK(stats.large_steps + stats.small_steps == 60);
        CHECK_STATUS(flush(chain, film), VOLGRAD_OK);
        CHECK(memcmp(block[0], block[1], BYTES) == 0);
    }
    CHECK(least == 0 && most > 10); /* so that the test says something */
}

/* ---- all chains ---- */

/* Mean of the film, with `seed`, of all chains with `each` mutations. */
static double mean_of_chains(uint64_t seed, uint64_t each) {
    options.seed = seed;
    learn_techniques();
    CHECK_STATUS(bootstrap(0, SAMPLES, weights), VOLGRAD_OK);
    CHECK_STATUS(make_plan(starts), VOLGRAD_OK);
    volgrad_film *film = clear(0);
    for (uint32_t i = 0; i < plan.chain_count; i++) {
        volgrad_chain *chain;
        volgrad_chain_stats stats = no_stats();
        CHECK_STATUS(init(0, &starts[i], &stats, &chain), VOLGRAD_OK);
        CHECK(stats.burn_in == BURN_IN && stats.large_steps == 0);
        CHECK_STATUS(run(chain, each, film, NULL), VOLGRAD_OK);
        CHECK_STATUS(flush(chain, film), VOLGRAD_OK);
    }
    CHECK_STATUS(volgrad_film_develop(film, (double)PIXELS / ((double)plan.chain_count * (double)each), rgb, FLOATS), VOLGRAD_OK);
    double mean = 0;
    for (int i = 1; i < FLOATS; i += 3) mean += rgb[i] / (double)PIXELS;
    return mean;
}

/* What chains render and a path sampler that leaves it out are together what one that does not renders. Fails for one in 10^4 seeds or so
   (two-sided, 4.5 standard errors that 24 seeds tell); the seeds are fixed. */
static void test_mean(uint32_t mode) {
    enum { SEEDS = 24 };
    volgrad_path_sampler_options path;
    double sum = 0, squares = 0;
    make_scene();
    options.shift.mode = mode;
    for (uint64_t seed = 0; seed < SEEDS; seed++) {
        double difference = mean_of_chains(seed, 200);
        for (int left_out = 0; left_out < 2; left_out++) {
            CHECK_STATUS(volgrad_path_sampler_options_default(&path, sizeof path), VOLGRAD_OK);
            path.max_depth = LONGEST + 2;
            path.seed = seed;
            path.left_out_first = left_out ? SHORTEST : 0;
            path.left_out_last = left_out ? LONGEST : 0;
            volgrad_film *film = clear(1);
            CHECK_STATUS(volgrad_path_sampler_run(scene, &host.queries, &path, 0, 0, PIXELS, film, NULL), VOLGRAD_OK);
            CHECK_STATUS(volgrad_film_develop(film, 1, rgb, FLOATS), VOLGRAD_OK);
            for (int i = 1; i < FLOATS; i += 3) difference += (left_out ? 1 : -1) * rgb[i] / (double)PIXELS;
        }
        sum += difference;
        squares += difference * difference;
    }
    double mean = sum / SEEDS, error = sqrt((squares / SEEDS - mean * mean) / (SEEDS - 1));
    CHECK_NEAR(mean, 0, 4.5 * error);
    CHECK(error > 0 && error < 0.01 * plan.brightness);
}

int main(void) {
    test_options();
    test_bootstrap();
    test_bootstrap_stats();
    test_learn();
    test_plan();
    test_memory();
    test_refusals();
    test_strangers();
    test_checkpoint(VOLGRAD_SHIFT_NONE);
    test_checkpoint(VOLGRAD_SHIFT_EXCHANGEABLE);
    test_checkpoint(VOLGRAD_SHIFT_THESIS);
    test_flush();
    test_peek();
    test_callbacks(VOLGRAD_SHIFT_NONE);
    test_callbacks(VOLGRAD_SHIFT_EXCHANGEABLE);
    test_callbacks(VOLGRAD_SHIFT_THESIS_PRINTED);
    test_mean(VOLGRAD_SHIFT_NONE);
    test_mean(VOLGRAD_SHIFT_EXCHANGEABLE);
    free(scene_memory);
    return check_end();
}
