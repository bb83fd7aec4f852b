/* Pixels of a row in which surfaces meet. There, the first visits of a half take more than one film
 * point of B, q and features. Each point lies in another plane of the row, because one plane misses
 * outlines that run along the row. Private to render/rows.
 *
 * The choice of pixels must not depend on the results of film points, or the mean would be biased.
 * Example: a wire thinner than a pixel would fill one of four film points in visits that find it,
 * and the background all of the others; the wire would be too faint. So the corners of pixels
 * decide. They are the same in all visits at the same shutter time.
 *
 * Film points of a half are a net: visits 0 and 1 lie in the two halves of a pixel, visits 0 to 3
 * in its four quarters, along either axis. The first two visits take four points each, a quarter
 * apart. If visits 2 and 3 took one each, these would represent only two quarters of the pixel, and
 * four visits would be no better than without. So they take a second point, in the quarter of visit
 * 0 or 1 that lies in the other half. Together the points cover the whole pixel. From four visits
 * on, the net alone is as good. */
#ifndef LF_RENDER_OUTLINES_H
#define LF_RENDER_OUTLINES_H

#include "render/rows/unscattered.h"

/* A worker's memory for films of this layout. LF_E_NOMEM; then *out may be finished. */
LF_NODISCARD lf_status lf_outlines_init(lf_outlines *out, const lf_row_triangles *rows,
                                        bool has_alphas, const lf_film_layout *layout);
/* Accepts a zeroed struct. */
void lf_outlines_finish(lf_outlines *outlines);

/* Zeroed memory for a film's rows: one bit per view pixel. LF_E_NOMEM; then *out may be finished.
 */
LF_NODISCARD lf_status lf_outline_map_init(lf_outline_map *out, const lf_film_layout *layout);
/* Accepts a zeroed struct. */
void lf_outline_map_finish(lf_outline_map *map);

/* Finds the outlines of a row at the visit's shutter time and stores them in worker->met.outlines.
 * true: the row has some. Uses both sections of the worker, so call it before the row's plane is
 * cut. Rows that plan->outlines already has are not searched again. */
bool lf_outlines_find(const lf_visit *visit);

/* Number of planes in which a visit takes film points, including its own. index: the visit's number
 * in its half of its stream, including coarse visits. */
int lf_outlines_planes(uint32_t index);

/* Takes the film points of outlines in plane `plane`, 1 .. lf_outlines_planes - 1. This plane must
 * have been cut and be the visit's current one. The planes before it must be done;
 * lf_unscattered_fan does the first. */
void lf_outlines_take(lf_unscattered *e, int plane);

/* Position of plane `plane` of a visit in the row, 0..1; offsets is the key of the sequence. */
float lf_outlines_row(uint64_t offsets, uint32_t index, int plane);
/* Position of a column's film point in that plane, in pixels from the pixel's left, 0..1. */
float lf_outlines_column(uint64_t key, int column, uint32_t index, int plane);
/* Position of its lens point along the plane's chord, 0..1. */
float lf_outlines_lens(uint64_t key, int column, uint32_t index, int plane);

#endif
