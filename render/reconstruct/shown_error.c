#include "render/reconstruct/shown_error.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "render/film/film_difference.h"
#include "render/film/median.h"
#include "render/reconstruct/bright.h"
#include "render/reconstruct/residual.h"
#include "render/reconstruct/scratch.h"

#define EPSILON 1e-2
/* A cell's own part in the shares of its pixels. Its neighbours have the remainder by
 * interpolation: in two or three directions 7/8 each. */
#define OWN_PART 0.7

typedef struct lf_open_row {
    const lf_reconstruction *r;
    const lf_film *film;
    const lf_pixels *pixels;
    lf_reconstruct_scratch *predicted[2], *bounded[2]; /* bounded NULL: no bounded fit */
    lf_row_halves halves;
    int row;
    lf_film_half half[2];
    const lf_film_known *known;
    float n[2], share[2]; /* of the samples */
    bool lacking[2];      /* the corrections of tiles for the view are in `times` of `predicted` */
} lf_open_row;

/* Sums over pixels. */
typedef struct lf_shown_sums {
    double variance, bias;
    size_t pixels;
} lf_shown_sums;

/* One pixel of one half: known and scattered light by the fit alone, without N/W; off: the
 * difference of an unbiased estimate from the shown value. */
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

static void read_half(const lf_open_row *o, size_t i, int h, bool fitted, const lf_fitted *found,
                      const lf_bright_pixel *bright, lf_half_pixel *out)
{
    static const float none[4] = {0.0f, 0.0f, 0.0f, -1.0f};
    const float *p = fitted ? o->predicted[h]->predicted[i] : none, *n = o->half[h].scattered[i].n;
    float q = o->half[h].q[i], w = q > 0.0f ? found->over[h] : 0.0f, shown[3];
    read_known(o, i, h, out->known);
    lf_pixel_show(n, w, p, shown);
    if (bright->share > 0.0f)
        lf_bright_mix(bright->share, bright->below[h], bright->above[h], w,
                      o->bounded[h]->predicted[i], shown);
    const float *times = o->predicted[h]->times[i % (size_t)o->film->width];
    for (int c = 0; c < 3 && fitted && o->lacking[h]; c++)
        shown[c] *= times[c];
    for (int c = 0; c < 3; c++) {
        float x = p[3] >= 0.0f ? p[c] : 0.0f;
        out->scattered[c] = q * fmaxf(x, 0.0f);
        out->shown[c] = out->known[c] + q * shown[c];
        out->off[c] = q * x + (n[c] - found->w[h] * x) / o->n[h] - q * shown[c];
    }
}

/* Median of the known light of the pixel and two to either side: for mirrors a single pixel is as
 * noisy as the tested value. */
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
    lf_fitted found;
    lf_bright_pixel bright = {.share = 0.0f};
    lf_fitted_read(o->film, &o->halves, o->pixels->second[i], i, &found);
    if (fitted && o->bounded[0])
        lf_bright_split(o->r, o->pixels, o->row, i, &found, &bright);
    for (int h = 0; h < 2; h++)
        read_half(o, i, h, fitted, &found, &bright, &half[h]);
    for (int c = 0; c < 3; c++) {
        /* if only one half has met a bright path, their mean would hide its error */
        double radiance = (double)(steady_known(o, i, c, half) +
                                   fminf(half[0].scattered[c], half[1].scattered[c])),
               inverse = 1.0 / (radiance * radiance + EPSILON),
               difference = (double)(half[0].shown[c] - half[1].shown[c]);
        sums->variance += (double)(o->share[0] * o->share[1]) * difference * difference * inverse;
        sums->bias += (double)half[0].off[c] * (double)half[1].off[c] * inverse;
    }
    sums->pixels++;
}

/* Predictions of both halves for a row. */
static lf_status predict(const lf_reconstruction *r, int row, const lf_pixels *pixels,
                         lf_reconstruct_scratch *const scratch[2])
{
    lf_status status = LF_OK;
    for (int h = 0; h < 2 && status == LF_OK; h++) {
        lf_pixels own = *pixels;
        memcpy(own.f[LF_BOTH], pixels->f[h], sizeof own.f[LF_BOTH]);
        status = lf_table_make(&scratch[h]->table, r, row, h);
        for (int k = 0; k < r->view.n_views && status == LF_OK; k++) {
            const int first = k * r->view.width;
            if (!lf_view_is_fitted(r, row, k))
                continue;
            r->kernels->predict(&scratch[h]->table, &own, first, r->view.width,
                                scratch[h]->predicted + first);
            lf_pixels_reflect(pixels, first, r->view.width, scratch[h]->predicted + first);
        }
    }
    return status;
}

/* Memory of a thread for the fit and the bounded one, per half. */
typedef struct lf_row_scratch {
    lf_reconstruct_scratch *whole[2], *bounded[2];
} lf_row_scratch;

static void give(lf_reconstruction *r, lf_reconstruct_scratch *const scratch[2])
{
    for (int h = 0; h < 2; h++)
        if (scratch[h])
            lf_scratch_give(r, scratch[h]);
}

static void give_all(lf_reconstruction *r, lf_row_scratch *s)
{
    give(r, s->whole);
    if (r->is_bright)
        give(r->bounded, s->bounded);
}

static bool take_all(lf_reconstruction *r, lf_row_scratch *out)
{
    bool whole = true;
    for (int h = 0; h < 2; h++) {
        out->whole[h] = lf_scratch_take(r);
        out->bounded[h] = r->is_bright ? lf_scratch_take(r->bounded) : NULL;
        whole = whole && out->whole[h] && (out->bounded[h] || !r->is_bright);
    }
    return whole;
}

static lf_shown_row sum_row(lf_open_row *o)
{
    lf_shown_sums sums = {.variance = 0.0};
    for (int k = 0; k < o->film->n_views; k++) {
        if (!lf_view_is_fitted(o->r, o->row, k))
            continue;
        for (int h = 0; h < 2; h++)
            o->lacking[h] = lf_residual_row(o->r, o->row, k, h, o->predicted[h]->times);
        for (int i = 0; i < o->film->width; i++)
            add_pixel(o, (size_t)k * (size_t)o->film->width + (size_t)i, &sums);
    }
    const double all = 3.0 * (double)sums.pixels;
    return (lf_shown_row){sums.variance / all, sums.bias / all};
}

static lf_status error_of_row(const lf_reconstruction *r, const lf_film *film, int row,
                              const lf_row_scratch *s, lf_shown_row *out)
{
    const lf_film_row *state = &film->rows[row];
    lf_pixels *pixels = &s->whole[0]->row;
    if (!(state->n[0] > 0.0 && state->n[1] > 0.0) ||
        !lf_pixels_read(pixels, r, film, row, LF_READ_HALVES))
        return LF_E_STATE;
    lf_status status = predict(r, row, pixels, s->whole);
    if (status == LF_OK && r->is_bright)
        status = predict(r->bounded, row, pixels, s->bounded);
    if (status != LF_OK)
        return status;
    lf_film_open(film, row);
    lf_open_row o = {.r = r,
                     .film = film,
                     .pixels = pixels,
                     .predicted = {s->whole[0], s->whole[1]},
                     .bounded = {s->bounded[0], s->bounded[1]},
                     .halves = lf_row_halves_of(film, row, (const float(*)[3])pixels->albedo),
                     .row = row,
                     .known = lf_film_known_at(film, row)};
    for (int h = 0; h < 2; h++) {
        o.half[h] = lf_film_at(film, row, h);
        o.n[h] = (float)state->n[h];
        o.share[h] = (float)(state->n[h] / (state->n[0] + state->n[1]));
    }
    *out = sum_row(&o);
    lf_film_close(film, row, false);
    return LF_OK;
}

double lf_shown_error_bound(const lf_shown_row *rows, int n, const lf_shown_chosen *chosen,
                            double alpha, double *out_estimate)
{
    double variance = 0.0, bias = 0.0, square = 0.0, fourth = 0.0;
    for (int i = 0; i < n; i++) {
        variance += rows[i].variance / n;
        bias += rows[i].bias / n;
        /* Rows' noise is independent, and neighbours have much the same error. */
        double d =
            i > 0 ? rows[i].variance - rows[i - 1].variance + rows[i].bias - rows[i - 1].bias : 0.0;
        square += 0.5 * d * d;
        fourth += 0.25 * d * d * d * d;
    }
    double estimate = variance + fmax(bias + chosen->likely, 0.0),
           most = variance + fmax(bias + chosen->most, 0.0);
    *out_estimate = isfinite(estimate) ? estimate : -1.0;
    if (!isfinite(estimate) || n < 2)
        return -1.0;
    double freedom = fmax(2.0, fourth > 0.0 ? square * square / fourth : 2.0),
           deviation = sqrt(square * n / (n - 1.0)) / n;
    return fmax(estimate, most) + lf_upper_quantile(alpha, freedom) * deviation;
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
    lf_row_scratch scratch;
    if (!take_all(job->r, &scratch) ||
        error_of_row(job->r, job->film, row, &scratch, &job->rows[row]) != LF_OK)
        atomic_store_explicit(&job->unknown, true, memory_order_relaxed);
    give_all(job->r, &scratch);
}

/* Adds the cells of one reconstruction. Level 1 stores the share of a cell for which it is not
 * shown. */
static void add_chosen(const lf_reconstruction *r, const lf_reconstruction *whole, bool bounded,
                       lf_shown_chosen *sum)
{
    for (int l = 1; l < LF_LEVELS; l++)
        for (int b = 0; b < r->level[l].n_bands; b++)
            for (int i = 0; i < r->level[l].bands[b].n; i++) {
                const lf_cell *cell = &r->level[l].bands[b].cells[i];
                const double bright = (double)whole->level[l].bands[b].cells[i].bright,
                             part = l > 1     ? 1.0
                                    : bounded ? bright
                                              : 1.0 - bright;
                sum->likely += part * (double)cell->chosen;
                sum->most += part * (double)cell->chosen_most;
            }
}

/* Correction of the estimate because the compared halves also chose the shares. */
static lf_shown_chosen chosen_by_chance(const lf_reconstruction *r, const lf_film *film)
{
    lf_shown_chosen chosen = {0.0, 0.0};
    double samples = 0.0, pixels = 0.0;
    add_chosen(r, r, false, &chosen);
    if (r->is_bright)
        add_chosen(r->bounded, r, true, &chosen);
    for (int row = 0; row < film->height; row++)
        for (int k = 0; k < film->n_views; k++)
            if (lf_view_is_fitted(r, row, k)) {
                pixels += film->width;
                samples += (film->rows[row].n[0] + film->rows[row].n[1]) * film->width;
            }
    if (!(samples > 0.0))
        return (lf_shown_chosen){0.0, 0.0};
    const double per = 2.0 * OWN_PART / 3.0, tiles = per * lf_residual_chosen(r) / pixels;
    return (lf_shown_chosen){per * chosen.likely / samples + tiles,
                             per * chosen.most / samples + tiles};
}

double lf_reconstruct_error(lf_reconstruction *r, const lf_film *film, double alpha,
                            double *out_estimate, const lf_cancel *cancel)
{
    lf_error_job job = {.r = r, .film = film};
    double bound = -1.0, estimate = -1.0;
    job.rows = r->ready ? lf_calloc((size_t)film->height, sizeof *job.rows) : NULL;
    if (job.rows && lf_pool_run(r->pool, film->height, run_row, &job, cancel) == LF_OK &&
        !job.unknown) {
        const lf_shown_chosen chosen = chosen_by_chance(r, film);
        bound = lf_shown_error_bound(job.rows, film->height, &chosen, alpha, &estimate);
    }
    lf_free(job.rows);
    if (out_estimate)
        *out_estimate = estimate;
    return bound;
}
