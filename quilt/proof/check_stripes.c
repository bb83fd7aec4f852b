#include "quilt/proof/check_stripes.h"

#include <math.h>
#include <string.h>

/* Of borders, in stripes: prints.h has them half-open, and rounding stays far below. */
#define ON_BORDER 1e-9
/* A stripe with a smaller share of a pixel is not seen in it. */
#define LEAST_SHARE 1e-7

double lf_check_stripe_at(const lf_check_stripes *stripes, double edge, double moved_mm)
{
    const double x = (edge - 0.5 * stripes->n) * stripes->pixel_mm - stripes->phase_mm - moved_mm;
    return stripes->n_views * (x / stripes->pitch_mm + 0.5);
}

double lf_check_stripe_px(const lf_check_stripes *stripes)
{
    return stripes->pitch_mm / stripes->n_views / stripes->pixel_mm;
}

/* Equal stripes must have equal codes: the sum of squared deviations from each stripe's mean. */
static double misfit_nearest(const lf_check_stripes *stripes, const lf_check_line *line,
                             const lf_check_block *block, double moved_mm, double *out_freedom)
{
    double misfit = 0.0;
    *out_freedom = 0.0;
    for (int j = block->first; j < block->end;) {
        const double stripe = floor(lf_check_stripe_at(stripes, j + 0.5, moved_mm) + ON_BORDER);
        int end = j + 1;
        while (end < block->end &&
               floor(lf_check_stripe_at(stripes, end + 0.5, moved_mm) + ON_BORDER) == stripe)
            end++;
        for (int c = 0; c < line->channels && end - j > 1; c++) {
            const double *value = line->value + (size_t)c;
            double sum = 0.0;
            for (int i = j; i < end; i++)
                sum += value[(size_t)i * (size_t)line->channels];
            for (int i = j; i < end; i++) {
                const double off = value[(size_t)i * (size_t)line->channels] - sum / (end - j);
                misfit += off * off;
            }
            *out_freedom += end - j - 1;
        }
        j = end;
    }
    return misfit;
}

/* Where a pixel lies: its first stripe, counted within the block, and the share of that stripe. */
typedef struct pixel_shares {
    int stripe;
    double first; /* the next stripe has the rest */
} pixel_shares;

static pixel_shares shares_of(const lf_check_stripes *stripes, int j, double moved_mm,
                              double origin)
{
    const double left = lf_check_stripe_at(stripes, j, moved_mm),
                 right = lf_check_stripe_at(stripes, j + 1.0, moved_mm);
    const double stripe = floor(left), border = stripe + 1.0;
    const double rest = right > border ? (right - border) / (right - left) : 0.0;
    if (rest < LEAST_SHARE)
        return (pixel_shares){(int)(stripe - origin), 1.0};
    if (rest > 1.0 - LEAST_SHARE)
        return (pixel_shares){(int)(stripe - origin) + 1, 1.0};
    return (pixel_shares){(int)(stripe - origin), 1.0 - rest};
}

/* Solves the tridiagonal system of the normal equations in place: stripe[t]. */
static int solve(int n, double *diagonal, const double *beside, double *right, double *stripe)
{
    int rank = 0;
    for (int t = 0; t < n; t++) {
        const double before =
            t > 0 && diagonal[t - 1] > 0.0 ? beside[t - 1] / diagonal[t - 1] : 0.0;
        if (t > 0) {
            diagonal[t] -= before * beside[t - 1];
            right[t] -= before * right[t - 1];
        }
        rank += diagonal[t] > 0.0;
    }
    for (int t = n - 1; t >= 0; t--) {
        const double next = t + 1 < n ? beside[t] * stripe[t + 1] : 0.0;
        stripe[t] = diagonal[t] > 0.0 ? (right[t] - next) / diagonal[t] : 0.0;
    }
    return rank;
}

/* Pixels are at most a stripe wide, so that each touches two neighbouring stripes at most, and the
 * normal equations are tridiagonal. */
static double misfit_of_channel(const lf_check_stripes *stripes, const lf_check_line *line, int c,
                                const lf_check_block *block, double moved_mm, double *scratch,
                                double *out_freedom)
{
    const double origin = floor(lf_check_stripe_at(stripes, block->first, moved_mm));
    const int room = block->end - block->first + 4;
    double *diagonal = scratch, *beside = scratch + room, *right = scratch + 2 * room,
           *stripe = scratch + 3 * room;
    int n = 0;
    double misfit = 0.0;
    memset(scratch, 0, 4 * (size_t)room * sizeof *scratch);
    for (int j = block->first; j < block->end; j++) {
        const pixel_shares at = shares_of(stripes, j, moved_mm, origin);
        const size_t i = (size_t)j * (size_t)line->channels + (size_t)c;
        const double weight = 1.0 / (line->sigma[i] * line->sigma[i]), rest = 1.0 - at.first;
        const int t = at.stripe;
        diagonal[t] += at.first * at.first * weight;
        right[t] += at.first * line->value[i] * weight;
        n = t + 1 > n ? t + 1 : n;
        if (rest > 0.0) {
            diagonal[t + 1] += rest * rest * weight;
            right[t + 1] += rest * line->value[i] * weight;
            beside[t] += at.first * rest * weight;
            n = t + 2 > n ? t + 2 : n;
        }
    }
    *out_freedom += block->end - block->first - solve(n, diagonal, beside, right, stripe);
    for (int j = block->first; j < block->end; j++) {
        const pixel_shares at = shares_of(stripes, j, moved_mm, origin);
        const size_t i = (size_t)j * (size_t)line->channels + (size_t)c;
        const double fitted =
            at.first * stripe[at.stripe] + (1.0 - at.first) * stripe[at.stripe + 1];
        const double off = (line->value[i] - fitted) / line->sigma[i];
        misfit += off * off;
    }
    return misfit;
}

double lf_check_misfit(const lf_check_stripes *stripes, const lf_check_line *line,
                       const lf_check_block *block, double moved_mm, double *scratch,
                       double *out_freedom)
{
    double misfit = 0.0;
    if (stripes->nearest)
        return misfit_nearest(stripes, line, block, moved_mm, out_freedom);
    *out_freedom = 0.0;
    for (int c = 0; c < line->channels; c++)
        misfit += misfit_of_channel(stripes, line, c, block, moved_mm, scratch, out_freedom);
    return misfit;
}
