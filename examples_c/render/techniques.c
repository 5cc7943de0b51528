#include "techniques.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "seconds.h"

/* Edges of the longest paths, if nobody says otherwise: beyond it there are too many images to look at. */
static const uint32_t LONGEST = 8;

static int failed(const char *path, const char *problem)
{
    fprintf(stderr, "volgrad-render: %s: %s\n", path, problem);
    return 0;
}

/* Renders it and writes the image, unless the job is stopped. */
static int write_image(const render_job *job, image_source *source)
{
    render_result result;
    source->result = &result;
    int ok = render_run(job, &result);
    volgrad_status status = ok ? volgrad_film_dropped(result.film.film, &source->dropped) : result.status;
    if (status != VOLGRAD_OK || !ok) {
        failed(source->output, status != VOLGRAD_OK ? volgrad_status_message(status) : "out of memory");
        ok = 0;
    }
    ok = ok && (*job->stop || image_write(source));
    render_result_free(&result);
    return ok;
}

static int write_technique(const render_job *whole, const image_source *image, technique t)
{
    const char *folder = image->options->techniques;
    size_t size = strlen(folder) + sizeof "/s00_t00_weighted.exr";
    char *path = malloc(size);
    if (path == NULL) {
        return failed(folder, "out of memory");
    }
    snprintf(path, size, "%s/s%u_t%u%s.exr", folder, (unsigned)t.light_vertices, (unsigned)t.camera_vertices,
             t.weighted ? "_weighted" : "");
    render_job job = *whole;
    job.technique = &t;
    job.max_passes = image->result->passes;
    job.max_seconds = 0.0;
    job.start = seconds_wall();
    job.report = NULL;
    image_source source = *image;
    source.output = path;
    source.technique = &t;
    int ok = write_image(&job, &source);
    free(path);
    return ok;
}

int techniques_write(const render_job *job, const image_source *source)
{
    uint32_t longest = job->bidirectional->max_length;
    if (longest > LONGEST && !source->options->has_max_depth) {
        longest = LONGEST;
    }
    int ok = 1;
    for (uint32_t edges = 2; edges <= longest; ++edges) {
        for (uint32_t lights = 0; lights <= edges; ++lights) {
            technique t = {.light_vertices = lights, .camera_vertices = edges + 1 - lights};
            for (; ok && !*job->stop && t.weighted <= 1; ++t.weighted) {
                ok = write_technique(job, source, t);
            }
        }
    }
    return ok;
}
