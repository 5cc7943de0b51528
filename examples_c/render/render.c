#include "render.h"

#include <math.h>
#include <stdlib.h>

#include "guide.h"
#include "metropolis.h"
#include "passes.h"
#include "seconds.h"
#include "ways.h"

void render_report(const render_job *job, double done)
{
    if (job->report != NULL) {
        job->report(job->report_user, done, seconds_wall() - job->start);
    }
}

double render_seconds_left(const render_job *job)
{
    if (*job->stop) {
        return 0.0;
    }
    return job->max_seconds > 0.0 ? job->max_seconds - (seconds_wall() - job->start) : INFINITY;
}

static int render_chains(const render_job *job, guide *g, render_result *result)
{
    render_job guided = *job;
    if (!guide_learn(g, job, &result->status)) {
        return 0;
    }
    guided.scene = g->scene;
    return metropolis_render(&guided, result);
}

/* One way is taken as it is; of several, guides are learned only for those that need them. */
static int render_best_way(const render_job *job, guide *g, render_result *result)
{
    volgrad_bidirectional_options bidirectional;
    render_job chosen = *job;
    if (!(job->way_count > 1 ? ways_choose(job, g, result) : guide_learn(g, job, &result->status))) {
        return 0;
    }
    const way *way = &job->ways[result->way];
    chosen.scene = g->scene;
    chosen.sampler = way->sampler;
    chosen.bidirectional = ways_guided(way, g, &bidirectional);
    result->roulette = chosen.bidirectional != NULL ? bidirectional.roulette : 0.0;
    return passes_render(&chosen, result);
}

int render_run(const render_job *job, render_result *result)
{
    *result = (render_result){.status = VOLGRAD_OK,
                              .stats = {.struct_size = sizeof result->stats},
                              .chains = {.stats = {.struct_size = sizeof result->chains.stats}}};
    double cpu_start = seconds_cpu();
    render_job first_way = *job;
    if (job->way_count > 1 && !ways_are_worth_trying(job)) {
        first_way.way_count = 1;
        first_way.guide = NULL;
        job = &first_way;
    }
    guide g = {.scene = job->scene};
    int ok = job->chains != NULL ? render_chains(job, &g, result) : render_best_way(job, &g, result);
    result->guide_samples = g.samples;
    result->guide_seconds = g.seconds;
    result->guide_stats = g.stats;
    guide_free(&g);
    result->wall_seconds = seconds_wall() - job->start;
    result->cpu_seconds = seconds_cpu() - cpu_start;
    return ok && result->status == VOLGRAD_OK;
}

void render_result_free(render_result *result)
{
    free(result->film.memory);
    free(result->chains.film.memory);
    *result = (render_result){.status = VOLGRAD_OK};
}
