/* <transform name="to_world">: rotate, scale, translate, lookat and matrix, composed in the order of the file. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "params.h"

/* Mitsuba does not normalise a rotation's axis: another length would also scale, hardly what is meant. */
#define AXIS_TOLERANCE 1e-4

static const double ZERO = 0, ONE = 1;

static int read_translate(xml_node *node, transform *out)
{
    vec3d offset;
    if (!param_axes(node, &ZERO, &offset)) {
        return 0;
    }
    *out = transform_translate(offset);
    return 1;
}

static int read_scale(xml_node *node, transform *out)
{
    vec3d factors;
    if (!param_axes(node, &ONE, &factors)) {
        return 0;
    }
    *out = transform_scale(factors);
    return 1;
}

static int read_rotate(xml_node *node, transform *out)
{
    vec3d axis;
    double degrees;
    const char *angle = xml_value(node, "angle");
    if (!param_axes(node, &ZERO, &axis)) {
        return 0;
    }
    if (!angle || param_numbers(angle, &degrees, 1) != 1) {
        return xml_error(node, "<rotate> needs angle=\"degrees\", one number");
    }
    double length = vec3d_length(axis);
    if (!(fabs(length - 1) <= AXIS_TOLERANCE)) {
        return xml_error(node, "the axis of <rotate> has length %g; write one of length 1, such as y=\"1\"", length);
    }
    *out = transform_rotate(vec3d_scaled(axis, 1 / length), degrees);
    return 1;
}

static int lookat_part(xml_node *node, const char *name, vec3d *out)
{
    double v[3];
    const char *text = xml_value(node, name);
    if (!text || param_numbers(text, v, 3) != 3) {
        return xml_error(node, "<lookat> needs %s=\"x, y, z\"", name);
    }
    *out = (vec3d){v[0], v[1], v[2]};
    return 1;
}

static int read_lookat(xml_node *node, transform *out)
{
    vec3d origin, target, up;
    int ok = lookat_part(node, "origin", &origin);
    ok &= lookat_part(node, "target", &target);
    ok &= lookat_part(node, "up", &up);
    if (ok && !transform_lookat(origin, target, up, out)) {
        return xml_error(node, "<lookat> is undefined; target must differ from origin, and up must not point along the view");
    }
    return ok;
}

/* 16 numbers row by row, or the 9 of a linear map. */
static int read_matrix(xml_node *node, transform *out)
{
    double v[16];
    const char *text = xml_value(node, "value");
    int count = text ? param_numbers(text, v, 16) : -1;
    if (count != 16 && count != 9) {
        return xml_error(node, "<matrix> needs value=\"...\" with 16 (or 9) numbers, row by row");
    }
    int size = count == 16 ? 4 : 3;
    *out = transform_identity();
    for (int i = 0; i < count; i++) {
        out->m[i / size][i % size] = v[i];
    }
    const double *last = out->m[3];
    if (last[0] != 0 || last[1] != 0 || last[2] != 0 || last[3] != 1) {
        return xml_error(node, "the last row of <matrix> must be 0 0 0 1 (an affine map)");
    }
    return 1;
}

static int read_operation(xml_node *node, transform *out)
{
    node->used = 1;
    if (strcmp(node->name, "translate") == 0) {
        return read_translate(node, out);
    }
    if (strcmp(node->name, "scale") == 0) {
        return read_scale(node, out);
    }
    if (strcmp(node->name, "rotate") == 0) {
        return read_rotate(node, out);
    }
    if (strcmp(node->name, "lookat") == 0) {
        return read_lookat(node, out);
    }
    if (strcmp(node->name, "matrix") == 0) {
        return read_matrix(node, out);
    }
    return xml_error(node, "<%s> is no transform; write rotate, scale, translate, lookat or matrix", node->name);
}

static int fits_single_precision(const transform *t)
{
    for (int i = 0; i < 12; i++) {
        if (!(fabs(t->m[i / 4][i % 4]) <= FLT_MAX)) {
            return 0;
        }
    }
    return 1;
}

transform param_transform(xml_node *object, const char *name)
{
    transform whole = transform_identity(), operation;
    xml_node *node = param_find(object, name);
    if (!node) {
        return whole;
    }
    node->used = 1;
    xml_value(node, "name");
    if (strcmp(node->name, "transform") != 0) {
        return xml_error(node, "%s is given as <%s>; write <transform name=\"%s\">", name, node->name, name), whole;
    }
    for (xml_node *child = node->first_child; child; child = child->next) {
        if (!read_operation(child, &operation)) {
            return transform_identity();
        }
        whole = transform_multiply(&operation, &whole);
    }
    if (fits_single_precision(&whole) && transform_is_invertible(&whole)) {
        return whole;
    }
    xml_error(node, "%s has no inverse (it flattens space or is too large); is one of its scale factors 0?", name);
    return transform_identity();
}
