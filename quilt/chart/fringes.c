#include "quilt/chart/fringes.h"

#include <complex.h>
#include <math.h>
#include <string.h>

#include "base/alloc.h"

#define TURN (2.0 * M_PI)
#define MOST_ANGLE (LF_CHART_MOST_SKEW * M_PI / 180.0)
#define STEP_CYCLES 0.12 /* at the edge */
#define N_LIGHT 5        /* 1, x, x^2, x^3, y */
#define N_WAVE 3         /* 1, x, x^2 times the cosine */
#define N_LINEAR (N_LIGHT + N_WAVE + 2)
#define N_SHEET 3
#define ITERATIONS 25
#define MOST_STEPS 2e9 /* of the first search */

static double band_per_mm(const lf_chart *chart, int band)
{
    return lf_chart_lpi(chart, band) / 25.4;
}

double lf_chart_cell_at(const lf_chart *chart, const lf_chart_optics *optics,
                        const lf_chart_sheet *sheet, double x, double y)
{
    double p[2];
    lf_chart_through(optics, x, y, p);
    const double u = p[0] * cos(sheet->angle) + p[1] * sin(sheet->angle);
    return remainder(chart->lpi / 25.4 * x - sheet->per_mm * u + sheet->cycles, 1.0);
}

/* ------------------------------------------------------------------------------ first search -- */

typedef struct search {
    const lf_chart *chart;
    const lf_chart_samples *samples;
    double *waves;        /* light of each row about its mean, in means */
    double complex *rows; /* [rows]: correlation at one pitch */
    double *depth;        /* [rows]: mean y of the lenses' points */
} search;

static void take_waves(search *s)
{
    const lf_chart_samples *g = s->samples;
    for (int r = 0; r < g->n_bands * g->rows_of_band; r++) {
        const size_t at = (size_t)r * (size_t)g->n_columns;
        double mean = 0.0, depth = 0.0;
        for (int c = 0; c < g->n_columns; c++) {
            mean += g->light[at + (size_t)c] / g->n_columns;
            depth += g->lens[2 * (at + (size_t)c) + 1] / g->n_columns;
        }
        s->depth[r] = depth;
        for (int c = 0; c < g->n_columns; c++)
            s->waves[at + (size_t)c] = g->light[at + (size_t)c] / fmax(mean, 1e-6) - 1.0;
    }
}

static void correlate(search *s, double per_mm)
{
    const lf_chart_samples *g = s->samples;
    for (int r = 0; r < g->n_bands * g->rows_of_band; r++) {
        const double f = band_per_mm(s->chart, r / g->rows_of_band);
        double complex sum = 0.0;
        for (int c = 0; c < g->n_columns; c++) {
            const size_t at = (size_t)r * (size_t)g->n_columns + (size_t)c;
            const double angle = TURN * (f * g->x[c] - per_mm * g->lens[2 * at]);
            sum += s->waves[at] * CMPLX(cos(angle), -sin(angle));
        }
        s->rows[r] = sum;
    }
}

/* The best pitch, angle and phase of a coarse grid. */
static void search_grid(search *s, double reach_ratio, lf_chart_sheet *out)
{
    const lf_chart *chart = s->chart;
    const lf_chart_samples *g = s->samples;
    const int n_rows = g->n_bands * g->rows_of_band;
    const int bands_beside = chart->n_bands / 2;
    const double spread =
        bands_beside * chart->step + LF_CHART_BEYOND_LPI + chart->lpi * reach_ratio; /* lpi */
    const double dp = STEP_CYCLES / g->half_width, middle = chart->lpi / 25.4;
    const double half_height = fmax(0.5 * chart->n_bands * chart->band_height, 1.0);
    const double da = STEP_CYCLES / (middle * half_height);
    const int np = (int)ceil(spread / 25.4 / dp), na = (int)ceil(MOST_ANGLE / da);
    double best = -1.0;
    for (int i = -np; i <= np; i++) {
        correlate(s, middle + i * dp);
        for (int k = -na; k <= na; k++) {
            const double down = TURN * (middle + i * dp) * sin(k * da);
            double complex sum = 0.0;
            for (int r = 0; r < n_rows; r++)
                sum += s->rows[r] * CMPLX(cos(down * s->depth[r]), sin(down * s->depth[r]));
            if (cabs(sum) <= best)
                continue;
            best = cabs(sum);
            /* ink is where the cosine is 1 */
            *out = (lf_chart_sheet){middle + i * dp, carg(-sum) / TURN, k * da, {{0}}, 0.0, 0.0};
        }
    }
}

/* --------------------------------------------------------------------------------------- fit -- */

/* Sums of one band. */
typedef struct sums {
    double linear[N_LINEAR * N_LINEAR], right[N_LINEAR];
    double cross[N_LINEAR * N_SHEET]; /* linear' J */
    double sheet[N_SHEET * N_SHEET], slope[N_SHEET];
    double square; /* of what is left */
} sums;

typedef struct point {
    double light, basis[N_LINEAR], sine[3]; /* of the phase, twice, three times */
    double turn[N_SHEET];                   /* derivative of the phase in radians */
} point;

static void point_at(const lf_chart *chart, const lf_chart_samples *g, const lf_chart_sheet *sheet,
                     int r, int c, point *out)
{
    const size_t at = (size_t)r * (size_t)g->n_columns + (size_t)c;
    const double x = g->x[c] / g->half_width, *p = g->lens + 2 * at;
    const double y = 2.0 * (r % g->rows_of_band + 0.5) / g->rows_of_band - 1.0;
    const double ca = cos(sheet->angle), sa = sin(sheet->angle), u = p[0] * ca + p[1] * sa;
    const double phase = TURN * (band_per_mm(chart, r / g->rows_of_band) * g->x[c] -
                                 sheet->per_mm * u + sheet->cycles);
    const double powers[4] = {1.0, x, x * x, x * x * x};
    out->light = g->light[at];
    memcpy(out->basis, powers, sizeof powers);
    out->basis[4] = y;
    for (int k = 0; k < N_WAVE; k++)
        out->basis[N_LIGHT + k] = powers[k] * cos(phase);
    for (int k = 2; k <= 3; k++)
        out->basis[N_LIGHT + N_WAVE + k - 2] = cos(k * phase);
    for (int k = 0; k < 3; k++)
        out->sine[k] = sin((k + 1) * phase);
    out->turn[0] = -TURN * u;
    out->turn[1] = TURN;
    out->turn[2] = -TURN * sheet->per_mm * (p[1] * ca - p[0] * sa);
}

/* Light of a point by the band's coefficients, and its derivative by the phase. */
static double model(const point *p, const double *coefficient, double *out_slope)
{
    double light = 0.0, wave = 0.0;
    for (int k = 0; k < N_LINEAR; k++)
        light += coefficient[k] * p->basis[k];
    for (int k = 0; k < N_WAVE; k++)
        wave += coefficient[N_LIGHT + k] * p->basis[k];
    *out_slope = -wave * p->sine[0] - 2.0 * coefficient[N_LIGHT + N_WAVE] * p->sine[1] -
                 3.0 * coefficient[N_LIGHT + N_WAVE + 1] * p->sine[2];
    return light;
}

/* Best linear coefficients of a band; n_used N_LIGHT: without fringes. */
static bool solve_band(const lf_chart *chart, const lf_chart_samples *g,
                       const lf_chart_sheet *sheet, int band, int n_used, double *coefficient)
{
    double a[N_LINEAR * N_LINEAR] = {0}, b[N_LINEAR] = {0};
    point p;
    for (int r = band * g->rows_of_band; r < (band + 1) * g->rows_of_band; r++)
        for (int c = 0; c < g->n_columns; c++) {
            point_at(chart, g, sheet, r, c, &p);
            for (int k = 0; k < n_used; k++) {
                b[k] += p.basis[k] * p.light;
                for (int l = 0; l < n_used; l++)
                    a[k * n_used + l] += p.basis[k] * p.basis[l];
            }
        }
    for (int k = 0; k < n_used; k++)
        a[k * (n_used + 1)] *= 1.0 + 1e-9; /* a band of one tone: fringes and light are the same */
    memset(coefficient, 0, N_LINEAR * sizeof *coefficient);
    if (!lf_chart_solve(n_used, 1, a, b))
        return false;
    memcpy(coefficient, b, (size_t)n_used * sizeof *b);
    return true;
}

static void add_band(const lf_chart *chart, const lf_chart_samples *g, const lf_chart_sheet *sheet,
                     int band, const double *coefficient, sums *out)
{
    point p;
    memset(out, 0, sizeof *out);
    for (int r = band * g->rows_of_band; r < (band + 1) * g->rows_of_band; r++)
        for (int c = 0; c < g->n_columns; c++) {
            double slope, j[N_SHEET];
            point_at(chart, g, sheet, r, c, &p);
            const double left = p.light - model(&p, coefficient, &slope);
            out->square += left * left;
            for (int k = 0; k < N_SHEET; k++)
                j[k] = slope * p.turn[k];
            for (int k = 0; k < N_SHEET; k++) {
                out->slope[k] += j[k] * left;
                for (int l = 0; l < N_SHEET; l++)
                    out->sheet[k * N_SHEET + l] += j[k] * j[l];
            }
            for (int k = 0; k < N_LINEAR; k++) {
                out->right[k] += p.basis[k] * left;
                for (int l = 0; l < N_LINEAR; l++)
                    out->linear[k * N_LINEAR + l] += p.basis[k] * p.basis[l];
                for (int l = 0; l < N_SHEET; l++)
                    out->cross[k * N_SHEET + l] += p.basis[k] * j[l];
            }
        }
}

/* Adds what a band says of the sheet, whatever its light: the Schur complement of `linear`. */
static void reduce_band(const sums *s, double *a, double *b)
{
    double linear[N_LINEAR * N_LINEAR], both[N_LINEAR * (N_SHEET + 1)];
    memcpy(linear, s->linear, sizeof linear);
    for (int k = 0; k < N_LINEAR; k++) {
        linear[k * (N_LINEAR + 1)] *= 1.0 + 1e-9;
        for (int l = 0; l < N_SHEET; l++)
            both[k * (N_SHEET + 1) + l] = s->cross[k * N_SHEET + l];
        both[k * (N_SHEET + 1) + N_SHEET] = s->right[k];
    }
    if (!lf_chart_solve(N_LINEAR, N_SHEET + 1, linear, both))
        return;
    for (int k = 0; k < N_SHEET; k++) {
        b[k] += s->slope[k];
        for (int i = 0; i < N_LINEAR; i++)
            b[k] -= s->cross[i * N_SHEET + k] * both[i * (N_SHEET + 1) + N_SHEET];
        for (int l = 0; l < N_SHEET; l++) {
            a[k * N_SHEET + l] += s->sheet[k * N_SHEET + l];
            for (int i = 0; i < N_LINEAR; i++)
                a[k * N_SHEET + l] -= s->cross[i * N_SHEET + k] * both[i * (N_SHEET + 1) + l];
        }
    }
}

/* Normal equations of the sheet over all bands; returns the sum of squares of what is left. */
static double gather(const lf_chart *chart, const lf_chart_samples *g, const lf_chart_sheet *sheet,
                     double *a, double *b)
{
    double square = 0.0;
    memset(a, 0, N_SHEET * N_SHEET * sizeof *a);
    memset(b, 0, N_SHEET * sizeof *b);
    for (int band = 0; band < g->n_bands; band++) {
        double coefficient[N_LINEAR];
        sums s;
        if (!solve_band(chart, g, sheet, band, N_LINEAR, coefficient))
            continue;
        add_band(chart, g, sheet, band, coefficient, &s);
        reduce_band(&s, a, b);
        square += s.square;
    }
    return square;
}

static void descend(const lf_chart *chart, const lf_chart_samples *g, lf_chart_sheet *sheet)
{
    double a[N_SHEET * N_SHEET], b[N_SHEET], damping = 1e-3;
    double cost = gather(chart, g, sheet, a, b);
    for (int i = 0; i < ITERATIONS; i++) {
        double damped[N_SHEET * N_SHEET], step[N_SHEET], next_a[N_SHEET * N_SHEET], next_b[N_SHEET];
        memcpy(damped, a, sizeof a);
        memcpy(step, b, sizeof b);
        for (int k = 0; k < N_SHEET; k++)
            damped[k * (N_SHEET + 1)] *= 1.0 + damping;
        if (!lf_chart_solve(N_SHEET, 1, damped, step))
            return;
        lf_chart_sheet next = *sheet;
        next.per_mm += step[0], next.cycles += step[1], next.angle += step[2];
        const double lower = gather(chart, g, &next, next_a, next_b);
        if (!(lower < cost)) {
            damping *= 10.0;
            if (damping > 1e6)
                return;
            continue;
        }
        const bool ends = cost - lower < 1e-9 * cost;
        *sheet = next;
        cost = lower;
        damping *= 0.1;
        memcpy(a, next_a, sizeof a);
        memcpy(b, next_b, sizeof b);
        if (ends)
            return;
    }
}

/* How alike neighbouring points of what is left are, -1..1: noise that is not independent tells
 * less. */
static double likeness(const lf_chart *chart, const lf_chart_samples *g,
                       const lf_chart_sheet *sheet)
{
    double own = 1e-300, next = 0.0;
    for (int band = 0; band < g->n_bands; band++) {
        double coefficient[N_LINEAR], slope, before = 0.0;
        point p;
        if (!solve_band(chart, g, sheet, band, N_LINEAR, coefficient))
            continue;
        for (int r = band * g->rows_of_band; r < (band + 1) * g->rows_of_band; r++)
            for (int c = 0; c < g->n_columns; c++) {
                point_at(chart, g, sheet, r, c, &p);
                const double left = p.light - model(&p, coefficient, &slope);
                own += left * left;
                next += c > 0 ? left * before : 0.0;
                before = left;
            }
    }
    return next / own;
}

static void judge(const lf_chart *chart, const lf_chart_samples *g, lf_chart_sheet *sheet)
{
    double a[N_SHEET * N_SHEET], b[N_SHEET], inverse[N_SHEET * N_SHEET] = {0};
    const double square = gather(chart, g, sheet, a, b);
    const double n = (double)g->n_bands * g->rows_of_band * g->n_columns;
    double plain = 0.0, light = 0.0;
    for (int band = 0; band < g->n_bands; band++) {
        double coefficient[N_LINEAR];
        sums s;
        if (!solve_band(chart, g, sheet, band, N_LIGHT, coefficient))
            continue;
        add_band(chart, g, sheet, band, coefficient, &s);
        plain += s.square;
        light += coefficient[0] / g->n_bands;
    }
    sheet->explained = plain > 0.0 ? 1.0 - square / plain : 0.0;
    sheet->contrast = sqrt(plain / n) / fmax(light, 1e-6);
    const double rho = fmin(fmax(likeness(chart, g, sheet), 0.0), 0.95);
    const double variance = square / n * (1.0 + rho) / (1.0 - rho);
    for (int k = 0; k < N_SHEET; k++)
        inverse[k * (N_SHEET + 1)] = 1.0;
    if (!lf_chart_solve(N_SHEET, N_SHEET, a, inverse))
        sheet->explained = 0.0;
    for (int k = 0; k < N_SHEET; k++)
        for (int l = 0; l < N_SHEET; l++)
            sheet->covariance[k][l] = variance * inverse[k * N_SHEET + l];
}

/* How many steps the first search takes: of a chart far larger than any sheet, too many. */
static double steps_of(const lf_chart *chart, const lf_chart_samples *g)
{
    const double rows = (double)g->n_bands * g->rows_of_band, middle = chart->lpi / 25.4;
    const double pitches = 2.0 * (0.5 * chart->n_bands * chart->step + LF_CHART_BEYOND_LPI) / 25.4 *
                           g->half_width / STEP_CYCLES;
    const double angles = MOST_ANGLE * middle * chart->n_bands * chart->band_height / STEP_CYCLES;
    return pitches * rows * (g->n_columns + angles);
}

lf_status lf_chart_sheet_fit(const lf_chart *chart, const lf_chart_optics *optics,
                             const lf_chart_samples *samples, lf_chart_sheet *out, lf_error *err)
{
    const size_t rows = (size_t)(samples->n_bands * samples->rows_of_band);
    search s = {.chart = chart,
                .samples = samples,
                .waves = lf_calloc(rows * (size_t)samples->n_columns, sizeof *s.waves),
                .rows = lf_calloc(rows, sizeof *s.rows),
                .depth = lf_calloc(rows, sizeof *s.depth)};
    lf_chart_sheet sheet = {0};
    const bool is_small = steps_of(chart, samples) < MOST_STEPS;
    const bool have = s.waves && s.rows && s.depth;
    if (have && is_small) {
        take_waves(&s);
        search_grid(&s, lf_chart_reach(optics) / optics->distance, &sheet);
        descend(chart, samples, &sheet);
        judge(chart, samples, &sheet);
        *out = sheet;
    }
    lf_free(s.waves);
    lf_free(s.rows);
    lf_free(s.depth);
    if (!is_small)
        return lf_error_set(err, LF_E_ARG, "chart",
                            "is too large to be read; print one with a smaller range or size");
    return have ? LF_OK
                : lf_error_set(err, LF_E_NOMEM, "chart", "not enough memory to fit the fringes");
}
