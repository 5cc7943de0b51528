/* From a NanoVDB tree to bricks. Its nodes are found with PNanoVDB, whose reads are made to stay inside the grid; that a node lies
   there as a whole is checked before it is read. Bricks are aligned with the tree's leaves of 8^3 voxels. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PNANOVDB_C
#define PNANOVDB_BUF_BOUNDS_CHECK
#include <nanovdb/PNanoVDB.h>

#include "nvdb.h"

enum { LEAF_SIDE = 8, BLOCK_SIDE = VOLGRAD_BRICK_SIDE + 1, AXES = 3 };
#define FLOAT_GRID PNANOVDB_GRID_TYPE_FLOAT
#define LAYOUT(name) pnanovdb_grid_type_constants[FLOAT_GRID].name

/* A box of 4096^3 voxels. The tables of its bricks take 2 GiB. */
#define MOST_BRICKS ((int64_t)1 << 27)

/* So that volgrad's 2^20 samples along an axis suffice for set_box. */
#define MOST_LEAVES (((int64_t)1 << 17) - 2)

/* What is at the place of a leaf: a leaf, or one value everywhere. */
typedef struct {
    uint32_t is_leaf;
    uint32_t value; /* the leaf's address in units of 32 bytes, or the bits of a float */
} source;

/* Bricks that are the same everywhere share blocks; the last ones of some values are remembered. */
enum { REMEMBERED = 64 };
typedef struct {
    int known;
    uint32_t bits, block;
} uniform_block;

typedef struct {
    const xml_node *node;
    const char *path;
    pnanovdb_buf_t buffer;
    uint64_t bytes;
    int64_t nodes_left[3]; /* leaves, lower and upper nodes that there is room for in the file: none can be visited twice for long */
    /* Leaves' coordinates in units of leaves. */
    int64_t low[AXES], high[AXES];
    int64_t counts[AXES]; /* of places, high - low + 1 */
    source *sources;      /* NULL while only the bounds are looked for */
    uint32_t *blocks;
    float *density;
    size_t block_count, block_room;
    uniform_block uniform[REMEMBERED];
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
    return xml_error(t->node, "%s: %s at byte %llu of the grid, which has %llu, aligned to 32; the file is damaged", t->path, what,
                     (unsigned long long)address, (unsigned long long)t->bytes);
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

static source *source_at(const tree *t, const int64_t at[AXES])
{
    return &t->sources[((at[2] - t->low[2]) * t->counts[1] + at[1] - t->low[1]) * t->counts[0] + at[0] - t->low[0]];
}

/* The cube of `side`^3 places from `at` on holds `what`: grows the bounds in the first round, is noted in the second. */
static int place(tree *t, const int64_t at[AXES], int64_t side, source what)
{
    if (!t->sources) {
        for (int axis = 0; axis < AXES; axis++) {
            t->low[axis] = at[axis] < t->low[axis] ? at[axis] : t->low[axis];
            t->high[axis] = at[axis] + side - 1 > t->high[axis] ? at[axis] + side - 1 : t->high[axis];
        }
        return 1;
    }
    int64_t i[AXES];
    for (i[2] = at[2]; i[2] < at[2] + side; i[2]++) {
        for (i[1] = at[1]; i[1] < at[1] + side; i[1]++) {
            for (i[0] = at[0]; i[0] < at[0] + side; i[0]++) {
                source *here = source_at(t, i);
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
                          place(t, at, side, (source){0, bits}));
}

static int visit_leaf(tree *t, const int64_t at[AXES], uint64_t address)
{
    if (!holds(t, address, LAYOUT(leaf_size)) || t->nodes_left[0]-- == 0) {
        return damaged(t, "a leaf", address);
    }
    return (t->sources || check_leaf(t, at, address)) && place(t, at, 1, (source){1, (uint32_t)(address / 32)});
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

/* ---- the bricks ---- */

static source source_or_nothing(const tree *t, const int64_t at[AXES])
{
    for (int axis = 0; axis < AXES; axis++) {
        if (at[axis] < t->low[axis] || at[axis] > t->high[axis]) {
            return (source){0, 0};
        }
    }
    return *source_at(t, at);
}

static uint32_t voxel_bits(const tree *t, source s, uint32_t x, uint32_t y, uint32_t z)
{
    pnanovdb_leaf_handle_t leaf = {{(uint64_t)s.value * 32}};
    return s.is_leaf ? read_word(t, pnanovdb_leaf_get_table_address(FLOAT_GRID, t->buffer, leaf, x << 6 | y << 3 | z).byte_offset)
                     : s.value;
}

/* A brick reads the leaf at `at` and, below it, the last layer of the leaves before. Returns whether all values are the same. */
static int gather(const tree *t, const int64_t at[AXES], uint32_t *bits)
{
    source sources[2][2][2];
    int alike = 1;
    for (int i = 0; i < 8; i++) {
        const int64_t near[AXES] = {at[0] - 1 + (i & 1), at[1] - 1 + (i >> 1 & 1), at[2] - 1 + (i >> 2)};
        source s = sources[i >> 2][i >> 1 & 1][i & 1] = source_or_nothing(t, near);
        alike = alike && !s.is_leaf && s.value == sources[0][0][0].value;
    }
    bits[0] = sources[0][0][0].value;
    for (uint32_t i = 0; !alike && i < VOLGRAD_BLOCK_SAMPLES; i++) {
        uint32_t x = i % BLOCK_SIDE, y = i / BLOCK_SIDE % BLOCK_SIDE, z = i / (BLOCK_SIDE * BLOCK_SIDE);
        bits[i] = voxel_bits(t, sources[z > 0][y > 0][x > 0], (x + 7) % 8, (y + 7) % 8, (z + 7) % 8);
    }
    for (uint32_t i = 1; !alike && bits[i] == bits[0]; i++) {
        alike = i == VOLGRAD_BLOCK_SAMPLES - 1;
    }
    return alike;
}

/* Appends a block: of these values, or of the first one everywhere. */
static int append(tree *t, const uint32_t *bits, int alike)
{
    if (t->block_count == t->block_room) {
        size_t room = t->block_room ? 2 * t->block_room : 64;
        float *density = realloc(t->density, room * VOLGRAD_BLOCK_SAMPLES * sizeof *density);
        if (!density) {
            return xml_out_of_memory(t->node);
        }
        t->density = density;
        t->block_room = room;
    }
    float *block = t->density + t->block_count++ * VOLGRAD_BLOCK_SAMPLES;
    for (int i = 0; i < VOLGRAD_BLOCK_SAMPLES; i++) {
        block[i] = as_float(bits[alike ? 0 : i]);
    }
    return 1;
}

static int add_brick(tree *t, const int64_t at[AXES], size_t brick)
{
    uint32_t bits[VOLGRAD_BLOCK_SAMPLES];
    int alike = gather(t, at, bits);
    uniform_block *uniform = &t->uniform[(bits[0] >> 17) % REMEMBERED];
    if (alike && uniform->known && uniform->bits == bits[0]) {
        t->blocks[brick] = uniform->block;
        return 1;
    }
    t->blocks[brick] = (uint32_t)t->block_count;
    if (alike) {
        *uniform = (uniform_block){1, bits[0], (uint32_t)t->block_count};
    }
    return append(t, bits, alike);
}

static size_t product(const int64_t counts[AXES])
{
    return (size_t)(counts[0] * counts[1] * counts[2]);
}

/* One brick more than leaves along each axis, for what lies between the last voxels and nothing, and one before, where it is the same. */
static int add_bricks(tree *t)
{
    const int64_t counts[AXES] = {t->counts[0] + 2, t->counts[1] + 2, t->counts[2] + 2};
    t->blocks = malloc(product(counts) * sizeof *t->blocks);
    if (!t->blocks) {
        return xml_out_of_memory(t->node);
    }
    int64_t i[AXES];
    size_t brick = 0;
    for (i[2] = t->low[2] - 1; i[2] <= t->high[2] + 1; i[2]++) {
        for (i[1] = t->low[1] - 1; i[1] <= t->high[1] + 1; i[1]++) {
            for (i[0] = t->low[0] - 1; i[0] <= t->high[0] + 1; i[0]++) {
                if (!add_brick(t, i, brick++)) {
                    return 0;
                }
            }
        }
    }
    return 1;
}

/* ---- all of it ---- */

static int check_header(const tree *t)
{
    pnanovdb_grid_handle_t grid = {{0}};
    if (t->bytes < PNANOVDB_GRID_SIZE + PNANOVDB_TREE_SIZE) {
        return xml_error(t->node, "%s: the grid has %llu bytes; its header alone takes %d", t->path, (unsigned long long)t->bytes,
                         PNANOVDB_GRID_SIZE + PNANOVDB_TREE_SIZE);
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

static int make_room(tree *t)
{
    if (t->low[0] > t->high[0]) {
        return xml_error(t->node, "%s: the grid has no density anywhere", t->path);
    }
    int fits = 1;
    int64_t bricks = 1;
    for (int axis = 0; axis < AXES; axis++) {
        t->counts[axis] = t->high[axis] - t->low[axis] + 1;
        fits = fits && t->counts[axis] <= MOST_LEAVES && t->counts[axis] + 2 <= MOST_BRICKS / bricks;
        bricks *= fits ? t->counts[axis] + 2 : 1;
    }
    if (!fits) {
        return xml_error(t->node,
                         "%s: the grid spans %lld x %lld x %lld leaves of 8^3 voxels; with two more along each axis %lld are "
                         "possible, %lld along one",
                         t->path, (long long)t->counts[0], (long long)t->counts[1], (long long)t->counts[2],
                         (long long)MOST_BRICKS, (long long)MOST_LEAVES);
    }
    t->sources = calloc(product(t->counts), sizeof *t->sources);
    return t->sources ? 1 : xml_out_of_memory(t->node);
}

/* The box begins a leaf before the first voxel and ends with one voxel after the last; those are 0. Voxels have their values at whole
   coordinates of the map, which are the centres of our samples. */
static void set_box(const tree *t, const transform *map, nvdb_volume *out)
{
    uint32_t *const sizes[AXES] = {&out->nx, &out->ny, &out->nz};
    double first[AXES];
    for (int axis = 0; axis < AXES; axis++) {
        *sizes[axis] = (uint32_t)(LEAF_SIDE * (t->counts[axis] + 1) + 1);
        first[axis] = (double)(LEAF_SIDE * (t->low[axis] - 1));
    }
    transform scale = transform_scale((vec3d){out->nx, out->ny, out->nz});
    transform offset = transform_translate((vec3d){first[0] - .5, first[1] - .5, first[2] - .5});
    transform box = transform_multiply(&offset, &scale);
    out->to_world = transform_multiply(map, &box);
}

static int convert(tree *t, nvdb_volume *out)
{
    transform map;
    volgrad_sparse_grid *grid = NULL;
    int ok = check_header(t) && read_map(t, &map) && visit(t) && make_room(t) && visit(t) && add_bricks(t);
    if (ok) {
        grid = malloc(sizeof *grid);
        ok = grid ? 1 : xml_out_of_memory(t->node);
    }
    free(t->sources);
    if (!ok) {
        free(t->blocks);
        free(t->density);
        return 0;
    }
    *grid = (volgrad_sparse_grid){sizeof *grid, (uint32_t)t->block_count, t->blocks, t->density};
    out->grid = grid;
    set_box(t, &map, out);
    return 1;
}

int nvdb_bricks(const xml_node *node, const char *path, const nvdb_grid *grid, nvdb_volume *out)
{
    tree t = {.node = node,
              .path = path,
              .buffer = pnanovdb_make_buf(grid->words, grid->bytes / 4),
              .bytes = grid->bytes,
              .low = {INT64_MAX, INT64_MAX, INT64_MAX},
              .high = {INT64_MIN, INT64_MIN, INT64_MIN}};
    *out = (nvdb_volume){0};
    return convert(&t, out);
}

void nvdb_free(const volgrad_sparse_grid *grid)
{
    if (grid) {
        free((void *)grid->blocks);
        free((void *)grid->density);
        free((void *)grid);
    }
}
