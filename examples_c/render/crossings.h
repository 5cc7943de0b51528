/* The surfaces between media that a ray crosses: null (index-matched) ones on its way to an opaque one, or all of them.

   Crossings arrive in any order while Embree traverses its tree, some of them twice. A crossing names the medium that the ray is in
   after it, whatever it was in before, so repeating one changes nothing. */
#ifndef RENDER_CROSSINGS_H
#define RENDER_CROSSINGS_H

#include <stdint.h>

#include "volgrad.h"

typedef struct {
    double t;       /* distance from the ray's origin, world units, > 0 */
    double t_error; /* rounding of `t`: another primitive of this shape is met here too if it is met this close */
    double gap;     /* rounding of the shape: another shape that should touch it here may be met this far away */
    volgrad_vec3 normal;
    uint32_t medium; /* after the crossing */
    uint32_t shape;
    uint32_t primitive;
    int leaves; /* the ray goes to the side that the normal points to */
} crossing;

/* Crossings kept per ray: room for VOLGRAD_MAX_SEGMENTS media with edges hit twice. */
enum { CROSSINGS_CAPACITY = 4 * VOLGRAD_MAX_SEGMENTS };

typedef struct {
    uint32_t count;
    double lost_from; /* distance of the nearest crossing that found no room; INFINITY if there was room for all */
    crossing items[CROSSINGS_CAPACITY];
} crossing_list;

void crossings_clear(crossing_list *list);

/* Adds a crossing unless it is known already. When the list is full, the farthest one is dropped. */
void crossings_add(crossing_list *list, const crossing *added);

/* The nearest one; NULL if there is none. Sorts the list. */
const crossing *crossings_first(crossing_list *list);

/* Writes the media from the ray's origin, which is in `medium`, to `end` (may be INFINITY); crossings at or beyond `end` do not
   count. Returns the number of segments, or 0 if they are more than VOLGRAD_MAX_SEGMENTS. Sorts the list. */
uint32_t crossings_segments(crossing_list *list, uint32_t medium, double end, volgrad_segment *segments);

#endif
