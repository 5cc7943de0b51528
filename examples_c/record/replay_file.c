#include "replay_file.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

static int fail(replay *p, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(p->problem, sizeof p->problem, format, arguments);
    va_end(arguments);
    return 0;
}

static void *aligned(size_t bytes)
{
    return aligned_alloc(16, (bytes + 16) / 16 * 16);
}

/* ---- the file ---- */

static int read_all(replay *p, const char *name)
{
    FILE *file = fopen(name, "rb");
    if (file == NULL) {
        return fail(p, "cannot be opened");
    }
    long end = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    p->count = end > 0 ? (size_t)end : 0;
    p->bytes = p->count > 0 && fseek(file, 0, SEEK_SET) == 0 ? aligned(p->count) : NULL;
    int ok = p->bytes != NULL && fread(p->bytes, 1, p->count, file) == p->count;
    fclose(file);
    return ok || fail(p, "cannot be read");
}

static int check_head(replay *p)
{
    record_head head = {.version = 0};
    if (p->count >= sizeof head) {
        memcpy(&head, p->bytes, sizeof head);
    }
    if (memcmp(head.magic, "VGRECORD", sizeof head.magic) != 0) {
        return fail(p, "is no record of volgrad's: it does not begin with VGRECORD");
    }
    if (head.order != 0x01020304 || head.pointer_bytes != sizeof(void *)) {
        return fail(p, "was recorded on another type of machine: bytes in another order, or pointers of %u bytes", (unsigned)head.pointer_bytes);
    }
    if (head.version != RECORD_VERSION) {
        return fail(p, "is a record of version %u; this program reads version %u", (unsigned)head.version, (unsigned)RECORD_VERSION);
    }
    if (head.abi != volgrad_abi_version()) {
        return fail(p, "was recorded with volgrad's ABI %u; this is %u", (unsigned)head.abi, (unsigned)volgrad_abi_version());
    }
    return 1;
}

/* The chunk at `at`, whose bytes follow it; NULL if it does not fit into the file. */
static const record_chunk *chunk_at(const replay *p, size_t at)
{
    if (p->count - at < sizeof(record_chunk)) {
        return NULL;
    }
    const record_chunk *chunk = (const void *)(p->bytes + at);
    return chunk->bytes <= p->count - at - sizeof *chunk ? chunk : NULL;
}

static size_t after(size_t at, const record_chunk *chunk)
{
    return at + sizeof *chunk + ((size_t)chunk->bytes + 15) / 16 * 16;
}

static int check_chunks(replay *p)
{
    for (size_t at = sizeof(record_head); at < p->count;) {
        const record_chunk *chunk = chunk_at(p, at);
        if (chunk == NULL) {
            break;
        }
        if (memcmp(chunk->tag, "END ", 4) == 0) {
            uint64_t hash = record_hash(RECORD_NO_BYTES, p->bytes, at);
            return (chunk->bytes == sizeof hash && memcmp(chunk + 1, &hash, sizeof hash) == 0) || fail(p, "was changed after it was recorded");
        }
        at = after(at, chunk);
    }
    return fail(p, "was cut off: its end is missing");
}

const void *replay_find(const replay *p, const char *tag, uint32_t number, size_t *count)
{
    for (size_t at = sizeof(record_head); at < p->count;) {
        const record_chunk *chunk = chunk_at(p, at);
        if (chunk == NULL || memcmp(chunk->tag, "END ", 4) == 0) {
            return NULL;
        }
        if (memcmp(chunk->tag, tag, 4) == 0 && chunk->number == number) {
            *count = (size_t)chunk->bytes;
            return chunk + 1;
        }
        at = after(at, chunk);
    }
    return NULL;
}

const void *replay_find_of(const replay *p, const char *tag, uint32_t number, uint64_t bytes)
{
    size_t count = 0;
    const void *found = replay_find(p, tag, number, &count);
    return count == bytes ? found : NULL;
}

/* ---- the scene ---- */

/* Bytes of so many floats; more than any file has, if they are too many to be counted. */
static uint64_t floats(uint32_t x, uint32_t y, uint32_t z)
{
    uint64_t plane = (uint64_t)x * y;
    return z > 0 && plane > UINT64_MAX / sizeof(float) / z ? UINT64_MAX : sizeof(float) * plane * z;
}

static int missing(replay *p, const char *what, uint32_t number)
{
    return fail(p, "is not whole: %s %u is missing or of another size", what, (unsigned)number);
}

static int read_media(replay *p)
{
    p->media = calloc(p->desc.media_count > 0 ? p->desc.media_count : 1, sizeof *p->media);
    for (uint32_t i = 0; i < p->desc.media_count && p->media != NULL; ++i) {
        const volgrad_medium *medium = replay_find_of(p, "MEDI", i, sizeof *medium);
        if (medium == NULL) {
            return missing(p, "medium", i);
        }
        p->media[i] = *medium;
        if (medium->kind == VOLGRAD_MEDIUM_GRID) {
            p->media[i].density = replay_find_of(p, "GRID", i, floats(medium->nx, medium->ny, medium->nz));
            if (p->media[i].density == NULL) {
                return missing(p, "density grid", i);
            }
        }
    }
    p->desc.media = p->media;
    return p->media != NULL || fail(p, "is too large for the memory");
}

static int read_lights(replay *p)
{
    p->lights = calloc(p->desc.light_count > 0 ? p->desc.light_count : 1, sizeof *p->lights);
    for (uint32_t i = 0; i < p->desc.light_count && p->lights != NULL; ++i) {
        const volgrad_light *light = replay_find_of(p, "LIGH", i, sizeof *light);
        if (light == NULL) {
            return missing(p, "light", i);
        }
        p->lights[i] = *light;
        if (light->kind == VOLGRAD_LIGHT_ENVIRONMENT_MAP) {
            p->lights[i].image = replay_find_of(p, "SKY ", i, floats(3, light->image_width, light->image_height));
            if (p->lights[i].image == NULL) {
                return missing(p, "environment map", i);
            }
        }
    }
    p->desc.lights = p->lights;
    return p->lights != NULL || fail(p, "is too large for the memory");
}

static int read_desc(replay *p)
{
    const volgrad_scene_desc *desc = replay_find_of(p, "DESC", 0, sizeof *desc);
    if (desc == NULL) {
        return missing(p, "scene", 0);
    }
    p->desc = *desc;
    p->desc.phases = NULL, p->desc.phase_count = 0; /* pointers of another process, if it was recorded with them */
    p->desc.materials = replay_find_of(p, "MATE", 0, (uint64_t)desc->material_count * sizeof *desc->materials);
    if (desc->material_count > 0 && p->desc.materials == NULL) {
        return missing(p, "material", 0);
    }
    return read_media(p) && read_lights(p);
}

static int make_scene(replay *p)
{
    size_t bytes = 0, count = 0;
    volgrad_status status = volgrad_scene_size(&p->desc, &bytes);
    if (status == VOLGRAD_OK && (p->scene_memory = aligned(bytes)) != NULL) {
        status = volgrad_scene_init(p->scene_memory, bytes, &p->desc, &p->scene, NULL);
    }
    /* A film is changed by nothing that guides do to it; the file's copy is ours. */
    void *film = (void *)(size_t)replay_find(p, "GUID", 0, &count);
    if (status == VOLGRAD_OK && p->scene != NULL && film != NULL) {
        const volgrad_scene *plain = p->scene;
        uint32_t width, height;
        size_t film_bytes = 0;
        status = volgrad_guide_film_size(plain, &width, &height);
        status = status == VOLGRAD_OK ? volgrad_film_size(width, height, &film_bytes) : status;
        if (film_bytes != count) {
            return missing(p, "guide", 0);
        }
        status = status == VOLGRAD_OK ? volgrad_guide_size(plain, &bytes) : status;
        p->guide_memory = status == VOLGRAD_OK ? aligned(bytes) : NULL;
        status = p->guide_memory != NULL ? volgrad_guide_init(p->guide_memory, bytes, plain, film, &p->scene) : status;
    }
    return (status == VOLGRAD_OK && p->scene != NULL) || fail(p, "has a scene that volgrad does not take: %s", volgrad_status_message(status));
}

int replay_open(replay *p, const char *file)
{
    memset(p, 0, sizeof *p);
    return read_all(p, file) && check_head(p) && check_chunks(p) && read_desc(p) && make_scene(p);
}

void replay_close(replay *p)
{
    free(p->bytes);
    free(p->media);
    free(p->lights);
    free(p->scene_memory);
    free(p->guide_memory);
}

/* ---- ray queries ---- */

static int32_t answer(replay *p, const char *tag, const volgrad_ray *rays, volgrad_hit *hits, uint32_t count)
{
    size_t size = 0;
    const char *what = memcmp(tag, "OCCL", 4) == 0 ? "occluded" : "intersect";
    const volgrad_ray *known = replay_find(p, tag, p->asked, &size);
    const volgrad_hit *answers = replay_find_of(p, "HITS", p->asked, (uint64_t)count * sizeof *hits);
    const int32_t *code = replay_find_of(p, "CODE", p->asked, sizeof *code);
    if (known == NULL || answers == NULL || code == NULL || size != count * sizeof *rays) {
        fail(p, "query %u, %s of %u rays, is not the recorded one: that was another kind, of another number of rays, or there was none",
             (unsigned)p->asked, what, (unsigned)count);
        return -1;
    }
    for (uint32_t i = 0; i < count; ++i) {
        if (memcmp(&rays[i], &known[i], sizeof *rays) != 0) {
            fail(p, "query %u, %s: ray %u from %.9g %.9g %.9g towards %.9g %.9g %.9g was from %.9g %.9g %.9g towards %.9g %.9g %.9g",
                 (unsigned)p->asked, what, (unsigned)i, (double)rays[i].origin.x, (double)rays[i].origin.y, (double)rays[i].origin.z,
                 (double)rays[i].direction.x, (double)rays[i].direction.y, (double)rays[i].direction.z, (double)known[i].origin.x,
                 (double)known[i].origin.y, (double)known[i].origin.z, (double)known[i].direction.x, (double)known[i].direction.y,
                 (double)known[i].direction.z);
            return -1;
        }
    }
    memcpy(hits, answers, count * sizeof *hits);
    p->asked++;
    return *code;
}

static int32_t intersect(void *user, const volgrad_ray *rays, volgrad_hit *hits, uint32_t count)
{
    return answer(user, "NEAR", rays, hits, count);
}

static int32_t occluded(void *user, const volgrad_ray *rays, volgrad_hit *hits, uint32_t count)
{
    return answer(user, "OCCL", rays, hits, count);
}

volgrad_queries replay_queries(replay *p)
{
    return (volgrad_queries){.struct_size = sizeof(volgrad_queries), .user = p, .intersect = intersect, .occluded = occluded};
}
