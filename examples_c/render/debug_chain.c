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
    int ok = m != NULL && check("looking", mutation_look(m, chain, job->scene, desc, job->queries));
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
    void *memory = aligned_memory(bytes);
    ok = ok && memory != NULL && check("film", volgrad_film_init(memory, bytes, job->width, job->height, &film)) &&
         check("chain", volgrad_chain_run(chain, job->scene, job->queries, which->number, film, NULL)) &&
         check("film", volgrad_film_init(memory, bytes, job->width, job->height, &film)) && print(chain, job, desc) &&
         record(c, chain, job, desc, g, film, bytes, name);
    free(memory);
    return ok;
}

int debug_chain(const render_job *job, const volgrad_scene_desc *desc, const chain_mutation *which, const char *image)
{
    guide g;
    bootstrap b;
    chains c = {.count = 0};
    volgrad_status status = VOLGRAD_OK;
    char *name = record_name(image);
    render_job guided = *job;
    int ok = guide_learn(&g, job, &status);
    guided.scene = g.scene;
    if (ok && bootstrap_run(&b, &guided, &status)) {
        ok = chains_start(&c, &guided, &b, &status) && name != NULL;
        if (ok && which->chain >= c.count) {
            char why[64];
            snprintf(why, sizeof why, "there are %u, from 0 on", (unsigned)c.count);
            ok = complain("no such chain", why);
        } else if (ok) {
            ok = run(&c, &guided, desc, &g, which, name);
        }
        bootstrap_free(&b);
    }
    if (status != VOLGRAD_OK) {
        ok = check("chains", status);
    }
    chains_free(&c);
    guide_free(&g);
    free(name);
    return ok;
}
