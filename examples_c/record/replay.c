/* volgrad-replay FILE: makes a recorded call again, without the host that made it, prints what it does, and says whether the same bits came of
 * it. Exit status: 0 the same, 1 not the same, 2 the file is no record that can be replayed. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mutation.h"
#include "replay_file.h"

enum { SAME = 0, DIFFERENT = 1, NO_RECORD = 2 };

static int wrong(const char *file, const char *problem)
{
    fprintf(stderr, "volgrad-replay: %s %s\n", file, problem);
    return NO_RECORD;
}

static int compare(const replay *p, const record_result *was, const record_result *is, int same_bytes)
{
    if (p->problem[0] != '\0') {
        printf("%s\n", p->problem);
    }
    if (was->status != is->status) {
        printf("status \"%s\", recorded \"%s\"\n", volgrad_status_message(is->status), volgrad_status_message(was->status));
    }
    int same = memcmp(was, is, sizeof *was) == 0 && same_bytes;
    printf("%s\n", same ? "the same bits" : "not the same bits");
    return same ? SAME : DIFFERENT;
}

/* ---- a path that was shifted ---- */

static int replay_path(replay *p, const char *file, const record_result *was)
{
    size_t vertices, segments, ends, options, splat_bytes = 0;
    const record_call *call = replay_find_of(p, "CALL", 0, sizeof *call);
    const volgrad_shift_options *shift = replay_find(p, "SHIF", 0, &options);
    volgrad_path path = {.vertices = replay_find(p, "VERT", 0, &vertices), .segments = replay_find(p, "SEGM", 0, &segments),
                         .edge_ends = replay_find(p, "ENDS", 0, &ends)};
    if (call == NULL || shift == NULL || path.vertices == NULL || path.segments == NULL || path.edge_ends == NULL ||
        options < sizeof shift->struct_size || shift->struct_size != options || vertices != (uint64_t)call->vertex_count * sizeof *path.vertices ||
        call->vertex_count == 0 || ends != (uint64_t)(call->vertex_count - 1) * sizeof *path.edge_ends) {
        return wrong(file, "is not whole: its path or its options are missing");
    }
    path.vertex_count = call->vertex_count;
    path.segment_count = (uint32_t)(segments / sizeof *path.segments);
    path_print(stdout, p->scene, &path);

    volgrad_splat splats[VOLGRAD_MAX_SHIFTS + 1];
    volgrad_queries queries = replay_queries(p);
    record_result is = {.count = 0};
    is.status = volgrad_shift_path(p->scene, &queries, shift, &path, call->weight, call->seed, call->index, splats, VOLGRAD_MAX_SHIFTS + 1,
                                   &is.count);
    for (uint32_t i = 0; i < is.count; ++i) {
        printf("splat at %.4f %.4f: %.9g %.9g %.9g\n", (double)splats[i].x, (double)splats[i].y, (double)splats[i].value.r,
               (double)splats[i].value.g, (double)splats[i].value.b);
    }
    const void *recorded = replay_find(p, "SPLA", 0, &splat_bytes);
    int same = splat_bytes == is.count * sizeof *splats && (splat_bytes == 0 || memcmp(recorded, splats, splat_bytes) == 0);
    return compare(p, was, &is, same);
}

/* ---- a mutation of a chain ---- */

static void print_splats(const volgrad_film *film, const volgrad_camera *camera)
{
    size_t pixels = (size_t)camera->width * camera->height;
    float *rgb = calloc(3 * pixels, sizeof *rgb);
    if (rgb != NULL && volgrad_film_develop(film, 1, rgb, 3 * pixels) == VOLGRAD_OK) {
        for (size_t i = 0; i < pixels; ++i) {
            const float *c = rgb + 3 * i;
            if (c[0] != 0 || c[1] != 0 || c[2] != 0) {
                printf("pixel %zu %zu: %.9g %.9g %.9g\n", i % camera->width, i / camera->width, (double)c[0], (double)c[1], (double)c[2]);
            }
        }
    }
    free(rgb);
}

/* `chain` is what was recorded before it. */
static int mutate(replay *p, const record_result *was, volgrad_chain *chain, const void *after, size_t bytes, mutation *m, volgrad_film *film,
                  size_t film_bytes)
{
    volgrad_queries queries = replay_queries(p);
    record_result is = {.status = mutation_look(m, chain, p->scene, &p->desc, &queries)};
    if (is.status == VOLGRAD_OK) {
        mutation_print(stdout, m, p->scene);
        is.status = volgrad_chain_run(chain, p->scene, &queries, 1, film, NULL);
    }
    print_splats(film, &p->desc.camera);
    is.film_hash = record_hash(RECORD_NO_BYTES, film, film_bytes);
    return compare(p, was, &is, memcmp(after, chain, bytes) == 0);
}

static int replay_mutation(replay *p, const char *file, const record_result *was)
{
    size_t bytes, film_bytes = 0;
    const void *before = replay_find(p, "CHN0", 0, &bytes), *after = replay_find_of(p, "CHN1", 0, bytes);
    const volgrad_camera *camera = &p->desc.camera;
    if (after == NULL || volgrad_film_size(camera->width, camera->height, &film_bytes) != VOLGRAD_OK) {
        return wrong(file, "is not whole: its chain is missing");
    }
    void *chain = aligned_alloc(16, (bytes + 15) / 16 * 16), *memory = aligned_alloc(16, film_bytes);
    mutation *m = calloc(1, sizeof *m);
    volgrad_film *film = NULL;
    int exit_status;
    if (chain != NULL && memory != NULL && m != NULL &&
        volgrad_film_init(memory, film_bytes, camera->width, camera->height, &film) == VOLGRAD_OK) {
        memcpy(chain, before, bytes);
        exit_status = mutate(p, was, chain, after, bytes, m, film, film_bytes);
    } else {
        exit_status = wrong(file, "is too large for the memory");
    }
    free(m);
    free(chain);
    free(memory);
    return exit_status;
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fputs("usage: volgrad-replay FILE\n", stderr);
        return NO_RECORD;
    }
    replay p;
    size_t count;
    int exit_status = NO_RECORD;
    const record_result *was = NULL;
    if (!replay_open(&p, argv[1])) {
        wrong(argv[1], p.problem);
    } else if ((was = replay_find_of(&p, "DONE", 0, sizeof *was)) == NULL) {
        wrong(argv[1], "is not whole: what came of the call is missing");
    } else if (replay_find(&p, "CALL", 0, &count) != NULL) {
        exit_status = replay_path(&p, argv[1], was);
    } else if (replay_find(&p, "CHN0", 0, &count) != NULL) {
        exit_status = replay_mutation(&p, argv[1], was);
    } else {
        wrong(argv[1], "has no call to replay");
    }
    replay_close(&p);
    return exit_status;
}
