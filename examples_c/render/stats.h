/* The table of --stats. */
#ifndef RENDER_STATS_H
#define RENDER_STATS_H

#include "render.h"

/* To standard output. `way`: the chosen one; `dropped`: splats that were no numbers. */
void stats_print(const render_result *result, const char *way, uint64_t dropped);

#endif
