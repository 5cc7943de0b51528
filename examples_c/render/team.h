/* Threads that share numbered items of work among them: each takes the next one when it is done with its last. */
#ifndef RENDER_TEAM_H
#define RENDER_TEAM_H

#include <stdint.h>

#include "volgrad.h"

typedef struct {
    unsigned threads; /* at least 1 */
    uint64_t item_count;
    void *user;
    /* `worker` is the number of the thread, from 0 on. */
    volgrad_status (*item)(void *user, unsigned worker, uint64_t item);
    /* On the calling thread, how many items are taken, about. May be NULL. */
    void (*report)(void *user, uint64_t items);
    /* Asked before each item whether to leave it, and all others, undone. May be NULL: all are done. */
    int (*enough)(void *user);
} team_task;

/* Returns when all items are done, or after the first that fails, with its status. Items 0 ... *done - 1 are done then, and no others;
   unless one failed. */
volgrad_status team_run(const team_task *task, uint64_t *done);

#endif
