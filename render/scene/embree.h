/* Embree 4, or Embree 3 if 4 is not installed; private to render/. They have the same names except
 * for ray queries, which this header wraps. */
#ifndef LF_RENDER_EMBREE_H
#define LF_RENDER_EMBREE_H

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

/* rtcIntersect1 of a ray that Embree accepts (ray.h), also from within the callback of a user
 * geometry. */
static inline void lf_embree_intersect(RTCScene scene, struct RTCRayHit *rh)
{
#if RTC_VERSION_MAJOR >= 4
    rtcIntersect1(scene, rh, NULL);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, rh);
#endif
}

/* rtcOccluded1 in the same way: tfar < 0 if the ray is occluded. */
static inline void lf_embree_occluded(RTCScene scene, struct RTCRay *ray)
{
#if RTC_VERSION_MAJOR >= 4
    rtcOccluded1(scene, ray, NULL);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene, &context, ray);
#endif
}

#endif
