#define _POSIX_C_SOURCE 200809L /* strtok_r */

#include "option_values.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

int read_whole(const char *text, uint64_t low, uint64_t high, uint64_t *out)
{
    /* strtoull alone would take signs and blanks. */
    if (*text == '\0' || text[strspn(text, "0123456789")] != '\0') {
        return 0;
    }
    errno = 0;
    *out = strtoull(text, NULL, 10);
    return errno == 0 && *out >= low && *out <= high;
}

int read_whole32(const char *text, uint32_t low, uint32_t high, uint32_t *out)
{
    uint64_t value;
    if (!read_whole(text, low, high, &value)) {
        return 0;
    }
    *out = (uint32_t)value;
    return 1;
}

int read_positive(const char *text, const char *unit, double *out)
{
    char *rest;
    *out = strtod(text, &rest);
    return rest != text && strcmp(rest, unit) == 0 && isfinite(*out) && *out > 0.0;
}

int read_factor(const char *text, double *out)
{
    char *rest;
    *out = strtod(text, &rest);
    return rest != text && *rest == '\0' && isfinite(*out) && *out >= 0.0;
}

int read_share(const char *text, float *out)
{
    char *rest;
    *out = strtof(text, &rest);
    return rest != text && *rest == '\0' && *out >= 0.0f && *out <= 1.0f;
}

int read_clamp(const char *text, float *out)
{
    double clamp;
    int read = read_positive(text, "", &clamp);
    *out = read ? (float)clamp : 0.0f;
    return isfinite(*out) && *out > 0.0f;
}

int read_range(const char *text, uint32_t low, uint32_t high, uint32_t *first, uint32_t *last)
{
    char copy[32];
    if (strlen(text) >= sizeof copy) {
        return 0;
    }
    strcpy(copy, text);
    char *dash = strchr(copy, '-');
    if (dash == NULL) {
        return 0;
    }
    *dash = '\0';
    return read_whole32(copy, low, high, first) && read_whole32(dash + 1, low, high, last) && *first <= *last;
}

int read_mutation(const char *text, uint32_t *chain, uint64_t *mutation)
{
    char copy[32];
    char *colon = strlen(text) < sizeof copy ? strchr(strcpy(copy, text), ':') : NULL;
    if (colon == NULL) {
        return 0;
    }
    *colon = '\0';
    return read_whole32(copy, 0, UINT32_MAX, chain) && read_whole(colon + 1, 0, UINT64_MAX, mutation);
}

int read_radius(const char *text, volgrad_shift_options *shift)
{
    double radius;
    if (read_positive(text, "px", &radius)) {
        shift->radius_unit = VOLGRAD_RADIUS_PIXELS;
    } else if (read_positive(text, "", &radius)) {
        shift->radius_unit = VOLGRAD_RADIUS_WORLD;
    } else {
        return 0;
    }
    shift->radius = (float)radius;
    return isfinite(shift->radius) && shift->radius > 0.0f;
}

int read_name(const char *text, const char *const *names, uint32_t count, uint32_t *out)
{
    for (uint32_t i = 0; i < count; ++i) {
        if (strcmp(text, names[i]) == 0) {
            *out = i;
            return 1;
        }
    }
    return 0;
}

int read_crop(const char *text, uint32_t crop[4])
{
    char copy[64];
    char *state = NULL;
    if (strlen(text) >= sizeof copy || strstr(text, ",,") != NULL || text[0] == ',') {
        return 0;
    }
    strcpy(copy, text);
    char *part = strtok_r(copy, ",", &state);
    for (int i = 0; i < 4; ++i, part = strtok_r(NULL, ",", &state)) {
        if (part == NULL || !read_whole32(part, 0, INT32_MAX, &crop[i])) {
            return 0;
        }
    }
    return part == NULL && text[strlen(text) - 1] != ',' && crop[0] < crop[2] && crop[1] < crop[3];
}
