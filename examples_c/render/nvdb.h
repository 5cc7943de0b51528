/* NanoVDB float grids (.nvdb, uncompressed or zip) as volgrad's sparse grids. */
#ifndef RENDER_NVDB_H
#define RENDER_NVDB_H

#include "transform.h"
#include "volgrad.h"
#include "xml.h"

/* A grid's bytes as NanoVDB lays them out in memory. */
typedef struct {
    uint32_t *words; /* to be freed */
    uint64_t bytes;
} nvdb_grid;

typedef struct {
    volgrad_sparse_grid *grid; /* to be freed with nvdb_free */
    uint32_t nx, ny, nz;
    transform to_world; /* of the unit cube, by the map in the file */
} nvdb_volume;

/* nvdb_file.c: the grid called `name`, or the only one if that is NULL. Reports errors at `node`; nothing is to be freed then. */
int nvdb_read(const xml_node *node, const char *path, const char *name, nvdb_grid *out);

/* nvdb_bricks.c: all of the grid's values; nothing in it is trusted. Reports errors at `node`; nothing is to be freed then. */
int nvdb_bricks(const xml_node *node, const char *path, const nvdb_grid *grid, nvdb_volume *out);

void nvdb_free(const volgrad_sparse_grid *grid);

#endif
