/* Guides for framing: tint objects nearer or farther than a panel shows sharply (lf_depth in
 * render/render.h). */
#ifndef LF_DAEMON_GUIDES_H
#define LF_DAEMON_GUIDES_H

#include "render/render.h"

/* The layers that lf_guides_mark reads, one channel each. */
#define LF_GUIDE_LAYERS (unsigned)(LF_LAYER_DEPTH | LF_LAYER_COVERAGE)

/* Tints pixels nearer than depth->sharp_from red and pixels farther than depth->sharp_to blue. The
 * tint is half of the shown colour times the coverage. Pixels that meet no object keep their
 * colour. layers: [n][2], LF_GUIDE_LAYERS; film: [n][3] radiance; exposure in stops. */
void lf_guides_mark(const lf_depth *depth, double exposure, const float *layers, size_t n,
                    float *film);

#endif
