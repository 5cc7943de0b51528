#include "params.h"

#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SEPARATORS " ,\t\r\n"
#define DECIMAL "0123456789+-.eE"

/* Values end as 32-bit floats: the limits keep them finite, and positive ones positive. */
const param_range PARAM_ANY = {-FLT_MAX, FLT_MAX, "finite in single precision"};
const param_range PARAM_POSITIVE = {FLT_MIN, FLT_MAX, "greater than 0"};
const param_range PARAM_NOT_NEGATIVE = {0, FLT_MAX, "0 or greater"};
const param_range PARAM_UNIT = {0, 1, "between 0 and 1"};

const char *param_type(xml_node *object)
{
    object->used = 1;
    xml_value(object, "id");
    xml_value(object, "name");
    const char *type = xml_value(object, "type");
    if (!type) {
        xml_error(object, "<%s> has no type; write <%s type=\"...\">", object->name, object->name);
    }
    return type ? type : "";
}

xml_node *param_object(xml_node *object, const char *element)
{
    xml_node *found = NULL;
    for (xml_node *child = object->first_child; child; child = child->next) {
        if (strcmp(child->name, element) != 0) {
            continue;
        }
        if (found) {
            child->used = 1;
            xml_error(child, "a second <%s> in <%s>; there can be only one", element, object->name);
        } else {
            found = child;
        }
    }
    return found;
}

xml_node *param_find(xml_node *object, const char *name)
{
    for (xml_node *child = object->first_child; child; child = child->next) {
        const char *child_name = xml_peek(child, "name");
        if (child_name && strcmp(child_name, name) == 0) {
            return child;
        }
    }
    return NULL;
}

static int is_one_of(const char *word, const char *first, const char *second)
{
    return strcmp(word, first) == 0 || (second && strcmp(word, second) == 0);
}

/* `<tag name="name">` or `<other_tag ...>`, marked. *ok tells an absent one that may be absent (1) from an error (0). */
static xml_node *property(xml_node *object, const char *name, int required, const char *tag, const char *other_tag, int *ok)
{
    xml_node *node = param_find(object, name);
    *ok = node || !required;
    if (!node) {
        if (required) {
            xml_error(object, "<%s> lacks its %s; add <%s name=\"%s\" .../>", object->name, name, tag, name);
        }
        return NULL;
    }
    if (is_one_of(node->name, tag, other_tag)) {
        node->used = 1;
        xml_value(node, "name");
        return node;
    }
    *ok = 0;
    if (strcmp(node->name, "spectrum") == 0 && strcmp(tag, "rgb") == 0) {
        xml_error(node, "<spectrum name=\"%s\"> is not supported (and 1 does not mean white there); write <rgb name=\"%s\" .../>",
                  name, name);
    } else {
        xml_error(node, "%s is given as <%s>; write <%s name=\"%s\" .../>", name, node->name, tag, name);
    }
    return NULL;
}

static const char *property_value(xml_node *node)
{
    const char *value = xml_value(node, "value");
    if (!value) {
        xml_error(node, "<%s> lacks its value; write value=\"...\"", node->name);
    }
    return value;
}

int param_numbers(const char *text, double *out, int room)
{
    int count = 0;
    for (text += strspn(text, SEPARATORS); *text; text += strspn(text, SEPARATORS)) {
        size_t length = strcspn(text, SEPARATORS);
        char *end;
        if (count == room || strspn(text, DECIMAL) < length) {
            return -1;
        }
        double number = strtod(text, &end);
        if (end != text + length || !isfinite(number)) {
            return -1;
        }
        out[count++] = number;
        text = end;
    }
    return count;
}

static int in_range(const xml_node *node, const char *name, double value, param_range range)
{
    if (value >= range.low && value <= range.high) {
        return 1;
    }
    xml_error(node, "%s is %g; it must be %s", name, value, range.words);
    return 0;
}

double param_float(xml_node *object, const char *name, const double *fallback, param_range range)
{
    int ok;
    xml_node *node = property(object, name, !fallback, "float", "integer", &ok);
    double value, stand_in = fallback ? *fallback : 1;
    const char *text = node ? property_value(node) : NULL;
    if (!text) {
        return stand_in;
    }
    if (param_numbers(text, &value, 1) != 1) {
        return xml_error(node, "%s is \"%s\"; it must be one number", name, text), stand_in;
    }
    return in_range(node, name, value, range) ? value : stand_in;
}

long param_integer(xml_node *object, const char *name, const long *fallback, long low, long high)
{
    int ok;
    xml_node *node = property(object, name, !fallback, "integer", NULL, &ok);
    long stand_in = fallback ? *fallback : low;
    const char *text = node ? property_value(node) : NULL;
    if (!text) {
        return stand_in;
    }
    char *end;
    errno = 0;
    long value = strtol(text, &end, 10);
    if (end != text && *end == '\0' && errno == 0 && value >= low && value <= high) {
        return value;
    }
    xml_error(node, "%s is \"%s\"; it must be a whole number from %ld to %ld", name, text, low, high);
    return stand_in;
}

int param_boolean(xml_node *object, const char *name, int fallback)
{
    int ok;
    xml_node *node = property(object, name, 0, "boolean", NULL, &ok);
    const char *text = node ? property_value(node) : NULL;
    if (!text) {
        return fallback;
    }
    if (is_one_of(text, "true", "false")) {
        return strcmp(text, "true") == 0;
    }
    xml_error(node, "%s is \"%s\"; it must be true or false", name, text);
    return fallback;
}

static volgrad_rgb to_rgb(const double *values, int count)
{
    int rgb = count == 3;
    return (volgrad_rgb){(float)values[0], (float)values[rgb ? 1 : 0], (float)values[rgb ? 2 : 0]};
}

volgrad_rgb param_color(xml_node *object, const char *name, const volgrad_rgb *fallback, param_range range)
{
    int ok;
    double values[3];
    xml_node *node = property(object, name, !fallback, "rgb", "float", &ok);
    volgrad_rgb stand_in = fallback ? *fallback : (volgrad_rgb){0, 0, 0};
    const char *text = node ? property_value(node) : NULL;
    if (!text) {
        return stand_in;
    }
    int is_rgb = strcmp(node->name, "rgb") == 0, count = param_numbers(text, values, is_rgb ? 3 : 1);
    if (count != 1 && count != 3) {
        xml_error(node, "%s is \"%s\"; it must be %s", name, text,
                  is_rgb ? "three linear numbers, or one for grey" : "one number");
        return stand_in;
    }
    for (int i = 0; i < count; i++) {
        if (!in_range(node, name, values[i], range)) {
            return stand_in;
        }
    }
    return to_rgb(values, count);
}

const char *param_string(xml_node *object, const char *name, int required)
{
    int ok;
    xml_node *node = property(object, name, required, "string", NULL, &ok);
    return node ? property_value(node) : NULL;
}

void param_only_string(xml_node *object, const char *name, const char *value)
{
    const char *text = param_string(object, name, 0);
    if (text && strcmp(text, value) != 0) {
        xml_error(param_find(object, name), "%s is \"%s\"; only \"%s\" is supported", name, text, value);
    }
}

int param_vec3d(xml_node *object, const char *element, const char *name, int required, vec3d *out)
{
    int ok;
    xml_node *node = property(object, name, required, element, NULL, &ok);
    return node && param_axes(node, NULL, out);
}

/* From `value`: three numbers, or one for all axes. */
static int axes_from_list(xml_node *node, const char *text, vec3d *out)
{
    double v[3];
    int count = param_numbers(text, v, 3);
    if (count != 1 && count != 3) {
        return xml_error(node, "value is \"%s\"; it must be three numbers, or one for all axes", text);
    }
    *out = count == 3 ? (vec3d){v[0], v[1], v[2]} : (vec3d){v[0], v[0], v[0]};
    return 1;
}

static int axis(xml_node *node, const char *name, const double *fallback, double *out)
{
    const char *text = xml_value(node, name);
    if (text && param_numbers(text, out, 1) == 1) {
        return 1;
    }
    if (text) {
        return xml_error(node, "%s is \"%s\"; it must be one number", name, text);
    }
    if (!fallback) {
        return xml_error(node, "<%s> lacks its %s; write x=\"...\" y=\"...\" z=\"...\"", node->name, name);
    }
    *out = *fallback;
    return 1;
}

int param_axes(xml_node *node, const double *fallback, vec3d *out)
{
    const char *list = xml_value(node, "value");
    vec3d read;
    int ok = list
                 ? axes_from_list(node, list, &read)
                 : axis(node, "x", fallback, &read.x) && axis(node, "y", fallback, &read.y) && axis(node, "z", fallback, &read.z);
    if (ok) {
        *out = read;
    }
    return ok;
}
