#include "team.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

typedef struct {
    const team_task *task;
    atomic_uint_fast64_t next_item;
    atomic_int status; /* the first that is not VOLGRAD_OK */
} job;

typedef struct {
    pthread_t thread;
    unsigned number;
    job *job;
} member;

static int goes_on(const job *j)
{
    return atomic_load(&j->status) == VOLGRAD_OK && (j->task->enough == NULL || !j->task->enough(j->task->user));
}

static void work(job *j, unsigned number)
{
    const team_task *task = j->task;
    while (goes_on(j)) {
        uint64_t item = atomic_fetch_add(&j->next_item, 1);
        if (item >= task->item_count) {
            break;
        }
        volgrad_status status = task->item(task->user, number, item);
        if (status != VOLGRAD_OK) {
            int none = VOLGRAD_OK;
            atomic_compare_exchange_strong(&j->status, &none, (int)status);
        } else if (number == 0 && task->report != NULL) {
            task->report(task->user, item);
        }
    }
}

static void *work_as_member(void *argument)
{
    member *self = argument;
    work(self->job, self->number);
    return NULL;
}

volgrad_status team_run(const team_task *task, uint64_t *done)
{
    job j = {.task = task};
    atomic_init(&j.next_item, 0);
    atomic_init(&j.status, VOLGRAD_OK);
    /* The calling thread is number 0. If the system refuses memory or a thread, the others do its work. */
    member *members = calloc(task->threads, sizeof *members);
    unsigned started = 1;
    while (members != NULL && started < task->threads) {
        members[started] = (member){.number = started, .job = &j};
        if (pthread_create(&members[started].thread, NULL, work_as_member, &members[started]) != 0) {
            break;
        }
        started++;
    }
    work(&j, 0);
    for (unsigned i = 1; i < started; ++i) {
        pthread_join(members[i].thread, NULL);
    }
    free(members);
    uint64_t taken = atomic_load(&j.next_item);
    *done = taken < task->item_count ? taken : task->item_count;
    return (volgrad_status)atomic_load(&j.status);
}
