/* Native samples: what a view pixel draws for itself at the first surface, into M of the film;
 * private to render/rows/. */
#ifndef LF_RENDER_NATIVE_H
#define LF_RENDER_NATIVE_H

#include "render/rows/visit.h"

/* Adds to M of a view pixel, which is [view][column]; what is not finite is dropped and counted. */
void lf_visit_add_native(lf_visit *visit, size_t pixel, lf_vec3 radiance);

/* Whether a base sample of the pixel has native samples, too: not where it has others of its own
 * (mirror_rounds) that are counted without. */
bool lf_natives_by_base(const lf_visit *visit, int view, int column);

/* What the delta lobes of the surface at the pivot bring, and what a veil sends out by itself. */
void lf_natives_of_surface(lf_visit *visit, int view, int column, const lf_pivot *pivot);

/* What every pane that a base ray from eye along ray->event.w reaches reflects, up to t_end: rays
 * pass them and end on them by chance, so that each is reached as often as its light comes through
 * what is before it. */
void lf_natives_of_thin_glass(lf_visit *visit, int view, int column, const lf_pivot *ray,
                              lf_vec3 eye, float t_end);

#endif
