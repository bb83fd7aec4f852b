/* By the primary sample, u = 1 - exp(-tau). */
#include "render/papers/shift.h"

/* Equal u means equal tau. */
static bool copy(const lf_majorant *from, const lf_majorant *to, lf_majorant_point p,
                 lf_majorant_point *out, double *out_jacobian)
{
    return lf_shift_optical_copy.map(from, to, p, out, out_jacobian);
}

/* tau' = -log(1 - C u). If C u is near 1, its distance from 1 is lost. With a = tau, b = tau_max
 * and b' = tau'_max this distance is (e^-a (1 - e^-(b-a)) + e^-b' (1 - e^-a)) / (1 - e^-b), with
 * the larger exponential factored out. */
static double stretched(double a, double b, double to)
{
    double c_u = expm1(-to) / expm1(-b) * -expm1(-a);
    if (c_u < 0.5)
        return -log1p(-c_u);
    double least = fmin(a, to);
    double sum = exp(least - a) * -expm1(a - b) + exp(least - to) * -expm1(-a);
    return least - log(sum) + log(-expm1(-b));
}

static bool stretch(const lf_majorant *from, const lf_majorant *to, lf_majorant_point p,
                    lf_majorant_point *out, double *out_jacobian)
{
    /* a point that rounding puts beyond the end is at the end */
    double depth = fmin(lf_majorant_depth(from, p.t), from->depth),
           there = fmin(stretched(depth, from->depth, to->depth), to->depth);
    if (!lf_majorant_at_depth(to, fmax(there, 0.0), out))
        return false;
    *out_jacobian = expm1(-to->depth) / expm1(-from->depth) * exp(there - depth) * (p.mu / out->mu);
    return true;
}

const lf_shift lf_shift_primary_copy = {"primary-copy", copy};
const lf_shift lf_shift_primary_stretch = {"primary-stretch", stretch};
