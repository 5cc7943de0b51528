/* Metropolis chains on all threads. They all make the same number of mutations, in rounds. */
#ifndef RENDER_CHAINS_H
#define RENDER_CHAINS_H

#include "bootstrap.h"
#include "films.h"
#include "render.h"

typedef struct {
    const render_job *job;
    const volgrad_chain_techniques *techniques; /* the bootstrap's: for chains_start only */
    uint32_t count; /* 0: the bootstrap found no light */
    void *memory;   /* of all chains, one after the other */
    size_t bytes_of_one;
    volgrad_chain_start *starts;
    volgrad_chain **each;
    films films;
    volgrad_chain_stats *stats; /* of each thread, by length */
    uint64_t done;              /* mutations of each */
    double seconds;             /* that they took */
    double cpu_seconds;         /* of all threads, with burn-in */
    uint64_t last_size;         /* mutations of each in the last round, or the one that is running */
} chains;

/* Makes the chains, with their burn-in. Returns 0 on a failure: *status says which; VOLGRAD_OK: memory is out. To be freed in either
   case. */
int chains_start(chains *c, const render_job *job, const bootstrap *b, volgrad_status *status);

/* One round: so many mutations of each chain. */
volgrad_status chains_run(chains *c, uint64_t mutations);

/* Adds what is due where the chains are now, and hands the sum of all films and stats to the result. */
volgrad_status chains_finish(chains *c, chain_result *result);

void chains_free(chains *c);

#endif
