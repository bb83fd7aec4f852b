/* The result of one row: the prediction of the nodes around its pixels, and N/W of the pixel itself
 * by its share. */
#include "render/reconstruct/answer.h"

#include <math.h>
#include <string.h>

#include "render/reconstruct/residual.h"
#include "render/reconstruct/scratch.h"

/* Planes of coarser nodes are extrapolated far beyond the data of their fit; this limits the
 * result. */
#define MOST_FROM_MEAN 1.5f
/* W of a cell with a meaningful mean, in pixels that their paths have filled once. */
#define LEAST_SEEN 1.0f

static lf_to_show to_show(const lf_answered_row *o)
{
    const lf_film_row *state = &o->film->rows[o->row];
    lf_to_show in = {.n = (float)(state->n[0] + state->n[1]), .least = lf_least_share(o->film)};
    int n = 0;
    for (int h = 0; h < 2; h++) {
        if (!o->halves.half[h].scattered)
            continue;
        in.scattered[n] = o->halves.half[h].scattered;
        in.w2[n++] = o->halves.half[h].w2;
    }
    return in;
}

/* The divisor of N for both halves. */
static float weight_of(const lf_answered_row *o, const lf_pixel_found *both, size_t i)
{
    const lf_pixels *pixels = &o->scratch->row;
    const lf_film_row *state = &o->film->rows[o->row];
    return lf_pixel_found_weight(o->film, both, pixels->second[i],
                                 pixels->q[i] * (float)(state->n[0] + state->n[1]));
}

/* Blends towards the bounded fit where that has a share. */
static void mix_bounded(const lf_answered_row *o, size_t i, const lf_fitted *x, float out[3])
{
    lf_bright_pixel bright;
    lf_pixel_found both = x->found[0];
    lf_pixel_found_join(&both, &x->found[1]);
    lf_bright_split(o->r, &o->scratch->row, o->row, i, x, &bright);
    if (!(bright.share > 0.0f))
        return;
    for (int c = 0; c < 3; c++) {
        bright.below[0][c] += bright.below[1][c];
        bright.above[0][c] += bright.above[1][c];
    }
    lf_bright_mix(bright.share, bright.below[0], bright.above[0], weight_of(o, &both, i),
                  o->bounded->predicted[i], out);
}

void lf_answer_pixel(const lf_answered_row *o, size_t i, lf_pixel_found out_found[2], float out[3])
{
    const lf_pixels *pixels = &o->scratch->row;
    lf_fitted x;
    lf_fitted_read(o->film, &o->halves, pixels->second[i], i, &x);
    for (int h = 0; h < 2; h++) {
        out_found[h] = x.found[h];
        out_found[h].w = x.w[h];
        for (int c = 0; c < 3 && pixels->albedo; c++)
            out_found[h].n[c] *= pixels->albedo[i][c];
    }
    lf_pixel_found both = x.found[0];
    lf_pixel_found_join(&both, &x.found[1]);
    const float n[3] = {out_found[0].n[0] + out_found[1].n[0],
                        out_found[0].n[1] + out_found[1].n[1],
                        out_found[0].n[2] + out_found[1].n[2]};
    lf_pixel_show(n, weight_of(o, &both, i), o->scratch->predicted[i], out);
    if (o->bounded)
        mix_bounded(o, i, &x, out);
}

/* Applies the corrections of tiles. */
static void add_lacking(const lf_answered_row *o, float (*out)[3])
{
    const int width = o->film->width;
    float(*times)[3] = o->scratch->times;
    for (int k = 0; k < o->film->n_views; k++) {
        if (!lf_residual_row(o->r, o->row, k, LF_BOTH, times))
            continue;
        for (int column = 0; column < width; column++) {
            const size_t i = (size_t)k * (size_t)width + (size_t)column;
            if (lf_pixel_is_fitted(&o->scratch->row, i))
                for (int c = 0; c < 3; c++)
                    out[i][c] *= times[column][c];
        }
    }
}

/* B + q R. Correction weights may move q outside of 0..1: then the sky would be dimmed, or counted
 * more than once, in isolated pixels. If B follows from q, q is clamped (its limit is in the
 * range). A stored B has the same noise, and q is not clamped. */
static void answer_row(const lf_answered_row *o, float (*out)[3])
{
    const lf_film *film = o->film;
    const lf_film_known *known = lf_film_known_at(film, o->row);
    const lf_pixels *pixels = &o->scratch->row;
    const lf_to_show in = to_show(o);
    const size_t n = (size_t)film->n_views * (size_t)film->width;
    o->r->kernels->show(&in, pixels, o->scratch->predicted, (int)n, out);
    for (size_t i = 0; i < n && o->bounded; i++) {
        lf_fitted x;
        if (!lf_pixel_is_fitted(pixels, i))
            continue;
        lf_fitted_read(film, &o->halves, pixels->second[i], i, &x);
        mix_bounded(o, i, &x, out[i]);
    }
    add_lacking(o, out);
    for (size_t i = 0; i < n; i++) {
        if (pixels->q[i] < 0.0f && film->rows[o->row].provisional) {
            memset(out[i], 0, sizeof out[i]);
            continue;
        }
        const float found = pixels->q[i], q = known ? found : fminf(1.0f, fmaxf(0.0f, found));
        for (int c = 0; c < 3; c++)
            out[i][c] = (known ? known[i].b[c] : film->sky[c] * (1.0f - q)) + q * out[i][c];
    }
}

/* The cell of a level that pixel i of a row lies in, and its middle; NULL: there is none. */
static const lf_cell *cell_of(const lf_reconstruction *r, const lf_pixels *pixels, int row,
                              size_t i, int level, float middle[3])
{
    int at[3] = {pixels->u[i], row / LF_CELL_SIDE, pixels->z[i]};
    for (int l = 0; l < level; l++)
        for (int k = 0; k < 3; k++)
            at[k] = lf_half_of(at[k]);
    for (int k = 0; k < 3; k++)
        middle[k] = ((float)at[k] + 0.5f) * (float)(1 << level);
    const lf_band *band = &r->level[level].bands[at[1]];
    const int n = lf_band_find(band, at[0], at[2]);
    return n >= 0 ? &band->cells[n] : NULL;
}

/* N/W of a cell; false: its W is so small that one bright path, or cancelling signed weights, would
 * dominate it. */
static bool mean_of(const lf_cell *cell, float out[3])
{
    const float w = cell->seen[0];
    for (int c = 0; c < 3 && w >= LEAST_SEEN; c++)
        out[c] = fmaxf(0.0f, cell->seen[1 + c] / w);
    return w >= LEAST_SEEN;
}

/* A pixel far from all cells in depth, for example on an outline that was unknown to the fit:
 * interpolates the means of the cells behind and in front of it. */
static void predict_between(const lf_reconstruction *r, const lf_pixels *pixels, int row, size_t i,
                            float out[4])
{
    const int level = LF_LEVELS - 1;
    const float side = (float)(1 << level), z = pixels->f[LF_BOTH][LF_DEPTH][i] / side - 0.5f;
    const lf_band *band = &r->level[level].bands[row / LF_CELL_SIDE >> level];
    float mean[2][3] = {{0}}, at[2] = {-INFINITY, INFINITY};
    int u = pixels->u[i];
    for (int l = 0; l < level; l++)
        u = lf_half_of(u);
    for (int k = band->z0; k < band->z0 + band->nz; k++) {
        const int n = lf_band_find(band, u, k), nearer = (float)k < z ? 0 : 1;
        if (n >= 0 && (nearer == 0 || at[1] == INFINITY) && mean_of(&band->cells[n], mean[nearer]))
            at[nearer] = (float)k;
    }
    if (at[0] == -INFINITY && at[1] == INFINITY)
        return;
    const float t = at[0] == -INFINITY  ? 1.0f
                    : at[1] == INFINITY ? 0.0f
                                        : (z - at[0]) / (at[1] - at[0]);
    for (int c = 0; c < 3; c++)
        out[c] = (1.0f - t) * mean[0][c] + t * mean[1][c];
    out[3] = 0.0f;
}

/* The prediction of a cell's node for a pixel that it was not fitted to, within a factor of
 * MOST_FROM_MEAN of the cell's mean; false: the cell has too few samples. */
static bool predict_by(const lf_cell *cell, const lf_pixels *pixels, size_t i,
                       const float middle[3], float out[3])
{
    float mean[3];
    if (!mean_of(cell, mean))
        return false;
    for (int c = 0; c < 3; c++) {
        const lf_plane *plane = &cell->node[LF_BOTH][c];
        float x = plane->constant;
        for (int k = 0; k < LF_FEATURES; k++)
            x += plane->slope[k] * (pixels->f[LF_BOTH][k][i] - (k < 3 ? middle[k] : 0.0f));
        out[c] = fminf(fmaxf(x, mean[c] / MOST_FROM_MEAN), mean[c] * MOST_FROM_MEAN);
    }
    return true;
}

/* A pixel without a near node of the finest level, because its row was visited after the fit. The
 * finest level that has a cell there replaces it. */
static void predict_coarser(const lf_reconstruction *r, const lf_pixels *pixels, int row, size_t i,
                            float out[4])
{
    for (int level = 1; level < LF_LEVELS; level++) {
        float middle[3];
        const lf_cell *cell = cell_of(r, pixels, row, i, level, middle);
        if (!cell || !predict_by(cell, pixels, i, middle, out))
            continue;
        out[3] = level == 1 ? cell->share : 0.0f;
        return;
    }
    predict_between(r, pixels, row, i, out);
}

static void predict(const lf_answered_row *o, const lf_reconstruction *r,
                    lf_reconstruct_scratch *scratch, int first, int n)
{
    const lf_pixels *pixels = &o->scratch->row;
    r->kernels->predict(&scratch->table, pixels, first, n, scratch->predicted + first);
    for (int i = first; i < first + n; i++)
        if (scratch->predicted[i][3] < 0.0f && lf_pixel_is_fitted(pixels, (size_t)i))
            predict_coarser(r, pixels, o->row, (size_t)i, scratch->predicted[i]);
    lf_pixels_reflect(pixels, first, n, scratch->predicted + first);
}

void lf_answer_predict(const lf_answered_row *o, int first, int n)
{
    predict(o, o->r, o->scratch, first, n);
    if (o->bounded)
        predict(o, o->r->bounded, o->bounded, first, n);
}

lf_status lf_answer_open(lf_reconstruction *r, const lf_film *film, int row, lf_reading what,
                         lf_answered_row *out)
{
    *out = (lf_answered_row){.r = r,
                             .film = film,
                             .scratch = lf_scratch_take(r),
                             .bounded = r->is_bright ? lf_scratch_take(r->bounded) : NULL,
                             .row = row};
    lf_status status = out->scratch && (out->bounded || !r->is_bright) ? LF_OK : LF_E_NOMEM;
    if (status == LF_OK)
        status = lf_table_make(&out->scratch->table, r, row, LF_BOTH);
    if (status == LF_OK && out->bounded)
        status = lf_table_make(&out->bounded->table, r->bounded, row, LF_BOTH);
    if (status == LF_OK && !lf_pixels_read(&out->scratch->row, r, film, row, what))
        status = LF_E_STATE;
    lf_film_open(film, row);
    if (status == LF_OK)
        out->halves = lf_row_halves_of(film, row, (const float(*)[3])out->scratch->row.albedo);
    return status;
}

void lf_answer_close(lf_reconstruction *r, lf_answered_row *o)
{
    lf_film_close(o->film, o->row, false);
    if (o->scratch)
        lf_scratch_give(r, o->scratch);
    if (o->bounded)
        lf_scratch_give(r->bounded, o->bounded);
}

lf_status lf_reconstruct_row(lf_reconstruction *r, const lf_film *film, int row, float *out)
{
    const int n = film->n_views * film->width;
    lf_answered_row o;
    if (!r->ready || !lf_film_is_known(&film->rows[row]))
        return LF_E_STATE;
    lf_status status = lf_answer_open(r, film, row, LF_READ_ALL, &o);
    if (status == LF_OK) {
        lf_answer_predict(&o, 0, n);
        answer_row(&o, (float(*)[3])out);
    }
    lf_answer_close(r, &o);
    return status;
}
