#include "ways.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "passes.h"
#include "seconds.h"

/* Of each way: their difference tells its error. */
enum { TRIALS = 2 };

/* Their numbers are neither the image's nor those that guides have learned from, which are of ~seed. */
static const uint64_t TRIAL_SEED = 0x9e3779b97f4a7c15u;

/* Rays are counted, and a tile that two blocks share is traced for both: blocks must not depend on the threads. */
enum { BLOCK_PIXELS = 256 };

/* What a way renders first: one block of pixels in each stride, somewhere, so that blocks do not lie below each other. */
enum { SAMPLE_PIXELS = 64, SAMPLE_STRIDE = 7 * SAMPLE_PIXELS, SAMPLE_JITTER = 239, FEWEST_BLOCKS = 4 };

/* What a way costs over the first one, where there is no sample. */
static const double USUAL_COST = 4.0;

/* Times what a sample of a bidirectional way tells: guided subpaths meet more. */
static const double GUIDED_COST = 3.0;

/* With fewer, trials would take longer than the image. */
enum { FEWEST_PASSES = 32 };

/* Of the work, or of the time limit, that trials may take. */
static const double MOST_FOR_TRIALS = 0.15;

/* The pixels' brightness, over which errors count, is known well enough only from this many together, along each side. */
enum { BLOCK = 8 };

/* Of the image's brightness: where it is darker than that errors count no more. */
static const double DARK = 1e-3;

/* What is known of a way. */
typedef struct {
    double part;   /* of the pixels, that its trials have rendered; 0: it has not been tried */
    double cost;   /* of whole trials, in rays; 0: not known */
    double errors; /* of whole passes; 0: not known */
} standing;

typedef struct {
    const render_job *job;
    const guide *guide;
    size_t values; /* of an image */
    float *images; /* of each way TRIALS */
    uint64_t rays; /* of all trials */
    standing ways[MOST_WAYS];
    unsigned best;
} contest;

const volgrad_bidirectional_options *ways_guided(const way *w, const guide *g, volgrad_bidirectional_options *out)
{
    if (w->bidirectional == NULL) {
        return NULL;
    }
    *out = *w->bidirectional;
    out->roulette = (float)fmin(w->roulette * g->brightness, FLT_MAX);
    return out;
}

/* ---- the trials ---- */

static float *image_of(const contest *c, unsigned way, unsigned trial)
{
    return c->images + (way * TRIALS + trial) * c->values;
}

static uint32_t blocks_of_sample(const render_job *job)
{
    return job->pixel_count / SAMPLE_STRIDE;
}

/* Sets the blocks of a pass, all of them or a sample; returns the part of the pixels in them. */
static double set_blocks(passes *p, int is_sample)
{
    p->block_pixels = is_sample ? SAMPLE_PIXELS : BLOCK_PIXELS;
    p->block_stride = is_sample ? SAMPLE_STRIDE : BLOCK_PIXELS;
    p->block_jitter = is_sample ? SAMPLE_JITTER : 0;
    p->blocks_per_pass = is_sample ? blocks_of_sample(p->job) : (p->job->pixel_count + BLOCK_PIXELS - 1) / BLOCK_PIXELS;
    return is_sample ? (double)p->blocks_per_pass * SAMPLE_PIXELS / p->job->pixel_count : 1.0;
}

/* A pass of its own, or a sample of its blocks. Returns 0 on a failure, as ways_choose. */
static int try_once(contest *c, unsigned index, unsigned trial, int is_sample, volgrad_status *status)
{
    double part = 1.0;
    const way *way = &c->job->ways[index];
    volgrad_path_sampler_options sampler = *way->sampler;
    volgrad_bidirectional_options bidirectional = {.struct_size = 0};
    render_job job = *c->job;
    passes p;
    render_result result = {.stats = {.struct_size = sizeof result.stats}};
    sampler.seed ^= TRIAL_SEED;
    job.scene = c->guide->scene;
    job.sampler = &sampler;
    job.bidirectional = ways_guided(way, c->guide, &bidirectional);
    bidirectional.seed = sampler.seed;
    int ok = passes_start(&p, &job, status);
    if (ok) {
        p.quiet = 1;
        p.done = trial;
        part = set_blocks(&p, is_sample);
        *status = passes_run(&p, 1);
    }
    if (ok && *status == VOLGRAD_OK) {
        *status = passes_finish(&p, &result);
    }
    if (ok && *status == VOLGRAD_OK) {
        *status = volgrad_film_develop(result.film.film, 1.0, image_of(c, index, trial), c->values);
        uint64_t rays = result.stats.rays + result.stats.occlusion_rays;
        c->ways[index].cost += (double)rays / part;
        c->ways[index].part = part;
        c->rays += rays;
    }
    passes_free(&p);
    render_result_free(&result);
    return ok && *status == VOLGRAD_OK;
}

/* ---- their errors ---- */

/* Mean of a way's images in a block. */
static double brightness_of(const contest *c, unsigned way, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1)
{
    double sum = 0.0;
    for (unsigned trial = 0; trial < TRIALS; ++trial) {
        for (uint32_t y = y0; y < y1; ++y) {
            const float *row = image_of(c, way, trial) + 3 * ((size_t)y * c->job->width + x0);
            for (uint32_t k = 0; k < 3 * (x1 - x0); ++k) {
                sum += row[k];
            }
        }
    }
    return sum / (3.0 * (x1 - x0) * (y1 - y0) * TRIALS);
}

/* Of a block: the mean of whole images, but no less than what a sample holds of it, which may show light that the others hardly ever find. */
static double brightness(const contest *c, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1)
{
    double whole = 0.0, sample = 0.0;
    unsigned count = 0;
    for (unsigned i = 0; i < c->job->way_count; ++i) {
        double part = c->ways[i].part;
        double mean = part > 0.0 ? brightness_of(c, i, x0, y0, x1, y1) : 0.0;
        if (part == 1.0) {
            whole += mean;
            count++;
        } else {
            sample = fmax(sample, mean);
        }
    }
    return fmax(whole / count, sample);
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

/* Relative squared error of each way, up to a common factor. What a sample of blocks makes is a part of all, and so is its variance, wherever
   in the image it is: what subpaths from lights show the camera is everywhere. */
static void find_errors(contest *c)
{
    const uint32_t *crop = c->job->crop;
    double dark = DARK * brightness(c, crop[0], crop[1], crop[2], crop[3]);
    for (unsigned i = 0; i < c->job->way_count; ++i) {
        c->ways[i].errors = 0.0;
    }
    for (uint32_t y = crop[1]; y < crop[3]; y += BLOCK) {
        for (uint32_t x = crop[0]; x < crop[2]; x += BLOCK) {
            uint32_t x1 = least(x + BLOCK, crop[2]), y1 = least(y + BLOCK, crop[3]);
            double mean = brightness(c, x, y, x1, y1);
            double scale = mean * mean + dark * dark;
            for (unsigned i = 0; i < c->job->way_count && scale > 0.0; ++i) {
                double part = c->ways[i].part;
                c->ways[i].errors += part > 0.0 ? squared_difference(c, i, x, y, x1, y1) / (scale * part) : 0.0;
                if (part == 1.0 && brightness_of(c, i, x, y, x1, y1) == 0.0) {
                    c->ways[i].errors += TRIALS * mean * mean * 3.0 * (x1 - x) * (y1 - y) / scale; /* others see light there */
                }
            }
        }
    }
}

/* ---- the choice ---- */

/* Of whole trials. Not known of bidirectional ways with shifts: about that of all others. */
static double cost(const contest *c, unsigned way)
{
    double others = 0.0;
    for (unsigned i = 1; i < c->job->way_count; ++i) {
        others += c->ways[i].cost;
    }
    return c->ways[way].cost > 0.0 ? c->ways[way].cost : fmax(others, USUAL_COST * c->ways[0].cost);
}

static double work(const contest *c, unsigned way)
{
    return c->ways[way].errors * cost(c, way);
}

static void find_best(contest *c)
{
    find_errors(c);
    c->best = 0;
    for (unsigned i = 1; i < c->job->way_count; ++i) {
        c->best = c->ways[i].part > 0.0 && work(c, i) < work(c, c->best) ? i : c->best;
    }
}

static int is_out_of_time(const contest *c)
{
    const render_job *job = c->job;
    return *job->stop || (job->max_seconds > 0.0 && seconds_wall() - job->start - c->guide->seconds >= MOST_FOR_TRIALS * job->max_seconds);
}

/* Returns 0 on a failure, as ways_choose. */
static int try_way(contest *c, unsigned index, int is_sample, volgrad_status *status)
{
    c->ways[index] = (standing){.part = 0.0};
    for (unsigned trial = 0; trial < TRIALS; ++trial) {
        if (trial > 0 && is_out_of_time(c)) {
            c->ways[index] = (standing){.part = 0.0}; /* one trial alone tells nothing of a way */
            return 1;
        }
        if (!try_once(c, index, trial, is_sample, status)) {
            return 0;
        }
        render_report(c->job, 0.0);
    }
    find_best(c);
    return 1;
}

/* What a way costs, by a sample. */
static int try_cost(contest *c, unsigned index, volgrad_status *status)
{
    int ok = try_once(c, index, 0, 1, status);
    c->ways[index] = (standing){.cost = TRIALS * c->ways[index].cost};
    return ok;
}

static int is_bidirectional(const contest *c, unsigned way)
{
    return c->job->ways[way].bidirectional != NULL;
}

/* The best way's work over this one's, or over that of ways alike; 1 if none of these has been tried. */
static double promise(const contest *c, unsigned way)
{
    double found = 0.0;
    for (unsigned i = 0; i < c->job->way_count; ++i) {
        if (c->ways[i].part > 0.0 && (i == way || (is_bidirectional(c, i) && is_bidirectional(c, way)))) {
            found = fmax(found, work(c, c->best) / work(c, i));
        }
    }
    return found > 0.0 ? found : 1.0;
}

/* Rays that trials may take. */
static double limit(const contest *c)
{
    const render_job *job = c->job;
    double rays = INFINITY, seconds = seconds_wall() - job->start - c->guide->seconds;
    if (job->max_passes > 0) {
        rays = MOST_FOR_TRIALS * (double)job->max_passes * cost(c, c->best) / TRIALS;
    }
    if (job->max_seconds > 0.0) {
        rays = fmin(rays, MOST_FOR_TRIALS * job->max_seconds / seconds * (double)c->rays);
    }
    return *job->stop ? 0.0 : rays;
}

/* Whether whole trials of a way are worth their cost: the better it looks, the more they may take. */
static int is_worth_it(const contest *c, unsigned way)
{
    if (!(work(c, c->best) > 0.0)) {
        return 0; /* nothing to gain */
    }
    double more = cost(c, way) * (is_bidirectional(c, way) && c->guide->samples == 0 ? GUIDED_COST : 1.0);
    return more <= promise(c, way) * limit(c) && (double)c->rays + more <= limit(c);
}

/* Samples of all but the first way, which is known, and bidirectional ways with shifts, which are slow without guides. Tiles lie elsewhere
   in each pass: what a sample of them holds differs too much to tell more than its cost. Returns 0 on a failure, as ways_choose. */
static int try_samples(contest *c, volgrad_status *status)
{
    for (unsigned i = 1; i < c->job->way_count && blocks_of_sample(c->job) >= FEWEST_BLOCKS; ++i) {
        int shifts = c->job->ways[i].sampler->shift.mode != VOLGRAD_SHIFT_NONE;
        if ((is_bidirectional(c, i) && shifts) || (double)c->rays >= limit(c)) {
            continue;
        }
        if (!(shifts ? try_cost(c, i, status) : try_way(c, i, 1, status))) {
            return 0;
        }
    }
    return 1;
}

/* Whether a way that they help is the best, or will be tried with them. */
static int are_guides_worth_it(const contest *c)
{
    int wanted = is_bidirectional(c, c->best);
    for (unsigned i = 0; i < c->job->way_count; ++i) {
        wanted = wanted || (is_bidirectional(c, i) && is_worth_it(c, i));
    }
    return wanted;
}

/* Returns 0 on a failure, as ways_choose. */
static int hold(contest *c, guide *g, volgrad_status *status)
{
    if (!try_way(c, 0, 0, status)) {
        return 0;
    }
    if (c->ways[0].part == 0.0) {
        return 1; /* there is no time for trials */
    }
    if (!try_samples(c, status) || (are_guides_worth_it(c) && !guide_learn(g, c->job, status))) {
        return 0;
    }
    for (unsigned i = 1; i < c->job->way_count; ++i) {
        if (is_worth_it(c, i) && !try_way(c, i, 0, status)) {
            return 0;
        }
    }
    return 1;
}

int ways_are_worth_trying(const render_job *job)
{
    return job->max_passes == 0 || job->max_passes >= FEWEST_PASSES;
}

int ways_choose(const render_job *job, guide *g, render_result *result)
{
    contest c = {.job = job, .guide = g, .values = 3 * (size_t)job->width * job->height};
    c.images = malloc(job->way_count * TRIALS * c.values * sizeof *c.images);
    /* Without memory for the trials: the first way. */
    double start = seconds_wall();
    int ok = c.images == NULL || hold(&c, g, &result->status);
    free(c.images);
    result->way = c.best;
    result->trial_rays = c.rays;
    result->trial_seconds = seconds_wall() - start - g->seconds;
    if (ok && job->note != NULL) {
        job->note(job->report_user, job->ways[c.best].name);
    }
    return ok;
}
