/* OpenEXR files: the window, then the pixels, into memory that is exactly as large. */
#include "fuzz.h"
#include "volgrad.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    enum { MOST_PIXELS = 1 << 20 };
    const char *path = fuzz_file("a.exr", data, size);
    volgrad_exr_layout layout;
    if (volgrad_exr_read_layout(path, &layout) != VOLGRAD_OK) {
        return 0;
    }
    uint64_t pixels = (uint64_t)layout.window_width * layout.window_height;
    if (pixels <= MOST_PIXELS) {
        float *rgb = malloc(3 * pixels * sizeof *rgb);
        volgrad_exr_read(path, rgb, 3 * pixels);
        free(rgb);
    }
    return 0;
}
