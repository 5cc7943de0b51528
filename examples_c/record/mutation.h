/* A chain's next mutation in words: what it proposes and decides, and both paths factor by factor. */
#ifndef RECORD_MUTATION_H
#define RECORD_MUTATION_H

#include <stdio.h>
#include <volgrad.h>

enum { MOST_VERTICES = VOLGRAD_MAX_LENGTH + 1 };

/* A path with the media along it. */
typedef struct {
    volgrad_vertex vertices[MOST_VERTICES];
    volgrad_segment segments[VOLGRAD_MAX_LENGTH * (VOLGRAD_MAX_SEGMENTS + 1)];
    uint32_t edge_ends[VOLGRAD_MAX_LENGTH];
    uint32_t segment_count;
} whole_path;

typedef struct {
    volgrad_chain_mutation what;
    whole_path paths[2]; /* the chain's, and the proposed one */
} mutation;

volgrad_status mutation_look(mutation *m, const volgrad_chain *chain, const volgrad_scene *scene, const volgrad_scene_desc *desc,
                             const volgrad_queries *queries);

void mutation_print(FILE *to, const mutation *m, const volgrad_scene *scene);

/* volgrad_path_report, printed. */
void path_print(FILE *to, const volgrad_scene *scene, const volgrad_path *path);

#endif
