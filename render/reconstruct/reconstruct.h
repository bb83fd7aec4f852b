/* The picture that people see: N/W by local regression on features that have no path noise, over a
 * lattice of cells in the world that all views share; private to render/.
 * docs/developer/reconstruction.md has the formulas.
 *
 * The answer of a view pixel is B + q max(0, a R), a its albedo (1 in films without), R the
 * prediction of a linear function of eight features (position along its epipolar line, row,
 * nearness, share of media, q, view, spread of nearness, light at infinity) whose coefficients lie
 * in nodes of the finest lattice, in between interpolated. They are fitted in cells of several
 * sizes to the sums N and W of each half and of both, and taken from coarse to fine as far as the
 * other half agrees, in the end towards N/W of the pixel itself: so the answer converges to that of
 * mwis with W.
 *
 *     lf_reconstruction *r;
 *     lf_reconstruct_create(&view, pool, &r);             // once a rig and film
 *     lf_reconstruct_fit(r, film, cancel);                // when the film has more to tell
 *     lf_reconstruct_row(r, film, row, out);              // any thread, any row, many at once
 *
 * A film must have features (lf_render_settings.features). Same film, same bytes, for any number of
 * threads. */
#ifndef LF_RENDER_RECONSTRUCT_H
#define LF_RENDER_RECONSTRUCT_H

#include "base/thread.h"
#include "render/film/film.h"

typedef struct lf_reconstruction lf_reconstruction;
typedef struct lf_past lf_past;

/* Where the views' pixels lie in the world that they share: the place of pixel column u of view k
 * along the epipolar line is u + shift[k] (nearness - still). */
typedef struct lf_reconstruct_view {
    int n_views, width, height;
    const float *shift; /* [n_views] camera position over the width of a pixel at Z = D; copied */
    float still;        /* nearness of what stays where it is from view to view: rig.h */
    float depth;        /* D over the width of a pixel at Z = D: nearness 1, in pixels */
    bool albedo;        /* the films that it is fitted to have albedo */
    float white;        /* with albedo: lf_sunlight_mean of the scene */
} lf_reconstruct_view;

/* LF_E_NOMEM. pool is borrowed and must outlive it. */
LF_NODISCARD lf_status lf_reconstruct_create(const lf_reconstruct_view *view, lf_pool *pool,
                                             lf_reconstruction **out);
/* Accepts NULL. */
void lf_reconstruct_destroy(lf_reconstruction *r);

/* Fits to what the film holds now, on the pool. LF_E_NOMEM or LF_E_CANCELLED: there is no fit then.
 * Not while rows are visited, or answered by it. */
LF_NODISCARD lf_status lf_reconstruct_fit(lf_reconstruction *r, const lf_film *film,
                                          const lf_cancel *cancel);
/* Whether the last fit came to its end. */
bool lf_reconstruct_ready(const lf_reconstruction *r);

/* What the last fit knows of the world, without its moments: a copy, for a reconstruction of the
 * same scene by another rig. NULL: there is no fit, or no memory. Not while a fit is made. */
lf_past *lf_past_of(const lf_reconstruction *r);
/* Accepts NULL. */
void lf_past_destroy(lf_past *past);

/* How the rig of a past saw what is seen now. */
typedef struct lf_past_move {
    /* (column, row, nearness, 1) of what lies before the middle camera -> the same for the past's,
     * times what is in the last place; rows first */
    double map[4][4];
    float view; /* who is at x of the width of the view cone, the same for both, was at x + view */
} lf_past_move;

/* Fits from now on have a past for a first guess, as far as what the film holds does not speak
 * against it. NULL, NULL: they have none. A past of films with albedo is
 * none for films without, and the other way round. past is borrowed for as long; move is copied.
 * Not while a fit is made. */
void lf_reconstruct_follow(lf_reconstruction *r, const lf_past *past, const lf_past_move *move);

/* The answer of one row of all views from the last fit and what the film holds of the row now. out
 * [view][column][3]. LF_E_STATE, and out untouched: there is no fit, or nothing is known of the row
 * (lf_film_is_known). Pixels of a provisional row that lie between others are 0. LF_E_NOMEM.
 * Thread: any, for different rows at once. */
lf_status lf_reconstruct_row(lf_reconstruction *r, const lf_film *film, int row, float *out);

#endif
