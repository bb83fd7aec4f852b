/* Pixels of a row in which surfaces meet: the first visits of a half take more than one film point
 * of B, q and features there, each in another plane of the row, since one plane tells nothing of
 * outlines that run along the row. Private to render/rows.
 *
 * Which pixels these are must not depend on what film points find, or what is kept would be biased:
 * a wire thinner than a pixel would be one of four film points in visits that find it, and the
 * background all of it in those that do not: too faint in all. So it is told by the corners of
 * pixels, which are the same in all visits of the same moment.
 *
 * Film points of a half are a net: visits 0 and 1 lie in the two halves of a pixel, 0 to 3 in its
 * four quarters, along either axis. The first two visits take four points each, a quarter apart. If
 * visits 2 and 3 took one each, these would stand for two quarters of the pixel alone, and four
 * visits would be no better than without. So they take a second one, in the quarter of visit 0 or 1
 * that lies in the other half: together they cover all of it. From four visits on the net does as
 * well by itself. */
#ifndef LF_RENDER_OUTLINES_H
#define LF_RENDER_OUTLINES_H

#include "render/rows/unscattered.h"

/* A worker's memory for films of this layout. LF_E_NOMEM; *out may then be finished. */
LF_NODISCARD lf_status lf_outlines_init(lf_outlines *out, const lf_row_triangles *rows,
                                        bool has_alphas, const lf_film_layout *layout);
/* Accepts one that is all zero. */
void lf_outlines_finish(lf_outlines *outlines);

/* Zeroed memory for a film's rows: a bit a view pixel. LF_E_NOMEM; *out may then be finished. */
LF_NODISCARD lf_status lf_outline_map_init(lf_outline_map *out, const lf_film_layout *layout);
/* Accepts one that is all zero. */
void lf_outline_map_finish(lf_outline_map *map);

/* Looks for the outlines of a row, at the visit's moment, into worker->met.outlines; true: there
 * are some. Uses both sections of the worker: before the row's plane is cut. What plan->outlines
 * has of the row is not looked for again. */
bool lf_outlines_find(const lf_visit *visit);

/* Planes that a visit takes film points in, itself the first: index is its number in its half of
 * its stream, coarse visits counted. */
int lf_outlines_planes(uint32_t index);

/* The film points of outlines in plane number `plane`, 1 .. lf_outlines_planes - 1, which has been
 * cut and is the visit's; those before it have been taken, the first by lf_unscattered_fan. */
void lf_outlines_take(lf_unscattered *e, int plane);

/* Where plane number `plane` of a visit lies in the row, 0..1; offsets names the sequence. */
float lf_outlines_row(uint64_t offsets, uint32_t index, int plane);
/* Where a column's film point lies in that plane, in pixels from its left, 0..1. */
float lf_outlines_column(uint64_t key, int column, uint32_t index, int plane);
/* Where its point of the lens lies along the plane's chord, 0..1. */
float lf_outlines_lens(uint64_t key, int column, uint32_t index, int plane);

#endif
