/* Three answers from one film (docs/estimators.md, "Three answers"). Everything is per row: a tile is a block of
 * neighbouring columns and views of one row, so that resolving needs nothing but the row itself. */
#include <math.h>
#include <string.h>

#include "render/film.h"

enum { TILE_COLUMNS = 16, TILE_VIEWS = 4 };

#define LF_ERROR_EPSILON 1e-2

/* One row of the film as the answers see it. */
typedef struct lf_row_view {
    const lf_film *film;
    lf_film_half half[2];
    double n[2];        /* expected samples of each half */
    int n_halves;       /* halves with samples */
    int only;           /* the half that has them, when there is one */
} lf_row_view;

/* What one or both halves say of one pixel: means over n. */
typedef struct lf_sums {
    double scattered[3], w, w2, known[3], q, native[3];
} lf_sums;

/* Adds a half's sums to s. */
static void gather(const lf_row_view *r, int h, size_t pixel, lf_sums *s)
{
    const lf_film_half *half = &r->half[h];
    for (int c = 0; c < 3; c++) {
        s->scattered[c] += (double)half->scattered[pixel].n[c];
        s->known[c] += (double)half->known[pixel].b[c];
        if (half->native)
            s->native[c] += (double)half->native[pixel][c];
    }
    s->w += (double)half->scattered[pixel].w;
    s->w2 += half->w2 ? (double)half->w2[pixel] : (double)half->scattered[pixel].w;
    s->q += (double)half->known[pixel].q;
}

static void divide(lf_sums *s, double n)
{
    double inverse = 1.0 / n;
    for (int c = 0; c < 3; c++) {
        s->scattered[c] *= inverse;
        s->known[c] *= inverse;
        s->native[c] *= inverse;
    }
    s->w *= inverse;
    s->w2 *= inverse;
    s->q *= inverse;
}

/* mask: 1 half A, 2 half B, 3 both pooled. */
static void sums_of(const lf_row_view *r, unsigned mask, size_t pixel, lf_sums *s)
{
    double n = 0.0;
    memset(s, 0, sizeof *s);
    for (int h = 0; h < 2; h++) {
        if ((mask >> h & 1u) == 0 || r->n[h] == 0.0)
            continue;
        gather(r, h, pixel, s);
        n += r->n[h];
    }
    divide(s, n > 0.0 ? n : 1.0);
}

static void answer_mis(const lf_sums *s, double out[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = s->known[c] + s->scattered[c] + s->native[c];
}

/* B + q N/W; where q has not settled (0 while something was found) or nothing was found, B + N/n. */
static void answer_ratio(const lf_sums *s, bool second, double out[3])
{
    double w = second ? s->w2 : s->w;
    double factor = w > 0.0 && s->q > 0.0 ? s->q / w : 1.0;
    for (int c = 0; c < 3; c++)
        out[c] = s->known[c] + factor * s->scattered[c] + s->native[c];
}

typedef struct lf_tile {
    int view0, view1, column0, column1;
} lf_tile;

/* Compares the spread between the halves of N/W and N/W' over a tile. */
static bool second_is_better(const lf_row_view *r, const lf_tile *t)
{
    double error[2] = {0.0, 0.0};
    if (!r->film->has_w2 || r->n_halves < 2)
        return false;
    for (int view = t->view0; view < t->view1; view++) {
        for (int column = t->column0; column < t->column1; column++) {
            size_t pixel = (size_t)view * (size_t)r->film->width + (size_t)column;
            lf_sums a, b;
            sums_of(r, 1, pixel, &a);
            sums_of(r, 2, pixel, &b);
            for (int i = 0; i < 2; i++) {
                double x[3], y[3];
                answer_ratio(&a, i == 1, x);
                answer_ratio(&b, i == 1, y);
                for (int c = 0; c < 3; c++)
                    error[i] += (x[c] - y[c]) * (x[c] - y[c]);
            }
        }
    }
    return error[1] < error[0];
}

/* Regression coefficients of one half over one tile: N - n q R on R (W - n q) and R (W' - n q), R the tile's N/W. */
typedef struct lf_beta {
    double ratio[3];   /* R */
    double lambda[2];
} lf_beta;

static void regress(const lf_row_view *r, int h, const lf_tile *t, lf_beta *beta)
{
    double n[3] = {0}, w = 0.0, a11 = 0.0, a12 = 0.0, a22 = 0.0, y1 = 0.0, y2 = 0.0;
    memset(beta, 0, sizeof *beta);
    for (int pass = 0; pass < 2; pass++) {
        for (int view = t->view0; view < t->view1; view++) {
            for (int column = t->column0; column < t->column1; column++) {
                lf_sums s;
                sums_of(r, 1u << h, (size_t)view * (size_t)r->film->width + (size_t)column, &s);
                w += pass == 0 ? s.w : 0.0;
                for (int c = 0; c < 3; c++) {
                    n[c] += pass == 0 ? s.scattered[c] : 0.0;
                    double x1 = beta->ratio[c] * (s.w - s.q), x2 = beta->ratio[c] * (s.w2 - s.q);
                    double y = s.scattered[c] - s.q * beta->ratio[c];
                    a11 += x1 * x1;
                    a12 += x1 * x2;
                    a22 += x2 * x2;
                    y1 += x1 * y;
                    y2 += x2 * y;
                }
            }
        }
        for (int c = 0; c < 3 && pass == 0; c++)
            beta->ratio[c] = w > 0.0 ? n[c] / w : 0.0;
    }
    double det = a11 * a22 - a12 * a12;
    if (r->film->has_w2 && det > 1e-6 * a11 * a22) {
        beta->lambda[0] = (a22 * y1 - a12 * y2) / det;
        beta->lambda[1] = (a11 * y2 - a12 * y1) / det;
    } else if (a11 > 0.0) {
        beta->lambda[0] = y1 / a11;
    }
    /* Any coefficients of the other half keep the estimate unbiased; wild ones only make it noisy. */
    for (int i = 0; i < 2; i++)
        beta->lambda[i] = fmin(fmax(beta->lambda[i], -1.0), 2.0);
}

/* One half of CV+: (N - beta_other (W - n q))/n; with one half alone there is no other, and beta is 0. */
static void answer_cv(const lf_row_view *r, size_t pixel, const lf_beta beta[2], double out[3])
{
    double weight[2] = {r->n[0] / (r->n[0] + r->n[1]), r->n[1] / (r->n[0] + r->n[1])};
    out[0] = out[1] = out[2] = 0.0;
    for (int h = 0; h < 2; h++) {
        if (r->n[h] == 0.0)
            continue;
        lf_sums s;
        sums_of(r, 1u << h, pixel, &s);
        const lf_beta *b = &beta[1 - h];
        for (int c = 0; c < 3; c++) {
            double control = b->ratio[c] * (b->lambda[0] * (s.w - s.q) + b->lambda[1] * (s.w2 - s.q));
            out[c] += weight[h] * (s.known[c] + s.scattered[c] - control + s.native[c]);
        }
    }
}

static void resolve_pixel(const lf_row_view *r, lf_estimator estimator, size_t pixel, bool second, const lf_beta beta[2],
                          unsigned mask, double out[3])
{
    lf_sums s;
    if (estimator == LF_ESTIMATOR_CV && mask == 3u) {
        answer_cv(r, pixel, beta, out);
        return;
    }
    sums_of(r, mask, pixel, &s);
    if (estimator == LF_ESTIMATOR_MWIS)
        answer_ratio(&s, second, out);
    else
        answer_mis(&s, out);
}

/* Flags of a pixel; a hole is where scattering is possible and no weight has arrived. */
static uint8_t flags_of(const lf_row_view *r, size_t pixel)
{
    float q = 0.0f, w = 0.0f;
    for (int h = 0; h < 2; h++) {
        if (r->n[h] == 0.0)
            continue;
        q += r->half[h].known[pixel].q;
        w += r->half[h].scattered[pixel].w;
    }
    if (w > 0.0f)
        return 0;
    return q > 0.0f ? LF_PIXEL_HOLE : LF_PIXEL_SETTLED;
}

/* (x_A - x_B)^2/4 over I^2 + epsilon, mean over channels. For cv the halves answer as mis does, an upper bound. */
static double relative_error(const lf_row_view *r, lf_estimator estimator, size_t pixel, bool second, const double answer[3])
{
    double a[3], b[3], sum = 0.0;
    resolve_pixel(r, estimator == LF_ESTIMATOR_CV ? LF_ESTIMATOR_MWIS : estimator, pixel, second, NULL, 1u, a);
    resolve_pixel(r, estimator == LF_ESTIMATOR_CV ? LF_ESTIMATOR_MWIS : estimator, pixel, second, NULL, 2u, b);
    for (int c = 0; c < 3; c++)
        sum += 0.25 * (a[c] - b[c]) * (a[c] - b[c]) / (answer[c] * answer[c] + LF_ERROR_EPSILON);
    return sum / 3.0;
}

static void resolve_tile(const lf_row_view *r, lf_estimator estimator, const lf_tile *t, float *out, uint8_t *flags,
                         lf_film_row *state)
{
    lf_beta beta[2] = {{{0}, {0}}, {{0}, {0}}};
    bool second = estimator != LF_ESTIMATOR_MIS && second_is_better(r, t);
    if (estimator == LF_ESTIMATOR_CV && r->n_halves == 2) {
        regress(r, 0, t, &beta[0]);
        regress(r, 1, t, &beta[1]);
    }
    for (int view = t->view0; view < t->view1; view++) {
        for (int column = t->column0; column < t->column1; column++) {
            size_t pixel = (size_t)view * (size_t)r->film->width + (size_t)column;
            double answer[3];
            resolve_pixel(r, estimator, pixel, second, beta, 3u, answer);
            for (int c = 0; c < 3; c++)
                out[3 * pixel + (size_t)c] = (float)answer[c];
            uint8_t f = flags_of(r, pixel);
            state->holes += f == LF_PIXEL_HOLE;
            if (flags)
                flags[pixel] = f;
            if (r->n_halves == 2)
                state->relative_error += relative_error(r, estimator, pixel, second, answer);
        }
    }
}

lf_status lf_film_resolve_row(const lf_film *film, lf_estimator estimator, int row, float *out, uint8_t *flags)
{
    lf_film_row *state = &film->rows[row];
    size_t pixels = (size_t)film->n_views * (size_t)film->width;
    lf_row_view r = {.film = film, .n = {state->n[0], state->n[1]}};
    if (state->n[0] + state->n[1] == 0.0) {
        memset(out, 0, 3 * pixels * sizeof *out);
        if (flags)
            memset(flags, LF_PIXEL_UNSEEN, pixels);
        return LF_E_STATE;
    }
    for (int h = 0; h < 2; h++) {
        r.half[h] = lf_film_at(film, row, h);
        r.n_halves += r.n[h] > 0.0;
    }
    state->holes = 0;
    state->relative_error = r.n_halves == 2 ? 0.0 : -1.0;
    for (int view = 0; view < film->n_views; view += TILE_VIEWS) {
        for (int column = 0; column < film->width; column += TILE_COLUMNS) {
            lf_tile t = {view, view + TILE_VIEWS, column, column + TILE_COLUMNS};
            t.view1 = t.view1 < film->n_views ? t.view1 : film->n_views;
            t.column1 = t.column1 < film->width ? t.column1 : film->width;
            resolve_tile(&r, estimator, &t, out, flags, state);
        }
    }
    return LF_OK;
}
