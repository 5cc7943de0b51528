#include "films.h"

#include <stdlib.h>

void *aligned_memory(size_t bytes)
{
    const size_t alignment = 16;
    if (bytes > SIZE_MAX - alignment) {
        return NULL;
    }
    return aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
}

static volgrad_status make_film(owned_film *made, uint32_t width, uint32_t height)
{
    size_t bytes;
    volgrad_status status = volgrad_film_size(width, height, &bytes);
    if (status != VOLGRAD_OK) {
        return status;
    }
    made->memory = aligned_memory(bytes);
    if (made->memory == NULL) {
        return VOLGRAD_OK; /* the caller sees that there is no film */
    }
    return volgrad_film_init(made->memory, bytes, width, height, &made->film);
}

int films_make(films *f, unsigned count, uint32_t width, uint32_t height, volgrad_status *status)
{
    *status = VOLGRAD_OK;
    *f = (films){.each = calloc(count, sizeof *f->each), .count = count};
    int ok = f->each != NULL;
    for (unsigned i = 0; ok && i < count; ++i) {
        *status = make_film(&f->each[i], width, height);
        ok = f->each[i].film != NULL;
    }
    return ok;
}

volgrad_status films_sum(films *f, owned_film *sum)
{
    for (unsigned i = 1; i < f->count; ++i) {
        volgrad_status status = volgrad_film_merge(f->each[0].film, f->each[i].film);
        if (status != VOLGRAD_OK) {
            return status;
        }
    }
    *sum = f->each[0];
    f->each[0] = (owned_film){.memory = NULL};
    return VOLGRAD_OK;
}

void films_free(films *f)
{
    for (unsigned i = 0; f->each != NULL && i < f->count; ++i) {
        free(f->each[i].memory);
    }
    free(f->each);
    *f = (films){.count = 0};
}
