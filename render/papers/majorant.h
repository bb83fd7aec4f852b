/* Majorants along a ray: an upper bound of the extinction, constant in sections and 0 between them
 * (Fraboni et al. 2022, equation 6; supplement, equations 5, 6 and 12); private to render/.
 * Majorants of overlapping media add up. Three coordinates along a ray are defined by them, all
 * increasing with the distance t and constant between sections: the depth of traversed medium l(t),
 * the majorant optical depth tau(t), and the primary sample u(t) = 1 - exp(-tau(t)). Everything is
 * in double precision; nothing allocates. */
#ifndef LF_RENDER_MAJORANT_H
#define LF_RENDER_MAJORANT_H

#include "render/papers/papers.h"
#include "render/scene/scene.h"

/* The interval of a medium with this majorant on a ray; begin < end. */
typedef struct lf_span {
    double begin, end, mu;
} lf_span;

#define LF_MAX_SECTIONS (2 * LF_MAX_VOLUMES)

typedef struct lf_majorant_section {
    double begin, end, mu; /* mu > 0 */
    double length, depth;  /* l and tau at its start */
} lf_majorant_section;

typedef struct lf_majorant {
    int n;
    double length, depth;                         /* l and tau at the end of the ray */
    lf_majorant_section section[LF_MAX_SECTIONS]; /* in order */
} lf_majorant;

/* A point inside a section, and the majorant there. */
typedef struct lf_majorant_point {
    double t, mu;
} lf_majorant_point;

/* Makes the majorant of n <= LF_MAX_VOLUMES spans, clipped to 0 <= t <= end. */
void lf_majorant_make(lf_majorant *out, int n, const lf_span *spans, double end);

double lf_majorant_length(const lf_majorant *m, double t);
double lf_majorant_depth(const lf_majorant *m, double t);
/* The inverses; false: the ray has no such point (0 gives the start of the first section). */
bool lf_majorant_at_length(const lf_majorant *m, double length, lf_majorant_point *out);
bool lf_majorant_at_depth(const lf_majorant *m, double depth, lf_majorant_point *out);

#endif
