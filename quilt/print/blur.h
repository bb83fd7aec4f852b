/* Private to quilt/print: how an eye sees a print blurred, from lf_print_blur
 * (docs/developer/print-compensation.md). Pure functions. */
#ifndef LF_QUILT_PRINT_BLUR_H
#define LF_QUILT_PRINT_BLUR_H

#include "quilt/print/crosstalk.h"
#include "quilt/print/print.h"

/* A spot, or a sum of spots that lie extra_px apart. Pixels of the raster, across the lenses. */
typedef struct lf_blur {
    lf_print_spot spot;
    double beside_px; /* of the spot, to the right (down) of where an eye should look */
    int n_extra;      /* 0: one spot */
    double extra_px;
    double extra[2 * LF_PRINT_CROSSTALK + 1]; /* weights, from left to right; sum 1 */
} lf_blur;

/* kernel[reach + k], k = -reach..reach: the part of an eye's light, in the middle of a stripe, that
 * comes from the stripe k to its right; stripes are stripe_px wide. The mean over all places of
 * stripes on the raster, whose pixels mix stripes by area. Exact. */
void lf_blur_kernel(const lf_print_spot *spot, double beside_px, double stripe_px, int reach,
                    double *kernel);
/* The blur of a print, before it is fitted: its spot and the distance of the others. */
lf_blur lf_blur_known(const lf_print *print);
/* Dots that an eye sees at most. */
double lf_blur_width(const lf_blur *blur);
/* The blur of a print. A measured crosstalk gives place and width of the spot, and what is left
 * gives the weights; the chart is taken to have the print's raster. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_blur_of_print(const lf_print *print, lf_blur *out);

/* {"views", "shares"}, for the manifest; NULL without a measured crosstalk or memory. */
json_t *lf_blur_crosstalk_json(const lf_print_blur *blur);

#endif
