/* The spots that a measured crosstalk means. The model is that of the compensation
 * (docs/developer/print-compensation.md): one spot, whose place and ink are fitted; the rest of the
 * kernel is a sum of such spots, one stripe apart. Here the raster is met in all ways alike. */
#include <math.h>
#include <string.h>

#include "quilt/proof/simulate.h"
#include "quilt/proof/simulate_weight.h"

/* Parts of a pixel's kernel; sweeps over the unknown weights of spots; rounds of both fits. */
enum { PARTS = 32, SWEEPS = 200, ROUNDS = 4, MOST = LF_PRINT_CROSSTALK };

typedef struct fit {
    double stripe, pixel, spot; /* mm */
    bool nearest;
    int n;
    double wanted[2 * MOST + 1]; /* from left to right on the print */
    double share[2 * MOST + 1];  /* of spots */
} fit;

/* The light of the stripe that is k stripes to the right, in a spot `place` to the right. */
static double share_of(const fit *f, int k, double place, double ink)
{
    double sum = 0.0, weights = 0.0;
    for (int i = 0; i < PARTS; i++) {
        /* a point and what its pixel holds are in one pixel; a nearest stripe is that of its
         * middle */
        const double part = 2.0 * (i + 0.5) / PARTS - 1.0;
        const double off = f->nearest ? 0.5 * part * f->pixel : part * f->pixel;
        const double weight = f->nearest ? 1.0 : 1.0 - fabs(part);
        const double left = (k - 0.5) * f->stripe - place + off;
        sum += weight * (lf_weight_before(left + f->stripe, f->spot, ink) -
                         lf_weight_before(left, f->spot, ink));
        weights += weight;
    }
    return sum / (weights * f->spot);
}

/* What is left of the kernel by a sum of such spots, one stripe apart. */
static double distance_of(const fit *f, const double at[2])
{
    double one[4 * MOST + 1], sum = 0.0;
    const int n = f->n;
    if (at[1] < 0.0)
        return (double)INFINITY;
    for (int k = -2 * n; k <= 2 * n; k++)
        one[2 * n + k] = share_of(f, k, at[0], at[1]);
    for (int k = -n; k <= n; k++) {
        double off = f->wanted[n + k];
        for (int e = -n; e <= n; e++)
            off -= f->share[n + e] * one[2 * n + k - e];
        sum += off * off;
    }
    return sum;
}

/* Place and ink of the spots that are nearest to the kernel: a search with steps that are halved
 * when none helps. */
static void fit_spot(const fit *f, double at[2])
{
    double best = distance_of(f, at);
    for (double step = 0.25 * f->stripe; step > 0.001 * f->stripe;) {
        double better[2] = {at[0], at[1]};
        for (int way = 0; way < 4; way++) {
            double next[2] = {at[0], at[1]};
            next[way / 2] += way % 2 ? step : -step;
            const double distance = distance_of(f, next);
            if (distance < best) {
                best = distance;
                memcpy(better, next, sizeof better);
            }
        }
        if (better[0] == at[0] && better[1] == at[1])
            step *= 0.5;
        memcpy(at, better, sizeof better);
    }
}

/* Weights of spots, one stripe apart, whose sum is nearest to the kernel; none is below 0. */
static void divide(fit *f, const double at[2])
{
    const int n = f->n;
    double *share = f->share, one[4 * MOST + 1], left[2 * MOST + 1], norm[2 * MOST + 1] = {0},
           sum = 0.0;
    for (int k = -2 * n; k <= 2 * n; k++)
        one[2 * n + k] = share_of(f, k, at[0], at[1]);
    for (int k = -n; k <= n; k++) {
        share[n + k] = k == 0;
        left[n + k] = f->wanted[n + k] - one[2 * n + k];
        for (int e = -n; e <= n; e++)
            norm[n + e] += one[2 * n + k - e] * one[2 * n + k - e];
    }
    for (int i = 0; i < SWEEPS * (2 * n + 1); i++) {
        const int e = i % (2 * n + 1) - n;
        double slope = 0.0;
        for (int k = -n; k <= n; k++)
            slope += left[n + k] * one[2 * n + k - e];
        const double next = fmax(share[n + e] + slope / norm[n + e], 0.0);
        for (int k = -n; k <= n; k++)
            left[n + k] -= (next - share[n + e]) * one[2 * n + k - e];
        share[n + e] = next;
    }
    for (int e = 0; e <= 2 * n; e++)
        sum += share[e];
    for (int e = 0; e <= 2 * n && sum > 0.0; e++)
        share[e] /= sum;
}

void lf_proof_fit_spots(const lf_print *print, double pixel_mm, lf_proof_sheet *sheet)
{
    const lf_print_blur *blur = &print->blur;
    const int n = blur->n_crosstalk;
    fit f = {.stripe = 25.4 / print->lpi /
                       (blur->crosstalk_views > 0 ? blur->crosstalk_views : sheet->n_views),
             .pixel = pixel_mm,
             .nearest = print->stripes == LF_STRIPES_NEAREST,
             .n = n};
    double at[2] = {0.0, 0.0};
    if (n <= 0 || n > MOST || sheet->grid != LF_LENS_LINEAR)
        return;
    f.spot = blur->spot_mm > 0.0 ? blur->spot_mm : 0.5 * f.stripe;
    for (int k = -n; k <= n; k++) /* views run from right to left */
        f.wanted[n + k] = blur->crosstalk[print->reverse ? n + k : n - k];
    f.share[n] = 1.0;
    for (int i = 0; i < ROUNDS; i++) {
        fit_spot(&f, at);
        divide(&f, at);
    }
    sheet->spot_mm = f.spot;
    sheet->ink_mm = at[1];
    sheet->spots.n = 2 * n + 1;
    memcpy(sheet->spots.share, f.share, sizeof f.share);
    for (int k = 0; k <= 2 * n; k++)
        sheet->spots.right_mm[k] = at[0] + (k - n) * f.stripe;
}
