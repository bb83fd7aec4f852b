/* Decides which pixels to send to a display: changed rectangles become bands, without the parts
 * that the display already shows.
 *
 * The panel is divided into tiles. For each tile the plan stores a hash of the pixels that the
 * display is known to show, or that they are unknown. An update hashes the touched tiles of the new
 * frame and omits equal ones. It joins near tiles to bands, including the pixels between them, if
 * this costs less than announcing another band. An unknown tile is sent whole.
 *
 * Threads: an object belongs to one thread at a time. Only create allocates. Private to device/ and
 * its tests. */
#ifndef LF_DEVICE_GUD_PLAN_H
#define LF_DEVICE_GUD_PLAN_H

#include <stdint.h>

#include "base/image.h"

typedef struct lf_gud_plan lf_gud_plan;

/* Creates a plan for a panel of width x height pixels, 1..LF_MAX_SIDE, with unknown contents.
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gud_plan_create(int width, int height, lf_gud_plan **out);
/* Accepts NULL. */
void lf_gud_plan_destroy(lf_gud_plan *plan);

/* Marks the display's contents as unknown. */
void lf_gud_plan_forget(lf_gud_plan *plan);

/* Computes the bands to send for rects[n] (within the panel) of frame (the panel's size, 3
 * channels). Outside rects, frame must equal the frame of the last update. A band has at most
 * max_pixels, or one row if that is more. Returns the number of bands for lf_gud_plan_band. */
int lf_gud_plan_update(lf_gud_plan *plan, const lf_image8 *frame, const lf_rect *rects, int n,
                       size_t max_pixels);
/* For a display that takes only whole frames: one band or none. */
int lf_gud_plan_update_whole(lf_gud_plan *plan, const lf_image8 *frame);
/* The i-th band of the last update. */
lf_rect lf_gud_plan_band(const lf_gud_plan *plan, int i);

/* To be called once the display has received band i. */
void lf_gud_plan_shown(lf_gud_plan *plan, int i);
/* To be called when the update failed: the contents of the bands not shown become unknown. */
void lf_gud_plan_failed(lf_gud_plan *plan);

#endif
