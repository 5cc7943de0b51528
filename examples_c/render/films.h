/* A film for each thread, and their sum, which is exact: whichever thread adds what does not matter. */
#ifndef RENDER_FILMS_H
#define RENDER_FILMS_H

#include <stddef.h>
#include <stdint.h>

#include "volgrad.h"

typedef struct {
    void *memory; /* to be freed */
    volgrad_film *film;
} owned_film;

typedef struct {
    owned_film *each;
    unsigned count;
} films;

/* Returns 0 on a failure: *status says which; VOLGRAD_OK: memory is out. To be freed in either case. */
int films_make(films *f, unsigned count, uint32_t width, uint32_t height, volgrad_status *status);

/* Merges all films into the first, which is no longer theirs then. */
volgrad_status films_sum(films *f, owned_film *sum);

void films_free(films *f);

/* Memory as volgrad wants it, 16-byte aligned. Free with free(). NULL: out of memory. */
void *aligned_memory(size_t bytes);

#endif
