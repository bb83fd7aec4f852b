/* Majorants along a ray: an upper bound of the extinction that is constant in sections and 0
 * between them (Fraboni et al. 2022, equation 6; supplement, equations 5, 6 and 12); private to
 * render/. Where media overlap their majorants add up. Three coordinates along a ray go by them,
 * all rising with the distance t and at rest between sections: the depth of traversed medium l(t),
 * the majorant optical depth tau(t), and the primary sample u(t) = 1 - exp(-tau(t)). Everything is
 * double precision; nothing allocates. */
#ifndef LF_RENDER_MAJORANT_H
#define LF_RENDER_MAJORANT_H

#include "render/papers/papers.h"
#include "render/scene/scene.h"

/* Where a medium with this majorant lies on a ray; begin < end. */
typedef struct lf_span {
    double begin, end, mu;
} lf_span;

#define LF_MAX_SECTIONS (2 * LF_MAX_VOLUMES)

typedef struct lf_majorant_section {
    double begin, end, mu; /* mu > 0 */
    double length, depth;  /* l and tau where it begins */
} lf_majorant_section;

typedef struct lf_majorant {
    int n;
    double length, depth;                         /* l and tau where the ray ends */
    lf_majorant_section section[LF_MAX_SECTIONS]; /* one behind the other */
} lf_majorant;

/* A point inside a section, and the majorant there. */
typedef struct lf_majorant_point {
    double t, mu;
} lf_majorant_point;

/* Of n <= LF_MAX_VOLUMES spans, as far as they lie in 0 <= t <= end. */
void lf_majorant_make(lf_majorant *out, int n, const lf_span *spans, double end);

double lf_majorant_length(const lf_majorant *m, double t);
double lf_majorant_depth(const lf_majorant *m, double t);
/* The inverses; false: the ray has no such point (that of 0 is where the first section begins). */
bool lf_majorant_at_length(const lf_majorant *m, double length, lf_majorant_point *out);
bool lf_majorant_at_depth(const lf_majorant *m, double depth, lf_majorant_point *out);

#endif
