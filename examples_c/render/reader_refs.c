/* Names that lead elsewhere: ids of other elements and names of files. */
#include <stdlib.h>
#include <string.h>

#include "reader.h"

static int has_id(const xml_node *node, const char *id)
{
    const char *own = strcmp(node->name, "ref") == 0 ? NULL : xml_peek(node, "id");
    return own && strcmp(own, id) == 0;
}

/* The first element of that id from `from` up to `end` (exclusive; NULL: the end of the file). */
static xml_node *find_id(xml_node *from, const xml_node *end, const char *id)
{
    for (xml_node *node = from; node && node != end; node = node->following) {
        if (has_id(node, id)) {
            return node;
        }
    }
    return NULL;
}

xml_node *reader_resolve(reader *r, xml_node *node)
{
    if (strcmp(node->name, "ref") != 0) {
        return node;
    }
    node->used = 1;
    xml_value(node, "name");
    const char *id = xml_value(node, "id");
    if (!id) {
        return xml_error(node, "<ref> has no id; write <ref id=\"...\"/>"), NULL;
    }
    xml_node *found = find_id(r->document->root, node, id), *later;
    if (found) {
        return found;
    }
    if ((later = find_id(node, NULL, id))) {
        xml_error(node, "\"%s\" is defined later, in line %lu; move it before its use", id, later->line);
    } else {
        xml_error(node, "nothing has the id \"%s\"", id);
    }
    return NULL;
}

void reader_check_ids(const xml_document *document)
{
    for (const xml_node *node = document->root; node; node = node->following) {
        const char *id = strcmp(node->name, "ref") == 0 ? NULL : xml_peek(node, "id");
        const xml_node *first = id ? find_id(document->root, node, id) : NULL;
        if (first) {
            xml_error(node, "the id \"%s\" is taken since line %lu; choose another", id, first->line);
        }
    }
}

char *reader_path(const xml_node *node, const char *filename)
{
    const char *scene_path = node->document->path, *slash = strrchr(scene_path, '/');
    size_t folder = slash && filename[0] != '/' ? (size_t)(slash - scene_path) + 1 : 0, name = strlen(filename) + 1;
    char *path = malloc(folder + name);
    if (!path) {
        return xml_out_of_memory(node), NULL;
    }
    memcpy(path, scene_path, folder);
    memcpy(path + folder, filename, name);
    return path;
}
