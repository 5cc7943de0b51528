/* volgrad's ray queries answered by Embree. Each is one traversal: opaque surfaces stop the ray, null (index-matched) surfaces are
   noted on the way and turned into the media that the ray passes. */
#ifndef RENDER_EMBREE_QUERIES_H
#define RENDER_EMBREE_QUERIES_H

#include "scene.h"
#include "volgrad.h"

typedef struct embree_queries embree_queries;

/* Builds the tree on `threads` threads (0: Embree decides). Borrows the scene's shapes. Returns NULL on failure, and then `problem`
   is a static text that says why. */
embree_queries *embree_queries_create(const scene *scene, unsigned threads, const char **problem);

void embree_queries_destroy(embree_queries *queries);

/* The callbacks for volgrad. Any number of threads may use them; valid until the queries are destroyed. */
volgrad_queries embree_queries_table(embree_queries *queries);

/* The medium at a point, which lies on no surface. */
uint32_t embree_queries_medium_at(const embree_queries *queries, volgrad_vec3 point);

/* The version of the Embree that this was built with, as in "3.13.5". Writes at most `size` characters. */
void embree_queries_version(char *text, size_t size);

#endif
