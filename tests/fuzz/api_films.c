/* Films of any size and splats of any value; OpenEXR files of any layout and attributes, written and read back. */

#include "api.h"

#include <unistd.h>

enum { MOST_SPLATS = 40, MOST_ATTRIBUTES = 4 };

static void films(input *in, arena *a) {
    uint32_t width = below(in, 20), height = below(in, 20), count = pick(in, MOST_SPLATS);
    volgrad_film *into = take_film(a, width, height), *from = take_film(a, height, width);
    volgrad_splat *splats = take_array(a, count * sizeof *splats);
    for (uint32_t i = 0; i < count; i++) {
        splats[i].x = number(in, -1, 21), splats[i].y = number(in, -1, 21);
        splats[i].value = colour(in, -10, 1e9f);
    }
    volgrad_film_add(into, splats, count);
    volgrad_film_add(from, hostile(in) ? NULL : splats, count);
    for (int i = pick(in, 100); i > 0; i--) volgrad_film_merge(into, from); /* sums grow */
    if (into != NULL) check_film(a, into, width, height);
    if (into != NULL && width * height > 1) {
        float pixel[3] = {-1, -1, -1};
        MUST(volgrad_film_develop(into, number(in, 0, 1), pixel, 3) != VOLGRAD_OK && pixel[0] == -1);
        MUST(volgrad_film_merge(into, into) == VOLGRAD_ERROR_RANGE);
    }
}

static const char *text(input *in, arena *a) {
    if (hostile(in)) return NULL;
    uint32_t length = pick(in, 40);
    char *bytes = take_array(a, length + 1);
    for (uint32_t i = 0; i < length; i++) bytes[i] = (char)(hostile(in) ? next_byte(in) : 'a' + pick(in, 26));
    return bytes;
}

static void exr(input *in, arena *a) {
    static char path[64];
    if (*path == 0) snprintf(path, sizeof path, "/tmp/volgrad_api_films_%ld.exr", (long)getpid());
    volgrad_exr_layout layout = {1 + pick(in, 12), 1 + pick(in, 12), 0, 0, 1 + pick(in, 12), 1 + pick(in, 12)}, found;
    if (hostile(in)) layout.width = next_word(in);
    if (hostile(in)) layout.window_width = next_word(in);
    if (hostile(in)) layout.window_height = next_word(in);
    if (pick(in, 2)) layout.x = below(in, 8), layout.y = below(in, 8);
    uint64_t count = (uint64_t)layout.window_width * layout.window_height * 3;
    if (count > 3 * 144) count = pick(in, 100);
    float *rgb = take_array(a, count * sizeof *rgb);
    for (uint64_t i = 0; i < count; i++) rgb[i] = number(in, 0, 10);
    volgrad_exr_attribute attributes[MOST_ATTRIBUTES];
    uint32_t attribute_count = pick(in, MOST_ATTRIBUTES + 1);
    for (uint32_t i = 0; i < attribute_count; i++) {
        attributes[i].name = text(in, a), attributes[i].text = text(in, a), attributes[i].number = number(in, 0, 10);
    }
    if (volgrad_exr_write(path, &layout, rgb, count, attributes, attribute_count) == VOLGRAD_OK) {
        float *back = take_array(a, count * sizeof *back);
        MUST(volgrad_exr_read_layout(path, &found) == VOLGRAD_OK && memcmp(&layout, &found, sizeof found) == 0);
        MUST(volgrad_exr_read(path, back, count - 1) == VOLGRAD_ERROR_TOO_SMALL);
        MUST(volgrad_exr_read(path, back, count) == VOLGRAD_OK && memcmp(rgb, back, count * sizeof *rgb) == 0);
    }
    unlink(path);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    input in = {data, size};
    arena memory = {{NULL}, 0};
    MUST(volgrad_status_message((int32_t)next_word(&in)) != NULL);
    films(&in, &memory);
    exr(&in, &memory);
    release(&memory);
    return 0;
}
