/* By the majorant optical depth. */
#include "render/papers/shift.h"

static bool copy(const lf_majorant *from, const lf_majorant *to, lf_majorant_point p,
                 lf_majorant_point *out, double *out_jacobian)
{
    if (!lf_majorant_at_depth(to, lf_majorant_depth(from, p.t), out))
        return false;
    *out_jacobian = p.mu / out->mu;
    return true;
}

static bool stretch(const lf_majorant *from, const lf_majorant *to, lf_majorant_point p,
                    lf_majorant_point *out, double *out_jacobian)
{
    /* a point that rounding puts beyond the end is at the end */
    double share = fmin(lf_majorant_depth(from, p.t) / from->depth, 1.0);
    if (!lf_majorant_at_depth(to, share * to->depth, out))
        return false;
    *out_jacobian = to->depth / from->depth * (p.mu / out->mu);
    return true;
}

const lf_shift lf_shift_optical_copy = {"optical-copy", copy};
const lf_shift lf_shift_optical_stretch = {"optical-stretch", stretch};
