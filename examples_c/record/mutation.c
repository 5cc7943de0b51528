#include "mutation.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the media along a path ---- */

static volgrad_vec3 along(volgrad_vec3 o, double t, volgrad_vec3 d)
{
    return (volgrad_vec3){(float)(o.x + t * d.x), (float)(o.y + t * d.y), (float)(o.z + t * d.z)};
}

static double dot(volgrad_vec3 a, volgrad_vec3 b)
{
    return (double)a.x * b.x + (double)a.y * b.y + (double)a.z * b.z;
}

static int is_far(const volgrad_scene_desc *desc, const volgrad_vertex *v)
{
    uint32_t kind = v->kind == VOLGRAD_VERTEX_LIGHT && v->index < desc->light_count ? desc->lights[v->index].kind : VOLGRAD_LIGHT_POINT;
    return kind == VOLGRAD_LIGHT_ENVIRONMENT || kind == VOLGRAD_LIGHT_ENVIRONMENT_MAP || kind == VOLGRAD_LIGHT_CUSTOM_SKY ||
           kind == VOLGRAD_LIGHT_DIRECTIONAL;
}

/* Rays start this far from a surface, and end as far before one, over the edge's length. */
static const double SURFACE_EPSILON = 1e-4;

/* The edge from vertex i to the next: its media, from `medium` on; and the medium beyond, where the next edge starts. */
static volgrad_status follow(whole_path *p, uint32_t i, const volgrad_scene_desc *desc, const volgrad_queries *queries, uint32_t *medium)
{
    const volgrad_vertex *from = &p->vertices[i], *to = from + 1;
    const volgrad_camera *camera = &desc->camera;
    volgrad_vec3 o = i == 0 && camera->kind == VOLGRAD_CAMERA_PINHOLE ? camera->position : from->position, d = to->position;
    double length = INFINITY, skipped = 0;
    if (!is_far(desc, to)) {
        d = along(to->position, -1, o);
        length = sqrt(dot(d, d));
        d = along((volgrad_vec3){0, 0, 0}, 1 / length, d);
    }
    if (i == 0) {
        skipped = camera->near_clip / dot(camera->forward, d);
    }
    int meets = to->kind == VOLGRAD_VERTEX_SURFACE;
    double epsilon = isinf(length) ? 0 : SURFACE_EPSILON * length;
    volgrad_ray ray = {.origin = along(o, skipped, d), .direction = d, .medium = *medium,
                       .t_min = from->kind == VOLGRAD_VERTEX_SURFACE ? (float)(isinf(length) ? SURFACE_EPSILON : epsilon) : 0,
                       .t_max = (float)(length - skipped + (meets ? epsilon : to->kind == VOLGRAD_VERTEX_MEDIUM ? 0 : -epsilon))};
    volgrad_hit hit;
    if ((meets ? queries->intersect : queries->occluded)(queries->user, &ray, &hit, 1) != 0) {
        return VOLGRAD_ERROR_CALLBACK;
    }
    if (hit.kind == VOLGRAD_HIT_OVERFLOW || (!meets && hit.kind == VOLGRAD_HIT_SURFACE) || hit.segment_count > VOLGRAD_MAX_SEGMENTS) {
        hit.segment_count = 0; /* the report will say that segments are missing */
    }
    for (uint32_t s = 0; s < hit.segment_count; ++s) {
        volgrad_segment *segment = &p->segments[p->segment_count++];
        *segment = hit.segments[s];
        segment->end += (float)skipped;
        *medium = segment->medium;
        if (s + 1 == hit.segment_count && !(segment->end >= length)) {
            segment->end = (float)length; /* it ended a little before the surface */
        }
    }
    if (meets && hit.kind == VOLGRAD_HIT_SURFACE && hit.medium_outside != VOLGRAD_KEEP_MEDIUM && i + 2 < MOST_VERTICES) {
        volgrad_vec3 next = is_far(desc, to + 1) ? to[1].position : along(to[1].position, -1, to->position);
        *medium = dot(hit.normal, next) > 0 ? hit.medium_outside : hit.medium_inside;
    }
    p->edge_ends[i] = p->segment_count;
    return VOLGRAD_OK;
}

static volgrad_status find_media(whole_path *p, uint32_t count, const volgrad_scene_desc *desc, const volgrad_queries *queries)
{
    uint32_t medium = desc->camera.medium;
    volgrad_status status = VOLGRAD_OK;
    for (uint32_t i = 0; i + 1 < count && status == VOLGRAD_OK; ++i) {
        status = follow(p, i, desc, queries, &medium);
    }
    return status;
}

volgrad_status mutation_look(mutation *m, const volgrad_chain *chain, const volgrad_scene *scene, const volgrad_scene_desc *desc,
                             const volgrad_queries *queries)
{
    memset(m, 0, sizeof *m);
    m->what.struct_size = sizeof m->what;
    volgrad_status status = volgrad_chain_peek(chain, scene, queries, &m->what, m->paths[0].vertices, m->paths[1].vertices, MOST_VERTICES);
    if (status == VOLGRAD_OK) {
        status = find_media(&m->paths[0], m->what.current.vertex_count, desc, queries);
    }
    if (status == VOLGRAD_OK) {
        status = find_media(&m->paths[1], m->what.proposed.vertex_count, desc, queries);
    }
    return status;
}

/* ---- in words ---- */

void path_print(FILE *to, const volgrad_scene *scene, const volgrad_path *path)
{
    size_t length = 0;
    volgrad_status status = volgrad_path_report(scene, path, NULL, 0, &length);
    char *text = malloc(length + 1);
    if (status == VOLGRAD_OK && text != NULL) {
        status = volgrad_path_report(scene, path, text, length + 1, &length);
    }
    fprintf(to, "%s\n", status == VOLGRAD_OK && text != NULL ? text : volgrad_status_message(status));
    free(text);
}

static void print_path(FILE *to, const char *name, const volgrad_chain_path *about, const whole_path *p, const volgrad_scene *scene)
{
    fprintf(to, "%s: %u vertices from the camera, %u from a light, ", name, (unsigned)about->camera_vertices, (unsigned)about->light_vertices);
    if (about->vertex_count == 0) {
        fputs("carries nothing\n", to);
        return;
    }
    fprintf(to, "at pixel %.4f %.4f, target %.9g\n", (double)about->x, (double)about->y, about->target);
    path_print(to, scene, &(volgrad_path){p->vertices, p->segments, p->edge_ends, about->vertex_count, p->segment_count});
}

void mutation_print(FILE *to, const mutation *m, const volgrad_scene *scene)
{
    const volgrad_chain_mutation *what = &m->what;
    const char *changed = what->changes_camera && what->changes_light ? "all numbers" : what->changes_camera ? "the camera's subpath" : "the light's subpath";
    fprintf(to, "mutation %" PRIu64 ": %s of %s, acceptance %.9g: %s\n", what->number, what->large ? "large step" : "small step", changed,
            what->acceptance, what->accepted ? "accepted" : "rejected");
    print_path(to, "current path", &what->current, &m->paths[0], scene);
    print_path(to, "proposed path", &what->proposed, &m->paths[1], scene);
}
