/* The command line. */
#ifndef RENDER_OPTIONS_H
#define RENDER_OPTIONS_H

#include <stdint.h>

#include "option_names.h"
#include "render.h"
#include "volgrad.h"

typedef struct {
    const char *scene;  /* borrowed from argv, as is `output` */
    const char *output; /* ends in .exr */
    uint64_t spp;       /* 0: not given */
    double seconds;     /* 0: not given */
    unsigned threads;   /* at least 1 */
    uint64_t seed;
    int has_max_depth;
    uint32_t max_depth; /* 0: no limit */
    uint32_t first_vertex; /* VOLGRAD_FIRST_VERTEX_*; 0: all paths */
    uint32_t integrator; /* INTEGRATOR_* */
    uint32_t heuristic;  /* VOLGRAD_HEURISTIC_* */
    int has_guide;
    uint64_t guide; /* passes to learn from; 0: no guides */
    uint32_t light_vertices; /* 0: not given */
    double roulette; /* over the image's brightness, as far as guides know it; < 0: not given */
    volgrad_shift_options shift;
    const char *techniques; /* folder of their images; NULL: none */
    int has_debug_chain;
    chain_mutation debug_chain;
    chain_settings chains; /* options.seed and options.shift are not set */
    int has_crop;
    uint32_t crop[4]; /* x0, y0, x1, y1 */
    int quiet;
    int stats;
} options;

typedef enum { OPTIONS_RUN, OPTIONS_HELP, OPTIONS_VERSION, OPTIONS_ERROR } options_result;

/* Reads the command line. On OPTIONS_ERROR the reason has been printed to stderr. */
options_result options_parse(int argc, char **argv, options *out);

void options_print_help(void);

/* Whether a mode is the thesis', which is for chains alone. */
int options_is_thesis(uint32_t mode);

#endif
