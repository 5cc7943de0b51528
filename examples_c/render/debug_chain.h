/* --debug-chain: one mutation of one chain, in words, and in a file for volgrad-replay. */
#ifndef RENDER_DEBUG_CHAIN_H
#define RENDER_DEBUG_CHAIN_H

#include "render.h"

/* Makes the job's chains, and of one of them the mutations before the one that is asked for; prints that and records it beside the image that
   there would be. Returns 0 if that failed, and has said why on stderr. */
int debug_chain(const render_job *job, const volgrad_scene_desc *desc, const chain_mutation *which, const char *image);

#endif
