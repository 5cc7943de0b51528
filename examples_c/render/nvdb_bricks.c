/* From the leaves of a NanoVDB grid to volgrad's bricks, which are aligned with them. */
#include <stdlib.h>
#include <string.h>

#include "nvdb_tree.h"

enum { BLOCK_SIDE = VOLGRAD_BRICK_SIDE + 1 };

/* The block of bricks without any density. */
enum { EMPTY = 0 };

/* Bricks that are the same everywhere share blocks; the last ones of some values are remembered. */
enum { REMEMBERED = 64 };
typedef struct {
    int known;
    uint32_t bits, block;
} uniform_block;

typedef struct {
    const xml_node *node;
    const uint32_t *words; /* of the grid */
    const nvdb_places *places;
    /* Bricks along each axis. Brick (0, 0, 0) is a place before the first one, the last one a place behind. */
    int64_t counts[AXES];
    uint32_t *blocks; /* of each brick */
    float *density;   /* of each block */
    size_t block_count, block_room;
    uniform_block uniform[REMEMBERED];
} bricks;

static int64_t index_of(const int64_t counts[AXES], int64_t x, int64_t y, int64_t z)
{
    return (z * counts[1] + y) * counts[0] + x;
}

/* At a place counted from the first one, or beyond. */
static nvdb_source source_at(const bricks *b, int64_t x, int64_t y, int64_t z)
{
    const int64_t *counts = b->places->counts;
    int inside = x >= 0 && y >= 0 && z >= 0 && x < counts[0] && y < counts[1] && z < counts[2];
    return inside ? b->places->sources[index_of(counts, x, y, z)] : (nvdb_source){0, 0};
}

static uint32_t voxel(const bricks *b, nvdb_source s, uint32_t x, uint32_t y, uint32_t z)
{
    return s.is_leaf ? b->words[s.value + (x << 6 | y << 3 | z)] : s.value;
}

static int all_equal(const uint32_t *bits, int count)
{
    int i = 1;
    while (i < count && bits[i] == bits[0]) {
        i++;
    }
    return i == count;
}

/* Reads the place at the brick and, below it, the last layer of the places before. Returns whether all values are the same: then only the
   first one may be there. */
static int gather(const bricks *b, const int64_t brick[AXES], uint32_t *bits)
{
    nvdb_source sources[2][2][2];
    int constant = 1;
    for (int i = 0; i < 8; i++) {
        nvdb_source s = source_at(b, brick[0] - 2 + (i & 1), brick[1] - 2 + (i >> 1 & 1), brick[2] - 2 + (i >> 2));
        sources[i >> 2][i >> 1 & 1][i & 1] = s;
        constant = constant && !s.is_leaf && s.value == sources[0][0][0].value;
    }
    bits[0] = sources[0][0][0].value;
    if (constant) {
        return 1;
    }
    for (uint32_t i = 0; i < VOLGRAD_BLOCK_SAMPLES; i++) {
        uint32_t x = i % BLOCK_SIDE, y = i / BLOCK_SIDE % BLOCK_SIDE, z = i / (BLOCK_SIDE * BLOCK_SIDE);
        bits[i] = voxel(b, sources[z > 0][y > 0][x > 0], (x + 7) % LEAF_SIDE, (y + 7) % LEAF_SIDE, (z + 7) % LEAF_SIDE);
    }
    return all_equal(bits, VOLGRAD_BLOCK_SAMPLES);
}

/* Appends a block: of these values, or of the first one everywhere. */
static int append(bricks *b, const uint32_t *bits, int alike)
{
    if (b->block_count == b->block_room) {
        size_t room = b->block_room ? 2 * b->block_room : 64;
        float *density = realloc(b->density, room * VOLGRAD_BLOCK_SAMPLES * sizeof *density);
        if (!density) {
            return xml_out_of_memory(b->node);
        }
        b->density = density;
        b->block_room = room;
    }
    float *block = b->density + b->block_count++ * VOLGRAD_BLOCK_SAMPLES;
    for (int i = 0; i < VOLGRAD_BLOCK_SAMPLES; i++) {
        memcpy(&block[i], &bits[alike ? 0 : i], sizeof *block);
    }
    return 1;
}

/* The brick's block, unless it has one. */
static int add_brick(bricks *b, const int64_t brick[AXES])
{
    uint32_t bits[VOLGRAD_BLOCK_SAMPLES], *block = &b->blocks[index_of(b->counts, brick[0], brick[1], brick[2])];
    if (*block != EMPTY) {
        return 1;
    }
    int alike = gather(b, brick, bits);
    uniform_block *uniform = &b->uniform[(bits[0] >> 17) % REMEMBERED];
    if (alike && uniform->known && uniform->bits == bits[0]) {
        *block = uniform->block;
        return 1;
    }
    *block = (uint32_t)b->block_count;
    if (alike) {
        *uniform = (uniform_block){1, bits[0], *block};
    }
    return append(b, bits, alike);
}

/* The brick at a place that is not empty, and the next ones, which its last layer reaches into. */
static int add_around(bricks *b, int64_t x, int64_t y, int64_t z)
{
    for (int i = 0; i < 8; i++) {
        const int64_t brick[AXES] = {x + 1 + (i & 1), y + 1 + (i >> 1 & 1), z + 1 + (i >> 2)};
        if (!add_brick(b, brick)) {
            return 0;
        }
    }
    return 1;
}

static int add_all(bricks *b)
{
    static const uint32_t nothing;
    const int64_t *counts = b->places->counts;
    b->blocks = calloc((size_t)(b->counts[0] * b->counts[1] * b->counts[2]), sizeof *b->blocks);
    if (!b->blocks) {
        return xml_out_of_memory(b->node);
    }
    b->uniform[0] = (uniform_block){1, nothing, EMPTY};
    int ok = append(b, &nothing, 1);
    for (int64_t z = 0; z < counts[2]; z++) {
        for (int64_t y = 0; y < counts[1]; y++) {
            for (int64_t x = 0; ok && x < counts[0]; x++) {
                nvdb_source s = b->places->sources[index_of(counts, x, y, z)];
                ok = (!s.is_leaf && s.value == 0) || add_around(b, x, y, z);
            }
        }
    }
    return ok;
}

/* The box begins a place before the first one and ends with one voxel after the last; there the density is 0. Voxels have their values at
   whole coordinates of the map, which are the centres of our samples. */
static void set_box(const nvdb_places *p, nvdb_volume *out)
{
    uint32_t *const sizes[AXES] = {&out->nx, &out->ny, &out->nz};
    double first[AXES];
    for (int axis = 0; axis < AXES; axis++) {
        *sizes[axis] = (uint32_t)(LEAF_SIDE * (p->counts[axis] + 1) + 1);
        first[axis] = (double)(LEAF_SIDE * (p->low[axis] - 1));
    }
    transform scale = transform_scale((vec3d){out->nx, out->ny, out->nz});
    transform offset = transform_translate((vec3d){first[0] - .5, first[1] - .5, first[2] - .5});
    transform box = transform_multiply(&offset, &scale);
    out->to_world = transform_multiply(&p->map, &box);
}

int nvdb_bricks(const xml_node *node, const char *path, const nvdb_grid *grid, nvdb_volume *out)
{
    nvdb_places places;
    *out = (nvdb_volume){0};
    if (!nvdb_find_places(node, path, grid, &places)) {
        return 0;
    }
    bricks b = {.node = node, .words = grid->words, .places = &places};
    for (int axis = 0; axis < AXES; axis++) {
        b.counts[axis] = places.counts[axis] + 2;
    }
    set_box(&places, out);
    int ok = add_all(&b);
    out->grid = ok ? malloc(sizeof *out->grid) : NULL;
    free(places.sources);
    if (!out->grid) {
        free(b.blocks);
        free(b.density);
        return ok ? xml_out_of_memory(node) : 0;
    }
    *out->grid = (volgrad_sparse_grid){sizeof *out->grid, (uint32_t)b.block_count, b.blocks, b.density};
    return 1;
}

void nvdb_free(const volgrad_sparse_grid *grid)
{
    if (grid) {
        free((void *)grid->blocks);
        free((void *)grid->density);
        free((void *)grid);
    }
}
