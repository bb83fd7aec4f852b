/* Rays for Embree; private to render/. */
#ifndef LF_RENDER_RAY_H
#define LF_RENDER_RAY_H

#include "render/scene/embree.h"
#include "render/scene/limits.h"

/* Whether Embree takes a ray; it ends the program at one that it does not. What is asked of it goes
 * through this, so that a direction that rounding has made no number meets nothing. */
static inline bool lf_ray_is_sound(const struct RTCRay *ray)
{
    return fabsf(ray->org_x) + fabsf(ray->org_y) + fabsf(ray->org_z) + fabsf(ray->dir_x) +
                   fabsf(ray->dir_y) + fabsf(ray->dir_z) <
               LF_MAX_RAY &&
           ray->tnear >= 0.0f && !isnan(ray->tfar);
}

#endif
