/* What an image says about its own making: the attributes of the EXR file. */
#ifndef RENDER_METADATA_H
#define RENDER_METADATA_H

#include "image.h"

enum { METADATA_CAPACITY = 48 };

typedef struct {
    volgrad_exr_attribute attributes[METADATA_CAPACITY];
    uint32_t count;
    char seed[24]; /* as text: a double does not hold every 64-bit number */
} metadata;

/* The attributes borrow from the source and from `m`. */
void metadata_collect(metadata *m, const image_source *source);

/* The command line as one would type it, quoted for a shell. Before getopt, which reorders argv. Free it. NULL: out of memory. */
char *metadata_command_line(int argc, char **argv);

#endif
