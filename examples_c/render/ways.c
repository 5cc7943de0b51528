#include "ways.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes.h"
#include "seconds.h"

/* Of each way: their difference tells its error. */
enum { TRIALS = 2 };

/* Their numbers are neither the image's nor those that guides have learned from, which are of ~seed. */
static const uint64_t TRIAL_SEED = 0x9e3779b97f4a7c15u;

/* Rays are counted, and a tile that two blocks share is traced for both: blocks must not depend on the threads. */
enum { BLOCK_PIXELS = 256 };

/* With fewer, trials would take longer than the image. */
enum { FEWEST_PASSES = 32 };

/* Of the work, or of the time limit: trials end once they have taken more. The work of two ways is always worth it: they may be 20 times
   apart. */
static const double MOST_FOR_TRIALS = 0.15;

/* The pixels' brightness, over which errors count, is known well enough only from this many together, along each side. */
enum { BLOCK = 8 };

/* Of the image's brightness: where it is darker than that errors count no more. */
static const double DARK = 1e-3;

typedef struct {
    const render_job *job;
    size_t values; /* of an image */
    float *images; /* of each way TRIALS */
    uint64_t rays;            /* of all trials */
    unsigned tried;           /* ways, from the first on */
    double cost[MOST_WAYS];   /* of each way's trials, in rays */
    double errors[MOST_WAYS]; /* of each way */
    unsigned best;
} contest;

/* ---- the trials ---- */

static float *image_of(const contest *c, unsigned way, unsigned trial)
{
    return c->images + (way * TRIALS + trial) * c->values;
}

/* A pass of its own. Returns 0 on a failure, as ways_choose. */
static int try_way(contest *c, unsigned index, unsigned trial, volgrad_status *status)
{
    const way *way = &c->job->ways[index];
    volgrad_path_sampler_options sampler = *way->sampler;
    render_job job = *c->job;
    volgrad_bidirectional_options bidirectional;
    passes p;
    render_result result = {.stats = {.struct_size = sizeof result.stats}};
    sampler.seed ^= TRIAL_SEED;
    job.sampler = &sampler;
    job.bidirectional = NULL;
    if (way->bidirectional != NULL) {
        bidirectional = *way->bidirectional;
        bidirectional.seed = sampler.seed;
        job.bidirectional = &bidirectional;
    }
    int ok = passes_start(&p, &job, status);
    if (ok) {
        p.quiet = 1;
        p.done = trial;
        p.block_pixels = BLOCK_PIXELS;
        p.blocks_per_pass = (job.pixel_count + BLOCK_PIXELS - 1) / BLOCK_PIXELS;
        *status = passes_run(&p, 1);
    }
    if (ok && *status == VOLGRAD_OK) {
        *status = passes_finish(&p, &result);
    }
    if (ok && *status == VOLGRAD_OK) {
        *status = volgrad_film_develop(result.film.film, 1.0, image_of(c, index, trial), c->values);
        uint64_t rays = result.stats.rays + result.stats.occlusion_rays;
        c->cost[index] += (double)rays;
        c->rays += rays;
    }
    passes_free(&p);
    render_result_free(&result);
    return ok && *status == VOLGRAD_OK;
}

/* ---- their errors ---- */

/* Mean of all images in a block. */
static double brightness(const contest *c, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1)
{
    double sum = 0.0;
    for (unsigned i = 0; i < c->tried * TRIALS; ++i) {
        for (uint32_t y = y0; y < y1; ++y) {
            const float *row = c->images + i * c->values + 3 * ((size_t)y * c->job->width + x0);
            for (uint32_t k = 0; k < 3 * (x1 - x0); ++k) {
                sum += row[k];
            }
        }
    }
    return sum / (3.0 * (x1 - x0) * (y1 - y0) * c->tried * TRIALS);
}

static double squared_difference(const contest *c, unsigned way, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1)
{
    double sum = 0.0;
    for (uint32_t y = y0; y < y1; ++y) {
        size_t start = 3 * ((size_t)y * c->job->width + x0);
        const float *a = image_of(c, way, 0) + start, *b = image_of(c, way, 1) + start;
        for (uint32_t k = 0; k < 3 * (x1 - x0); ++k) {
            sum += ((double)a[k] - b[k]) * ((double)a[k] - b[k]);
        }
    }
    return sum;
}

static uint32_t least(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

/* Relative squared error of each way, up to a common factor. */
static void find_errors(contest *c)
{
    uint32_t width = c->job->width, height = c->job->height;
    double dark = DARK * brightness(c, 0, 0, width, height);
    memset(c->errors, 0, sizeof c->errors);
    for (uint32_t y = 0; y < height; y += BLOCK) {
        for (uint32_t x = 0; x < width; x += BLOCK) {
            uint32_t x1 = least(x + BLOCK, width), y1 = least(y + BLOCK, height);
            double mean = brightness(c, x, y, x1, y1);
            double scale = mean * mean + dark * dark;
            for (unsigned i = 0; i < c->tried && scale > 0.0; ++i) {
                c->errors[i] += squared_difference(c, i, x, y, x1, y1) / scale;
            }
        }
    }
}

/* ---- the choice ---- */

int ways_are_worth_trying(const render_job *job)
{
    return job->max_passes == 0 || job->max_passes >= FEWEST_PASSES;
}

static double work(const contest *c, unsigned way)
{
    return c->errors[way] * c->cost[way];
}

static void find_best(contest *c)
{
    find_errors(c);
    c->best = 0;
    for (unsigned i = 1; i < c->tried; ++i) {
        c->best = work(c, i) < work(c, c->best) ? i : c->best;
    }
}

static int have_cost_enough(const contest *c)
{
    const render_job *job = c->job;
    if (render_seconds_left(job) <= (1.0 - MOST_FOR_TRIALS) * job->max_seconds) {
        return 1;
    }
    return job->max_passes > 0 && c->tried > 1 && (double)c->rays > MOST_FOR_TRIALS * (double)job->max_passes * c->cost[c->best] / TRIALS;
}

/* Returns 0 on a failure, as ways_choose. */
static int hold(contest *c, volgrad_status *status)
{
    while (c->tried < c->job->way_count) {
        for (unsigned trial = 0; trial < TRIALS; ++trial) {
            if (*c->job->stop || (c->tried > 0 && have_cost_enough(c))) {
                return 1; /* one trial alone tells nothing of a way */
            }
            if (!try_way(c, c->tried, trial, status)) {
                return 0;
            }
            render_report(c->job, 0.0);
        }
        c->tried++;
        find_best(c);
    }
    return 1;
}

int ways_choose(const render_job *job, render_result *result)
{
    if (job->way_count == 1) {
        return 1;
    }
    contest c = {.job = job, .values = 3 * (size_t)job->width * job->height};
    c.images = malloc(job->way_count * TRIALS * c.values * sizeof *c.images);
    /* Without memory for the trials: the first way. */
    double start = seconds_wall();
    int ok = c.images == NULL || hold(&c, &result->status);
    free(c.images);
    result->way = c.best;
    result->trial_rays = c.rays;
    result->trial_seconds = seconds_wall() - start;
    if (ok && job->note != NULL) {
        job->note(job->report_user, job->ways[c.best].name);
    }
    return ok;
}
