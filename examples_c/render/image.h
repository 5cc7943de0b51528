/* The finished image: developed from the film, cut to the crop window and written with what is known about its making. */
#ifndef RENDER_IMAGE_H
#define RENDER_IMAGE_H

#include "options.h"
#include "render.h"

typedef struct {
    const char *command_line;
    const char *output; /* ends in .exr */
    const options *options;
    const volgrad_camera *camera;
    const volgrad_path_sampler_options *sampler;
    const chain_settings *chains; /* NULL: none */
    const technique *technique;   /* NULL: all */
    const render_result *result;
    uint64_t dropped; /* samples that were no numbers */
} image_source;

/* The whole image and the part of it that is rendered. */
volgrad_exr_layout image_window(const volgrad_camera *camera);

/* Writes the EXR file and its preview. Prints to stderr and returns 0 on failure. */
int image_write(const image_source *source);

#endif
