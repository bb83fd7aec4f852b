/* Positions of volumes while the shutter is open; private to render/. */
#ifndef LF_RENDER_VOLUME_PLACE_H
#define LF_RENDER_VOLUME_PLACE_H

#include "render/import/scene/shutter.h"

/* Extends a box in world coordinates by a volume that is number i of the descs (or one of its
 * fields), over its whole motion. No effect for an empty volume. */
void lf_volume_extend(const lf_volume *volume, const lf_shutter *shutter, int i,
                      double bounds[2][3]);

/* Checks that the volume, empty or not, lies within LF_MAX_REACH while the shutter is open:
 * LF_E_FORMAT. */
LF_NODISCARD lf_status lf_volume_check(const lf_volume *volume, const lf_shutter *shutter, int i,
                                       lf_error *err);

/* Sets its position at shutter open, its motion, its box and the cell size of slices. LF_E_FORMAT
 * (singular maps), LF_E_NOMEM. */
LF_NODISCARD lf_status lf_volume_place(lf_volume *volume, const lf_shutter *shutter, int i,
                                       const double origin[3], lf_error *err);

#endif
