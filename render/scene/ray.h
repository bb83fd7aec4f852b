/* Rays for Embree; private to render/. */
#ifndef LF_RENDER_RAY_H
#define LF_RENDER_RAY_H

#include "render/scene/embree.h"
#include "render/scene/limits.h"

/* Whether Embree accepts a ray; it ends the program otherwise. All queries check this, so that a
 * direction that became NaN by rounding meets nothing. */
static inline bool lf_ray_is_sound(const struct RTCRay *ray)
{
    return fabsf(ray->org_x) + fabsf(ray->org_y) + fabsf(ray->org_z) + fabsf(ray->dir_x) +
                   fabsf(ray->dir_y) + fabsf(ray->dir_z) <
               LF_MAX_RAY &&
           ray->tnear >= 0.0f && !isnan(ray->tfar);
}

#endif
