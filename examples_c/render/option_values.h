/* The values of command-line options from text, strictly: nothing before them, nothing after. All return 0 if the text is wrong. */
#ifndef RENDER_OPTION_VALUES_H
#define RENDER_OPTION_VALUES_H

#include <stdint.h>

#include "volgrad.h"

/* A whole decimal number from low to high. */
int read_whole(const char *text, uint64_t low, uint64_t high, uint64_t *out);
int read_whole32(const char *text, uint32_t low, uint32_t high, uint32_t *out);

/* A number > 0 followed by `unit`. */
int read_positive(const char *text, const char *unit, double *out);

/* A number >= 0. */
int read_factor(const char *text, double *out);

/* A number from 0 to 1. */
int read_share(const char *text, float *out);

/* A number > 0, also in single precision. */
int read_clamp(const char *text, float *out);

/* Two whole numbers as in 2-32, the first not greater. */
int read_range(const char *text, uint32_t low, uint32_t high, uint32_t *first, uint32_t *last);

/* A chain and one of its mutations, as in 3:1000. */
int read_mutation(const char *text, uint32_t *chain, uint64_t *mutation);

/* A kernel's radius in pixels, as in 4px, or in world units, as in 0.1. */
int read_radius(const char *text, volgrad_shift_options *shift);

/* The index of a name. */
int read_name(const char *text, const char *const *names, uint32_t count, uint32_t *out);

/* x0,y0,x1,y1 with x0 < x1 and y0 < y1. Whether that fits the image is known only with the scene. */
int read_crop(const char *text, uint32_t crop[4]);

#endif
