/* One spelling for Embree 3 and Embree 4. They differ in the name of the object that travels with a ray (context), in how it is
   set up, and in the arguments of the two query calls; buffers, filter functions and user geometry are the same. */
#ifndef RENDER_EMBREE_SHIM_H
#define RENDER_EMBREE_SHIM_H

#if defined(__has_include)
#if __has_include(<embree4/rtcore.h>)
#define RENDER_EMBREE_MAJOR 4
#endif
#endif

#ifdef RENDER_EMBREE_MAJOR

#include <embree4/rtcore.h>

/* Travels with a ray; a user's struct that starts with it can be recovered in callbacks. */
typedef struct RTCRayQueryContext embree_context;

static inline void embree_intersect(RTCScene scene, embree_context *context, struct RTCRayHit *rayhit)
{
    struct RTCIntersectArguments arguments;
    rtcInitRayQueryContext(context);
    rtcInitIntersectArguments(&arguments);
    arguments.context = context;
    rtcIntersect1(scene, rayhit, &arguments);
}

static inline void embree_occluded(RTCScene scene, embree_context *context, struct RTCRay *ray)
{
    struct RTCOccludedArguments arguments;
    rtcInitRayQueryContext(context);
    rtcInitOccludedArguments(&arguments);
    arguments.context = context;
    rtcOccluded1(scene, ray, &arguments);
}

#else

#define RENDER_EMBREE_MAJOR 3

#include <embree3/rtcore.h>

/* Travels with a ray; a user's struct that starts with it can be recovered in callbacks. */
typedef struct RTCIntersectContext embree_context;

static inline void embree_intersect(RTCScene scene, embree_context *context, struct RTCRayHit *rayhit)
{
    rtcInitIntersectContext(context);
    rtcIntersect1(scene, context, rayhit);
}

static inline void embree_occluded(RTCScene scene, embree_context *context, struct RTCRay *ray)
{
    rtcInitIntersectContext(context);
    rtcOccluded1(scene, context, ray);
}

#endif

#endif
