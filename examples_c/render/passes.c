#include "passes.h"

#include <stdlib.h>

#include "counts.h"
#include "pace.h"
#include "seconds.h"
#include "team.h"

/* ---- one group of passes ---- */

/* An item is one block of pixels of one pass. */
static volgrad_status render_item(void *user, unsigned worker, uint64_t item)
{
    const passes *p = user;
    const render_job *job = p->job;
    uint64_t pass = p->done + item / p->blocks_per_pass;
    uint64_t block = item % p->blocks_per_pass;
    uint32_t first_pixel = (uint32_t)(block * p->block_stride + block * p->block_jitter % (p->block_stride - p->block_pixels + 1));
    uint32_t left = job->pixel_count - first_pixel;
    uint32_t count = left < p->block_pixels ? left : p->block_pixels;
    volgrad_film *film = p->films.each[worker].film;
    volgrad_path_sampler_stats *stats = &p->stats[worker];
    volgrad_status status = VOLGRAD_OK;
    if (job->technique != NULL) {
        const technique *only = job->technique;
        return volgrad_bidirectional_run_technique(job->scene, job->queries, job->bidirectional, only->light_vertices,
                                                   only->camera_vertices, only->weighted, pass, first_pixel, count, film, stats);
    }
    if (job->bidirectional != NULL) {
        status = volgrad_bidirectional_run(job->scene, job->queries, job->bidirectional, pass, first_pixel, count, film, stats);
    }
    if (status == VOLGRAD_OK) {
        status = volgrad_path_sampler_run(job->scene, job->queries, job->sampler, pass, first_pixel, count, film, stats);
    }
    return status;
}

static void report(void *user, uint64_t items)
{
    const passes *p = user;
    render_report(p->job, (double)p->done + (double)items / (double)p->blocks_per_pass);
}

volgrad_status passes_run(passes *p, uint64_t count)
{
    team_task task = {.threads = p->job->threads,
                      .item_count = count * p->blocks_per_pass,
                      .user = p,
                      .item = render_item,
                      .report = p->quiet ? NULL : report};
    uint64_t items;
    double start = seconds_wall();
    volgrad_status status = team_run(&task, &items);
    p->seconds += seconds_wall() - start;
    p->done += count;
    p->last_size = count;
    return status;
}

/* ---- all of them ---- */

/* Small enough for every thread to get some of a single pass, large enough for the counter not to matter. */
static uint32_t block_size(const render_job *job)
{
    const uint32_t blocks_per_thread = 16, smallest = 64, largest = 4096;
    uint32_t size = job->pixel_count / (blocks_per_thread * job->threads);
    return size < smallest ? smallest : size > largest ? largest : size;
}

int passes_start(passes *p, const render_job *job, volgrad_status *status)
{
    *p = (passes){.job = job, .block_pixels = block_size(job)};
    p->block_stride = p->block_pixels;
    p->blocks_per_pass = (job->pixel_count + p->block_pixels - 1) / p->block_pixels;
    p->stats = counts_of_paths(job->threads);
    return films_make(&p->films, job->threads, job->width, job->height, status) && p->stats != NULL;
}

volgrad_status passes_finish(passes *p, render_result *result)
{
    result->passes = p->done;
    for (unsigned i = 0; i < p->job->threads; ++i) {
        counts_add_paths(&result->stats, &p->stats[i]);
    }
    return films_sum(&p->films, &result->film);
}

void passes_free(passes *p)
{
    films_free(&p->films);
    free(p->stats);
}

/* ---- until a limit ---- */

/* How many passes to render before the next look; 0 to stop. */
static uint64_t next_group_size(const passes *p)
{
    const render_job *job = p->job;
    double seconds_left = render_seconds_left(job);
    if (p->done > 0 && (seconds_left <= 0.0 || (job->max_passes > 0 && p->done >= job->max_passes))) {
        return 0;
    }
    uint64_t size = pace_next(p->done, p->seconds, p->last_size, seconds_left);
    return job->max_passes > 0 && size > job->max_passes - p->done ? job->max_passes - p->done : size;
}

int passes_render(const render_job *job, render_result *result)
{
    passes p;
    int ok = passes_start(&p, job, &result->status);
    uint64_t size;
    while (ok && result->status == VOLGRAD_OK && (size = next_group_size(&p)) > 0) {
        result->status = passes_run(&p, size);
        render_report(job, (double)p.done);
    }
    if (ok && result->status == VOLGRAD_OK) {
        result->status = passes_finish(&p, result);
    }
    passes_free(&p);
    return ok;
}
