/* The container of NanoVDB grids, little endian: segments, each a header of 16 bytes (magic, version, u16 number of grids, u16 codec),
   for each grid 176 bytes of metadata and its name, and then the grids' data; zip: u64 length and a zlib stream.
   Source: OpenVDB, nanovdb/util/IO.h. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "nvdb.h"

enum { HEADER_BYTES = 16, METADATA_BYTES = 176, LENGTH_BYTES = 8 };
enum { CODEC_NONE, CODEC_ZIP, CODEC_BLOSC };
enum { TYPE_FLOAT = 1, CLASS_UNKNOWN = 0, CLASS_FOG = 2 };

/* Offsets in the metadata. */
enum { GRID_BYTES = 0, FILE_BYTES = 8, GRID_TYPE = 32, GRID_CLASS = 36, NAME_BYTES = 136, CODEC = 168 };

/* Of a name, that of a grid has no more. */
enum { MOST_NAME = 255 };

/* zlib compresses by no more than this. */
#define MOST_COMPRESSION 1032

/* A file in memory, and how much of it has been read. */
typedef struct {
    const xml_node *node;
    const char *path;
    unsigned char *data;
    uint64_t bytes, at;
} input;

/* One of the grids in a file. */
typedef struct {
    const char *name;
    unsigned name_length;
    uint32_t type, grid_class, codec;
    uint64_t bytes, file_bytes, start;
} entry;

static uint64_t number(const unsigned char *data, int bytes)
{
    uint64_t value = 0;
    for (int i = bytes; i-- > 0;) {
        value = value << 8 | data[i];
    }
    return value;
}

static const unsigned char *take(input *in, uint64_t bytes)
{
    if (bytes > in->bytes - in->at) {
        xml_error(in->node, "%s ends too early: after byte %llu another %llu bytes are needed, %llu are there", in->path,
                  (unsigned long long)in->at, (unsigned long long)bytes, (unsigned long long)(in->bytes - in->at));
        return NULL;
    }
    in->at += bytes;
    return in->data + (in->at - bytes);
}

static int load(input *in)
{
    FILE *file = fopen(in->path, "rb");
    if (!file) {
        return xml_error(in->node, "cannot open %s; file names are relative to the scene file", in->path);
    }
    long end = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    int ok = end >= 0 && fseek(file, 0, SEEK_SET) == 0;
    if (ok) {
        in->bytes = (uint64_t)end;
        in->data = malloc(in->bytes ? (size_t)in->bytes : 1);
        ok = in->data && fread(in->data, 1, (size_t)in->bytes, file) == in->bytes;
    }
    fclose(file);
    return ok ? 1 : xml_error(in->node, "%s cannot be read", in->path);
}

/* Returns the number of grids in the segment that begins here, 0 on an error. */
static unsigned read_header(input *in)
{
    const unsigned char *header = take(in, HEADER_BYTES);
    if (!header) {
        return 0;
    }
    /* Later versions of the library write a 2 for files; what follows is the same. */
    if (memcmp(header, "NanoVDB", 7) != 0 || (header[7] != '0' && header[7] != '2')) {
        return (unsigned)xml_error(in->node, "%s is no .nvdb file: it does not begin with NanoVDB0 or NanoVDB2", in->path);
    }
    unsigned version = (unsigned)number(header + 8, 4), count = (unsigned)number(header + 12, 2);
    if (version >> 21 != 32) {
        return (unsigned)xml_error(in->node, "%s is of NanoVDB's version %u.%u; version 32 is needed", in->path, version >> 21,
                                   version >> 10 & 0x7ff);
    }
    return count ? count : (unsigned)xml_error(in->node, "%s has a segment without grids; write the file anew", in->path);
}

static int read_metadata(input *in, entry *out)
{
    const unsigned char *data = take(in, METADATA_BYTES);
    if (!data) {
        return 0;
    }
    uint32_t name_bytes = (uint32_t)number(data + NAME_BYTES, 4);
    *out = (entry){.type = (uint32_t)number(data + GRID_TYPE, 4),
                   .grid_class = (uint32_t)number(data + GRID_CLASS, 4),
                   .codec = (uint32_t)number(data + CODEC, 2),
                   .bytes = number(data + GRID_BYTES, 8),
                   .file_bytes = number(data + FILE_BYTES, 8)};
    const unsigned char *name = take(in, name_bytes);
    if (name) {
        const unsigned char *end = memchr(name, 0, name_bytes);
        out->name = (const char *)name;
        uint64_t length = end ? (uint64_t)(end - name) : name_bytes;
        out->name_length = length < MOST_NAME ? (unsigned)length : MOST_NAME;
    }
    return name != NULL;
}

static int is_called(const entry *grid, const char *name)
{
    return grid->name_length == strlen(name) && memcmp(grid->name, name, grid->name_length) == 0;
}

/* What has been found in a file so far. */
typedef struct {
    const char *wanted; /* NULL: any */
    entry found;
    unsigned matches, grids;
    char names[512]; /* of all grids, as many as fit */
} search;

static void note(search *s, const entry *grid)
{
    size_t length = strlen(s->names);
    snprintf(s->names + length, sizeof s->names - length, "%s%.*s", s->grids ? ", " : "", (int)grid->name_length, grid->name);
    s->grids++;
    if (!s->wanted || is_called(grid, s->wanted)) {
        s->found = *grid;
        s->matches++;
    }
}

/* The metadata of one segment, read again once the number of all its grids' bytes is known: they lie after the last name. */
static int read_segment(input *in, search *s)
{
    unsigned count = read_header(in);
    uint64_t metadata = in->at;
    entry grid;
    for (unsigned i = 0; i < count; i++) {
        if (!read_metadata(in, &grid)) {
            return 0;
        }
    }
    uint64_t data = in->at;
    in->at = metadata;
    for (unsigned i = 0; i < count; i++) {
        uint64_t next = read_metadata(in, &grid) ? in->at : 0;
        in->at = grid.start = data;
        if (!next || !take(in, grid.file_bytes)) {
            return 0;
        }
        data = in->at;
        in->at = next;
        note(s, &grid);
    }
    in->at = data;
    return count > 0;
}

static int find(input *in, search *s)
{
    do {
        if (!read_segment(in, s)) {
            return 0;
        }
    } while (in->at < in->bytes);
    if (s->matches == 0) {
        return xml_error(in->node, "%s has no grid \"%s\"; it has: %s", in->path, s->wanted, s->names);
    }
    if (s->matches > 1) {
        const char *what = s->wanted ? "of this name; rename them" : "; name one with <string name=\"grid\" value=\"...\"/>";
        return xml_error(in->node, "%s has %u grids%s%s: %s", in->path, s->matches, s->wanted ? " " : "", what, s->names);
    }
    return 1;
}

static const char *type_name(uint32_t type)
{
    static const char *const names[] = {"no type", "float", "double", "int16", "int32", "int64", "vec3f", "vec3d", "mask", "half",
                                        "uint32", "bool", "rgba8", "fp4", "fp8", "fp16", "fpn", "vec4f", "vec4d", "index"};
    return type < sizeof names / sizeof *names ? names[type] : "an unknown type";
}

static const char *class_name(uint32_t grid_class)
{
    static const char *const names[] = {"unknown",     "level set",  "fog volume", "staggered",
                                        "point index", "point data", "topology",   "voxel volume"};
    return grid_class < sizeof names / sizeof *names ? names[grid_class] : "special";
}

static int check_kind(const input *in, const entry *grid)
{
    if (grid->type != TYPE_FLOAT) {
        return xml_error(in->node, "%s: grid %.*s is of type %s; float is needed", in->path, (int)grid->name_length, grid->name,
                         type_name(grid->type));
    }
    if (grid->grid_class != CLASS_FOG && grid->grid_class != CLASS_UNKNOWN) {
        return xml_error(in->node, "%s: grid %.*s is of class %s; a density is a fog volume", in->path, (int)grid->name_length,
                         grid->name, class_name(grid->grid_class));
    }
    if (grid->codec == CODEC_BLOSC) {
        return xml_error(in->node, "%s is compressed with BLOSC; write it with zip or without compression (nanovdb_convert -z)",
                         in->path);
    }
    if (grid->codec != CODEC_NONE && grid->codec != CODEC_ZIP) {
        return xml_error(in->node, "%s is compressed with codec %u; 0 (none) and 1 (zip) are possible", in->path,
                         (unsigned)grid->codec);
    }
    return 1;
}

/* The length of the grid's bytes as compressed; 0 if that does not fit what the file says. */
static uint64_t compressed_bytes(const input *in, const entry *grid)
{
    if (grid->codec == CODEC_NONE) {
        return grid->bytes == grid->file_bytes ? grid->bytes : 0;
    }
    if (grid->file_bytes < LENGTH_BYTES || number(in->data + grid->start, LENGTH_BYTES) != grid->file_bytes - LENGTH_BYTES) {
        return 0;
    }
    uint64_t length = grid->file_bytes - LENGTH_BYTES;
    return grid->bytes / MOST_COMPRESSION <= length ? length : 0;
}

static int unpack(const input *in, const entry *grid, nvdb_grid *out)
{
    uint64_t length = compressed_bytes(in, grid);
    if (length == 0 || grid->bytes > SIZE_MAX - 8) {
        return xml_error(in->node, "%s: grid %.*s cannot have %llu bytes in %llu of the file; write the file anew", in->path,
                         (int)grid->name_length, grid->name, (unsigned long long)grid->bytes,
                         (unsigned long long)grid->file_bytes);
    }
    const unsigned char *data = in->data + grid->start;
    uint32_t *words = calloc((size_t)(grid->bytes / 8 + 1), 8);
    if (!words) {
        return xml_out_of_memory(in->node);
    }
    uLongf bytes = (uLongf)grid->bytes;
    if (grid->codec == CODEC_NONE) {
        memcpy(words, data, (size_t)grid->bytes);
    } else if (uncompress((Bytef *)words, &bytes, data + LENGTH_BYTES, (uLong)length) != Z_OK || bytes != grid->bytes) {
        free(words);
        return xml_error(in->node, "%s: the zlib stream of grid %.*s is damaged; write the file anew", in->path,
                         (int)grid->name_length, grid->name);
    }
    *out = (nvdb_grid){words, grid->bytes};
    return 1;
}

int nvdb_read(const xml_node *node, const char *path, const char *name, nvdb_grid *out)
{
    input in = {node, path, NULL, 0, 0};
    search s = {.wanted = name};
    int ok = load(&in) && find(&in, &s) && check_kind(&in, &s.found) && unpack(&in, &s.found, out);
    free(in.data);
    return ok;
}
