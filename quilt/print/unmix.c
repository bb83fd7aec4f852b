#include "quilt/print/unmix.h"

#include <string.h>

#include "base/alloc.h"

/* The system K^T K + DAMPING is solved this often for the error that is left. A pattern that is
 * seen with the strength s then keeps (DAMPING / (s^2 + DAMPING))^SOLVES of its error. */
#define DAMPING 1e-3
#define SOLVES 3
/* Sweeps of coordinate descent, each there and back, near dots at the end of the gamut. */
#define SWEEPS 3
/* A dot farther outside the gamut than this is a clamped one. */
#define BEYOND 1e-6

static double share_of(const lf_crosstalk *k, int t, int dot)
{
    return lf_crosstalk_row(k, t)[dot - k->first[t]];
}

/* The shares of a dot in the places from crosstalk->from[dot] on. */
static double *column_of(const lf_unmix *unmix, int dot)
{
    return unmix->column + (size_t)dot * (size_t)unmix->height;
}

static int height_of(const lf_crosstalk *k)
{
    int height = 1;
    for (int dot = 0; dot < k->n_dots; dot++)
        height = k->to[dot] - k->from[dot] > height ? k->to[dot] - k->from[dot] : height;
    return height;
}

static void make_columns(lf_unmix *unmix)
{
    const lf_crosstalk *k = unmix->crosstalk;
    for (int dot = 0; dot < k->n_dots; dot++)
        for (int t = k->from[dot]; t < k->to[dot]; t++)
            column_of(unmix, dot)[t - k->from[dot]] = share_of(k, t, dot);
}

static double *lanes_of(double *values, int i)
{
    return values + (size_t)i * LF_UNMIX_LANES;
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

static lf_status make_scratch(lf_unmix *unmix)
{
    const size_t n_dots = (size_t)unmix->crosstalk->n_dots,
                 n_places = (size_t)unmix->crosstalk->n_places;
    unmix->error = lf_calloc(n_places * LF_UNMIX_LANES, sizeof *unmix->error);
    unmix->plain = lf_calloc(n_places * LF_UNMIX_LANES, sizeof *unmix->plain);
    unmix->step = lf_calloc(n_dots * LF_UNMIX_LANES, sizeof *unmix->step);
    unmix->dots = lf_calloc(n_dots * LF_UNMIX_LANES, sizeof *unmix->dots);
    unmix->clamped = lf_calloc(n_dots, 2);
    if (!unmix->error || !unmix->plain || !unmix->step || !unmix->dots || !unmix->clamped) {
        lf_unmix_finish(unmix);
        return LF_E_NOMEM;
    }
    unmix->near = unmix->clamped + n_dots;
    return LF_OK;
}

lf_status lf_unmix_init(lf_unmix *unmix, const lf_crosstalk *crosstalk)
{
    const size_t n_dots = (size_t)crosstalk->n_dots;
    *unmix = (lf_unmix){.crosstalk = crosstalk, .height = height_of(crosstalk)};
    unmix->factor = lf_calloc(n_dots * (size_t)crosstalk->width, sizeof *unmix->factor);
    unmix->column = lf_calloc(n_dots * (size_t)unmix->height, sizeof *unmix->column);
    unmix->norm = lf_calloc(n_dots, sizeof *unmix->norm);
    if (!unmix->factor || !unmix->column || !unmix->norm) {
        lf_unmix_finish(unmix);
        return LF_E_NOMEM;
    }
    make_columns(unmix);
    make_factor(unmix);
    return make_scratch(unmix);
}

lf_status lf_unmix_share(lf_unmix *unmix, const lf_unmix *whole)
{
    *unmix = (lf_unmix){.shares = true};
    lf_unmix_turn(unmix, whole);
    return make_scratch(unmix);
}

void lf_unmix_turn(lf_unmix *share, const lf_unmix *whole)
{
    share->crosstalk = whole->crosstalk;
    share->factor = whole->factor;
    share->column = whole->column;
    share->height = whole->height;
    share->norm = whole->norm;
}

void lf_unmix_finish(lf_unmix *unmix)
{
    if (!unmix->shares) {
        lf_free(unmix->factor);
        lf_free(unmix->column);
        lf_free(unmix->norm);
    }
    lf_free(unmix->error);
    lf_free(unmix->plain);
    lf_free(unmix->step);
    lf_free(unmix->dots);
    lf_free(unmix->clamped);
    memset(unmix, 0, sizeof *unmix);
}

lf_unmix_part lf_unmix_part_of(const lf_unmix *unmix, int begin, int end)
{
    const lf_crosstalk *k = unmix->crosstalk;
    lf_unmix_part part = {begin, end, k->first_seen, k->end_seen};
    while (part.first_place < part.end_place && k->first[part.first_place] < begin)
        part.first_place++;
    while (part.end_place > part.first_place && k->first[part.end_place - 1] + k->width > end)
        part.end_place--;
    return part;
}

/* error = K dots - wanted. */
static void look_at(lf_unmix *unmix, const lf_unmix_part *part, const double *wanted)
{
    const lf_crosstalk *k = unmix->crosstalk;
    for (int t = part->first_place; t < part->end_place; t++) {
        const double *share = lf_crosstalk_row(k, t), *dots = lanes_of(unmix->dots, k->first[t]);
        double *error = lanes_of(unmix->error, t), sum[LF_UNMIX_LANES];
        for (int lane = 0; lane < LF_UNMIX_LANES; lane++)
            sum[lane] = -wanted[(size_t)t * LF_UNMIX_LANES + (size_t)lane];
        for (int d = 0; d < k->width; d++)
            for (int lane = 0; lane < LF_UNMIX_LANES; lane++)
                sum[lane] += share[d] * dots[d * LF_UNMIX_LANES + lane];
        memcpy(error, sum, sizeof sum);
    }
}

/* Places that see a dot, within a part, and the dot's shares in them. */
typedef struct seen_at {
    const double *share;
    double *error;
    int n;
} seen_at;

static seen_at seen_of(const lf_unmix *unmix, const lf_unmix_part *part, int dot)
{
    const lf_crosstalk *k = unmix->crosstalk;
    const int from = k->from[dot] > part->first_place ? k->from[dot] : part->first_place,
              to = k->to[dot] < part->end_place ? k->to[dot] : part->end_place;
    return (seen_at){column_of(unmix, dot) + (from - k->from[dot]), lanes_of(unmix->error, from),
                     to - from};
}

/* -K^T error of one dot. */
static inline void pull_back(const seen_at *seen, double pull[static LF_UNMIX_LANES])
{
    double sum[LF_UNMIX_LANES] = {0.0};
    for (int t = 0; t < seen->n; t++)
        for (int lane = 0; lane < LF_UNMIX_LANES; lane++)
            sum[lane] -= seen->share[t] * seen->error[t * LF_UNMIX_LANES + lane];
    memcpy(pull, sum, sizeof sum);
}

/* step = (L D L^T)^-1 (-K^T error). A part uses the factor of the whole: it is larger than the
 * part's own, so steps are shorter at the part's ends and never overshoot. */
static void solve(lf_unmix *unmix, const lf_unmix_part *part)
{
    const int width = unmix->crosstalk->width;
    for (int i = part->begin; i < part->end; i++) {
        const double *row = unmix->factor + (size_t)i * (size_t)width;
        const seen_at seen = seen_of(unmix, part, i);
        double *step = lanes_of(unmix->step, i), sum[LF_UNMIX_LANES];
        pull_back(&seen, sum);
        for (int d = 1; d < width && d <= i - part->begin; d++)
            for (int lane = 0; lane < LF_UNMIX_LANES; lane++)
                sum[lane] -= row[d] * (step - (size_t)d * LF_UNMIX_LANES)[lane];
        memcpy(step, sum, sizeof sum);
    }
    for (int i = part->end - 1; i >= part->begin; i--) {
        const double *row = unmix->factor + (size_t)i * (size_t)width;
        double *step = lanes_of(unmix->step, i), sum[LF_UNMIX_LANES];
        for (int lane = 0; lane < LF_UNMIX_LANES; lane++)
            sum[lane] = step[lane] * row[0];
        for (int d = 1; d < width && d < part->end - i; d++)
            for (int lane = 0; lane < LF_UNMIX_LANES; lane++)
                sum[lane] -= (row + (size_t)d * (size_t)width)[d] *
                             (step + (size_t)d * LF_UNMIX_LANES)[lane];
        memcpy(step, sum, sizeof sum);
    }
}

static double within(double v)
{
    return v > 0.0 ? v < 1.0 ? v : 1.0 : 0.0;
}

/* Cuts the dots to the gamut. False: none was outside. */
static bool cut(lf_unmix *unmix, const lf_unmix_part *part)
{
    const int around = 2 * unmix->crosstalk->width;
    int until = part->begin; /* dots before it are marked */
    memset(unmix->clamped + part->begin, 0, (size_t)(part->end - part->begin));
    memset(unmix->near + part->begin, 0, (size_t)(part->end - part->begin));
    for (int i = part->begin; i < part->end; i++) {
        double *dot = lanes_of(unmix->dots, i);
        for (int lane = 0; lane < LF_UNMIX_LANES; lane++) {
            if (dot[lane] < -BEYOND || dot[lane] > 1.0 + BEYOND)
                unmix->clamped[i] |= (unsigned char)(1U << lane);
            dot[lane] = within(dot[lane]);
        }
        if (!unmix->clamped[i])
            continue;
        until = until > i - around ? until : i - around;
        for (; until <= i + around && until < part->end; until++)
            unmix->near[until] = 1;
    }
    return until != part->begin;
}

/* Moves one dot to where the squares of the errors are least within the gamut. */
static void settle(lf_unmix *unmix, const lf_unmix_part *part, int i)
{
    if (!unmix->near[i] || unmix->norm[i] <= 0.0)
        return;
    const seen_at seen = seen_of(unmix, part, i);
    double *dot = lanes_of(unmix->dots, i), moved[LF_UNMIX_LANES];
    pull_back(&seen, moved);
    for (int lane = 0; lane < LF_UNMIX_LANES; lane++) {
        const double to = within(dot[lane] + moved[lane] / unmix->norm[i]);
        moved[lane] = to - dot[lane];
        dot[lane] = to;
    }
    for (int t = 0; t < seen.n; t++)
        for (int lane = 0; lane < LF_UNMIX_LANES; lane++)
            seen.error[t * LF_UNMIX_LANES + lane] += seen.share[t] * moved[lane];
}

/* Leaves a lane as it was if that is better. */
static void never_worse(lf_unmix *unmix, const lf_unmix_part *part, const double *print)
{
    for (size_t lane = 0; lane < LF_UNMIX_LANES; lane++) {
        const size_t begin = (size_t)part->first_place * LF_UNMIX_LANES + lane,
                     end = (size_t)part->end_place * LF_UNMIX_LANES;
        double sum = 0.0, plain = 0.0;
        for (size_t i = begin; i < end; i += LF_UNMIX_LANES) {
            sum += unmix->error[i] * unmix->error[i];
            plain += unmix->plain[i] * unmix->plain[i];
        }
        if (sum <= plain)
            continue;
        for (size_t i = (size_t)part->begin * LF_UNMIX_LANES + lane;
             i < (size_t)part->end * LF_UNMIX_LANES; i += LF_UNMIX_LANES)
            unmix->dots[i] = print[i];
        for (size_t i = begin; i < end; i += LF_UNMIX_LANES)
            unmix->error[i] = unmix->plain[i];
    }
}

void lf_unmix_light(lf_unmix *unmix, const lf_unmix_part *part, const double *wanted, double *print)
{
    const size_t dots_at = (size_t)part->begin * LF_UNMIX_LANES,
                 dots_size = (size_t)(part->end - part->begin) * LF_UNMIX_LANES * sizeof *print,
                 places_at = (size_t)part->first_place * LF_UNMIX_LANES,
                 places_size =
                     (size_t)(part->end_place - part->first_place) * LF_UNMIX_LANES * sizeof *print;
    memcpy(unmix->dots + dots_at, print + dots_at, dots_size);
    look_at(unmix, part, wanted);
    memcpy(unmix->plain + places_at, unmix->error + places_at, places_size);
    for (int i = 0; i < SOLVES; i++) {
        solve(unmix, part);
        for (size_t v = dots_at; v < (size_t)part->end * LF_UNMIX_LANES; v++)
            unmix->dots[v] += unmix->step[v];
        look_at(unmix, part, wanted);
    }
    if (cut(unmix, part)) {
        look_at(unmix, part, wanted);
        for (int sweep = 0; sweep < SWEEPS; sweep++) {
            for (int i = part->begin; i < part->end; i++)
                settle(unmix, part, i);
            for (int i = part->end - 1; i >= part->begin; i--)
                settle(unmix, part, i);
        }
    }
    never_worse(unmix, part, print);
    memcpy(print + dots_at, unmix->dots + dots_at, dots_size);
}
