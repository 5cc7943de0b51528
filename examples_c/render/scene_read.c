/* A Mitsuba 3 scene file from its root element on. */
#include <stdlib.h>
#include <string.h>

#include "reader.h"

static void check_root(xml_node *root)
{
    root->used = 1;
    if (strcmp(root->name, "scene") != 0) {
        xml_error(root, "the file's outermost element is <%s>; it must be <scene version=\"3.0.0\">", root->name);
        return;
    }
    const char *version = xml_value(root, "version");
    char *end = NULL;
    long major = version ? strtol(version, &end, 10) : 0;
    if (major != 3 || *end != '.') {
        xml_error(root, "version is \"%s\"; write version=\"3.0.0\", the format of Mitsuba 3", version ? version : "");
    }
}

/* Elements of which a scene has exactly one. */
static void check_single(xml_node *root, const char *element, const char *example)
{
    if (!param_object(root, element)) {
        xml_error(root, "the scene has no %s; add %s", element, example);
    }
}

static void read_element(reader *r, xml_node *node)
{
    if (strcmp(node->name, "bsdf") == 0) {
        reader_bsdf(r, node);
    } else if (strcmp(node->name, "medium") == 0) {
        reader_medium(r, node);
    } else if (strcmp(node->name, "shape") == 0) {
        reader_shape(r, node);
    } else if (strcmp(node->name, "emitter") == 0) {
        reader_emitter(r, node);
    } else if (strcmp(node->name, "sensor") == 0) {
        reader_sensor(r, node);
    } else if (strcmp(node->name, "integrator") == 0) {
        reader_integrator(r, node);
    }
}

/* Elements in the file's order, so that what a <ref> may name has been read before it. */
static void read_scene(reader *r)
{
    xml_node *root = r->document->root;
    check_root(root);
    if (r->document->errors) {
        return;
    }
    reader_check_ids(r->document);
    check_single(root, "integrator", "<integrator type=\"volpath\"/>");
    check_single(root, "sensor", "<sensor type=\"perspective\">");
    for (xml_node *node = root->first_child; node; node = node->next) {
        read_element(r, node);
    }
    xml_report_unused(r->document);
    if (r->document->errors == 0 && r->scene->desc.light_count == 0) {
        xml_error(root, "nothing in this scene emits light; add an <emitter>");
    }
}

int scene_load(const char *path, scene *out)
{
    xml_document document;
    if (!xml_load(path, &document)) {
        return 0;
    }
    *out = (scene){.desc = {.struct_size = sizeof out->desc}};
    reader r = {&document, out, VOLGRAD_NONE, VOLGRAD_NONE};
    read_scene(&r);
    int ok = document.errors == 0;
    if (ok) {
        reader_bounds(out);
    } else {
        scene_free(out);
    }
    xml_free(&document);
    return ok;
}
