#include "chains.h"

#include <math.h>
#include <stdlib.h>

#include "counts.h"
#include "seconds.h"
#include "team.h"

/* ---- a piece of work is one chain ---- */

enum { LENGTHS = VOLGRAD_MAX_LENGTH + 1 };

/* Where a thread counts what it does with a chain. */
static volgrad_chain_stats *stats_for(const chains *c, unsigned worker, uint64_t item)
{
    return &c->stats[worker * LENGTHS + c->starts[item].length];
}

/* A burn-in only tunes the steps, so without time for it the image is as right. */
static volgrad_status init_item(void *user, unsigned worker, uint64_t item)
{
    chains *c = user;
    const render_job *job = c->job;
    volgrad_chain_options options = job->chains->options;
    if (render_seconds_left(job) <= 0.0) {
        options.burn_in = 0;
    }
    unsigned char *memory = (unsigned char *)c->memory + item * c->bytes_of_one;
    return volgrad_chain_init(memory, c->bytes_of_one, job->scene, job->queries, &options, c->techniques, &c->starts[item],
                              stats_for(c, worker, item), &c->each[item]);
}

static volgrad_status run_item(void *user, unsigned worker, uint64_t item)
{
    const chains *c = user;
    const render_job *job = c->job;
    return volgrad_chain_run(c->each[item], job->scene, job->queries, c->last_size, c->films.each[worker].film,
                             stats_for(c, worker, item));
}

static volgrad_status flush_item(void *user, unsigned worker, uint64_t item)
{
    const chains *c = user;
    return volgrad_chain_flush(c->each[item], c->job->scene, c->job->queries, c->films.each[worker].film, stats_for(c, worker, item));
}

static void report_init(void *user, uint64_t items)
{
    const chains *c = user;
    (void)items;
    render_report(c->job, 0.0);
}

static void report_run(void *user, uint64_t items)
{
    const chains *c = user;
    double mutations = (double)c->done * (double)c->count + (double)items * (double)c->last_size;
    render_report(c->job, mutations / (double)c->job->pixel_count);
}

static volgrad_status for_each(chains *c, volgrad_status (*item)(void *, unsigned, uint64_t), void (*report)(void *, uint64_t))
{
    team_task task = {.threads = c->job->threads, .item_count = c->count, .user = c, .item = item, .report = report};
    uint64_t items;
    double cpu_start = seconds_cpu();
    volgrad_status status = team_run(&task, &items);
    c->cpu_seconds += seconds_cpu() - cpu_start;
    return status;
}

volgrad_status chains_run(chains *c, uint64_t mutations)
{
    double start = seconds_wall();
    c->last_size = mutations;
    volgrad_status status = for_each(c, run_item, report_run);
    c->seconds += seconds_wall() - start;
    c->done += mutations;
    return status;
}

/* ---- beginning and end ---- */

/* Unless told: so many that their burn-in is a small share of all mutations. A bootstrap sample carries nothing more often than a
   mutation does, and so takes less time: a half to a fifth of it, in our scenes. */
static uint32_t wanted_chains(const render_job *job, const bootstrap *b)
{
    const double burn_in_share = 0.05, fewest = 32.0, most = 1024.0, mutations_per_sample_time = 0.3;
    const chain_settings *settings = job->chains;
    if (settings->chains > 0) {
        return settings->chains;
    }
    double mutations = INFINITY;
    if (settings->mutations_per_pixel > 0) {
        mutations = (double)settings->mutations_per_pixel * (double)job->pixel_count;
    }
    if (job->max_seconds > 0.0) {
        double samples = fmax(render_seconds_left(job), 0.0) * (double)b->count / b->seconds;
        mutations = fmin(mutations, mutations_per_sample_time * samples);
    }
    double affordable = burn_in_share * mutations / fmax((double)settings->options.burn_in, 1.0);
    return (uint32_t)fmin(fmax(affordable, fewest), most);
}

static int make_room(chains *c, uint32_t wanted, volgrad_status *status)
{
    *status = volgrad_chain_size(&c->job->chains->options, &c->bytes_of_one);
    if (*status != VOLGRAD_OK) {
        return 0;
    }
    /* volgrad_chain_plan can make so many more of them than wanted. */
    size_t most = (size_t)wanted + VOLGRAD_MAX_LENGTH;
    c->memory = aligned_memory(most * c->bytes_of_one);
    c->starts = calloc(most, sizeof *c->starts);
    c->each = calloc(most, sizeof *c->each);
    c->stats = counts_of_chains((size_t)c->job->threads * LENGTHS);
    return c->memory != NULL && c->starts != NULL && c->each != NULL && c->stats != NULL;
}

int chains_start(chains *c, const render_job *job, const bootstrap *b, volgrad_status *status)
{
    *c = (chains){.job = job, .techniques = &b->techniques};
    uint32_t wanted = wanted_chains(job, b);
    if (!make_room(c, wanted, status) || !films_make(&c->films, job->threads, job->width, job->height, status)) {
        return 0;
    }
    volgrad_chain_plan_result planned = {.struct_size = sizeof planned};
    *status = volgrad_chain_plan(&job->chains->options, c->techniques, b->weights, b->count, wanted, c->starts,
                                 wanted + VOLGRAD_MAX_LENGTH, &planned);
    if (*status == VOLGRAD_OK) {
        c->count = planned.chain_count;
        *status = for_each(c, init_item, report_init);
    }
    return *status == VOLGRAD_OK;
}

/* What the threads counted, by length and in all. */
static void add_up(const chains *c, chain_result *result)
{
    for (uint32_t i = 0; i < c->count; ++i) {
        chain_length *length = &result->lengths[c->starts[i].length];
        length->chains += 1;
        length->brightness = c->starts[i].brightness;
    }
    for (size_t i = 0; i < (size_t)c->job->threads * LENGTHS; ++i) {
        counts_add_chains(&result->lengths[i % LENGTHS].stats, &c->stats[i]);
        counts_add_chains(&result->stats, &c->stats[i]);
    }
}

volgrad_status chains_finish(chains *c, chain_result *result)
{
    volgrad_status status = for_each(c, flush_item, NULL);
    if (status != VOLGRAD_OK) {
        return status;
    }
    result->count = c->count;
    result->mutations_each = c->done;
    result->cpu_seconds = c->cpu_seconds;
    result->scale = (double)c->job->pixel_count / ((double)c->count * (double)c->done);
    add_up(c, result);
    return films_sum(&c->films, &result->film);
}

void chains_free(chains *c)
{
    films_free(&c->films);
    free(c->memory);
    free(c->starts);
    free(c->each);
    free(c->stats);
}
