/* Shapes: geometry, and what is attached to it. */
#include <string.h>

#include "reader.h"

/* What the children of a shape say, beside its geometry. */
typedef struct {
    int has_bsdf;
    uint32_t material; /* VOLGRAD_NONE: a null bsdf */
    int has_interior, has_exterior;
    uint32_t interior, exterior;
    int emits;
    area_emission emission;
} attachments;

static void attach_bsdf(reader *r, xml_node *child, xml_node *bsdf, attachments *to)
{
    if (bsdf == child) {
        reader_bsdf(r, child);
    }
    if (to->has_bsdf) {
        xml_error(child, "a second bsdf in this shape; there can be only one");
    }
    to->has_bsdf = 1;
    to->material = bsdf->object;
}

/* `name` of the child, not of the definition, says on which side the medium is. */
static void attach_medium(reader *r, xml_node *child, xml_node *medium, attachments *to)
{
    const char *side = xml_peek(child, "name");
    int is_interior = side && strcmp(side, "interior") == 0;
    if (medium == child) {
        reader_medium(r, child);
    }
    if (!is_interior && !(side && strcmp(side, "exterior") == 0)) {
        xml_error(child, "a medium in a shape must say which side it is on; write name=\"interior\" or name=\"exterior\"");
        return;
    }
    if (is_interior ? to->has_interior : to->has_exterior) {
        xml_error(child, "a second %s medium in this shape; there can be only one", side);
    }
    *(is_interior ? &to->has_interior : &to->has_exterior) = 1;
    *(is_interior ? &to->interior : &to->exterior) = medium->object;
}

static void attach_emitter(xml_node *child, attachments *to)
{
    area_emission emission = reader_area_emitter(child);
    if (to->emits) {
        xml_error(child, "a second emitter in this shape; there can be only one");
    }
    to->emits = 1;
    to->emission = emission;
}

static void attach(reader *r, xml_node *child, attachments *to)
{
    xml_node *definition = reader_resolve(r, child);
    if (!definition) {
        return;
    }
    if (strcmp(definition->name, "bsdf") == 0) {
        attach_bsdf(r, child, definition, to);
    } else if (strcmp(definition->name, "medium") == 0) {
        attach_medium(r, child, definition, to);
    } else if (strcmp(child->name, "emitter") == 0) {
        attach_emitter(child, to);
    } else if (definition != child) {
        xml_error(child, "a <ref> in a shape may name a bsdf or a medium; this one is a <%s>", definition->name);
    }
}

static void set_material(reader *r, const xml_node *node, const attachments *from, shape *s)
{
    s->is_null = from->has_bsdf && from->material == VOLGRAD_NONE;
    if (s->is_null && from->emits) {
        xml_error(node, "a shape with a null bsdf cannot emit; leave the bsdf away for a black one");
    }
    s->material = from->has_bsdf ? from->material : reader_default_bsdf(r, node, from->emits);
}

static void set_media(const xml_node *node, const attachments *from, int mirrored, shape *s)
{
    int bounds = from->has_interior || from->has_exterior;
    uint32_t missing = bounds ? VOLGRAD_NONE : VOLGRAD_KEEP_MEDIUM;
    s->medium_inside = from->has_interior ? from->interior : missing;
    s->medium_outside = from->has_exterior ? from->exterior : missing;
    /* Mitsuba 3.9 keeps the shading normal of a mirrored rectangle or cube but turns the geometric one, which swaps the two
     * media. */
    if (bounds && mirrored) {
        xml_error(node, "to_world mirrors this shape, and Mitsuba then confuses its interior with its exterior; write it without "
                        "a mirroring scale");
    }
}

void reader_shape(reader *r, xml_node *node)
{
    shape s = {.first_light = VOLGRAD_NONE};
    attachments attached = {0};
    int mirrored;
    const char *type = param_type(node);
    for (xml_node *child = node->first_child; child; child = child->next) {
        attach(r, child, &attached);
    }
    reader_geometry(node, type, &s, &mirrored);
    set_material(r, node, &attached, &s);
    set_media(node, &attached, mirrored, &s);
    if (attached.emits && r->document->errors == 0) {
        reader_shape_lights(r, node, &s, attached.emission);
    }
    node->object = reader_add_shape(r, node, &s);
}
