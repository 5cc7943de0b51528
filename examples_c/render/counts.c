#include "counts.h"

#include <stdlib.h>

void counts_add_paths(volgrad_path_sampler_stats *sum, const volgrad_path_sampler_stats *more)
{
    sum->paths += more->paths;
    sum->rays += more->rays;
    sum->occlusion_rays += more->occlusion_rays;
    sum->shifted_paths += more->shifted_paths;
    sum->shifts += more->shifts;
    sum->stays += more->stays;
    sum->overflows += more->overflows;
}

void counts_add_chains(volgrad_chain_stats *sum, const volgrad_chain_stats *more)
{
    sum->samples += more->samples;
    sum->large_steps += more->large_steps;
    sum->large_accepted += more->large_accepted;
    sum->small_steps += more->small_steps;
    sum->small_accepted += more->small_accepted;
    sum->dark += more->dark;
    sum->burn_in += more->burn_in;
    sum->dropped += more->dropped;
    sum->rays += more->rays;
    sum->occlusion_rays += more->occlusion_rays;
    sum->overflows += more->overflows;
    sum->shifted_paths += more->shifted_paths;
    sum->shifts += more->shifts;
    sum->stays += more->stays;
}

volgrad_path_sampler_stats *counts_of_paths(size_t count)
{
    volgrad_path_sampler_stats *all = calloc(count, sizeof *all);
    for (size_t i = 0; all != NULL && i < count; ++i) {
        all[i].struct_size = sizeof *all;
    }
    return all;
}

volgrad_chain_stats *counts_of_chains(size_t count)
{
    volgrad_chain_stats *all = calloc(count, sizeof *all);
    for (size_t i = 0; all != NULL && i < count; ++i) {
        all[i].struct_size = sizeof *all;
    }
    return all;
}
