/* What the C tests share: counted checks, and outputs that must stay as they were. */

#ifndef CHECK_H
#define CHECK_H

#include <math.h>
#include <stdalign.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "volgrad.h"

static int check_passed, check_failed;

static inline void check_that(int ok, const char *what, const char *file, int line) {
    check_passed += ok != 0;
    check_failed += ok == 0;
    if (!ok) fprintf(stderr, "%s:%d: failed: %s\n", file, line, what);
}

static inline void check_status(volgrad_status got, volgrad_status expected, const char *what, const char *file, int line) {
    check_that(got == expected, what, file, line);
    if (got != expected) fprintf(stderr, "  expected %d (%s), got %d\n", expected, volgrad_status_message(expected), got);
}

static inline void check_near(double got, double expected, double within, const char *what, const char *file, int line) {
    int ok = fabs(got - expected) <= within; /* false for NaN */
    check_that(ok, what, file, line);
    if (!ok) fprintf(stderr, "  expected %.9g within %.3g, got %.9g\n", expected, within, got);
}

#define CHECK(condition) check_that((condition), #condition, __FILE__, __LINE__)
#define CHECK_STATUS(call, expected) check_status((call), (expected), #call, __FILE__, __LINE__)
#define CHECK_NEAR(got, expected, within) check_near((got), (expected), (within), #got, __FILE__, __LINE__)

/* Before a call that must fail: fills an output with a pattern; after it: whether the pattern is still there. */
#define FILL(output) memset(&(output), 0xA5, sizeof(output))
#define UNTOUCHED(output) untouched(&(output), sizeof(output))

static inline int untouched(const void *memory, size_t bytes) {
    const unsigned char *byte = memory;
    while (bytes > 0 && byte[bytes - 1] == 0xA5) bytes--;
    return bytes == 0;
}

/* A call that must fail with `expected` and leave `output` alone. */
#define REFUSED(output, call, expected) (FILL(output), CHECK_STATUS(call, expected), CHECK(UNTOUCHED(output)))

/* The last statement of main. */
static inline int check_end(void) {
    printf("%d passed, %d failed\n", check_passed, check_failed);
    return check_failed ? EXIT_FAILURE : EXIT_SUCCESS;
}

#endif
