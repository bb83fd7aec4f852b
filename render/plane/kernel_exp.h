/* The exponential of the kernels: one polynomial for every instruction set, so that all give the
 * same bits. */
#ifndef LF_RENDER_KERNEL_EXP_H
#define LF_RENDER_KERNEL_EXP_H

/* exp(x) = 2^i 2^f with i = round(x log2 e); 2^f is the Taylor series of exp(f ln 2) to degree 6,
 * |f| <= 1/2. The relative error is below 2e-7. Weights below exp(LF_EXP_MIN) are set to 0, because
 * they do not change a sum. */
#define LF_EXP_MIN (-60.0f)
#define LF_LOG2E 1.44269504088896341f
#define LF_LN2_HI 0.693359375f
#define LF_LN2_LO (-2.12194440e-4f)
#define LF_EXP_C2 0.5f
#define LF_EXP_C3 1.66666667e-1f
#define LF_EXP_C4 4.16666667e-2f
#define LF_EXP_C5 8.33333333e-3f
#define LF_EXP_C6 1.38888889e-3f

#endif
