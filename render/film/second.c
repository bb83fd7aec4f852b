/* Where N/W' is less noisy than N/W, as reconstructions ask of whole rows, several times a fit: read
 * straight from the film, column by column without a branch, so that compilers make vectors of it.
 */
#include <string.h>

#include "render/film/film.h"
#include "render/film/tile.h"

/* A row of which both halves have something. */
typedef struct lf_open_halves {
    lf_film_half half[2];
    float inverse[2];     /* 1/n */
    float share_known[2]; /* of the samples whose q counts */
} lf_open_halves;

/* What the halves are apart by N/W and by N/W', squares for each column and channel. */
typedef struct lf_apart {
    float square[2][LF_TILE_COLUMNS][3];
} lf_apart;

static bool open_halves(const lf_film *film, int row, lf_open_halves *out)
{
    const lf_film_row *state = &film->rows[row];
    double known[2];
    if (!(state->n[0] > 0.0 && state->n[1] > 0.0))
        return false;
    lf_film_row_known(state, known);
    for (int h = 0; h < 2; h++) {
        out->half[h] = lf_film_at(film, row, h);
        out->inverse[h] = 1.0f / (float)state->n[h];
        out->share_known[h] = (float)(known[h] / (known[0] + known[1]));
    }
    return true;
}

/* Columns [first, first + n) of one view, by R alone: what the halves' film points have met is not
 * compared. */
static void compare(const lf_open_halves *o, size_t first, int n, lf_apart *out)
{
    const lf_film_scattered *a = o->half[0].scattered + first, *b = o->half[1].scattered + first;
    const float *qa = o->half[0].q + first, *qb = o->half[1].q + first,
                *wa2 = o->half[0].w2 + first, *wb2 = o->half[1].w2 + first;
    for (int j = 0; j < 2; j++) {
        for (int i = 0; i < n; i++) {
            const float wa = lf_film_weight(a[i].w * o->inverse[0], wa2[i] * o->inverse[0], j == 1),
                        wb = lf_film_weight(b[i].w * o->inverse[1], wb2[i] * o->inverse[1], j == 1),
                        q = o->share_known[0] * qa[i] + o->share_known[1] * qb[i];
            const bool both = wa > 0.0f && wb > 0.0f;
            const float over_a = both ? wa : 1.0f, over_b = both ? wb : 1.0f;
            for (int c = 0; c < 3; c++) {
                const float d = q * (a[i].n[c] * o->inverse[0] / over_a -
                                     b[i].n[c] * o->inverse[1] / over_b);
                out->square[j][i][c] = both ? d * d : 0.0f;
            }
        }
    }
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
                error[0] += (double)apart.square[0][i][c];
                error[1] += (double)apart.square[1][i][c];
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
}
