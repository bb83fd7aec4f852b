/* Frames of a sequence whose shutters overlap: their common parts are rendered once.
 *
 * A shutter that is open for longer than a frame is cut into parts that fit the shutters of all
 * frames (lf_frames_parts). A part is a picture of its own, with a scene and random numbers that do
 * not depend on the frame. A frame is the sum of its parts, each with its share of the samples
 * (docs/developer/estimators/motion.md, "Shutters that overlap").
 *
 * With --state, each part has a state: shutter_part k of frame f is the k-th part that begins in f.
 *
 * Thread: the main thread, as the rendering's. */
#ifndef LF_DAEMON_RENDERING_SHARED_H
#define LF_DAEMON_RENDERING_SHARED_H

#include "daemon/tools/rendering.h"

/* The number of parts of a frame of r; *out_a_frame: how many begin in each frame. 0: frames share
 * nothing. Reasons: their shutters; a camera that turns from frame to frame or is in a grid; error
 * budgets; catchers or layers, which need rays of the frame itself. */
int lf_shared_parts(const lf_rendering *r, int *out_a_frame);
/* The number of renderers kept at a time. */
int lf_shared_renderers(int n_parts, int a_frame);
/* A part's share of a frame's budget: passes in pairs, one for each half of the film. */
lf_budget lf_shared_budget(const lf_rendering *r, int n_parts);

/* Creates the shared state for the frames of r. wanted[frame - first]: the frame is to be rendered;
 * it must stay valid. *out NULL: frames share nothing. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_shared_frames_create(const lf_rendering *r, const bool *wanted,
                                               lf_shared_frames **out, lf_error *err);
/* Sets scene, settings and renderer of the current frame in r, and the cost of its parts in
 * r->gathered. Frames must come in order. LF_E_CANCELLED; errors of scenes. */
LF_NODISCARD lf_status lf_shared_frames_take(lf_shared_frames *shared, lf_rendering *r,
                                             lf_error *err);
/* Removes the states of parts that no frame after the current one needs. kept: this run has not
 * rendered the current frame, so only complete states of this job are removed. */
void lf_shared_frames_remove_states(lf_shared_frames *shared, lf_rendering *r, bool kept);
/* Accepts NULL. */
void lf_shared_frames_destroy(lf_shared_frames *shared);

#endif
