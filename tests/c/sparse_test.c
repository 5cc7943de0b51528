/* Sparse grids: what volgrad_scene_init checks of them, and that they are the dense grid of the same samples. */

#include "small_scene.h"

enum { NX = 20, NY = 9, NZ = 7, BRICKS = 3 * 2 * 1, SAMPLES = VOLGRAD_BLOCK_SAMPLES };

static small_scene s;
static float dense[NZ][NY][NX];
static float blocks[2][9][9][9];
static uint32_t of_brick[BRICKS];
static struct {
    volgrad_sparse_grid grid;
    unsigned char newer[8];
} sparse;
static alignas(16) unsigned char memory[2][1 << 14];
static const volgrad_scene *scene;

static int near_inside(int sample, int count) {
    return sample < 0 ? 0 : sample < count ? sample : count - 1;
}

/* Densities in the first 7 samples along each axis, so in the first brick alone; all others share a block without any. */
static void fill(void) {
    memset(&sparse, 0, sizeof sparse);
    for (int z = 0; z < NZ; z++)
        for (int y = 0; y < NY; y++)
            for (int x = 0; x < NX; x++) dense[z][y][x] = x < 7 && y < 7 ? 1 + x + 0.5f * (float)y * (float)z : 0;
    for (int z = 0; z < 9; z++)
        for (int y = 0; y < 9; y++)
            for (int x = 0; x < 9; x++) {
                blocks[0][z][y][x] = 0;
                blocks[1][z][y][x] = dense[near_inside(z - 1, NZ)][near_inside(y - 1, NY)][near_inside(x - 1, NX)];
            }
    memset(of_brick, 0, sizeof of_brick);
    of_brick[0] = 1;
    sparse.grid = (volgrad_sparse_grid){sizeof sparse.grid, 2, of_brick, &blocks[0][0][0][0]};
    small_scene_fill(&s);
    s.desc.media_count = 2;
    s.media[1].kind = VOLGRAD_MEDIUM_SPARSE_GRID;
    s.media[1].custom = &sparse.grid;
    s.media[1].nx = NX, s.media[1].ny = NY, s.media[1].nz = NZ;
    s.media[1].local_to_world[0] = s.media[1].local_to_world[5] = s.media[1].local_to_world[10] = 2;
}

static void refuse(volgrad_status status, const char *name, const char *what, int line) {
    volgrad_error error = {sizeof error, 77, NULL};
    check_status(volgrad_scene_init(memory[0], sizeof memory[0], &s.desc, &scene, &error), status, what, __FILE__, line);
    int named = error.field != NULL && strcmp(error.field, name) == 0 && error.index == 1;
    check_that(named, what, __FILE__, line);
    if (!named) fprintf(stderr, "  blamed: %s %u\n", error.field ? error.field : "NULL", (unsigned)error.index);
    fill();
}

#define BAD(set, status, name) ((set), refuse((status), (name), #set, __LINE__))

static void test_description(void) {
    volgrad_sparse_grid *g = &sparse.grid;
    volgrad_medium *m = &s.media[1];
    const char *sides = "media.nx, media.ny, media.nz", *density = "media.custom.density";
    BAD(m->custom = NULL, VOLGRAD_ERROR_NULL, "media.custom");
    BAD(m->custom = memory[0] + 1, VOLGRAD_ERROR_MISALIGNED, "media.custom");
    BAD(m->kind = VOLGRAD_MEDIUM_HOMOGENEOUS, VOLGRAD_ERROR_RANGE, "media.custom");
    BAD(g->struct_size = sizeof *g - 1, VOLGRAD_ERROR_STRUCT_SIZE, "media.custom");
    BAD((g->struct_size = sizeof sparse, sparse.newer[7] = 1), VOLGRAD_ERROR_STRUCT_SIZE, "media.custom");
    BAD(g->blocks = NULL, VOLGRAD_ERROR_NULL, "media.custom.blocks");
    BAD(g->density = NULL, VOLGRAD_ERROR_NULL, density);
    BAD(of_brick[BRICKS - 1] = 2, VOLGRAD_ERROR_INDEX, "media.custom.blocks");
    BAD(of_brick[0] = VOLGRAD_NONE, VOLGRAD_ERROR_INDEX, "media.custom.blocks");
    BAD(g->block_count = 1, VOLGRAD_ERROR_INDEX, "media.custom.blocks");
    BAD(g->block_count = 0, VOLGRAD_ERROR_INDEX, "media.custom.blocks");
    BAD(blocks[1][8][8][8] = NAN, VOLGRAD_ERROR_NOT_FINITE, density);
    BAD(blocks[1][0][0][0] = INFINITY, VOLGRAD_ERROR_NOT_FINITE, density);
    BAD(blocks[0][4][4][4] = -1, VOLGRAD_ERROR_RANGE, density);
    BAD(m->nx = 0, VOLGRAD_ERROR_RANGE, sides);
    BAD(m->nz = UINT32_MAX, VOLGRAD_ERROR_RANGE, sides);
    BAD((m->nx = m->ny = m->nz = 1u << 20), VOLGRAD_ERROR_RANGE, sides); /* 2^51 bricks */
    BAD(m->local_to_world[5] = 0, VOLGRAD_ERROR_RANGE, "media.local_to_world");
    /* A box of 2^33 samples is no dense grid, but a sparse one. */
    size_t bytes = 0;
    m->nx = m->ny = m->nz = 2048;
    CHECK_STATUS(volgrad_scene_size(&s.desc, &bytes), VOLGRAD_OK);
    CHECK(bytes > (size_t)8 * 257 * 257 * 257 && bytes < (size_t)9 * 257 * 257 * 257);
    fill();
}

/* The same bits from both, along lines through full bricks, empty ones and nothing. */
static void test_lines(void) {
    const volgrad_scene *scenes[2];
    CHECK_STATUS(volgrad_scene_init(memory[0], sizeof memory[0], &s.desc, &scenes[0], NULL), VOLGRAD_OK);
    s.media[1].kind = VOLGRAD_MEDIUM_GRID;
    s.media[1].custom = NULL;
    s.media[1].density = &dense[0][0][0];
    CHECK_STATUS(volgrad_scene_init(memory[1], sizeof memory[1], &s.desc, &scenes[1], NULL), VOLGRAD_OK);
    volgrad_segment segment = {INFINITY, 1, {0, 0, 0}};
    int dark = 0;
    for (int i = 0; i < 100; i++) {
        float angle = 0.016f * (float)i;
        volgrad_line line = {{0.1f, 0.2f, -0.5f}, {sinf(angle), 0.0f, cosf(angle)}, 4, 1, &segment};
        volgrad_optical_depth depths[2];
        volgrad_flight flights[2];
        for (int k = 0; k < 2; k++) {
            memset(&depths[k], 0, sizeof depths[k]), memset(&flights[k], 0, sizeof flights[k]);
            CHECK_STATUS(volgrad_line_optical_depth(scenes[k], &line, &depths[k]), VOLGRAD_OK);
            CHECK_STATUS(volgrad_line_sample_distance(scenes[k], &line, 0.4, &flights[k]), VOLGRAD_OK);
        }
        CHECK(memcmp(&depths[0], &depths[1], sizeof depths[0]) == 0);
        CHECK(memcmp(&flights[0], &flights[1], sizeof flights[0]) == 0);
        dark += depths[0].tau.r > 0.1f;
    }
    CHECK(dark > 30);
    fill();
}

int main(void) {
    fill();
    test_description();
    test_lines();
    return check_end();
}
