/* Vectors of three doubles, for results that single precision would lose; private to render/. */
#ifndef LF_RENDER_VEC_DOUBLE_H
#define LF_RENDER_VEC_DOUBLE_H

#include <math.h>

#include "render/scene/vec.h"

#define LF_RADIANS(degrees) ((degrees) * (M_PI / 180.0))

static inline double lf_dot_double(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline double lf_length_double(const double a[3])
{
    return sqrt(lf_dot_double(a, a));
}

static inline lf_vec3 lf_to_vec3(const double v[3])
{
    return lf_v3((float)v[0], (float)v[1], (float)v[2]);
}

/* a - b; out may be one of them. */
static inline void lf_sub_double(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[i] - b[i];
}

/* out is neither a nor b. */
static inline void lf_cross_double(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

#endif
