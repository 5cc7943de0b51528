/* Programs of other versions of the header: their option structs end earlier, wherever that is, or later. What they have counts, over the
 * defaults of the rest; nothing behind their end is read or written, which the address sanitizer sees. */

#include "open_queries.h"

enum { PIXELS = 40, BYTES = 48 * SIDE * SIDE + 64, LARGEST = 256, SAMPLES = 50 };

static small_scene s;
static const volgrad_scene *scene;
static open_queries host;
static volgrad_segment segments[2] = {{4, 0, {0, 0, 0}}, {4, 0, {0, 0, 0}}};

/* What a call made: 0, but for what it wrote. */
static alignas(16) unsigned char made[BYTES], expected[BYTES];

static volgrad_film *new_film(void) {
    volgrad_film *film = NULL;
    CHECK_STATUS(volgrad_film_init(made, BYTES, SIDE, SIDE, &film), VOLGRAD_OK);
    return film;
}

static volgrad_status use_path_sampler(const void *options) {
    return volgrad_path_sampler_run(scene, &host.queries, options, 1, 1000, PIXELS, new_film(), NULL);
}

static volgrad_status use_bidirectional(const void *options) {
    return volgrad_bidirectional_run(scene, &host.queries, options, 1, 1000, PIXELS, new_film(), NULL);
}

static volgrad_status use_chain(const void *options) {
    size_t bytes;
    volgrad_status status = volgrad_chain_size(options, &bytes);
    if (status != VOLGRAD_OK) return status;
    memcpy(made, &bytes, sizeof bytes);
    return volgrad_chain_bootstrap(scene, &host.queries, options, NULL, 0, SAMPLES, (float *)(made + 16), NULL);
}

static volgrad_status use_shift(const void *options) {
    volgrad_vertex vertices[3] = {{.kind = VOLGRAD_VERTEX_CAMERA},
                                  {.kind = VOLGRAD_VERTEX_MEDIUM, .position = {0.1f, 0, 3}},
                                  {.kind = VOLGRAD_VERTEX_LIGHT, .position = {0, 2, 3}, .index = POINT_LIGHT}};
    uint32_t ends[2] = {1, 2}, count;
    volgrad_path path = {vertices, segments, ends, 3, 2};
    return volgrad_shift_path(scene, &host.queries, options, &path, WHITE, 1, 2, (volgrad_splat *)made, VOLGRAD_MAX_SHIFTS + 1, &count);
}

static volgrad_status use_transmittance(const void *options) {
    volgrad_line line = {{0, 0, 0}, {0, 0, 1}, 4, 1, segments};
    return volgrad_line_transmittance_estimate(scene, &line, options, 1, 2, (volgrad_transmittance_estimate *)made);
}

/* An option struct. */
typedef struct kind {
    const char *name;
    /* A call that reads it. */
    volgrad_status (*use)(const void *options);
    size_t size;
    /* All fields other than the defaults. */
    const void *custom;
    void *defaults;
} kind;

static int used(const kind *k, const void *options) {
    memset(made, 0, sizeof made);
    return k->use(options);
}

static void test_sizes(const kind *k) {
    static const unsigned char nothing[BYTES];
    int accepted = 0;
    unsigned char whole[LARGEST];
    check_that(used(k, k->custom) == VOLGRAD_OK && memcmp(made, nothing, BYTES) != 0, k->name, __FILE__, __LINE__);
    for (size_t size = 4; size <= k->size + 64; size += 4) {
        size_t known = size < k->size ? size : k->size;
        /* The same as a whole struct of this version. */
        memcpy(whole, k->defaults, k->size);
        memcpy(whole + 4, (const char *)k->custom + 4, known - 4);
        int status = used(k, whole);
        memcpy(expected, made, BYTES);
        /* On the heap, so that an access behind its end is noticed. */
        unsigned char *theirs = calloc(1, size);
        memcpy(theirs, k->custom, known);
        uint32_t declared = (uint32_t)size;
        memcpy(theirs, &declared, sizeof declared);
        int same = used(k, theirs) == status && memcmp(made, expected, BYTES) == 0;
        check_that(same, k->name, __FILE__, __LINE__);
        if (!same) fprintf(stderr, "  of %u bytes\n", declared);
        accepted += status == VOLGRAD_OK;
        if (size > k->size) {
            theirs[size - 1] = 1; /* set, and not known here */
            check_that(used(k, theirs) == VOLGRAD_ERROR_STRUCT_SIZE, k->name, __FILE__, __LINE__);
        }
        free(theirs);
    }
    /* Nearly all of these are settings that exist; and they are not without effect. */
    check_that(accepted * 4 >= (int)(k->size / 4 + 16) * 3, k->name, __FILE__, __LINE__);
    used(k, k->defaults);
    memcpy(expected, made, BYTES);
    used(k, k->custom);
    check_that(memcmp(made, expected, BYTES) != 0, k->name, __FILE__, __LINE__);
}

/* The _default functions write as many bytes as they are told there are. */
#define TEST_DEFAULTS(type) \
    do { \
        type whole; \
        CHECK_STATUS(type##_default(&whole, sizeof whole), VOLGRAD_OK); \
        for (size_t size = 4; size <= sizeof whole + 64; size += 4) { \
            unsigned char *theirs = malloc(size); \
            memset(theirs, 0xA5, size); \
            CHECK_STATUS(type##_default((type *)theirs, size), VOLGRAD_OK); \
            uint32_t declared; \
            memcpy(&declared, theirs, sizeof declared); \
            CHECK(declared == size); \
            size_t known = size < sizeof whole ? size : sizeof whole; \
            CHECK(memcmp(theirs + 4, (unsigned char *)&whole + 4, known - 4) == 0); \
            for (size_t i = known; i < size; i++) CHECK(theirs[i] == 0); \
            free(theirs); \
        } \
    } while (0)

/* Counts come back into structs of any size: what there is room for. */
static void test_stats(size_t size, const void *options, int bootstrap) {
    union {
        volgrad_path_sampler_stats sampler;
        volgrad_chain_stats chain;
    } whole;
    static float weights[SAMPLES];
    for (size_t their_size = size; their_size >= 4; their_size -= 4) {
        unsigned char *theirs = calloc(1, their_size);
        uint32_t declared = (uint32_t)their_size;
        memcpy(theirs, &declared, sizeof declared);
        const volgrad_queries *queries = &host.queries;
        void *stats = theirs;
        volgrad_status status = bootstrap ? volgrad_chain_bootstrap(scene, queries, options, NULL, 0, SAMPLES, weights, stats)
                                          : volgrad_path_sampler_run(scene, queries, options, 1, 1000, PIXELS, new_film(), stats);
        CHECK_STATUS(status, VOLGRAD_OK);
        if (their_size == size) memcpy(&whole, theirs, size);
        CHECK(memcmp(theirs, &declared, 4) == 0 && memcmp(theirs + 4, (unsigned char *)&whole + 4, their_size - 4) == 0);
        free(theirs);
    }
    CHECK(bootstrap ? whole.chain.samples == SAMPLES && whole.chain.rays > 0 : whole.sampler.paths == PIXELS && whole.sampler.shifts > 0);
}

int main(void) {
    void *memory;
    small_scene_fill(&s);
    scene = scene_make(&s.desc, &memory);
    queries_answer(&host, FOG, 0, FOG);

    volgrad_shift_options shift, shift_custom;
    CHECK_STATUS(volgrad_shift_options_default(&shift, sizeof shift), VOLGRAD_OK);
    shift_custom = (volgrad_shift_options){
        sizeof shift, VOLGRAD_SHIFT_TWO_LEVEL, VOLGRAD_KERNEL_BALL, VOLGRAD_RADIUS_WORLD, 0.1f, 9, 1, 2, 0.5f, 3};

    volgrad_path_sampler_options path, path_custom;
    CHECK_STATUS(volgrad_path_sampler_options_default(&path, sizeof path), VOLGRAD_OK);
    path_custom = (volgrad_path_sampler_options){sizeof path, 7, 3, 5, 11, shift_custom, 3, 4};

    volgrad_bidirectional_options both, both_custom;
    CHECK_STATUS(volgrad_bidirectional_options_default(&both, sizeof both), VOLGRAD_OK);
    both_custom = (volgrad_bidirectional_options){sizeof both, 6, 3, VOLGRAD_HEURISTIC_POWER, 11, 2, 0.5f, shift_custom};

    volgrad_chain_options chain, chain_custom;
    CHECK_STATUS(volgrad_chain_options_default(&chain, sizeof chain), VOLGRAD_OK);
    chain_custom = (volgrad_chain_options){sizeof chain, 3, 5, 7, 0.5f, 2, 11, shift_custom};

    volgrad_transmittance_options line, line_custom;
    CHECK_STATUS(volgrad_transmittance_options_default(&line, sizeof line), VOLGRAD_OK);
    line_custom = (volgrad_transmittance_options){sizeof line, VOLGRAD_TRANSMITTANCE_RAY_MARCHING, 3, 0};

    const kind kinds[] = {
        {"volgrad_shift_options", use_shift, sizeof shift, &shift_custom, &shift},
        {"volgrad_path_sampler_options", use_path_sampler, sizeof path, &path_custom, &path},
        {"volgrad_bidirectional_options", use_bidirectional, sizeof both, &both_custom, &both},
        {"volgrad_chain_options", use_chain, sizeof chain, &chain_custom, &chain},
        {"volgrad_transmittance_options", use_transmittance, sizeof line, &line_custom, &line},
    };
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) test_sizes(&kinds[i]);

    TEST_DEFAULTS(volgrad_shift_options);
    TEST_DEFAULTS(volgrad_path_sampler_options);
    TEST_DEFAULTS(volgrad_bidirectional_options);
    TEST_DEFAULTS(volgrad_chain_options);
    TEST_DEFAULTS(volgrad_transmittance_options);

    test_stats(sizeof(volgrad_path_sampler_stats), &path_custom, 0);
    test_stats(sizeof(volgrad_chain_stats), &chain, 1);

    free(memory);
    return check_end();
}
