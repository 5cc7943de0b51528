#define _POSIX_C_SOURCE 200809L /* clock_gettime */

#include "render.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <time.h>

/* Passes that are rendered between two looks at the clock and the signal. Threads wait for each other at its end, so it should
   take a while, but no longer than one likes to wait. */
static const double GROUP_SECONDS = 0.2;

typedef struct {
    const render_job *job;
    uint64_t first_pass;
    uint64_t pass_count;
    uint32_t block_pixels;
    uint32_t blocks_per_pass;
    double start; /* of the rendering, on the wall clock */
    atomic_uint_fast64_t next_item; /* pass * blocks_per_pass + block, counted from first_pass */
    atomic_int status;              /* the first that is not VOLGRAD_OK */
} group;

typedef struct {
    pthread_t thread;
    int is_caller; /* the thread that called render_run: it reports */
    group *group;
    void *film_memory;
    volgrad_film *film;
    volgrad_path_sampler_stats stats;
} worker;

static double seconds_of(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void *render_allocate(size_t bytes)
{
    const size_t alignment = 16;
    if (bytes > SIZE_MAX - alignment) {
        return NULL;
    }
    return aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
}

static void add_stats(volgrad_path_sampler_stats *sum, const volgrad_path_sampler_stats *more)
{
    sum->paths += more->paths;
    sum->rays += more->rays;
    sum->occlusion_rays += more->occlusion_rays;
    sum->shifted_paths += more->shifted_paths;
    sum->shifts += more->shifts;
    sum->stays += more->stays;
    sum->overflows += more->overflows;
}

/* ---- one group of passes ---- */

static volgrad_status render_item(const group *g, uint64_t item, volgrad_film *film, volgrad_path_sampler_stats *stats)
{
    const render_job *job = g->job;
    uint64_t pass = g->first_pass + item / g->blocks_per_pass;
    uint32_t first_pixel = (uint32_t)(item % g->blocks_per_pass) * g->block_pixels;
    uint32_t left = job->pixel_count - first_pixel;
    uint32_t count = left < g->block_pixels ? left : g->block_pixels;
    return volgrad_path_sampler_run(job->scene, job->queries, job->sampler, pass, first_pixel, count, film, stats);
}

static void report(const group *g, uint64_t items_done)
{
    const render_job *job = g->job;
    if (job->report != NULL) {
        double passes = (double)g->first_pass + (double)items_done / (double)g->blocks_per_pass;
        job->report(job->report_user, passes, seconds_of(CLOCK_MONOTONIC) - g->start);
    }
}

static void *work(void *argument)
{
    worker *self = argument;
    group *g = self->group;
    volgrad_path_sampler_stats stats = {.struct_size = sizeof stats}; /* here, so that threads share no cache line */
    const uint64_t item_count = g->pass_count * g->blocks_per_pass;
    for (;;) {
        uint64_t item = atomic_fetch_add(&g->next_item, 1);
        if (item >= item_count || atomic_load(&g->status) != VOLGRAD_OK) {
            break;
        }
        volgrad_status status = render_item(g, item, self->film, &stats);
        if (status != VOLGRAD_OK) {
            int none = VOLGRAD_OK;
            atomic_compare_exchange_strong(&g->status, &none, (int)status);
        } else if (self->is_caller) {
            report(g, item);
        }
    }
    add_stats(&self->stats, &stats);
    return NULL;
}

/* The calling thread is worker 0. If the system refuses a thread, the others do its work. */
static void run_group(worker *workers, unsigned count, group *g)
{
    unsigned started = 1;
    for (unsigned i = 0; i < count; ++i) {
        workers[i].group = g;
    }
    while (started < count && pthread_create(&workers[started].thread, NULL, work, &workers[started]) == 0) {
        started++;
    }
    work(&workers[0]);
    for (unsigned i = 1; i < started; ++i) {
        pthread_join(workers[i].thread, NULL);
    }
}

/* ---- all groups ---- */

/* Small enough for every thread to get some of a single pass, large enough for the counter not to matter. */
static uint32_t block_size(const render_job *job)
{
    const uint32_t blocks_per_thread = 16, smallest = 64, largest = 4096;
    uint32_t size = job->pixel_count / (blocks_per_thread * job->threads);
    return size < smallest ? smallest : size > largest ? largest : size;
}

/* How many passes to render before the next look, from the speed so far; 0 to stop. */
static uint64_t next_group_size(const render_job *job, uint64_t done, uint64_t last_size, double seconds)
{
    const double most_growth = 4.0; /* the first passes are slow, and say little */
    double group_seconds = GROUP_SECONDS;
    if (done == 0) {
        return 1;
    }
    if (*job->stop || (job->max_passes > 0 && done >= job->max_passes) ||
        (job->max_seconds > 0.0 && seconds >= job->max_seconds)) {
        return 0;
    }
    if (job->max_seconds > 0.0 && job->max_seconds - seconds < group_seconds) {
        group_seconds = job->max_seconds - seconds;
    }
    double passes = group_seconds * (double)done / seconds;
    double limit = most_growth * (double)last_size;
    passes = passes < limit ? passes : limit;
    uint64_t size = passes > 1.0 ? (uint64_t)passes : 1;
    return job->max_passes > 0 && size > job->max_passes - done ? job->max_passes - done : size;
}

static volgrad_status render_groups(const render_job *job, worker *workers, render_result *result)
{
    group g = {.job = job, .block_pixels = block_size(job), .start = seconds_of(CLOCK_MONOTONIC)};
    g.blocks_per_pass = (job->pixel_count + g.block_pixels - 1) / g.block_pixels;
    uint64_t size = 1;
    while ((size = next_group_size(job, result->passes, size, result->wall_seconds)) > 0) {
        g.first_pass = result->passes;
        g.pass_count = size;
        atomic_init(&g.next_item, 0);
        atomic_init(&g.status, VOLGRAD_OK);
        run_group(workers, job->threads, &g);
        if (atomic_load(&g.status) != VOLGRAD_OK) {
            return (volgrad_status)atomic_load(&g.status);
        }
        result->passes += size;
        result->wall_seconds = seconds_of(CLOCK_MONOTONIC) - g.start;
        report(&g, size * g.blocks_per_pass);
    }
    return VOLGRAD_OK;
}

/* ---- films ---- */

static volgrad_status make_film(const render_job *job, worker *w)
{
    size_t bytes;
    volgrad_status status = volgrad_film_size(job->width, job->height, &bytes);
    if (status != VOLGRAD_OK) {
        return status;
    }
    w->film_memory = render_allocate(bytes);
    if (w->film_memory == NULL) {
        return VOLGRAD_OK; /* the caller sees that there is no film */
    }
    return volgrad_film_init(w->film_memory, bytes, job->width, job->height, &w->film);
}

/* The sum of all films, in that of the first worker, which passes to the result. */
static volgrad_status collect(worker *workers, unsigned count, render_result *result)
{
    add_stats(&result->stats, &workers[0].stats);
    for (unsigned i = 1; i < count; ++i) {
        volgrad_status status = volgrad_film_merge(workers[0].film, workers[i].film);
        if (status != VOLGRAD_OK) {
            return status;
        }
        add_stats(&result->stats, &workers[i].stats);
    }
    result->film = workers[0].film;
    result->film_memory = workers[0].film_memory;
    workers[0].film_memory = NULL;
    return VOLGRAD_OK;
}

int render_run(const render_job *job, render_result *result)
{
    *result = (render_result){.status = VOLGRAD_OK, .stats = {.struct_size = sizeof result->stats}};
    worker *workers = calloc(job->threads, sizeof *workers);
    int ok = workers != NULL;
    for (unsigned i = 0; ok && i < job->threads; ++i) {
        workers[i].is_caller = i == 0;
        result->status = make_film(job, &workers[i]);
        ok = workers[i].film != NULL;
    }
    if (ok) {
        double cpu_start = seconds_of(CLOCK_PROCESS_CPUTIME_ID);
        result->status = render_groups(job, workers, result);
        result->cpu_seconds = seconds_of(CLOCK_PROCESS_CPUTIME_ID) - cpu_start;
    }
    if (ok && result->status == VOLGRAD_OK) {
        result->status = collect(workers, job->threads, result);
    }
    for (unsigned i = 0; workers != NULL && i < job->threads; ++i) {
        free(workers[i].film_memory);
    }
    free(workers);
    return result->film != NULL;
}

void render_result_free(render_result *result)
{
    free(result->film_memory);
    *result = (render_result){.status = VOLGRAD_OK};
}
