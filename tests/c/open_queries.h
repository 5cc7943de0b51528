/* The geometry of the C tests: none. Fog everywhere, or a slab of it between z = 1 and z = 2; and answers that break the rules. */

#ifndef OPEN_QUERIES_H
#define OPEN_QUERIES_H

#include "small_scene.h"

enum answer {
    FOG,
    SLAB,
    OVERFLOWS,
    STOPS,
    END_NAN,
    END_NEGATIVE,
    NO_SEGMENT,
    TOO_MANY_SEGMENTS,
    MEDIUM_BEYOND,
    KIND_BEYOND,
    MATERIAL_BEYOND,
    LIGHT_BEYOND,
    SIDE_BEYOND,
    T_NAN,
    T_ZERO,
    NORMAL_ZERO,
    NORMAL_NAN,
    ANSWERS
};

typedef struct open_queries {
    volgrad_queries queries;
    /* The first `good` calls get the first answer, all others the second. */
    enum answer first, answer;
    uint32_t good;
    uint32_t calls;
} open_queries;

static inline void answer_slab(const volgrad_ray *ray, volgrad_hit *hit) {
    float enter = (1 - ray->origin.z) / ray->direction.z, leave = (2 - ray->origin.z) / ray->direction.z;
    if (enter > leave) {
        float swap = enter;
        enter = leave, leave = swap;
    }
    const float ends[3] = {enter, leave, INFINITY};
    hit->segment_count = 0;
    for (int i = 0; i < 3; i++) {
        float end = ends[i] < ray->t_max ? ends[i] : ray->t_max;
        if (!(end > 0)) continue;
        volgrad_segment segment = {end, i == 1 ? 0 : VOLGRAD_NONE, {0, 0, 1}};
        hit->segments[hit->segment_count++] = segment;
    }
}

static inline int32_t answer_rays(void *user, const volgrad_ray *rays, volgrad_hit *hits, uint32_t count) {
    open_queries *q = user;
    enum answer answer = q->calls++ < q->good ? q->first : q->answer;
    for (uint32_t i = 0; i < count; i++) {
        volgrad_hit hit;
        memset(&hit, 0xFF, sizeof hit); /* what a rule does not ask for */
        hit.kind = VOLGRAD_HIT_NONE;
        hit.segment_count = 1;
        hit.segments[0].end = rays[i].t_max;
        hit.segments[0].medium = rays[i].medium;
        if (answer == SLAB) answer_slab(&rays[i], &hit);
        if (answer >= MATERIAL_BEYOND) {
            hit.kind = VOLGRAD_HIT_SURFACE;
            hit.material = DIFFUSE;
            hit.light = VOLGRAD_NONE;
            hit.t = 1;
            hit.normal = vec(0, 0, -1);
            hit.medium_inside = hit.medium_outside = VOLGRAD_KEEP_MEDIUM;
        }
        switch (answer) {
        case OVERFLOWS: hit.kind = VOLGRAD_HIT_OVERFLOW; break;
        case STOPS: return 7;
        case END_NAN: hit.segments[0].end = NAN; break;
        case END_NEGATIVE: hit.segments[0].end = -1; break;
        case NO_SEGMENT: hit.segment_count = 0; break;
        case TOO_MANY_SEGMENTS: hit.segment_count = VOLGRAD_MAX_SEGMENTS + 1; break;
        case MEDIUM_BEYOND: hit.segments[0].medium = 1; break;
        case KIND_BEYOND: hit.kind = 3; break;
        case MATERIAL_BEYOND: hit.material = MATERIALS; break;
        case LIGHT_BEYOND: hit.light = LIGHTS; break;
        case SIDE_BEYOND: hit.medium_inside = 1; break;
        case T_NAN: hit.t = NAN; break;
        case T_ZERO: hit.t = 0; break;
        case NORMAL_ZERO: hit.normal = vec(0, 0, 0); break;
        case NORMAL_NAN: hit.normal = vec(NAN, 0, 1); break;
        default: break;
        }
        hits[i] = hit;
    }
    return 0;
}

static inline const volgrad_queries *queries_answer(open_queries *q, enum answer first, uint32_t good, enum answer answer) {
    memset(q, 0, sizeof *q);
    q->queries.struct_size = sizeof q->queries;
    q->queries.user = q;
    q->queries.intersect = q->queries.occluded = answer_rays;
    q->first = first;
    q->answer = answer;
    q->good = good;
    return &q->queries;
}

static inline volgrad_status answer_status(enum answer answer) {
    return answer == STOPS ? VOLGRAD_ERROR_CALLBACK : VOLGRAD_ERROR_INVALID_HIT;
}

#endif
