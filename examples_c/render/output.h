/* Image files. They appear under their name only when they are complete: written beside it first, then renamed. */
#ifndef RENDER_OUTPUT_H
#define RENDER_OUTPUT_H

#include <stddef.h>
#include <stdint.h>

#include "volgrad.h"

/* Before hours of rendering: can files be made where `exr_path` (which ends in .exr) and its preview go? Prints why not to stderr
   and returns 0. */
int output_check(const char *exr_path);

/* Makes a folder if there is none. Prints why not to stderr and returns 0. */
int output_folder(const char *path);

/* `rgb`: 3 floats for each pixel of the layout's window, row by row. Print to stderr and return 0 on failure. */
int output_write_exr(const char *exr_path, const volgrad_exr_layout *layout, const float *rgb,
                     const volgrad_exr_attribute *attributes, uint32_t attribute_count);

/* The preview x.png of x.exr: clamped to [0, 1], sRGB transfer curve. */
int output_write_preview(const char *exr_path, uint32_t width, uint32_t height, const float *rgb);

#endif
