/* One row of a film as a reconstruction reads it; private to render/reconstruct. */
#ifndef LF_RENDER_RECONSTRUCT_PIXELS_H
#define LF_RENDER_RECONSTRUCT_PIXELS_H

#include "render/reconstruct/lattice.h"

/* Features of one half, or of both, of one pixel: absolute coordinates. */
typedef struct lf_pixel_features {
    float f[LF_FEATURES];
} lf_pixel_features;

/* Arrays [view][column] of one row. */
typedef struct lf_pixels {
    lf_pixel_features *feature[LF_VARIANTS];
    int *u, *z; /* of the cell of level 0 */
    float *q;   /* of both halves; 0: nothing scatters, all else is then undefined */
} lf_pixels;

/* LF_E_NOMEM. */
LF_NODISCARD lf_status lf_pixels_create(size_t n, lf_pixels **out);
/* Accepts NULL. */
void lf_pixels_destroy(lf_pixels *pixels);

/* halves: also the features of each alone. false: the row was never visited. */
bool lf_pixels_read(lf_pixels *pixels, const lf_reconstruction *r, const lf_film *film, int row,
                    bool halves);

#endif
