/* Sums of a film over the cells of all levels; private to render/reconstruct. */
#ifndef LF_RENDER_RECONSTRUCT_MOMENTS_H
#define LF_RENDER_RECONSTRUCT_MOMENTS_H

#include "render/reconstruct/pixels.h"

/* All cells and sums of a band of level 0. One worker a band. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_moments_gather(lf_reconstruction *r, const lf_film *film, int number,
                                         lf_pixels rows[LF_CELL_SIDE]);
/* Those of a band of a level above, from the level below. */
LF_NODISCARD lf_status lf_moments_coarsen(lf_reconstruction *r, int level, int number);

/* Where N/W of a half, or of both, is an answer: W has come up to a share of what is expected where
 * weights may cancel. nq: the expected weight. */
static inline bool lf_weight_is_usable(const lf_film *film, float w, float nq)
{
    return film->layout.has_signed ? w > 0.25f * nq : w > 0.0f;
}

#endif
