/* What eyes in front of a panel see of a light field: its views are toned, interlaced and looked at
 * through the panel's lenses (device/sim/optics.h), from LF_EYE_PLACES directions and from one view
 * further to the right of each. The pictures are the display's light, 0 to 1 and linear.
 *
 * Errors are those of trial.h: e = (x - r) / sqrt(r^2 + epsilon), r the reference as an eye sees
 * it. A panel has 8 bits, and so has what the lenses show: errors below some 1e-5 are rounding. */
#ifndef LF_BENCH_EYES_H
#define LF_BENCH_EYES_H

#include "base/calibration.h"
#include "base/thread.h"
#include "render/render.h"

enum { LF_EYE_PLACES = 3, LF_EYES = 2 * LF_EYE_PLACES };

typedef struct lf_eyes lf_eyes;

/* settings: views, their size and aspect. All arguments but pool, which works in all calls, are
 * only read here. LF_E_ARG: the panel's lenses cannot be resolved. On LF_OK the caller owns *out.
 * One thread at a time. */
LF_NODISCARD lf_status lf_eyes_create(const lf_calibration *calibration,
                                      const lf_render_settings *settings,
                                      const lf_film_settings *film, double epsilon, lf_pool *pool,
                                      lf_eyes **out, lf_error *err);
/* Accepts NULL. */
void lf_eyes_destroy(lf_eyes *eyes);

/* Two independent renderings of the reference, [row][view][column][3]; r is their mean as the eyes
 * see it. Before the others. */
void lf_eyes_set_reference(lf_eyes *eyes, const float *first, const float *second);

/* Looks at a picture, laid out as the reference is, and remembers what it looks like.
 * *out_rel_mse: mean of e^2 over all eyes. *out_flicker: mean square of the change of e, in each
 * place of the eye's picture, from an eye to the one that is a view further right. What the
 * reference adds to both is subtracted. */
void lf_eyes_look(lf_eyes *eyes, const float *picture, double *out_rel_mse, double *out_flicker);

/* Mean square of the change of e from the picture that was looked at last to this one. The
 * reference adds nothing to it. */
double lf_eyes_change(lf_eyes *eyes, const float *picture);

#endif
