/* The unit ball (shape.h). */
#ifndef LF_RENDER_SHAPE_SPHERE_H
#define LF_RENDER_SHAPE_SPHERE_H

#include <stdbool.h>

#include "render/scene/vec.h"

static inline void lf_sphere_interval(const float o[3], const float d[3], float *from, float *to)
{
    float a = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    float middle = -(o[0] * d[0] + o[1] * d[1] + o[2] * d[2]) / a;
    float x = o[0] + middle * d[0], y = o[1] + middle * d[1], z = o[2] + middle * d[2];
    float h = sqrtf(lf_max((1.0f - (x * x + y * y + z * z)) / a, 0.0f));
    *from = middle - h;
    *to = middle + h;
}

static inline bool lf_sphere_contains(const float p[3])
{
    return p[0] * p[0] + p[1] * p[1] + p[2] * p[2] <= 1.0f;
}

static inline double lf_sphere_reach(const double row[3])
{
    return sqrt(row[0] * row[0] + row[1] * row[1] + row[2] * row[2]);
}

#endif
