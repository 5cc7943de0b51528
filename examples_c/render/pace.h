/* How much to do between two looks at the clock and the signal. Threads wait for each other there, so it should take a while, but no
   longer than one likes to wait. */
#ifndef RENDER_PACE_H
#define RENDER_PACE_H

#include <stdint.h>

/* The next group's size, at least 1: `done` took `seconds`, the last group was of `last_size`, and there are `seconds_left` (INFINITY:
   no limit). Units are the caller's. */
uint64_t pace_next(uint64_t done, double seconds, uint64_t last_size, double seconds_left);

#endif
