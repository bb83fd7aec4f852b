/* Crosstalk that was measured with another number of views than a print has. */
#include <math.h>
#include <string.h>

#include "quilt/print/print.h"

/* The part of [left, right] in [low, high]. */
static double overlap(double left, double right, double low, double high)
{
    return fmax(0, fmin(right, high) - fmax(left, low));
}

/* The light in a view k views of width `to` away, if share i is spread evenly over a view of width
 * `from`; widths in lenses. */
static double share_of(const lf_print_blur *blur, int k, double from, double to)
{
    double sum = 0;
    for (int i = -blur->n_crosstalk; i <= blur->n_crosstalk; i++)
        sum += blur->crosstalk[i + blur->n_crosstalk] / from *
               overlap((i - 0.5) * from, (i + 0.5) * from, (k - 0.5) * to, (k + 0.5) * to);
    return sum;
}

void lf_print_fit_crosstalk(lf_print_blur *blur, int n_views)
{
    double fitted[2 * LF_PRINT_CROSSTALK + 1] = {0}, sum = 0;
    if (blur->n_crosstalk == 0 || blur->crosstalk_views == 0 || blur->crosstalk_views == n_views)
        return;
    const double from = 1.0 / blur->crosstalk_views, to = 1.0 / n_views;
    const int reach = (int)ceil((blur->n_crosstalk + 0.5) * from / to - 0.5 - 1e-9);
    const int n = reach < LF_PRINT_CROSSTALK ? reach : LF_PRINT_CROSSTALK;
    for (int k = -n; k <= n; k++)
        sum += fitted[k + n] = share_of(blur, k, from, to);
    for (int i = 0; i <= 2 * n && sum > 0; i++)
        fitted[i] /= sum;
    memcpy(blur->crosstalk, fitted, sizeof fitted);
    blur->n_crosstalk = sum > 0 ? n : 0;
    blur->crosstalk_views = n_views;
}
