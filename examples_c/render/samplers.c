#include "samplers.h"

#include <stdio.h>

/* Most edges of a path; UINT32_MAX: no limit. */
static uint32_t longest_path(const samplers *all)
{
    return all->path.max_depth > 0 ? all->path.max_depth : UINT32_MAX;
}

static uint32_t at_most(uint32_t value, uint32_t limit)
{
    return value < limit ? value : limit;
}

static void leave_out(samplers *all, uint32_t first, uint32_t last)
{
    all->path.left_out_first = first;
    all->path.left_out_last = last;
}

/* The light that lights send through few gaps takes few edges to find them; longer paths cost more than they teach. */
enum { LONGEST_LESSON = 6 };

/* Guides learn from paths of up to `longest` edges. */
static void set_guide(samplers *all, const options *o, uint32_t longest)
{
    all->has_guide = !o->has_guide || o->guide > 0;
    all->guide.passes = o->guide;
    all->guide.options.max_length = at_most(LONGEST_LESSON, longest);
    all->guide.options.rr_depth = all->path.rr_depth;
    /* Other random numbers than those of the image: what they choose must not have been learned from them. */
    all->guide.options.seed = ~o->seed;
    all->guide.options.light_vertices = all->bidirectional.light_vertices;
}

static int set_bidirectional(samplers *all, const options *o)
{
    const uint32_t shortest = 2;
    if (longest_path(all) < shortest) {
        fputs("volgrad-render: --integrator bdpt is for paths of 2 or more edges, but max_depth is 1: use path\n", stderr);
        return 0;
    }
    all->bidirectional.max_length = at_most(VOLGRAD_MAX_LENGTH, longest_path(all));
    all->bidirectional.rr_depth = all->path.rr_depth;
    all->bidirectional.heuristic = o->heuristic;
    all->bidirectional.seed = o->seed;
    all->bidirectional.light_vertices = o->light_vertices;
    all->bidirectional.shift = o->shift;
    all->path.shift.run = 1; /* as there */
    leave_out(all, shortest, all->bidirectional.max_length);
    set_guide(all, o, all->bidirectional.max_length);
    return 1;
}

static int set_chains(samplers *all, const options *o)
{
    volgrad_chain_options *chains = &all->chains.options;
    if (longest_path(all) < chains->min_length) {
        fprintf(stderr, "volgrad-render: chains are for paths of %u or more edges (--chain-lengths), but max_depth is %u\n",
                (unsigned)chains->min_length, (unsigned)longest_path(all));
        return 0;
    }
    chains->max_length = at_most(chains->max_length, longest_path(all));
    chains->seed = o->seed;
    chains->shift = o->shift;
    if (options_is_thesis(o->shift.mode)) {
        all->path.shift.mode = VOLGRAD_SHIFT_NONE;
    }
    leave_out(all, chains->min_length, chains->max_length);
    set_guide(all, o, chains->max_length);
    return 1;
}

int samplers_set(samplers *out, const options *o, const scene *s)
{
    *out = (samplers){.chains = o->chains};
    volgrad_status status = volgrad_path_sampler_options_default(&out->path, sizeof out->path);
    if (status == VOLGRAD_OK) {
        status = volgrad_bidirectional_options_default(&out->bidirectional, sizeof out->bidirectional);
        out->guide.options = out->bidirectional;
    }
    if (status != VOLGRAD_OK) {
        fprintf(stderr, "volgrad-render: samplers: %s\n", volgrad_status_message(status));
        return 0;
    }
    out->path.max_depth = o->has_max_depth ? o->max_depth : s->max_depth;
    out->path.rr_depth = s->rr_depth;
    out->path.first_vertex = o->first_vertex;
    out->path.seed = o->seed;
    out->path.shift = o->shift;
    switch (o->integrator) {
    case INTEGRATOR_BDPT:
        return set_bidirectional(out, o);
    case INTEGRATOR_MMLT:
        return set_chains(out, o);
    default:
        return 1;
    }
}

/* ---- ways to choose from ---- */

typedef struct {
    uint32_t integrator, shift, count, run;
} candidate;

/* The best of what was tried in each of scenes/: path in cloud and smoke, bdpt in caustic, the others in room. The largest tiles are best
   where few paths carry much. What differs most is tried first: there may be no time for more. */
static const candidate CANDIDATES[] = {
    {INTEGRATOR_PATH, VOLGRAD_SHIFT_NONE, 0, 0},
    {INTEGRATOR_BDPT, VOLGRAD_SHIFT_NONE, 0, 0},
    {INTEGRATOR_PATH, VOLGRAD_SHIFT_EXCHANGEABLE, 35, 1},
    {INTEGRATOR_BDPT, VOLGRAD_SHIFT_EXCHANGEABLE, 35, 1},
};

unsigned samplers_list(samplers *all, options *each, const options *o, const scene *s)
{
    if (o->integrator != INTEGRATOR_AUTO) {
        each[0] = *o;
        return samplers_set(&all[0], o, s) ? 1 : 0;
    }
    unsigned count = 0;
    for (size_t i = 0; i < sizeof CANDIDATES / sizeof CANDIDATES[0]; ++i) {
        const candidate *c = &CANDIDATES[i];
        options *set = &each[count];
        *set = *o;
        set->integrator = c->integrator;
        set->shift.mode = c->shift;
        if (c->shift != VOLGRAD_SHIFT_NONE) {
            set->shift.kernel = VOLGRAD_KERNEL_TILE;
            set->shift.count = c->count;
            set->shift.run = c->run;
        }
        uint32_t longest = o->has_max_depth ? o->max_depth : s->max_depth;
        if (c->integrator == INTEGRATOR_PATH || longest != 1) {
            count += samplers_set(&all[count], set, s) ? 1 : 0;
        }
    }
    return count;
}

/* The best in scenes/room.xml of what was tried; a batch costs more than a connection. */
static double roulette(const options *o)
{
    return o->roulette >= 0.0 ? o->roulette : o->shift.mode != VOLGRAD_SHIFT_NONE ? 6.0 : 0.5;
}

way samplers_way(const samplers *all, const options *o)
{
    way w = {.sampler = &all->path,
             .bidirectional = o->integrator == INTEGRATOR_BDPT ? &all->bidirectional : NULL,
             .roulette = roulette(o)};
    const char *integrator = options_integrator_name(o->integrator);
    if (o->shift.mode == VOLGRAD_SHIFT_NONE) {
        snprintf(w.name, sizeof w.name, "--integrator %s", integrator);
    } else {
        snprintf(w.name, sizeof w.name, "--integrator %s --shift %s", integrator, options_shift_name(o->shift.mode));
    }
    return w;
}
