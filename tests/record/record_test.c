/* record_test PATH OTHER: a host with a homogeneous fog and a point light, and no renderer, records a path that it shifts. It lists a phase
 * function that no medium has. And the same file with another seed, whose call asks about other rays, and a pointer to that phase function. */
#include <stdlib.h>
#include <string.h>

#include "../../examples_c/record/record.h"

enum { FOG = 0 };

/* Fog everywhere, no surface. The rest of a hit is not initialised, as it may be. */
static int32_t answer(void *user, const volgrad_ray *rays, volgrad_hit *hits, uint32_t count)
{
    (void)user;
    for (uint32_t i = 0; i < count; ++i) {
        memset(&hits[i], 0xA5, sizeof hits[i]);
        hits[i].kind = VOLGRAD_HIT_NONE;
        hits[i].segment_count = 1;
        hits[i].segments[0].end = rays[i].t_max;
        hits[i].segments[0].medium = FOG;
    }
    return 0;
}

static double isotropic(void *user, double mu)
{
    (void)user, (void)mu;
    return 0.25 / 3.14159265358979;
}

static double isotropic_cosine(void *user, double u)
{
    (void)user;
    return 2 * u - 1;
}

static const volgrad_custom_phase unused = {.struct_size = sizeof unused, .eval = isotropic, .sample = isotropic_cosine};
static const volgrad_custom_phase *const phases[1] = {&unused};

static const char *record(const char *file)
{
    volgrad_camera camera = {.width = 16, .height = 16, .crop_x1 = 16, .crop_y1 = 16, .medium = FOG, .forward = {0, 0, 1},
                             .right = {1, 0, 0}, .up = {0, 1, 0}, .tan_half_fov_x = 1};
    volgrad_medium fog = {.kind = VOLGRAD_MEDIUM_HOMOGENEOUS, .sigma_t = {.1f, .2f, .3f}, .albedo = {.9f, .9f, .9f}};
    volgrad_light lamp = {.kind = VOLGRAD_LIGHT_POINT, .medium = FOG, .emission = {9, 9, 9}, .sampling_weight = 1, .position = {0, 2, 3}};
    volgrad_scene_desc desc = {.struct_size = sizeof desc, .media_count = 1, .light_count = 1, .camera = camera, .media = &fog, .lights = &lamp,
                               .phases = phases, .phase_count = 1};
    static _Alignas(16) char memory[8192];
    const volgrad_scene *scene;
    if (volgrad_scene_init(memory, sizeof memory, &desc, &scene, NULL) != VOLGRAD_OK) {
        return "no scene";
    }
    volgrad_vertex vertices[3] = {{.kind = VOLGRAD_VERTEX_CAMERA}, {.kind = VOLGRAD_VERTEX_MEDIUM, .position = {.1f, .2f, 3}},
                                  {.kind = VOLGRAD_VERTEX_LIGHT, .position = {0, 2, 3}}};
    volgrad_segment segments[2] = {{.end = 4, .medium = FOG}, {.end = 2, .medium = FOG}};
    uint32_t ends[2] = {1, 2}, count = 0;
    volgrad_path path = {vertices, segments, ends, 3, 2};
    volgrad_queries host = {.struct_size = sizeof host, .intersect = answer, .occluded = answer};
    volgrad_shift_options options;
    volgrad_splat splats[VOLGRAD_MAX_SHIFTS + 1];
    recorder r;
    if (volgrad_shift_options_default(&options, sizeof options) != VOLGRAD_OK) {
        return "no options";
    }
    options.mode = VOLGRAD_SHIFT_EXCHANGEABLE;
    const char *problem = record_begin(&r, file, &desc, NULL, 0);
    if (problem != NULL) {
        return problem;
    }
    record_call call = {.weight = {1, 2, 3}, .seed = 5, .index = 6};
    if (record_shift_path(&r, scene, &host, &options, &path, call, splats, VOLGRAD_MAX_SHIFTS + 1, &count) != VOLGRAD_OK) {
        return "no splats";
    }
    return record_end(&r) ? NULL : "not written";
}

static const char *change(const char *from, const char *to)
{
    static _Alignas(16) char bytes[1 << 16];
    FILE *file = fopen(from, "rb");
    size_t count = file != NULL ? fread(bytes, 1, sizeof bytes, file) : 0;
    if (file != NULL) {
        fclose(file);
    }
    for (size_t at = sizeof(record_head); at < count;) {
        record_chunk *chunk = (void *)(bytes + at);
        if (memcmp(chunk->tag, "DESC", 4) == 0) {
            volgrad_scene_desc *desc = (void *)(chunk + 1);
            if (desc->phases != NULL || desc->phase_count != 0) {
                return "a pointer was recorded";
            }
            desc->phases = phases, desc->phase_count = 1;
        }
        if (memcmp(chunk->tag, "CALL", 4) == 0) {
            ((record_call *)(chunk + 1))->seed += 2; /* tiles begin elsewhere */
        }
        if (memcmp(chunk->tag, "END ", 4) == 0) {
            uint64_t hash = record_hash(RECORD_NO_BYTES, bytes, at);
            memcpy(chunk + 1, &hash, sizeof hash);
        }
        at += sizeof *chunk + (size_t)(chunk->bytes + 15) / 16 * 16;
    }
    file = fopen(to, "wb");
    int ok = count > 0 && file != NULL && fwrite(bytes, 1, count, file) == count;
    return file != NULL && fclose(file) == 0 && ok ? NULL : "not copied";
}

int main(int argc, char **argv)
{
    const char *problem = argc == 3 ? record(argv[1]) : "two files are needed";
    problem = problem != NULL ? problem : change(argv[1], argv[2]);
    if (problem != NULL) {
        fprintf(stderr, "record_test: %s\n", problem);
    }
    return problem != NULL;
}
