#include "crossings.h"

#include <math.h>
#include <stddef.h>

void crossings_clear(crossing_list *list)
{
    list->count = 0;
    list->lost_from = INFINITY;
}

static int is_known(const crossing_list *list, const crossing *added)
{
    for (uint32_t i = 0; i < list->count; ++i) {
        const crossing *c = &list->items[i];
        if (c->shape == added->shape && c->primitive == added->primitive && c->leaves == added->leaves) {
            return 1;
        }
    }
    return 0;
}

static crossing *farthest(crossing_list *list)
{
    crossing *far = &list->items[0];
    for (uint32_t i = 1; i < list->count; ++i) {
        if (list->items[i].t > far->t) {
            far = &list->items[i];
        }
    }
    return far;
}

void crossings_add(crossing_list *list, const crossing *added)
{
    if (is_known(list, added)) {
        return;
    }
    if (list->count < CROSSINGS_CAPACITY) {
        list->items[list->count++] = *added;
        return;
    }
    crossing *far = farthest(list);
    if (added->t < far->t) {
        list->lost_from = fmin(list->lost_from, far->t);
        *far = *added;
    } else {
        list->lost_from = fmin(list->lost_from, added->t);
    }
}

/* By distance. Where two shapes touch, the one that is left comes before the one that is entered: the media beyond count. */
static int goes_before(const crossing *a, const crossing *b)
{
    if (a->shape != b->shape && a->leaves != b->leaves && fabs(a->t - b->t) <= a->gap + b->gap) {
        return a->leaves;
    }
    return a->t < b->t;
}

/* Insertion sort: stable, and lists are short. */
static void sort(crossing_list *list)
{
    for (uint32_t i = 1; i < list->count; ++i) {
        crossing moved = list->items[i];
        uint32_t j = i;
        for (; j > 0 && goes_before(&moved, &list->items[j - 1]); --j) {
            list->items[j] = list->items[j - 1];
        }
        list->items[j] = moved;
    }
}

/* Entering and leaving one shape at the same place is brushing past an edge or corner: which of the two comes first is rounding,
   and the medium after it is the one before it. */
static int only_touches(const crossing_list *list, uint32_t index)
{
    const crossing *c = &list->items[index];
    for (uint32_t i = 0; i < list->count; ++i) {
        const crossing *other = &list->items[i];
        if (other->shape == c->shape && other->leaves != c->leaves && fabs(other->t - c->t) <= other->t_error + c->t_error) {
            return 1;
        }
    }
    return 0;
}

/* The segments so far, and the medium of the one that is still open. */
typedef struct {
    volgrad_segment *segments;
    uint32_t count;
    uint32_t medium;
} segment_builder;

/* Ends the open segment at a surface and opens the next. Segments without length are left out, equal neighbours are merged.
   Returns 0 if there is no room. */
static int change_medium(segment_builder *builder, float end, const crossing *c)
{
    float start = builder->count > 0 ? builder->segments[builder->count - 1].end : 0.0f;
    if (end > start) {
        if (builder->count + 1 >= VOLGRAD_MAX_SEGMENTS) {
            return 0;
        }
        builder->segments[builder->count++] =
            (volgrad_segment){.end = end, .medium = builder->medium, .normal = c->normal};
    }
    if (builder->count > 0 && builder->segments[builder->count - 1].medium == c->medium) {
        builder->count--;
    }
    builder->medium = c->medium;
    return 1;
}

const crossing *crossings_first(crossing_list *list)
{
    sort(list);
    for (uint32_t i = 0; i < list->count; ++i) {
        if (!only_touches(list, i)) {
            return &list->items[i];
        }
    }
    return NULL;
}

uint32_t crossings_segments(crossing_list *list, uint32_t medium, double end, volgrad_segment *segments)
{
    if (list->lost_from < end) {
        return 0;
    }
    segment_builder builder = {segments, 0, medium};
    float last_end = (float)end;
    sort(list);
    for (uint32_t i = 0; i < list->count; ++i) {
        const crossing *c = &list->items[i];
        if (!(c->t < end) || c->medium == builder.medium || only_touches(list, i)) {
            continue;
        }
        if (!change_medium(&builder, fminf((float)c->t, last_end), c)) {
            return 0;
        }
    }
    segments[builder.count++] = (volgrad_segment){.end = last_end, .medium = builder.medium};
    return builder.count;
}
