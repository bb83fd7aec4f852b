/* The table of shifts, and the weights of chains for any of them. */
#include "render/papers/shift.h"

#include "render/scene/vec_double.h"

static const lf_shift *const table[] = {&lf_shift_optical_stretch, &lf_shift_optical_copy,
                                        &lf_shift_raw_stretch,     &lf_shift_raw_copy,
                                        &lf_shift_primary_stretch, &lf_shift_primary_copy};
#define N_SHIFTS (int)(sizeof table / sizeof table[0])

const lf_shift *lf_shift_at(int index)
{
    return index >= 0 && index < N_SHIFTS ? table[index] : NULL;
}

const char *lf_shift_name(int shift)
{
    return lf_shift_at(shift) ? lf_shift_at(shift)->name : NULL;
}

double lf_shift_ratio(const lf_shift *shift, const lf_majorant *from, const lf_majorant *to, int n,
                      const lf_null *nulls, lf_extinction_fn extinction, void *target)
{
    double log_ratio = from->depth - to->depth;
    for (int q = 0; q < n; q++) {
        lf_majorant_point p;
        double jacobian;
        if (!shift->map(from, to, nulls[q].at, &p, &jacobian))
            return 0.0;
        double left = p.mu - extinction(target, p.t);
        if (!(left > 0.0 && jacobian > 0.0))
            return 0.0;
        log_ratio += log(jacobian * left / (nulls[q].at.mu - nulls[q].extinction));
    }
    return exp(log_ratio);
}

static double facing(const double from[3], const double to[3], const double *normal)
{
    double d[3];
    lf_sub_double(to, from, d);
    double length = lf_length_double(d),
           cosine = normal ? fabs(lf_dot_double(d, normal)) / length : 1.0;
    return cosine / (length * length);
}

double lf_shift_area(const double lens[3], const double film[3], const double axis[3],
                     const double pivot[3], const double *normal)
{
    return facing(lens, film, axis) / facing(lens, pivot, normal);
}
