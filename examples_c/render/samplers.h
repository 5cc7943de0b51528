/* The settings of all samplers, from the command line and the scene. */
#ifndef RENDER_SAMPLERS_H
#define RENDER_SAMPLERS_H

#include "options.h"
#include "scene.h"

typedef struct {
    volgrad_path_sampler_options path; /* beside another one: leaves out what that one renders */
    volgrad_bidirectional_options bidirectional;
    chain_settings chains;
    guide_settings guide;
    int has_guide;
} samplers;

/* Returns 0 if the command line does not go with the scene; it has said so then. */
int samplers_set(samplers *out, const options *o, const scene *s);

/* The samplers among which the command line leaves the choice, up to MOST_WAYS, and the options that each is set from; just one but with
   --integrator auto. Returns how many; 0: the command line does not go with the scene, it has said so then. */
unsigned samplers_list(samplers *all, options *each, const options *o, const scene *s);

/* How to render with one of them. */
way samplers_way(const samplers *all, const options *o);

#endif
