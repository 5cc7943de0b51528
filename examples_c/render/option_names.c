#include "option_names.h"

#include "option_values.h"
#include "volgrad.h"

/* By value. */
static const char *const SHIFT_NAMES[] = {
    [VOLGRAD_SHIFT_NONE] = "none",
    [VOLGRAD_SHIFT_LOG_LINEAR] = "log_linear",
    [VOLGRAD_SHIFT_EXACT] = "exact",
    [VOLGRAD_SHIFT_EXCHANGEABLE] = "exchangeable",
    [VOLGRAD_SHIFT_FIRST_ORDER] = "first_order",
    [VOLGRAD_SHIFT_HALF_ORDER] = "half_order",
    [VOLGRAD_SHIFT_LINEAR_DEPTH] = "linear_depth",
    [VOLGRAD_SHIFT_TWO_LEVEL] = "two_level",
    [VOLGRAD_SHIFT_THESIS] = "thesis",
    [VOLGRAD_SHIFT_THESIS_PRINTED] = "thesis_printed",
};
static const char *const KERNEL_NAMES[] = {
    [VOLGRAD_KERNEL_DISK] = "disk", [VOLGRAD_KERNEL_BALL] = "ball", [VOLGRAD_KERNEL_TILE] = "tile"};
static const char *const INTEGRATOR_NAMES[] = {
    [INTEGRATOR_PATH] = "path", [INTEGRATOR_BDPT] = "bdpt", [INTEGRATOR_MMLT] = "mmlt", [INTEGRATOR_AUTO] = "auto"};
static const char *const HEURISTIC_NAMES[] = {
    [VOLGRAD_HEURISTIC_BALANCE] = "balance", [VOLGRAD_HEURISTIC_POWER] = "power"};
/* Of VOLGRAD_FIRST_VERTEX_MEDIUM, a bit, and those after it. */
static const char *const FIRST_VERTEX_NAMES[] = {"medium", "surface", "specular", "none"};
enum {
    SHIFT_NAMES_COUNT = sizeof SHIFT_NAMES / sizeof SHIFT_NAMES[0],
    KERNEL_NAMES_COUNT = sizeof KERNEL_NAMES / sizeof KERNEL_NAMES[0],
    INTEGRATOR_NAMES_COUNT = sizeof INTEGRATOR_NAMES / sizeof INTEGRATOR_NAMES[0],
    HEURISTIC_NAMES_COUNT = sizeof HEURISTIC_NAMES / sizeof HEURISTIC_NAMES[0],
    FIRST_VERTEX_NAMES_COUNT = sizeof FIRST_VERTEX_NAMES / sizeof FIRST_VERTEX_NAMES[0]
};

const char *options_shift_name(uint32_t mode)
{
    return mode < SHIFT_NAMES_COUNT ? SHIFT_NAMES[mode] : "unknown";
}

const char *options_kernel_name(uint32_t kernel)
{
    return kernel < KERNEL_NAMES_COUNT ? KERNEL_NAMES[kernel] : "unknown";
}

const char *options_integrator_name(uint32_t integrator)
{
    return integrator < INTEGRATOR_NAMES_COUNT ? INTEGRATOR_NAMES[integrator] : "unknown";
}

const char *options_heuristic_name(uint32_t heuristic)
{
    return heuristic < HEURISTIC_NAMES_COUNT ? HEURISTIC_NAMES[heuristic] : "unknown";
}

const char *options_first_vertex_name(uint32_t kinds)
{
    for (uint32_t i = 0; i < FIRST_VERTEX_NAMES_COUNT; ++i) {
        if (kinds == (uint32_t)VOLGRAD_FIRST_VERTEX_MEDIUM << i) {
            return FIRST_VERTEX_NAMES[i];
        }
    }
    return "all";
}

int read_shift(const char *text, uint32_t *mode)
{
    return read_name(text, SHIFT_NAMES, SHIFT_NAMES_COUNT, mode);
}

int read_kernel(const char *text, uint32_t *kernel)
{
    return read_name(text, KERNEL_NAMES, KERNEL_NAMES_COUNT, kernel);
}

int read_integrator(const char *text, uint32_t *integrator)
{
    return read_name(text, INTEGRATOR_NAMES, INTEGRATOR_NAMES_COUNT, integrator);
}

int read_heuristic(const char *text, uint32_t *heuristic)
{
    return read_name(text, HEURISTIC_NAMES, HEURISTIC_NAMES_COUNT, heuristic);
}

int read_first_vertex(const char *text, uint32_t *kinds)
{
    uint32_t index;
    int known = read_name(text, FIRST_VERTEX_NAMES, FIRST_VERTEX_NAMES_COUNT, &index);
    *kinds = known ? (uint32_t)VOLGRAD_FIRST_VERTEX_MEDIUM << index : 0;
    return known;
}
