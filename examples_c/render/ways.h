/* --integrator auto: several ways to render, of which small trials find the best for the scene. */
#ifndef RENDER_WAYS_H
#define RENDER_WAYS_H

#include "guide.h"
#include "render.h"

/* Whether the image takes so long that trials cost little of it. */
int ways_are_worth_trying(const render_job *job);

/* Tries job->ways with numbers that are not in the image; sets result->way, trial_rays and trial_seconds. Guides are learned, as by
   guide_learn, only if they could help. Without a time limit all depends on the job's seed, not on a clock: costs are counted in rays.
   Returns 0 on a failure: result->status says which; VOLGRAD_OK: memory is out. */
int ways_choose(const render_job *job, guide *g, render_result *result);

/* Puts the way's bidirectional options, as they are with these guides, into `out`, and returns that; NULL if it has none. */
const volgrad_bidirectional_options *ways_guided(const way *w, const guide *g, volgrad_bidirectional_options *out);

#endif
