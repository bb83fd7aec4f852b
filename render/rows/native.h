/* Native samples: samples that a view pixel draws for itself at the first surface, into M of the
 * film; private to render/rows/. */
#ifndef LF_RENDER_NATIVE_H
#define LF_RENDER_NATIVE_H

#include "render/rows/visit.h"

/* Adds to M of a view pixel, an index [view][column]; drops and counts values that are not finite.
 */
void lf_visit_add_native(lf_visit *visit, size_t pixel, lf_vec3 radiance);

/* Whether a base sample of the pixel also draws native samples. Not if the pixel has separate ones
 * (mirror_rounds). */
bool lf_natives_by_base(const lf_visit *visit, int view, int column);

/* Adds what the delta lobes of the surface at the pivot reflect and refract, and the emission of an
 * alpha surface. */
void lf_natives_of_surface(lf_visit *visit, int view, int column, const lf_pivot *pivot);

/* Adds the reflections of thin glass that a base ray from eye along ray->event.w meets up to t_end.
 * Rays pass thin glass or end on it at random, so that each one is reached with the probability of
 * the transmittance in front of it. */
void lf_natives_of_thin_glass(lf_visit *visit, int view, int column, const lf_pivot *ray,
                              lf_vec3 eye, float t_end);

#endif
