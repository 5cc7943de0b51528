/* The table of --stats. */
#ifndef RENDER_STATS_H
#define RENDER_STATS_H

#include "render.h"

/* To standard output. `dropped`: splats that were no numbers. */
void stats_print(const render_result *result, uint64_t dropped);

#endif
