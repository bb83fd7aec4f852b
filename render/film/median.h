/* The median of neighbours, which a rare bright one does not move; private to render/. */
#ifndef LF_RENDER_MEDIAN_H
#define LF_RENDER_MEDIAN_H

/* Of a NaN either may come out. */
static inline float lf_least(float a, float b)
{
    return a < b ? a : b;
}

static inline float lf_most(float a, float b)
{
    return a < b ? b : a;
}

/* Of five numbers that are not negative. */
static inline float lf_median_of_five(const float x[5])
{
    float f = lf_most(lf_least(x[0], x[1]), lf_least(x[2], x[3])),
          g = lf_least(lf_most(x[0], x[1]), lf_most(x[2], x[3]));
    return lf_most(lf_least(lf_most(f, g), x[4]), lf_least(f, g));
}

#endif
