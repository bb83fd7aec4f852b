/* Where volumes stand while the shutter is open; private to render/. */
#ifndef LF_RENDER_VOLUME_PLACE_H
#define LF_RENDER_VOLUME_PLACE_H

#include "render/import/scene/shutter.h"

/* Extends a box in world coordinates by a volume that is number i of the descs (or a field of it),
 * wherever it goes, if anything of it is there. */
void lf_volume_extend(const lf_volume *volume, const lf_shutter *shutter, int i,
                      double bounds[2][3]);

/* Whether all of it, there or not, lies within LF_MAX_REACH while the shutter is open: LF_E_FORMAT.
 */
LF_NODISCARD lf_status lf_volume_check(const lf_volume *volume, const lf_shutter *shutter, int i,
                                       lf_error *err);

/* Puts it where it is when the shutter opens, and works out its way, its box and what slices
 * resolve of it. LF_E_FORMAT (maps that flatten space), LF_E_NOMEM. */
LF_NODISCARD lf_status lf_volume_place(lf_volume *volume, const lf_shutter *shutter, int i,
                                       const double origin[3], lf_error *err);

#endif
