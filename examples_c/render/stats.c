#include "stats.h"

#include <inttypes.h>
#include <stdio.h>

static void print_row(const char *name, uint64_t count, double seconds)
{
    printf("%-16s %16" PRIu64 " %14.0f\n", name, count, seconds > 0.0 ? (double)count / seconds : 0.0);
}

static void print_share(const char *name, uint64_t part, uint64_t whole)
{
    printf("%-16s %16" PRIu64 " %13.1f%%\n", name, part, whole > 0 ? 100.0 * (double)part / (double)whole : 0.0);
}

static void print_chains(const chain_result *chains)
{
    const volgrad_chain_stats *s = &chains->stats;
    uint64_t mutations = s->large_steps + s->small_steps;
    printf("\n%-16s %16.6g +- %.2g%%\n", "brightness", chains->brightness, 100.0 * chains->relative_error);
    printf("%-16s %16" PRIu64 " in %.3f s\n", "samples for it", chains->bootstrap_samples, chains->bootstrap_seconds);
    printf("%-16s %16" PRIu32 "\n\n", "chains", chains->count);
    printf("%-16s %16s %14s\n", "", "count", "per core s");
    print_row("mutations", mutations + s->burn_in, chains->cpu_seconds);
    print_row("rays", s->rays, chains->cpu_seconds);
    print_row("occlusion rays", s->occlusion_rays, chains->cpu_seconds);
    print_row("shifted paths", s->shifted_paths, chains->cpu_seconds);
    print_row("shifts", s->shifts, chains->cpu_seconds);
    print_row("stays", s->stays, chains->cpu_seconds);
    print_row("overflows", s->overflows, chains->cpu_seconds);
    print_row("dropped paths", s->dropped, chains->cpu_seconds);
    printf("\n%-16s %16s %14s\n", "", "count", "share");
    print_share("burn-in", s->burn_in, mutations + s->burn_in);
    print_share("large steps", s->large_steps, mutations);
    print_share("  accepted", s->large_accepted, s->large_steps);
    print_share("small steps", s->small_steps, mutations);
    print_share("  accepted", s->small_accepted, s->small_steps);
    print_share("dark", s->dark, mutations);
}

void stats_print(const render_result *result, uint64_t dropped)
{
    const volgrad_path_sampler_stats *s = &result->stats;
    double seconds = result->wall_seconds;
    printf("%-16s %16" PRIu64 "\n", "passes", result->passes);
    printf("%-16s %16.3f s\n", "wall time", seconds);
    printf("%-16s %16.3f s\n", "processor time", result->cpu_seconds);
    if (result->guide_seconds > 0.0) {
        printf("%-16s %16" PRIu64 " in %.3f s\n", "guide samples", result->guide_samples, result->guide_seconds);
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
