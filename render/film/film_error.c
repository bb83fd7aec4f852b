/* The error of the image, from its rows (docs/developer/estimators.md, "10. The error estimate").
 * Views share paths, and pixels of a row share an offset; only the rows and the halves are
 * independent. */
#include <math.h>

#include "render/film/film.h"

/* Upper quantile of the normal distribution (Newton's method on the error function). */
static double normal_quantile(double alpha)
{
    double z = sqrt(-2.0 * log(alpha));
    for (int i = 0; i < 60; i++)
        z += (0.5 * erfc(z / sqrt(2.0)) - alpha) * sqrt(2.0 * M_PI) * exp(0.5 * z * z) *
             (i < 4 ? 0.5 : 1.0);
    return z;
}

/* Fisher and Cornish's expansion around the normal distribution; below 5 a line in 1/freedom from
 * there to the closed form at 2. */
double lf_upper_quantile(double alpha, double freedom)
{
    if (freedom < 5.0) {
        double two = (1.0 - 2.0 * alpha) * sqrt(0.5 / (alpha * (1.0 - alpha))),
               share = (1.0 / freedom - 0.2) / 0.3;
        return share * two + (1.0 - share) * lf_upper_quantile(alpha, 5.0);
    }
    double z = normal_quantile(alpha), z2 = z * z, f = 1.0 / freedom;
    double g1 = (z2 + 1.0) * z / 4.0;
    double g2 = ((5.0 * z2 + 16.0) * z2 + 3.0) * z / 96.0;
    double g3 = (((3.0 * z2 + 19.0) * z2 + 17.0) * z2 - 15.0) * z / 384.0;
    return z + f * (g1 + f * (g2 + f * g3));
}

/* Variance of the logarithm of a gamma variable of this shape. */
static double trigamma(double x)
{
    double sum = 0.0;
    for (; x < 6.0; x += 1.0)
        sum += 1.0 / (x * x);
    return sum + 1.0 / x + 1.0 / (2.0 * x * x) + 1.0 / (6.0 * x * x * x) -
           1.0 / (30.0 * pow(x, 5.0));
}

/* Variance of R squared, relative to the relMSE of one estimate: 4 times the variance of R, and
 * pi/2 from the mean magnitude of a normal difference to its mean square. R is a median of five,
 * clamped to the range of the pixel's two halves (resolve.c: steady_radiance). For normal estimates
 * of variance 1 this has 0.510, and 0.325 weighted by the squared difference of the halves, as
 * errors weight it (by Monte Carlo). The value used lies between, because noise is not normal;
 * 0.325 would lower bounds by some per cent. */
#define SCALE_VARIANCE (4.0 * 0.449 * M_PI / 2.0)

/* Standard deviation of the logarithm of the error in pixels whose halves disagree about R
 * (resolve.c: confirmed), common to all of them: light that only one half has met is one path or
 * one highlight that all views see. */
#define DOUBT 0.5

double lf_error_bound(const lf_row_error *rows, int n, double alpha, double *out_estimate)
{
    double estimate = 0.0, scale = 0.0, doubtful = 0.0, own = 0.0, next = 0.0, shared = 0.0,
           fourth = 0.0;
    for (int i = 0; i < n; i++) {
        own += rows[i].square * rows[i].square;
        next += i + 1 < n ? rows[i].square * rows[i + 1].square : 0.0;
        estimate += rows[i].square / n;
        doubtful += rows[i].doubtful / n;
        scale += pow(rows[i].square * rows[i].magnitude, 2.0);
    }
    if (out_estimate)
        *out_estimate = estimate;
    if (!(estimate > 0.0) || !isfinite(estimate))
        return estimate == 0.0 ? 0.0 : -1.0;
    /* A single row, or one next to rows without error, gives no information about its own scatter:
     * it counts as a single number. Otherwise the variance uses the products with the next row.
     * They are multiplied by the loss if the next row has less error than this one, plus the part
     * of the row that is from known light alone, whose edges the next row has elsewhere. */
    double variance = 4.0 * own / ((double)n * n),
           lost = next > 1e-6 * own ? 4.0 * fmax(n / (n - 1.0), own / next) : 0.0;
    for (int i = 0; i < n; i++) {
        double x = lost * rows[i].cross * rows[i].cross + 4.0 / 3.0 * rows[i].known * rows[i].known;
        shared += x;
        fourth += x * x;
    }
    if (lost > 0.0)
        variance = fmin(variance, (shared + SCALE_VARIANCE * scale) / ((double)n * n));
    double freedom = fmax(2.0, fourth > 0.0 ? shared * shared / fourth : 2.0);
    double deviation =
        sqrt(2.0 * trigamma(fmax(2.0 * estimate * estimate / fmax(variance, 1e-300), 1e-3)));
    return estimate * exp(hypot(lf_upper_quantile(alpha, freedom) * deviation,
                                normal_quantile(alpha) * DOUBT * doubtful / estimate));
}
