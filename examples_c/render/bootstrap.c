#include "bootstrap.h"

#include <stdlib.h>

#include "seconds.h"
#include "team.h"

/* It makes the whole image too bright or too dark by as much, so it should stay below what one sees. */
static const double GOOD_RELATIVE_ERROR = 0.003;

/* Of the time limit. */
static const double MOST_OF_TIME = 0.1;

/* Samples are doubled from the first number on, so that how many there are depends on their values, not on the machine. */
static const uint64_t FIRST_COUNT = 1u << 13;
static const uint64_t MOST_WITHOUT_TIME_LIMIT = 1u << 20;
static const uint64_t MOST = 1u << 27; /* half a gigabyte */

enum { ITEM_SAMPLES = 256 };

/* One batch: the samples from b->count on, up to `end`. */
typedef struct {
    bootstrap *b;
    uint64_t end;
} batch;

static volgrad_status sample_item(void *user, unsigned worker, uint64_t item)
{
    const batch *t = user;
    const render_job *job = t->b->job;
    uint64_t first = t->b->count + item * ITEM_SAMPLES;
    uint64_t left = t->end - first;
    (void)worker;
    return volgrad_chain_bootstrap(job->scene, job->queries, &job->chains->options, first,
                                   left < ITEM_SAMPLES ? (uint32_t)left : ITEM_SAMPLES, t->b->weights + first);
}

static int time_is_up(const render_job *job)
{
    double limit = MOST_OF_TIME * job->max_seconds;
    return *job->stop || (job->chains->bootstrap == 0 && job->max_seconds > 0.0 && seconds_wall() - job->start >= limit);
}

/* The first batch is always whole: there is nothing to begin with otherwise. */
static int enough(void *user)
{
    const batch *t = user;
    return t->b->count > 0 && time_is_up(t->b->job);
}

static void report(void *user, uint64_t items)
{
    const batch *t = user;
    (void)items;
    render_report(t->b->job, 0.0);
}

/* Samples in all after the next batch; the same as now to stop. */
static uint64_t next_count(const bootstrap *b)
{
    const chain_settings *settings = b->job->chains;
    if (settings->bootstrap > 0) {
        return settings->bootstrap;
    }
    uint64_t most = b->job->max_seconds > 0.0 ? MOST : MOST_WITHOUT_TIME_LIMIT;
    int good = b->known.brightness > 0.0 && b->known.relative_error <= GOOD_RELATIVE_ERROR;
    if (good || b->count >= most || (b->count > 0 && time_is_up(b->job))) {
        return b->count;
    }
    return b->count > 0 ? 2 * b->count : FIRST_COUNT;
}

static volgrad_status run_batch(bootstrap *b, uint64_t end)
{
    batch t = {.b = b, .end = end};
    team_task task = {.threads = b->job->threads,
                      .item_count = (end - b->count + ITEM_SAMPLES - 1) / ITEM_SAMPLES,
                      .user = &t,
                      .item = sample_item,
                      .report = report,
                      .enough = enough};
    uint64_t items;
    volgrad_status status = team_run(&task, &items);
    if (status != VOLGRAD_OK) {
        return status;
    }
    uint64_t reached = b->count + items * ITEM_SAMPLES;
    b->count = reached < end ? reached : end;
    return volgrad_chain_plan(&b->job->chains->options, b->weights, b->count, 1, NULL, 0, &b->known);
}

int bootstrap_run(bootstrap *b, const render_job *job, volgrad_status *status)
{
    double start = seconds_wall();
    uint64_t end, asked = 0;
    *b = (bootstrap){.job = job, .known = {.struct_size = sizeof b->known}};
    *status = VOLGRAD_OK;
    /* After a batch that was cut short the next one would end where that one should have. */
    while (*status == VOLGRAD_OK && b->count == asked && (end = next_count(b)) > b->count) {
        float *more = realloc(b->weights, end * sizeof *more);
        if (more == NULL) {
            return 0;
        }
        b->weights = more;
        asked = end;
        *status = run_batch(b, end);
    }
    b->seconds = seconds_wall() - start;
    return *status == VOLGRAD_OK;
}

void bootstrap_free(bootstrap *b)
{
    free(b->weights);
}
