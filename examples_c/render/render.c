#include "render.h"

#include <math.h>
#include <stdlib.h>

#include "guide.h"
#include "metropolis.h"
#include "passes.h"
#include "seconds.h"

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

int render_run(const render_job *job, render_result *result)
{
    *result = (render_result){.status = VOLGRAD_OK,
                              .stats = {.struct_size = sizeof result->stats},
                              .chains = {.stats = {.struct_size = sizeof result->chains.stats}}};
    double cpu_start = seconds_cpu();
    guide g;
    int ok = guide_learn(&g, job, &result->status);
    result->guide_samples = g.samples;
    result->guide_seconds = g.seconds;
    result->guide_stats = g.stats;
    if (ok) {
        render_job guided = *job;
        guided.scene = g.scene;
        volgrad_bidirectional_options bidirectional;
        if (job->bidirectional != NULL) {
            bidirectional = *job->bidirectional;
            bidirectional.roulette = (float)(job->roulette * g.brightness);
            result->roulette = bidirectional.roulette;
            guided.bidirectional = &bidirectional;
        }
        ok = job->chains != NULL ? metropolis_render(&guided, result) : passes_render(&guided, result);
    }
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
