/* The fit of a node: weighted least squares of N/W on features, over the cells around it. */
#include "render/reconstruct/solve.h"

#include <math.h>
#include <string.h>

#include "render/reconstruct/kernel.h"

/* Tent-weighted sums of the 27 cells around one, as seen from its middle. */
static void gather(const lf_reconstruct_kernels *kernels, const lf_lattice *level, int number,
                   const lf_cell *cell, float side, lf_moments sum[2])
{
    memset(sum, 0, 2 * sizeof *sum);
    for (int dv = -1; dv <= 1; dv++) {
        if (number + dv < 0 || number + dv >= level->n_bands)
            continue;
        const lf_band *band = &level->bands[number + dv];
        for (int dz = -1; dz <= 1; dz++) {
            for (int du = -1; du <= 1; du++) {
                int i = lf_band_find(band, cell->u + du, cell->z + dz);
                const float shift[3] = {(float)du * side, (float)dv * side, (float)dz * side},
                            weight = (dv ? 0.5f : 1.0f) * (dz ? 0.5f : 1.0f) * (du ? 0.5f : 1.0f);
                for (int h = 0; h < 2 && i >= 0; h++)
                    kernels->move(&sum[h], &band->cells[i].half[h][h], weight, shift);
            }
        }
    }
}

/* Variances that features are known to, or matter by: below them a slope is not asked for. */
static double floor_of(int feature, double depth, double radiance)
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
    case LF_LIGHT:
        return 1e-3 * radiance * radiance + 1e-30;
    default:
        return 1e-3;
    }
}

/* In place, the lower triangle; false: not positive definite. */
static bool cholesky(double a[LF_FEATURES][LF_FEATURES])
{
    for (int i = 0; i < LF_FEATURES; i++) {
        for (int j = 0; j <= i; j++) {
            double s = a[i][j];
            for (int k = 0; k < j; k++)
                s -= a[i][k] * a[j][k];
            if (i == j && !(s > 1e-12))
                return false;
            a[i][j] = i == j ? sqrt(s) : s / a[j][j];
        }
    }
    return true;
}

static void back_substitute(double a[LF_FEATURES][LF_FEATURES], double x[LF_FEATURES])
{
    for (int i = 0; i < LF_FEATURES; i++) {
        for (int k = 0; k < i; k++)
            x[i] -= a[i][k] * x[k];
        x[i] /= a[i][i];
    }
    for (int i = LF_FEATURES - 1; i >= 0; i--) {
        for (int k = i + 1; k < LF_FEATURES; k++)
            x[i] -= a[k][i] * x[k];
        x[i] /= a[i][i];
    }
}

void lf_solve(const lf_moments *m, double depth, lf_plane out[3])
{
    double mean[LF_FEATURES], scale[LF_FEATURES], a[LF_FEATURES][LF_FEATURES], radiance = 0.0;
    memset(out, 0, 3 * sizeof *out);
    if (!(m->w > 0.0f))
        return;
    double w = 1.0 / (double)m->w, ridge = 4.0 * w + 1e-3;
    for (int c = 0; c < 3; c++)
        radiance += (double)m->n[c] * w / 3.0;
    for (int i = 0; i < LF_FEATURES; i++) {
        mean[i] = (double)m->wf[i] * w;
        double variance = (double)m->wff[i][i] * w - mean[i] * mean[i];
        scale[i] = 1.0 / sqrt(fmax(variance, 0.0) + floor_of(i, depth, radiance));
        for (int j = 0; j <= i; j++)
            a[i][j] = ((double)m->wff[i][j] * w - mean[i] * mean[j]) * scale[i] * scale[j];
        a[i][i] += ridge;
    }
    bool good = cholesky(a);
    for (int c = 0; c < 3; c++) {
        double x[LF_FEATURES], constant = (double)m->n[c] * w;
        for (int i = 0; i < LF_FEATURES; i++)
            x[i] = ((double)m->nf[c][i] * w - constant * mean[i]) * scale[i];
        if (good)
            back_substitute(a, x);
        for (int i = 0; i < LF_FEATURES; i++) {
            double slope = good ? x[i] * scale[i] : 0.0;
            out[c].slope[i] = (float)slope;
            constant -= slope * mean[i];
        }
        out[c].constant = (float)constant;
    }
}

void lf_solve_band(lf_reconstruction *r, int level, int number)
{
    lf_band *band = &r->level[level].bands[number];
    for (int i = 0; i < band->n; i++) {
        lf_cell *cell = &band->cells[i];
        static const float here[3] = {0.0f, 0.0f, 0.0f};
        lf_moments sum[2], both;
        gather(r->kernels, &r->level[level], number, cell, (float)(1 << level), sum);
        both = sum[0];
        r->kernels->move(&both, &sum[1], 1.0f, here);
        const lf_moments *m[LF_VARIANTS] = {&sum[0], &sum[1], &both};
        for (int v = 0; v < LF_VARIANTS; v++) {
            cell->filled[v] = m[v]->w > 0.0f;
            lf_solve(m[v], (double)r->cell_depth, cell->node[v]);
        }
    }
}
