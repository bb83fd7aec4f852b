/* picture: the views of the light field as they are now, 8-bit, resolved and tone-mapped row by row
 * while the film is rendered, and filled for the screen while they are incomplete; what
 * catchers get and guides are in them. Memory: 8 bytes a view pixel, with catchers 29 more, and 28
 * with such as reflect. Thread:
 * the engine's, but for lf_picture_row, which workers call for different rows at once. */
#ifndef LF_DAEMON_PICTURE_H
#define LF_DAEMON_PICTURE_H

#include "quilt/quilt.h"
#include "render/render.h"

/* How far a coarse frame may reach for a pixel, and how far is reached so that a picture that moves
 * is seen before it is coarse everywhere (a few pixels at the edges of the outer views are seen by
 * few other views and found late). */
#define LF_COARSE_REACH 4
#define LF_FILL_REACH 16

typedef struct lf_picture {
    int n_views, width, height, n_threads;
    uint8_t *rgb;         /* [row][view][column][3]; what is missing is filled when it is shown */
    uint8_t *missing;     /* [row][view][column]: nonzero = hole or never visited */
    int64_t *row_missing; /* [row]: how many of them; all of a row that is shown without paths */
    float *scratch;       /* [thread][view][column][3] */
    float *beside;        /* [thread][view][column][2], LF_GUIDE_LAYERS; NULL: no guides */
    uint8_t *flags;       /* [thread][view][column] */
    lf_tone *tone;
    lf_film_settings film; /* exposure: the one in use */
    bool metered;          /* the one in use was measured: it stays unless it is far off */
    bool settled;          /* it has been looked at since the picture was shaped */
    lf_renderer *renderer; /* borrowed: what rows are resolved from */
    lf_caught *caught;     /* of the renderer; NULL where nothing is caught */
    lf_depth sharp;        /* what guides mark: outside of it */
    lf_estimator estimator;
    bool reconstructs; /* rows are shown by the renderer's fit, where there is one */
    /* every view pixel has been looked through itself, on average: finding nothing there is an
     * answer, not a hole */
    bool sampled;
} lf_picture;

/* Makes room for this shape (kept when it is the one already there) and takes the film block's
 * tone. Everything is missing afterwards. LF_E_NOMEM, LF_E_ARG: the picture is as before. Zeroed is
 * a valid start. */
LF_NODISCARD lf_status lf_picture_shape(lf_picture *picture, int n_views, int width, int height,
                                        int n_threads, const lf_film_settings *film, lf_error *err);
void lf_picture_finish(lf_picture *picture);

/* What rows are made of from now on, after lf_picture_shape: renderer (borrowed; NULL: of none) has
 * another film. LF_E_NOMEM: what catchers get is missing. */
LF_NODISCARD lf_status lf_picture_follow(lf_picture *picture, lf_renderer *renderer);
/* With depth (NULL: without) what lies outside of it is marked in rows made from now on
 * (daemon/output/guides.h). LF_E_NOMEM: without. */
LF_NODISCARD lf_status lf_picture_guide(lf_picture *picture, const lf_depth *depth);
/* Whether every row has seen enough of what its catchers get to be called converged. */
bool lf_picture_caught(const lf_picture *picture);

/* Takes another exposure or curve, and shows all rows by it. LF_E_NOMEM, LF_E_ARG: as before. */
LF_NODISCARD lf_status lf_picture_retone(lf_picture *picture, const lf_film_settings *film,
                                         lf_pool *pool, lf_error *err);
/* With an automatic exposure, once a picture: measures it, and where it is more than half a stop
 * from the one in use, or the first, shows all rows by it: true. It then stays as it is until
 * there is another picture, whatever comes. */
bool lf_picture_expose(lf_picture *picture, lf_pool *pool);

/* An lf_row_fn with the picture as its context: shows a row that was just visited; where it is to
 * be reconstructed, by the last fit as soon as there is one. */
void lf_picture_row(void *context, int row, int worker);
/* The same of a row that is not looked at before there is a fit (lf_picture_fitted). */
void lf_picture_row_later(void *context, int row, int worker);
/* All rows by a new fit, with what catchers get smooth. LF_E_CANCELLED: some are as they were. */
LF_NODISCARD lf_status lf_picture_fitted(lf_picture *picture, lf_pool *pool,
                                         const lf_cancel *cancel);
/* All rows again (another estimator, a restored film). LF_E_CANCELLED: some are as they
 * were. */
LF_NODISCARD lf_status lf_picture_resolve(lf_picture *picture, lf_pool *pool,
                                          const lf_cancel *cancel);
/* Everything is missing, as in the beginning. */
void lf_picture_forget(lf_picture *picture);
/* Resolves all rows for what that leaves behind for lf_renderer_stats; shows nothing. Cancelled, it
 * leaves some as they were. */
void lf_picture_estimate(lf_picture *picture, lf_pool *pool, const lf_cancel *cancel);
/* Tone-maps float views that come from a file; nothing is missing then. */
void lf_picture_take(lf_picture *picture, const lf_views32 *views);

/* How many view pixels are missing. */
int64_t lf_picture_missing(const lf_picture *picture);
/* The views to show; borrowed until the next call. *out_unfilled: pixels that have none to be
 * filled from in a coarse frame's reach (0 = at least coarse); *out_blank: those that have none in
 * LF_FILL_REACH either, and are not shown as anything. */
lf_views8 lf_picture_views(lf_picture *picture, lf_pool *pool, int64_t *out_unfilled,
                           int64_t *out_blank);
/* What is shown, or the other of the two, as a linear film [row][view][column][3], filled likewise,
 * without guides; reconstructed: by a fit made now. LF_E_NOMEM; LF_E_STATE: nothing has been
 * rendered yet, or the film has no features. */
LF_NODISCARD lf_status lf_picture_film(const lf_picture *picture, bool reconstructed, lf_pool *pool,
                                       float *film);

#endif
