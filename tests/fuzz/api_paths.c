/* Paths of all kinds of vertices, most of which no sampler would make: contribution, factors, gradients, shifts. */

#include "api.h"

enum { MOST_VERTICES = 7, MOST_EDGE_SEGMENTS = 3, MOST_PATHS = 4 };

static void decode_vertex(input *in, const volgrad_scene_desc *d, uint32_t i, uint32_t count, volgrad_vertex *v) {
    v->kind = i == 0 ? VOLGRAD_VERTEX_CAMERA : i + 1 == count ? VOLGRAD_VERTEX_LIGHT : 1 + pick(in, 2);
    if (hostile(in)) v->kind = below(in, 4);
    uint32_t counts[] = {1, d->media_count, d->material_count, d->light_count};
    v->index = below(in, counts[v->kind & 3]);
    v->position = i == 0 && next_byte(in) & 1 ? d->camera.position : point(in);
    if (v->kind == VOLGRAD_VERTEX_LIGHT && next_byte(in) & 1) v->position = direction(in);
    v->normal = v->shading_normal = direction(in);
    v->user = SAID;
}

static void decode_edge(input *in, world *w, volgrad_segment *segments, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        segments[i].end = i + 1 == count && !hostile(in) ? INFINITY : number(in, 0, 4);
        segments[i].medium = next_byte(in) & 1 && w->desc.media_count ? pick(in, w->desc.media_count) : below(in, w->desc.media_count);
        if (pick(in, 8) == 0) segments[i].medium = VOLGRAD_NONE;
        segments[i].normal = direction(in);
    }
}

static volgrad_path decode_path(input *in, world *w) {
    volgrad_path path;
    path.vertex_count = 2 + pick(in, MOST_VERTICES - 1);
    uint32_t edges = path.vertex_count - 1, sizes[MOST_VERTICES], sum = 0;
    volgrad_vertex *vertices = take_array(&w->memory, path.vertex_count * sizeof *vertices);
    uint32_t *ends = take_array(&w->memory, edges * sizeof *ends);
    for (uint32_t i = 0; i < path.vertex_count; i++) decode_vertex(in, &w->desc, i, path.vertex_count, &vertices[i]);
    for (uint32_t i = 0; i < edges; i++) {
        sizes[i] = hostile(in) ? 0 : 1 + pick(in, MOST_EDGE_SEGMENTS);
        ends[i] = sum += sizes[i];
    }
    volgrad_segment *segments = take_array(&w->memory, sum * sizeof *segments);
    for (uint32_t i = 0, from = 0; i < edges; from = ends[i++]) decode_edge(in, w, segments + from, sizes[i]);
    if (hostile(in)) ends[pick(in, edges)] = below(in, sum + 1);
    path.vertices = hostile(in) ? NULL : vertices;
    path.edge_ends = hostile(in) ? NULL : ends;
    path.segments = hostile(in) ? NULL : segments;
    path.segment_count = hostile(in) && sum > 0 ? sum - 1 : sum;
    if (hostile(in)) path.vertex_count = pick(in, 2);
    return path;
}

/* All of the report, and as much of it as there is room for. */
static void report(input *in, world *w, const volgrad_path *path) {
    size_t length = 0, again = 0, room = hostile(in) ? 1 : 1 + pick(in, 200);
    if (volgrad_path_report(w->scene, path, NULL, 0, &length) != VOLGRAD_OK) return;
    char *whole = take_array(&w->memory, length + 1), *part = take_array(&w->memory, room);
    MUST(volgrad_path_report(w->scene, path, whole, length + 1, &again) == VOLGRAD_OK);
    MUST(w->lies || (again == length && strlen(whole) == length));
    MUST(volgrad_path_report(w->scene, path, part, room, &again) == VOLGRAD_OK);
    size_t written = room - 1 < again ? room - 1 : again;
    MUST(strlen(part) == written && (w->lies || strncmp(part, whole, written) == 0));
}

static void use_path(input *in, world *w, const volgrad_path *path) {
    volgrad_error error = {sizeof error, 0, NULL};
    volgrad_gradient gradient;
    volgrad_derivative derivative;
    double f[3];
    volgrad_path_validate(w->scene, path, &error);
    volgrad_path_contribution(w->scene, path, f);
    report(in, w, path);
    volgrad_path_factor *factors = take_array(&w->memory, path->vertex_count * sizeof *factors);
    volgrad_path_factors(w->scene, path, factors, path->vertex_count);
    MUST(volgrad_path_factors(w->scene, path, factors, path->vertex_count - (path->vertex_count > 0)) != VOLGRAD_OK);
    for (uint32_t first = 0; first < path->vertex_count; first++) {
        volgrad_path_log_gradient(w->scene, path, first, &gradient);
        volgrad_path_run_log_gradient(w->scene, path, first, below(in, path->vertex_count), &gradient);
        volgrad_path_run_log_derivative(w->scene, path, first, below(in, path->vertex_count), &derivative);
    }
}

static void shift(input *in, world *w, const volgrad_path *path) {
    volgrad_shift_options options;
    decode_shift(in, &options);
    uint32_t capacity = hostile(in) ? pick(in, 10) : VOLGRAD_MAX_SHIFTS + 1, count = 0;
    volgrad_splat *splats = take_array(&w->memory, capacity * sizeof *splats);
    const volgrad_queries *queries = hostile(in) ? NULL : &w->queries;
    uint64_t seed = next_byte(in), index = next_byte(in);
    volgrad_status status = volgrad_shift_path(w->scene, queries, &options, path, colour(in, 0, 10), seed, index, splats, capacity, &count);
    MUST(status == VOLGRAD_OK ? count <= capacity : count == 0);
    uint32_t x = below(in, MOST_SIDE), y = below(in, MOST_SIDE), bounds[4];
    if (volgrad_shift_tile(w->scene, &options, seed, x, y, bounds) != VOLGRAD_OK) return;
    MUST(bounds[0] <= x && x < bounds[2] && bounds[1] <= y && y < bounds[3]);
}

/* All at once, the first of them often twice: neighbours that have everything in common. */
static void shift_all(input *in, world *w, volgrad_path *paths, uint32_t path_count) {
    volgrad_shift_options options;
    volgrad_rgb weights[MOST_PATHS];
    decode_shift(in, &options);
    if (path_count > 1 && pick(in, 2)) paths[1] = paths[0];
    for (uint32_t i = 0; i < path_count; i++) weights[i] = colour(in, 0, 10);
    uint32_t capacity = path_count * (VOLGRAD_MAX_SHIFTS + 1), count = 0;
    if (hostile(in)) capacity = pick(in, 40);
    volgrad_splat *splats = take_array(&w->memory, capacity * sizeof *splats);
    const volgrad_queries *queries = hostile(in) ? NULL : &w->queries;
    uint64_t seed = next_byte(in), index = hostile(in) ? UINT64_MAX : next_byte(in);
    volgrad_status status =
        volgrad_shift_paths(w->scene, queries, &options, paths, weights, path_count, seed, index, splats, capacity, &count);
    uint32_t most = options.struct_size < sizeof options ? VOLGRAD_MAX_SHIFTS : options.count; /* options that are cut off have the default's */
    MUST(status == VOLGRAD_OK ? count <= capacity && count <= path_count * (most + 1ull) : count == 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    input in = {data, size};
    world w;
    int with_scene = decode_world(&in, &w) != NULL;
    volgrad_path paths[MOST_PATHS];
    uint32_t count = 0;
    while (with_scene && count < MOST_PATHS && in.size > 0) {
        volgrad_path *path = &paths[count++];
        *path = decode_path(&in, &w);
        use_path(&in, &w, path);
        shift(&in, &w, path);
    }
    if (with_scene) shift_all(&in, &w, paths, count);
    release(&w.memory);
    return 0;
}
