/* The nodes of a NanoVDB tree. They are found with PNanoVDB, whose reads are made to stay inside the grid; that a node lies there as a
   whole is checked before it is read. */
#include "nvdb_tree.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PNANOVDB_C
#define PNANOVDB_BUF_BOUNDS_CHECK
#include <nanovdb/PNanoVDB.h>

#define FLOAT_GRID PNANOVDB_GRID_TYPE_FLOAT
#define LAYOUT(name) pnanovdb_grid_type_constants[FLOAT_GRID].name

/* A box of 4096^3 voxels. The tables of its bricks take 2 GiB: a second or two, which fuzzers (who define this) have not. */
#ifdef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
#define MOST_BRICKS ((int64_t)1 << 14)
#else
#define MOST_BRICKS ((int64_t)1 << 27)
#endif

/* So that volgrad's 2^20 samples along an axis suffice for the bricks' box. */
#define MOST_LEAVES (((int64_t)1 << 17) - 2)

/* So that 32 bits suffice for a place in its words. */
#define MOST_BYTES ((uint64_t)1 << 34)

typedef struct {
    const xml_node *node;
    const char *path;
    pnanovdb_buf_t buffer;
    uint64_t bytes;
    int64_t nodes_left[3]; /* leaves, lower and upper nodes that the file has room for: none can be visited again and again */
    nvdb_places *places;   /* without sources while only the bounds are looked for */
} tree;

static uint32_t read_word(const tree *t, uint64_t address)
{
    return pnanovdb_buf_read_uint32(t->buffer, address);
}

static float as_float(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static double read_double(const tree *t, uint64_t address)
{
    uint64_t bits = pnanovdb_buf_read_uint64(t->buffer, address);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static int damaged(const tree *t, const char *what, uint64_t address)
{
    return xml_error(t->node,
                     "%s: %s at byte %llu of the grid, which has %llu: beyond its end, not a multiple of 32, or used twice; the file "
                     "is damaged",
                     t->path, what, (unsigned long long)address, (unsigned long long)t->bytes);
}

/* Whether `bytes` from `address` on are all there. */
static int holds(const tree *t, uint64_t address, uint64_t bytes)
{
    return address % 32 == 0 && address <= t->bytes && bytes <= t->bytes - address;
}

static int check_value(const tree *t, float value, int64_t x, int64_t y, int64_t z)
{
    return value >= 0 && isfinite(value)
               ? 1
               : xml_error(t->node, "%s: voxel (%lld, %lld, %lld) is %g; a density is finite and not negative", t->path,
                           (long long)x, (long long)y, (long long)z, (double)value);
}

static int check_leaf(const tree *t, const int64_t at[AXES], uint64_t address)
{
    pnanovdb_leaf_handle_t leaf = {{address}};
    for (uint32_t n = 0; n < PNANOVDB_LEAF_TABLE_COUNT; n++) {
        float value = as_float(read_word(t, pnanovdb_leaf_get_table_address(FLOAT_GRID, t->buffer, leaf, n).byte_offset));
        if (!check_value(t, value, LEAF_SIDE * at[0] + (n >> 6), LEAF_SIDE * at[1] + (n >> 3 & 7), LEAF_SIDE * at[2] + (n & 7))) {
            return 0;
        }
    }
    return 1;
}

/* ---- the nodes ---- */

static nvdb_source *source_at(const tree *t, const int64_t at[AXES])
{
    const nvdb_places *p = t->places;
    return &p->sources[((at[2] - p->low[2]) * p->counts[1] + at[1] - p->low[1]) * p->counts[0] + at[0] - p->low[0]];
}

/* The cube of `side`^3 places from `at` on holds `what`: grows the bounds in the first round, is noted in the second. */
static int place(tree *t, const int64_t at[AXES], int64_t side, nvdb_source what)
{
    if (!t->places->sources) {
        int64_t *low = t->places->low, *high = t->places->high;
        for (int axis = 0; axis < AXES; axis++) {
            low[axis] = at[axis] < low[axis] ? at[axis] : low[axis];
            high[axis] = at[axis] + side - 1 > high[axis] ? at[axis] + side - 1 : high[axis];
        }
        return 1;
    }
    int64_t i[AXES];
    for (i[2] = at[2]; i[2] < at[2] + side; i[2]++) {
        for (i[1] = at[1]; i[1] < at[1] + side; i[1]++) {
            for (i[0] = at[0]; i[0] < at[0] + side; i[0]++) {
                nvdb_source *here = source_at(t, i);
                if (here->is_leaf || here->value) {
                    return xml_error(t->node, "%s: two nodes of the tree are at the same place; the file is damaged", t->path);
                }
                *here = what;
            }
        }
    }
    return 1;
}

static int visit_tile(tree *t, const int64_t at[AXES], int64_t side, uint64_t address)
{
    uint32_t bits = read_word(t, address);
    float value = as_float(bits);
    return value == 0 || (check_value(t, value, LEAF_SIDE * at[0], LEAF_SIDE * at[1], LEAF_SIDE * at[2]) &&
                          place(t, at, side, (nvdb_source){0, bits}));
}

static int visit_leaf(tree *t, const int64_t at[AXES], uint64_t address)
{
    if (!holds(t, address, LAYOUT(leaf_size)) || t->nodes_left[0]-- == 0) {
        return damaged(t, "a leaf", address);
    }
    return (t->places->sources || check_leaf(t, at, address)) &&
           place(t, at, 1, (nvdb_source){1, (uint32_t)((address + LAYOUT(leaf_off_table)) / sizeof(uint32_t))});
}

static int visit_lower(tree *t, const int64_t at[AXES], uint64_t address)
{
    if (!holds(t, address, LAYOUT(lower_size)) || t->nodes_left[1]-- == 0) {
        return damaged(t, "a lower node", address);
    }
    pnanovdb_lower_handle_t lower = {{address}};
    for (uint32_t n = 0; n < PNANOVDB_LOWER_TABLE_COUNT; n++) {
        const int64_t child[AXES] = {at[0] + (n >> 8), at[1] + (n >> 4 & 15), at[2] + (n & 15)};
        int ok = pnanovdb_lower_get_child_mask(t->buffer, lower, n)
                     ? visit_leaf(t, child, pnanovdb_lower_get_child(FLOAT_GRID, t->buffer, lower, n).address.byte_offset)
                     : visit_tile(t, child, 1, pnanovdb_lower_get_table_address(FLOAT_GRID, t->buffer, lower, n).byte_offset);
        if (!ok) {
            return 0;
        }
    }
    return 1;
}

static int visit_upper(tree *t, const int64_t at[AXES], uint64_t address)
{
    enum { SIDE = 16 }; /* leaves along the side of a child */
    if (!holds(t, address, LAYOUT(upper_size)) || t->nodes_left[2]-- == 0) {
        return damaged(t, "an upper node", address);
    }
    pnanovdb_upper_handle_t upper = {{address}};
    for (uint32_t n = 0; n < PNANOVDB_UPPER_TABLE_COUNT; n++) {
        const int64_t child[AXES] = {at[0] + SIDE * (n >> 10), at[1] + SIDE * (n >> 5 & 31), at[2] + SIDE * (n & 31)};
        int ok = pnanovdb_upper_get_child_mask(t->buffer, upper, n)
                     ? visit_lower(t, child, pnanovdb_upper_get_child(FLOAT_GRID, t->buffer, upper, n).address.byte_offset)
                     : visit_tile(t, child, SIDE, pnanovdb_upper_get_table_address(FLOAT_GRID, t->buffer, upper, n).byte_offset);
        if (!ok) {
            return 0;
        }
    }
    return 1;
}

/* Leaf coordinate along an axis from 20 bits of a root tile's key, the high bits of a signed 32-bit voxel coordinate. */
static int64_t from_key(uint64_t bits)
{
    return (int64_t)(int32_t)((uint32_t)bits << 12) / LEAF_SIDE;
}

static int visit_root(tree *t, pnanovdb_root_handle_t root)
{
    enum { SIDE = 512 }; /* leaves along the side of a child */
    uint64_t count = pnanovdb_root_get_tile_count(t->buffer, root);
    if (!holds(t, root.address.byte_offset, LAYOUT(root_size) + count * LAYOUT(root_tile_size))) {
        return damaged(t, "the root", root.address.byte_offset);
    }
    if (as_float(read_word(t, root.address.byte_offset + LAYOUT(root_off_background))) != 0) {
        return xml_error(t->node, "%s: the background is not 0, so that the density would have no end", t->path);
    }
    for (uint32_t n = 0; n < count; n++) {
        pnanovdb_root_tile_handle_t tile = pnanovdb_root_get_tile(FLOAT_GRID, root, n);
        uint64_t key = pnanovdb_root_tile_get_key(t->buffer, tile);
        const int64_t at[AXES] = {from_key(key >> 42), from_key(key >> 21), from_key(key)};
        int ok = pnanovdb_root_tile_get_child(t->buffer, tile) != 0
                     ? visit_upper(t, at, pnanovdb_root_get_child(FLOAT_GRID, t->buffer, root, tile).address.byte_offset)
                     : visit_tile(t, at, SIDE, pnanovdb_root_tile_get_value_address(FLOAT_GRID, t->buffer, tile).byte_offset);
        if (!ok) {
            return 0;
        }
    }
    return 1;
}

static int visit(tree *t)
{
    pnanovdb_grid_handle_t grid = {{0}};
    t->nodes_left[0] = (int64_t)(t->bytes / LAYOUT(leaf_size));
    t->nodes_left[1] = (int64_t)(t->bytes / LAYOUT(lower_size));
    t->nodes_left[2] = (int64_t)(t->bytes / LAYOUT(upper_size));
    return visit_root(t, pnanovdb_tree_get_root(t->buffer, pnanovdb_grid_get_tree(t->buffer, grid)));
}

/* ---- all of it ---- */

static int check_header(const tree *t)
{
    pnanovdb_grid_handle_t grid = {{0}};
    if (t->bytes < PNANOVDB_GRID_SIZE + PNANOVDB_TREE_SIZE) {
        return xml_error(t->node, "%s: the grid has %llu bytes; its header alone takes %d", t->path, (unsigned long long)t->bytes,
                         PNANOVDB_GRID_SIZE + PNANOVDB_TREE_SIZE);
    }
    if (t->bytes > MOST_BYTES) {
        return xml_error(t->node, "%s: the grid has %llu bytes; %llu are possible", t->path, (unsigned long long)t->bytes,
                         (unsigned long long)MOST_BYTES);
    }
    uint32_t version = pnanovdb_grid_get_version(t->buffer, grid), type = pnanovdb_grid_get_grid_type(t->buffer, grid);
    if (memcmp(t->buffer.data, "NanoVDB", 7) != 0 || pnanovdb_version_get_major(version) != 32 || type != FLOAT_GRID) {
        return xml_error(t->node, "%s: the data are not those of a NanoVDB float grid of version 32; the file is damaged", t->path);
    }
    return 1;
}

static int read_map(const tree *t, transform *out)
{
    pnanovdb_grid_handle_t grid = {{0}};
    uint64_t map = pnanovdb_grid_get_map(t->buffer, grid).address.byte_offset;
    *out = transform_identity();
    int finite = 1;
    for (int row = 0; row < AXES; row++) {
        for (int column = 0; column < AXES; column++) {
            out->m[row][column] = read_double(t, map + PNANOVDB_MAP_OFF_MATD + 8 * (uint64_t)(AXES * row + column));
            finite = finite && isfinite(out->m[row][column]);
        }
        out->m[row][3] = read_double(t, map + PNANOVDB_MAP_OFF_VECD + 8 * (uint64_t)row);
        finite = finite && isfinite(out->m[row][3]);
    }
    return (finite && transform_is_invertible(out)) ||
           xml_error(t->node, "%s: the grid's map from voxels to the world has no inverse", t->path);
}

static int make_room(const tree *t)
{
    nvdb_places *p = t->places;
    if (p->low[0] > p->high[0]) {
        return xml_error(t->node, "%s: the grid has no density anywhere", t->path);
    }
    int fits = 1;
    int64_t bricks = 1;
    for (int axis = 0; axis < AXES; axis++) {
        p->counts[axis] = p->high[axis] - p->low[axis] + 1;
        fits = fits && p->counts[axis] <= MOST_LEAVES && p->counts[axis] + 2 <= MOST_BRICKS / bricks;
        bricks *= fits ? p->counts[axis] + 2 : 1;
    }
    if (!fits) {
        return xml_error(t->node,
                         "%s: the grid spans %lld x %lld x %lld leaves of 8^3 voxels; with two more along each axis %lld are "
                         "possible, %lld along one",
                         t->path, (long long)p->counts[0], (long long)p->counts[1], (long long)p->counts[2],
                         (long long)MOST_BRICKS, (long long)MOST_LEAVES);
    }
    p->sources = calloc((size_t)(p->counts[0] * p->counts[1] * p->counts[2]), sizeof *p->sources);
    return p->sources ? 1 : xml_out_of_memory(t->node);
}

int nvdb_find_places(const xml_node *node, const char *path, const nvdb_grid *grid, nvdb_places *out)
{
    tree t = {.node = node,
              .path = path,
              .buffer = pnanovdb_make_buf(grid->words, grid->bytes / sizeof(uint32_t)),
              .bytes = grid->bytes,
              .places = out};
    *out = (nvdb_places){.low = {INT64_MAX, INT64_MAX, INT64_MAX}, .high = {INT64_MIN, INT64_MIN, INT64_MIN}};
    int ok = check_header(&t) && read_map(&t, &out->map) && visit(&t) && make_room(&t) && visit(&t);
    if (!ok) {
        free(out->sources);
        out->sources = NULL;
    }
    return ok;
}
