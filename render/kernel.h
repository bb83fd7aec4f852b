/* The hot inner loops, behind a table of functions: one file an instruction set, kernel_c.c the oracle that the others must
 * equal bit for bit (same operations in the same order, no contraction). Chosen once, before threads start: the best that
 * the CPU has, or what LF_CPU names ("c", "avx2"). Private to render/. */
#ifndef LF_RENDER_KERNEL_H
#define LF_RENDER_KERNEL_H

#include "render/slice.h"

typedef struct lf_kernels {
    const char *name;

    /* Optical depths per unit of Z of n rays X(Z) = x0[k] + slope[k] Z from the camera line to z_end[k], and sigma_t in the slab where
     * z_end[0] lies (sigma may be NULL). n is a multiple of LF_LANES; x0 and slope are linear in k (lanes behind the
     * views repeat the last), so that the ends bound the fan. tau[n], sigma[n] out. */
    void (*march)(const lf_slice *slice, int n, const float *x0, const float *slope, const float *z_end, float *tau, float *sigma);

    /* Prefix densities D_k = scale_k exp(-(tau_k - tau_min)), tau_min over lanes with scale_k > 0; all 0 when there is none.
     * Returns their sum, added in the fixed order lane 0..7 of running sums of 8. d may alias scale. */
    float (*densities)(int n, const float *scale, const float *tau, float *d);
} lf_kernels;

extern const lf_kernels lf_kernels_c;
#if defined(__x86_64__)
extern const lf_kernels lf_kernels_avx2;
#endif

/* The table in use; the first call chooses. Thread safe. */
const lf_kernels *lf_kernels_get(void);

/* Tables this CPU can run, the oracle first; NULL behind the last. */
const lf_kernels *lf_kernels_at(int index);

#endif
