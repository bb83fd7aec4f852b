/* Automatic exposure: a percentile of the luminance, from a histogram over the leading bits of
 * floats, which increase with the value. No logarithm decides the bin of a pixel, and counts add up
 * to the same in any order. */
#include <math.h>
#include <string.h>

#include "quilt/quilt.h"

#define SHARE_ABOVE 0.05
#define SHOWN_AS 0.8
#define STEPS_A_STOP 8.0
#define MAX_STOPS 32.0

/* Keeps exponent and four bits of mantissa of a positive float. */
enum { BIN_SHIFT = 19 };

static double first_of(int bin)
{
    uint32_t bits = (uint32_t)bin << BIN_SHIFT;
    float first;
    memcpy(&first, &bits, sizeof first);
    return (double)first;
}

void lf_meter_add(lf_meter *meter, size_t n, const float *rgb)
{
    for (size_t i = 0; i < n; i++) {
        const float *c = rgb + 3 * i;
        float luminance = 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2];
        uint32_t bits;
        memcpy(&bits, &luminance, sizeof bits);
        if (luminance > 0.0f && isfinite(luminance))
            meter->n[bits >> BIN_SHIFT]++;
    }
}

void lf_meter_add_views(lf_meter *meter, const lf_views32 *views)
{
    for (int view = 0; view < views->n_views; view++)
        for (int row = 0; row < views->height; row++)
            lf_meter_add(meter, (size_t)views->width, lf_views32_row(views, view, row));
}

void lf_meter_merge(lf_meter *meter, const lf_meter *other)
{
    for (int i = 0; i < LF_METER_BINS; i++)
        meter->n[i] += other->n[i];
}

double lf_meter_exposure(const lf_meter *meter)
{
    int64_t all = 0;
    for (int i = 0; i < LF_METER_BINS; i++)
        all += meter->n[i];
    double above = SHARE_ABOVE * (double)all;
    for (int i = LF_METER_BINS - 1; i >= 0 && all > 0; i--) {
        double n = (double)meter->n[i];
        if (n <= above) {
            above -= n;
            continue;
        }
        double low = first_of(i), value = low + (1.0 - above / n) * (first_of(i + 1) - low);
        double stops = round(STEPS_A_STOP * log2(SHOWN_AS / value)) / STEPS_A_STOP;
        return fmin(fmax(stops, -MAX_STOPS), MAX_STOPS);
    }
    return 0.0;
}
