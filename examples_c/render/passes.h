/* Whole passes on all threads: a pass is one path through every pixel of the crop window, or a pair of subpaths and what they make
   together with a path for the lengths that they leave out. */
#ifndef RENDER_PASSES_H
#define RENDER_PASSES_H

#include "films.h"
#include "render.h"

typedef struct {
    const render_job *job;
    films films;
    volgrad_path_sampler_stats *stats; /* of each thread */
    uint64_t done;
    double seconds;     /* that they took */
    uint64_t last_size; /* of the last group */
    uint32_t block_pixels, blocks_per_pass;
    /* Block k begins somewhere in stride k, at k * block_jitter in what it leaves room for. As large as a block: all pixels. */
    uint32_t block_stride, block_jitter;
    int quiet; /* does not report */
} passes;

/* Returns 0 on a failure: *status says which; VOLGRAD_OK: memory is out. To be freed in either case. */
int passes_start(passes *p, const render_job *job, volgrad_status *status);

/* Renders `count` more. */
volgrad_status passes_run(passes *p, uint64_t count);

/* Hands the sum of all films and stats to the result. */
volgrad_status passes_finish(passes *p, render_result *result);

void passes_free(passes *p);

/* Passes until one of the job's limits. As render_run. */
int passes_render(const render_job *job, render_result *result);

#endif
