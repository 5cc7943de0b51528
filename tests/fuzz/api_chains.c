/* Metropolis chains from bootstrap to flush: weights, tables and starts as they were made, or not; chains that are copied, or continued
 * in another scene. */

#include "api.h"

enum { MOST_SAMPLES = 128, MOST_STARTS = 8 + VOLGRAD_MAX_LENGTH, MUTATIONS = 24, OTHER_SCENE = 3 };

static volgrad_chain_options decode_options(input *in) {
    volgrad_chain_options o;
    MUST(volgrad_chain_options_default(&o, sizeof o) == VOLGRAD_OK);
    o.min_length = hostile(in) ? below(in, 70) : 2 + pick(in, 3);
    o.max_length = hostile(in) ? below(in, 70) : o.min_length + pick(in, 4);
    o.burn_in = pick(in, 20);
    o.large_step = number(in, 0.1f, 1);
    o.shift_every = hostile(in) ? next_word(in) : 1 + pick(in, 4);
    o.seed = next_byte(in);
    decode_shift(in, &o.shift);
    if (o.shift.mode >= VOLGRAD_SHIFT_THESIS && !hostile(in)) {
        o.shift.kernel = VOLGRAD_KERNEL_BALL;
        o.shift.radius_unit = VOLGRAD_RADIUS_WORLD;
    }
    volgrad_chain_options_validate(&o, NULL);
    return o;
}

static volgrad_chain_stats no_stats(void) {
    volgrad_chain_stats stats;
    memset(&stats, 0, sizeof stats);
    stats.struct_size = sizeof stats;
    return stats;
}

/* What a peek says is what the next mutation does, if the host answers twice the same. */
static void peek(input *in, world *w, volgrad_chain *chain, const volgrad_chain_options *options, volgrad_film *film) {
    uint32_t capacity = hostile(in) ? pick(in, 8) : options->max_length + 1;
    volgrad_vertex *current = take_array(&w->memory, capacity * sizeof *current);
    volgrad_vertex *proposed = take_array(&w->memory, capacity * sizeof *proposed);
    volgrad_chain_mutation next;
    volgrad_chain_stats stats = no_stats();
    memset(&next, 0, sizeof next);
    next.struct_size = known_size(in, sizeof next, 8);
    volgrad_status status = volgrad_chain_peek(chain, w->scene, &w->queries, &next, current, proposed, capacity);
    if (status != VOLGRAD_OK || volgrad_chain_run(chain, w->scene, &w->queries, 1, film, &stats) != VOLGRAD_OK) return;
    MUST(next.current.vertex_count <= capacity && next.proposed.vertex_count <= capacity);
    if (w->lies || w->nonsense > 0) return;
    MUST(stats.large_steps == next.large && stats.large_accepted + stats.small_accepted == next.accepted);
}

static void run_chain(input *in, world *w, const volgrad_chain_options *options, const volgrad_chain_techniques *techniques,
                      const volgrad_chain_start *start, volgrad_film *film) {
    size_t bytes;
    volgrad_chain *chain = NULL;
    volgrad_chain_stats stats = no_stats();
    if (volgrad_chain_size(options, &bytes) != VOLGRAD_OK) return;
    void *memory = take(&w->memory, bytes);
    if (volgrad_chain_init(memory, bytes, w->scene, &w->queries, options, techniques, start, &stats, &chain) != VOLGRAD_OK) {
        MUST(chain == NULL);
        return;
    }
    if (pick(in, 2)) { /* moved */
        chain = memcpy(take(&w->memory, bytes), memory, bytes);
        memset(memory, 0xA5, bytes);
        MUST(volgrad_chain_flush(memory, w->scene, &w->queries, film, NULL) == VOLGRAD_ERROR_NOT_INITIALISED);
    }
    uint32_t was = w->ball_count;
    if (pick(in, OTHER_SCENE) == 0) w->ball_count = 0;
    stats = no_stats();
    volgrad_status status = volgrad_chain_run(chain, w->scene, &w->queries, MUTATIONS, film, &stats);
    MUST(status != VOLGRAD_OK || stats.large_steps + stats.small_steps == MUTATIONS);
    volgrad_chain_flush(chain, w->scene, &w->queries, film, &stats);
    peek(in, w, chain, options, film);
    w->ball_count = was;
    volgrad_chain_run(chain, w->scene, &w->queries, MUTATIONS, film, NULL);
}

static void decode_techniques(input *in, world *w, const volgrad_chain_options *options, volgrad_chain_techniques *techniques) {
    float weights[MOST_SAMPLES];
    volgrad_chain_bootstrap(w->scene, &w->queries, options, NULL, 0, MOST_SAMPLES, memset(weights, 0, sizeof weights), NULL);
    volgrad_chain_learn(options, weights, MOST_SAMPLES, techniques);
    while (hostile(in)) techniques->shares[below(in, 66) % 66][below(in, 65) % 65] = number(in, 0, 1);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static volgrad_chain_techniques table;
    input in = {data, size};
    world w;
    if (decode_world(&in, &w) == NULL) return release(&w.memory), 0;
    volgrad_film *film = take_film(&w.memory, w.desc.camera.width, w.desc.camera.height);
    if (film == NULL) return release(&w.memory), 0;
    volgrad_chain_options options = decode_options(&in);
    memset(&table, 0, sizeof table);
    const volgrad_chain_techniques *techniques = NULL;
    if (pick(&in, 2)) decode_techniques(&in, &w, &options, &table), techniques = &table;

    float weights[MOST_SAMPLES];
    memset(weights, 0, sizeof weights);
    w.patience = MOST_RAYS;
    volgrad_chain_stats stats = no_stats();
    volgrad_chain_bootstrap(w.scene, &w.queries, &options, techniques, 0, MOST_SAMPLES, weights, &stats);
    for (int i = 0; i < MOST_SAMPLES && !hostile(&in); i++) MUST(weights[i] >= 0 && isfinite(weights[i]));
    while (hostile(&in)) weights[pick(&in, MOST_SAMPLES)] = number(&in, 0, 1);

    volgrad_chain_start starts[MOST_STARTS];
    memset(starts, 0, sizeof starts);
    volgrad_chain_plan_result plan = {sizeof plan, 0, 0, 0};
    volgrad_chain_plan(&options, techniques, weights, MOST_SAMPLES, below(&in, 8), starts, MOST_STARTS, &plan);
    if (hostile(&in)) starts[0].length = below(&in, 65);
    if (hostile(&in)) starts[0].sample = next_word(&in);
    if (hostile(&in)) starts[0].share = number(&in, 0, 1);
    if (hostile(&in)) starts[0].value = number(&in, 0, 1);
    if (hostile(&in)) starts[0].others = number(&in, 0, 1);
    if (hostile(&in)) starts[0].brightness = number(&in, 0, 1);
    if (hostile(&in)) starts[0].chains = next_word(&in);
    for (uint32_t i = 0; i < 2; i++) {
        w.patience = MOST_RAYS;
        run_chain(&in, &w, &options, techniques, &starts[i], film);
    }
    check_film(&w.memory, film, w.desc.camera.width, w.desc.camera.height);
    release(&w.memory);
    return 0;
}
