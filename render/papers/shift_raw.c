/* By the depth of traversed medium. */
#include "render/papers/shift.h"

static bool copy(const lf_majorant *from, const lf_majorant *to, lf_majorant_point p,
                 lf_majorant_point *out, double *out_jacobian)
{
    *out_jacobian = 1.0;
    return lf_majorant_at_length(to, lf_majorant_length(from, p.t), out);
}

static bool stretch(const lf_majorant *from, const lf_majorant *to, lf_majorant_point p,
                    lf_majorant_point *out, double *out_jacobian)
{
    /* a point that rounding puts beyond the end is at the end */
    double share = fmin(lf_majorant_length(from, p.t) / from->length, 1.0);
    *out_jacobian = to->length / from->length;
    return lf_majorant_at_length(to, share * to->length, out);
}

const lf_shift lf_shift_raw_copy = {"raw-copy", copy};
const lf_shift lf_shift_raw_stretch = {"raw-stretch", stretch};
