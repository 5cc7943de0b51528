#include "metadata.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void add(metadata *m, const char *name, const char *text, double number)
{
    if (m->count < METADATA_CAPACITY) {
        m->attributes[m->count++] = (volgrad_exr_attribute){.name = name, .text = text, .number = number};
    }
}

static void add_text(metadata *m, const char *name, const char *text)
{
    add(m, name, text, 0.0);
}

static void add_number(metadata *m, const char *name, double number)
{
    add(m, name, NULL, number);
}

/* One argument, in quotes where a shell would need them. Returns the end of what was written; needs 4 * length + 2 characters. */
static char *quote(char *to, const char *argument)
{
    static const char plain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-+=./,:@%";
    size_t length = strlen(argument);
    if (length > 0 && strspn(argument, plain) == length) {
        memcpy(to, argument, length);
        return to + length;
    }
    *to++ = '\'';
    for (; *argument != '\0'; ++argument) {
        if (*argument == '\'') {
            memcpy(to, "'\\''", 4);
            to += 4;
        } else {
            *to++ = *argument;
        }
    }
    *to++ = '\'';
    return to;
}

char *metadata_command_line(int argc, char **argv)
{
    size_t size = 1;
    for (int i = 0; i < argc; ++i) {
        size += 4 * strlen(argv[i]) + 3;
    }
    char *line = malloc(size), *end = line;
    if (line == NULL) {
        return NULL;
    }
    for (int i = 0; i < argc; ++i) {
        if (i > 0) {
            *end++ = ' ';
        }
        end = quote(end, argv[i]);
    }
    *end = '\0';
    return line;
}

static void add_chains(metadata *m, const chain_settings *settings, const chain_result *made)
{
    const volgrad_chain_options *options = &settings->options;
    add_number(m, "chains", made->count);
    add_number(m, "mutationsPerPixel", made->count > 0 ? 1.0 / made->scale : 0.0);
    add_number(m, "mutationsPerChain", (double)made->mutations_each);
    add_number(m, "chainLengthsFirst", options->min_length);
    add_number(m, "chainLengthsLast", options->max_length);
    add_number(m, "burnIn", options->burn_in);
    add_number(m, "largeStep", options->large_step);
    if (options->shift.mode != VOLGRAD_SHIFT_NONE) {
        add_number(m, "shiftEvery", options->shift_every);
    }
    add_number(m, "bootstrapSamples", (double)made->bootstrap_samples);
    add_number(m, "brightness", made->brightness);
    add_number(m, "brightnessRelativeError", made->relative_error);
}

static void add_sampler(metadata *m, const volgrad_path_sampler_options *sampler, const volgrad_shift_options *shift)
{
    add_number(m, "maxDepth", sampler->max_depth > 0 ? (double)sampler->max_depth : -1.0);
    add_number(m, "rrDepth", sampler->rr_depth);
    add_text(m, "shift", options_shift_name(shift->mode));
    if (shift->mode != VOLGRAD_SHIFT_NONE) {
        add_text(m, "shiftKernel", options_kernel_name(shift->kernel));
        add_number(m, "shiftCount", shift->count);
        add_number(m, "shiftRun", sampler->shift.run);
        if (shift->kernel != VOLGRAD_KERNEL_TILE) {
            const char *name = shift->radius_unit == VOLGRAD_RADIUS_PIXELS ? "shiftRadiusPixels" : "shiftRadiusWorld";
            add_number(m, name, shift->radius);
            add_number(m, "shiftAlpha", shift->alpha);
        }
        if (shift->clamp > 0.0f) {
            add_number(m, "shiftClamp", shift->clamp);
        }
        if (shift->mode == VOLGRAD_SHIFT_TWO_LEVEL) {
            add_number(m, "shiftExact", shift->exact_count);
        }
    }
}

void metadata_collect(metadata *m, const image_source *source)
{
    const render_result *result = source->result;
    *m = (metadata){.count = 0};
    snprintf(m->seed, sizeof m->seed, "%" PRIu64, source->sampler->seed);
    add_text(m, "volgradVersion", volgrad_version());
    add_text(m, "scene", source->options->scene);
    add_text(m, "commandLine", source->command_line);
    add_text(m, "seed", m->seed);
    add_number(m, "samplesPerPixel", (double)result->passes);
    add_number(m, "renderTimeSeconds", result->wall_seconds);
    add_number(m, "cpuTimeSeconds", result->cpu_seconds);
    add_number(m, "droppedSamples", (double)source->dropped);
    uint64_t of_chains = result->chains.stats.overflows + result->chains.stats.dropped;
    uint64_t of_bootstrap = result->chains.bootstrap.overflows + result->chains.bootstrap.dropped;
    add_number(m, "droppedPaths", (double)(result->stats.overflows + of_chains + of_bootstrap));
    add_text(m, "integrator", options_integrator_name(source->options->integrator));
    if (source->options->integrator == INTEGRATOR_BDPT) {
        add_text(m, "heuristic", options_heuristic_name(source->options->heuristic));
        add_number(m, "roulette", result->roulette);
    }
    if (source->options->integrator != INTEGRATOR_PATH) {
        add_number(m, "guideSamples", (double)result->guide_samples);
    }
    if (source->sampler->first_vertex != 0) {
        add_text(m, "firstVertex", options_first_vertex_name(source->sampler->first_vertex));
    }
    if (source->technique != NULL) {
        add_number(m, "lightVertices", source->technique->light_vertices);
        add_number(m, "cameraVertices", source->technique->camera_vertices);
        add_number(m, "weighted", source->technique->weighted);
    }
    add_sampler(m, source->sampler, &source->options->shift);
    if (source->chains != NULL) {
        add_chains(m, source->chains, &result->chains);
    }
}
