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
    return output_write_exr(source->options->output, layout, window, m.attributes, m.count) &&
           output_write_preview(source->options->output, layout->window_width, layout->window_height, window);
}

int image_write(const image_source *source)
{
    volgrad_exr_layout layout = image_window(source->camera);
    size_t count = 3 * (size_t)layout.width * layout.height;
    float *rgb = malloc(count * sizeof *rgb);
    if (rgb == NULL) {
        fputs("volgrad-render: out of memory for the image\n", stderr);
        return 0;
    }
    volgrad_status status = volgrad_film_develop(source->result->film, 1.0 / (double)source->result->passes, rgb, count);
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
