/* The coefficients of cv (docs/developer/estimators.md, "8. Three estimators"). */
#include "render/film/tile.h"

#include <math.h>
#include <string.h>

#include "render/film/median.h"

/* Bound of N/W when it is estimated from many pixels: times its own mean. */
#define RATIO_BOUND 2.0

/* Input of a mean of N/W: a half, with W or W', in the columns first to last of a tile. */
typedef struct lf_mean_of {
    int half, first, last;
    bool second;
} lf_mean_of;

/* N, reduced in proportion if N/w exceeds the bound; signed values are unchanged. */
static double below_bound(const lf_sums *s, double w, int c, double ratio)
{
    double n = (double)s->scattered[c];
    return w > 0.0 ? fmin(n, RATIO_BOUND * ratio * w) : n;
}

/* N/W with N of each pixel below a bound from the previous round. A highlight of a few pixels is
 * excluded, also if these have most of W: W above 2 q counts as 2 q, and the divisor of N is at
 * least half of the sum of q. Input: the start value, INFINITY to use all of N. */
static void bounded_ratio(const lf_tile *t, const lf_mean_of *of, int rounds, double ratio[3])
{
    int columns = t->column1 - t->column0, over = columns - of->last + of->first;
    for (int round = 0; round < rounds; round++) {
        double n[3] = {0}, weight = 0.0, q = 0.0;
        for (int i = of->first; i < t->count; i += i % columns < of->last ? 1 : over) {
            const lf_sums *s = &t->pixel[i].half[of->half];
            double w = (double)lf_sums_weight(s, of->second), most = 2.0 * (double)s->q,
                   part = w > most && most > 0.0 ? most / w : 1.0;
            weight += part * w;
            q += (double)s->q;
            for (int c = 0; c < 3; c++)
                n[c] += part * below_bound(s, w, c, ratio[c]);
        }
        weight = fmax(weight, 0.5 * q);
        for (int c = 0; c < 3; c++)
            ratio[c] = weight > 0.0 ? fmax(n[c] / weight, 0.0) : 0.0;
    }
}

enum { RATIO_ROUNDS = 8 };

/* R of the tile by W or W', and how far pixels are from it. */
static double tile_spread(const lf_tile *t, const lf_mean_of *of, double ratio[3])
{
    double spread = 0.0;
    for (int c = 0; c < 3; c++)
        ratio[c] = INFINITY;
    bounded_ratio(t, of, RATIO_ROUNDS, ratio);
    for (int i = 0; i < t->count; i++) {
        const lf_sums *s = &t->pixel[i].half[of->half];
        double w = (double)lf_sums_weight(s, of->second);
        for (int c = 0; c < 3; c++)
            spread += pow(below_bound(s, w, c, ratio[c]) - ratio[c] * w, 2.0);
    }
    return spread;
}

/* R of every pixel: of the tile or of its surroundings, whichever is darker. Too low a value keeps
 * the noise, too high a value adds to it. */
static void read_beta_ratios(const lf_tile *t, int h, lf_beta *beta)
{
    int columns = t->column1 - t->column0;
    lf_mean_of of = {.half = h, .first = 0, .last = columns - 1};
    double tile[2][3], spread = tile_spread(t, &of, tile[0]);
    if (t->film->layout.has_w2) {
        of.second = true;
        of.second = tile_spread(t, &of, tile[1]) < spread;
    }
    const double *whole = tile[of.second];
    for (int column = 0; column < columns; column++) {
        double local[3] = {whole[0], whole[1], whole[2]};
        of.first = column > LF_TILE_BESIDE ? column - LF_TILE_BESIDE : 0;
        of.last = column + LF_TILE_BESIDE < columns ? column + LF_TILE_BESIDE : columns - 1;
        bounded_ratio(t, &of, RATIO_ROUNDS, local);
        for (int i = column; i < t->count; i += columns)
            for (int c = 0; c < 3; c++)
                beta->ratio[i][c] = fmin(whole[c], local[c]);
    }
}

/* Least squares, relative to R. Any coefficients from the other half keep the estimate unbiased;
 * extreme ones only add noise. */
void lf_tile_regress(const lf_tile *t, int h, lf_beta *out)
{
    double a11 = 0.0, a12 = 0.0, a22 = 0.0, y1 = 0.0, y2 = 0.0;
    memset(out->lambda, 0, sizeof out->lambda);
    read_beta_ratios(t, h, out);
    for (int i = 0; i < t->count; i++) {
        const lf_sums *s = &t->pixel[i].half[h];
        for (int c = 0; c < 3; c++) {
            double r = out->ratio[i][c], x1 = r * (double)(s->w - s->q),
                   x2 = r * (double)(s->w2 - s->q),
                   y = below_bound(s, (double)lf_most(s->w, s->w2), c, r) - r * (double)s->q,
                   weight = 1.0 / (r * r + LF_ERROR_EPSILON);
            a11 += weight * x1 * x1;
            a12 += weight * x1 * x2;
            a22 += weight * x2 * x2;
            y1 += weight * x1 * y;
            y2 += weight * x2 * y;
        }
    }
    double det = a11 * a22 - a12 * a12;
    if (t->film->layout.has_w2 && det > 1e-6 * a11 * a22) {
        out->lambda[0] = (a22 * y1 - a12 * y2) / det;
        out->lambda[1] = (a11 * y2 - a12 * y1) / det;
    } else if (a11 > 0.0) {
        out->lambda[0] = y1 / a11;
    }
    /* N falls by at most the controls' prediction, and does not rise. */
    double sum = out->lambda[0] + out->lambda[1], part = sum > 0.0 ? fmin(1.0, 1.0 / sum) : 0.0;
    for (int i = 0; i < 2; i++)
        out->lambda[i] = fmin(fmax(part * out->lambda[i], -1.0), 2.0);
}
