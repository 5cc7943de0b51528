/* An XML file as a small tree that remembers where everything stood and what has been read of it, so that errors carry
   `file:line:column` and nothing in a file is ignored silently. */
#ifndef RENDER_XML_H
#define RENDER_XML_H

#include <stddef.h>
#include <stdint.h>

typedef struct xml_document xml_document;

typedef struct {
    const char *name;
    const char *value;
    int used;
} xml_attribute;

typedef struct xml_node {
    xml_document *document;
    const char *name;
    unsigned long line; /* of its `<`; lines and columns count from 1 */
    unsigned long column;
    xml_attribute *attributes;
    size_t attribute_count;
    struct xml_node *parent;
    struct xml_node *first_child;
    struct xml_node *last_child;
    struct xml_node *next;      /* next child of the same parent */
    struct xml_node *following; /* next element of the whole file */
    int used;
    uint32_t object; /* for whoever reads the tree: index of what was made from this element */
} xml_node;

struct xml_document {
    const char *path; /* borrowed */
    xml_node *root;   /* also the head of the list of all elements in the file's order */
    xml_node *last;
    unsigned long errors; /* errors reported so far */
};

/* Reads the file into a tree. On an error prints it and returns 0; nothing needs to be freed then. `path` must outlive the tree.
 */
int xml_load(const char *path, xml_document *out);
void xml_free(xml_document *document);

/* The attribute's value, marked as used; NULL if there is none. */
const char *xml_value(xml_node *node, const char *attribute);

/* The same without marking it. */
const char *xml_peek(const xml_node *node, const char *attribute);

/* Prints `file:line:column: message` to stderr and counts it. Returns 0, what a caller that fails returns. */
#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
int xml_error(const xml_node *node, const char *format, ...);

/* The same for something that is worth knowing but no error. */
#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
void xml_warning(const xml_node *node, const char *format, ...);

int xml_out_of_memory(const xml_node *node);

/* Reports every element and attribute that nobody has used. */
void xml_report_unused(const xml_document *document);

#endif
