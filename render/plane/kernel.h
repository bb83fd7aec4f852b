/* The hot inner loops, as a table of functions: one file per instruction set. kernel_c.c is the
 * reference: the others must give bitwise the same results (same operations in the same order, no
 * contraction). base/cpu.h chooses the table. Private to render/. */
#ifndef LF_RENDER_KERNEL_H
#define LF_RENDER_KERNEL_H

#include "render/plane/body.h"
#include "render/plane/fan.h"
#include "render/plane/slice.h"
#include "render/scene/look_up.h"
#include "render/transport/lanes/suffix.h"
#include "render/transport/surface/surface_fan.h"

/* Points on a slice's rays at which the slice is compared with the grid (correction.h). */
typedef struct lf_probe {
    const lf_slice *slice;
    const lf_volume *volume;
    lf_line line;  /* of the row's plane, at this depth */
    float z, my2;  /* the depth; 1 + my^2 */
    float inverse; /* 1 / density of the points, per unit of Z */
} lf_probe;

typedef struct lf_kernels {
    const char *name;

    /* Adds to tau[n] the optical depths per unit of Z of n rays X(Z) = x0[k] + slope[k] Z in a
     * slice, between the camera line and z_end[k]. If sigma is not NULL, sets sigma[n] to sigma_t
     * of each ray at z_end, which must then be the same for all. The number n is a multiple of
     * LF_LANES. On every plane, X(Z) must be monotonic in k, so that the end rays bound the fan:
     * camera positions increase with k, and lanes after the last view repeat it. */
    void (*march)(const lf_slice *slice, int n, const float *x0, const float *slope,
                  const float *z_end, float *tau, float *sigma);

    /* march without sigma, with moments of the first collision. Sets *sums[0..2] to the sums over
     * planes of w, w y and w y^2, y the nearness of the plane and w the transmittance lost there.
     * exp(-x) of a plane is approximated by 1 / (1 + x + x^2/2). */
    void (*moments)(const lf_slice *slice, const lf_feature_rays *rays, float *tau,
                    float *const sums[3]);

    /* march for a homogeneous shape; `within` also computes moments of the first collision.
     * out[0][n] is approximately its probability. out[1][n] and out[2][n] are mean and standard
     * deviation of its nearness, with 1/Z to second order along the ray's part inside. */
    void (*through)(const lf_body *body, int n, const float *x0, const float *slope,
                    const float *z_end, float *tau);
    void (*within)(const lf_body *body, const lf_feature_rays *rays, float *tau,
                   float *const out[3]);

    /* sigma_t of an interpolated grid at n points of a line, n a multiple of LF_LANES. */
    void (*sample)(const lf_volume *volume, const lf_line *line, int n, const float *x,
                   float *sigma);

    /* factor[n] *= 1 - (sigma - sigma~) length / density of points, for rays as in march that reach
     * the probe's depth. sigma is the grid at that depth on the ray, sigma~ the slice there. */
    void (*compare)(const lf_probe *probe, int n, const float *x0, const float *slope,
                    const float *z_end, float *factor);

    /* Prefix densities D_k = scale_k exp(-(tau_k - tau_min)), tau_min over lanes with scale_k > 0;
     * all 0 if there is no such lane. Returns their sum, added in the fixed order lane 0..7 of
     * running sums of 8. d may alias scale. */
    float (*densities)(int n, const float *scale, const float *tau, float *d);

    /* Suffixes of many pivots at once. */
    const lf_suffixes *suffixes;

    /* Loops for pivots on surfaces. */
    const lf_fans *fans;

    /* Lobes of surfaces for all views. */
    const lf_surface_fans *surfaces;
} lf_kernels;

extern const lf_kernels lf_kernels_c;
#if defined(__x86_64__)
extern const lf_kernels lf_kernels_avx2, lf_kernels_avx512;
#elif defined(__aarch64__)
extern const lf_kernels lf_kernels_neon;
#endif

/* The table in use. Thread safe. */
const lf_kernels *lf_kernels_get(void);

/* Tables that this CPU can run, the reference first; NULL after the last. */
const lf_kernels *lf_kernels_at(int index);

#endif
