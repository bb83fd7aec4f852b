/* Base prefixes and their densities in other views; private to render/. A prefix leads from a film
 * point and a lens point through media to the pivot: a collision, or a point of a surface. A shift
 * copies the pivot and the lens point; the film point follows. Null collisions are shifted by
 * shift.h. */
#ifndef LF_RENDER_PREFIX_H
#define LF_RENDER_PREFIX_H

#include "render/papers/state.h"

/* A base sample and its pivot. */
typedef struct lf_prefix {
    lf_event event;     /* LF_EVENT_ESCAPE: none */
    lf_media_path path; /* from the base's lens to the pivot */
    int row, view, column;
    float alone;         /* weight if only its own pixel receives it */
    double lx, ly;       /* on the lens */
    double x, y, z;      /* the pivot, camera space */
    float my;            /* of its row's plane */
    lf_sampler *sampler; /* continues with the pivot's own dimensions */
} lf_prefix;

/* Draws a prefix in a pixel; *p must have its row, view, column and sampler. Its chain is stored in
 * the worker. */
void lf_prefix_draw(const lf_general *g, lf_general_worker *w, lf_prefix *p);

/* Sets column and to_pivot of all views. */
void lf_prefix_look(const lf_general *g, lf_general_worker *w, const lf_prefix *p);

/* Area at the pivot for an area on the film of a view (lf_shift_area). */
double lf_prefix_area(const lf_general *g, const lf_prefix *p, int view);

/* Whether another view has the pivot in its frame, sees the same side of its surface, and is not
 * occluded. */
bool lf_prefix_visible(const lf_general *g, lf_general_worker *w, const lf_prefix *p, int view);

/* rho of another view that sees the pivot: the density of this prefix in that view over the density
 * in the base. */
double lf_prefix_ratio(const lf_general *g, lf_general_worker *w, const lf_prefix *p, int view);

#endif
