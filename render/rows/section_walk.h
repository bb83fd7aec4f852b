/* Looking for what a section has between a point and the cameras; private to render/rows/. */
#ifndef LF_RENDER_SECTION_WALK_H
#define LF_RENDER_SECTION_WALK_H

#include "render/rows/section.h"

/* What is asked: the point, how far in front of it hiding begins, and the positions that are left.
 */
typedef struct lf_question {
    float d, s, behind;
    uint32_t on; /* the triangle it lies on */
    const float *c;
    float *scale;
    int first, last; /* positions outside of these are hidden */
} lf_question;

/* Takes positions that are hidden off the ends; false: none is left. */
static inline bool lf_question_narrow(lf_question *q)
{
    while (q->first <= q->last && !(q->scale[q->first] > 0.0f))
        q->first++;
    while (q->first <= q->last && !(q->scale[q->last] > 0.0f))
        q->last--;
    return q->first <= q->last;
}

/* Boxes that hide the point from positions between the outermost. The same roundings as below,
 * which rise and fall with what they round: a box spans no less than its segments do, so that no
 * ray slips through between two that share an end. */
static inline void lf_question_meets(const lf_section_node *node, const lf_question *q,
                                     int out[LF_SECTION_WIDE])
{
    float first = q->c[q->first], last = q->c[q->last], behind = q->behind, d = q->d, s = q->s;
    for (int i = 0; i < LF_SECTION_WIDE; i++) {
        float near = lf_max(node->d0[i] - d, behind), far = node->d1[i] - d, s0 = node->s0[i] - s,
              s1 = node->s1[i] - s;
        float lo = s0 / (s0 < 0.0f ? near : far), hi = s1 / (s1 < 0.0f ? far : near);
        out[i] = (far > behind) & (lo <= last) & (hi >= first);
    }
}

/* The positions [lo, hi] that each segment hides the point from; lo > hi: none. No branches, for
 * the compiler's vectors. */
static inline void lf_question_intervals(const lf_section_leaf *leaf, const lf_question *q,
                                         float lo[LF_SECTION_WIDE], float hi[LF_SECTION_WIDE])
{
    float behind = q->behind, d = q->d, s = q->s;
    for (int i = 0; i < LF_SECTION_WIDE; i++) {
        float d0 = leaf->d0[i] - d, d1 = leaf->d1[i] - d, s0 = leaf->s0[i] - s,
              s1 = leaf->s1[i] - s;
        /* where it comes out from behind the point */
        float cut = s0 + (s1 - s0) * ((behind - d0) / (d1 - d0));
        float c0 = (d0 < behind ? cut : s0) / lf_max(d0, behind), c1 = s1 / d1;
        lo[i] = d1 > behind ? lf_min(c0, c1) : INFINITY;
        hi[i] = d1 > behind ? lf_max(c0, c1) : -INFINITY;
    }
    for (int i = 0; i < LF_SECTION_WIDE; i++)
        lo[i] = leaf->triangle[i] == q->on ? INFINITY : lo[i];
}

/* A question about the point p on the surface `on` (NULL: none), as lf_section_hide gets it; to be
 * narrowed before anything is asked. */
lf_question lf_section_ask(const lf_row_triangles *rows, const lf_rig *rig, lf_vec3 p,
                           const lf_hit *on, int n, const float *c, float *scale);

#endif
