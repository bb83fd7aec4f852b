/* Sums of a film over the cells of all levels; private to render/reconstruct. */
#ifndef LF_RENDER_RECONSTRUCT_MOMENTS_H
#define LF_RENDER_RECONSTRUCT_MOMENTS_H

#include "render/reconstruct/scratch.h"

/* N, W and W' of a pixel, of a half or of both. */
typedef struct lf_pixel_found {
    float n[3], w, w2;
} lf_pixel_found;

static inline void lf_pixel_found_add(lf_pixel_found *found, const lf_film_half *half, size_t pixel)
{
    const lf_film_scattered *s = &half->scattered[pixel];
    for (int c = 0; c < 3; c++)
        found->n[c] += s->n[c];
    found->w += s->w;
    found->w2 += half->w2 ? half->w2[pixel] : s->w;
}

static inline void lf_pixel_found_join(lf_pixel_found *to, const lf_pixel_found *from)
{
    for (int c = 0; c < 3; c++)
        to->n[c] += from->n[c];
    to->w += from->w;
    to->w2 += from->w2;
}

/* The halves of a row, for one pixel. A row with visits of only one half counts as one half by its
 * position, alternating with the next row (or, if one row of each cell was visited, with the next
 * cell). Its features represent both halves. */
typedef struct lf_row_halves {
    lf_film_half half[2]; /* zeros: no samples */
    float n[2];
    const float (*albedo)[3]; /* of its pixels, divisor of N; NULL: none */
} lf_row_halves;

/* For an open row. albedo: borrowed, as lf_pixels_read found it. */
lf_row_halves lf_row_halves_of(const lf_film *film, int row, const float (*albedo)[3]);

/* The halves of one pixel, as used by the fit. */
typedef struct lf_fitted {
    lf_pixel_found found[2]; /* N is divided by the albedo */
    float w[2];              /* W or W': as a summand, even if it is not a valid divisor */
    float over[2];           /* divisor of N, 0: not valid */
    float answer[2][3];      /* N/W, if valid */
} lf_fitted;

/* For pixel i; with W' if `second` (the less noisy weight). */
void lf_fitted_read(const lf_film *film, const lf_row_halves *halves, bool second, size_t i,
                    lf_fitted *out);

/* Makes all cells and sums of a band of level 0. One worker per band. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_moments_gather(lf_reconstruction *r, const lf_film *film, int number,
                                         lf_reconstruct_scratch *scratch);
/* Makes a band of a higher level from the level below. */
LF_NODISCARD lf_status lf_moments_coarsen(lf_reconstruction *r, int level, int number);

/* The share of n q that W must reach if weights may cancel. */
static inline float lf_least_share(const lf_film *film)
{
    return film->layout.has_signed ? 0.25f : 0.0f;
}

/* The divisor of N if it is valid: W, or W' if `second` (the less noisy weight); 0 if it is not
 * valid. If weights may cancel, it must reach a share of its expectation nq. */
static inline float lf_pixel_found_weight(const lf_film *film, const lf_pixel_found *found,
                                          bool second, float nq)
{
    float w = lf_film_weight(found->w, found->w2, second);
    return w > lf_least_share(film) * nq ? w : 0.0f;
}

#endif
