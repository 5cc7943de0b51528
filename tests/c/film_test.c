/* Films. */

#include <float.h>

#include "check.h"

enum { W = 5, H = 3, FLOATS = 3 * W * H };

static alignas(16) unsigned char block[2][4096];
static volgrad_film *a, *b;
static float rgb[FLOATS], other[FLOATS];

static void make(int which, uint32_t width, uint32_t height) {
    volgrad_film **film = which == 0 ? &a : &b;
    memset(block[which], 0xFF, sizeof block[which]);
    CHECK_STATUS(volgrad_film_init(block[which], sizeof block[which], width, height, film), VOLGRAD_OK);
}

static void add(volgrad_film *film, float x, float y, float r, float g, float blue) {
    const volgrad_splat splat = {x, y, {r, g, blue}};
    CHECK_STATUS(volgrad_film_add(film, &splat, 1), VOLGRAD_OK);
}

static uint64_t dropped(const volgrad_film *film) {
    uint64_t n = 99;
    CHECK_STATUS(volgrad_film_dropped(film, &n), VOLGRAD_OK);
    return n;
}

static const float *develop(const volgrad_film *film, float *to) {
    CHECK_STATUS(volgrad_film_develop(film, 1, to, FLOATS), VOLGRAD_OK);
    return to;
}

static void test_memory(void) {
    size_t bytes = 0, wrong;
    volgrad_film *film;
    CHECK_STATUS(volgrad_film_size(W, H, &bytes), VOLGRAD_OK);
    CHECK(bytes > 48 * W * H && bytes <= 48 * W * H + 64);
    CHECK_STATUS(volgrad_film_size(W, H, NULL), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_film_size(W, H, (void *)(block[0] + 1)), VOLGRAD_ERROR_MISALIGNED);
    const uint32_t sides[][2] = {{0, H}, {W, 0}, {0, 0}, {UINT32_MAX, 1}, {1, UINT32_MAX}, {UINT32_MAX, UINT32_MAX}};
    for (int i = 0; i < 6; i++) {
        REFUSED(wrong, volgrad_film_size(sides[i][0], sides[i][1], &wrong), VOLGRAD_ERROR_RANGE);
        REFUSED(film, volgrad_film_init(block[0], sizeof block[0], sides[i][0], sides[i][1], &film), VOLGRAD_ERROR_RANGE);
    }
    CHECK_STATUS(volgrad_film_init(block[0], bytes, W, H, NULL), VOLGRAD_ERROR_NULL);
    REFUSED(film, volgrad_film_init(NULL, bytes, W, H, &film), VOLGRAD_ERROR_NULL);
    REFUSED(film, volgrad_film_init(block[0] + 8, bytes, W, H, &film), VOLGRAD_ERROR_MISALIGNED);
    REFUSED(film, volgrad_film_init(block[0], bytes - 1, W, H, &film), VOLGRAD_ERROR_TOO_SMALL);
    REFUSED(film, volgrad_film_init(block[0], 0, W, H, &film), VOLGRAD_ERROR_TOO_SMALL);
    FILL(block[0]);
    CHECK_STATUS(volgrad_film_init(block[0], bytes, W, H, &film), VOLGRAD_OK);
    CHECK(untouched(block[0] + bytes, sizeof block[0] - bytes));
    develop(film, rgb);
    for (int i = 0; i < FLOATS; i++) CHECK(rgb[i] == 0);
    CHECK(dropped(film) == 0);
}

static void test_not_a_film(void) {
    const volgrad_splat splat = {0, 0, {1, 1, 1}};
    uint64_t n;
    make(0, W, H);
    for (int pattern = 0; pattern < 256; pattern += 0x5A) {
        memset(block[1], pattern, sizeof block[1]);
        volgrad_film *none = (volgrad_film *)(void *)block[1];
        CHECK_STATUS(volgrad_film_add(none, &splat, 1), VOLGRAD_ERROR_NOT_INITIALISED);
        CHECK_STATUS(volgrad_film_merge(none, a), VOLGRAD_ERROR_NOT_INITIALISED);
        CHECK_STATUS(volgrad_film_merge(a, none), VOLGRAD_ERROR_NOT_INITIALISED);
        REFUSED(rgb, volgrad_film_develop(none, 1, rgb, FLOATS), VOLGRAD_ERROR_NOT_INITIALISED);
        REFUSED(n, volgrad_film_dropped(none, &n), VOLGRAD_ERROR_NOT_INITIALISED);
    }
    volgrad_film *odd = (volgrad_film *)(void *)(block[1] + 8);
    CHECK_STATUS(volgrad_film_add(odd, &splat, 1), VOLGRAD_ERROR_MISALIGNED);
    CHECK_STATUS(volgrad_film_merge(odd, a), VOLGRAD_ERROR_MISALIGNED);
    CHECK_STATUS(volgrad_film_merge(a, odd), VOLGRAD_ERROR_MISALIGNED);
    REFUSED(rgb, volgrad_film_develop(odd, 1, rgb, FLOATS), VOLGRAD_ERROR_MISALIGNED);
    CHECK_STATUS(volgrad_film_add(NULL, &splat, 1), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_film_add(a, NULL, 1), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_film_add(a, NULL, 0), VOLGRAD_OK);
    CHECK_STATUS(volgrad_film_add(a, &splat, SIZE_MAX), VOLGRAD_ERROR_RANGE);
    CHECK_STATUS(volgrad_film_merge(NULL, a), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_film_merge(a, NULL), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_film_merge(NULL, NULL), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_film_dropped(NULL, &n), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_film_dropped(a, NULL), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_film_develop(NULL, 1, rgb, FLOATS), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_film_develop(a, 1, NULL, FLOATS), VOLGRAD_ERROR_NULL);
    REFUSED(rgb, volgrad_film_develop(a, 1, rgb, FLOATS - 1), VOLGRAD_ERROR_TOO_SMALL);
    REFUSED(rgb, volgrad_film_develop(a, 1, rgb, 0), VOLGRAD_ERROR_TOO_SMALL);
    REFUSED(rgb, volgrad_film_develop(a, NAN, rgb, FLOATS), VOLGRAD_ERROR_NOT_FINITE);
    REFUSED(rgb, volgrad_film_develop(a, -INFINITY, rgb, FLOATS), VOLGRAD_ERROR_NOT_FINITE);
    CHECK(dropped(a) == 0);
}

static void test_splats(void) {
    make(0, W, H);
    add(a, 1.25f, 2.75f, 1, -2, 0.5f);
    add(a, 1, 2, 1, 0, 0);
    add(a, nextafterf(2, 0), nextafterf(3, 0), 0, 0, -1);
    develop(a, rgb);
    const float *pixel = rgb + 3 * (2 * W + 1);
    CHECK(pixel[0] == 2 && pixel[1] == -2 && pixel[2] == -0.5f);
    float sum = 0;
    for (int i = 0; i < FLOATS; i++) sum += fabsf(rgb[i]);
    CHECK(sum == 4.5f);
    CHECK_STATUS(volgrad_film_develop(a, -0.25, rgb, FLOATS), VOLGRAD_OK);
    CHECK(pixel[0] == -0.5f && pixel[1] == 0.5f && pixel[2] == 0.125f);

    /* The first and the last pixel, and those just outside. */
    make(0, W, H);
    add(a, 0, 0, 1, 1, 1);
    add(a, nextafterf(W, 0), nextafterf(H, 0), 1, 1, 1);
    CHECK(dropped(a) == 0 && develop(a, rgb)[0] == 1 && rgb[FLOATS - 1] == 1);
    const float bad[] = {NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, 1.0001e9f, -1.0001e9f};
    uint64_t expected = 0;
    for (int i = 0; i < 7; i++) {
        add(a, 0, 0, bad[i], 1, 1);
        add(a, 0, 0, 1, bad[i], 1);
        add(a, 0, 0, 1, 1, bad[i]);
        add(a, bad[i], 0, 1, 1, 1);
        add(a, 0, bad[i], 1, 1, 1);
        CHECK(dropped(a) == (expected += 5));
    }
    add(a, -1e-30f, 0, 1, 1, 1);
    add(a, 0, -1e-30f, 1, 1, 1);
    add(a, W, 0, 1, 1, 1);
    add(a, 0, H, 1, 1, 1);
    CHECK(dropped(a) == expected + 4);
    memset(other, 0, sizeof other);
    other[0] = other[1] = other[2] = other[FLOATS - 1] = other[FLOATS - 2] = other[FLOATS - 3] = 1;
    CHECK(memcmp(develop(a, rgb), other, sizeof rgb) == 0);
    add(a, 2, 0, 0.999e9f, -0.999e9f, FLT_TRUE_MIN);
    CHECK(dropped(a) == expected + 4);
}

/* Numbers of very different sizes, in any order and on any number of films. */
static void test_exact(void) {
    enum { N = 3000 };
    static volgrad_splat splats[N];
    uint32_t random = 1;
    for (int i = 0; i < N; i++) {
        float numbers[5];
        for (int j = 0; j < 5; j++) numbers[j] = (float)((random = random * 1664525u + 1013904223u) >> 8) / 16777216.0f;
        float size = ldexpf(1, i % 40 - 20);
        splats[i] = (volgrad_splat){W * numbers[0] * 0.999f, H * numbers[1] * 0.999f,
                                    {size * (numbers[2] - 0.5f), -size * numbers[3], size * numbers[4]}};
    }
    make(0, W, H);
    CHECK_STATUS(volgrad_film_add(a, splats, N), VOLGRAD_OK);
    make(1, W, H);
    for (int i = N - 1; i >= 0; i--) CHECK_STATUS(volgrad_film_add(b, &splats[i], 1), VOLGRAD_OK);
    CHECK(memcmp(a, b, 48 * W * H) == 0);
    CHECK(memcmp(develop(a, rgb), develop(b, other), sizeof rgb) == 0);
    make(1, W, H);
    CHECK_STATUS(volgrad_film_add(b, splats + N / 3, N - N / 3), VOLGRAD_OK);
    static alignas(16) unsigned char third[sizeof block[0]];
    volgrad_film *c;
    CHECK_STATUS(volgrad_film_init(third, sizeof third, W, H, &c), VOLGRAD_OK);
    CHECK_STATUS(volgrad_film_add(c, splats, N / 3), VOLGRAD_OK);
    CHECK_STATUS(volgrad_film_merge(b, c), VOLGRAD_OK);
    CHECK(memcmp(a, b, 48 * W * H) == 0);
    CHECK(memcmp(rgb, develop(b, other), sizeof rgb) == 0);

    /* And back to nothing, exactly. */
    for (int i = 0; i < N; i++) {
        volgrad_rgb *value = &splats[i].value;
        value->r = -value->r, value->g = -value->g, value->b = -value->b;
    }
    CHECK_STATUS(volgrad_film_add(b, splats, N), VOLGRAD_OK);
    develop(b, other);
    for (int i = 0; i < FLOATS; i++) CHECK(other[i] == 0);
}

static void test_merge(void) {
    make(0, W, H);
    add(a, 0, 0, 1, 2, 3);
    add(a, -1, 0, 1, 2, 3);
    make(1, W, H);
    add(b, 0, 0, 1, 0, -5);
    add(b, NAN, 0, 1, 2, 3);
    CHECK_STATUS(volgrad_film_merge(a, b), VOLGRAD_OK);
    CHECK(dropped(a) == 2 && dropped(b) == 1);
    develop(a, rgb);
    CHECK(rgb[0] == 2 && rgb[1] == 2 && rgb[2] == -2);
    CHECK_STATUS(volgrad_film_merge(a, a), VOLGRAD_ERROR_RANGE);
    const uint32_t sizes[][2] = {{W + 1, H}, {W, H - 1}, {H, W}, {W * H, 1}};
    for (int i = 0; i < 4; i++) {
        make(1, sizes[i][0], sizes[i][1]);
        add(b, 0, 0, 7, 7, 7);
        CHECK_STATUS(volgrad_film_merge(a, b), VOLGRAD_ERROR_SIZE_MISMATCH);
        CHECK_STATUS(volgrad_film_merge(b, a), VOLGRAD_ERROR_SIZE_MISMATCH);
        CHECK(memcmp(develop(a, other), rgb, sizeof rgb) == 0 && dropped(a) == 2);
    }
    /* A film may be copied. */
    memcpy(block[1], block[0], sizeof block[0]);
    CHECK(memcmp(develop((volgrad_film *)(void *)block[1], other), rgb, sizeof rgb) == 0);
}

int main(void) {
    test_memory();
    test_not_a_film();
    test_splats();
    test_exact();
    test_merge();
    return check_end();
}
