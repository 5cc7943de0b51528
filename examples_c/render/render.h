/* Renders an image on all threads. It depends on the seed and on how much was done, not on the threads: films are integer sums, and a
   limit or a signal only decides before which pass, or round of mutations, to stop, whether guides learn from all samples that they
   should, and how much is tried (ways.h). */
#ifndef RENDER_RENDER_H
#define RENDER_RENDER_H

#include <signal.h>
#include <stdint.h>

#include "films.h"
#include "volgrad.h"

/* How chains are run (chains.h). Numbers that are 0 were not given. */
typedef struct {
    volgrad_chain_options options;
    uint64_t mutations_per_pixel; /* in all; 0: no limit */
    uint64_t bootstrap;           /* samples exactly; 0: until their error is small */
    uint32_t chains;              /* 0: so many that their burn-in costs little */
} chain_settings;

/* One mutation of one chain, both from 0 on. */
typedef struct {
    uint32_t chain;
    uint64_t number; /* among those that count */
} chain_mutation;

/* How the subpaths from lights learn where to go (guide.h). */
typedef struct {
    volgrad_bidirectional_options options;
    uint64_t passes; /* 0: enough for the scene's lights */
} guide_settings;

/* One of the ways to make bidirectional paths, as in volgrad_bidirectional_run_technique. */
typedef struct {
    uint32_t light_vertices, camera_vertices;
    uint32_t weighted;
} technique;

/* What renders an image without chains. */
enum { MOST_WAYS = 4 };

typedef struct {
    char name[64];                                      /* for the user */
    const volgrad_path_sampler_options *sampler;        /* all, or what the other leaves out */
    const volgrad_bidirectional_options *bidirectional; /* NULL: no bidirectional paths */
    double roulette;                                    /* bidirectional->roulette over the brightness that guides find */
} way;

typedef struct {
    const volgrad_scene *scene;
    const volgrad_queries *queries;
    const way *ways;                                    /* of which trials choose one */
    unsigned way_count;                                 /* 1 to MOST_WAYS */
    const volgrad_path_sampler_options *sampler;        /* of the chosen way, as long as it is rendered with */
    const volgrad_bidirectional_options *bidirectional; /* the same */
    const technique *technique;                         /* only what it makes, of all samplers; NULL: everything */
    const chain_settings *chains;                       /* NULL: no chains */
    const guide_settings *guide;                        /* NULL: subpaths go wherever lights shine */
    uint32_t width, height;                             /* of the whole image */
    uint32_t crop[4];                                   /* the crop window: x0, y0, x1, y1 */
    uint32_t pixel_count;                               /* in it */
    unsigned threads;                                   /* at least 1 */
    uint64_t max_passes;                                /* 0: no limit; beside chains: in proportion to them */
    double max_seconds;                                 /* 0: no limit */
    const volatile sig_atomic_t *stop;                  /* ends the rendering when it becomes non-zero */
    double start;                                       /* of the rendering, seconds_wall() */
    /* Told now and then, on the calling thread, how many passes, or mutations per pixel, are done (with fraction) after how many
       seconds. May be NULL. */
    void (*report)(void *user, double done, double seconds);
    void *report_user;
    /* Told in words what the user may like to know. May be NULL. */
    void (*note)(void *user, const char *text);
} render_job;

/* The chains of one path length. */
typedef struct {
    uint32_t chains;
    double brightness;
    volgrad_chain_stats stats;
} chain_length;

/* What chains made. All 0 without chains. */
typedef struct {
    owned_film film;
    double scale; /* for volgrad_film_develop */
    uint32_t count;
    uint64_t mutations_each;
    uint64_t bootstrap_samples;
    double bootstrap_seconds;
    double brightness, relative_error; /* as in volgrad_chain_plan_result */
    double cpu_seconds;                /* of the mutations, of all threads */
    volgrad_chain_stats stats;         /* of all chains */
    volgrad_chain_stats bootstrap;     /* of the samples before them */
    chain_length lengths[VOLGRAD_MAX_LENGTH + 1];
} chain_result;

typedef struct {
    volgrad_status status;
    unsigned way;         /* number of the job's way that was chosen */
    uint64_t trial_rays;  /* of the ways that were tried, which are not in `stats` */
    double trial_seconds; /* that trials took */
    uint64_t passes;
    double wall_seconds;
    double cpu_seconds; /* of all threads */
    volgrad_path_sampler_stats stats;
    owned_film film; /* the sum of all passes; NULL unless status is VOLGRAD_OK */
    uint64_t guide_samples; /* that guides learned from; 0: no guides */
    double guide_seconds;   /* that it took */
    double roulette;        /* luminance from which on nothing was left to chance; 0: nothing was */
    volgrad_path_sampler_stats guide_stats;
    chain_result chains;
} render_result;

/* Returns 0 when out of memory or when `status` is not VOLGRAD_OK; what was rendered by then is lost. */
int render_run(const render_job *job, render_result *result);

/* Calls job->report, if there is one. */
void render_report(const render_job *job, double done);

/* Seconds that are left, INFINITY without a limit; 0 or less also when a signal has come. */
double render_seconds_left(const render_job *job);

void render_result_free(render_result *result);

#endif
