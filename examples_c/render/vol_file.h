/* Density grids of Mitsuba's .vol files (version 3, float32, one channel). */
#ifndef RENDER_VOL_FILE_H
#define RENDER_VOL_FILE_H

#include "xml.h"

typedef struct {
    uint32_t nx, ny, nz;
    float box_min[3], box_max[3]; /* as the file says; means something with use_grid_bbox only */
    float *density;               /* x fastest; to be freed */
} vol_grid;

/* Reads and checks the file. On an error reports it at `node`, returns 0 and leaves nothing to be freed. */
int vol_load(const xml_node *node, const char *path, vol_grid *out);

#endif
