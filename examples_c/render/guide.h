/* Where subpaths from lights go: learned before the rendering, from samples that are not in the image. */
#ifndef RENDER_GUIDE_H
#define RENDER_GUIDE_H

#include "render.h"

typedef struct {
    const volgrad_scene *scene; /* the guided one; the job's own if there is nothing to guide */
    void *memory;               /* to be freed once that scene is not used any more */
    owned_film film;            /* what it learned from; NULL: nothing is guided */
    size_t film_bytes;
    uint64_t samples;           /* that it learned from; 0: nothing is guided */
    double seconds;             /* that they took */
    double brightness;          /* mean luminance of a pixel, as far as subpaths from lights make it; 0: nothing is guided */
    volgrad_path_sampler_stats stats;
} guide;

/* Without a time limit it depends on the job's seed only. Returns 0 on a failure: *status says which; VOLGRAD_OK: memory is out. To be
   freed in either case. */
int guide_learn(guide *g, const render_job *job, volgrad_status *status);

void guide_free(guide *g);

#endif
