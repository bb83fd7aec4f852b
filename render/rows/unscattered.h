/* Unscattered light of a row, which is known without sampling paths; private to render/rows.
 * visit.h declares the functions for other files (lf_unscattered_row). */
#ifndef LF_RENDER_UNSCATTERED_H
#define LF_RENDER_UNSCATTERED_H

#include "render/rows/visit.h"

/* Data that all fans of a row share. */
typedef struct lf_unscattered {
    const lf_visit *visit;
    lf_vec3 sky;   /* if it is constant */
    float density; /* point density for correction weights */
    bool constant, has_alphas;
    bool between; /* the row lies between others, where worker->met.smooth says so */
    /* Where in the pixel albedo is looked up: columns from its left, and the slope below the plane.
     * Four visits use the centres of a pixel's quarters. */
    float quarter, down;
    const bool *only; /* [view] of a column: views to compute; NULL: all of them */
    int plane;        /* number of the visit's current plane: outlines.h */
} lf_unscattered;

/* The rays of a column's fan that may meet anything. */
typedef struct lf_unscattered_rays {
    int from, to;   /* lanes of the worker */
    lf_rays rays;   /* the same rays … */
    lf_lines lines; /* … and once more, as lines */
    float off[2];   /* from their slopes to the slopes at which albedo is looked up */
} lf_unscattered_rays;

/* Applies alpha surfaces and thin glass to the rays (prefix_factor.h): multiplies worker->factor,
 * and finds their features. */
void lf_unscattered_alphas(const lf_unscattered *e, const lf_unscattered_rays *fan);

/* B, q and features of the views [first, end) in a column, from one film point. */
void lf_unscattered_fan(const lf_unscattered *e, int column, int first, int end);

/* Takes the first run of adjacent view groups out of *left and returns their views, [*first, *end).
 * false: *left is empty. */
bool lf_unscattered_next_groups(uint32_t *left, int n_views, int *first, int *end);

/* The sky of a row's rays if it is constant; false: each ray evaluates its own. */
bool lf_unscattered_sky(const lf_visit *visit, lf_vec3 *out);

#endif
