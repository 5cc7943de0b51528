#include "bootstrap.h"

#include <math.h>
#include <stdlib.h>

#include "counts.h"
#include "seconds.h"
#include "team.h"

/* It makes the whole image too bright or too dark by as much, so it should stay below what one sees. */
static const double GOOD_RELATIVE_ERROR = 0.003;

/* Of the time limit. */
static const double MOST_OF_TIME = 0.1;

/* Samples are doubled from the first number on, so that how many there are depends on their values, not on the machine. */
static const uint64_t FIRST_COUNT = 1u << 13;
static const uint64_t MOST = 1u << 27; /* half a gigabyte */

/* Without a time limit: mutations for each sample. */
static const uint64_t FEWEST_MUTATIONS = 2;

enum { ITEM_SAMPLES = 256 };

/* Samples beside those that tell how often to try which technique, and most of these. */
static const uint64_t SAMPLES_PER_LEARNING = 4;
static const uint64_t MOST_LEARNING = 1u << 17;
static const double LEARNING_SHARE_OF_TIME = 0.25; /* of the bootstrap's */

/* ---- one batch on all threads ---- */

typedef struct {
    const render_job *job;
    const volgrad_chain_options *options;
    const volgrad_chain_techniques *techniques; /* NULL: all alike */
    float *weights;                             /* of all samples */
    volgrad_chain_stats *stats;                 /* of each thread */
    uint64_t first, end;
    double until;   /* on the wall's clock; INFINITY: no limit */
    int at_least;   /* is made whole */
} batch;

static volgrad_status sample_item(void *user, unsigned worker, uint64_t item)
{
    const batch *t = user;
    uint64_t first = t->first + item * ITEM_SAMPLES;
    uint64_t left = t->end - first;
    return volgrad_chain_bootstrap(t->job->scene, t->job->queries, t->options, t->techniques, first,
                                   left < ITEM_SAMPLES ? (uint32_t)left : ITEM_SAMPLES, t->weights + first, &t->stats[worker]);
}

static int time_is_up(const render_job *job, double until)
{
    return *job->stop || seconds_wall() >= until;
}

static int enough(void *user)
{
    const batch *t = user;
    return !t->at_least && time_is_up(t->job, t->until);
}

static void report(void *user, uint64_t items)
{
    const batch *t = user;
    (void)items;
    render_report(t->job, 0.0);
}

/* *reached: where it stopped, t->end or before. */
static volgrad_status run_batch(batch *t, uint64_t *reached)
{
    team_task task = {.threads = t->job->threads,
                      .item_count = (t->end - t->first + ITEM_SAMPLES - 1) / ITEM_SAMPLES,
                      .user = t,
                      .item = sample_item,
                      .report = report,
                      .enough = enough};
    uint64_t items;
    volgrad_status status = team_run(&task, &items);
    uint64_t end = t->first + items * ITEM_SAMPLES;
    *reached = end < t->end ? end : t->end;
    return status;
}

/* ---- how many ---- */

/* When a share of the time that the bootstrap may take is over. */
static double time_of(const bootstrap *b, double share)
{
    int limited = b->job->chains->bootstrap == 0 && b->job->max_seconds > 0.0;
    return limited ? b->start + share * MOST_OF_TIME * b->job->max_seconds : INFINITY;
}

static uint64_t most_samples(const render_job *job)
{
    uint64_t most = job->chains->mutations_per_pixel * job->pixel_count / FEWEST_MUTATIONS;
    if (job->chains->bootstrap > 0) {
        return job->chains->bootstrap;
    }
    return job->max_seconds > 0.0 || most > MOST ? MOST : most;
}

/* Samples in all after the next batch; the same as now to stop. */
static uint64_t next_count(const bootstrap *b)
{
    uint64_t most = most_samples(b->job);
    if (b->job->chains->bootstrap > 0) {
        return most;
    }
    if (b->count == 0) {
        return FIRST_COUNT;
    }
    int good = b->known.brightness > 0.0 && b->known.relative_error <= GOOD_RELATIVE_ERROR;
    if (good || b->count >= most || time_is_up(b->job, time_of(b, 1.0))) {
        return b->count;
    }
    return 2 * b->count < most ? 2 * b->count : most;
}

/* ---- all of it ---- */

/* Learns how often to try which technique. */
static volgrad_status learn(bootstrap *b)
{
    const render_job *job = b->job;
    uint64_t wanted = most_samples(job) / SAMPLES_PER_LEARNING, count;
    /* Other random numbers than those of the samples that follow, which would not be independent of their techniques otherwise. */
    volgrad_chain_options options = job->chains->options;
    options.seed = ~options.seed;
    batch t = {.job = job,
               .options = &options,
               .weights = b->weights,
               .stats = b->stats,
               .end = wanted < MOST_LEARNING ? wanted : MOST_LEARNING,
               .until = time_of(b, LEARNING_SHARE_OF_TIME)};
    volgrad_status status = run_batch(&t, &count);
    return status == VOLGRAD_OK ? volgrad_chain_learn(&options, b->weights, count, &b->techniques) : status;
}

static volgrad_status run_samples(bootstrap *b, uint64_t end)
{
    batch t = {.job = b->job,
               .options = &b->job->chains->options,
               .techniques = &b->techniques,
               .weights = b->weights,
               .stats = b->stats,
               .first = b->count,
               .end = end,
               .until = time_of(b, 1.0),
               .at_least = b->count == 0}; /* there is nothing to begin with otherwise */
    volgrad_status status = run_batch(&t, &b->count);
    return status == VOLGRAD_OK ? volgrad_chain_plan(t.options, t.techniques, b->weights, b->count, 1, NULL, 0, &b->known) : status;
}

static int make_room(bootstrap *b, uint64_t count)
{
    float *more = realloc(b->weights, count * sizeof *more);
    b->weights = more != NULL ? more : b->weights;
    return more != NULL;
}

int bootstrap_run(bootstrap *b, const render_job *job, volgrad_status *status)
{
    uint64_t end, asked = 0;
    *b = (bootstrap){.job = job, .start = seconds_wall(), .known = {.struct_size = sizeof b->known}};
    b->stats = counts_of_chains(job->threads);
    if (b->stats == NULL || !make_room(b, MOST_LEARNING)) {
        *status = VOLGRAD_OK;
        return 0;
    }
    *status = learn(b);
    /* After a batch that was cut short the next one would end where that one should have. */
    while (*status == VOLGRAD_OK && b->count == asked && (end = next_count(b)) > b->count) {
        if (!make_room(b, end)) {
            return 0;
        }
        asked = end;
        *status = run_samples(b, end);
    }
    b->seconds = seconds_wall() - b->start;
    return *status == VOLGRAD_OK;
}

void bootstrap_free(bootstrap *b)
{
    free(b->weights);
    free(b->stats);
}
