/* A recorded call (record.h), read and made again. */
#ifndef RECORD_REPLAY_FILE_H
#define RECORD_REPLAY_FILE_H

#include "record.h"

typedef struct {
    unsigned char *bytes; /* the file, aligned to 16 */
    size_t count;
    volgrad_scene_desc desc;
    volgrad_medium *media;
    volgrad_light *lights;
    void *scene_memory, *guide_memory;
    const volgrad_scene *scene;
    uint32_t asked;
    char problem[240]; /* the first query that differed, in words; empty: none */
} replay;

/* Reads a file and makes its scene. Returns 0 and says in `problem` what is wrong. */
int replay_open(replay *p, const char *file);

/* Answers from the record. A query that is not the recorded one stops the call. */
volgrad_queries replay_queries(replay *p);

/* A chunk's bytes, *count of them, if it is there. */
const void *replay_find(const replay *p, const char *tag, uint32_t number, size_t *count);

/* The same, if it has so many bytes. */
const void *replay_find_of(const replay *p, const char *tag, uint32_t number, uint64_t bytes);

void replay_close(replay *p);

#endif
