#include "render/reconstruct/pixels.h"

#include <string.h>

#include "base/alloc.h"

/* Arrays of their own: all features of both halves; of a half but its row and view, which are the
 * same. */
enum { ARRAYS = LF_FEATURES + 2 * (LF_FEATURES - 2) + 1 };

lf_status lf_pixels_init(size_t n, lf_pixels *out)
{
    out->data = lf_calloc(ARRAYS * n, sizeof *out->data);
    out->cells = lf_calloc(2 * n, sizeof *out->cells);
    if (!out->data || !out->cells)
        return LF_E_NOMEM;
    float *next = out->data;
    for (int v = LF_BOTH; v >= 0; v--) {
        for (int i = 0; i < LF_FEATURES; i++) {
            bool shared = v != LF_BOTH && (i == LF_ROW || i == LF_VIEW);
            out->f[v][i] = shared ? out->f[LF_BOTH][i] : next;
            next += shared ? 0 : n;
        }
    }
    out->q = next;
    out->u = out->cells;
    out->z = out->cells + n;
    return LF_OK;
}

void lf_pixels_finish(lf_pixels *pixels)
{
    lf_free(pixels->data);
    lf_free(pixels->cells);
    memset(pixels, 0, sizeof *pixels);
}

bool lf_pixels_read(lf_pixels *pixels, const lf_reconstruction *r, const lf_film *film, int row,
                    bool halves)
{
    const lf_film_row *state = &film->rows[row];
    double n = state->n[0] + state->n[1];
    lf_view_row in = {
        .row = ((float)row + 0.5f) / LF_CELL_SIDE, .depth = r->view.depth, .n = film->width};
    if (!(n > 0.0))
        return false;
    for (int k = 0; k < film->n_views; k++) {
        in.first = k * film->width;
        in.view = (float)k / (float)film->n_views - 0.5f;
        in.shift = r->shift[k];
        for (int h = 0; h < 2; h++) {
            const lf_film_half half = lf_film_at(film, row, h);
            in.q[h] = half.q + in.first;
            in.feature[h] = half.feature + in.first;
            in.share[h] = (float)(state->n[h] / n);
        }
        r->kernels->read(&in, halves && lf_view_is_fitted(r, row, k), pixels);
    }
    return true;
}

/* ------------------------------------------------------------------------------------- tables --
 */

void lf_table_finish(lf_row_table *table)
{
    lf_free(table->terms);
    lf_free(table->share);
    memset(table, 0, sizeof *table);
}

/* Over the ranges of two bands and one node around: where pixels of these lie between. */
static lf_status begin(lf_row_table *table, const lf_band *a, const lf_band *b)
{
    const lf_band *one = a->nu > 0 ? a : b, *other = b->nu > 0 ? b : one;
    int u0 = one->u0 < other->u0 ? one->u0 : other->u0,
        z0 = one->z0 < other->z0 ? one->z0 : other->z0, u1 = one->u0 + one->nu,
        z1 = one->z0 + one->nz;
    u1 = u1 > other->u0 + other->nu ? u1 : other->u0 + other->nu;
    z1 = z1 > other->z0 + other->nz ? z1 : other->z0 + other->nz;
    table->u0 = u0 - 1;
    table->nu = u1 - u0 + 2;
    table->z0 = z0 - 1;
    table->nz = z1 - z0 + 2;
    size_t places = (size_t)table->nu * (size_t)table->nz;
    if (places > table->size) {
        lf_table_finish(&(lf_row_table){.terms = table->terms, .share = table->share});
        table->terms = lf_calloc(places * LF_TABLE_TERMS * 4, sizeof *table->terms);
        table->share = lf_calloc(places, sizeof *table->share);
        table->size = table->terms && table->share ? places : 0;
        return table->size > 0 ? LF_OK : LF_E_NOMEM;
    }
    memset(table->terms, 0, places * LF_TABLE_TERMS * 4 * sizeof *table->terms);
    memset(table->share, 0, places * sizeof *table->share);
    return LF_OK;
}

static void add_node(lf_row_table *table, const lf_cell *cell, int variant, float weight,
                     float above)
{
    static const int order[LF_TABLE_TERMS] = {-1,        LF_PLACE, LF_DEPTH,  LF_MEDIA,
                                              LF_PIVOTS, LF_VIEW,  LF_SPREAD, LF_LIGHT};
    size_t u = (size_t)(cell->u - table->u0), z = (size_t)(cell->z - table->z0),
           nu = (size_t)table->nu;
    float *terms = table->terms + (z * LF_TABLE_TERMS * nu + u) * 4;
    for (int c = 0; c < 3; c++) {
        const lf_plane *p = &cell->node[variant][c];
        float constant = p->constant + above * p->slope[LF_ROW] -
                         ((float)cell->u + 0.5f) * p->slope[LF_PLACE] -
                         ((float)cell->z + 0.5f) * p->slope[LF_DEPTH];
        for (int i = 0; i < LF_TABLE_TERMS; i++)
            terms[(size_t)i * nu * 4 + (size_t)c] +=
                weight * (i == 0 ? constant : p->slope[order[i]]);
    }
    terms[3] += weight;
    table->share[z * nu + u] += weight * cell->share;
}

lf_status lf_table_make(lf_row_table *table, const lf_reconstruction *r, int row, int variant)
{
    const lf_lattice *l = &r->level[0];
    float v = ((float)row + 0.5f) / LF_CELL_SIDE - 0.5f, low = floorf(v);
    int first = (int)low, second = first + 1 < l->n_bands ? first + 1 : first;
    first = first >= 0 ? first : second;
    const lf_band *bands[2] = {&l->bands[first], &l->bands[second]};
    const float weight[2] = {first < second ? 1.0f - (v - low) : 1.0f, v - low};
    lf_status status = begin(table, bands[0], bands[1]);
    for (int b = 0; b < (first < second ? 2 : 1) && status == LF_OK; b++)
        for (int i = 0; i < bands[b]->n; i++)
            add_node(table, &bands[b]->cells[i], variant, weight[b],
                     v - (float)(b == 0 ? first : second));
    return status;
}
