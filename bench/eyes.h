/* Simulates eyes in front of a panel that shows a light field. Views are tone-mapped, interlaced
 * and seen through the panel's lenses (device/sim/optics.h). There are LF_EYE_PLACES directions,
 * and for each a second eye one view further to the right. Images are linear display light, 0 to 1.
 *
 * Errors are as in trial.h: e = (x - r) / sqrt(r^2 + epsilon), r the reference as the eye sees it.
 * A panel and the image through its lenses have 8 bits, so errors below about 1e-5 are rounding. */
#ifndef LF_BENCH_EYES_H
#define LF_BENCH_EYES_H

#include "base/calibration.h"
#include "base/thread.h"
#include "render/render.h"

enum { LF_EYE_PLACES = 3, LF_EYES = 2 * LF_EYE_PLACES };

typedef struct lf_eyes lf_eyes;

/* settings: views, their size and aspect. All arguments except pool, which works in all calls, are
 * read only here. LF_E_ARG: the panel cannot resolve its lenses. On LF_OK the caller owns *out. One
 * thread at a time. */
LF_NODISCARD lf_status lf_eyes_create(const lf_calibration *calibration,
                                      const lf_render_settings *settings,
                                      const lf_film_settings *film, double epsilon, lf_pool *pool,
                                      lf_eyes **out, lf_error *err);
/* Accepts NULL. */
void lf_eyes_destroy(lf_eyes *eyes);

/* Sets two independent renderings of the reference, [row][view][column][3]; r is their mean as the
 * eyes see it. To be called before the functions below. */
void lf_eyes_set_reference(lf_eyes *eyes, const float *first, const float *second);

/* Simulates the eyes for a picture, in the layout of the reference, and stores what they see.
 * *out_rel_mse: mean of e^2 over all eyes. *out_flicker: mean square of the change of e, pixel by
 * pixel, from an eye to its neighbour one view further right. The reference's own contribution is
 * subtracted from both. */
void lf_eyes_look(lf_eyes *eyes, const float *picture, double *out_rel_mse, double *out_flicker);

/* Mean square of the change of e from the last picture to this one. The reference contributes
 * nothing to it. */
double lf_eyes_change(lf_eyes *eyes, const float *picture);

#endif
