/* The position of a subpixel under its lens: one body for the reference (interlace.c) and the
 * kernels of every instruction set. Private to quilt/. */
#ifndef LF_QUILT_KERNEL_PLACE_H
#define LF_QUILT_KERNEL_PLACE_H

#include <math.h>

#include "quilt/kernel/kernel.h"

/* Position across the cone, 0..1, for a phase in lens periods; the clamp is that of
 * lf_view_of_subpixel's sources. */
static inline double lf_place_of(double phase, bool from_right)
{
    double f = phase - floor(phase);
    double z = from_right ? 1 - f : f;
    z = z < 1e-5 ? 1e-5 : z;
    return z > 0.999999 ? 0.999999 : z;
}

static inline double lf_place_at(const lf_places *p, size_t i, size_t of_six)
{
    return lf_place_of((p->across[i] + p->along[of_six]) * p->pitch - p->center, p->from_right) *
           p->n_views;
}

#endif
