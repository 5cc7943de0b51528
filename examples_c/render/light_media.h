/* The medium in which each light begins. */
#ifndef RENDER_LIGHT_MEDIA_H
#define RENDER_LIGHT_MEDIA_H

#include "embree_queries.h"

/* Sets `medium` of the scene's lights: `queries` are those of this scene. */
void light_media_find(scene *s, const embree_queries *queries);

#endif
