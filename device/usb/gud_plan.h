/* Which pixels a display has to be sent: changed rectangles become bands, and what the display
 * shows already is left out.
 *
 * The panel is divided into tiles. Of each the plan keeps a hash of what the display is known to
 * show, or that nothing is known. An update hashes the tiles that its rectangles touch in the new
 * frame, leaves out those that are equal, and joins what is near to bands, with what lies between,
 * as long as that is less than announcing another band costs. A tile of which nothing is known is
 * sent whole. Threads: an object belongs to one thread at a time. Nothing but create allocates.
 * Private to device/ and its tests. */
#ifndef LF_DEVICE_GUD_PLAN_H
#define LF_DEVICE_GUD_PLAN_H

#include <stdint.h>

#include "base/image.h"

typedef struct lf_gud_plan lf_gud_plan;

/* For a panel of width x height pixels, 1..LF_MAX_SIDE, of which nothing is known. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_gud_plan_create(int width, int height, lf_gud_plan **out);
/* Accepts NULL. */
void lf_gud_plan_destroy(lf_gud_plan *plan);

/* Nothing is known any more of what the display shows. */
void lf_gud_plan_forget(lf_gud_plan *plan);

/* What to send for rects[n] (within the panel) of frame (the panel's size, 3 channels), of which
 * all else is what the last update had there. Bands have at most max_pixels, or one row when that
 * is more. Returns their number; lf_gud_plan_band gives them. */
int lf_gud_plan_update(lf_gud_plan *plan, const lf_image8 *frame, const lf_rect *rects, int n,
                       size_t max_pixels);
/* The same for a display that takes nothing but whole frames: one band or none. */
int lf_gud_plan_update_whole(lf_gud_plan *plan, const lf_image8 *frame);
/* The i-th band of the last update. */
lf_rect lf_gud_plan_band(const lf_gud_plan *plan, int i);

/* Told when the display has all of band i. */
void lf_gud_plan_shown(lf_gud_plan *plan, int i);
/* Told when the update was broken off: nothing is known any more of where bands lie that were not
 * shown. */
void lf_gud_plan_failed(lf_gud_plan *plan);

#endif
