#include "quilt/axis.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"

/* Taps of the interval [low, high] by area; outside the source the edge sample is repeated. */
static void area_taps(lf_axis_filter *filter, int n_in, int i, double low, double high)
{
    low = fmin(fmax(low, 0.0), n_in - 1e-6);
    high = fmin(fmax(high, low + 1e-6), (double)n_in);
    const int first = (int)low;
    const int last = (int)ceil(high) - 1;
    float *weight = filter->weight + (size_t)i * (size_t)filter->max_taps;

    filter->first[i] = first;
    filter->n_taps[i] = last - first + 1;
    for (int t = 0; t < filter->n_taps[i]; t++) {
        const double s = first + t;
        weight[t] = (float)((fmin(high, s + 1.0) - fmax(low, s)) / (high - low));
    }
}

static void linear_taps(lf_axis_filter *filter, int n_in, int i, double middle)
{
    const double s = fmin(fmax(middle - 0.5, 0.0), n_in - 1.0);
    const int first = (int)s;
    const double fraction = s - first;
    float *weight = filter->weight + (size_t)i * (size_t)filter->max_taps;
    filter->first[i] = first;
    filter->n_taps[i] = fraction > 0.0 ? 2 : 1;
    weight[0] = (float)(1.0 - fraction);
    weight[1] = (float)fraction;
}

lf_status lf_axis_filter_init(lf_axis_filter *filter, int n_in, int n_out, double start,
                              double step, double footprint)
{
    const int max_taps = footprint > 1.0 ? (int)fmin(ceil(footprint) + 1.0, n_in) : 2;
    memset(filter, 0, sizeof *filter);
    filter->n_out = n_out;
    filter->max_taps = max_taps;
    filter->first = lf_calloc((size_t)n_out, sizeof *filter->first);
    filter->n_taps = lf_calloc((size_t)n_out, sizeof *filter->n_taps);
    filter->weight = lf_calloc((size_t)n_out, (size_t)max_taps * sizeof *filter->weight);
    filter->inside = lf_calloc((size_t)n_out, sizeof *filter->inside);
    if (!filter->first || !filter->n_taps || !filter->weight || !filter->inside) {
        lf_axis_filter_finish(filter);
        return LF_E_NOMEM;
    }
    for (int i = 0; i < n_out; i++) {
        const double middle = start + i * step, low = middle - 0.5 * footprint,
                     high = middle + 0.5 * footprint;
        filter->inside[i] = (float)fmax(0.0, (fmin(high, n_in) - fmax(low, 0.0)) / (high - low));
        if (footprint > 1.0)
            area_taps(filter, n_in, i, low, high);
        else
            linear_taps(filter, n_in, i, middle);
    }
    return LF_OK;
}

void lf_axis_filter_finish(lf_axis_filter *filter)
{
    lf_free(filter->first);
    lf_free(filter->n_taps);
    lf_free(filter->weight);
    lf_free(filter->inside);
    memset(filter, 0, sizeof *filter);
}

void lf_axis_filter_part(const lf_axis_filter *filter, int first, int n, const float *line,
                         float *out)
{
    for (int i = first; i < first + n; i++) {
        const float *weight = filter->weight + (size_t)i * (size_t)filter->max_taps;
        const float *in = line + 3 * (size_t)filter->first[i];
        float sum[3] = {0.0F, 0.0F, 0.0F};
        for (int t = 0; t < filter->n_taps[i]; t++)
            for (int c = 0; c < 3; c++)
                sum[c] += weight[t] * in[3 * t + c];
        memcpy(out + 3 * (size_t)(i - first), sum, sizeof sum);
    }
}

void lf_axis_filter_line(const lf_axis_filter *filter, const float *line, float *out)
{
    lf_axis_filter_part(filter, 0, filter->n_out, line, out);
}
