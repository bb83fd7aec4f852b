/* How far the picture is from the truth, with an upper bound that holds as often as it says
 * (docs/estimators.md, "The error and its bound"). Views share paths and pixels of a row share an
 * offset; what is independent is the rows, and the halves. */
#include <math.h>

#include "base/alloc.h"
#include "render/renderer.h"

/* Upper quantile of the normal distribution (Newton's method on the error function). */
static double normal_quantile(double alpha)
{
    double z = sqrt(-2.0 * log(alpha));
    for (int i = 0; i < 60; i++)
        z += (0.5 * erfc(z / sqrt(2.0)) - alpha) * sqrt(2.0 * M_PI) * exp(0.5 * z * z) *
             (i < 4 ? 0.5 : 1.0);
    return z;
}

/* Upper quantile of Student's t, for 2 degrees of freedom or more: Fisher and Cornish's expansion
 * about the normal one, below 5 on a line in 1/freedom from there to the closed form at 2. */
static double t_quantile(double alpha, double freedom)
{
    if (freedom < 5.0) {
        double two = (1.0 - 2.0 * alpha) * sqrt(0.5 / (alpha * (1.0 - alpha))),
               share = (1.0 / freedom - 0.2) / 0.3;
        return share * two + (1.0 - share) * t_quantile(alpha, 5.0);
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

/* Variance of R squared, relative to the relMSE of one answer: 4 times that of R, and pi/2 to get
 * from the mean magnitude of a normal difference to its mean square. R is a median of five brought
 * between the pixel's two halves (resolve.c: steady_radiance). Of normal answers of variance 1 that
 * has 0.510, and 0.325 weighed by the squared difference of the halves, as errors weigh it (by
 * Monte Carlo). What is used lies between, since noise is not normal; 0.325 would lower bounds by
 * some per cent. */
#define SCALE_VARIANCE (4.0 * 0.449 * M_PI / 2.0)

double lf_error_bound(const lf_row_error *rows, int n, double alpha, double *out_estimate)
{
    double estimate = 0.0, scale = 0.0, own = 0.0, next = 0.0, shared = 0.0, fourth = 0.0;
    for (int i = 0; i < n; i++) {
        own += rows[i].square * rows[i].square;
        next += i + 1 < n ? rows[i].square * rows[i + 1].square : 0.0;
        estimate += rows[i].square / n;
        scale += pow(rows[i].square * rows[i].magnitude, 2.0);
    }
    if (out_estimate)
        *out_estimate = estimate;
    if (!(estimate > 0.0) || !isfinite(estimate))
        return estimate == 0.0 ? 0.0 : -1.0;
    /* A row alone, or beside rows without error, tells nothing about its own scatter: as if it were
     * a single number. Else the products with the next row, times what is lost where the next row
     * has less error than this one, and what known light alone makes of a row, whose edges the next
     * row has elsewhere. */
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
    return estimate * exp(t_quantile(alpha, freedom) * deviation);
}

/* Visits of a row, in both halves, before finding no error at all is believed: what a row's plane
 * has missed so far shows none. */
#define MIN_VISITS 8

static bool visited_enough(const lf_film *film)
{
    for (int row = 0; row < film->height; row++)
        if (film->rows[row].visits[0] + film->rows[row].visits[1] < MIN_VISITS)
            return false;
    return true;
}

typedef struct error_job {
    const lf_film *film;
    lf_estimator estimator;
    float *scratch; /* [worker][2][view][column][3] */
    lf_row_error *rows;
    atomic_bool unknown;
} error_job;

static void error_of_row(void *context, int row, int worker)
{
    error_job *job = context;
    size_t values = 3 * (size_t)job->film->n_views * (size_t)job->film->width;
    float *a = job->scratch + (size_t)worker * 2 * values, *b = a + values;
    lf_row_error *out = &job->rows[row];
    bool last = row + 1 == job->film->height;
    double next;
    if (!lf_film_row_differences(job->film, job->estimator, row, a, &out->known) ||
        (!last && !lf_film_row_differences(job->film, job->estimator, row + 1, b, &next))) {
        atomic_store_explicit(&job->unknown, true, memory_order_relaxed);
        return;
    }
    for (size_t i = 0; i < values; i++) {
        out->square += (double)a[i] * (double)a[i];
        out->magnitude += (double)fabsf(a[i]);
        out->cross += last ? 0.0 : (double)a[i] * (double)b[i];
    }
    out->square /= (double)values;
    out->magnitude /= (double)values;
    out->cross /= (double)values;
}

double lf_renderer_error_bound(const lf_renderer *renderer, lf_estimator estimator, double alpha,
                               double *out_estimate)
{
    const lf_film *film = &renderer->film;
    size_t values = 3 * (size_t)film->n_views * (size_t)film->width;
    error_job job = {.film = film, .estimator = estimator};
    job.scratch =
        lf_calloc((size_t)lf_pool_threads(renderer->pool) * 2 * values, sizeof *job.scratch);
    job.rows = lf_calloc((size_t)film->height, sizeof *job.rows);
    double bound = -1.0;
    /* Half of the risk is kept for what rows cannot tell: a bias that both halves share, a
     * denominator that is off. */
    if (job.scratch && job.rows &&
        lf_pool_run(renderer->pool, film->height, error_of_row, &job, NULL) == LF_OK &&
        !job.unknown)
        bound = lf_error_bound(job.rows, film->height, 0.5 * alpha, out_estimate);
    if (bound == 0.0 && !visited_enough(film))
        bound = -1.0;
    lf_free(job.scratch);
    lf_free(job.rows);
    return bound;
}
