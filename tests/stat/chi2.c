#include "tests/stat/chi2.h"

#include <stdlib.h>

#include "render/transport/sampler.h"
#include "tests/stat/stat.h"

#define MIN_EXPECTED 5.0
#define MIN_DEPTH 1
#define MAX_DEPTH 8

typedef struct cell {
    double observed, expected;
} cell;

static int by_expected(const void *a, const void *b)
{
    double x = ((const cell *)a)->expected, y = ((const cell *)b)->expected;
    return (x > y) - (x < y);
}

double lf_chi2_p(double *observed, double *expected, int n)
{
    cell *cells = calloc((size_t)n, sizeof *cells), pool = {0};
    double chi2 = 0.0, total = 0.0, impossible = 0.0;
    int degrees = -1;
    for (int i = 0; i < n; i++) {
        cells[i] = (cell){observed[i], expected[i]};
        total += observed[i];
        impossible += expected[i] > 0.0 ? 0.0 : observed[i];
    }
    qsort(cells, (size_t)n, sizeof *cells, by_expected);
    for (int i = 0; i < n; i++) {
        pool.observed += cells[i].observed;
        pool.expected += cells[i].expected;
        if (pool.expected < MIN_EXPECTED)
            continue;
        chi2 += (pool.observed - pool.expected) * (pool.observed - pool.expected) / pool.expected;
        degrees++;
        pool = (cell){0};
    }
    free(cells);
    if (impossible > 1e-5 * total || degrees < 1)
        return 0.0;
    return lf_p_chi2(chi2, degrees);
}

/* -------------------------------------------------------------------------- bins on a sphere -- */

typedef struct domain {
    const lf_chi2_sphere *test;
    lf_vec3 t, b;
    double growth; /* e^warp - 1 */
} domain;

static double density(const domain *d, double t, double phi01)
{
    const lf_chi2_sphere *q = d->test;
    double m = q->m_max * expm1(q->warp * t) / d->growth, sine = sqrt(m * (2.0 - m)),
           phi = 2.0 * M_PI * phi01;
    double jacobian = 2.0 * M_PI * q->m_max * q->warp * exp(q->warp * t) / d->growth;
    lf_vec3 local = lf_v3((float)(sine * cos(phi)), (float)(sine * sin(phi)), (float)(1.0 - m));
    return q->pdf(q->context, lf_from_frame(d->t, d->b, q->axis, local)) * jacobian;
}

/* 3 x 3 points of Gauss and Legendre. */
static double gauss(const domain *d, double t, double phi, double dt, double dphi)
{
    static const double x[3] = {0.11270166537925831, 0.5, 0.88729833462074169},
                        w[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    double sum = 0.0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            sum += w[i] * w[j] * density(d, t + x[i] * dt, phi + x[j] * dphi);
    return sum * dt * dphi;
}

/* Splits while the four quarters disagree with the whole by more than a hundredth of the noise that
 * the samples will have. */
static double integrate(const domain *d, double t, double phi, double dt, double dphi, double whole,
                        int depth)
{
    double part[4], sum = 0.0, hx = 0.5 * dt, hy = 0.5 * dphi;
    for (int i = 0; i < 4; i++)
        sum += part[i] = gauss(d, t + (i & 1) * hx, phi + (i >> 1) * hy, hx, hy);
    double noise = sqrt(fmax(sum, 1e-6) / d->test->n_samples);
    if (depth >= MAX_DEPTH ||
        (depth >= MIN_DEPTH && fabs(sum - whole) < 0.01 * noise / (1 << depth)))
        return sum;
    sum = 0.0;
    for (int i = 0; i < 4; i++)
        sum += integrate(d, t + (i & 1) * hx, phi + (i >> 1) * hy, hx, hy, part[i], depth + 1);
    return sum;
}

static double fill_expected(const domain *d, double *expected)
{
    const lf_chi2_sphere *q = d->test;
    double mass = 0.0, dt = 1.0 / q->n_t, dphi = 1.0 / q->n_phi;
    for (int i = 0; i < q->n_t; i++) {
        for (int j = 0; j < q->n_phi; j++) {
            double p =
                integrate(d, i * dt, j * dphi, dt, dphi, gauss(d, i * dt, j * dphi, dt, dphi), 0);
            /* A cell of which only a corner lies under the pdf may miss all points: not impossible,
             * only unlikely. */
            expected[i * q->n_phi + j] = fmax(p * q->n_samples, 1e-9);
            mass += p;
        }
    }
    return mass;
}

/* The bin of a direction, or the extra one behind the last. 1 - cos comes from a difference: it
 * must be right at 1e-8 too. */
static int bin_of(const domain *d, lf_vec3 w)
{
    const lf_chi2_sphere *q = d->test;
    lf_vec3 difference = lf_sub(w, q->axis);
    double m = 0.5 * (double)lf_dot(difference, difference);
    double t = log1p(m / q->m_max * d->growth) / q->warp;
    double phi = atan2((double)lf_dot(d->b, w), (double)lf_dot(d->t, w)) / (2.0 * M_PI);
    phi -= floor(phi);
    if (!(t < 1.0))
        return q->m_max < 2.0 ? q->n_t * q->n_phi
                              : (q->n_t - 1) * q->n_phi + (int)fmin(phi * q->n_phi, q->n_phi - 1);
    return (int)(t * q->n_t) * q->n_phi + (int)fmin(phi * q->n_phi, q->n_phi - 1);
}

/* Returns how many samples fell where the pdf is 0. */
static int fill_observed(const domain *d, double *observed)
{
    const lf_chi2_sphere *q = d->test;
    int impossible = 0;
    for (int i = 0; i < q->n_samples; i++) {
        lf_sampler s;
        float u[3];
        lf_vec3 w;
        lf_sampler_init(&s, LF_SAMPLER_INDEPENDENT, q->seed, (uint32_t)i);
        lf_sampler_2d(&s, u);
        u[2] = lf_sampler_1d(&s);
        bool drawn = q->sample(q->context, u, &w);
        observed[drawn ? bin_of(d, w) : q->n_t * q->n_phi] += 1.0;
        impossible += drawn && !(q->pdf(q->context, w) > 0.0);
    }
    return impossible;
}

double lf_chi2_sphere_p(const lf_chi2_sphere *q, double *out_mass)
{
    int n = q->n_t * q->n_phi + 1;
    double *observed = calloc((size_t)n, sizeof *observed),
           *expected = calloc((size_t)n, sizeof *expected);
    domain d = {.test = q, .growth = expm1(q->warp)};
    lf_tangents(q->axis, &d.t, &d.b);
    double mass = fill_expected(&d, expected);
    int impossible = fill_observed(&d, observed);
    expected[n - 1] = fmax(1.0 - mass, 0.0) * q->n_samples;
    /* What quadrature leaves of an integral of 1 is not a cell. */
    if (fabs(mass - 1.0) < 1e-3 && observed[n - 1] <= 1e-5 * q->n_samples) {
        observed[n - 1] = expected[n - 1] = 0.0;
        for (int i = 0; i < n - 1; i++)
            expected[i] /= mass;
    }
    bool sound = mass < 1.0 + 1e-3 && impossible <= 1e-5 * q->n_samples;
    double p = sound ? lf_chi2_p(observed, expected, n) : 0.0;
    if (out_mass)
        *out_mass = mass;
    free(observed);
    free(expected);
    return p;
}
