/* What is known of a row without sampling paths; private to render/rows. visit.h has what others
 * ask of it (lf_unscattered_row). */
#ifndef LF_RENDER_UNSCATTERED_H
#define LF_RENDER_UNSCATTERED_H

#include "render/rows/visit.h"

/* What the fans of a row share. */
typedef struct lf_unscattered {
    const lf_visit *visit;
    lf_vec3 sky;   /* where it is constant */
    float density; /* of the points of correction weights */
    bool constant, has_alphas;
    bool between; /* the row lies between others where worker->met.smooth says so */
    /* where in their pixels albedo is looked up, columns from the left; and how far that is below
     * the plane, as a slope: four visits look at the middles of a pixel's quarters */
    float quarter, down;
    const bool *only; /* [view] of a column: the others are left as they are; NULL: all of them */
    int plane;        /* of the visit's: outlines.h */
} lf_unscattered;

/* The rays of a column's fan that may meet anything. */
typedef struct lf_unscattered_rays {
    int from, to;   /* lanes of the worker */
    lf_rays rays;   /* the same … */
    lf_lines lines; /* … and once more */
    float off[2];   /* from their slopes to those at which albedo is looked up */
} lf_unscattered_rays;

/* What alpha surfaces and panes do to them (prefix_factor.h): multiplies worker->factor, and finds
 * what is seen of them. */
void lf_unscattered_alphas(const lf_unscattered *e, const lf_unscattered_rays *fan);

/* B, q and features of the views [first, end) in a column, from one film point. */
void lf_unscattered_fan(const lf_unscattered *e, int column, int first, int end);

/* The first group of views of `left` and what follows it without a gap: [*first, *end); false:
 * there is none. They are taken out of *left. */
bool lf_unscattered_next_groups(uint32_t *left, int n_views, int *first, int *end);

/* The sky of a row's rays where it is one; false: each looks for its own. */
bool lf_unscattered_sky(const lf_visit *visit, lf_vec3 *out);

#endif
