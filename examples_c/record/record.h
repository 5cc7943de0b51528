/* Records one call of volgrad, with all that it depends on, so that a bug in a host is replayed without the host: scene, guides, options,
 * the path or the chain, and every ray query with its answer. What came of the call is recorded too, to be compared bit for bit.
 *
 * The file: a head of 32 bytes, then chunks. Head: "VGRECORD", u32 version, u32 VOLGRAD_ABI_VERSION, u32 bytes of a pointer, u32 0x01020304 as
 * this machine stores it, 8 bytes 0. Chunk: a tag of 4 letters, u32 number, u64 bytes, then these, filled up to 16. Structs are as in volgrad.h,
 * pointers 0. The last chunk is END, with record_hash of all bytes before it: chains and films are taken as they are, so a file that was cut off or
 * changed is none. */
#ifndef RECORD_H
#define RECORD_H

#include <stdio.h>
#include <volgrad.h>

enum { RECORD_VERSION = 1 };

typedef struct {
    char magic[8];
    uint32_t version, abi, pointer_bytes, order;
    uint64_t zero;
} record_head;

typedef struct {
    char tag[4];
    uint32_t number;
    uint64_t bytes;
} record_chunk;

/* What a path was handed over with (CALL). */
typedef struct {
    volgrad_rgb weight;
    uint32_t vertex_count;
    uint64_t seed, index;
} record_call;

/* What came of the call (DONE). */
typedef struct {
    volgrad_status status;
    uint32_t count;     /* of splats; 0 of a chain's mutation */
    uint64_t film_hash; /* of a chain's mutation; else 0 */
} record_result;

typedef struct {
    FILE *file;
    uint64_t hash; /* of what was written */
    volgrad_queries host;
    uint32_t asked;
} recorder;

/* Begins a file with a scene. `guide`: the film that volgrad_guide_init is given, of that many bytes, before it is; or NULL. Returns NULL, or
   what is wrong: sparse grids, and callbacks of the host's for materials, lights, densities and phase functions, cannot be recorded. */
const char *record_begin(recorder *r, const char *file, const volgrad_scene_desc *desc, const volgrad_film *guide, size_t guide_bytes);

/* The host's queries, recorded as they are answered. `r` stays where it is. */
volgrad_queries record_queries(recorder *r, const volgrad_queries *host);

/* Calls volgrad_shift_path. */
volgrad_status record_shift_path(recorder *r, const volgrad_scene *scene, const volgrad_queries *host, const volgrad_shift_options *options,
                                 const volgrad_path *path, record_call call, volgrad_splat *splats, uint32_t capacity, uint32_t *count);

/* Makes one mutation of a chain, and adds it to an empty film. Reads both paths for the report on the way: see mutation.h. */
volgrad_status record_mutation(recorder *r, volgrad_chain *chain, size_t chain_bytes, const volgrad_scene *scene,
                               const volgrad_scene_desc *desc, const volgrad_queries *host, volgrad_film *film, size_t film_bytes);

/* Ends the file. Returns 0 if it could not be written. */
int record_end(recorder *r);

/* FNV-1a, 64 bits, over bytes after those whose hash is `before`: RECORD_NO_BYTES for none. */
uint64_t record_hash(uint64_t before, const void *bytes, size_t count);
#define RECORD_NO_BYTES UINT64_C(14695981039346656037)

#endif
