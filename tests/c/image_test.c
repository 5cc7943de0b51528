/* OpenEXR files. */

#include "check.h"

enum { W = 7, H = 5, FLOATS = 3 * W * H };

static const volgrad_exr_layout layout = {100, 50, 30, 20, W, H};
static const char *const file = "image_test.exr";
static float rgb[FLOATS], back[FLOATS + 2];

static volgrad_status write_to(const char *path) {
    return volgrad_exr_write(path, &layout, rgb, FLOATS, NULL, 0);
}

/* Whether the file's first bytes, its head, hold `text`. */
static int head_holds(const char *text) {
    char head[2048];
    FILE *in = fopen(file, "rb");
    if (!in) return 0;
    size_t bytes = fread(head, 1, sizeof head, in), length = strlen(text);
    fclose(in);
    for (size_t i = 0; i + length <= bytes; i++) {
        if (memcmp(head + i, text, length) == 0) return 1;
    }
    return 0;
}

static void test_round_trip(void) {
    const volgrad_exr_attribute attributes[] = {{"note", "some words", 0}, {"seed", NULL, 0.1}, {"empty", "", 0}};
    volgrad_exr_layout found;
    CHECK_STATUS(volgrad_exr_write(file, &layout, rgb, FLOATS, attributes, 3), VOLGRAD_OK);
    for (int i = 0; i < 3; i++) CHECK(head_holds(attributes[i].name));
    CHECK(head_holds(attributes[0].text) && !head_holds("no such text"));
    CHECK_STATUS(volgrad_exr_read_layout(file, &found), VOLGRAD_OK);
    CHECK(memcmp(&found, &layout, sizeof found) == 0);
    FILL(back);
    CHECK_STATUS(volgrad_exr_read(file, back, FLOATS + 2), VOLGRAD_OK);
    CHECK(memcmp(back, rgb, sizeof rgb) == 0 && untouched(back + FLOATS, 2 * sizeof *back));
    CHECK_STATUS(volgrad_exr_read(file, back, FLOATS), VOLGRAD_OK);
    REFUSED(back, volgrad_exr_read(file, back, FLOATS - 1), VOLGRAD_ERROR_TOO_SMALL);
    REFUSED(back, volgrad_exr_read(file, back, 0), VOLGRAD_ERROR_TOO_SMALL);
    CHECK_STATUS(volgrad_exr_read(file, NULL, FLOATS), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_exr_read(file, (void *)((unsigned char *)back + 1), FLOATS), VOLGRAD_ERROR_MISALIGNED);
    CHECK_STATUS(volgrad_exr_read_layout(file, NULL), VOLGRAD_ERROR_NULL);

    /* Another image in its place; the whole of it. */
    const volgrad_exr_layout whole = {H, W, 0, 0, H, W};
    CHECK_STATUS(volgrad_exr_write(file, &whole, rgb, FLOATS, NULL, 0), VOLGRAD_OK);
    CHECK_STATUS(volgrad_exr_read_layout(file, &found), VOLGRAD_OK);
    CHECK(memcmp(&found, &whole, sizeof found) == 0);
}

/* Text stays the UTF-8 that it is: two bytes per letter here, and three. */
static void test_utf8(void) {
    const volgrad_exr_attribute accents = {"note", "\xC3\xA9t\xC3\xA9", 0}, arrow = {"note", "\xE2\x86\x92", 0};
    CHECK_STATUS(volgrad_exr_write(file, &layout, rgb, FLOATS, &accents, 1), VOLGRAD_OK);
    CHECK(head_holds(accents.text));
    CHECK_STATUS(volgrad_exr_write(file, &layout, rgb, FLOATS, &arrow, 1), VOLGRAD_OK);
    CHECK(head_holds(arrow.text));
}

static void test_write_errors(void) {
    const size_t counts[] = {0, 1, W * H, FLOATS - 1};
    for (int i = 0; i < 4; i++) CHECK_STATUS(volgrad_exr_write(file, &layout, rgb, counts[i], NULL, 0), VOLGRAD_ERROR_RANGE);
    CHECK_STATUS(volgrad_exr_write(file, &layout, back, FLOATS + 1, NULL, 0), VOLGRAD_ERROR_RANGE);
    CHECK_STATUS(volgrad_exr_write(file, &layout, rgb, SIZE_MAX, NULL, 0), VOLGRAD_ERROR_RANGE);
    volgrad_exr_layout odd = layout;
    odd.window_width = 0;
    CHECK_STATUS(volgrad_exr_write(file, &odd, rgb, 0, NULL, 0), VOLGRAD_ERROR_RANGE);
    odd.window_width = odd.window_height = UINT32_MAX;
    CHECK_STATUS(volgrad_exr_write(file, &odd, rgb, FLOATS, NULL, 0), VOLGRAD_ERROR_RANGE);
    odd = layout, odd.width = 0; /* an image without pixels */
    CHECK(volgrad_exr_write(file, &odd, rgb, FLOATS, NULL, 0) != VOLGRAD_OK);
    odd = layout, odd.height = 0;
    CHECK(volgrad_exr_write(file, &odd, rgb, FLOATS, NULL, 0) != VOLGRAD_OK);

    CHECK_STATUS(volgrad_exr_write(NULL, &layout, rgb, FLOATS, NULL, 0), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_exr_write(file, NULL, rgb, FLOATS, NULL, 0), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_exr_write(file, &layout, NULL, FLOATS, NULL, 0), VOLGRAD_ERROR_NULL);
    CHECK_STATUS(volgrad_exr_write(file, &layout, rgb, FLOATS, NULL, 1), VOLGRAD_ERROR_NULL);
    const volgrad_exr_attribute unnamed = {NULL, "text", 0};
    CHECK_STATUS(volgrad_exr_write(file, &layout, rgb, FLOATS, &unnamed, 1), VOLGRAD_ERROR_NULL);
    const volgrad_exr_attribute not_utf8 = {"note", "\xFF\xFE", 0};
    CHECK(volgrad_exr_write(file, &layout, rgb, FLOATS, &not_utf8, 1) != VOLGRAD_OK);

    CHECK_STATUS(write_to("no such folder/image_test.exr"), VOLGRAD_ERROR_FILE);
    CHECK_STATUS(write_to("."), VOLGRAD_ERROR_FILE);
    CHECK_STATUS(write_to(""), VOLGRAD_ERROR_FILE);

    /* Windows far out, or beyond what the format can say: no file, but no bug either. */
    const uint32_t far[] = {(uint32_t)INT32_MAX, (uint32_t)INT32_MAX + 1, UINT32_MAX};
    for (int i = 0; i < 3; i++) {
        odd = layout, odd.x = far[i];
        CHECK_STATUS(volgrad_exr_write(file, &odd, rgb, FLOATS, NULL, 0), VOLGRAD_ERROR_FILE);
        odd = layout, odd.height = far[i];
        volgrad_status status = volgrad_exr_write(file, &odd, rgb, FLOATS, NULL, 0);
        CHECK(status == VOLGRAD_OK || status == VOLGRAD_ERROR_FILE);
    }
}

/* The first `keep` bytes of a good file; then, if `flip` is below it, with that byte changed. */
static void damage(const unsigned char *good, size_t keep, size_t flip) {
    FILE *out = fopen(file, "wb");
    CHECK(out != NULL);
    if (!out) return;
    for (size_t i = 0; i < keep; i++) fputc(i == flip ? good[i] ^ 0x41 : good[i], out);
    fclose(out);
}

static void test_read_errors(void) {
    volgrad_exr_layout found;
    const char *const missing[] = {"no such file.exr", "no such folder/file.exr", ".", "", "\xFF\xFE"};
    for (int i = 0; i < 5; i++) {
        REFUSED(back, volgrad_exr_read(missing[i], back, FLOATS), VOLGRAD_ERROR_FILE);
        REFUSED(found, volgrad_exr_read_layout(missing[i], &found), VOLGRAD_ERROR_FILE);
    }
    REFUSED(back, volgrad_exr_read(NULL, back, FLOATS), VOLGRAD_ERROR_NULL);
    REFUSED(found, volgrad_exr_read_layout(NULL, &found), VOLGRAD_ERROR_NULL);

    static unsigned char good[1 << 14];
    CHECK_STATUS(write_to(file), VOLGRAD_OK);
    FILE *in = fopen(file, "rb");
    CHECK(in != NULL);
    if (!in) return;
    size_t bytes = fread(good, 1, sizeof good, in);
    fclose(in);
    CHECK(bytes > 100 && bytes < sizeof good);

    /* Cut off: at the end, everywhere in the head, and to nothing. */
    for (size_t keep = 0; keep < bytes; keep += keep < 16 ? 1 : 37) {
        damage(good, keep, SIZE_MAX);
        REFUSED(back, volgrad_exr_read(file, back, FLOATS), VOLGRAD_ERROR_FILE);
    }
    damage(good, bytes - 1, SIZE_MAX);
    REFUSED(back, volgrad_exr_read(file, back, FLOATS), VOLGRAD_ERROR_FILE);

    /* One byte changed: whatever comes back, it is an answer, and an error leaves the buffer alone. */
    int internal = 0;
    for (size_t flip = 0; flip < bytes; flip++) {
        damage(good, bytes, flip);
        FILL(back), FILL(found);
        volgrad_status status = volgrad_exr_read(file, back, FLOATS);
        CHECK(status == VOLGRAD_OK || UNTOUCHED(back));
        internal += status == VOLGRAD_ERROR_INTERNAL;
        status = volgrad_exr_read_layout(file, &found);
        CHECK(status == VOLGRAD_OK || UNTOUCHED(found));
        internal += status == VOLGRAD_ERROR_INTERNAL;
    }
    CHECK(internal == 0);

    /* Garbage, and no image at all. */
    for (size_t i = 0; i < sizeof good; i++) good[i] = (unsigned char)(i * i * 31 + i * 7);
    damage(good, sizeof good, SIZE_MAX);
    REFUSED(back, volgrad_exr_read(file, back, FLOATS), VOLGRAD_ERROR_FILE);
    REFUSED(found, volgrad_exr_read_layout(file, &found), VOLGRAD_ERROR_FILE);

    /* A disk that is full, where there is one to try. */
    FILE *full = fopen("/dev/full", "r+b");
    if (full) {
        fclose(full);
        CHECK_STATUS(write_to("/dev/full"), VOLGRAD_ERROR_FILE);
    }
}

int main(void) {
    for (int i = 0; i < FLOATS; i++) rgb[i] = (float)(i - 20) * 0.37f;
    rgb[3] = 1e30f, rgb[4] = 1e-40f, rgb[5] = -INFINITY;
    test_round_trip();
    test_utf8();
    test_write_errors();
    test_read_errors();
    remove(file);
    return check_end();
}
