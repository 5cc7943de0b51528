/* --integrator auto: several ways to render, of which small trials find the best for the scene. */
#ifndef RENDER_WAYS_H
#define RENDER_WAYS_H

#include "render.h"

/* Whether the image takes so long that trials cost little of it. */
int ways_are_worth_trying(const render_job *job);

/* Tries job->ways, on job->scene, with numbers that are not in the image; sets result->way, trial_rays and trial_seconds. Without a time
   limit it depends on the job's seed, not on a clock: costs are counted in rays. Returns 0 on a failure: result->status says which;
   VOLGRAD_OK: memory is out. */
int ways_choose(const render_job *job, render_result *result);

#endif
