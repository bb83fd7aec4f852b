/* The denoised image: N/W by local regression on features without path noise, over a lattice of
 * cells in the world that all views share; private to render/. docs/developer/reconstruction.md has
 * the formulas.
 *
 * The value of a view pixel is B + q max(0, a R). a is its albedo (1 in films without albedo), R
 * the prediction of a linear function of eight features (position along its epipolar line, row,
 * nearness, share of media, q, view, spread of nearness, light at infinity). Its coefficients
 * belong to nodes of the finest lattice and are interpolated between them. They are fitted in cells
 * of several sizes to the sums N and W of each half and of both. They are blended from coarse to
 * fine as far as the other half agrees, finally towards N/W of the pixel itself. So the image
 * converges to mwis with W.
 *
 *     lf_reconstruction *r;
 *     lf_reconstruct_create(&view, pool, &r);             // once per rig and film
 *     lf_reconstruct_fit(r, film, cancel);                // when the film has more samples
 *     lf_reconstruct_row(r, film, row, out);              // any thread, any row, many at once
 *
 * The film must have features (lf_render_settings.features). The same film gives the same bytes for
 * any number of threads. */
#ifndef LF_RENDER_RECONSTRUCT_H
#define LF_RENDER_RECONSTRUCT_H

#include "base/thread.h"
#include "render/film/film.h"

typedef struct lf_reconstruction lf_reconstruction;
typedef struct lf_past lf_past;

/* Positions of the views' pixels in the shared world: the place of pixel column u of view k along
 * the epipolar line is u + shift[k] (nearness - still). */
typedef struct lf_reconstruct_view {
    int n_views, width, height;
    const float *shift; /* [n_views] camera position over the width of a pixel at Z = D; copied */
    float still;        /* nearness of points that do not move from view to view: rig.h */
    float depth;        /* D over the width of a pixel at Z = D: nearness 1, in pixels */
    bool albedo;        /* the fitted films have albedo */
    float white;        /* with albedo: lf_sunlight_mean of the scene */
} lf_reconstruct_view;

/* LF_E_NOMEM. pool is borrowed and must outlive it. */
LF_NODISCARD lf_status lf_reconstruct_create(const lf_reconstruct_view *view, lf_pool *pool,
                                             lf_reconstruction **out);
/* Accepts NULL. */
void lf_reconstruct_destroy(lf_reconstruction *r);

/* Fits to the film's current sums, on the pool. LF_E_NOMEM or LF_E_CANCELLED: then there is no fit.
 * Not while rows are visited, or resolved with it. */
LF_NODISCARD lf_status lf_reconstruct_fit(lf_reconstruction *r, const lf_film *film,
                                          const lf_cancel *cancel);
/* Whether the last fit was completed. */
bool lf_reconstruct_ready(const lf_reconstruction *r);

/* A copy of the last fit without its moments, for a reconstruction of the same scene by another
 * rig. NULL: there is no fit, or no memory. Not during a fit. */
lf_past *lf_past_of(const lf_reconstruction *r);
/* Accepts NULL. */
void lf_past_destroy(lf_past *past);

/* From the current rig to the rig of a past. */
typedef struct lf_past_move {
    /* Maps (column, row, nearness, 1), of a point in front of the middle camera, to the past's
     * coordinates, multiplied by the last component; rows of the matrix come first. */
    double map[4][4];
    /* The camera at position x of the view cone's width, which is the same for both, was at x +
     * view. */
    float view;
} lf_past_move;

/* Later fits use a past as a first guess, as far as the film does not contradict it. NULL, NULL: no
 * past. A past of films with albedo is not used for films without, and vice versa. past is borrowed
 * as long as it is used; move is copied. Not during a fit. */
void lf_reconstruct_follow(lf_reconstruction *r, const lf_past *past, const lf_past_move *move);

/* The result for one row of all views, from the last fit and the row's current sums. out
 * [view][column][3]. LF_E_STATE, with out untouched: there is no fit, or the row has no data
 * (lf_film_is_known). Pixels of a provisional row that lie between others are 0. LF_E_NOMEM.
 * Thread: any, for different rows at once. */
lf_status lf_reconstruct_row(lf_reconstruction *r, const lf_film *film, int row, float *out);

#endif
