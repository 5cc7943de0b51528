/* Renders whole passes on all threads: a pass is one path through every pixel of the crop window. The image depends on the seed and
   the number of passes, not on the threads: films are integer sums, and a limit or a signal only decides before which pass to stop. */
#ifndef RENDER_RENDER_H
#define RENDER_RENDER_H

#include <signal.h>
#include <stddef.h>
#include <stdint.h>

#include "volgrad.h"

typedef struct {
    const volgrad_scene *scene;
    const volgrad_queries *queries;
    const volgrad_path_sampler_options *sampler;
    uint32_t width, height;            /* of the whole image */
    uint32_t pixel_count;              /* in the crop window */
    unsigned threads;                  /* at least 1 */
    uint64_t max_passes;               /* 0: no limit */
    double max_seconds;                /* 0: no limit */
    const volatile sig_atomic_t *stop; /* ends the rendering when it becomes non-zero */
    /* Told now and then, on the calling thread, how many passes (with fraction) are done after how many seconds. May be NULL. */
    void (*report)(void *user, double passes, double seconds);
    void *report_user;
} render_job;

typedef struct {
    volgrad_status status;
    uint64_t passes;
    double wall_seconds;
    double cpu_seconds; /* of all threads */
    volgrad_path_sampler_stats stats;
    volgrad_film *film; /* the sum of all passes; NULL unless status is VOLGRAD_OK */
    void *film_memory;
} render_result;

/* Returns 0 when out of memory or when `status` is not VOLGRAD_OK; what was rendered by then is lost. */
int render_run(const render_job *job, render_result *result);

void render_result_free(render_result *result);

/* Memory as volgrad wants it, 16-byte aligned. Free with free(). */
void *render_allocate(size_t bytes);

#endif
