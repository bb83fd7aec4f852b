/* The optical depth of a scene's media along a ray, exactly; private to render/. Regular tracking
 * of every grid: what is interpolated linearly is a cubic along a ray within a cell, which two
 * points of Gauss' rule integrate exactly. Slow, and without noise: restir's final shading. */
#ifndef LF_RENDER_MEDIA_DEPTH_H
#define LF_RENDER_MEDIA_DEPTH_H

#include "render/scene/scene.h"

/* Along o + t w, 0 <= t <= end, which may be infinite; w unit. Adds its look-ups to *lookups. The
 * scene's volumes stand still. */
double lf_media_depth(const lf_scene *scene, lf_vec3 o, lf_vec3 w, double end, int64_t *lookups);

#endif
