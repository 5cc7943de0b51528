/* Names of settings, as on the command line and in image files. */
#ifndef RENDER_OPTION_NAMES_H
#define RENDER_OPTION_NAMES_H

#include <stdint.h>

enum { INTEGRATOR_PATH, INTEGRATOR_BDPT, INTEGRATOR_MMLT, INTEGRATOR_AUTO };

const char *options_shift_name(uint32_t mode); /* "none" for VOLGRAD_SHIFT_NONE */
const char *options_kernel_name(uint32_t kernel);
const char *options_integrator_name(uint32_t integrator);
const char *options_heuristic_name(uint32_t heuristic);
const char *options_first_vertex_name(uint32_t kinds); /* "all" for 0 */

/* The value of a name. Return 0 if it is none. */
int read_shift(const char *text, uint32_t *mode);
int read_kernel(const char *text, uint32_t *kernel);
int read_integrator(const char *text, uint32_t *integrator);
int read_heuristic(const char *text, uint32_t *heuristic);
int read_first_vertex(const char *text, uint32_t *kinds);

#endif
