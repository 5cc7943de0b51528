/* Shifts of any sampler's paths. */

#include "open_queries.h"

enum { CAPACITY = VOLGRAD_MAX_SHIFTS + 1 };

static const volgrad_scene *scene;
static const volgrad_queries *queries;
static volgrad_vertex vertices[4];
static volgrad_segment segments[3];
static uint32_t ends[3];
static volgrad_path path;
static volgrad_shift_options options;
static const volgrad_rgb weight = {2, 2, 2};
static volgrad_splat splats[CAPACITY];
static uint32_t count;

/* Camera, fog, point light; exchangeable shifts by 1/10. */
static void fill(void) {
    memset(vertices, 0, sizeof vertices);
    memset(segments, 0, sizeof segments);
    vertices[1].kind = VOLGRAD_VERTEX_MEDIUM, vertices[1].position = vec(0.1f, 0, 3);
    vertices[2].kind = VOLGRAD_VERTEX_LIGHT, vertices[2].position = vec(0, 2, 3), vertices[2].index = POINT_LIGHT;
    for (int i = 0; i < 3; i++) {
        segments[i].end = 4;
        ends[i] = (uint32_t)i + 1;
    }
    path = (volgrad_path){vertices, segments, ends, 3, 2};
    CHECK_STATUS(volgrad_shift_options_default(&options, sizeof options), VOLGRAD_OK);
    options.mode = VOLGRAD_SHIFT_EXCHANGEABLE;
    options.kernel = VOLGRAD_KERNEL_BALL, options.radius_unit = VOLGRAD_RADIUS_WORLD, options.radius = 0.1f;
}

static volgrad_status shift(volgrad_rgb c, uint32_t capacity) {
    return volgrad_shift_path(scene, queries, &options, &path, c, 1, 2, splats, capacity, &count);
}

/* The current path and options must be refused; then resets them. */
static void refuse(volgrad_status status, volgrad_rgb c, uint32_t capacity, const char *what, int line) {
    FILL(splats), FILL(count);
    check_status(shift(c, capacity), status, what, __FILE__, line);
    check_that(UNTOUCHED(splats) && UNTOUCHED(count), what, __FILE__, line);
    fill();
}

#define BAD(set, status) ((set), refuse((status), weight, CAPACITY, #set, __LINE__))

static float luminance(volgrad_rgb c) {
    return 0.2126f * c.r + 0.7152f * c.g + 0.0722f * c.b;
}

static void test_defaults(void) {
    struct {
        volgrad_shift_options options;
        unsigned char tail[16];
    } larger;
    volgrad_shift_options o;
    CHECK_STATUS(volgrad_shift_options_default(&o, sizeof o), VOLGRAD_OK);
    CHECK(o.struct_size == sizeof o && o.mode == VOLGRAD_SHIFT_NONE && o.kernel == VOLGRAD_KERNEL_TILE);
    CHECK(o.radius_unit == VOLGRAD_RADIUS_PIXELS && o.radius == 4 && o.count == 8);
    CHECK(o.run == 2 && o.exact_count == 1 && o.alpha == 1 && o.clamp == 0);
    FILL(larger);
    CHECK_STATUS(volgrad_shift_options_default(&larger.options, sizeof larger - 4), VOLGRAD_OK);
    CHECK(larger.options.struct_size == sizeof larger - 4 && larger.options.count == 8);
    for (int i = 0; i < 16; i++) CHECK(larger.tail[i] == (i < 12 ? 0 : 0xA5));
    FILL(o);
    CHECK_STATUS(volgrad_shift_options_default(&o, offsetof(volgrad_shift_options, radius)), VOLGRAD_OK);
    CHECK(o.struct_size == offsetof(volgrad_shift_options, radius) && UNTOUCHED(o.radius) && UNTOUCHED(o.count));
    REFUSED(o, volgrad_shift_options_default(&o, 0), VOLGRAD_ERROR_STRUCT_SIZE);
    REFUSED(o, volgrad_shift_options_default(&o, 3), VOLGRAD_ERROR_STRUCT_SIZE);
    REFUSED(o, volgrad_shift_options_default(&o, SIZE_MAX), VOLGRAD_ERROR_STRUCT_SIZE);
    CHECK_STATUS(volgrad_shift_options_default(NULL, sizeof o), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_shift_options_default((void *)(larger.tail + 1), sizeof o), VOLGRAD_ERROR_MISALIGNED);
}

static void test_options(void) {
    BAD(options.mode = VOLGRAD_SHIFT_THESIS, VOLGRAD_ERROR_KIND); /* of chains */
    BAD(options.mode = VOLGRAD_SHIFT_THESIS_PRINTED, VOLGRAD_ERROR_KIND);
    BAD(options.mode = 10, VOLGRAD_ERROR_KIND);
    BAD(options.kernel = 3, VOLGRAD_ERROR_KIND);
    BAD(options.radius_unit = 2, VOLGRAD_ERROR_KIND);
    BAD(options.radius_unit = VOLGRAD_RADIUS_PIXELS, VOLGRAD_ERROR_KIND); /* of a ball */
    BAD(options.radius = 0, VOLGRAD_ERROR_RANGE);
    BAD(options.radius = -1, VOLGRAD_ERROR_RANGE);
    BAD(options.radius = NAN, VOLGRAD_ERROR_NOT_FINITE);
    BAD(options.radius = INFINITY, VOLGRAD_ERROR_NOT_FINITE);
    BAD(options.count = 0, VOLGRAD_ERROR_RANGE);
    BAD(options.count = VOLGRAD_MAX_SHIFTS + 1, VOLGRAD_ERROR_RANGE);
    BAD(options.run = 0, VOLGRAD_ERROR_RANGE);
    BAD(options.run = VOLGRAD_MAX_RUN + 1, VOLGRAD_ERROR_RANGE);
    BAD(options.exact_count = 0, VOLGRAD_ERROR_RANGE);
    BAD(options.exact_count = options.count + 1, VOLGRAD_ERROR_RANGE);
    BAD(options.alpha = -0.1f, VOLGRAD_ERROR_RANGE);
    BAD(options.alpha = 1.1f, VOLGRAD_ERROR_RANGE);
    BAD(options.alpha = NAN, VOLGRAD_ERROR_NOT_FINITE);
    BAD(options.clamp = -1, VOLGRAD_ERROR_RANGE);
    BAD(options.clamp = INFINITY, VOLGRAD_ERROR_NOT_FINITE);
    for (uint32_t n = 1; n <= VOLGRAD_MAX_SHIFTS; n++) {
        int square = n == 3 || n == 8 || n == 15 || n == 24 || n == 35;
        options.kernel = VOLGRAD_KERNEL_TILE, options.count = n, options.radius = 0; /* unused */
        if (square) {
            CHECK_STATUS(shift(weight, CAPACITY), VOLGRAD_OK);
            CHECK(count <= n + 1 && count > n / 4);
            fill();
        } else {
            BAD((void)0, VOLGRAD_ERROR_RANGE);
        }
    }
    BAD(options.struct_size = 0, VOLGRAD_ERROR_STRUCT_SIZE);
    BAD(options.struct_size = 5000, VOLGRAD_ERROR_STRUCT_SIZE);
    const volgrad_rgb bad[] = {{NAN, 1, 1}, {1, INFINITY, 1}, {1, 1, -INFINITY}};
    for (int i = 0; i < 3; i++) refuse(VOLGRAD_ERROR_NOT_FINITE, bad[i], CAPACITY, "weight", __LINE__);
    refuse(VOLGRAD_ERROR_TOO_SMALL, weight, 8, "capacity 8", __LINE__);
    refuse(VOLGRAD_ERROR_TOO_SMALL, weight, 0, "capacity 0", __LINE__);

    /* Smaller options have defaults for the rest. */
    options.struct_size = offsetof(volgrad_shift_options, count), options.count = 0;
    CHECK_STATUS(shift(weight, CAPACITY), VOLGRAD_OK);
    CHECK(count == 9);
    fill();
    options.struct_size = offsetof(volgrad_shift_options, run); /* as it once was */
    options.run = options.exact_count = 0, options.alpha = options.clamp = NAN;
    CHECK_STATUS(shift(weight, CAPACITY), VOLGRAD_OK);
    CHECK(count == 9);
    volgrad_splat shorter[CAPACITY];
    memcpy(shorter, splats, sizeof shorter);
    fill();
    CHECK_STATUS(shift(weight, CAPACITY), VOLGRAD_OK);
    CHECK(memcmp(shorter, splats, count * sizeof *splats) == 0);
}

/* |W| is at most clamp; without it some are larger. */
static void test_clamp(void) {
    float largest[2];
    for (int clamped = 0; clamped < 2; clamped++) {
        options.mode = VOLGRAD_SHIFT_FIRST_ORDER, options.radius = 1.5f, options.count = 32;
        options.clamp = clamped ? 1.25f : 0;
        CHECK_STATUS(shift(weight, CAPACITY), VOLGRAD_OK);
        largest[clamped] = 0;
        for (uint32_t i = 0; i + 1 < count; i++) {
            float w = fabsf(splats[i].value.g) * 33 / weight.g;
            if (w > largest[clamped]) largest[clamped] = w;
        }
    }
    CHECK(largest[0] > 1.3f);
    CHECK_NEAR(largest[1], 1.25f, 1e-5);
    fill();
}

/* Of a run two vertices move, where the options say so: then the weights are others. */
static void test_runs(void) {
    volgrad_rgb sums[2];
    for (uint32_t run = 1; run <= 2; run++) {
        vertices[3] = vertices[2];
        vertices[2] = vertices[1];
        vertices[2].position = vec(0.3f, 0.5f, 3.5f);
        path.vertex_count = 4, path.segment_count = 3;
        options.mode = VOLGRAD_SHIFT_EXACT, options.radius = 0.3f, options.run = run;
        CHECK_STATUS(shift(weight, CAPACITY), VOLGRAD_OK);
        CHECK(count == 9);
        sums[run - 1] = splats[0].value;
        fill();
    }
    CHECK(sums[0].g > 0 && sums[1].g > 0 && sums[0].g != sums[1].g);
}

static void test_pointers_and_paths(void) {
    static alignas(16) const unsigned char zeros[1 << 12];
    const volgrad_scene *good = scene;
    BAD(scene = NULL, VOLGRAD_ERROR_NULL);
    BAD(scene = (const void *)(zeros + 1), VOLGRAD_ERROR_MISALIGNED);
    BAD(scene = (const void *)zeros, VOLGRAD_ERROR_NOT_INITIALISED);
    scene = good;
    FILL(splats), FILL(count);
    CHECK_STATUS(volgrad_shift_path(scene, queries, NULL, &path, weight, 1, 2, splats, CAPACITY, &count), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_shift_path(scene, queries, &options, NULL, weight, 1, 2, splats, CAPACITY, &count), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_shift_path(scene, queries, &options, &path, weight, 1, 2, NULL, CAPACITY, &count), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_shift_path(scene, queries, &options, &path, weight, 1, 2, splats, CAPACITY, NULL), VOLGRAD_ERROR_NULL);
    CHECK(UNTOUCHED(splats) && UNTOUCHED(count));

    open_queries broken;
    const volgrad_queries *before = queries;
    BAD(queries = NULL, VOLGRAD_ERROR_NULL);
    BAD((options.mode = VOLGRAD_SHIFT_EXACT, queries = NULL), VOLGRAD_ERROR_NULL);
    queries = queries_answer(&broken, FOG, 0, FOG);
    BAD(broken.queries.occluded = NULL, VOLGRAD_ERROR_NULL);
    BAD(broken.queries.struct_size = 3, VOLGRAD_ERROR_STRUCT_SIZE);
    queries = NULL;
    options.mode = VOLGRAD_SHIFT_LOG_LINEAR;
    CHECK_STATUS(shift(weight, CAPACITY), VOLGRAD_OK);
    queries = before;
    fill();

    for (uint32_t mode = VOLGRAD_SHIFT_NONE; mode <= VOLGRAD_SHIFT_TWO_LEVEL; mode++) {
        BAD((options.mode = mode, path.vertex_count = 1), VOLGRAD_ERROR_RANGE);
        BAD((options.mode = mode, path.vertices = NULL), VOLGRAD_ERROR_NULL);
        BAD((options.mode = mode, vertices[1].kind = 9), VOLGRAD_ERROR_KIND);
        BAD((options.mode = mode, vertices[2].index = LIGHTS), VOLGRAD_ERROR_INDEX);
    }
    BAD(ends[0] = 9, VOLGRAD_ERROR_SEGMENTS);
}

/* Whether the first answer breaks the rules or the second, about another edge. */
static void test_callbacks(void) {
    open_queries answers;
    const volgrad_queries *before = queries;
    for (uint32_t i = 0; i < 4 * ANSWERS; i++) {
        uint32_t good = i & 1, mode = i & 2 ? VOLGRAD_SHIFT_EXACT : VOLGRAD_SHIFT_EXCHANGEABLE;
        int answer = (int)(i / 4);
        if (answer < STOPS || answer > KIND_BEYOND) continue; /* no rule, or one for surfaces, which an occlusion query may find */
        char what[64];
        snprintf(what, sizeof what, "callback: answer %d, mode %u, call %u", answer, (unsigned)mode, (unsigned)good);
        queries = queries_answer(&answers, FOG, good, (enum answer)answer);
        options.mode = mode;
        refuse(answer_status((enum answer)answer), weight, CAPACITY, what, __LINE__);
    }
    queries = queries_answer(&answers, FOG, 0, OVERFLOWS); /* all are lost but the path itself */
    CHECK_STATUS(shift(weight, CAPACITY), VOLGRAD_OK);
    CHECK_NEAR(splats[count - 1].value.g, weight.g, 1e-5);
    queries = before;
}

static void test_batches(void) {
    volgrad_splat again[CAPACITY];
    for (uint32_t n = 1; n <= VOLGRAD_MAX_SHIFTS; n += 31) {
        for (uint32_t mode = VOLGRAD_SHIFT_LOG_LINEAR; mode <= VOLGRAD_SHIFT_TWO_LEVEL; mode++) {
            options.mode = mode, options.count = n;
            CHECK_STATUS(shift(weight, CAPACITY), VOLGRAD_OK);
            CHECK(count == n + 1);
            float sum = 0;
            for (uint32_t i = 0; i < count; i++) sum += luminance(splats[i].value);
            CHECK_NEAR(sum, luminance(weight), mode == VOLGRAD_SHIFT_EXCHANGEABLE ? 1e-4 : 1);
            memcpy(again, splats, sizeof again);
            CHECK_STATUS(shift(weight, count), VOLGRAD_OK);
            CHECK(memcmp(again, splats, count * sizeof *splats) == 0);
        }
    }
    fill();
    vertices[1].position = vec(0, 0, -3); /* nothing there to shift */
    vertices[2].position = vec(0, 0, -5);
    BAD((void)0, VOLGRAD_ERROR_ZERO_CONTRIBUTION);

    /* One splat at its own pixel: without a mode; for a path that begins on a surface, in some; that sees a light directly. */
    const volgrad_rgb negative = {-1, 0, 2};
    options.mode = VOLGRAD_SHIFT_NONE, options.count = 0, options.kernel = 99;
    CHECK_STATUS(shift(negative, 1), VOLGRAD_OK);
    CHECK(count == 1 && memcmp(&splats[0].value, &negative, sizeof negative) == 0);
    CHECK_NEAR(splats[0].x, 32 + 32 * 0.1 / 3, 1e-4);
    CHECK_NEAR(splats[0].y, 32, 1e-4);
    fill();
    vertices[1].kind = VOLGRAD_VERTEX_SURFACE, vertices[1].index = DIFFUSE, vertices[1].normal = vec(0, 0.6f, -0.8f);
    options.mode = VOLGRAD_SHIFT_LOG_LINEAR; /* moves no surfaces */
    CHECK_STATUS(shift(weight, 1), VOLGRAD_OK);
    CHECK(count == 1);
    CHECK_NEAR(splats[0].value.g, weight.g, 1e-5);
    options.mode = VOLGRAD_SHIFT_EXCHANGEABLE; /* would, but no other image point shows one */
    CHECK_STATUS(shift(weight, CAPACITY), VOLGRAD_OK);
    float total = 0;
    for (uint32_t i = 0; i < count; i++) total += luminance(splats[i].value);
    CHECK_NEAR(total, luminance(weight), 1e-4);
    vertices[1].normal = vec(0, -0.6f, -0.8f); /* turned away from the light: the weight is the caller's, and stays */
    CHECK_STATUS(shift(weight, 1), VOLGRAD_OK);
    CHECK(count == 1 && memcmp(&splats[0].value, &weight, sizeof weight) == 0);
    fill();
    vertices[3] = vertices[2];
    vertices[2].kind = VOLGRAD_VERTEX_SURFACE, vertices[2].index = MIRROR, vertices[2].normal = vec(0, -1, 0);
    vertices[3].position = vec(0.5f, 0, 3);
    path.vertex_count = 4, path.segment_count = 3;
    CHECK_STATUS(shift(weight, 1), VOLGRAD_OK);
    CHECK(count == 1 && splats[0].value.g == weight.g);
    fill();
}

/* Seen directly, light at infinity is seen where its direction points, wherever the camera is. */
static void test_direct_light(small_scene *s) {
    void *memory;
    const volgrad_scene *before = scene;
    s->desc.camera.position = vec(10, 20, -5);
    scene = scene_make(&s->desc, &memory);
    vertices[1] = vertices[2];
    vertices[1].index = SKY, vertices[1].position = vec(0.6f, 0, 0.8f);
    path.vertex_count = 2, path.segment_count = 1, segments[0].end = INFINITY;
    CHECK_STATUS(shift(weight, 1), VOLGRAD_OK);
    CHECK(count == 1);
    CHECK_NEAR(splats[0].x, 32 + 32 * 0.75, 1e-3);
    CHECK_NEAR(splats[0].y, 32, 1e-3);
    scene = before;
    free(memory);
    fill();
}

/* Two contributions of one sample: one batch, the sum of what each would be. In another order with another path between, the same, apart. */
static void test_paths(void) {
    volgrad_vertex others[4] = {vertices[0], vertices[1], vertices[1], vertices[2]};
    others[2].position = vec(0.5f, 0.2f, 4);
    const volgrad_path longer = {others, segments, ends, 4, 3};
    const volgrad_path both[3] = {path, longer, path};
    const volgrad_rgb weights[3] = {{1, 2, 3}, {4, 2, 1}, {0, 0, 0}};
    static volgrad_splat together[3 * CAPACITY], alone[2][CAPACITY];
    uint32_t counts[2], of_both;
    options.kernel = VOLGRAD_KERNEL_TILE, options.run = 1;
    for (int i = 0; i < 2; i++) {
        CHECK_STATUS(volgrad_shift_path(scene, queries, &options, &both[i], weights[i], 1, 2, alone[i], CAPACITY, &counts[i]), VOLGRAD_OK);
    }
    CHECK_STATUS(volgrad_shift_paths(scene, queries, &options, both, weights, 2, 1, 2, together, 18, &of_both), VOLGRAD_OK);
    CHECK(counts[0] == 9 && counts[1] == 9 && of_both == 9);
    for (uint32_t i = 0; i < 9; i++) {
        CHECK_NEAR(together[i].x, alone[0][i].x, 1e-3);
        CHECK_NEAR(together[i].value.g, alone[0][i].value.g + alone[1][i].value.g, 1e-5);
    }
    FILL(of_both);
    CHECK_STATUS(volgrad_shift_paths(scene, queries, &options, both, weights, 2, 1, 2, together, 17, &of_both), VOLGRAD_ERROR_TOO_SMALL);
    CHECK_STATUS(volgrad_shift_paths(scene, queries, &options, NULL, weights, 2, 1, 2, together, 18, &of_both), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_shift_paths(scene, queries, &options, both, NULL, 2, 1, 2, together, 18, &of_both), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_shift_paths(scene, queries, &options, both, weights, 2, 1, 2, NULL, 18, &of_both), VOLGRAD_ERROR_NULL);
    CHECK(UNTOUCHED(of_both));
    CHECK_STATUS(volgrad_shift_paths(scene, queries, &options, NULL, NULL, 0, 1, 2, NULL, 0, &of_both), VOLGRAD_OK);
    CHECK(of_both == 0);
    CHECK_STATUS(volgrad_shift_paths(scene, queries, &options, both, weights, 3, 1, 2, together, 27, &of_both), VOLGRAD_OK);
    CHECK(of_both == 10); /* one that carries nothing stays at its pixel */
    fill();
}

/* Tiles cover the image, and a path's splats are in its tile. */
static void test_tiles(void) {
    uint32_t tile[4], area = 0;
    options.kernel = VOLGRAD_KERNEL_TILE;
    for (uint32_t y = 0; y < SIDE; y = tile[3]) {
        for (uint32_t x = 0; x < SIDE; x = tile[2]) {
            CHECK_STATUS(volgrad_shift_tile(scene, &options, 1, x, y, tile), VOLGRAD_OK);
            CHECK(tile[0] == x && tile[1] == y && tile[2] <= x + 3 && tile[3] <= y + 3);
            area += (tile[2] - x) * (tile[3] - y);
        }
    }
    CHECK(area == SIDE * SIDE);
    CHECK_STATUS(shift(weight, CAPACITY), VOLGRAD_OK);
    CHECK_STATUS(volgrad_shift_tile(scene, &options, 1, (uint32_t)splats[0].x, (uint32_t)splats[0].y, tile), VOLGRAD_OK);
    for (uint32_t i = 0; i < count; i++) {
        CHECK(splats[i].x >= (float)tile[0] && splats[i].x < (float)tile[2] && splats[i].y >= (float)tile[1] && splats[i].y < (float)tile[3]);
    }
    FILL(tile);
    CHECK_STATUS(volgrad_shift_tile(scene, &options, 1, SIDE, 0, tile), VOLGRAD_ERROR_RANGE);
    CHECK_STATUS(volgrad_shift_tile(scene, &options, 1, 0, SIDE, tile), VOLGRAD_ERROR_RANGE);
    CHECK_STATUS(volgrad_shift_tile(scene, &options, 1, 0, 0, NULL), VOLGRAD_ERROR_NULL);
    fill();
    CHECK_STATUS(volgrad_shift_tile(scene, &options, 1, 0, 0, tile), VOLGRAD_ERROR_KIND);
    CHECK(UNTOUCHED(tile));
}

int main(void) {
    small_scene s;
    open_queries fog;
    void *memory;
    scene = scene_make(small_scene_fill(&s), &memory);
    queries = queries_answer(&fog, FOG, 0, FOG);
    fill();
    test_defaults();
    test_batches();
    test_options();
    test_clamp();
    test_runs();
    test_pointers_and_paths();
    test_callbacks();
    test_direct_light(&s);
    test_paths();
    test_tiles();
    free(memory);
    return check_end();
}
