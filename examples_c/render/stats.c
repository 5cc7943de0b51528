#include "stats.h"

#include <inttypes.h>
#include <stdio.h>

static void print_row(const char *name, uint64_t count, double seconds)
{
    printf("%-16s %16" PRIu64 " %14.0f\n", name, count, seconds > 0.0 ? (double)count / seconds : 0.0);
}

void stats_print(const render_result *result, uint64_t dropped)
{
    const volgrad_path_sampler_stats *s = &result->stats;
    double seconds = result->wall_seconds;
    printf("%-16s %16" PRIu64 "\n", "passes", result->passes);
    printf("%-16s %16.3f s\n", "wall time", seconds);
    printf("%-16s %16.3f s\n\n", "processor time", result->cpu_seconds);
    printf("%-16s %16s %14s\n", "", "count", "per second");
    print_row("paths", s->paths, seconds);
    print_row("rays", s->rays, seconds);
    print_row("occlusion rays", s->occlusion_rays, seconds);
    print_row("shifted paths", s->shifted_paths, seconds);
    print_row("shifts", s->shifts, seconds);
    print_row("stays", s->stays, seconds);
    print_row("overflows", s->overflows, seconds);
    print_row("dropped samples", dropped, seconds);
}
