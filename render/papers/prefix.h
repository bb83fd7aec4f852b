/* Base prefixes and what they are to other views; private to render/. From a film point and a lens
 * point through media to the pivot: a collision, or a point of a surface. Of a shift the pivot and
 * the lens point are copied, the film point follows; null collisions go by shift.h. */
#ifndef LF_RENDER_PREFIX_H
#define LF_RENDER_PREFIX_H

#include "render/papers/state.h"

/* A base sample and the pivot that it has found. */
typedef struct lf_prefix {
    lf_event event;     /* LF_EVENT_ESCAPE: none */
    lf_media_path path; /* from the base's lens to the pivot */
    int row, view, column;
    float alone;         /* what it weighs where only its own pixel receives it */
    double lx, ly;       /* on the lens */
    double x, y, z;      /* the pivot, camera space */
    float my;            /* of its row's plane */
    lf_sampler *sampler; /* goes on with the pivot's own dimensions */
} lf_prefix;

/* Draws one in a pixel; *p has its row, view, column and sampler. The worker's chain is its own.
 */
void lf_prefix_draw(const lf_general *g, lf_general_worker *w, lf_prefix *p);

/* Fills column and to_pivot of all views. */
void lf_prefix_look(const lf_general *g, lf_general_worker *w, const lf_prefix *p);

/* Area at the pivot for an area on the film of a view (lf_shift_area). */
double lf_prefix_area(const lf_general *g, const lf_prefix *p, int view);

/* Whether another view has the pivot in its frame, looks at the same side of its surface, and
 * nothing hides it. */
bool lf_prefix_visible(const lf_general *g, lf_general_worker *w, const lf_prefix *p, int view);

/* rho of another view by which it is visible: how much likelier it would have drawn this prefix. */
double lf_prefix_ratio(const lf_general *g, lf_general_worker *w, const lf_prefix *p, int view);

#endif
