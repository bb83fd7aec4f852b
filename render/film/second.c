/* Where N/W' is less noisy than N/W, for the reconstruction, which needs whole rows several times
 * per fit: read directly from the film, column by column without a branch, so that compilers
 * vectorise it. */
#include <string.h>

#include "render/film/film.h"
#include "render/film/median.h"
#include "render/film/tile.h"

/* A row with samples in both halves. */
typedef struct lf_open_halves {
    lf_film_half half[2];
    float inverse[2];     /* 1/n */
    float share_known[2]; /* of the samples that q is a mean over */
} lf_open_halves;

/* Columns side by side: what a half has found, W and W' as N is divided by them, over n. */
typedef struct lf_lanes {
    float n[3][LF_TILE_COLUMNS], w[2][LF_TILE_COLUMNS];
} lf_lanes;

/* Squared differences of the halves' N/W and N/W', for each channel and column. */
typedef struct lf_apart {
    float square[2][3][LF_TILE_COLUMNS];
} lf_apart;

/* The caller closes the row; false: it was not opened. */
static bool open_halves(const lf_film *film, int row, lf_open_halves *out)
{
    const lf_film_row *state = &film->rows[row];
    double known[2];
    if (!(state->n[0] > 0.0 && state->n[1] > 0.0))
        return false;
    lf_film_row_known(state, known);
    lf_film_open(film, row);
    for (int h = 0; h < 2; h++) {
        out->half[h] = lf_film_at(film, row, h);
        out->inverse[h] = 1.0f / (float)state->n[h];
        out->share_known[h] = (float)(known[h] / (known[0] + known[1]));
    }
    return true;
}

static void read_lanes(const lf_open_halves *o, int h, size_t first, int n, lf_lanes *out)
{
    const lf_film_scattered *s = o->half[h].scattered + first;
    const float *w2 = o->half[h].w2 + first, inverse = o->inverse[h];
    for (int i = 0; i < n; i++) {
        for (int c = 0; c < 3; c++)
            out->n[c][i] = s[i].n[c] * inverse;
        out->w[0][i] = s[i].w * inverse;
        out->w[1][i] = w2[i] * inverse;
    }
    for (int i = 0; i < LF_TILE_COLUMNS; i++)
        out->w[1][i] = lf_film_weight(out->w[0][i], out->w[1][i], true);
}

/* For the three channels, N of the halves over w; not valid if w is not above 0. In separate steps,
 * because compilers do not vectorise it as a whole. */
static void square(const float *restrict q, const lf_lanes *restrict a, const lf_lanes *restrict b,
                   int j, float (*restrict out)[LF_TILE_COLUMNS])
{
    float least[LF_TILE_COLUMNS], over_a[LF_TILE_COLUMNS], over_b[LF_TILE_COLUMNS];
    for (int i = 0; i < LF_TILE_COLUMNS; i++)
        least[i] = lf_least(a->w[j][i], b->w[j][i]);
    for (int i = 0; i < LF_TILE_COLUMNS; i++)
        over_a[i] = least[i] > 0.0f ? a->w[j][i] : 1.0f;
    for (int i = 0; i < LF_TILE_COLUMNS; i++)
        over_b[i] = least[i] > 0.0f ? b->w[j][i] : 1.0f;
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < LF_TILE_COLUMNS; i++) {
            const float d = q[i] * (a->n[c][i] / over_a[i] - b->n[c][i] / over_b[i]);
            out[c][i] = d * d;
        }
        for (int i = 0; i < LF_TILE_COLUMNS; i++)
            out[c][i] = least[i] > 0.0f ? out[c][i] : 0.0f;
    }
}

/* Columns [first, first + n) of one view, by R alone: the features of the halves are not compared.
 */
static void compare(const lf_open_halves *o, size_t first, int n, lf_apart *out)
{
    const float *qa = o->half[0].q + first, *qb = o->half[1].q + first;
    float q[LF_TILE_COLUMNS] = {0.0f};
    lf_lanes a = {.w = {{0.0f}}}, b = a;
    read_lanes(o, 0, first, n, &a);
    read_lanes(o, 1, first, n, &b);
    for (int i = 0; i < n; i++)
        q[i] = o->share_known[0] * qa[i] + o->share_known[1] * qb[i];
    for (int j = 0; j < 2; j++)
        square(q, &a, &b, j, out->square[j]);
}

/* One tile: n columns of the views [first, end). */
static bool second_is_steadier(const lf_film *film, const lf_open_halves *o, int view0, int view1,
                               int column0, int n)
{
    double error[2] = {0.0, 0.0};
    for (int k = view0; k < view1; k++) {
        lf_apart apart;
        compare(o, (size_t)k * (size_t)film->width + (size_t)column0, n, &apart);
        for (int i = 0; i < n; i++)
            for (int c = 0; c < 3; c++) {
                error[0] += (double)apart.square[0][c][i];
                error[1] += (double)apart.square[1][c][i];
            }
    }
    return error[1] < error[0];
}

void lf_film_row_second(const lf_film *film, int row, bool *out)
{
    const int width = film->width, n_views = film->n_views;
    lf_open_halves o;
    memset(out, 0, (size_t)n_views * (size_t)width * sizeof *out);
    if (!film->layout.has_w2 || !open_halves(film, row, &o))
        return;
    for (int view0 = 0; view0 < n_views; view0 += LF_TILE_VIEWS) {
        const int view1 = view0 + LF_TILE_VIEWS < n_views ? view0 + LF_TILE_VIEWS : n_views;
        for (int column0 = 0; column0 < width; column0 += LF_TILE_COLUMNS) {
            const int left = width - column0, n = left < LF_TILE_COLUMNS ? left : LF_TILE_COLUMNS;
            if (!second_is_steadier(film, &o, view0, view1, column0, n))
                continue;
            for (int k = view0; k < view1; k++)
                memset(out + (size_t)k * (size_t)width + (size_t)column0, true, (size_t)n);
        }
    }
    lf_film_close(film, row, false);
}
