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

static void use_path(input *in, world *w, const volgrad_path *path) {
    volgrad_error error = {sizeof error, 0, NULL};
    volgrad_gradient gradient;
    volgrad_derivative derivative;
    double f[3];
    volgrad_path_validate(w->scene, path, &error);
    volgrad_path_contribution(w->scene, path, f);
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
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    input in = {data, size};
    world w;
    int with_scene = decode_world(&in, &w) != NULL;
    for (int i = 0; with_scene && i < MOST_PATHS && in.size > 0; i++) {
        volgrad_path path = decode_path(&in, &w);
        use_path(&in, &w, &path);
        shift(&in, &w, &path);
    }
    release(&w.memory);
    return 0;
}
