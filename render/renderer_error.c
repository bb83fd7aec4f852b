/* The error of the image, with an upper bound that holds with the stated confidence. */
#include <math.h>

#include "base/alloc.h"
#include "render/reconstruct/shown_error.h"
#include "render/renderer.h"

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
    lf_row_error next;
    if (!lf_film_row_differences(job->film, job->estimator, row, a, out) ||
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
    /* Half of the risk is reserved for effects that rows cannot show: a bias that both halves
     * share, an error of the denominator. */
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

double lf_renderer_shown_error(const lf_renderer *renderer, double alpha, double *out_estimate,
                               const lf_cancel *cancel)
{
    if (out_estimate)
        *out_estimate = -1.0;
    return renderer->shown ? lf_reconstruct_error(renderer->shown, &renderer->film, 0.5 * alpha,
                                                  out_estimate, cancel)
                           : -1.0;
}
