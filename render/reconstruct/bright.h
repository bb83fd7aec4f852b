/* Highlights that no feature describes, excluded from the fit; private to render/reconstruct.
 * docs/developer/reconstruction-extensions.md, "Highlights", has the formulas.
 *
 * Every cell of level 1 has a bound, a few times a mean of N/W that is itself bounded in the same
 * way. The excess over the bound is compared between the halves, pixel by pixel. If the halves
 * agree on the pixels, a second reconstruction is fitted to the values below the bound, and the
 * excess is added where it was found. */
#ifndef LF_RENDER_RECONSTRUCT_BRIGHT_H
#define LF_RENDER_RECONSTRUCT_BRIGHT_H

#include "render/reconstruct/moments.h"

typedef struct lf_bright_cell lf_bright_cell;

/* The cells of a band of level 1, in their order. */
typedef struct lf_bright {
    lf_bright_cell *cells;
    int n, size; /* cells; allocated */
} lf_bright;

void lf_bright_finish(lf_bright *bright);

/* Passes over bands, one worker each; every pass ends before the next begins. LF_E_NOMEM for passes
 * that read the film.
 *
 * 1. The brightness of pixels. */
LF_NODISCARD lf_status lf_bright_tell(lf_reconstruction *r, const lf_film *film, int number);
/* 2. The bound, from the neighbouring cells. */
void lf_bright_settle_bound(lf_reconstruction *r, int number);
/* 3. The excess in both halves. */
LF_NODISCARD lf_status lf_bright_compare(lf_reconstruction *r, const lf_film *film, int number);
/* 4. The share of the bounded fit, from the neighbouring cells. */
void lf_bright_settle(lf_reconstruction *r, int number);

/* Whether any share is above 0. */
bool lf_bright_anywhere(const lf_reconstruction *r);

/* Removes the excess over the bound of pixel i, which is fitted, from each half. */
void lf_bright_bound(const lf_reconstruction *r, const lf_pixels *pixels, int row, size_t i,
                     lf_fitted *x);

/* A pixel of the bounded fit: what each half has received below the bound, and the excess as far as
 * it is shown, multiplied by the albedo again. The share is for the bounded fit; if it is 0 the
 * other fields are undefined. */
typedef struct lf_bright_pixel {
    float share, below[2][3], above[2][3];
} lf_bright_pixel;

void lf_bright_split(const lf_reconstruction *r, const lf_pixels *pixels, int row, size_t i,
                     const lf_fitted *x, lf_bright_pixel *out);

/* Blends towards the bounded fit. n, above: received below the bound, and the excess, over w. */
static inline void lf_bright_mix(float share, const float n[3], const float above[3], float w,
                                 const float predicted[4], float out[3])
{
    float bounded[3];
    lf_pixel_show(n, w, predicted, bounded);
    for (int c = 0; c < 3; c++)
        out[c] += share * (bounded[c] + (w > 0.0f ? above[c] / w : 0.0f) - out[c]);
}

#endif
