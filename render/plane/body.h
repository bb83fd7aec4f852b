/* A homogeneous shape on one row's plane. Every ray of the row has its interval in closed form,
 * without resampling; private to render/. (docs/developer/estimators.md, "6. Optical depth to all
 * views") */
#ifndef LF_RENDER_BODY_H
#define LF_RENDER_BODY_H

#include "render/plane/rig.h"

typedef struct lf_body {
    lf_volume_kind shape;
    float sigma_t; /* per scene unit */
    /* A ray X(Z) = x0 + slope Z of the row's plane is (origin + x0 across) + (depth + slope across)
     * Z in volume space. */
    float origin[3], across[3], depth[3];
} lf_body;

/* The rays of a row's plane in a volume's space, in the form of lf_body. Returns false if the plane
 * misses the volume. */
bool lf_body_rays(const lf_volume *volume, const lf_rig *rig, const lf_row_plane *plane,
                  float origin[3], float across[3], float depth[3]);

/* Cuts the shape with the row's plane. Returns false if the plane misses it. */
bool lf_body_cut(lf_body *body, const lf_volume *volume, const lf_rig *rig,
                 const lf_row_plane *plane);

/* The part [*from, *to] of Z > 0 of the ray inside the shape; *from >= *to: the ray misses it.
 * Single rays and the kernels' lanes share this code, so that collisions and weights agree bitwise.
 */
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

/* The first collision in a part of optical depth x, in units of the part's length (0..1): mean and
 * variance of the truncated exponential, 1/x - 1/(e^x - 1) and 1/x^2 - e^x/(e^x - 1)^2. Series
 * replace these formulas where they cancel. *met is the probability 1 - e^-x. Error below 1e-3;
 * without branches and calls. */
static inline void lf_body_truncated(float x, float *met, float *mean, float *variance)
{
    float square = x * x, large = lf_max(x, 1.0f), v = large * (1.0f / 16.0f),
          root = 1.0f + v * (1.0f + 0.5f * v), e = root * root;
    e *= e;
    e *= e;
    e = 1.0f / (e * e); /* e^-x, for x >= 1 */
    float inverse = 1.0f / large, lost = 1.0f - e, ratio = e / lost,
          thin = x * (1.0f - x * (0.5f - x * (1.0f / 6.0f - x * (1.0f / 24.0f - x / 120.0f))));
    bool is_thin = x < 1.0f;
    *met = is_thin ? thin : lost;
    *mean = is_thin ? 0.5f - x * (1.0f / 12.0f - square * (1.0f / 720.0f)) : inverse - ratio;
    *variance = is_thin ? 1.0f / 12.0f - square * (1.0f / 240.0f - square * (1.0f / 6048.0f))
                        : inverse * inverse - ratio * (1.0f + ratio);
}

/* Result of lf_body_moments for one ray. */
typedef struct lf_body_met {
    float depth; /* per unit of Z */
    float share, nearness, spread;
} lf_body_met;

static inline lf_body_met lf_body_meet(const lf_body *body, const lf_feature_rays *rays, float x0,
                                       float slope, float z_end, float length)
{
    float from, to, share, mean, variance;
    lf_body_interval(body, x0, slope, &from, &to);
    float inside = lf_max(lf_min(to, z_end) - from, 0.0f), depth = body->sigma_t * inside;
    lf_body_truncated(depth * length, &share, &mean, &variance);
    bool hit = inside > 0.0f;
    float inverse = 1.0f / lf_max(from + inside * mean, 1e-30f), part = inside * inverse,
          y = lf_min(rays->distance * inverse, LF_NEARNESS_MAX), relative = variance * part * part;
    return (lf_body_met){.depth = depth,
                         .share = hit ? share : 0.0f,
                         .nearness = hit ? lf_min(y * (1.0f + relative), LF_NEARNESS_MAX) : 0.0f,
                         .spread = hit ? y * sqrtf(lf_max(relative, 0.0f)) : 0.0f};
}

/* Adds the depths of n rays to tau. This is the kernels' loop, written once and compiled for each
 * instruction set. */
static inline void lf_body_depths(const lf_body *body, int n, const float *restrict x0,
                                  const float *restrict slope, const float *restrict z_end,
                                  float *restrict tau)
{
    /* One loop per shape, with a copy whose shape is constant, so that the compiler vectorises it.
     */
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

/* lf_body_depths together with lf_kernels.within. */
static inline void lf_body_moments(const lf_body *body, const lf_feature_rays *rays,
                                   float *restrict tau, float *const out[3])
{
    const float *restrict x0 = rays->x0, *restrict slope = rays->slope,
                          *restrict z_end = rays->z_end, *restrict length = rays->length;
    float *restrict met = out[0], *restrict nearness = out[1], *restrict spread = out[2];
    const lf_feature_rays of = *rays;
    lf_body known = *body;
    switch (body->shape) {
#define LF_MOMENTS(NAME, name)                                                                     \
    case LF_VOLUME_##NAME:                                                                         \
        known.shape = LF_VOLUME_##NAME;                                                            \
        for (int k = 0; k < of.n; k++) {                                                           \
            const lf_body_met here =                                                               \
                lf_body_meet(&known, &of, x0[k], slope[k], z_end[k], length[k]);                   \
            tau[k] += here.depth;                                                                  \
            met[k] = here.share;                                                                   \
            nearness[k] = here.nearness;                                                           \
            spread[k] = here.spread;                                                               \
        }                                                                                          \
        break;
        LF_VOLUME_SHAPES(LF_MOMENTS)
#undef LF_MOMENTS
    case LF_VOLUME_GRID:
        break;
    }
}

#endif
