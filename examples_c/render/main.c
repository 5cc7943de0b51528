/* volgrad-render: renders a scene in Mitsuba 3's XML with volgrad and Embree. */
#include <stdio.h>
#include <stdlib.h>

#include "debug_chain.h"
#include "embree_queries.h"
#include "films.h"
#include "image.h"
#include "interrupt.h"
#include "light_media.h"
#include "metadata.h"
#include "options.h"
#include "output.h"
#include "progress.h"
#include "render.h"
#include "samplers.h"
#include "scene.h"
#include "seconds.h"
#include "stats.h"
#include "techniques.h"

enum { EXIT_OK = 0, EXIT_FAILED = 1, EXIT_WRONG_INPUT = 2 };

/* Passes, or mutations per pixel. */
enum { DEFAULT_SAMPLES = 64 };

/* ---- setting up ---- */

static void print_status(const char *what, volgrad_status status)
{
    fprintf(stderr, "volgrad-render: %s: %s\n", what, volgrad_status_message(status));
}

static int print_version(void)
{
    char embree[32];
    embree_queries_version(embree, sizeof embree);
    printf("volgrad-render %s (ABI %u, Embree %s)\n", volgrad_version(), (unsigned)volgrad_abi_version(), embree);
    return EXIT_OK;
}

/* The part of the image to render becomes the camera's crop window. Returns 0 if it does not fit the image. */
static int set_crop(volgrad_camera *camera, const options *o)
{
    if (!o->has_crop) {
        return 1;
    }
    if (o->crop[2] > camera->width || o->crop[3] > camera->height) {
        fprintf(stderr, "volgrad-render: --crop reaches beyond the image of %u x %u pixels\n", (unsigned)camera->width,
                (unsigned)camera->height);
        return 0;
    }
    camera->crop_x0 = o->crop[0];
    camera->crop_y0 = o->crop[1];
    camera->crop_x1 = o->crop[2];
    camera->crop_y1 = o->crop[3];
    return 1;
}

/* volgrad's side of the scene. Returns its memory, to be freed, or NULL. */
static void *make_core_scene(const volgrad_scene_desc *desc, const volgrad_scene **core)
{
    size_t bytes = 0;
    volgrad_error error = {.struct_size = sizeof error};
    volgrad_status status = volgrad_scene_size(desc, &bytes);
    if (status != VOLGRAD_OK) {
        print_status("scene", status);
        return NULL;
    }
    void *memory = aligned_memory(bytes);
    if (memory == NULL) {
        fputs("volgrad-render: out of memory for the scene\n", stderr);
        return NULL;
    }
    status = volgrad_scene_init(memory, bytes, desc, core, &error);
    if (status != VOLGRAD_OK) {
        fprintf(stderr, "volgrad-render: scene: %s", volgrad_status_message(status));
        if (error.field != NULL) {
            fprintf(stderr, " (%s, index %u)", error.field, (unsigned)error.index);
        }
        fputc('\n', stderr);
        free(memory);
        return NULL;
    }
    return memory;
}

/* --spp, or --mutations, and --time as given; with neither, as many as the scene asks for. */
static uint64_t sample_limit(uint64_t given, const options *o, const scene *s)
{
    if (given > 0 || o->seconds > 0.0) {
        return given;
    }
    return s->sample_count > 0 ? s->sample_count : DEFAULT_SAMPLES;
}

/* ---- the run ---- */

/* Splats that were dropped by either film. */
static volgrad_status count_dropped(const render_result *result, uint64_t *dropped)
{
    uint64_t of_chains = 0;
    volgrad_status status = volgrad_film_dropped(result->film.film, dropped);
    if (status == VOLGRAD_OK && result->chains.film.film != NULL) {
        status = volgrad_film_dropped(result->chains.film.film, &of_chains);
    }
    *dropped += of_chains;
    return status;
}

/* Returns 0 if there is no image. */
static int render_image(const render_job *job, render_result *result, uint64_t *dropped)
{
    int ok = render_run(job, result);
    progress_end(job->report_user);
    if (!ok && result->status == VOLGRAD_OK) {
        fputs("volgrad-render: out of memory for films and chains\n", stderr);
        return 0;
    }
    volgrad_status status = ok ? count_dropped(result, dropped) : result->status;
    if (status != VOLGRAD_OK) {
        print_status("rendering", status);
    }
    return status == VOLGRAD_OK;
}

/* What the command line leaves open, and all that it may mean. */
typedef struct {
    samplers samplers[MOST_WAYS];
    options options[MOST_WAYS];
    way ways[MOST_WAYS];
    unsigned count;
} choices;

static int render_and_write(const render_job *job, image_source *source, const choices *all)
{
    render_result result;
    int exit_status = EXIT_FAILED;
    source->result = &result;
    int ok = render_image(job, &result, &source->dropped);
    source->options = &all->options[result.way];
    source->sampler = &all->samplers[result.way].path;
    if (ok && image_write(source)) {
        exit_status = *job->stop ? EXIT_INTERRUPTED : EXIT_OK;
        if (source->options->stats) {
            stats_print(&result, job->ways[result.way].name, source->dropped);
        }
    }
    if (exit_status == EXIT_OK && source->options->techniques != NULL) {
        exit_status = !techniques_write(job, source) ? EXIT_FAILED : *job->stop ? EXIT_INTERRUPTED : EXIT_OK;
    }
    render_result_free(&result);
    return exit_status;
}

static int run_with_queries(image_source *source, choices *all, const scene *s, const volgrad_scene *core,
                            const volgrad_queries *queries)
{
    samplers *first = &all->samplers[0], *last = &all->samplers[all->count - 1];
    const options *o = source->options;
    volgrad_exr_layout window = image_window(source->camera);
    uint32_t pixels = window.window_width * window.window_height;
    int has_chains = o->integrator == INTEGRATOR_MMLT;
    uint64_t *limit = &first->chains.mutations_per_pixel;
    *limit = sample_limit(*limit, o, s);
    uint64_t passes = has_chains ? o->spp : sample_limit(o->spp, o, s);
    progress progress;
    progress_start(&progress, o->quiet, has_chains ? *limit : passes, o->seconds, pixels, has_chains ? "mutations" : "samples");
    render_job job = {.scene = core,
                      .queries = queries,
                      .ways = all->ways,
                      .way_count = all->count,
                      .sampler = &first->path,
                      .bidirectional = all->ways[0].bidirectional,
                      .chains = has_chains ? &first->chains : NULL,
                      .guide = last->has_guide ? &last->guide : NULL,
                      .width = window.width,
                      .height = window.height,
                      .crop = {source->camera->crop_x0, source->camera->crop_y0, source->camera->crop_x1, source->camera->crop_y1},
                      .pixel_count = pixels,
                      .threads = o->threads,
                      .max_passes = passes,
                      .max_seconds = o->seconds,
                      .stop = interrupt_watch(),
                      .start = seconds_wall(),
                      .report = progress_report,
                      .note = progress_note,
                      .report_user = &progress};
    if (o->has_debug_chain) {
        return debug_chain(&job, &s->desc, &o->debug_chain, o->output) ? EXIT_OK : EXIT_FAILED;
    }
    source->chains = job.chains;
    return render_and_write(&job, source, all);
}

static int run_scene(image_source *source, scene *s)
{
    choices all;
    const volgrad_scene *core = NULL;
    const char *problem = NULL;
    if (!set_crop(&s->desc.camera, source->options)) {
        return EXIT_WRONG_INPUT;
    }
    all.count = samplers_list(all.samplers, all.options, source->options, s);
    for (unsigned i = 0; i < all.count; ++i) {
        all.ways[i] = samplers_way(&all.samplers[i], &all.options[i]);
    }
    if (all.count == 0) {
        return EXIT_WRONG_INPUT;
    }
    embree_queries *embree = embree_queries_create(s, source->options->threads, &problem);
    if (embree == NULL) {
        fprintf(stderr, "volgrad-render: Embree: %s\n", problem);
        return EXIT_FAILED;
    }
    light_media_find(s, embree);
    int exit_status = EXIT_WRONG_INPUT;
    void *core_memory = make_core_scene(&s->desc, &core);
    if (core_memory != NULL) {
        volgrad_queries queries = embree_queries_table(embree);
        source->camera = &s->desc.camera;
        exit_status = run_with_queries(source, &all, s, core, &queries);
    }
    embree_queries_destroy(embree);
    free(core_memory);
    return exit_status;
}

static int run(const options *o, const char *command_line)
{
    scene s;
    image_source source = {.command_line = command_line, .output = o->output, .options = o};
    if (!output_check(o->output) || (o->techniques != NULL && !output_folder(o->techniques))) {
        return EXIT_FAILED;
    }
    if (!scene_load(o->scene, &s)) {
        return EXIT_WRONG_INPUT;
    }
    int exit_status = run_scene(&source, &s);
    scene_free(&s);
    return exit_status;
}

static int parse_and_run(int argc, char **argv, const char *command_line)
{
    options o;
    switch (options_parse(argc, argv, &o)) {
    case OPTIONS_HELP:
        options_print_help();
        return EXIT_OK;
    case OPTIONS_VERSION:
        return print_version();
    case OPTIONS_RUN:
        return run(&o, command_line);
    default:
        return EXIT_WRONG_INPUT;
    }
}

int main(int argc, char **argv)
{
    if (volgrad_abi_version() != VOLGRAD_ABI_VERSION) {
        fprintf(stderr, "volgrad-render: built for volgrad ABI %u, found %u\n", (unsigned)VOLGRAD_ABI_VERSION,
                (unsigned)volgrad_abi_version());
        return EXIT_FAILED;
    }
    char *command_line = metadata_command_line(argc, argv);
    if (command_line == NULL) {
        fputs("volgrad-render: out of memory\n", stderr);
        return EXIT_FAILED;
    }
    int exit_status = parse_and_run(argc, argv, command_line);
    free(command_line);
    return exit_status;
}
