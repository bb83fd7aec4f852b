/* [-1,1]^3 (shape.h). */
#ifndef LF_RENDER_SHAPE_BOX_H
#define LF_RENDER_SHAPE_BOX_H

#include <stdbool.h>

#include "render/scene/vec.h"

static inline void lf_box_interval(const float o[3], const float d[3], float *from, float *to)
{
    float lo = -INFINITY, hi = INFINITY;
    for (int i = 0; i < 3; i++) {
        /* A ray parallel to faces: from and to are far away on either side, never 0/0. */
        float inverse = 1.0f / (fabsf(d[i]) > 1e-30f ? d[i] : 1e-30f);
        float p = (-1.0f - o[i]) * inverse, q = (1.0f - o[i]) * inverse;
        lo = lf_max(lo, lf_min(p, q));
        hi = lf_min(hi, lf_max(p, q));
    }
    *from = lo;
    *to = hi;
}

static inline bool lf_box_contains(const float p[3])
{
    return fabsf(p[0]) <= 1.0f && fabsf(p[1]) <= 1.0f && fabsf(p[2]) <= 1.0f;
}

static inline double lf_box_reach(const double row[3])
{
    return fabs(row[0]) + fabs(row[1]) + fabs(row[2]);
}

#endif
