/* The median of neighbours, which ignores a rare bright one; private to render/. */
#ifndef LF_RENDER_MEDIAN_H
#define LF_RENDER_MEDIAN_H

/* If either is NaN, the result may be either. */
static inline float lf_least(float a, float b)
{
    return a < b ? a : b;
}

static inline float lf_most(float a, float b)
{
    return a < b ? b : a;
}

/* Of five non-negative numbers. */
static inline float lf_median_of_five(const float x[5])
{
    float f = lf_most(lf_least(x[0], x[1]), lf_least(x[2], x[3])),
          g = lf_least(lf_most(x[0], x[1]), lf_most(x[2], x[3]));
    return lf_most(lf_least(lf_most(f, g), x[4]), lf_least(f, g));
}

#endif
