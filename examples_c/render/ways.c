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

/* Rows of a stripe, and one stripe of how many a way renders first. */
enum { STRIPE_ROWS = 4, STRIPES = 8 };

/* Times the best work: a way whose stripes take more is not tried further. Guides and roulette, which stripes are rendered without, gain
   less. */
static const double HOPELESS = 4.0;

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
    double rays;   /* that they took */
    double errors; /* of whole passes */
    int hopeless;
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

static uint32_t blocks_of(uint32_t first, uint32_t stride, uint32_t pixels)
{
    return first < pixels ? (pixels - first + stride - 1) / stride : 0;
}

/* Blocks next to each other, or stripes. Returns the part of the pixels in them, 0 for stripes of an image that has too few. */
static double set_blocks(passes *p, int in_stripes)
{
    uint32_t pixels = p->job->pixel_count, rows = STRIPE_ROWS * p->job->width;
    p->block_pixels = in_stripes ? rows : BLOCK_PIXELS;
    p->block_stride = in_stripes ? STRIPES * rows : BLOCK_PIXELS;
    p->first_pixel = in_stripes ? STRIPES / 2 * rows : 0;
    p->blocks_per_pass = blocks_of(p->first_pixel, p->block_stride, pixels);
    if (!in_stripes || p->blocks_per_pass == 0) {
        return in_stripes ? 0.0 : 1.0;
    }
    uint32_t last = p->first_pixel + (p->blocks_per_pass - 1) * p->block_stride;
    uint32_t size = pixels - last < rows ? pixels - last : rows;
    return ((double)(p->blocks_per_pass - 1) * rows + size) / pixels;
}

/* A pass of its own, or its stripes. Returns 0 on a failure, as ways_choose. */
static int try_once(contest *c, unsigned index, unsigned trial, int in_stripes, volgrad_status *status)
{
    const way *way = &c->job->ways[index];
    volgrad_path_sampler_options sampler = *way->sampler;
    volgrad_bidirectional_options bidirectional;
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
        c->ways[index].part = set_blocks(&p, in_stripes);
        *status = passes_run(&p, 1);
    }
    if (ok && *status == VOLGRAD_OK) {
        *status = passes_finish(&p, &result);
    }
    if (ok && *status == VOLGRAD_OK) {
        *status = volgrad_film_develop(result.film.film, 1.0, image_of(c, index, trial), c->values);
        uint64_t rays = result.stats.rays + result.stats.occlusion_rays;
        c->ways[index].rays += (double)rays;
        c->rays += rays;
    }
    passes_free(&p);
    render_result_free(&result);
    return ok && *status == VOLGRAD_OK;
}

/* ---- their errors ---- */

/* Mean of all whole images in a block. */
static double brightness(const contest *c, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1)
{
    double sum = 0.0;
    unsigned images = 0;
    for (unsigned i = 0; i < c->job->way_count * TRIALS; ++i) {
        int whole = c->ways[i / TRIALS].part == 1.0;
        images += whole;
        for (uint32_t y = y0; whole && y < y1; ++y) {
            const float *row = c->images + i * c->values + 3 * ((size_t)y * c->job->width + x0);
            for (uint32_t k = 0; k < 3 * (x1 - x0); ++k) {
                sum += row[k];
            }
        }
    }
    return sum / (3.0 * (x1 - x0) * (y1 - y0) * images);
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

/* Relative squared error of each way, up to a common factor. The samples of stripes are a part of all, and so is their variance, wherever
   in the image it is: what subpaths from lights show the camera is everywhere. */
static void find_errors(contest *c)
{
    uint32_t width = c->job->width, height = c->job->height;
    double dark = DARK * brightness(c, 0, 0, width, height);
    for (unsigned i = 0; i < c->job->way_count; ++i) {
        c->ways[i].errors = 0.0;
    }
    for (uint32_t y = 0; y < height; y += BLOCK) {
        for (uint32_t x = 0; x < width; x += BLOCK) {
            uint32_t x1 = least(x + BLOCK, width), y1 = least(y + BLOCK, height);
            double mean = brightness(c, x, y, x1, y1);
            double scale = mean * mean + dark * dark;
            for (unsigned i = 0; i < c->job->way_count && scale > 0.0; ++i) {
                double part = c->ways[i].part;
                c->ways[i].errors += part > 0.0 ? squared_difference(c, i, x, y, x1, y1) / (scale * part) : 0.0;
            }
        }
    }
}

/* ---- the choice ---- */

/* Rays of TRIALS whole passes; 0: not known. */
static double cost(const contest *c, unsigned way)
{
    return c->ways[way].part > 0.0 ? c->ways[way].rays / c->ways[way].part : 0.0;
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

/* Whether trials with so many rays more would cost too much. */
static int is_too_much(const contest *c, double rays)
{
    const render_job *job = c->job;
    double all = (double)c->rays + rays, seconds = seconds_wall() - job->start;
    if (*job->stop || (job->max_seconds > 0.0 && seconds * all > MOST_FOR_TRIALS * job->max_seconds * (double)c->rays)) {
        return 1;
    }
    return job->max_passes > 0 && all > MOST_FOR_TRIALS * (double)job->max_passes * cost(c, c->best) / TRIALS;
}

/* Returns 0 on a failure, as ways_choose. */
static int try_way(contest *c, unsigned index, int in_stripes, volgrad_status *status)
{
    c->ways[index].rays = 0.0;
    for (unsigned trial = 0; trial < TRIALS; ++trial) {
        if (!try_once(c, index, trial, in_stripes, status)) {
            return 0;
        }
        render_report(c->job, 0.0);
    }
    find_best(c);
    return 1;
}

static int is_bidirectional(const contest *c, unsigned way)
{
    return c->job->ways[way].bidirectional != NULL;
}

/* Stripes of all but the first way, which is known, as long as they are not too much. Bidirectional ways with shifts, which are slow
   without guides, are as hopeless as those without. Returns 0 on a failure, as ways_choose. */
static int try_stripes(contest *c, volgrad_status *status)
{
    int hopeless_bidirectional = 0;
    for (unsigned i = 1; i < c->job->way_count; ++i) {
        int shifts = c->job->ways[i].sampler->shift.mode != VOLGRAD_SHIFT_NONE;
        if (is_bidirectional(c, i) && shifts) {
            c->ways[i].hopeless = hopeless_bidirectional;
            continue;
        }
        if (is_too_much(c, 0.0)) {
            break;
        }
        if (!try_way(c, i, 1, status)) {
            return 0;
        }
        c->ways[i].hopeless = c->ways[i].part > 0.0 && work(c, i) > HOPELESS * work(c, 0);
        hopeless_bidirectional = hopeless_bidirectional || (is_bidirectional(c, i) && c->ways[i].hopeless);
    }
    return 1;
}

/* Whether a way that they help may be chosen. */
static int are_guides_worth_it(const contest *c)
{
    int wanted = is_bidirectional(c, c->best);
    for (unsigned i = 0; i < c->job->way_count; ++i) {
        wanted = wanted || (is_bidirectional(c, i) && !c->ways[i].hopeless && !is_too_much(c, 0.0));
    }
    return wanted;
}

/* Returns 0 on a failure, as ways_choose. */
static int hold(contest *c, guide *g, volgrad_status *status)
{
    if (!try_way(c, 0, 0, status) || !try_stripes(c, status) || (are_guides_worth_it(c) && !guide_learn(g, c->job, status))) {
        return 0;
    }
    for (unsigned i = 1; i < c->job->way_count; ++i) {
        if (!c->ways[i].hopeless && !is_too_much(c, cost(c, i)) && !try_way(c, i, 0, status)) {
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
