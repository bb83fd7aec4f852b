/* The steps of a visit, one file each (visit_*.c); visit.c calls them in order. Private to
 * render/rows/. */
#ifndef LF_RENDER_VISIT_STEPS_H
#define LF_RENDER_VISIT_STEPS_H

#include "render/rows/visit.h"

static inline bool lf_cancelled(const lf_cancel *cancel)
{
    return cancel && atomic_load_explicit(cancel, memory_order_relaxed);
}

/* ----------------------------------------------------------------------------- visit_views.c -- */

/* A step coprime to n near n times 1 - 1/golden ratio: neighbouring columns take distant views. */
int lf_lattice_step(int n);
/* 1 / step modulo n: view k of column u has rank inverse k - u - start, the rank j that is below
 * `subsets` in the visits that take it. */
int lf_lattice_inverse(int step, int n);

/* ------------------------------------------------------------------------------- visit_cut.c -- */

/* Draws the shutter time of a visit, if the scene moves (lf_visit_plan.moving). */
void lf_visit_set_shutter_time(lf_visit *visit, lf_visit_number number);
/* Draws a plane of a visit (0: its own; else one for outlines), and cuts volumes, meshes and
 * equiangular lights with it. */
void lf_visit_cut(lf_visit *visit, lf_visit_number number, int plane);

/* The number of planes in which a visit finds B and q; index is its number in its half. */
int lf_visit_planes(const lf_visit_plan *plan, int64_t index);

/* ------------------------------------------------------------------------------ visit_base.c -- */

/* A base sample to be taken. */
typedef struct lf_base {
    int view, column;
    float film;       /* position in the pixel, 0..1; < 0: drawn */
    bool native_only; /* follow only its delta lobes and share nothing */
    uint64_t key;     /* of the random numbers of its pixel */
    uint32_t index;   /* number of the sample within key */
} lf_base;

/* Takes a base sample: spreads its pivot over the views, and adds its native samples. */
void lf_base_sample(lf_visit *visit, const lf_base *base);

/* ----------------------------------------------------------------------------- visit_holes.c -- */

/* Fills the holes of a row. First it uses the plane of the current visit (now: its number in its
 * half; < 0: none), which finds most. Then it uses planes of earlier visits, one of which has found
 * scattering there: visits of the pass's stream first, then of other streams. Each sample weighs as
 * much as the half's count so far (docs/developer/estimators.md, "8. Three estimators"). A pixel
 * that only older visits have met counts as dark until a path arrives. The weight of that path is
 * then far above all others. false: cancelled. */
bool lf_fill_holes(lf_visit *visit, int64_t now, const lf_cancel *cancel);

#endif
