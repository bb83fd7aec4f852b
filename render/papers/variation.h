/* The map of amv2019; private to render/. */
#ifndef LF_RENDER_VARIATION_H
#define LF_RENDER_VARIATION_H

#include "render/rows/adaptive.h"

/* Counts in proportion to the total variation of the pilot's error along rows (Fraboni et al. 2019,
 * 4.3), pooled as in the map of rows/adaptive.h. LF_E_NOMEM: counts are as before. */
LF_NODISCARD lf_status lf_variation_map(const lf_film *film, lf_counts *counts);

#endif
