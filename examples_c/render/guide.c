#include "guide.h"

#include <stdlib.h>

#include "counts.h"
#include "seconds.h"
#include "team.h"

/* Guides have 64 x 64 cells for each light. The room with a lamp outside its window (scenes/room.xml) learns well from 50,000 samples;
   of many lights each should get some for every cell. */
static const uint64_t FEWEST_SAMPLES = 50000;
static const uint64_t SAMPLES_PER_CELL = 3;

/* More would need too many samples, and films of more than 3 MB for each thread. */
enum { MOST_LIGHTS = 16 };

/* Of the time limit. */
static const double MOST_OF_TIME = 0.1;

enum { ITEM_PIXELS = 512 };

typedef struct {
    const render_job *job;
    uint32_t width, height; /* of the films */
    uint32_t items_per_pass;
    films films;
    volgrad_path_sampler_stats *stats; /* of each thread */
    double start;
} lesson;

static volgrad_status learn_item(void *user, unsigned worker, uint64_t item)
{
    const lesson *l = user;
    const render_job *job = l->job;
    uint32_t first = (uint32_t)(item % l->items_per_pass) * ITEM_PIXELS;
    uint32_t left = job->pixel_count - first;
    return volgrad_guide_learn(job->scene, job->queries, &job->guide->options, item / l->items_per_pass, first,
                               left < ITEM_PIXELS ? left : ITEM_PIXELS, l->films.each[worker].film, &l->stats[worker]);
}

static int enough(void *user)
{
    const lesson *l = user;
    const render_job *job = l->job;
    return *job->stop || (job->max_seconds > 0.0 && seconds_wall() - l->start >= MOST_OF_TIME * job->max_seconds);
}

static void report(void *user, uint64_t items)
{
    (void)items;
    render_report(((const lesson *)user)->job, 0.0);
}

static uint64_t some_for_each_cell(const lesson *l)
{
    return SAMPLES_PER_CELL * l->width * l->height;
}

static uint64_t count_passes(const lesson *l)
{
    uint64_t wanted = some_for_each_cell(l), pixels = l->job->pixel_count;
    wanted = wanted > FEWEST_SAMPLES ? wanted : FEWEST_SAMPLES;
    return l->job->guide->passes > 0 ? l->job->guide->passes : (wanted + pixels - 1) / pixels;
}

/* *done: as many as wanted, or enough of them. What few samples find is no guide: light would go almost nowhere else. */
static volgrad_status take_samples(lesson *l, guide *g, int *done)
{
    uint64_t items, pixels = l->job->pixel_count;
    l->items_per_pass = (l->job->pixel_count + ITEM_PIXELS - 1) / ITEM_PIXELS;
    team_task task = {.threads = l->job->threads,
                      .item_count = count_passes(l) * l->items_per_pass,
                      .user = l,
                      .item = learn_item,
                      .report = report,
                      .enough = enough};
    volgrad_status status = team_run(&task, &items);
    g->samples = items / l->items_per_pass * pixels + items % l->items_per_pass * ITEM_PIXELS;
    for (unsigned i = 0; i < l->job->threads; ++i) {
        counts_add_paths(&g->stats, &l->stats[i]);
    }
    *done = items == task.item_count || g->samples >= some_for_each_cell(l);
    return status;
}

static volgrad_status find_brightness(const lesson *l, guide *g, const volgrad_film *film)
{
    size_t pixels = (size_t)l->width * l->height;
    float *rgb = malloc(3 * pixels * sizeof *rgb);
    if (rgb == NULL) {
        return VOLGRAD_OK; /* nothing is left to chance then */
    }
    volgrad_status status = volgrad_film_develop(film, 1.0 / (double)g->samples, rgb, 3 * pixels);
    for (size_t i = 0; status == VOLGRAD_OK && i < pixels; ++i) {
        g->brightness += 0.2126 * rgb[3 * i] + 0.7152 * rgb[3 * i + 1] + 0.0722 * rgb[3 * i + 2];
    }
    free(rgb);
    return status;
}

/* Puts a scene that is guided by `film` into the guide's memory. */
static volgrad_status make_scene(guide *g, const render_job *job, volgrad_film *film)
{
    size_t bytes;
    volgrad_status status = volgrad_guide_size(job->scene, &bytes);
    if (status != VOLGRAD_OK) {
        return status;
    }
    g->memory = aligned_memory(bytes);
    return g->memory != NULL ? volgrad_guide_init(g->memory, bytes, job->scene, film, &g->scene) : VOLGRAD_OK;
}

static int learn(lesson *l, guide *g, volgrad_status *status)
{
    owned_film sum = {.memory = NULL};
    l->stats = counts_of_paths(l->job->threads);
    if (!films_make(&l->films, l->job->threads, l->width, l->height, status) || l->stats == NULL) {
        return 0;
    }
    int done = 0;
    *status = take_samples(l, g, &done);
    if (*status == VOLGRAD_OK && !done) {
        g->samples = 0;
        return 1;
    }
    if (*status == VOLGRAD_OK) {
        *status = films_sum(&l->films, &sum);
    }
    if (*status == VOLGRAD_OK) {
        *status = find_brightness(l, g, sum.film);
    }
    g->film = sum;
    if (*status == VOLGRAD_OK) {
        *status = volgrad_film_size(l->width, l->height, &g->film_bytes);
    }
    if (*status == VOLGRAD_OK) {
        *status = make_scene(g, l->job, sum.film);
    }
    return *status == VOLGRAD_OK && g->memory != NULL;
}

/* Whether the scene has lights, and so few that guides are of use. */
static int find_size(lesson *l)
{
    return volgrad_guide_film_size(l->job->scene, &l->width, &l->height) == VOLGRAD_OK &&
           l->height <= MOST_LIGHTS * l->width; /* a square of cells for each */
}

int guide_learn(guide *g, const render_job *job, volgrad_status *status)
{
    lesson l = {.job = job, .start = seconds_wall()};
    *g = (guide){.scene = job->scene};
    *status = VOLGRAD_OK;
    if (job->guide == NULL || !find_size(&l)) {
        return 1;
    }
    int ok = learn(&l, g, status);
    films_free(&l.films);
    free(l.stats);
    g->seconds = seconds_wall() - l.start;
    return ok;
}

void guide_free(guide *g)
{
    free(g->film.memory);
    free(g->memory);
}
