/* Fits in lanes, to be compiled for an instruction set (kernel.h). Loops over lanes have no branch,
 * so that compilers vectorise them. In double; private to render/reconstruct. */
#ifndef LF_RENDER_RECONSTRUCT_SOLVE_LANES_H
#define LF_RENDER_RECONSTRUCT_SOLVE_LANES_H

#include <math.h>

#include "render/reconstruct/kernel.h"

typedef double solve_lanes[LF_SOLVE_LANES];

/* The normal equations of a lane: features centred and scaled to a variance of about 1. */
typedef struct solve_system {
    solve_lanes w; /* 1 over the sum of weights */
    solve_lanes mean[LF_FEATURES], scale[LF_FEATURES];
    /* The lower triangle; then its Cholesky factor. The reciprocal of the factor's diagonal is in
     * `inverse`. */
    solve_lanes a[LF_FEATURES][LF_FEATURES], inverse[LF_FEATURES];
    solve_lanes good; /* 1; 0: not positive definite */
} solve_system;

/* Lower limits of the variances of features: their precision, or the size that matters. A smaller
 * variance gives no slope. */
static inline double solve_floor(int feature, double depth)
{
    switch (feature) {
    case LF_PLACE:
    case LF_ROW:
        return 0.25 / (LF_CELL_SIDE * LF_CELL_SIDE);
    case LF_DEPTH:
    case LF_SPREAD:
        return 1.0 / (depth * depth);
    case LF_VIEW:
        return 2.5e-3;
    case LF_PIVOTS:
        return 1e-4;
    default:
        return 1e-3;
    }
}

/* The lower limit for light is relative to the radiance. */
static inline void solve_scales(const lf_moments *const m[LF_SOLVE_LANES], double depth,
                                solve_system *s)
{
    solve_lanes radiance;
    for (int l = 0; l < LF_SOLVE_LANES; l++) {
        s->w[l] = m[l]->w > 0.0f ? 1.0 / (double)m[l]->w : 0.0;
        s->good[l] = 1.0;
        radiance[l] =
            ((double)m[l]->n[0] + (double)m[l]->n[1] + (double)m[l]->n[2]) * s->w[l] / 3.0;
    }
    for (int i = 0; i < LF_FEATURES; i++) {
        const double least = solve_floor(i, depth), of_light = i == LF_LIGHT ? 1.0 : 0.0;
        for (int l = 0; l < LF_SOLVE_LANES; l++) {
            s->mean[i][l] = (double)m[l]->wf[i] * s->w[l];
            double variance = (double)m[l]->wff[i][i] * s->w[l] - s->mean[i][l] * s->mean[i][l],
                   part = of_light * (radiance[l] * radiance[l]) + (1.0 - of_light);
            variance = variance > 0.0 ? variance : 0.0;
            s->scale[i][l] = 1.0 / sqrt(variance + (least * part + of_light * 1e-30));
        }
    }
}

static inline void solve_matrix(const lf_moments *const m[LF_SOLVE_LANES], solve_system *s)
{
    for (int i = 0; i < LF_FEATURES; i++) {
        for (int j = 0; j <= i; j++)
            for (int l = 0; l < LF_SOLVE_LANES; l++)
                s->a[i][j][l] =
                    ((double)m[l]->wff[j][i] * s->w[l] - s->mean[i][l] * s->mean[j][l]) *
                    s->scale[i][l] * s->scale[j][l];
        for (int l = 0; l < LF_SOLVE_LANES; l++)
            s->a[i][i][l] += 4.0 * s->w[l] + 1e-3;
    }
}

static inline void solve_factor(solve_system *s)
{
    for (int i = 0; i < LF_FEATURES; i++) {
        for (int j = 0; j <= i; j++) {
            solve_lanes sum;
            for (int l = 0; l < LF_SOLVE_LANES; l++)
                sum[l] = s->a[i][j][l];
            for (int k = 0; k < j; k++)
                for (int l = 0; l < LF_SOLVE_LANES; l++)
                    sum[l] -= s->a[i][k][l] * s->a[j][k][l];
            for (int l = 0; l < LF_SOLVE_LANES && j < i; l++)
                s->a[i][j][l] = sum[l] * s->inverse[j][l];
            for (int l = 0; l < LF_SOLVE_LANES && j == i; l++) {
                const double definite = sum[l] > 1e-12 ? 1.0 : 0.0;
                s->good[l] *= definite;
                s->inverse[i][l] = 1.0 / sqrt(sum[l] > 1e-12 ? sum[l] : 1.0);
            }
        }
    }
}

static inline void solve_back(const solve_system *s, solve_lanes x[LF_FEATURES])
{
    for (int i = 0; i < LF_FEATURES; i++) {
        for (int k = 0; k < i; k++)
            for (int l = 0; l < LF_SOLVE_LANES; l++)
                x[i][l] -= s->a[i][k][l] * x[k][l];
        for (int l = 0; l < LF_SOLVE_LANES; l++)
            x[i][l] *= s->inverse[i][l];
    }
    for (int i = LF_FEATURES - 1; i >= 0; i--) {
        for (int k = i + 1; k < LF_FEATURES; k++)
            for (int l = 0; l < LF_SOLVE_LANES; l++)
                x[i][l] -= s->a[k][i][l] * x[k][l];
        for (int l = 0; l < LF_SOLVE_LANES; l++)
            x[i][l] *= s->inverse[i][l];
    }
}

/* One channel's plane; only the constant if there is no factor. */
static inline void solve_channel(const lf_moments *const m[LF_SOLVE_LANES], const solve_system *s,
                                 int c, lf_plane (*const out[LF_SOLVE_LANES])[3])
{
    solve_lanes x[LF_FEATURES], constant;
    for (int l = 0; l < LF_SOLVE_LANES; l++)
        constant[l] = (double)m[l]->n[c] * s->w[l];
    for (int i = 0; i < LF_FEATURES; i++)
        for (int l = 0; l < LF_SOLVE_LANES; l++)
            x[i][l] =
                ((double)m[l]->nf[c][i] * s->w[l] - constant[l] * s->mean[i][l]) * s->scale[i][l];
    solve_back(s, x);
    for (int i = 0; i < LF_FEATURES; i++) {
        for (int l = 0; l < LF_SOLVE_LANES; l++) {
            x[i][l] = s->good[l] > 0.0 ? x[i][l] * s->scale[i][l] : 0.0;
            constant[l] -= x[i][l] * s->mean[i][l];
        }
        for (int l = 0; l < LF_SOLVE_LANES; l++)
            (*out[l])[c].slope[i] = (float)x[i][l];
    }
    for (int l = 0; l < LF_SOLVE_LANES; l++)
        (*out[l])[c].constant = (float)constant[l];
}

static void solve(const lf_moments *const m[LF_SOLVE_LANES], double depth,
                  lf_plane (*const out[LF_SOLVE_LANES])[3])
{
    solve_system s;
    solve_scales(m, depth, &s);
    solve_matrix(m, &s);
    solve_factor(&s);
    for (int c = 0; c < 3; c++)
        solve_channel(m, &s, c, out);
}

#endif
