#include "render/reconstruct/shown_error.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "render/film/film_difference.h"
#include "render/film/median.h"
#include "render/reconstruct/moments.h"
#include "render/reconstruct/scratch.h"

#define EPSILON 1e-2
/* Of a cell's own part in the shares by which its pixels go: those around it are between, in two or
 * three directions 7/8 each. */
#define OWN_PART 0.7

typedef struct lf_open_row {
    const lf_film *film;
    const lf_pixels *pixels;
    const lf_reconstruct_scratch *predicted[2];
    lf_film_half half[2];
    const lf_film_known *known;
    float n[2], share[2]; /* of the samples */
} lf_open_row;

/* Sums over pixels. */
typedef struct lf_shown_sums {
    double variance, bias;
    size_t pixels;
} lf_shown_sums;

/* One pixel of one half: known and what is scattered by the fit alone are what it would be without
 * N/W; off is what an answer without bias is off from what is shown. */
typedef struct lf_half_pixel {
    float known[3], scattered[3], shown[3], off[3];
} lf_half_pixel;

/* B + M/n of a half. */
static void read_known(const lf_open_row *o, size_t i, int h, float out[3])
{
    float difference[3] = {0}, part = h == 0 ? o->share[1] : -o->share[0];
    if (o->known)
        lf_difference_unpack(o->known[i].difference, difference);
    for (int c = 0; c < 3; c++)
        out[c] = o->known ? o->known[i].b[c] + part * difference[c]
                          : o->film->sky[c] * (1.0f - o->half[h].q[i]);
}

static void read_half(const lf_open_row *o, size_t i, int h, bool fitted, lf_half_pixel *out)
{
    const float *p = o->predicted[h]->predicted[i];
    bool near = fitted && p[3] >= 0.0f, second = o->pixels->second[i];
    float q = o->half[h].q[i], share = near ? p[3] : 1.0f;
    lf_pixel_found found = {.w = 0.0f};
    lf_pixel_found_add(&found, &o->half[h], i);
    float w = q > 0.0f ? lf_pixel_found_weight(o->film, &found, second, o->n[h] * q) : 0.0f,
          summand = second ? found.w2 : found.w;
    read_known(o, i, h, out->known);
    for (int c = 0; c < 3; c++) {
        float x = near ? p[c] : 0.0f, shown = w > 0.0f ? x + share * (found.n[c] / w - x) : x;
        out->scattered[c] = q * fmaxf(x, 0.0f);
        shown = q * fmaxf(shown, 0.0f);
        out->shown[c] = out->known[c] + shown;
        out->off[c] = q * x + (found.n[c] - summand * x) / o->n[h] - shown;
    }
}

/* Known light of the pixel and two to either side of it, the median: of mirrors it is as noisy as
 * what it is asked about. */
static float steady_known(const lf_open_row *o, size_t i, int c, const lf_half_pixel half[2])
{
    float x[5];
    int width = o->film->width, column = (int)(i % (size_t)width);
    if (!o->known)
        return o->share[0] * half[0].known[c] + o->share[1] * half[1].known[c];
    for (int k = -2; k <= 2; k++) {
        int at = column + k < 0 ? 0 : column + k >= width ? width - 1 : column + k;
        x[k + 2] = lf_most(o->known[i - (size_t)column + (size_t)at].b[c], 0.0f);
    }
    return lf_median_of_five(x);
}

static void add_pixel(const lf_open_row *o, size_t i, lf_shown_sums *sums)
{
    bool fitted = lf_pixel_is_fitted(o->pixels, i);
    lf_half_pixel half[2];
    for (int h = 0; h < 2; h++)
        read_half(o, i, h, fitted, &half[h]);
    for (int c = 0; c < 3; c++) {
        /* where only one half has met a bright path, their mean would hide what that is off */
        double radiance = (double)(steady_known(o, i, c, half) +
                                   fminf(half[0].scattered[c], half[1].scattered[c])),
               inverse = 1.0 / (radiance * radiance + EPSILON),
               difference = (double)(half[0].shown[c] - half[1].shown[c]);
        sums->variance += (double)(o->share[0] * o->share[1]) * difference * difference * inverse;
        sums->bias += (double)half[0].off[c] * (double)half[1].off[c] * inverse;
    }
    sums->pixels++;
}

/* What both halves predict of a row. */
static lf_status predict(const lf_reconstruction *r, int row, const lf_pixels *pixels,
                         lf_reconstruct_scratch *const scratch[2])
{
    lf_status status = LF_OK;
    for (int h = 0; h < 2 && status == LF_OK; h++) {
        lf_pixels own = *pixels;
        memcpy(own.f[LF_BOTH], pixels->f[h], sizeof own.f[LF_BOTH]);
        status = lf_table_make(&scratch[h]->table, r, row, h);
        for (int k = 0; k < r->view.n_views && status == LF_OK; k++)
            if (lf_view_is_fitted(r, row, k))
                r->kernels->predict(&scratch[h]->table, &own, k * r->view.width, r->view.width,
                                    scratch[h]->predicted + (size_t)k * (size_t)r->view.width);
    }
    return status;
}

static lf_status error_of_row(const lf_reconstruction *r, const lf_film *film, int row,
                              lf_reconstruct_scratch *const scratch[2], lf_shown_row *out)
{
    const lf_film_row *state = &film->rows[row];
    lf_pixels *pixels = &scratch[0]->rows[0];
    lf_shown_sums sums = {.variance = 0.0};
    if (!(state->n[0] > 0.0 && state->n[1] > 0.0) || !lf_pixels_read(pixels, r, film, row, true))
        return LF_E_STATE;
    lf_status status = predict(r, row, pixels, scratch);
    lf_open_row o = {.film = film,
                     .pixels = pixels,
                     .predicted = {scratch[0], scratch[1]},
                     .known = lf_film_known_at(film, row)};
    for (int h = 0; h < 2; h++) {
        o.half[h] = lf_film_at(film, row, h);
        o.n[h] = (float)state->n[h];
        o.share[h] = (float)(state->n[h] / (state->n[0] + state->n[1]));
    }
    for (int k = 0; k < film->n_views && status == LF_OK; k++)
        for (int i = 0; i < film->width && lf_view_is_fitted(r, row, k); i++)
            add_pixel(&o, (size_t)k * (size_t)film->width + (size_t)i, &sums);
    const double all = 3.0 * (double)sums.pixels;
    *out = (lf_shown_row){sums.variance / all, sums.bias / all};
    return status;
}

double lf_shown_error_bound(const lf_shown_row *rows, int n, double chosen, double alpha,
                            double *out_estimate)
{
    double variance = 0.0, bias = 0.0, square = 0.0, fourth = 0.0;
    for (int i = 0; i < n; i++) {
        variance += rows[i].variance / n;
        bias += rows[i].bias / n;
        /* Rows' noise is independent, and neighbours have much the same bias. */
        double d = i > 0 ? rows[i].bias - rows[i - 1].bias : 0.0;
        square += 0.5 * d * d;
        fourth += 0.25 * d * d * d * d;
    }
    double estimate = variance + fmax(bias + chosen, 0.0);
    *out_estimate = isfinite(estimate) ? estimate : -1.0;
    if (!isfinite(estimate) || n < 2)
        return -1.0;
    double freedom = fmax(2.0, fourth > 0.0 ? square * square / fourth : 2.0),
           deviation = sqrt(square * n / (n - 1.0)) / n;
    return estimate + lf_upper_quantile(alpha, freedom) * deviation;
}

typedef struct lf_error_job {
    lf_reconstruction *r;
    const lf_film *film;
    lf_shown_row *rows;
    atomic_bool unknown;
} lf_error_job;

static void run_row(void *context, int row, int worker)
{
    lf_error_job *job = context;
    (void)worker;
    lf_reconstruct_scratch *scratch[2] = {lf_scratch_take(job->r), lf_scratch_take(job->r)};
    if (!scratch[0] || !scratch[1] ||
        error_of_row(job->r, job->film, row, scratch, &job->rows[row]) != LF_OK)
        atomic_store_explicit(&job->unknown, true, memory_order_relaxed);
    for (int i = 0; i < 2; i++)
        if (scratch[i])
            lf_scratch_give(job->r, scratch[i]);
}

/* What the estimate lacks because shares were chosen by the halves that it compares. */
static double chosen_by_chance(const lf_reconstruction *r, const lf_film *film)
{
    double chosen = 0.0, samples = 0.0;
    for (int l = 1; l < LF_LEVELS; l++)
        for (int b = 0; b < r->level[l].n_bands; b++)
            for (int i = 0; i < r->level[l].bands[b].n; i++)
                chosen += (double)r->level[l].bands[b].cells[i].chosen;
    for (int row = 0; row < film->height; row++)
        for (int k = 0; k < film->n_views; k++)
            if (lf_view_is_fitted(r, row, k))
                samples += (film->rows[row].n[0] + film->rows[row].n[1]) * film->width;
    return samples > 0.0 ? 2.0 * OWN_PART * chosen / (3.0 * samples) : 0.0;
}

double lf_reconstruct_error(lf_reconstruction *r, const lf_film *film, double alpha,
                            double *out_estimate, const lf_cancel *cancel)
{
    lf_error_job job = {.r = r, .film = film};
    double bound = -1.0, estimate = -1.0;
    job.rows = r->ready ? lf_calloc((size_t)film->height, sizeof *job.rows) : NULL;
    if (job.rows && lf_pool_run(r->pool, film->height, run_row, &job, cancel) == LF_OK &&
        !job.unknown)
        bound = lf_shown_error_bound(job.rows, film->height, chosen_by_chance(r, film), alpha,
                                     &estimate);
    lf_free(job.rows);
    if (out_estimate)
        *out_estimate = estimate;
    return bound;
}
