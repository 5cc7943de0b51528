#include "debug_chain.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../record/mutation.h"
#include "../record/record.h"
#include "chains.h"
#include "guide.h"

static int complain(const char *what, const char *why)
{
    fprintf(stderr, "volgrad-render: --debug-chain: %s: %s\n", what, why);
    return 0;
}

static int check(const char *what, volgrad_status status)
{
    return status == VOLGRAD_OK || complain(what, volgrad_status_message(status));
}

static int check_memory(const void *memory)
{
    return memory != NULL || complain("memory", "there is not enough");
}

/* The image's name with another ending. */
static char *record_name(const char *image)
{
    size_t stem = strlen(image) - strlen(".exr");
    char *name = malloc(stem + sizeof ".record");
    if (name != NULL) {
        memcpy(name, image, stem);
        strcpy(name + stem, ".record");
    }
    return name;
}

static int print(const volgrad_chain *chain, const render_job *job, const volgrad_scene_desc *desc)
{
    mutation *m = malloc(sizeof *m);
    int ok = check_memory(m) && check("looking", mutation_look(m, chain, job->scene, desc, job->queries));
    if (ok) {
        mutation_print(stdout, m, job->scene);
    }
    free(m);
    return ok;
}

static int record(chains *c, volgrad_chain *chain, const render_job *job, const volgrad_scene_desc *desc, const guide *g, volgrad_film *film,
                  size_t film_bytes, const char *name)
{
    recorder r;
    const char *problem = record_begin(&r, name, desc, g->film.film, g->film_bytes);
    if (problem != NULL) {
        return complain(name, problem);
    }
    volgrad_status status = record_mutation(&r, chain, c->bytes_of_one, job->scene, desc, job->queries, film, film_bytes);
    if (!record_end(&r)) {
        return complain(name, "cannot be written");
    }
    printf("%s: %" PRIu32 " ray queries; volgrad-replay %s makes this mutation again\n", name, r.asked, name);
    return check("mutation", status);
}

/* The chain makes its mutations up to that one, whose splats are `film`'s only ones. */
static int run(chains *c, const render_job *job, const volgrad_scene_desc *desc, const guide *g, const chain_mutation *which,
               const char *name)
{
    size_t bytes = 0;
    volgrad_chain *chain = c->each[which->chain];
    volgrad_film *film = NULL;
    int ok = check("film", volgrad_film_size(job->width, job->height, &bytes));
    void *memory = ok ? aligned_memory(bytes) : NULL;
    ok = ok && check_memory(memory) && check("film", volgrad_film_init(memory, bytes, job->width, job->height, &film)) &&
         check("chain", volgrad_chain_run(chain, job->scene, job->queries, which->number, film, NULL)) &&
         check("film", volgrad_film_init(memory, bytes, job->width, job->height, &film)) && print(chain, job, desc) &&
         record(c, chain, job, desc, g, film, bytes, name);
    free(memory);
    return ok;
}

/* As far as the mutations: status says what is wrong, VOLGRAD_OK that memory is out. */
static int start(chains *c, bootstrap *b, guide *g, const render_job *job, render_job *guided, volgrad_status *status)
{
    int ok = guide_learn(g, job, status);
    guided->scene = g->scene;
    return ok && bootstrap_run(b, guided, status) && chains_start(c, guided, b, status);
}

int debug_chain(const render_job *job, const volgrad_scene_desc *desc, const chain_mutation *which, const char *image)
{
    guide g = {.samples = 0};
    bootstrap b = {.count = 0};
    chains c = {.count = 0};
    volgrad_status status = VOLGRAD_OK;
    char *name = record_name(image);
    render_job guided = *job;
    int ok = name != NULL && start(&c, &b, &g, job, &guided, &status);
    if (!ok) {
        ok = check("chains", status) && check_memory(NULL);
    } else if (which->chain >= c.count) {
        char why[64];
        snprintf(why, sizeof why, "there are %u, from 0 on", (unsigned)c.count);
        ok = complain("no such chain", why);
    } else {
        ok = run(&c, &guided, desc, &g, which, name);
    }
    chains_free(&c);
    bootstrap_free(&b);
    guide_free(&g);
    free(name);
    return ok;
}
