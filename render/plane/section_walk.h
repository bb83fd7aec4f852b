/* Looking for what a section has between a point and the cameras; private to render/rows/. */
#ifndef LF_RENDER_SECTION_WALK_H
#define LF_RENDER_SECTION_WALK_H

#include "render/plane/section.h"

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

/* A question about the point p on the surface `on` (NULL: none), as lf_section_hide gets it; to be
 * narrowed before anything is asked. */
lf_question lf_section_ask(const lf_row_cut *cut, lf_vec3 p, const lf_hit *on, int n,
                           const float *c, float *scale);

#endif
