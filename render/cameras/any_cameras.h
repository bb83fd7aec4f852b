/* mvpt and vpt of cameras that are listed one by one (lf_camera.list), as the renderer drives them
 * (integrator.h); private to render/.
 *
 * Nothing is rectified, so a pivot lies in another row of every view's film, and whatever a path
 * brings is added wherever it belongs by whoever found it: sums of whole numbers (splat.h), which
 * do not depend on the order and so not on the number of threads. They go into the film behind the
 * pass, with B and q of a ray a view pixel. Weights are those of rows
 * (docs/developer/estimators/cameras.md, "Densities"), with the density of each view's samples as
 * its own camera has it, what surfaces hide by rays and optical depths cell by cell (depth.h). A
 * pass over some rows shares among these. */
#ifndef LF_RENDER_ANY_CAMERAS_H
#define LF_RENDER_ANY_CAMERAS_H

#include "render/integrator.h"

extern const lf_integrator lf_integrator_any_cameras;

#endif
