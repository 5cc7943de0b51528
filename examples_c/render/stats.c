#include "stats.h"

#include <inttypes.h>
#include <stdio.h>

static void print_row(const char *name, uint64_t count, double seconds)
{
    printf("%-16s %16" PRIu64 " %14.0f\n", name, count, seconds > 0.0 ? (double)count / seconds : 0.0);
}

static double percent(uint64_t part, uint64_t whole)
{
    return whole > 0 ? 100.0 * (double)part / (double)whole : 0.0;
}

static void print_share(const char *name, uint64_t part, uint64_t whole)
{
    printf("%-16s %16" PRIu64 " %13.1f%%\n", name, part, percent(part, whole));
}

/* With the same of the bootstrap in a third column. */
static void print_both(const char *name, uint64_t count, double seconds, uint64_t bootstrap)
{
    printf("%-16s %16" PRIu64 " %14.0f %14" PRIu64 "\n", name, count, seconds > 0.0 ? (double)count / seconds : 0.0, bootstrap);
}

static void print_lengths(const chain_result *chains)
{
    printf("\n%-16s %9s %12s %12s %9s %9s %9s %9s\n", "edges", "chains", "brightness", "mutations", "large acc", "small acc", "dark", "dropped");
    for (int length = 0; length <= VOLGRAD_MAX_LENGTH; ++length) {
        const chain_length *l = &chains->lengths[length];
        const volgrad_chain_stats *s = &l->stats;
        if (l->chains > 0) {
            printf("%-16d %9" PRIu32 " %12.5g %12" PRIu64 " %8.1f%% %8.1f%% %8.1f%% %9" PRIu64 "\n", length, l->chains, l->brightness,
                   s->large_steps + s->small_steps, percent(s->large_accepted, s->large_steps),
                   percent(s->small_accepted, s->small_steps), percent(s->dark, s->large_steps + s->small_steps), s->dropped);
        }
    }
}

static void print_chains(const chain_result *chains)
{
    const volgrad_chain_stats *s = &chains->stats, *b = &chains->bootstrap;
    uint64_t mutations = s->large_steps + s->small_steps;
    printf("\n%-16s %16.6g +- %.2g%%\n", "brightness", chains->brightness, 100.0 * chains->relative_error);
    printf("%-16s %16" PRIu64 " in %.3f s\n", "samples for it", chains->bootstrap_samples, chains->bootstrap_seconds);
    printf("%-16s %16" PRIu32 "\n\n", "chains", chains->count);
    printf("%-16s %16s %14s %14s\n", "", "count", "per core s", "bootstrap");
    print_both("mutations", mutations + s->burn_in, chains->cpu_seconds, b->samples);
    print_both("rays", s->rays, chains->cpu_seconds, b->rays);
    print_both("occlusion rays", s->occlusion_rays, chains->cpu_seconds, b->occlusion_rays);
    print_row("shifted paths", s->shifted_paths, chains->cpu_seconds);
    print_row("shifts", s->shifts, chains->cpu_seconds);
    print_row("stays", s->stays, chains->cpu_seconds);
    print_both("overflows", s->overflows, chains->cpu_seconds, b->overflows);
    print_both("dropped paths", s->dropped, chains->cpu_seconds, b->dropped);
    printf("\n%-16s %16s %14s\n", "", "count", "share");
    print_share("burn-in", s->burn_in, mutations + s->burn_in);
    print_share("large steps", s->large_steps, mutations);
    print_share("  accepted", s->large_accepted, s->large_steps);
    print_share("small steps", s->small_steps, mutations);
    print_share("  accepted", s->small_accepted, s->small_steps);
    print_share("dark", s->dark, mutations);
    print_lengths(chains);
}

void stats_print(const render_result *result, const char *way, uint64_t dropped)
{
    const volgrad_path_sampler_stats *s = &result->stats;
    double seconds = result->wall_seconds - result->guide_seconds - result->trial_seconds;
    printf("%-16s %16" PRIu64 "\n", "passes", result->passes);
    printf("%-16s %16.3f s\n", "wall time", result->wall_seconds);
    printf("%-16s %16.3f s\n", "processor time", result->cpu_seconds);
    if (result->guide_seconds > 0.0) {
        printf("%-16s %16" PRIu64 " in %.3f s\n", "guide samples", result->guide_samples, result->guide_seconds);
        printf("%-16s %16" PRIu64 "\n", "guide rays", result->guide_stats.rays + result->guide_stats.occlusion_rays);
        printf("%-16s %16" PRIu64 "\n", "guide overflows", result->guide_stats.overflows);
    }
    if (result->trial_rays > 0) {
        printf("%-16s %16" PRIu64 " in %.3f s: %s\n", "trial rays", result->trial_rays, result->trial_seconds, way);
    }
    putchar('\n');
    printf("%-16s %16s %14s\n", "", "count", "per second");
    print_row("paths", s->paths, seconds);
    print_row("rays", s->rays, seconds);
    print_row("occlusion rays", s->occlusion_rays, seconds);
    print_row("shifted paths", s->shifted_paths, seconds);
    print_row("shifts", s->shifts, seconds);
    print_row("stays", s->stays, seconds);
    print_row("overflows", s->overflows, seconds);
    print_row("dropped samples", dropped, seconds);
    if (result->chains.bootstrap_samples > 0) {
        print_chains(&result->chains);
    }
}
