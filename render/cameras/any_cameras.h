/* mvpt and vpt for cameras listed one by one (lf_camera.list), as the renderer drives them
 * (integrator.h); private to render/.
 *
 * These cameras are not rectified: a pivot lies in a different row in every view. Each worker adds
 * contributions to any row of the film, as integers (splat.h). Integer sums do not depend on the
 * order of addition, so they do not depend on the number of threads. They are added to the film
 * after the pass, together with B and q of one ray per view pixel. The weights are as for rows
 * (docs/developer/estimators/cameras.md, "Densities"), with the sample density of each view by its
 * own camera, occlusion by rays, and optical depths cell by cell (depth.h). A pass over some rows
 * shares paths among these rows only. */
#ifndef LF_RENDER_ANY_CAMERAS_H
#define LF_RENDER_ANY_CAMERAS_H

#include "render/integrator.h"

extern const lf_integrator lf_integrator_any_cameras;

#endif
