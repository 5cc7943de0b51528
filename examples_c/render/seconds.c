#define _POSIX_C_SOURCE 200809L /* clock_gettime */

#include "seconds.h"

#include <time.h>

static double seconds_of(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double seconds_wall(void)
{
    return seconds_of(CLOCK_MONOTONIC);
}

double seconds_cpu(void)
{
    return seconds_of(CLOCK_PROCESS_CPUTIME_ID);
}
