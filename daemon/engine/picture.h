/* picture: the current views of the light field, 8 bits per channel. Rows are resolved and
 * tone-mapped one by one during rendering. Missing pixels are filled for the screen while views are
 * incomplete. Shadow catchers and guides are included.
 *
 * Memory: 8 bytes per view pixel; 29 more with catchers; 28 more if catchers reflect.
 *
 * Thread: the engine's, except lf_picture_row, which workers call for different rows at once. */
#ifndef LF_DAEMON_PICTURE_H
#define LF_DAEMON_PICTURE_H

#include "quilt/quilt.h"
#include "render/render.h"

/* Largest distance, in pixels, from which a pixel is filled. COARSE: in a frame that counts as
 * coarse. FILL: in earlier frames, so that a moving picture is visible sooner. A few pixels at the
 * edges of the outer views are seen by few other views and found late. */
#define LF_COARSE_REACH 4
#define LF_FILL_REACH 16

typedef struct lf_picture {
    int n_views, width, height, n_threads;
    uint8_t *rgb;         /* [row][view][column][3]; missing pixels are filled when it is shown */
    uint8_t *missing;     /* [row][view][column]: nonzero = hole or never visited */
    int64_t *row_missing; /* [row]: number of missing pixels; a row shown without paths counts as
                           * all missing */
    float *scratch;       /* [thread][view][column][3] */
    float *beside;        /* [thread][view][column][2], LF_GUIDE_LAYERS; NULL: no guides */
    uint8_t *flags;       /* [thread][view][column] */
    lf_tone *tone;
    lf_film_settings film; /* exposure: the one in use */
    bool metered;          /* the exposure in use was measured; it stays unless it is far off */
    bool settled;          /* the exposure was checked since the last lf_picture_shape */
    lf_renderer *renderer; /* borrowed; rows are resolved from its film */
    lf_caught *caught;     /* of the renderer; NULL: no catchers */
    lf_depth sharp;        /* guides mark what is outside this depth */
    lf_estimator estimator;
    bool reconstructs; /* rows are shown by the renderer's fit, if it has one */
    /* Every view pixel has one sample of its own on average. A pixel without scattered light is
     * then an answer, not a hole. */
    bool sampled;
} lf_picture;

/* Allocates this shape, unless the picture has it already, and takes the tone curve of film. All
 * pixels are missing afterwards. LF_E_NOMEM, LF_E_ARG: the picture is unchanged. A zeroed picture
 * is valid input. */
LF_NODISCARD lf_status lf_picture_shape(lf_picture *picture, int n_views, int width, int height,
                                        int n_threads, const lf_film_settings *film, lf_error *err);
void lf_picture_finish(lf_picture *picture);

/* Sets the renderer (borrowed; NULL: none) whose film is shown from now on. To be called after
 * lf_picture_shape. LF_E_NOMEM: catchers are not shown. */
LF_NODISCARD lf_status lf_picture_follow(lf_picture *picture, lf_renderer *renderer);
/* Marks what lies outside depth in rows shown from now on (daemon/output/guides.h); NULL: no
 * guides. LF_E_NOMEM: no guides. */
LF_NODISCARD lf_status lf_picture_guide(lf_picture *picture, const lf_depth *depth);
/* True if the shadow catchers of every row have enough samples to be called converged. */
bool lf_picture_caught(const lf_picture *picture);

/* Sets another exposure or tone curve and shows all rows with it. LF_E_NOMEM, LF_E_ARG:
 * unchanged. */
LF_NODISCARD lf_status lf_picture_retone(lf_picture *picture, const lf_film_settings *film,
                                         lf_pool *pool, lf_error *err);
/* Automatic exposure, once per picture. Measures the exposure. If it is the first one, or more than
 * half a stop from the one in use, shows all rows with it and returns true. The exposure then stays
 * until the next picture. */
bool lf_picture_expose(lf_picture *picture, lf_pool *pool);

/* An lf_row_fn; context is the picture. Shows a row that was just visited. A picture that is to be
 * reconstructed uses the last fit once there is one. */
void lf_picture_row(void *context, int row, int worker);
/* Like lf_picture_row, for a row that is shown only once there is a fit (lf_picture_fitted). */
void lf_picture_row_later(void *context, int row, int worker);
/* Shows all rows with a new fit, with smoothed catchers. LF_E_CANCELLED: some rows are
 * unchanged. */
LF_NODISCARD lf_status lf_picture_fitted(lf_picture *picture, lf_pool *pool,
                                         const lf_cancel *cancel);
/* Shows all rows again, after a change of estimator or a restored film. LF_E_CANCELLED: some rows
 * are unchanged. */
LF_NODISCARD lf_status lf_picture_resolve(lf_picture *picture, lf_pool *pool,
                                          const lf_cancel *cancel);
/* Marks all pixels as missing. */
void lf_picture_forget(lf_picture *picture);
/* Resolves all rows only for the error sums that lf_renderer_stats reads; shows nothing. If
 * cancelled, some rows keep their old sums. */
void lf_picture_estimate(lf_picture *picture, lf_pool *pool, const lf_cancel *cancel);
/* Tone-maps float views from a file; no pixel is missing then. */
void lf_picture_take(lf_picture *picture, const lf_views32 *views);

/* Number of missing view pixels. */
int64_t lf_picture_missing(const lf_picture *picture);
/* The views to show; borrowed until the next call. *out_unfilled: missing pixels without a source
 * within LF_COARSE_REACH (0 = at least coarse). *out_blank: those without a source within
 * LF_FILL_REACH, which stay blank. */
lf_views8 lf_picture_views(lf_picture *picture, lf_pool *pool, int64_t *out_unfilled,
                           int64_t *out_blank);
/* A linear film [row][view][column][3], filled like the views, without guides. reconstructed: by a
 * new fit; otherwise the unfiltered answer. LF_E_NOMEM; LF_E_STATE: nothing has been rendered yet,
 * or the film has no features. */
LF_NODISCARD lf_status lf_picture_film(const lf_picture *picture, bool reconstructed, lf_pool *pool,
                                       float *film);

#endif
