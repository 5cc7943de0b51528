/* Tests of the .nvdb reader: the files of nvdb_write against what NanoVDB's own library says is in them, and damaged files.

   Usage: nvdb_test FOLDER, in which nvdb_write has written. Writes into that folder. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "nvdb.h"
#include "scene.h"

static const char *folder;
static char messages[4096];
static int passed, failed;

#define CHECK(condition) check((condition) != 0, #condition, __LINE__)

static void check(int ok, const char *what, int line)
{
    ok ? passed++ : failed++;
    if (!ok) {
        printf("nvdb_test.c:%d: failed: %s\n", line, what);
    }
}

static const char *path_of(const char *name)
{
    static char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

/* ---- good files ---- */

typedef struct {
    scene loaded;
    void *memory;
    const volgrad_scene *scene;
} world;

static int world_load(world *w, const char *name)
{
    size_t bytes = 0;
    if (!scene_load(path_of(name), &w->loaded)) {
        return 0;
    }
    volgrad_scene_size(&w->loaded.desc, &bytes);
    w->memory = aligned_alloc(16, (bytes + 15) / 16 * 16);
    return volgrad_scene_init(w->memory, bytes, &w->loaded.desc, &w->scene, NULL) == VOLGRAD_OK;
}

static void world_free(world *w)
{
    free(w->memory);
    scene_free(&w->loaded);
}

static volgrad_optical_depth depth_of(const world *w, const volgrad_line *line)
{
    volgrad_optical_depth depth;
    memset(&depth, 0, sizeof depth);
    CHECK(volgrad_line_optical_depth(w->scene, line, &depth) == VOLGRAD_OK);
    return depth;
}

static float random_float(float low, float high)
{
    static uint32_t state = 1;
    state = state * 1664525u + 1013904223u;
    return low + (high - low) * (float)(state >> 8) / (float)(1 << 24);
}

/* The same numbers; zeros may differ in sign. */
static int equal(const float *a, const float *b, size_t count)
{
    size_t i = 0;
    while (i < count && a[i] == b[i]) {
        i++;
    }
    return i == count;
}

/* A line between two random points around the grid. */
static volgrad_line random_line(volgrad_segment *segment)
{
    volgrad_vec3 a = {random_float(-1, 1), random_float(-2, 2), random_float(.5f, 1.8f)}, d;
    float length;
    do {
        d = (volgrad_vec3){random_float(-1, 1), random_float(-1, 1), random_float(-1, 1)};
        length = sqrtf(d.x * d.x + d.y * d.y + d.z * d.z);
    } while (length < .1f);
    *segment = (volgrad_segment){INFINITY, 0, {0, 0, 0}};
    return (volgrad_line){a, {d.x / length, d.y / length, d.z / length}, 4, 1, segment};
}

/* The same as from a dense grid, bit for bit, and kept in much less. */
static void test_dense(void)
{
    world sparse = {0}, dense = {0};
    if (!world_load(&sparse, "nvdb.xml") || !world_load(&dense, "vol.xml")) {
        check(0, "nvdb.xml, vol.xml", __LINE__);
        return;
    }
    const volgrad_medium *s = sparse.loaded.desc.media, *d = dense.loaded.desc.media;
    CHECK(s->nx == d->nx && s->ny == d->ny && s->nz == d->nz);
    CHECK(equal(s->local_to_world, d->local_to_world, 12));
    int thick = 0;
    for (int i = 0; i < 3000; i++) {
        volgrad_segment segment;
        volgrad_line line = random_line(&segment);
        volgrad_optical_depth a = depth_of(&sparse, &line), b = depth_of(&dense, &line);
        CHECK(equal(&a.tau.r, &b.tau.r, sizeof a / sizeof a.tau.r));
        thick += a.tau.r > .1f;
    }
    CHECK(thick > 300);
    const volgrad_sparse_grid *grid = s->custom;
    size_t kept = grid->block_count * (size_t)VOLGRAD_BLOCK_SAMPLES, all = (size_t)d->nx * d->ny * d->nz;
    /* 64 leaves' worth of the ball, the shell of the cube, with the neighbours that they reach into. */
    CHECK(kept < all / 2);
    world_free(&sparse);
    world_free(&dense);
}

/* Values at points, as NanoVDB interpolates them: along a line through a point that is short beside a voxel. */
static void test_points(void)
{
    const float half = 1.f / 8192;
    world w = {0};
    FILE *file = fopen(path_of("points.bin"), "rb");
    if (!file || !world_load(&w, "nvdb.xml")) {
        check(0, "points.bin, nvdb.xml", __LINE__);
        return;
    }
    float p[4], scale = w.loaded.desc.media[0].sigma_t.r;
    int count = 0, positive = 0;
    for (; fread(p, sizeof p, 1, file) == 1; count++) {
        volgrad_segment segment = {INFINITY, 0, {0, 0, 0}};
        volgrad_line line = {{p[0], p[1] - half, p[2]}, {0, 1, 0}, 2 * half, 1, &segment};
        double value = depth_of(&w, &line).tau.r / (2 * half * scale);
        int ok = fabs(value - p[3]) < .01;
        check(ok, "the value at a point", __LINE__);
        if (!ok) {
            printf("  (%g, %g, %g): %g, expected %g\n", (double)p[0], (double)p[1], (double)p[2], value, (double)p[3]);
        }
        positive += p[3] > 0;
    }
    CHECK(count == 4000 && positive > 500 && positive < 3500);
    fclose(file);
    world_free(&w);
}

/* ---- bad files ---- */

typedef struct {
    unsigned char *data;
    size_t bytes;
} content;

static content read_all(const char *name)
{
    content c = {NULL, 0};
    FILE *file = fopen(path_of(name), "rb");
    if (file && fseek(file, 0, SEEK_END) == 0) {
        c.bytes = (size_t)ftell(file);
        rewind(file);
        c.data = malloc(c.bytes);
        c.bytes = fread(c.data, 1, c.bytes, file);
    }
    if (file) {
        fclose(file);
    }
    check(c.data != NULL, name, __LINE__);
    return c;
}

/* Reads grid `grid` of a file, with what is reported going into `messages`. */
static int try_to_read(const char *path, const char *grid, nvdb_volume *volume)
{
    xml_document document = {.path = "test.xml"};
    xml_node node = {.document = &document, .line = 1, .column = 1};
    nvdb_grid data = {NULL, 0};
    char log[512];
    snprintf(log, sizeof log, "%s/messages", folder);
    fflush(stderr);
    int saved = dup(STDERR_FILENO);
    if (saved < 0 || !freopen(log, "w+", stderr)) {
        exit(2);
    }
    int ok = nvdb_read(&node, path, grid, &data) && nvdb_bricks(&node, path, &data, volume);
    free(data.words);
    rewind(stderr);
    messages[fread(messages, 1, sizeof messages - 1, stderr)] = '\0';
    fflush(stderr);
    dup2(saved, STDERR_FILENO);
    close(saved);
    CHECK(ok == (document.errors == 0));
    return ok;
}

static void refuse_file(const char *name, const char *grid, const char *says, int line)
{
    char path[512];
    nvdb_volume volume;
    snprintf(path, sizeof path, "%s", path_of(name));
    int ok = try_to_read(path, grid, &volume);
    check(!ok, "refused", line);
    check(strstr(messages, says) != NULL, says, line);
    if (!strstr(messages, says)) {
        printf("  %s", messages);
    }
    if (ok) {
        nvdb_free(volume.grid);
    }
}

static void accept_file(const char *name, const char *grid, int line)
{
    nvdb_volume volume;
    char path[512];
    snprintf(path, sizeof path, "%s", path_of(name));
    int ok = try_to_read(path, grid, &volume);
    check(ok, messages, line);
    if (ok) {
        nvdb_free(volume.grid);
    }
}

#define REFUSE(name, grid, says) refuse_file(name, grid, says, __LINE__)

static void test_kinds(void)
{
    REFUSE("absent.nvdb", NULL, "cannot open");
    REFUSE("cloud.vol", NULL, "is no .nvdb file");
    REFUSE("double.nvdb", NULL, "is of type double; float is needed");
    REFUSE("level_set.nvdb", NULL, "is of class level set; a density is a fog volume");
    REFUSE("background.nvdb", NULL, "the background is not 0");
    REFUSE("negative.nvdb", NULL, "a density is finite and not negative");
    REFUSE("empty.nvdb", NULL, "has no density anywhere");
    REFUSE("two.nvdb", NULL, "has 2 grids; name one with <string name=\"grid\" value=\"...\"/>: density, temperature");
    REFUSE("two.nvdb", "smoke", "has no grid \"smoke\"; it has: density, temperature");
    REFUSE("two.nvdb", "temperature", "is of type double");
    accept_file("two.nvdb", "density", __LINE__);
}

static void write_copy(const content *c, size_t bytes)
{
    FILE *file = fopen(path_of("bad.nvdb"), "wb");
    if (!file || fwrite(c->data, 1, bytes, file) != bytes || fclose(file) != 0) {
        exit(2);
    }
}

/* Writes a changed copy, which has to be refused. */
static void refuse_copy(const content *c, size_t bytes, const char *says, int line)
{
    write_copy(c, bytes);
    refuse_file("bad.nvdb", NULL, says, line);
}

static void accept_copy(const content *c, int line)
{
    write_copy(c, c->bytes);
    accept_file("bad.nvdb", NULL, line);
}

static void put(unsigned char *at, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++) {
        at[i] = (unsigned char)(value >> 8 * i);
    }
}

/* The file with `value` at `offset`, and then as it was. */
static void refuse_value(content *c, size_t offset, uint64_t value, int bytes, const char *says, int line)
{
    unsigned char before[8];
    memcpy(before, c->data + offset, sizeof before);
    put(c->data + offset, value, bytes);
    refuse_copy(c, c->bytes, says, line);
    memcpy(c->data + offset, before, sizeof before);
}

#define WITH(offset, value, bytes, says) refuse_value(&c, (size_t)(offset), (uint64_t)(value), bytes, says, __LINE__)

static uint64_t word(const content *c, size_t at, int bytes)
{
    uint64_t value = 0;
    for (int i = bytes; i-- > 0;) {
        value = value << 8 | c->data[at + (size_t)i];
    }
    return value;
}

static void test_container(void)
{
    content c = read_all("zip.nvdb");
    const size_t data = 16 + 176 + sizeof "density";
    for (size_t bytes = 0; bytes < c.bytes; bytes += bytes < data + 16 ? 1 : 5000) {
        refuse_copy(&c, bytes, "ends too early", __LINE__);
    }
    WITH(0, 'X', 1, "is no .nvdb file");
    WITH(7, '7', 1, "is no .nvdb file");
    WITH(8, 31u << 21 | 5u << 10, 4, "is of NanoVDB's version 31.5; version 32 is needed");
    WITH(12, 0, 2, "a segment without grids");
    WITH(12, 0xffff, 2, "ends too early");
    WITH(16, UINT64_MAX, 8, "cannot have 18446744073709551615 bytes");
    WITH(16, 1u << 30, 8, "cannot have 1073741824 bytes");
    WITH(16, 1000, 8, "the zlib stream of grid density is damaged");
    WITH(24, UINT64_MAX, 8, "ends too early");
    WITH(24, 8, 8, "is no .nvdb file"); /* what follows is taken for another segment */
    WITH(16 + 32, 99, 4, "is of type an unknown type");
    WITH(16 + 136, UINT32_MAX, 4, "ends too early");
    WITH(16 + 168, 2, 2, "is compressed with BLOSC");
    WITH(16 + 168, 7, 2, "is compressed with codec 7");
    WITH(16 + 168, 0, 2, "cannot have");
    WITH(data, UINT64_MAX, 8, "cannot have");
    WITH(data + 100, 0x1234567890abcdef, 8, "the zlib stream of grid density is damaged");
    free(c.data);
}

/* Offsets of NanoVDB's structs, version 32, float. */
enum { GRID_VERSION = 16, GRID_MATRIX = 296 + 88, GRID_TYPE = 636, TREE = 672, TREE_ROOT = TREE + 24 };
enum { ROOT_TILES = 24, ROOT_BACKGROUND = 28, ROOT_TILE = 64, TILE_BYTES = 32, TILE_CHILD = 8 };
enum { UPPER_CHILDREN = 32 + 4096, UPPER_TABLE = 8256, LOWER_CHILDREN = 32 + 512, LOWER_TABLE = 1088, LEAF_VALUES = 96 };

static size_t first_child(const content *c, size_t node, size_t mask, size_t table, size_t *entry)
{
    size_t n = 0;
    while (!(c->data[node + mask + n / 8] >> n % 8 & 1)) {
        n++;
    }
    *entry = node + table + 8 * n;
    return node + (size_t)word(c, *entry, 8);
}

static void test_tree(void)
{
    content c = read_all("small.nvdb");
    const size_t grid = 16 + 176 + sizeof "density", root = grid + TREE + (size_t)word(&c, grid + TREE_ROOT, 8);
    const size_t tile = root + ROOT_TILE, upper = root + (size_t)word(&c, tile + TILE_CHILD, 8);
    size_t lower_entry, leaf_entry, lower = first_child(&c, upper, UPPER_CHILDREN, UPPER_TABLE, &lower_entry);
    size_t leaf = first_child(&c, lower, LOWER_CHILDREN, LOWER_TABLE, &leaf_entry);

    WITH(grid, 0, 1, "not those of a NanoVDB float grid");
    WITH(grid + GRID_VERSION, 31u << 21, 4, "not those of a NanoVDB float grid");
    WITH(grid + GRID_TYPE, 2, 4, "not those of a NanoVDB float grid");
    WITH(grid + GRID_MATRIX + 64, 0, 8, "has no inverse");
    WITH(grid + GRID_MATRIX, UINT64_MAX, 8, "has no inverse");
    /* Outside the grid, or not aligned. */
    const uint64_t outside[] = {1, 4, c.bytes, 1ull << 40, UINT64_MAX / 2 + 1, UINT64_MAX};
    for (size_t i = 0; i < sizeof outside / sizeof *outside; i++) {
        WITH(grid + TREE_ROOT, outside[i], 8, ": the root at byte");
        WITH(tile + TILE_CHILD, outside[i], 8, ": an upper node at byte");
        WITH(lower_entry, outside[i], 8, ": a lower node at byte");
        WITH(leaf_entry, outside[i], 8, ": a leaf at byte");
    }
    WITH(root + ROOT_TILES, UINT32_MAX, 4, "the root at byte");
    WITH(root + ROOT_BACKGROUND, 0x3f800000, 4, "the background is not 0");
    WITH(leaf + LEAF_VALUES, 0x7fc00000, 4, "a density is finite and not negative");
    WITH(leaf + LEAF_VALUES + 511 * 4, 0xbf800000, 4, "is -1; a density");
    WITH(leaf + LEAF_VALUES, 0x7f800000, 4, "is inf; a density");
    WITH(tile, word(&c, tile + TILE_BYTES, 8), 8, "two nodes of the tree are at the same place");
    WITH(tile, 0x400ull << 42, 8, "leaves of 8^3 voxels; with two more along each axis 134217728 are possible");
    refuse_copy(&c, c.bytes - 1, "ends too early", __LINE__);
    c.data[7] = '2', c.data[grid + 7] = '1'; /* the magic numbers of later versions */
    accept_copy(&c, __LINE__);
    free(c.data);
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: nvdb_test FOLDER\n");
        return 2;
    }
    folder = argv[1];
    test_dense();
    test_points();
    test_kinds();
    test_container();
    test_tree();
    remove(path_of("bad.nvdb"));
    remove(path_of("messages"));
    printf("%d passed, %d failed\n", passed, failed);
    return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
