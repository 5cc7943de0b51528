#include "xml.h"

#include <expat.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define READ_BYTES 65536

typedef struct {
    xml_document *document;
    XML_Parser expat;
    xml_node *open; /* innermost element that is not closed yet */
} parser;

static int report_at(const char *path, unsigned long line, unsigned long column, const char *message)
{
    fprintf(stderr, "%s:%lu:%lu: %s\n", path, line, column, message);
    return 0;
}

static int report_here(const parser *p, const char *message)
{
    p->document->errors++;
    return report_at(p->document->path, XML_GetCurrentLineNumber(p->expat), XML_GetCurrentColumnNumber(p->expat) + 1, message);
}

static const char *copy_text(char **room, const char *text)
{
    size_t bytes = strlen(text) + 1;
    char *copy = memcpy(*room, text, bytes);
    *room += bytes;
    return copy;
}

/* One allocation holds the element, its attributes and all their text. */
static xml_node *make_node(const char *name, const char **pairs)
{
    size_t count = 0, text = strlen(name) + 1;
    for (; pairs[2 * count]; count++) {
        text += strlen(pairs[2 * count]) + strlen(pairs[2 * count + 1]) + 2;
    }
    xml_node *node = calloc(1, sizeof *node + count * sizeof(xml_attribute) + text);
    if (!node) {
        return NULL;
    }
    node->attributes = (xml_attribute *)(node + 1);
    node->attribute_count = count;
    char *room = (char *)(node->attributes + count);
    node->name = copy_text(&room, name);
    for (size_t i = 0; i < count; i++) {
        node->attributes[i].name = copy_text(&room, pairs[2 * i]);
        node->attributes[i].value = copy_text(&room, pairs[2 * i + 1]);
    }
    return node;
}

static void link_node(parser *p, xml_node *node)
{
    xml_document *document = p->document;
    if (document->last) {
        document->last->following = node;
    } else {
        document->root = node;
    }
    document->last = node;
    xml_node *parent = node->parent = p->open;
    if (!parent) {
        return;
    }
    if (parent->last_child) {
        parent->last_child->next = node;
    } else {
        parent->first_child = node;
    }
    parent->last_child = node;
}

static void XMLCALL on_start(void *user, const XML_Char *name, const XML_Char **pairs)
{
    parser *p = user;
    xml_node *node = make_node(name, pairs);
    if (!node) {
        report_here(p, "out of memory");
        XML_StopParser(p->expat, XML_FALSE);
        return;
    }
    node->document = p->document;
    node->line = XML_GetCurrentLineNumber(p->expat);
    node->column = XML_GetCurrentColumnNumber(p->expat) + 1;
    link_node(p, node);
    p->open = node;
}

static void XMLCALL on_end(void *user, const XML_Char *name)
{
    parser *p = user;
    (void)name;
    p->open = p->open->parent;
}

static void XMLCALL on_text(void *user, const XML_Char *text, int length)
{
    parser *p = user;
    for (int i = 0; i < length; i++) {
        if (strchr(" \t\r\n", text[i]) && text[i]) {
            continue;
        }
        report_here(p, "text between elements; values belong into attributes, remarks into <!-- -->");
        XML_StopParser(p->expat, XML_FALSE);
        return;
    }
}

/* Feeds the file to expat; 0 on an error, which has been reported. */
static int parse_file(parser *p, FILE *file)
{
    for (;;) {
        void *buffer = XML_GetBuffer(p->expat, READ_BYTES);
        if (!buffer) {
            return report_here(p, "out of memory");
        }
        size_t bytes = fread(buffer, 1, READ_BYTES, file);
        if (ferror(file)) {
            return report_here(p, "the file cannot be read any further");
        }
        if (XML_ParseBuffer(p->expat, (int)bytes, bytes == 0) != XML_STATUS_OK) {
            if (!p->document->errors) {
                report_here(p, XML_ErrorString(XML_GetErrorCode(p->expat)));
            }
            return 0;
        }
        if (bytes == 0) {
            return 1;
        }
    }
}

static int parse_open_file(xml_document *out, FILE *file)
{
    parser p = {out, XML_ParserCreate(NULL), NULL};
    if (!p.expat) {
        return report_at(out->path, 1, 1, "out of memory");
    }
    XML_SetUserData(p.expat, &p);
    XML_SetElementHandler(p.expat, on_start, on_end);
    XML_SetCharacterDataHandler(p.expat, on_text);
    int ok = parse_file(&p, file);
    XML_ParserFree(p.expat);
    return ok;
}

int xml_load(const char *path, xml_document *out)
{
    *out = (xml_document){.path = path};
    FILE *file = fopen(path, "rb");
    if (!file) {
        return report_at(path, 1, 1, "cannot open this file; is the path right?");
    }
    int ok = parse_open_file(out, file);
    fclose(file);
    if (!ok) {
        xml_free(out);
    }
    return ok;
}

void xml_free(xml_document *document)
{
    for (xml_node *node = document->root, *following; node; node = following) {
        following = node->following;
        free(node);
    }
    document->root = document->last = NULL;
}

static xml_attribute *find_attribute(const xml_node *node, const char *name)
{
    for (size_t i = 0; i < node->attribute_count; i++) {
        if (strcmp(node->attributes[i].name, name) == 0) {
            return &node->attributes[i];
        }
    }
    return NULL;
}

const char *xml_value(xml_node *node, const char *attribute)
{
    xml_attribute *found = find_attribute(node, attribute);
    if (!found) {
        return NULL;
    }
    found->used = 1;
    return found->value;
}

const char *xml_peek(const xml_node *node, const char *attribute)
{
    const xml_attribute *found = find_attribute(node, attribute);
    return found ? found->value : NULL;
}

static void report_formatted(const xml_node *node, const char *prefix, const char *format, va_list arguments)
{
    fprintf(stderr, "%s:%lu:%lu: %s", node->document->path, node->line, node->column, prefix);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
}

int xml_error(const xml_node *node, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    report_formatted(node, "", format, arguments);
    va_end(arguments);
    node->document->errors++;
    return 0;
}

void xml_warning(const xml_node *node, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    report_formatted(node, "warning: ", format, arguments);
    va_end(arguments);
}

int xml_out_of_memory(const xml_node *node)
{
    return xml_error(node, "out of memory while reading <%s>", node->name);
}

/* Whether an earlier child of the same parent has the same element name and the same `name` attribute. */
static int is_repeated(const xml_node *node)
{
    const char *name = xml_peek(node, "name");
    if (!name || !node->parent) {
        return 0;
    }
    for (const xml_node *other = node->parent->first_child; other != node; other = other->next) {
        const char *other_name = xml_peek(other, "name");
        if (strcmp(other->name, node->name) == 0 && other_name && strcmp(other_name, name) == 0) {
            return 1;
        }
    }
    return 0;
}

static void report_unused_node(const xml_node *node)
{
    const char *name = xml_peek(node, "name");
    const char *parent = node->parent ? node->parent->name : "the file";
    if (is_repeated(node)) {
        xml_error(node, "<%s name=\"%s\"> is given twice in <%s>; write it once", node->name, name, parent);
    } else if (name) {
        xml_error(node, "<%s name=\"%s\"> is not supported in this <%s>; scenes/README.md lists what is", node->name, name,
                  parent);
    } else {
        xml_error(node, "<%s> is not supported in this <%s>; scenes/README.md lists what is", node->name, parent);
    }
}

void xml_report_unused(const xml_document *document)
{
    for (const xml_node *node = document->root; node; node = node->following) {
        if (!node->used) {
            if (!node->parent || node->parent->used) {
                report_unused_node(node);
            }
            continue;
        }
        for (size_t i = 0; i < node->attribute_count; i++) {
            if (!node->attributes[i].used) {
                xml_error(node, "attribute %s=\"%s\" is not supported in <%s>; scenes/README.md lists what is",
                          node->attributes[i].name, node->attributes[i].value, node->name);
            }
        }
    }
}
