#include "quilt/proof/check_stripes.h"

#include <math.h>
#include <string.h>

/* Of borders, in stripes: prints.h has them half-open, and rounding stays far below. */
#define ON_BORDER 1e-9
/* A stripe with a smaller share of a pixel is not seen in it. */
#define LEAST_SHARE 1e-7

lf_check_stripes lf_check_stripes_of(const lf_print *print, const double dpi[2], int n)
{
    const double slant = print->optics.slant * acos(-1.0) / 180.0;
    const int across = print->horizontal ? 1 : 0;
    lf_check_stripes out = {.n = n,
                            .n_views = print->n_views,
                            .pixel_mm = 25.4 / dpi[across],
                            .pitch_mm = 25.4 / print->lpi,
                            .phase_mm = print->phase_mm,
                            .nearest = print->stripes == LF_STRIPES_NEAREST,
                            .cosine = cos(slant),
                            .lean = print->horizontal ? -sin(slant) : sin(slant),
                            .along_pixel_mm = 25.4 / dpi[1 - across]};
    if (lf_print_is_exact(print)) {
        out.thickness_mm = print->optics.thickness_mm;
        out.index = lf_optics_index(&print->optics);
        out.distance_mm = print->optics.distance_mm;
    }
    return out;
}

/* By how much a place of the print is drawn to the middle on its way to the lenses, by Snell's law
 * for the ray that the eye sends there. Each step leaves about t / (n D) of the error. */
static double drawn_in(const lf_check_stripes *stripes, double radius_mm)
{
    double r = radius_mm;
    if (!(radius_mm > 0.0))
        return 1.0;
    for (int i = 0; i < 40; i++) {
        const double inside = asin(sin(atan(r / stripes->distance_mm)) / stripes->index);
        const double next = radius_mm - stripes->thickness_mm * tan(inside);
        const double step = next - r;
        r = next;
        if (fabs(step) < 1e-11)
            break;
    }
    return r / radius_mm;
}

double lf_check_stripe_at(const lf_check_stripes *stripes, double edge, double moved_mm)
{
    const double across = (edge - 0.5 * stripes->n) * stripes->pixel_mm;
    double x = across * stripes->cosine + stripes->along_mm * stripes->lean;
    if (stripes->thickness_mm > 0.0) /* the lenses are finer than their lines on the print */
        x *= drawn_in(stripes, hypot(across, stripes->along_mm)) *
             (1.0 + stripes->thickness_mm / (stripes->index * stripes->distance_mm));
    return stripes->n_views * ((x - stripes->phase_mm - moved_mm) / stripes->pitch_mm + 0.5);
}

double lf_check_stripe_px(const lf_check_stripes *stripes)
{
    return stripes->pitch_mm / stripes->n_views / (stripes->pixel_mm * stripes->cosine);
}

/* Half of the stripes that a pixel covers by its extent across and along the lenses. */
static void halves(const lf_check_stripes *stripes, double *out_wide, double *out_narrow)
{
    const double stripe_mm = stripes->pitch_mm / stripes->n_views;
    const double a = 0.5 * stripes->pixel_mm * fabs(stripes->cosine) / stripe_mm,
                 b = 0.5 * stripes->along_pixel_mm * fabs(stripes->lean) / stripe_mm;
    *out_wide = fmax(a, b);
    *out_narrow = fmin(a, b);
}

double lf_check_stripe_reach(const lf_check_stripes *stripes)
{
    double wide, narrow;
    halves(stripes, &wide, &narrow);
    return 2.0 * (wide + narrow);
}

double lf_check_stripe_share(const lf_check_stripes *stripes, double distance)
{
    double wide, narrow;
    halves(stripes, &wide, &narrow);
    const double beyond = wide + narrow - fabs(distance);
    if (beyond <= 0.0)
        return distance < 0.0 ? 0.0 : 1.0;
    if (beyond >= 2.0 * narrow) /* the border crosses both long sides */
        return 0.5 + 0.5 * distance / wide;
    const double corner = beyond * beyond / (8.0 * wide * narrow);
    return distance < 0.0 ? corner : 1.0 - corner;
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

/* Where the pixels of a block lie. */
typedef struct pixel_shares {
    int n_stripes;
    double *stripe; /* [pixels] its first stripe, counted within the block */
    double *first;  /* [pixels] share of that stripe; the next one has the rest */
} pixel_shares;

static pixel_shares shares_of(const lf_check_stripes *stripes, const lf_check_block *block,
                              double moved_mm, double *scratch)
{
    const int n = block->end - block->first;
    pixel_shares out = {0};
    out.stripe = scratch;
    out.first = scratch + n;
    const double half = 0.5 * lf_check_stripe_reach(stripes);
    const double origin = floor(lf_check_stripe_at(stripes, block->first + 0.5, moved_mm) - half);
    for (int i = 0; i < n; i++) {
        const double middle = lf_check_stripe_at(stripes, block->first + i + 0.5, moved_mm);
        const double stripe = floor(middle - half);
        const double own = lf_check_stripe_share(stripes, stripe + 1.0 - middle);
        const bool last = own < LEAST_SHARE; /* all of it lies in the next stripe */
        out.stripe[i] = stripe - origin + (last ? 1.0 : 0.0);
        out.first[i] = last || own > 1.0 - LEAST_SHARE ? 1.0 : own;
    }
    out.n_stripes = (int)out.stripe[n - 1] + (out.first[n - 1] < 1.0 ? 2 : 1);
    return out;
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
static double misfit_of_channel(const lf_check_line *line, int c, const lf_check_block *block,
                                const pixel_shares *shares, double *scratch, double *out_freedom)
{
    const int n = block->end - block->first, room = n + 4;
    double *diagonal = scratch, *beside = scratch + room, *right = scratch + 2 * room,
           *stripe = scratch + 3 * room;
    const size_t first = (size_t)block->first * (size_t)line->channels + (size_t)c;
    double misfit = 0.0;
    memset(scratch, 0, 4 * (size_t)room * sizeof *scratch);
    for (int i = 0; i < n; i++) {
        const size_t at = first + (size_t)i * (size_t)line->channels;
        const double weight = 1.0 / (line->sigma[at] * line->sigma[at]);
        const double own = shares->first[i], rest = 1.0 - own, value = line->value[at] * weight;
        const int t = (int)shares->stripe[i];
        diagonal[t] += own * own * weight;
        right[t] += own * value;
        diagonal[t + 1] += rest * rest * weight;
        right[t + 1] += rest * value;
        beside[t] += own * rest * weight;
    }
    *out_freedom += n - solve(shares->n_stripes, diagonal, beside, right, stripe);
    for (int i = 0; i < n; i++) {
        const size_t at = first + (size_t)i * (size_t)line->channels;
        const int t = (int)shares->stripe[i];
        const double own = shares->first[i], fitted = own * stripe[t] + (1.0 - own) * stripe[t + 1];
        const double off = (line->value[at] - fitted) / line->sigma[at];
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
    const pixel_shares shares = shares_of(stripes, block, moved_mm, scratch);
    double *rest = scratch + 2 * (size_t)(block->end - block->first);
    *out_freedom = 0.0;
    for (int c = 0; c < line->channels; c++)
        misfit += misfit_of_channel(line, c, block, &shares, rest, out_freedom);
    return misfit;
}
