/* Private to quilt/print: where eyes look on a print, and the pixels that they see there.
 *
 * With an exact map, the places change a little along the lenses. The print is then divided into
 * bands along them, on both sides of the middle, whose places are within a hundredth of a pixel.
 * Written by one thread, then read by any. */
#ifndef LF_QUILT_PRINT_LOOKED_H
#define LF_QUILT_PRINT_LOOKED_H

#include "quilt/print/blur.h"
#include "quilt/print/unmix.h"

/* Rows (columns) whose places are the same. */
typedef struct lf_looked_band {
    /* places 2 t: the border below stripe t; 2 t + 1: its middle. Stripes are numbered across the
     * lenses, from the first lens's. */
    lf_crosstalk matrix;
    lf_unmix unmix;
    lf_stripe_mix *mix; /* [n_pixels] */
} lf_looked_band;

typedef struct lf_looked {
    const lf_print *print;
    const lf_print_shape *shape;
    int n_stripes, n_pixels; /* across the lenses */
    int n_bands;
    lf_looked_band *bands;
    int *band_at;              /* [n_rows (columns)] */
    double own, own_worst;     /* lf_print_left */
    double least_px, apart_px; /* of a stripe; places of two bands, at most */
} lf_looked;

/* The weight of an eye between two views, next to that of an eye at a view. */
#define LF_LOOKED_BETWEEN 0.012

/* Straight lenses. References are borrowed. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_looked_init(lf_looked *k, const lf_print *print,
                                      const lf_print_shape *shape);
void lf_looked_finish(lf_looked *k);

static inline int lf_looked_stripe(const lf_looked *looked, int lens, int view)
{
    const int n = looked->print->n_views;
    return lens * n + (looked->print->reverse ? view : n - 1 - view);
}

static inline int lf_looked_lens(const lf_looked *looked, int stripe)
{
    return stripe / looked->print->n_views;
}

static inline int lf_looked_view(const lf_looked *looked, int stripe)
{
    const int n = looked->print->n_views, m = stripe % n;
    return looked->print->reverse ? m : n - 1 - m;
}

#endif
