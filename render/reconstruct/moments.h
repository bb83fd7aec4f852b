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

/* What a row's halves hold of one pixel. A row that one half alone has visited counts as a half by
 * its place, one row with the next and, where one row of each cell was visited, one cell with the
 * next: its features stand for both. */
typedef struct lf_row_halves {
    lf_film_half half[2]; /* zeros: nothing */
    float n[2];
    const float (*albedo)[3]; /* of its pixels, which N is divided by; NULL: nothing */
} lf_row_halves;

/* albedo: borrowed, as lf_pixels_read found it. */
lf_row_halves lf_row_halves_of(const lf_film *film, int row, const float (*albedo)[3]);

/* One pixel's halves, as they are fitted to. */
typedef struct lf_fitted {
    lf_pixel_found found[2]; /* N over the albedo */
    float w[2];              /* W or W': as a summand even where it is nothing to divide by */
    float over[2];           /* what N is divided by, 0: that is no answer */
    float answer[2][3];      /* N/W, where there is one */
} lf_fitted;

/* Of pixel i, by W' where that is the second and less noisy weight. */
void lf_fitted_read(const lf_film *film, const lf_row_halves *halves, bool second, size_t i,
                    lf_fitted *out);

/* All cells and sums of a band of level 0. One worker a band. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_moments_gather(lf_reconstruction *r, const lf_film *film, int number,
                                         lf_reconstruct_scratch *scratch);
/* Those of a band of a level above, from the level below. */
LF_NODISCARD lf_status lf_moments_coarsen(lf_reconstruction *r, int level, int number);

/* The share of n q that W has to come up to where weights may cancel. */
static inline float lf_least_share(const lf_film *film)
{
    return film->layout.has_signed ? 0.25f : 0.0f;
}

/* What N is divided by where it is an answer: W, or W' where that is the second and less noisy
 * weight; 0 where it is none: it has to come up to a share of what is expected, nq, where weights
 * may cancel. */
static inline float lf_pixel_found_weight(const lf_film *film, const lf_pixel_found *found,
                                          bool second, float nq)
{
    float w = lf_film_weight(found->w, found->w2, second);
    return w > lf_least_share(film) * nq ? w : 0.0f;
}

#endif
