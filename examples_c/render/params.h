/* Typed values of a scene element: `<float name="fov" value="36"/>` and its relatives, checked and marked as used.
   A wrong or missing value is reported and counted (xml.h), and the call returns a usable stand-in, so that reading can go on. */
#ifndef RENDER_PARAMS_H
#define RENDER_PARAMS_H

#include "transform.h"
#include "volgrad.h"
#include "xml.h"

#define PARAM_REQUIRED NULL

/* Closed range of what a number may be, and how to say it. */
typedef struct {
    double low, high;
    const char *words;
} param_range;

extern const param_range PARAM_ANY;
extern const param_range PARAM_POSITIVE;
extern const param_range PARAM_NOT_NEGATIVE;
extern const param_range PARAM_UNIT; /* [0, 1] */

/* Marks the element as used and returns its `type`; "" if it has none. `id` and `name` of an element with a type are names only.
 */
const char *param_type(xml_node *object);

/* The only child element of this kind, or NULL. */
xml_node *param_object(xml_node *object, const char *element);

/* `<element name="...">`, not marked; NULL if there is none. */
xml_node *param_find(xml_node *object, const char *name);

/* Numbers of a list separated by commas or spaces. Returns how many there are, or -1 if there is more than `room` or anything
 * else. */
int param_numbers(const char *text, double *out, int room);

/* `fallback` is the value of an absent element; PARAM_REQUIRED makes that an error. */
double param_float(xml_node *object, const char *name, const double *fallback, param_range range);
long param_integer(xml_node *object, const char *name, const long *fallback, long low, long high);
int param_boolean(xml_node *object, const char *name, int fallback);
volgrad_rgb param_color(xml_node *object, const char *name, const volgrad_rgb *fallback, param_range range);

/* NULL if it is absent (an error if required) or wrong. */
const char *param_string(xml_node *object, const char *name, int required);

/* Reports every value of the string but this one; an absent string is fine. */
void param_only_string(xml_node *object, const char *name, const char *value);

/* `<point>` or `<vector>`: `element` says which. Returns 0 if it is absent (an error if required) or wrong. */
int param_vec3d(xml_node *object, const char *element, const char *name, int required, vec3d *out);

/* The three attributes x, y, z, or `value` with three numbers or one for all. Absent axes get `fallback`; NULL: they are
 * required. */
int param_axes(xml_node *node, const double *fallback, vec3d *out);

/* Operations in the order of the file, the first acts first; the identity if absent. Always invertible. */
transform param_transform(xml_node *object, const char *name);

#endif
