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

static double *row_of(const lf_crosstalk *k, int t)
{
    return k->share + (size_t)t * (size_t)k->width;
}

static double share_of(const lf_crosstalk *k, int t, int dot)
{
    return row_of(k, t)[dot - k->first[t]];
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
        row_of(k, t)[d] += share;
}

/* Divides every row by its sum, and finds the rows of every column. */
static void complete(lf_crosstalk *k)
{
    int from = 0, to = 0;
    for (int t = 0; t < k->n_places; t++) {
        double sum = 0.0;
        for (int d = 0; d < k->width; d++)
            sum += row_of(k, t)[d];
        for (int d = 0; d < k->width && sum > 0.0; d++)
            row_of(k, t)[d] /= sum;
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

/* ----------------------------------------------------------------------------------- inverse -- */

/* The system K^T K + DAMPING is solved this often for the error that is left. A pattern that is
 * seen with the strength s then keeps (DAMPING / (s^2 + DAMPING))^SOLVES of its error. */
#define DAMPING 1e-3
#define SOLVES 3
/* Sweeps of coordinate descent, each there and back, near dots at the end of the gamut. */
#define SWEEPS 6
/* A dot farther outside the gamut than this is a clamped one. */
#define BEYOND 1e-6

static double *lanes_of(double *values, int i)
{
    return values + (size_t)i * LF_LANES;
}

/* The element (i, j) of K^T K, j <= i. */
static double gram(const lf_crosstalk *k, int i, int j)
{
    double sum = 0.0;
    for (int t = k->from[i]; t < k->to[j]; t++)
        sum += share_of(k, t, i) * share_of(k, t, j);
    return sum;
}

/* K^T K + DAMPING = L D L^T. Row i of the factor has 1 / D of i and, at d, L of column i - d. */
static void make_factor(lf_unmix *unmix)
{
    const lf_crosstalk *k = unmix->crosstalk;
    const int band = k->width - 1;
    double scaled[LF_CROSSTALK_WIDTH]; /* L D */
    for (int i = 0; i < k->n_dots; i++) {
        double *row = unmix->factor + (size_t)i * (size_t)k->width;
        unmix->norm[i] = gram(k, i, i);
        double rest = unmix->norm[i] + DAMPING;
        for (int d = band < i ? band : i; d > 0; d--) {
            const double *other = row - (size_t)d * (size_t)k->width;
            scaled[d] = gram(k, i, i - d);
            for (int e = d + 1; e <= band && e <= i; e++)
                scaled[d] -= scaled[e] * other[e - d];
            row[d] = scaled[d] * other[0];
            rest -= scaled[d] * row[d];
        }
        row[0] = 1.0 / rest;
    }
}

lf_status lf_unmix_init(lf_unmix *unmix, const lf_crosstalk *crosstalk)
{
    const size_t n_dots = (size_t)crosstalk->n_dots, n_places = (size_t)crosstalk->n_places;
    memset(unmix, 0, sizeof *unmix);
    unmix->crosstalk = crosstalk;
    unmix->factor = lf_calloc(n_dots * (size_t)crosstalk->width, sizeof *unmix->factor);
    unmix->norm = lf_calloc(n_dots, sizeof *unmix->norm);
    unmix->error = lf_calloc(n_places * LF_LANES, sizeof *unmix->error);
    unmix->plain = lf_calloc(n_places * LF_LANES, sizeof *unmix->plain);
    unmix->step = lf_calloc(n_dots * LF_LANES, sizeof *unmix->step);
    unmix->dots = lf_calloc(n_dots * LF_LANES, sizeof *unmix->dots);
    unmix->clamped = lf_calloc(n_dots, 2);
    if (!unmix->factor || !unmix->norm || !unmix->error || !unmix->plain || !unmix->step ||
        !unmix->dots || !unmix->clamped) {
        lf_unmix_finish(unmix);
        return LF_E_NOMEM;
    }
    unmix->near = unmix->clamped + n_dots;
    make_factor(unmix);
    return LF_OK;
}

void lf_unmix_finish(lf_unmix *unmix)
{
    lf_free(unmix->factor);
    lf_free(unmix->norm);
    lf_free(unmix->error);
    lf_free(unmix->plain);
    lf_free(unmix->step);
    lf_free(unmix->dots);
    lf_free(unmix->clamped);
    memset(unmix, 0, sizeof *unmix);
}

/* error = K dots - wanted, 0 where nothing is seen. */
static void look_at(lf_unmix *unmix, const double *wanted)
{
    const lf_crosstalk *k = unmix->crosstalk;
    for (int t = 0; t < k->n_places; t++) {
        const double *share = row_of(k, t), *dots = lanes_of(unmix->dots, k->first[t]);
        double seen[LF_LANES] = {0.0}, sum = 0.0;
        for (int d = 0; d < k->width; d++) {
            sum += share[d];
            for (int lane = 0; lane < LF_LANES; lane++)
                seen[lane] += share[d] * dots[d * LF_LANES + lane];
        }
        double *error = lanes_of(unmix->error, t);
        for (int lane = 0; lane < LF_LANES; lane++)
            error[lane] =
                sum > 0.0 ? seen[lane] - wanted[(size_t)t * LF_LANES + (size_t)lane] : 0.0;
    }
}

/* -K^T error of one dot. */
static void pull_back(lf_unmix *unmix, int dot, double pull[static LF_LANES])
{
    const lf_crosstalk *k = unmix->crosstalk;
    for (int lane = 0; lane < LF_LANES; lane++)
        pull[lane] = 0.0;
    for (int t = k->from[dot]; t < k->to[dot]; t++) {
        const double share = share_of(k, t, dot), *error = lanes_of(unmix->error, t);
        for (int lane = 0; lane < LF_LANES; lane++)
            pull[lane] -= share * error[lane];
    }
}

/* step = (L D L^T)^-1 (-K^T error). */
static void solve(lf_unmix *unmix)
{
    const int n = unmix->crosstalk->n_dots, width = unmix->crosstalk->width;
    for (int i = 0; i < n; i++) {
        const double *row = unmix->factor + (size_t)i * (size_t)width;
        double *step = lanes_of(unmix->step, i);
        pull_back(unmix, i, step);
        for (int d = 1; d < width && d <= i; d++)
            for (int lane = 0; lane < LF_LANES; lane++)
                step[lane] -= row[d] * (step - (size_t)d * LF_LANES)[lane];
    }
    for (int i = n - 1; i >= 0; i--) {
        const double *row = unmix->factor + (size_t)i * (size_t)width;
        double *step = lanes_of(unmix->step, i);
        for (int lane = 0; lane < LF_LANES; lane++)
            step[lane] *= row[0];
        for (int d = 1; d < width && d < n - i; d++)
            for (int lane = 0; lane < LF_LANES; lane++)
                step[lane] -=
                    (row + (size_t)d * (size_t)width)[d] * (step + (size_t)d * LF_LANES)[lane];
    }
}

static double within(double v)
{
    return v > 0.0 ? v < 1.0 ? v : 1.0 : 0.0;
}

/* Cuts the dots to the gamut. False: none was outside. */
static bool cut(lf_unmix *unmix)
{
    const int n = unmix->crosstalk->n_dots, around = 2 * unmix->crosstalk->width;
    int until = 0; /* dots before it are marked */
    memset(unmix->clamped, 0, 2 * (size_t)n);
    for (int i = 0; i < n; i++) {
        double *dot = lanes_of(unmix->dots, i);
        for (int lane = 0; lane < LF_LANES; lane++) {
            if (dot[lane] < -BEYOND || dot[lane] > 1.0 + BEYOND)
                unmix->clamped[i] |= (unsigned char)(1U << lane);
            dot[lane] = within(dot[lane]);
        }
        if (!unmix->clamped[i])
            continue;
        for (until = until > i - around ? until : i - around; until <= i + around; until++)
            if (until >= 0 && until < n)
                unmix->near[until] = 1;
    }
    return until != 0;
}

/* Moves one dot to where the squares of the errors are least within the gamut. */
static void settle(lf_unmix *unmix, int i)
{
    const lf_crosstalk *k = unmix->crosstalk;
    double *dot = lanes_of(unmix->dots, i), moved[LF_LANES];
    if (!unmix->near[i] || unmix->norm[i] <= 0.0)
        return;
    pull_back(unmix, i, moved);
    for (int lane = 0; lane < LF_LANES; lane++) {
        const double to = within(dot[lane] + moved[lane] / unmix->norm[i]);
        moved[lane] = to - dot[lane];
        dot[lane] = to;
    }
    for (int t = k->from[i]; t < k->to[i]; t++) {
        const double share = share_of(k, t, i);
        double *error = lanes_of(unmix->error, t);
        for (int lane = 0; lane < LF_LANES; lane++)
            error[lane] += share * moved[lane];
    }
}

/* Leaves a lane as it was if that is better. */
static void never_worse(lf_unmix *unmix, const double *print)
{
    const size_t n_errors = (size_t)unmix->crosstalk->n_places * LF_LANES,
                 n_dots = (size_t)unmix->crosstalk->n_dots * LF_LANES;
    for (size_t lane = 0; lane < LF_LANES; lane++) {
        double sum = 0.0, plain = 0.0;
        for (size_t i = lane; i < n_errors; i += LF_LANES) {
            sum += unmix->error[i] * unmix->error[i];
            plain += unmix->plain[i] * unmix->plain[i];
        }
        if (sum <= plain)
            continue;
        for (size_t i = lane; i < n_dots; i += LF_LANES)
            unmix->dots[i] = print[i];
        for (size_t i = lane; i < n_errors; i += LF_LANES)
            unmix->error[i] = unmix->plain[i];
    }
}

void lf_unmix_light(lf_unmix *unmix, const double *wanted, double *print)
{
    const int n = unmix->crosstalk->n_dots;
    const size_t n_values = (size_t)n * LF_LANES,
                 n_errors = (size_t)unmix->crosstalk->n_places * LF_LANES;
    memcpy(unmix->dots, print, n_values * sizeof *print);
    look_at(unmix, wanted);
    memcpy(unmix->plain, unmix->error, n_errors * sizeof *print);
    for (int i = 0; i < SOLVES; i++) {
        solve(unmix);
        for (size_t v = 0; v < n_values; v++)
            unmix->dots[v] += unmix->step[v];
        look_at(unmix, wanted);
    }
    if (cut(unmix)) {
        look_at(unmix, wanted);
        for (int sweep = 0; sweep < SWEEPS; sweep++) {
            for (int i = 0; i < n; i++)
                settle(unmix, i);
            for (int i = n - 1; i >= 0; i--)
                settle(unmix, i);
        }
    }
    never_worse(unmix, print);
    memcpy(print, unmix->dots, n_values * sizeof *print);
}
