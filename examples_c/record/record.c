#include "record.h"

#include <stdlib.h>
#include <string.h>

#include "mutation.h"

static void put(recorder *r, const void *bytes, size_t count)
{
    if (count > 0) {
        fwrite(bytes, 1, count, r->file);
        r->hash = record_hash(r->hash, bytes, count);
    }
}

static void chunk(recorder *r, const char *tag, uint32_t number, const void *bytes, size_t count)
{
    static const char zeros[16];
    record_chunk head = {.number = number, .bytes = count};
    memcpy(head.tag, tag, sizeof head.tag);
    put(r, &head, sizeof head);
    put(r, bytes, count);
    put(r, zeros, (16 - count % 16) % 16);
}

/* ---- the scene ---- */

static const char *media(recorder *r, const volgrad_scene_desc *desc)
{
    for (uint32_t i = 0; i < desc->media_count; ++i) {
        volgrad_medium medium = desc->media[i];
        if (medium.kind == VOLGRAD_MEDIUM_SPARSE_GRID) {
            return "a sparse grid cannot be recorded";
        }
        if (medium.kind == VOLGRAD_MEDIUM_CUSTOM || medium.phase.kind == VOLGRAD_PHASE_CUSTOM) {
            return "a medium whose density or phase function the host computes cannot be recorded";
        }
        if (medium.density != NULL) {
            chunk(r, "GRID", i, medium.density, sizeof(float) * medium.nx * medium.ny * medium.nz);
        }
        medium.density = NULL;
        chunk(r, "MEDI", i, &medium, sizeof medium);
    }
    return NULL;
}

static const char *materials(recorder *r, const volgrad_scene_desc *desc)
{
    for (uint32_t i = 0; i < desc->material_count; ++i) {
        if (desc->materials[i].custom != NULL) {
            return "a material of the host's own cannot be recorded";
        }
    }
    chunk(r, "MATE", 0, desc->materials, desc->material_count * sizeof *desc->materials);
    return NULL;
}

static const char *lights(recorder *r, const volgrad_scene_desc *desc)
{
    for (uint32_t i = 0; i < desc->light_count; ++i) {
        volgrad_light light = desc->lights[i];
        if (light.custom != NULL) {
            return "a light of the host's own cannot be recorded";
        }
        if (light.image != NULL) {
            chunk(r, "SKY ", i, light.image, sizeof(float) * 3 * light.image_width * light.image_height);
        }
        light.image = NULL;
        chunk(r, "LIGH", i, &light, sizeof light);
    }
    return NULL;
}

const char *record_begin(recorder *r, const char *file, const volgrad_scene_desc *desc, const volgrad_film *guide, size_t guide_bytes)
{
    *r = (recorder){.file = fopen(file, "wb"), .hash = RECORD_NO_BYTES};
    if (r->file == NULL) {
        return "the file cannot be opened";
    }
    record_head head = {{'V', 'G', 'R', 'E', 'C', 'O', 'R', 'D'}, RECORD_VERSION, VOLGRAD_ABI_VERSION, sizeof(void *), 0x01020304, 0};
    put(r, &head, sizeof head);
    volgrad_scene_desc plain = *desc;
    plain.media = NULL, plain.materials = NULL, plain.lights = NULL;
    plain.phases = NULL, plain.phase_count = 0; /* no medium that is recorded has one */
    chunk(r, "DESC", 0, &plain, sizeof plain);
    const char *problem = media(r, desc);
    problem = problem != NULL ? problem : materials(r, desc);
    problem = problem != NULL ? problem : lights(r, desc);
    if (guide != NULL) {
        chunk(r, "GUID", 0, guide, guide_bytes);
    }
    if (problem != NULL) {
        fclose(r->file);
    }
    return problem;
}

int record_end(recorder *r)
{
    uint64_t hash = r->hash;
    chunk(r, "END ", 0, &hash, sizeof hash);
    int ok = !ferror(r->file);
    return fclose(r->file) == 0 && ok;
}

/* ---- ray queries ---- */

/* What volgrad reads of an answer: the rest need not be initialised. */
static volgrad_hit known_part(const volgrad_hit *hit, int occlusion)
{
    volgrad_hit out;
    int has_media = hit->kind != VOLGRAD_HIT_OVERFLOW && !(occlusion && hit->kind == VOLGRAD_HIT_SURFACE);
    memset(&out, 0, sizeof out);
    out.kind = hit->kind;
    if (hit->kind == VOLGRAD_HIT_SURFACE && !occlusion) {
        memcpy(&out, hit, offsetof(volgrad_hit, segments));
    }
    out.segment_count = has_media ? hit->segment_count : 0;
    for (uint32_t i = 0; i < out.segment_count && i < VOLGRAD_MAX_SEGMENTS; ++i) {
        out.segments[i] = hit->segments[i];
        if (i + 1 == out.segment_count) {
            memset(&out.segments[i].normal, 0, sizeof out.segments[i].normal);
        }
    }
    return out;
}

static int32_t ask(recorder *r, volgrad_query_fn query, int occlusion, const volgrad_ray *rays, volgrad_hit *hits, uint32_t count)
{
    int32_t code = query(r->host.user, rays, hits, count);
    size_t bytes = count * sizeof *hits;
    volgrad_hit *known = calloc(count, sizeof *known);
    if (known == NULL) {
        return -1;
    }
    for (uint32_t i = 0; i < count && code == 0; ++i) {
        known[i] = known_part(&hits[i], occlusion);
    }
    chunk(r, occlusion ? "OCCL" : "NEAR", r->asked, rays, count * sizeof *rays);
    chunk(r, "HITS", r->asked, known, bytes);
    chunk(r, "CODE", r->asked++, &code, sizeof code);
    free(known);
    return code;
}

static int32_t intersect(void *user, const volgrad_ray *rays, volgrad_hit *hits, uint32_t count)
{
    recorder *r = user;
    return ask(r, r->host.intersect, 0, rays, hits, count);
}

static int32_t occluded(void *user, const volgrad_ray *rays, volgrad_hit *hits, uint32_t count)
{
    recorder *r = user;
    return ask(r, r->host.occluded, 1, rays, hits, count);
}

volgrad_queries record_queries(recorder *r, const volgrad_queries *host)
{
    r->host = *host;
    return (volgrad_queries){.struct_size = sizeof(volgrad_queries), .user = r, .intersect = intersect, .occluded = occluded};
}

/* ---- the calls ---- */

volgrad_status record_shift_path(recorder *r, const volgrad_scene *scene, const volgrad_queries *host, const volgrad_shift_options *options,
                                 const volgrad_path *path, record_call call, volgrad_splat *splats, uint32_t capacity, uint32_t *count)
{
    volgrad_queries queries = record_queries(r, host);
    record_result done = {.count = 0};
    call.vertex_count = path->vertex_count;
    chunk(r, "CALL", 0, &call, sizeof call);
    chunk(r, "SHIF", 0, options, options->struct_size);
    chunk(r, "VERT", 0, path->vertices, path->vertex_count * sizeof *path->vertices);
    chunk(r, "SEGM", 0, path->segments, path->segment_count * sizeof *path->segments);
    chunk(r, "ENDS", 0, path->edge_ends, path->vertex_count > 0 ? (path->vertex_count - 1) * sizeof *path->edge_ends : 0);
    done.status = volgrad_shift_path(scene, &queries, options, path, call.weight, call.seed, call.index, splats, capacity, &done.count);
    if (done.status == VOLGRAD_OK) {
        *count = done.count;
        chunk(r, "SPLA", 0, splats, done.count * sizeof *splats);
    }
    chunk(r, "DONE", 0, &done, sizeof done);
    return done.status;
}

volgrad_status record_mutation(recorder *r, volgrad_chain *chain, size_t chain_bytes, const volgrad_scene *scene,
                               const volgrad_scene_desc *desc, const volgrad_queries *host, volgrad_film *film, size_t film_bytes)
{
    volgrad_queries queries = record_queries(r, host);
    record_result done = {.count = 0};
    chunk(r, "CHN0", 0, chain, chain_bytes);
    /* The same queries in the same order as when it is replayed. */
    mutation *m = calloc(1, sizeof *m);
    done.status = m != NULL ? mutation_look(m, chain, scene, desc, &queries) : VOLGRAD_ERROR_INTERNAL;
    free(m);
    if (done.status == VOLGRAD_OK) {
        done.status = volgrad_chain_run(chain, scene, &queries, 1, film, NULL);
    }
    done.film_hash = record_hash(RECORD_NO_BYTES, film, film_bytes);
    chunk(r, "CHN1", 0, chain, chain_bytes);
    chunk(r, "DONE", 0, &done, sizeof done);
    return done.status;
}

uint64_t record_hash(uint64_t before, const void *bytes, size_t count)
{
    const unsigned char *at = bytes;
    uint64_t hash = before;
    for (size_t i = 0; i < count; ++i) {
        hash = (hash ^ at[i]) * 1099511628211u;
    }
    return hash;
}
