/* Guides for who frames a picture: what lies nearer or farther than a panel shows sharply (lf_depth
 * in render/render.h) is marked in the picture itself. */
#ifndef LF_DAEMON_GUIDES_H
#define LF_DAEMON_GUIDES_H

#include "render/render.h"

/* What lf_guides_mark reads, a channel each. */
#define LF_GUIDE_LAYERS (unsigned)(LF_LAYER_DEPTH | LF_LAYER_COVERAGE)

/* Lays red over pixels nearer than depth->sharp_from and blue over those farther than
 * depth->sharp_to, half of what is shown at most, as much as they are covered; what meets nothing
 * is left alone. layers: [n][2], LF_GUIDE_LAYERS; film: [n][3] radiance, shown with an exposure in
 * stops. */
void lf_guides_mark(const lf_depth *depth, double exposure, const float *layers, size_t n,
                    float *film);

#endif
