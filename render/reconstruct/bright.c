#include "render/reconstruct/bright.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "render/reconstruct/scratch.h"

/* N/W by powers of two. */
enum { BUCKETS = 32, LOWEST = -16, ROUNDS = 8 };

/* Times the mean around: more is above the bound. */
#define BOUND 2.0f
/* The shown excess of one half is limited to this factor times the bound, or to the other half's
 * value as far as that is trusted. */
#define AGREED 4.0f
/* An agreement of the halves counts as chance up to this number of its standard deviations. */
#define DOUBT 2.0f
/* Correlations of the halves from which on the bounded fit has a share, and all. */
#define LEAST 0.1f
#define ENOUGH 0.2f
/* Trust in a half whose pixel is as bright as the other's: partial from the first correlation on,
 * full from the second. Below, two rare bright paths in one pixel may be chance. */
#define LEAST_TRUSTED 0.4f
#define TRUSTED 0.7f

struct lf_bright_cell {
    float weight[BUCKETS], found[BUCKETS]; /* sums of W and of N, mean of the channels */
    float n, sum[2], square, product;      /* of the excess over the bound, in both halves */
    float bound, trust;
};

void lf_bright_finish(lf_bright *bright)
{
    lf_free(bright->cells);
    *bright = (lf_bright){.cells = NULL};
}

static lf_status begin(lf_bright *bright, int n)
{
    if (n > bright->size) {
        lf_free(bright->cells);
        bright->cells = lf_calloc((size_t)n, sizeof *bright->cells);
        bright->size = bright->cells ? n : 0;
        if (!bright->cells)
            return LF_E_NOMEM;
    }
    bright->n = n;
    if (n > 0)
        memset(bright->cells, 0, (size_t)n * sizeof *bright->cells);
    return LF_OK;
}

/* ------------------------------------------------------------------------------------ pixels -- */

static float mean_of(const float rgb[3])
{
    return (rgb[0] + rgb[1] + rgb[2]) * (1.0f / 3.0f);
}

static void tell(lf_bright_cell *cell, const lf_fitted *x)
{
    for (int h = 0; h < 2; h++) {
        if (!(x->over[h] > 0.0f))
            continue;
        float n = mean_of(x->found[h].n), r = mean_of(x->answer[h]);
        int bucket = r > 0.0f && n > 0.0f ? ilogbf(r) - LOWEST : 0;
        bucket = bucket < 0 ? 0 : bucket < BUCKETS ? bucket : BUCKETS - 1;
        cell->weight[bucket] += n > 0.0f && r > 0.0f ? n / r : x->found[h].w;
        cell->found[bucket] += n;
    }
}

static void compare(lf_bright_cell *cell, const lf_fitted *x)
{
    float e[2];
    if (!(x->over[0] > 0.0f && x->over[1] > 0.0f))
        return;
    for (int h = 0; h < 2; h++) {
        float over = fmaxf(0.0f, mean_of(x->answer[h]) - cell->bound);
        e[h] = over > 0.0f ? over / (over + cell->bound) : 0.0f;
        cell->sum[h] += e[h];
    }
    cell->n += 1.0f;
    cell->square += 0.5f * (e[0] * e[0] + e[1] * e[1]);
    cell->product += e[0] * e[1];
}

typedef void (*visit_fn)(lf_bright_cell *cell, const lf_fitted *x);

static void visit_row(lf_reconstruction *r, const lf_film *film, const lf_pixels *pixels, int row,
                      int number, visit_fn visit)
{
    lf_film_open(film, row);
    const lf_row_halves halves = lf_row_halves_of(film, row, (const float(*)[3])pixels->albedo);
    const lf_band *band = &r->level[1].bands[number];
    lf_fitted x;
    for (int k = 0; k < film->n_views; k++) {
        size_t first = (size_t)k * (size_t)film->width;
        for (size_t i = first; i < first + (size_t)film->width && lf_view_is_fitted(r, row, k);
             i++) {
            if (!lf_pixel_is_fitted(pixels, i))
                continue;
            lf_fitted_read(film, &halves, pixels->second[i], i, &x);
            int at = lf_band_find(band, lf_half_of(pixels->u[i]), lf_half_of(pixels->z[i]));
            visit(&r->bright[number].cells[at], &x);
        }
    }
    lf_film_close(film, row, false);
}

static lf_status visit_band(lf_reconstruction *r, const lf_film *film, int number, visit_fn visit)
{
    lf_reconstruct_scratch *scratch = lf_scratch_take(r);
    int first = number * 2 * LF_CELL_SIDE, end = first + 2 * LF_CELL_SIDE;
    if (!scratch)
        return LF_E_NOMEM;
    for (int row = first; row < end && row < film->height; row++)
        if (lf_film_visited(film->rows[row].visits) &&
            lf_pixels_read(&scratch->row, r, film, row, LF_READ_SUMMED))
            visit_row(r, film, &scratch->row, row, number, visit);
    lf_scratch_give(r, scratch);
    return LF_OK;
}

lf_status lf_bright_tell(lf_reconstruction *r, const lf_film *film, int number)
{
    lf_status status = begin(&r->bright[number], r->level[1].bands[number].n);
    return status == LF_OK ? visit_band(r, film, number, tell) : status;
}

lf_status lf_bright_compare(lf_reconstruction *r, const lf_film *film, int number)
{
    return visit_band(r, film, number, compare);
}

/* ------------------------------------------------------------------------------------- cells -- */

/* The n-th of the 27 cells around one of a band. */
static const lf_bright_cell *around(const lf_reconstruction *r, int number, const lf_cell *cell,
                                    int n, float *weight)
{
    const lf_cell *other = lf_cell_around(&r->level[1], number, cell, n, weight);
    int band = number + n / 9 - 1;
    return other ? &r->bright[band].cells[other - r->level[1].bands[band].cells] : NULL;
}

/* The mean, with values above BOUND times it cut off; no bound if it is not above 0, because single
 * contributions may be negative. */
static float bounded_mean(const float weight[BUCKETS], const float found[BUCKETS])
{
    float w = 0.0f, mean = INFINITY;
    for (int b = 0; b < BUCKETS; b++)
        w += weight[b];
    for (int k = 0; k < ROUNDS && w > 0.0f; k++) {
        float bound = BOUND * mean, sum = 0.0f;
        for (int b = 0; b < BUCKETS; b++)
            if (weight[b] > 0.0f)
                sum += fminf(found[b], bound * weight[b]);
        mean = sum / w;
        if (!(mean > 0.0f))
            return INFINITY;
    }
    return mean;
}

void lf_bright_settle_bound(lf_reconstruction *r, int number)
{
    const lf_band *band = &r->level[1].bands[number];
    for (int i = 0; i < band->n; i++) {
        float weight[BUCKETS] = {0}, found[BUCKETS] = {0}, part;
        for (int n = 0; n < 27; n++) {
            const lf_bright_cell *other = around(r, number, &band->cells[i], n, &part);
            for (int b = 0; b < BUCKETS && other; b++) {
                weight[b] += part * other->weight[b];
                found[b] += part * other->found[b];
            }
        }
        r->bright[number].cells[i].bound = BOUND * bounded_mean(weight, found);
    }
}

/* Sums of the excess in the neighbouring cells. */
static lf_bright_cell sum_around(const lf_reconstruction *r, int number, const lf_cell *cell)
{
    lf_bright_cell sum = {.n = 0.0f};
    float part;
    for (int n = 0; n < 27; n++) {
        const lf_bright_cell *other = around(r, number, cell, n, &part);
        if (!other)
            continue;
        sum.n += part * other->n;
        sum.square += part * other->square;
        sum.product += part * other->product;
        for (int h = 0; h < 2; h++)
            sum.sum[h] += part * other->sum[h];
    }
    return sum;
}

/* For a cell, from means: the sums of products of the halves, and of squares. */
static void spread_of(const lf_bright_cell *s, const float mean[2], float *out_agreed,
                      float *out_total)
{
    const float a = mean[0], b = mean[1];
    *out_agreed = s->product - b * s->sum[0] - a * s->sum[1] + s->n * a * b;
    *out_total = s->square - a * s->sum[0] - b * s->sum[1] + 0.5f * s->n * (a * a + b * b);
}

/* The correlation of the excess in the halves, as far as it is beyond chance. */
static float correlation(const lf_reconstruction *r, int number, const lf_cell *cell)
{
    const lf_bright_cell sum = sum_around(r, number, cell);
    float mean[2] = {0}, agreed, total, part, variance = 0.0f;
    for (int h = 0; h < 2 && sum.n > 0.0f; h++)
        mean[h] = sum.sum[h] / sum.n;
    spread_of(&sum, mean, &agreed, &total);
    if (!(total > 1e-6f * sum.n && agreed > 0.0f))
        return 0.0f;
    for (int n = 0; n < 27; n++) {
        const lf_bright_cell *other = around(r, number, cell, n, &part);
        float own = 0.0f, all = 0.0f;
        if (other)
            spread_of(other, mean, &own, &all);
        float off = part * (own - agreed / total * all);
        variance += off * off;
    }
    return (agreed - DOUBT * sqrtf(variance)) / total;
}

static float step_between(float x, float least, float enough)
{
    return fminf(1.0f, fmaxf(0.0f, (x - least) / (enough - least)));
}

void lf_bright_settle(lf_reconstruction *r, int number)
{
    lf_band *band = &r->level[1].bands[number];
    for (int i = 0; i < band->n; i++) {
        const float rho = correlation(r, number, &band->cells[i]);
        band->cells[i].bright = step_between(rho, LEAST, ENOUGH);
        r->bright[number].cells[i].trust = step_between(rho, LEAST_TRUSTED, TRUSTED);
    }
}

bool lf_bright_anywhere(const lf_reconstruction *r)
{
    for (int b = 0; b < r->level[1].n_bands; b++)
        for (int i = 0; i < r->level[1].bands[b].n; i++)
            if (r->level[1].bands[b].cells[i].bright > 0.0f)
                return true;
    return false;
}

/* --------------------------------------------------------------------------- above and below -- */

/* The cell of level 1 that a pixel is in; NULL: none. */
static const lf_bright_cell *cell_at(const lf_reconstruction *r, const lf_pixels *pixels, int row,
                                     size_t i)
{
    int number = row / LF_CELL_SIDE / 2;
    int at = lf_band_find(&r->level[1].bands[number], lf_half_of(pixels->u[i]),
                          lf_half_of(pixels->z[i]));
    return at >= 0 ? &r->bright[number].cells[at] : NULL;
}

static float answer_of(const lf_fitted *x, int h)
{
    return x->over[h] > 0.0f ? mean_of(x->answer[h]) : 0.0f;
}

/* The part of half h's value that is at most `most`. */
static float part_below(const lf_fitted *x, int h, float most)
{
    float r = answer_of(x, h);
    return r > most ? most / r : 1.0f;
}

void lf_bright_bound(const lf_reconstruction *r, const lf_pixels *pixels, int row, size_t i,
                     lf_fitted *x)
{
    const lf_bright_cell *cell = cell_at(r, pixels, row, i);
    for (int h = 0; h < 2 && cell; h++) {
        float part = part_below(x, h, cell->bound);
        for (int c = 0; c < 3 && part < 1.0f; c++) {
            x->answer[h][c] *= part;
            x->found[h].n[c] *= part;
        }
    }
}

void lf_bright_split(const lf_reconstruction *r, const lf_pixels *pixels, int row, size_t i,
                     const lf_fitted *x, lf_bright_pixel *out)
{
    const lf_band *band = &r->level[0].bands[row / LF_CELL_SIDE];
    int at = lf_band_find(band, pixels->u[i], pixels->z[i]);
    out->share = at >= 0 ? band->cells[at].bright : 0.0f;
    if (!(out->share > 0.0f))
        return;
    const lf_bright_cell *cell = cell_at(r, pixels, row, i);
    const float bound = cell ? cell->bound : INFINITY, trust = cell ? cell->trust : 0.0f;
    for (int h = 0; h < 2; h++) {
        float most = AGREED * fmaxf(bound, trust * answer_of(x, 1 - h)),
              below = part_below(x, h, bound), shown = part_below(x, h, most);
        for (int c = 0; c < 3; c++) {
            float n = x->found[h].n[c] * (pixels->albedo ? pixels->albedo[i][c] : 1.0f);
            out->below[h][c] = below * n;
            out->above[h][c] = (shown - below) * n;
        }
    }
}
