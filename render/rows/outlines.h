/* Pixels of a row in which surfaces meet: they get LF_OUTLINE_POINTS film points of B, q and
 * features, each in another plane of the row, since one plane tells nothing of outlines that run
 * along the row. Private to render/rows.
 *
 * Which pixels these are must not depend on what film points find, or what is kept would be biased:
 * a wire thinner than a pixel would be one of four film points in visits that find it, and the
 * background all of it in those that do not: too faint in all. So it is told by the corners of
 * pixels, which are the same in all visits of the same moment.
 */
#ifndef LF_RENDER_OUTLINES_H
#define LF_RENDER_OUTLINES_H

#include "render/rows/exits.h"

/* A worker's memory for films of this layout. LF_E_NOMEM; *out may then be finished. */
LF_NODISCARD lf_status lf_outlines_init(lf_outlines *out, const lf_row_triangles *rows, bool veiled,
                                        const lf_film_layout *layout);
/* Accepts one that is all zero. */
void lf_outlines_finish(lf_outlines *outlines);

/* Looks for the outlines of a row, at the visit's moment, into worker->met.outlines; true: there
 * are some. Uses both sections of the worker: before the row's plane is cut. */
bool lf_outlines_find(const lf_visit_plan *plan, const lf_visit *visit);

/* The film points of outlines in plane number `plane`, 1 .. LF_OUTLINE_POINTS - 1, which has been
 * cut and is the visit's; those before it have been taken, the first by lf_exits_fan. */
void lf_outlines_take(lf_exits *e, int plane);
/* How far the film points of a plane are to the right of those in plane 0, in pixels. What leaves
 * the pixel on the right comes in on its left. */
float lf_outlines_step(int plane);
/* How far the plane is below plane 0, in rows, likewise. */
static inline float lf_outlines_lower(int plane)
{
    return (float)plane / LF_OUTLINE_POINTS;
}

#endif
