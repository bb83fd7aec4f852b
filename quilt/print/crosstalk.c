#include "quilt/print/crosstalk.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"

/* The Gaussian is cut where less than 1e-4 of it is left. */
#define SIGMAS 4.0

/* ------------------------------------------------------------------------------------ matrix -- */

static lf_status crosstalk_init(lf_crosstalk *out, int n_places, int n_dots, int width)
{
    memset(out, 0, sizeof *out);
    out->n_places = n_places;
    out->n_dots = n_dots;
    out->width = width;
    out->first = lf_calloc((size_t)n_places, sizeof *out->first);
    out->share = lf_calloc((size_t)n_places * (size_t)width, sizeof *out->share);
    out->from = lf_calloc((size_t)n_dots, 2 * sizeof *out->from);
    if (out->first && out->share && out->from) {
        out->to = out->from + n_dots;
        return LF_OK;
    }
    lf_crosstalk_finish(out);
    return LF_E_NOMEM;
}

void lf_crosstalk_finish(lf_crosstalk *crosstalk)
{
    lf_free(crosstalk->first);
    lf_free(crosstalk->share);
    lf_free(crosstalk->from);
    memset(crosstalk, 0, sizeof *crosstalk);
}

/* Places a row so that it fits, with rising starts. */
static void begin_row(lf_crosstalk *k, int t, int first)
{
    const int most = k->n_dots - k->width, before = t > 0 ? k->first[t - 1] : 0;
    first = first < before ? before : first;
    k->first[t] = first < most ? first : most;
}

static void add_share(const lf_crosstalk *k, int t, int dot, double share)
{
    const int d = dot - k->first[t];
    if (d >= 0 && d < k->width)
        lf_crosstalk_row(k, t)[d] += share;
}

/* Divides every row by its sum, and finds the rows of every column. */
static void complete(lf_crosstalk *k)
{
    int from = 0, to = 0;
    for (int t = 0; t < k->n_places; t++) {
        double sum = 0.0;
        for (int d = 0; d < k->width; d++)
            sum += lf_crosstalk_row(k, t)[d];
        for (int d = 0; d < k->width && sum > 0.0; d++)
            lf_crosstalk_row(k, t)[d] /= sum;
        if (sum > 0.0)
            k->end_seen = t + 1;
        else if (k->end_seen == 0)
            k->first_seen = t + 1;
    }
    for (int dot = 0; dot < k->n_dots; dot++) {
        while (from < k->n_places && k->first[from] + k->width <= dot)
            from++;
        while (to < k->n_places && k->first[to] <= dot)
            to++;
        k->from[dot] = from;
        k->to[dot] = to;
    }
}

lf_status lf_crosstalk_of_kernel(const double *kernel, int n, int reach, lf_crosstalk *out)
{
    const int width = 2 * reach + 1 < n ? 2 * reach + 1 : n;
    if (crosstalk_init(out, n, n, width) != LF_OK)
        return LF_E_NOMEM;
    for (int t = 0; t < n; t++) {
        begin_row(out, t, t - reach);
        for (int d = -reach; d <= reach; d++)
            add_share(out, t, t + d, kernel[reach + d]);
    }
    complete(out);
    return LF_OK;
}

/* ------------------------------------------------------------------------------------- spots -- */

/* The integral up to x of a step that ink has made soft. */
static double ramp(double x, double ink_px)
{
    if (ink_px <= 0.0)
        return x > 0.0 ? x : 0.0;
    const double z = x / ink_px;
    return x * 0.5 * erfc(-z * 0.70710678118654752) +
           ink_px * 0.39894228040143268 * exp(-0.5 * z * z);
}

/* The part of the spot that lies to the left of x, pixels from its middle. */
static double spot_before(const lf_print_spot *spot, double x)
{
    const double half = 0.5 * spot->box_px;
    return (ramp(x + half, spot->ink_px) - ramp(x - half, spot->ink_px)) / spot->box_px;
}

static double half_of(const lf_print_spot *spot)
{
    return 0.5 * spot->box_px + SIGMAS * spot->ink_px;
}

double lf_crosstalk_width(const lf_crosstalk_look *look)
{
    return ceil(2.0 * (half_of(&look->spot) + look->n_extra * look->extra_px)) + 1.0;
}

static void add_spot(const lf_crosstalk_look *look, double middle, double weight, int t,
                     const lf_crosstalk *out)
{
    const double half = half_of(&look->spot);
    const int first = (int)floor(middle - half), last = (int)ceil(middle + half);
    double before = spot_before(&look->spot, first - middle);
    for (int dot = first; dot < last; dot++) {
        const double after = spot_before(&look->spot, dot + 1 - middle);
        add_share(out, t, dot, weight * (after - before));
        before = after;
    }
}

lf_status lf_crosstalk_of_look(const lf_crosstalk_look *look, lf_crosstalk *out)
{
    const double width = lf_crosstalk_width(look);
    const double reach = half_of(&look->spot) + look->n_extra * look->extra_px;
    if (!(width <= LF_CROSSTALK_WIDTH && width <= look->n_dots))
        return LF_E_ARG;
    if (crosstalk_init(out, look->n_places, look->n_dots, (int)width) != LF_OK)
        return LF_E_NOMEM;
    for (int t = 0; t < look->n_places; t++) {
        const double middle = look->middle[t];
        begin_row(out, t, (int)fmax(floor(middle - reach), 0.0));
        if (!(middle >= 0.0 && middle <= look->n_dots))
            continue;
        if (look->n_extra == 0)
            add_spot(look, middle, 1.0, t, out);
        for (int e = -look->n_extra; e <= look->n_extra && look->n_extra > 0; e++)
            add_spot(look, middle + e * look->extra_px, look->extra[look->n_extra + e], t, out);
    }
    complete(out);
    return LF_OK;
}
