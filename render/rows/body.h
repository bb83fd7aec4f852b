/* A homogeneous shape on one row's plane: nothing is resampled, every ray of the row knows its
 * interval in closed form; private to render/. (docs/estimators.md, "Media of a row") */
#ifndef LF_RENDER_BODY_H
#define LF_RENDER_BODY_H

#include "render/rows/rig.h"

typedef struct lf_body {
    lf_volume_kind shape;
    float sigma_t; /* per scene unit */
    /* A ray X(Z) = x0 + slope Z of the row's plane is (origin + x0 across) + (depth + slope across)
     * Z in volume space. */
    float origin[3], across[3], depth[3];
} lf_body;

/* The rays of a row's plane in a volume's space, as lf_body has them. Returns false when the plane
 * misses the volume. */
bool lf_body_rays(const lf_volume *volume, const lf_rig *rig, const lf_row_plane *plane,
                  float origin[3], float across[3], float depth[3]);

/* Cuts the shape with the row's plane. Returns false when the plane misses it. */
bool lf_body_cut(lf_body *body, const lf_volume *volume, const lf_rig *rig,
                 const lf_row_plane *plane);

/* The part [*from, *to] of Z > 0 that the ray spends inside; *from >= *to: it passes by. One piece
 * of code for one ray and for the kernels' lanes, so that collisions and weights agree to the last
 * bit. */
static inline void lf_body_interval(const lf_body *b, float x0, float slope, float *from, float *to)
{
    float o[3], d[3];
    for (int i = 0; i < 3; i++) {
        o[i] = b->origin[i] + x0 * b->across[i];
        d[i] = b->depth[i] + slope * b->across[i];
    }
    lf_shape_interval(b->shape, o, d, from, to);
    *from = lf_max(*from, 0.0f);
}

/* Optical depth per unit of Z up to z_end. */
static inline float lf_body_depth(const lf_body *body, float x0, float slope, float z_end)
{
    float from, to;
    lf_body_interval(body, x0, slope, &from, &to);
    return body->sigma_t * lf_max(lf_min(to, z_end) - from, 0.0f);
}

/* Sets sums as lf_kernels.moments does, for rays of these lengths per unit of Z. Where along its
 * part inside of the shape, of length L and optical depth tau, a ray collides, if it does: the
 * truncated exponential has the mean L (1/tau - 1/(e^tau - 1)) and the variance L^2 (1/tau^2 -
 * e^tau / (e^tau - 1)^2); 1/Z there to second order. */
void lf_body_moments(const lf_body *body, int n, const float *x0, const float *slope,
                     const float *z_end, const float *length, float distance, float *const sums[3]);

/* Adds the depths of n rays to tau: the kernels' loop, here once and compiled for each instruction
 * set. */
static inline void lf_body_depths(const lf_body *body, int n, const float *restrict x0,
                                  const float *restrict slope, const float *restrict z_end,
                                  float *restrict tau)
{
    /* a loop for each shape, with a copy that is known to be one, so that it becomes vector code */
    lf_body known = *body;
    switch (body->shape) {
#define LF_DEPTHS(NAME, name)                                                                      \
    case LF_VOLUME_##NAME:                                                                         \
        known.shape = LF_VOLUME_##NAME;                                                            \
        for (int k = 0; k < n; k++)                                                                \
            tau[k] += lf_body_depth(&known, x0[k], slope[k], z_end[k]);                            \
        break;
        LF_VOLUME_SHAPES(LF_DEPTHS)
#undef LF_DEPTHS
    case LF_VOLUME_GRID:
        break;
    }
}

#endif
