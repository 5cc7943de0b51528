/* What a NanoVDB tree has at the places of its leaves. */
#ifndef RENDER_NVDB_TREE_H
#define RENDER_NVDB_TREE_H

#include "nvdb.h"

enum { LEAF_SIDE = 8, AXES = 3 };

/* A leaf, or one value everywhere. */
typedef struct {
    uint32_t is_leaf;
    uint32_t value; /* of a leaf: where in the grid's words its values begin, z fastest; otherwise the bits of a float */
} nvdb_source;

/* The box of all places where there is anything, in units of leaves. */
typedef struct {
    int64_t low[AXES], high[AXES], counts[AXES]; /* high - low + 1 */
    nvdb_source *sources;                        /* x fastest; to be freed */
    transform map;                               /* from voxels to the world */
} nvdb_places;

/* Checks all of the grid. Reports errors at `node`; nothing is to be freed then. */
int nvdb_find_places(const xml_node *node, const char *path, const nvdb_grid *grid, nvdb_places *out);

#endif
