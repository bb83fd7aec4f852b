/* Frames of a sequence whose shutters overlap: what they have in common is rendered once.
 *
 * A shutter that stays open for longer than a frame is cut into parts that fit the shutters of all
 * frames (lf_frames_parts). A part is a picture of its own, with a scene and random numbers that
 * are the same whichever frame asks; a frame is its parts together, each with its share of the
 * samples (docs/developer/estimators/motion.md, "Shutters that overlap"). Thread: the main thread,
 * as the rendering's. */
#ifndef LF_DAEMON_RENDERING_SHARED_H
#define LF_DAEMON_RENDERING_SHARED_H

#include "daemon/tools/rendering.h"

/* How many parts the frames of r have, *out_a_frame of them beginning in each. 0: they share
 * nothing: by their shutters; since the camera is turned from frame to frame or stands in a grid;
 * since budgets are errors; or since there are catchers, or layers, which rays of the frame's own
 * look for. */
int lf_shared_parts(const lf_rendering *r, int *out_a_frame);
/* Frames in hand at a time, renderers that are kept. */
int lf_shared_renderers(int n_parts, int a_frame);
/* What a part gets of a frame's budget: passes in pairs, one for each half of the film. */
lf_budget lf_shared_budget(const lf_rendering *r, int n_parts);

/* For the frames of r, of which wanted[frame - first] tells whether they are to be rendered (it has
 * to stay). *out NULL: they share nothing. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_shared_frames_create(const lf_rendering *r, const bool *wanted,
                                               lf_shared_frames **out, lf_error *err);
/* Puts scene, settings and renderer of the frame in hand into r, and what its parts came to into
 * r->gathered. Frames come in their order. LF_E_CANCELLED; errors of scenes. */
LF_NODISCARD lf_status lf_shared_frames_take(lf_shared_frames *shared, lf_rendering *r,
                                             lf_error *err);
/* Accepts NULL. */
void lf_shared_frames_destroy(lf_shared_frames *shared);

#endif
