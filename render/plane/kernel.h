/* The hot inner loops, behind a table of functions: one file an instruction set, kernel_c.c the
 * oracle that the others must equal bit for bit (same operations in the same order, no
 * contraction). Which is in use base/cpu.h says. Private to render/. */
#ifndef LF_RENDER_KERNEL_H
#define LF_RENDER_KERNEL_H

#include "render/plane/body.h"
#include "render/plane/fan.h"
#include "render/plane/slice.h"
#include "render/scene/look_up.h"
#include "render/transport/lanes/suffix.h"

/* Points of a slice's rays that are held against the grid (correction.h). */
typedef struct lf_probe {
    const lf_slice *slice;
    const lf_volume *volume;
    lf_line line;  /* of the row's plane, at this depth */
    float z, my2;  /* the depth; 1 + my^2 */
    float inverse; /* 1 / density of the points, per unit of Z */
} lf_probe;

typedef struct lf_kernels {
    const char *name;

    /* Adds to tau[n] the optical depths per unit of Z that n rays X(Z) = x0[k] + slope[k] Z meet in
     * a slice between the camera line and z_end[k]; sigma[n] (may be NULL: not wanted) is set to
     * sigma_t of each ray at z_end, the same z_end for all then. n is a multiple of LF_LANES; on
     * every plane X(Z) rises or falls with k (camera positions rise with k, lanes behind the views
     * repeat the last), so that the ends bound the fan. */
    void (*march)(const lf_slice *slice, int n, const float *x0, const float *slope,
                  const float *z_end, float *tau, float *sigma);

    /* march without sigma, with the moments of where the first collision lies: sets *sums[0..2] to
     * the sums over planes of w, w y and w y^2, y the nearness of the plane and w the transmittance
     * that is lost there. exp(-x) of a plane is taken as 1 / (1 + x + x^2/2). */
    void (*moments)(const lf_slice *slice, const lf_feature_rays *rays, float *tau,
                    float *const sums[3]);

    /* march for a homogeneous shape, and with where the first collision lies: sets out[0][n] to
     * about its probability, out[1][n] and out[2][n] to mean and standard deviation of nearness
     * there, 1/Z to second order along the ray's part inside. */
    void (*through)(const lf_body *body, int n, const float *x0, const float *slope,
                    const float *z_end, float *tau);
    void (*within)(const lf_body *body, const lf_feature_rays *rays, float *tau,
                   float *const out[3]);

    /* sigma_t of an interpolated grid at n points of a line, n a multiple of LF_LANES. */
    void (*sample)(const lf_volume *volume, const lf_line *line, int n, const float *x,
                   float *sigma);

    /* factor[n] *= 1 - (sigma - sigma~) length / density of points, for rays as march has them that
     * reach so deep: sigma of the grid where the ray is at the probe's depth, sigma~ what the slice
     * has there. */
    void (*compare)(const lf_probe *probe, int n, const float *x0, const float *slope,
                    const float *z_end, float *factor);

    /* Prefix densities D_k = scale_k exp(-(tau_k - tau_min)), tau_min over lanes with scale_k > 0;
     * all 0 when there is none. Returns their sum, added in the fixed order lane 0..7 of running
     * sums of 8. d may alias scale. */
    float (*densities)(int n, const float *scale, const float *tau, float *d);

    /* Suffixes of many pivots at once. */
    const lf_suffixes *suffixes;

    /* What a pivot on a surface costs. */
    const lf_fans *fans;
} lf_kernels;

extern const lf_kernels lf_kernels_c;
#if defined(__x86_64__)
extern const lf_kernels lf_kernels_avx2, lf_kernels_avx512;
#elif defined(__aarch64__)
extern const lf_kernels lf_kernels_neon;
#endif

/* The table in use. Thread safe. */
const lf_kernels *lf_kernels_get(void);

/* Tables this CPU can run, the oracle first; NULL behind the last. */
const lf_kernels *lf_kernels_at(int index);

#endif
