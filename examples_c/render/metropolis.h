/* Metropolis light transport: chains render the paths of some lengths, passes of the path sampler the others, in turns. */
#ifndef RENDER_METROPOLIS_H
#define RENDER_METROPOLIS_H

#include "render.h"

/* As render_run. */
int metropolis_render(const render_job *job, render_result *result);

#endif
