/* Trees of NanoVDB float grids. The input changes a good one: records of a place and eight bytes. A place counts from the start of one of
   the good tree's parts, so that few bytes reach all fields. */
#include "fuzz.h"
#include "nvdb.h"

/* Sizes and offsets of NanoVDB's structs, version 32, float; see PNanoVDB.h. */
enum { GRID = 0, TREE = 672, ROOT = 736, TILES = ROOT + 64, UPPER = 896, UPPER_BYTES = 270400 };
enum { LOWERS = 2, LOWER = UPPER + UPPER_BYTES, LOWER_BYTES = 33856, LEAF = LOWER + LOWERS * LOWER_BYTES, LEAF_BYTES = 2144 };
enum { BYTES = LEAF + LOWERS * LEAF_BYTES };
enum { UPPER_CHILDREN = 32 + 4096, UPPER_TABLE = 8256, LOWER_CHILDREN = 32 + 512, LOWER_TABLE = 1088, LEAF_VALUES = 96 };

static uint64_t good[BYTES / 8], data_words[BYTES / 8];

static void put(size_t at, uint64_t value, size_t bytes)
{
    memcpy((unsigned char *)good + at, &value, bytes);
}

static void put_double(size_t at, double value)
{
    memcpy((unsigned char *)good + at, &value, sizeof value);
}

/* Two leaves of one value each, below lower nodes of their own, at 0 and 128 along z. */
static void make_good(void)
{
    memcpy(good, "NanoVDB0", 8);
    put(16, 32u << 21 | 4u << 10, 4);
    put(32, BYTES, 8);
    put(632, 2, 4), put(636, 1, 4); /* a fog volume of floats */
    for (size_t i = 0; i < 3; i++) {
        put_double(296 + 88 + 32 * i, .25); /* the diagonal of the map */
    }
    put(TREE + 24, ROOT - TREE, 8);
    put(ROOT + 24, 1, 4);
    put(TILES + 8, UPPER - ROOT, 8);
    put(UPPER + UPPER_CHILDREN, 3, 1);
    for (size_t i = 0; i < LOWERS; i++) {
        size_t lower = LOWER + i * LOWER_BYTES, leaf = LEAF + i * LEAF_BYTES;
        put(UPPER + UPPER_TABLE + 8 * i, lower - UPPER, 8);
        put(lower + LOWER_CHILDREN, 1, 1);
        put(lower + LOWER_TABLE, leaf - lower, 8);
        for (size_t n = 0; n < 512; n++) {
            put(leaf + LEAF_VALUES + 4 * n, 0x3f000000, 4);
        }
    }
}

static size_t place(const uint8_t *record)
{
    static const size_t parts[] = {GRID,
                                   TREE,
                                   ROOT,
                                   TILES,
                                   UPPER,
                                   UPPER + UPPER_CHILDREN,
                                   UPPER + UPPER_TABLE,
                                   LOWER,
                                   LOWER + LOWER_CHILDREN,
                                   LOWER + LOWER_TABLE,
                                   LEAF,
                                   LEAF + LEAF_VALUES};
    size_t offset = record[1] | (size_t)record[2] << 8 | (size_t)record[3] << 16;
    return (parts[record[0] % (sizeof parts / sizeof *parts)] + offset) % (BYTES - 8);
}

/* What every volume that is read has to be. */
static void check(const nvdb_volume *v)
{
    size_t bricks = (size_t)((v->nx + 8) / 8) * ((v->ny + 8) / 8) * ((v->nz + 8) / 8);
    for (size_t i = 0; i < bricks; i++) {
        if (v->grid->blocks[i] >= v->grid->block_count) {
            abort();
        }
    }
    for (size_t i = 0; i < (size_t)v->grid->block_count * VOLGRAD_BLOCK_SAMPLES; i++) {
        if (!(v->grid->density[i] >= 0)) {
            abort();
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    enum { RECORD = 12 };
    if (good[0] == 0) {
        make_good();
    }
    memcpy(data_words, good, sizeof good);
    for (size_t i = 0; i + RECORD <= size; i += RECORD) {
        memcpy((unsigned char *)data_words + place(data + i), data + i + 4, 8);
    }
    /* What is left shortens the grid. */
    size_t cut = size % RECORD ? (size_t)data[size - 1] << (size % RECORD) : 0;
    xml_document document = {.path = "fuzz.xml"};
    xml_node node = {.document = &document};
    nvdb_grid grid = {malloc(sizeof good), sizeof good - cut};
    nvdb_volume volume;
    memcpy(grid.words, data_words, sizeof good);
    if (nvdb_bricks(&node, "tree", &grid, &volume)) {
        check(&volume);
        nvdb_free(volume.grid);
    }
    free(grid.words);
    return 0;
}
