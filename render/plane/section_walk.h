/* Searching a section for segments between a point and the cameras; private to render/plane/. */
#ifndef LF_RENDER_SECTION_WALK_H
#define LF_RENDER_SECTION_WALK_H

#include "render/plane/section.h"

/* A query: the point, the smallest d at which a surface can hide it, and the remaining positions.
 */
typedef struct lf_question {
    float d, s, behind;
    uint32_t on; /* the triangle that contains the point */
    const float *c;
    float *scale;
    int first, last; /* positions outside of these are hidden */
} lf_question;

/* Drops hidden positions at both ends; false: no position is left. */
static inline bool lf_question_narrow(lf_question *q)
{
    while (q->first <= q->last && !(q->scale[q->first] > 0.0f))
        q->first++;
    while (q->first <= q->last && !(q->scale[q->last] > 0.0f))
        q->last--;
    return q->first <= q->last;
}

/* A query about the point p on the surface `on` (NULL: none), with the arguments of
 * lf_section_hide. Narrow it before use. */
lf_question lf_section_ask(const lf_row_cut *cut, lf_vec3 p, const lf_hit *on, int n,
                           const float *c, float *scale);

#endif
