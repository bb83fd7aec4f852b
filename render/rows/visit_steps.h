/* The steps of a visit, a file each (visit_*.c); private to render/rows/. visit.c puts them in
 * order. */
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

/* Draws the moment of a visit of what moves (lf_visit_plan.moment). */
void lf_visit_set_shutter_time(lf_visit *visit, lf_visit_number number);
/* Draws a plane of a visit (0: its own; else one of its outlines), and cuts volumes, meshes and the
 * lights in media with it. */
void lf_visit_cut(lf_visit *visit, lf_visit_number number, int plane);

/* Planes in which a visit finds B and q, at most; index is its number in its half. */
int lf_visit_planes(const lf_visit_plan *plan, int64_t index);

/* ------------------------------------------------------------------------------ visit_base.c -- */

/* A base sample to be taken. */
typedef struct lf_base {
    int view, column;
    float film;       /* where in the pixel, 0..1; < 0: drawn */
    bool native_only; /* its delta lobes are followed, and nothing is shared */
    uint64_t key;     /* of the random numbers of its pixel */
    uint32_t index;   /* which of them */
} lf_base;

/* Takes it: spreads the pivot that it finds over the views, and adds its native samples. */
void lf_base_sample(lf_visit *visit, const lf_base *base);

/* ----------------------------------------------------------------------------- visit_holes.c -- */

/* Fills the holes of a row: in the plane of the visit that has just been (now: its number in its
 * half; < 0: none has), where most are found at once, then in those of earlier visits, one of which
 * has found that something scatters there: of the pass's stream, then of the others. Each sample
 * weighs as much as the half's count so far (docs/developer/estimators.md, "8. Three estimators").
 * What only older visits have met counts as dark until a path arrives, whose weight is beyond
 * comparison. false = cancelled. */
bool lf_fill_holes(lf_visit *visit, int64_t now, const lf_cancel *cancel);

#endif
