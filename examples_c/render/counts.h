/* Sums of what threads have counted. */
#ifndef RENDER_COUNTS_H
#define RENDER_COUNTS_H

#include "volgrad.h"

void counts_add_paths(volgrad_path_sampler_stats *sum, const volgrad_path_sampler_stats *more);

void counts_add_chains(volgrad_chain_stats *sum, const volgrad_chain_stats *more);

/* `count` of either kind, all 0. NULL: memory is out. To be freed. */
volgrad_path_sampler_stats *counts_of_paths(size_t count);

volgrad_chain_stats *counts_of_chains(size_t count);

#endif
