#include "image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "metadata.h"
#include "output.h"

volgrad_exr_layout image_window(const volgrad_camera *camera)
{
    return (volgrad_exr_layout){.width = camera->width,
                                .height = camera->height,
                                .x = camera->crop_x0,
                                .y = camera->crop_y0,
                                .window_width = camera->crop_x1 - camera->crop_x0,
                                .window_height = camera->crop_y1 - camera->crop_y0};
}

/* Moves the window's pixels to the front. */
static void cut_window(float *rgb, const volgrad_exr_layout *layout)
{
    size_t row = 3 * (size_t)layout->window_width;
    for (uint32_t y = 0; y < layout->window_height; ++y) {
        const float *from = rgb + 3 * ((size_t)(layout->y + y) * layout->width + layout->x);
        memmove(rgb + y * row, from, row * sizeof *rgb);
    }
}

static int write_files(const image_source *source, const float *window, const volgrad_exr_layout *layout)
{
    metadata m;
    metadata_collect(&m, source);
    return output_write_exr(source->output, layout, window, m.attributes, m.count) &&
           output_write_preview(source->output, layout->window_width, layout->window_height, window);
}

/* `more` is room for as many floats as `rgb`; without chains it is not used. */
static volgrad_status develop(const render_result *result, float *rgb, float *more, size_t count)
{
    volgrad_status status = volgrad_film_develop(result->film.film, 1.0 / (double)result->passes, rgb, count);
    if (status != VOLGRAD_OK || result->chains.film.film == NULL) {
        return status;
    }
    status = volgrad_film_develop(result->chains.film.film, result->chains.scale, more, count);
    for (size_t i = 0; status == VOLGRAD_OK && i < count; ++i) {
        rgb[i] += more[i];
    }
    return status;
}

int image_write(const image_source *source)
{
    volgrad_exr_layout layout = image_window(source->camera);
    size_t count = 3 * (size_t)layout.width * layout.height;
    float *rgb = malloc((source->result->chains.film.film != NULL ? 2 : 1) * count * sizeof *rgb);
    if (rgb == NULL) {
        fputs("volgrad-render: out of memory for the image\n", stderr);
        return 0;
    }
    volgrad_status status = develop(source->result, rgb, rgb + count, count);
    int ok = status == VOLGRAD_OK;
    if (ok) {
        cut_window(rgb, &layout);
        ok = write_files(source, rgb, &layout);
    } else {
        fprintf(stderr, "volgrad-render: film: %s\n", volgrad_status_message(status));
    }
    free(rgb);
    return ok;
}
