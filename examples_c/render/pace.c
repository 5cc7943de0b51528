#include "pace.h"

#include <math.h>

static const double GROUP_SECONDS = 0.2;
static const double MOST_GROWTH = 4.0; /* the first ones are slow, and say little */

uint64_t pace_next(uint64_t done, double seconds, uint64_t last_size, double seconds_left)
{
    if (done == 0) {
        return 1;
    }
    double size = fmin(GROUP_SECONDS, seconds_left) * (double)done / seconds;
    size = fmin(size, MOST_GROWTH * (double)last_size);
    return size > 1.0 ? (uint64_t)size : 1;
}
