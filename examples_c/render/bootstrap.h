/* What chains begin with: independent samples on all threads, until the image's brightness is known well enough. */
#ifndef RENDER_BOOTSTRAP_H
#define RENDER_BOOTSTRAP_H

#include "render.h"

typedef struct {
    const render_job *job;
    volgrad_chain_techniques techniques; /* of these samples */
    float *weights;
    uint64_t count;
    double start;   /* seconds_wall() */
    double seconds; /* that they took */
    volgrad_chain_plan_result known;
    volgrad_chain_stats *stats; /* of each thread, what was learned from included */
} bootstrap;

/* Returns 0 on a failure: *status says which; VOLGRAD_OK: memory is out. To be freed in either case. */
int bootstrap_run(bootstrap *b, const render_job *job, volgrad_status *status);

void bootstrap_free(bootstrap *b);

#endif
