/* One ray on its way through Embree's tree: what happens at each surface that it meets. */
#ifndef RENDER_TRAVERSAL_H
#define RENDER_TRAVERSAL_H

#include "crossings.h"
#include "embree_shim.h"
#include "scene.h"
#include "triangle.h"
#include "vec3d.h"

/* Where a ray meets a shape, in double precision from the shape as it was read. */
typedef struct {
    double t;
    vec3d normal; /* not of unit length */
    int leaves;   /* the ray goes to the side that the normal points to */
} surface_point;

/* The context comes first: Embree's callbacks get a pointer to it. Geometry i of the tree is shape i of the scene. */
typedef struct {
    embree_context context;
    const scene *scene;
    vec3d origin;
    vec3d direction;
    shear shear; /* of the two */
    double t_min;
    double t_max;
    int passes_all; /* opaque surfaces too are crossed, not hit */
    /* The nearest opaque point so far, that of primitive `primitive` of shape `shape`; none yet if VOLGRAD_NONE. */
    uint32_t shape, primitive;
    surface_point point;
    crossing_list crossings; /* null surfaces met so far, or all that bound media */
} traversal;

/* Filter of both query kinds for opaque meshes, which are Embree's triangles. The geometry's user pointer is the shape. */
void traversal_filter(const struct RTCFilterFunctionNArguments *args);

/* Callbacks for spheres and for null meshes, which are user geometry (sphere.h and triangle.h say why): null surfaces are noted in
   `crossings` and let the ray pass. The geometry's user pointer is the shape. */
void traversal_bounds(const struct RTCBoundsFunctionArguments *args);
void traversal_intersect(const struct RTCIntersectFunctionNArguments *args);
void traversal_occluded(const struct RTCOccludedFunctionNArguments *args);

#endif
