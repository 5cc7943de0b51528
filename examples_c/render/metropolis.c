#include "metropolis.h"

#include <inttypes.h>
#include <stdio.h>

#include "bootstrap.h"
#include "chains.h"
#include "counts.h"
#include "pace.h"
#include "passes.h"

/* How much of the time, or of the samples, goes to the path sampler: what is left to it is easy, or dim. */
static const double PASSES_SHARE_OF_TIME = 0.15;
enum { MUTATIONS_PER_PASS = 8 };

/* The limits of a job. 0: none. */
typedef struct {
    uint64_t mutations_of_each;
    uint64_t passes;
} targets;

static targets find_targets(const render_job *job, uint32_t chain_count)
{
    uint64_t per_pixel = job->chains->mutations_per_pixel;
    targets t = {.passes = job->max_passes};
    if (chain_count > 0) {
        t.mutations_of_each = (per_pixel * job->pixel_count + chain_count - 1) / chain_count;
    }
    if (t.passes == 0) {
        t.passes = (per_pixel + MUTATIONS_PER_PASS - 1) / MUTATIONS_PER_PASS;
    }
    return t;
}

/* Mutations of each chain in the next round; 0 to stop. */
static uint64_t next_round_size(const chains *c, uint64_t target)
{
    double seconds_left = render_seconds_left(c->job);
    if (c->done > 0 && (seconds_left <= 0.0 || (target > 0 && c->done >= target))) {
        return 0;
    }
    uint64_t size = pace_next(c->done, c->seconds, c->last_size, seconds_left * (1.0 - PASSES_SHARE_OF_TIME));
    return target > 0 && size > target - c->done ? target - c->done : size;
}

/* Passes that should be there now: with a number of mutations, in proportion to those done, so that the image does not depend on the
   machine; else for their share of the time, at least one. */
static uint64_t passes_wanted(const passes *p, const chains *c, targets t)
{
    if (t.mutations_of_each > 0) {
        double share = (double)c->done / (double)t.mutations_of_each;
        uint64_t wanted = (uint64_t)(share * (double)t.passes);
        return c->done >= t.mutations_of_each ? t.passes : wanted > 0 ? wanted : 1;
    }
    double affordable = 1.0;
    if (p->done > 0) {
        affordable = PASSES_SHARE_OF_TIME / (1.0 - PASSES_SHARE_OF_TIME) * c->seconds * (double)p->done / p->seconds;
    }
    uint64_t wanted = affordable > 1.0 ? (uint64_t)affordable : 1;
    return t.passes > 0 && wanted > t.passes ? t.passes : wanted;
}

static volgrad_status run_rounds(chains *c, passes *p)
{
    targets t = find_targets(c->job, c->count);
    volgrad_status status = VOLGRAD_OK;
    uint64_t size;
    while (status == VOLGRAD_OK && (size = next_round_size(c, t.mutations_of_each)) > 0) {
        status = chains_run(c, size);
        uint64_t wanted = passes_wanted(p, c, t);
        if (status == VOLGRAD_OK && wanted > p->done) {
            status = passes_run(p, wanted - p->done);
        }
        render_report(c->job, (double)c->done * (double)c->count / (double)c->job->pixel_count);
    }
    return status;
}

static int run_chains(chains *c, const render_job *job, render_result *result)
{
    passes p;
    int ok = passes_start(&p, job, &result->status);
    p.quiet = 1;
    if (ok) {
        result->status = run_rounds(c, &p);
    }
    if (ok && result->status == VOLGRAD_OK) {
        result->status = chains_finish(c, &result->chains);
    }
    if (ok && result->status == VOLGRAD_OK) {
        result->status = passes_finish(&p, result);
    }
    passes_free(&p);
    return ok;
}

/* What the bootstrap tells, to the result and to the user. */
static void tell(const bootstrap *b, const render_job *job, chain_result *result)
{
    const volgrad_chain_options *options = &job->chains->options;
    char text[160];
    result->bootstrap_samples = b->count;
    result->bootstrap_seconds = b->seconds;
    result->brightness = b->known.brightness;
    result->relative_error = b->known.relative_error;
    for (unsigned i = 0; i < job->threads; ++i) {
        counts_add_chains(&result->bootstrap, &b->stats[i]);
    }
    if (b->known.brightness > 0.0) {
        snprintf(text, sizeof text, "brightness %.5g, known to %.2g %%, from %" PRIu64 " samples in %.2f s", b->known.brightness,
                 100.0 * b->known.relative_error, b->count, b->seconds);
    } else {
        snprintf(text, sizeof text, "%" PRIu64 " samples found no light on paths of %u to %u edges: none in the image", b->count,
                 (unsigned)options->min_length, (unsigned)options->max_length);
    }
    if (job->note != NULL) {
        job->note(job->report_user, text);
    }
}

int metropolis_render(const render_job *job, render_result *result)
{
    bootstrap b;
    chains c = {.count = 0};
    int ok = bootstrap_run(&b, job, &result->status);
    if (ok) {
        tell(&b, job, &result->chains);
        ok = chains_start(&c, job, &b, &result->status);
    }
    bootstrap_free(&b);
    if (ok && c.count > 0) {
        ok = run_chains(&c, job, result);
    } else if (ok) {
        /* Nothing to make chains of: what the path sampler finds is all there is. */
        render_job rest = *job;
        rest.max_passes = find_targets(job, 0).passes;
        ok = passes_render(&rest, result);
    }
    chains_free(&c);
    return ok;
}
