/* Metals by name; private to render/. Complex indices eta + i k at 611.4, 549.1 and 464.2 nm, the
 * dominant wavelengths of sRGB's primaries, by linear interpolation between the published samples:
 * Johnson and Christy, Phys. Rev. B 6, 4370 (1972; gold, silver, copper) and Phys. Rev. B 9, 5056
 * (1974; chromium, iron, nickel, titanium); Rakic, Applied Optics 34, 4755 (1995; aluminium); as in
 * the database of refractiveindex.info (CC0). */
#ifndef LF_RENDER_METAL_H
#define LF_RENDER_METAL_H

#include "render/scene/vec.h"

typedef struct lf_metal {
    lf_vec3 eta, k;
} lf_metal;

/* NULL after the last; lf_metals[i] belongs to lf_metal_names[i]. */
extern const char *const lf_metal_names[];
extern const lf_metal lf_metals[];

#endif
