/* Layout, little endian: 'V' 'O' 'L', u8 version 3, i32 encoding (1: float32), i32 nx ny nz, i32 channels, f32 box minimum and
   maximum, then the values, x fastest. Source: Mitsuba 3's documentation of gridvolume. */
#include "vol_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define HEADER_BYTES 48
#define VERSION 3
#define FLOAT32 1
#define MAX_SIDE 65536 /* more than any memory holds; keeps the product of three far from overflow */

static uint32_t read_u32(const unsigned char *bytes)
{
    return bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

static float read_f32(const unsigned char *bytes)
{
    uint32_t bits = read_u32(bytes);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static int check_format(const xml_node *node, const char *path, const unsigned char *header)
{
    uint32_t encoding = read_u32(header + 4), channels = read_u32(header + 20);
    if (memcmp(header, "VOL", 3) != 0) {
        return xml_error(node, "%s is no .vol file: it does not begin with VOL", path);
    }
    if (header[3] != VERSION) {
        return xml_error(node, "%s is a .vol file of version %d; version 3 is needed", path, header[3]);
    }
    if (encoding != FLOAT32) {
        return xml_error(node, "%s has encoding %u; 1 (float32) is needed", path, (unsigned)encoding);
    }
    if (channels != 1) {
        return xml_error(node, "%s has %u channels; a density has 1", path, (unsigned)channels);
    }
    return 1;
}

static int read_header(const xml_node *node, const char *path, FILE *file, vol_grid *out)
{
    unsigned char header[HEADER_BYTES];
    if (fread(header, 1, HEADER_BYTES, file) != HEADER_BYTES) {
        return xml_error(node, "%s is shorter than the 48 bytes of a .vol file's header", path);
    }
    if (!check_format(node, path, header)) {
        return 0;
    }
    uint32_t n[3];
    for (int i = 0; i < 3; i++) {
        n[i] = read_u32(header + 8 + 4 * i);
        out->box_min[i] = read_f32(header + 24 + 4 * i);
        out->box_max[i] = read_f32(header + 36 + 4 * i);
        if (n[i] < 1 || n[i] > MAX_SIDE) {
            return xml_error(node, "%s has a side of %ld samples; from 1 to %d are possible", path, (long)(int32_t)n[i],
                             MAX_SIDE);
        }
    }
    out->nx = n[0], out->ny = n[1], out->nz = n[2];
    return 1;
}

/* Bytes after the header; -1 if unknown. */
static long long bytes_left(FILE *file)
{
    long end = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    return end < 0 || fseek(file, HEADER_BYTES, SEEK_SET) != 0 ? -1 : (long long)end - HEADER_BYTES;
}

static int check_density(const xml_node *node, const char *path, const vol_grid *grid, size_t i)
{
    float value = grid->density[i];
    if (value >= 0 && isfinite(value)) {
        return 1;
    }
    xml_error(node, "%s: sample (%zu, %zu, %zu) is %g; a density is finite and not negative", path, i % grid->nx,
              i / grid->nx % grid->ny, i / grid->nx / grid->ny, (double)value);
    return 0;
}

static int read_density(const xml_node *node, const char *path, FILE *file, vol_grid *grid)
{
    size_t count = (size_t)grid->nx * grid->ny * grid->nz;
    long long bytes = bytes_left(file);
    if (bytes < 0 || (unsigned long long)bytes != 4ull * count) {
        return xml_error(node, "%s has %lld bytes of values; its %u x %u x %u samples take %llu", path, bytes, (unsigned)grid->nx,
                         (unsigned)grid->ny, (unsigned)grid->nz, 4ull * count);
    }
    grid->density = malloc(4 * count);
    if (!grid->density) {
        return xml_out_of_memory(node);
    }
    if (fread(grid->density, 4, count, file) != count) {
        return xml_error(node, "%s cannot be read", path);
    }
    for (size_t i = 0; i < count; i++) {
        unsigned char raw[4];
        memcpy(raw, &grid->density[i], sizeof raw);
        grid->density[i] = read_f32(raw);
        if (!check_density(node, path, grid, i)) {
            return 0;
        }
    }
    return 1;
}

int vol_load(const xml_node *node, const char *path, vol_grid *out)
{
    *out = (vol_grid){0};
    FILE *file = fopen(path, "rb");
    if (!file) {
        return xml_error(node, "cannot open %s; file names are relative to the scene file", path);
    }
    int ok = read_header(node, path, file, out) && read_density(node, path, file, out);
    fclose(file);
    if (!ok) {
        free(out->density);
        out->density = NULL;
    }
    return ok;
}
