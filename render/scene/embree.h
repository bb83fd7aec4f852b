/* Embree 4, or 3 where there is no other; private to render/. Both have the same names but for how
 * a ray is asked, which is here. */
#ifndef LF_RENDER_EMBREE_H
#define LF_RENDER_EMBREE_H

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

/* rtcIntersect1 of a ray that Embree takes (ray.h), also from within the function of a user
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

/* rtcOccluded1 in the same way: tfar < 0 where something is met. */
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
