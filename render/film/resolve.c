/* Three estimates from one film (docs/developer/estimators.md, "8. Three estimators"). Everything
 * is per row: a tile is a block of neighbouring columns and views of one row, so that resolving
 * needs only the row itself. */
#include <assert.h>
#include <math.h>
#include <string.h>

#include "render/film/film.h"
#include "render/film/film_difference.h"
#include "render/film/median.h"
#include "render/film/tile.h"

enum { BESIDE = LF_TILE_BESIDE, AROUND = LF_TILE_COLUMNS + 2 * BESIDE };
/* Size of the neighbourhood in which one half is searched for light that the other has met: views
 * and columns to either side. */
enum {
    NEAR_VIEWS = 2,
    NEAR_COLUMNS = 1,
    NEAR_ACROSS = LF_TILE_COLUMNS + 2 * NEAR_COLUMNS,
    NEAR_PLACES = (LF_TILE_VIEWS + 2 * NEAR_VIEWS) * NEAR_ACROSS
};

/* Source of I in the error's denominator. SCALE_MEDIAN: the row's medians only, for maps of counts
 * (which must not depend on other rows) and films made by them. SCALE_ROW: also light that the
 * halves agree on in the row. SCALE_ROWS: also in the neighbouring rows, which must not be visited
 * at the same time. */
typedef enum lf_scale_of { SCALE_MEDIAN, SCALE_ROW, SCALE_ROWS } lf_scale_of;

/* Squared difference of known light between the halves, relative to its square, that is negligible:
 * it changes the error by less than a hundredth. */
#define NEGLIGIBLE 1e-4

static size_t pixel_index(const lf_tile *t, int i)
{
    int columns = t->column1 - t->column0;
    return (size_t)(t->view0 + i / columns) * (size_t)t->film->width +
           (size_t)(t->column0 + i % columns);
}

static void read_half(const lf_film_half *half, size_t pixel, float inverse, lf_sums *s)
{
    assert(half->scattered && half->q);
    for (int c = 0; c < 3; c++)
        s->scattered[c] = half->scattered[pixel].n[c] * inverse;
    s->w = half->scattered[pixel].w * inverse;
    s->w2 = half->w2 ? half->w2[pixel] * inverse : s->w;
    s->q = half->q[pixel];
}

static void pool(lf_tile_pixel *p, const float share[2], const float share_known[2])
{
    const lf_sums *a = &p->half[0], *b = &p->half[1];
    for (int c = 0; c < 3; c++)
        p->pooled.scattered[c] = share[0] * a->scattered[c] + share[1] * b->scattered[c];
    p->pooled.w = share[0] * a->w + share[1] * b->w;
    p->pooled.w2 = share[0] * a->w2 + share[1] * b->w2;
    p->pooled.q = share_known[0] * a->q + share_known[1] * b->q;
}

/* B + M/n of the halves and of both. */
static void read_known(const lf_tile *t, size_t pixel, lf_tile_pixel *p)
{
    float difference[3] = {0};
    const float *sky = t->film->sky;
    if (t->known)
        lf_difference_unpack(t->known[pixel].difference, difference);
    for (int c = 0; c < 3; c++) {
        if (t->known) {
            p->pooled.known[c] = t->known[pixel].b[c];
            p->half[0].known[c] = p->pooled.known[c] + t->share_known[1] * difference[c];
            p->half[1].known[c] = p->pooled.known[c] - t->share_known[0] * difference[c];
        } else {
            p->pooled.known[c] = sky[c] * (1.0f - p->pooled.q);
            for (int h = 0; h < 2; h++)
                p->half[h].known[c] = sky[c] * (1.0f - p->half[h].q);
        }
    }
}

enum { POOLED = 2 };

static const lf_sums *sums_of(const lf_tile_pixel *p, int which)
{
    return which == POOLED ? &p->pooled : &p->half[which];
}

/* N/W of a whole tile: of a half, or of both. */
static void tile_ratio(const lf_tile *t, int which, double ratio[3])
{
    double n[3] = {0}, w = 0.0;
    for (int i = 0; i < t->count; i++) {
        const lf_sums *s = sums_of(&t->pixel[i], which);
        w += (double)s->w;
        for (int c = 0; c < 3; c++)
            n[c] += (double)s->scattered[c];
    }
    for (int c = 0; c < 3; c++)
        ratio[c] = w > 0.0 ? n[c] / w : 0.0;
}

static void read_tile(lf_tile *t)
{
    t->count = (t->view1 - t->view0) * (t->column1 - t->column0);
    for (int i = 0; i < t->count; i++) {
        lf_tile_pixel *p = &t->pixel[i];
        for (int h = 0; h < 2; h++) {
            p->half[h] = (lf_sums){0};
            if (t->n[h] > 0.0f)
                read_half(&t->half[h], pixel_index(t, i), 1.0f / t->n[h], &p->half[h]);
        }
        pool(p, t->share, t->share_known);
        read_known(t, pixel_index(t, i), p);
    }
    for (int which = 0; which <= POOLED && t->film->layout.has_signed; which++)
        tile_ratio(t, which, t->ratio[which]);
}

static void answer_mis(const lf_sums *s, float out[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = s->known[c] + s->scattered[c];
}

/* B + q N/W, and B if no radiance was received. B and q come from the same film points. If none of
 * them has met a scatterer, q is 0 and B is the whole background; the light that other paths have
 * found there is counted in pixels where q is too high. If weights have both signs, a W that is
 * small relative to q may be a remainder of cancellation, and N/W arbitrary; then the tile's ratio
 * replaces it. */
static void answer_ratio(const lf_tile *t, int i, int which, bool second, float out[3])
{
    const lf_sums *s = sums_of(&t->pixel[i], which);
    float w = lf_sums_weight(s, second), share = w > 0.0f ? s->q / w : 0.0f;
    bool cancelled = t->film->layout.has_signed && w != 0.0f && w < 0.25f * s->q;
    for (int c = 0; c < 3; c++)
        out[c] =
            s->known[c] + (cancelled ? s->q * (float)t->ratio[which][c] : share * s->scattered[c]);
}

/* Compares the spread between the halves of N/W and N/W' over a tile. */
static bool second_is_better(const lf_tile *t)
{
    double error[2] = {0.0, 0.0};
    if (!t->film->layout.has_w2 || t->n_halves < 2)
        return false;
    for (int i = 0; i < t->count; i++) {
        for (int j = 0; j < 2; j++) {
            float x[3], y[3];
            answer_ratio(t, i, 0, j == 1, x);
            answer_ratio(t, i, 1, j == 1, y);
            for (int c = 0; c < 3; c++)
                error[j] += (double)((x[c] - y[c]) * (x[c] - y[c]));
        }
    }
    return error[1] < error[0];
}

/* The i-th pixel's CV+ of a half, by the other half's coefficients. */
static void answer_half_cv(const lf_sums *s, int i, const lf_beta *other, double out[3])
{
    double control =
        other->lambda[0] * (double)(s->w - s->q) + other->lambda[1] * (double)(s->w2 - s->q);
    for (int c = 0; c < 3; c++)
        out[c] = (double)s->scattered[c] - other->ratio[i][c] * control;
}

/* Known light and the halves' CV+ by their shares; with only one half, beta is 0. */
static void answer_cv(const lf_tile *t, int i, const lf_beta beta[2], float out[3])
{
    const lf_tile_pixel *p = &t->pixel[i];
    double half[2][3];
    for (int h = 0; h < 2; h++)
        answer_half_cv(&p->half[h], i, &beta[1 - h], half[h]);
    for (int c = 0; c < 3; c++)
        out[c] = (float)((double)p->pooled.known[c] + (double)t->share[0] * half[0][c] +
                         (double)t->share[1] * half[1][c]);
}

/* A hole: scattering is possible and no weight has arrived. */
static uint8_t flags_of(const lf_sums *s)
{
    if (s->w != 0.0f)
        return 0;
    return s->q > 0.0f ? LF_PIXEL_HOLE : LF_PIXEL_SETTLED;
}

/* ------------------------------------------------------------------------------------ errors -- */

/* Data for resolving a tile's pixels. */
typedef struct lf_tile_answers {
    lf_estimator estimator;
    bool second; /* W' is the better weight */
    lf_beta beta[2];
    float pixel[LF_TILE_VIEWS * LF_TILE_COLUMNS][3];
    /* of the tile and LF_TILE_BESIDE columns around it */
    float radiance[3][LF_TILE_VIEWS * AROUND];
    lf_scale_of scale;
    bool has_near;
    double near[2][3][NEAR_PLACES]; /* sums over rows of the fourth power of R, of the halves */
} lf_tile_answers;

static void answer_half(const lf_tile *t, const lf_tile_answers *a, int i, int h, double out[3])
{
    const lf_tile_pixel *p = &t->pixel[i];
    float y[3] = {0};
    if (a->estimator == LF_ESTIMATOR_CV)
        answer_half_cv(&p->half[h], i, &a->beta[1 - h], out);
    else if (a->estimator == LF_ESTIMATOR_MIS)
        answer_mis(&p->half[h], y);
    else
        answer_ratio(t, i, h, a->second, y);
    for (int c = 0; c < 3; c++)
        out[c] =
            a->estimator == LF_ESTIMATOR_CV ? out[c] + (double)p->half[h].known[c] : (double)y[c];
}

/* The lower median of the non-negative numbers among five; -1: none. */
static float lower_median(const float x[5])
{
    float sorted[5];
    int n = 0;
    float lowest = lf_least(lf_least(lf_least(x[0], x[1]), lf_least(x[2], x[3])), x[4]);
    if (lowest >= 0.0f)
        return lf_median_of_five(x);
    for (int i = 0; i < 5; i++) {
        int k = n;
        if (x[i] < 0.0f)
            continue;
        for (n++; k > 0 && sorted[k - 1] > x[i]; k--)
            sorted[k] = sorted[k - 1];
        sorted[k] = x[i];
    }
    return n > 0 ? sorted[(n - 1) / 2] : -1.0f;
}

/* R of a pixel's halves and of both together; -1: no radiance was received, or outside the image.
 */
static void read_ratios(const lf_tile *t, const lf_tile_answers *a, const lf_film_half half[2],
                        int view, int column, float out[3][3])
{
    size_t pixel = (size_t)view * (size_t)t->film->width + (size_t)(ptrdiff_t)column;
    lf_sums s[3] = {{.w = 0.0f}, {.w = 0.0f}, {.w = 0.0f}};
    for (int h = 0; h < 2 && column >= 0 && column < t->film->width; h++)
        if (t->n[h] > 0.0f)
            read_half(&half[h], pixel, 1.0f, &s[h]);
    s[POOLED].w = s[0].w + s[1].w;
    s[POOLED].w2 = s[0].w2 + s[1].w2;
    for (int c = 0; c < 3; c++)
        s[POOLED].scattered[c] = s[0].scattered[c] + s[1].scattered[c];
    for (int k = 0; k <= POOLED; k++) {
        float w = lf_sums_weight(&s[k], a->second), inverse = w > 0.0f ? 1.0f / w : 0.0f;
        for (int c = 0; c < 3; c++)
            out[k][c] = w > 0.0f ? s[k].scattered[c] * inverse : -1.0f;
    }
}

/* R of both halves in a tile, and in two columns to either side. */
static void read_radiance(const lf_tile *t, lf_tile_answers *a)
{
    const lf_film_half half[2] = {t->half[0], t->half[1]};
    for (int view = t->view0; view < t->view1; view++) {
        for (int column = t->column0 - BESIDE; column < t->column1 + BESIDE; column++) {
            int at = (view - t->view0) * AROUND + column - t->column0 + BESIDE;
            float r[3][3];
            read_ratios(t, a, half, view, column, r);
            for (int c = 0; c < 3; c++)
                a->radiance[c][at] = r[POOLED][c];
        }
    }
}

static void answer_tile(const lf_tile *t, lf_estimator estimator, lf_scale_of scale,
                        lf_tile_answers *a)
{
    a->estimator = estimator;
    a->scale = scale;
    a->has_near = false;
    a->second = second_is_better(t);
    for (int h = 0; h < 2 && estimator == LF_ESTIMATOR_CV; h++)
        if (t->n_halves == 2)
            lf_tile_regress(t, h, &a->beta[h]);
        else
            memset(&a->beta[h], 0, sizeof a->beta[h]);
    for (int i = 0; i < t->count; i++)
        if (estimator == LF_ESTIMATOR_CV)
            answer_cv(t, i, a->beta, a->pixel[i]);
        else if (estimator == LF_ESTIMATOR_MIS)
            answer_mis(&t->pixel[i].pooled, a->pixel[i]);
        else
            answer_ratio(t, i, POOLED, a->second, a->pixel[i]);
    if (t->n_halves == 2)
        read_radiance(t, a);
}

/* Adds the radiance of the halves in one view of one row that is far above the median of five. */
static void add_near(const lf_tile *t, const lf_film_half half[2], int view, double *near,
                     lf_tile_answers *a)
{
    enum { READ = NEAR_ACROSS + 2 * BESIDE };
    float all[3][READ], said[2][3][READ];
    for (int k = 0; k < READ; k++) {
        float r[3][3];
        read_ratios(t, a, half, view, t->column0 - NEAR_COLUMNS - BESIDE + k, r);
        for (int c = 0; c < 3; c++) {
            all[c][k] = r[POOLED][c];
            said[0][c][k] = r[0][c];
            said[1][c][k] = r[1][c];
        }
    }
    for (int i = 0; i < 6 * NEAR_ACROSS; i++) {
        int h = i / (3 * NEAR_ACROSS), c = i / NEAR_ACROSS % 3, k = i % NEAR_ACROSS;
        float median = lf_most(0.0f, lower_median(&all[c][k]));
        double r = (double)said[h][c][k + BESIDE];
        if (r > 4.0 * (double)median)
            near[(h * 3 + c) * NEAR_PLACES + k] += r * r * r * r;
    }
}

/* Outstanding radiance of each half near the tile's pixels, in this row and in the neighbouring
 * rows. Light that is bright everywhere, such as a lit ground next to a shadow, gives no
 * information about a pixel. */
static void read_near(const lf_tile *t, lf_tile_answers *a)
{
    int rows = a->scale == SCALE_ROWS ? 1 : 0;
    memset(a->near, 0, sizeof a->near);
    a->has_near = true;
    for (int row = t->row - rows; row <= t->row + rows; row++) {
        if (row < 0 || row >= t->film->height)
            continue;
        lf_film_open(t->film, row);
        const lf_film_half half[2] = {lf_film_at(t->film, row, 0), lf_film_at(t->film, row, 1)};
        for (int k = 0; k < LF_TILE_VIEWS + 2 * NEAR_VIEWS; k++) {
            int view = t->view0 - NEAR_VIEWS + k;
            if (view >= 0 && view < t->film->n_views)
                add_near(t, half, view, &a->near[0][0][k * NEAR_ACROSS], a);
        }
        lf_film_close(t->film, row, false);
    }
}

/* Number of the `around` positions to either side that are in 0 to n - 1. */
static int places(int at, int around, int n)
{
    int first = at > around ? at - around : 0, last = at + around < n ? at + around : n - 1;
    return last - first + 1;
}

/* Brightness that half h has met near a pixel: the root of the mean fourth power. This is close to
 * the maximum in a highlight, and a part of it if only one path was bright. */
static float brightness_near(const lf_tile *t, const lf_tile_answers *a, int i, int h, int c)
{
    int columns = t->column1 - t->column0, rows = a->scale == SCALE_ROWS ? 1 : 0;
    int n = places(t->row, rows, t->film->height) *
            places(t->view0 + i / columns, NEAR_VIEWS, t->film->n_views) *
            places(t->column0 + i % columns, NEAR_COLUMNS, t->film->width);
    double sum = 0.0;
    for (int v = 0; v <= 2 * NEAR_VIEWS; v++)
        for (int k = 0; k <= 2 * NEAR_COLUMNS; k++)
            sum += a->near[h][c][(i / columns + v) * NEAR_ACROSS + i % columns + k];
    return (float)sqrt(sqrt(sum / n));
}

/* R of a pixel whose halves disagree (u and v are their values): each is trusted as far as the
 * other has met similar light near the pixel, and at least the median. Light that only one half has
 * met is mostly too bright for the pixel, so R lies between the two. */
static float confirmed(const lf_tile *t, lf_tile_answers *a, int i, int c, const float said[2],
                       float median)
{
    float x[2];
    if (a->scale == SCALE_MEDIAN || !(lf_most(said[0], said[1]) > median))
        return median;
    if (!a->has_near)
        read_near(t, a);
    for (int h = 0; h < 2; h++)
        x[h] = lf_most(median, lf_least(said[h], brightness_near(t, a, i, 1 - h, c)));
    float high = lf_most(x[0], x[1]);
    return high > 0.0f ? cbrtf(lf_least(x[0], x[1]) / high) * high : 0.0f;
}

/* R of a pixel for the error's denominator: the median of five, clamped to the range of the pixel's
 * two halves if they agree at all. A rare bright path must not hide its own error in the
 * denominator, but only one half has met it. *out_doubt: they do not agree. */
static float steady_radiance(const lf_tile *t, lf_tile_answers *a, int i, int c, bool *out_doubt)
{
    int columns = t->column1 - t->column0;
    const lf_sums *x = &t->pixel[i].half[0], *y = &t->pixel[i].half[1];
    float median = lf_most(0.0f, lower_median(&a->radiance[c][i / columns * AROUND + i % columns]));
    float w[2] = {lf_sums_weight(x, a->second), lf_sums_weight(y, a->second)};
    const float said[2] = {w[0] > 0.0f ? x->scattered[c] / w[0] : 0.0f,
                           w[1] > 0.0f ? y->scattered[c] / w[1] : 0.0f};
    float low = lf_least(said[0], said[1]), high = lf_most(said[0], said[1]);
    *out_doubt = !(w[0] > 0.0f && w[1] > 0.0f) || high > 4.0f * low;
    return *out_doubt ? confirmed(t, a, i, c, said, median) : lf_most(low, lf_least(high, median));
}

/* The darkest known light of a pixel and two to either side. */
static float darkest(const lf_tile *t, int i, int c)
{
    int column = t->column0 + i % (t->column1 - t->column0);
    float dark = t->pixel[i].pooled.known[c];
    for (int k = column > BESIDE ? -BESIDE : -column;
         k <= BESIDE && column + k < t->film->width && t->known; k++)
        dark = lf_least(dark, t->known[pixel_index(t, i) + (size_t)(ptrdiff_t)k].b[c]);
    return dark;
}

/* Known light without rare bright paths in a mirror, which only one half has found, and no
 * neighbour in this view or the next ones. */
static float believed(const lf_tile *t, int i, int c)
{
    int columns = t->column1 - t->column0, column = t->column0 + i % columns;
    const lf_tile_pixel *p = &t->pixel[i];
    float known = p->pooled.known[c],
          enough = 2.0f * lf_least(p->half[0].known[c], p->half[1].known[c]);
    for (int view = t->view0; view < t->view1; view++) {
        for (int k = column > 0 ? column - 1 : 0;
             k <= column + 1 && k < t->film->width && enough < known; k++) {
            size_t pixel = (size_t)view * (size_t)t->film->width + (size_t)k;
            enough = pixel == pixel_index(t, i) ? enough : lf_most(enough, t->known[pixel].b[c]);
        }
    }
    return lf_least(known, enough);
}

/* I^2 + epsilon of a channel, over what its inverse is expected to be more than that
 * (docs/developer/estimators.md, "10. The error estimate"). */
static double scale_of(const lf_tile *t, lf_tile_answers *a, int i, int c, bool *out_doubt)
{
    const lf_tile_pixel *p = &t->pixel[i];
    float scattered = p->pooled.q * steady_radiance(t, a, i, c, out_doubt),
          difference = p->half[0].known[c] - p->half[1].known[c];
    float known = t->film->layout.has_native ? believed(t, i, c) : p->pooled.known[c];
    double x = (double)known + (double)scattered, scale = x * x + LF_ERROR_EPSILON;
    double d = (double)(t->share[0] * t->share[1]) * (double)difference * (double)difference,
           k = (double)known * (double)known;
    if (!(d > NEGLIGIBLE * k))
        return scale;
    double dark = (double)darkest(t, i, c) + (double)scattered, lone = d < k ? d / k : 1.0;
    return scale / (1.0 + 0.9 * lone * sqrt(sqrt(k / (dark * dark + LF_ERROR_EPSILON))));
}

/* The difference of the halves, scaled so that its square is the error of their mean: sqrt(s_A s_B
 * / (I^2 + epsilon)) (x_A - x_B). out_known: the same for their known light; out_doubt: I was
 * guessed. */
static void difference(const lf_tile *t, lf_tile_answers *a, int i, float out[3],
                       float out_known[3], bool out_doubt[3])
{
    double x[2][3], share = (double)t->share[0] * (double)t->share[1];
    const lf_tile_pixel *p = &t->pixel[i];
    answer_half(t, a, i, 0, x[0]);
    answer_half(t, a, i, 1, x[1]);
    for (int c = 0; c < 3; c++) {
        double factor = sqrt(share / scale_of(t, a, i, c, &out_doubt[c]));
        out[c] = (float)((x[0][c] - x[1][c]) * factor);
        out_known[c] = (float)((double)(p->half[0].known[c] - p->half[1].known[c]) * factor);
    }
}

static double relative_error(const lf_tile *t, lf_tile_answers *a, int i)
{
    float d[3], known[3];
    bool doubt[3];
    difference(t, a, i, d, known, doubt);
    return (double)(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) / 3.0;
}

/* -------------------------------------------------------------------------------------- rows -- */

static void resolve_tile(lf_tile *t, lf_estimator estimator, float *out, uint8_t *flags,
                         lf_film_row *state)
{
    lf_tile_answers a;
    read_tile(t);
    answer_tile(t, estimator, SCALE_ROW, &a);
    for (int i = 0; i < t->count; i++) {
        size_t pixel = pixel_index(t, i);
        memcpy(out + 3 * pixel, a.pixel[i], sizeof a.pixel[i]);
        uint8_t f = flags_of(&t->pixel[i].pooled);
        state->holes += f == LF_PIXEL_HOLE;
        if (flags)
            flags[pixel] = f;
        if (t->n_halves == 2)
            state->relative_error += relative_error(t, &a, i);
    }
}

/* Opens a row of the film for reading its tiles; the caller closes it. false: the row has no visit,
 * and is not open. */
static bool open_row(lf_tile *t, const lf_film *film, int row)
{
    const lf_film_row *state = &film->rows[row];
    double n = state->n[0] + state->n[1], known[2];
    *t = (lf_tile){.film = film, .row = row};
    if (!(n > 0.0))
        return false;
    lf_film_open(film, row);
    t->known = lf_film_known_at(film, row);
    lf_film_row_known(state, known);
    for (int h = 0; h < 2; h++) {
        t->half[h] = lf_film_at(film, row, h);
        t->share_known[h] = (float)(known[h] / (known[0] + known[1]));
        t->n[h] = (float)state->n[h];
        t->share[h] = (float)(state->n[h] / n);
        t->n_halves += state->n[h] > 0.0;
    }
    return true;
}

/* open_row for rows with visits of both halves. */
static bool open_both(lf_tile *t, const lf_film *film, int row)
{
    if (!(film->rows[row].n[0] > 0.0 && film->rows[row].n[1] > 0.0))
        return false;
    return open_row(t, film, row);
}

/* The bounds of tile i among all. false after the last. */
static bool at_tile(lf_tile *t, int i)
{
    int across = (t->film->width + LF_TILE_COLUMNS - 1) / LF_TILE_COLUMNS;
    t->view0 = i / across * LF_TILE_VIEWS;
    t->column0 = i % across * LF_TILE_COLUMNS;
    t->view1 =
        t->view0 + LF_TILE_VIEWS < t->film->n_views ? t->view0 + LF_TILE_VIEWS : t->film->n_views;
    t->column1 = t->column0 + LF_TILE_COLUMNS < t->film->width ? t->column0 + LF_TILE_COLUMNS
                                                               : t->film->width;
    return t->view0 < t->film->n_views;
}

lf_status lf_film_resolve_row(const lf_film *film, lf_estimator estimator, int row, float *out,
                              uint8_t *flags)
{
    lf_film_row *state = &film->rows[row];
    size_t pixels = (size_t)film->n_views * (size_t)film->width;
    lf_tile t;
    if (!open_row(&t, film, row)) {
        memset(out, 0, 3 * pixels * sizeof *out);
        if (flags)
            memset(flags, LF_PIXEL_UNSEEN, pixels);
        return LF_E_STATE;
    }
    state->holes = 0;
    state->relative_error = t.n_halves == 2 ? 0.0 : -1.0;
    for (int i = 0; at_tile(&t, i); i++)
        resolve_tile(&t, estimator, out, flags, state);
    lf_film_close(film, row, false);
    return LF_OK;
}

void lf_film_row_errors(const lf_film *film, int row, float *out_error, float *out_q)
{
    lf_tile t;
    if (!open_both(&t, film, row))
        return;
    for (int k = 0; at_tile(&t, k); k++) {
        lf_tile_answers a;
        read_tile(&t);
        answer_tile(&t, LF_ESTIMATOR_MWIS, SCALE_MEDIAN, &a);
        for (int i = 0; i < t.count; i++) {
            out_error[pixel_index(&t, i)] = (float)relative_error(&t, &a, i);
            out_q[pixel_index(&t, i)] = t.pixel[i].pooled.q;
        }
    }
    lf_film_close(film, row, false);
}

bool lf_film_row_differences(const lf_film *film, lf_estimator estimator, int row, float *out,
                             lf_row_error *out_row)
{
    lf_tile t;
    double sum = 0.0, doubtful = 0.0, n = 3.0 * film->n_views * film->width;
    if (!open_both(&t, film, row))
        return false;
    for (int k = 0; at_tile(&t, k); k++) {
        lf_tile_answers a;
        read_tile(&t);
        answer_tile(&t, estimator, SCALE_ROWS, &a);
        for (int i = 0; i < t.count; i++) {
            float known[3], *d = out + 3 * pixel_index(&t, i);
            bool doubt[3];
            difference(&t, &a, i, d, known, doubt);
            for (int c = 0; c < 3; c++) {
                sum += (double)lf_least(d[c] * d[c], known[c] * known[c]);
                doubtful += doubt[c] ? (double)(d[c] * d[c]) : 0.0;
            }
        }
    }
    lf_film_close(film, row, false);
    out_row->known = sum / n;
    out_row->doubtful = doubtful / n;
    return true;
}

void lf_film_row_variances(const lf_film *film, lf_estimator estimator, int row, float *out,
                           size_t stride)
{
    lf_tile t;
    if (!open_both(&t, film, row))
        return;
    double share = (double)t.share[0] * (double)t.share[1], x[2][3];
    for (int k = 0; at_tile(&t, k); k++) {
        lf_tile_answers a;
        read_tile(&t);
        answer_tile(&t, estimator, SCALE_MEDIAN, &a);
        for (int i = 0; i < t.count; i++) {
            answer_half(&t, &a, i, 0, x[0]);
            answer_half(&t, &a, i, 1, x[1]);
            for (int c = 0; c < 3; c++)
                out[pixel_index(&t, i) * stride + (size_t)c] =
                    (float)(share * (x[0][c] - x[1][c]) * (x[0][c] - x[1][c]));
        }
    }
    lf_film_close(film, row, false);
}
