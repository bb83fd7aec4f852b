#include "render/reconstruct/pixels.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"

/* Separate arrays: all features of both halves; of a half all except its row and view, which are
 * the same. */
enum { ARRAYS = LF_FEATURES + 2 * (LF_FEATURES - 2) + 1 };

lf_status lf_pixels_init(size_t n, bool albedo, lf_pixels *out)
{
    out->data = lf_pages(ARRAYS * n, sizeof *out->data);
    out->cells = lf_calloc(2 * n, sizeof *out->cells);
    out->second = lf_calloc(n, sizeof *out->second);
    out->albedo = albedo ? lf_calloc(n, sizeof *out->albedo) : NULL;
    if (!out->data || !out->cells || !out->second || (albedo && !out->albedo))
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
    lf_pages_free(pixels->data);
    lf_free(pixels->cells);
    lf_free(pixels->second);
    lf_free(pixels->albedo);
    memset(pixels, 0, sizeof *pixels);
}

/* Albedo of pixel k. If it is unknown, for example on an outline that was met late, the albedo of
 * the nearest pixel of its view; 0: none. */
static lf_packed_albedo nearest_albedo(const lf_view_row *in, int k)
{
    const int reach = 8;
    lf_packed_albedo found = in->albedo[k];
    for (int by = 1; by <= reach && found == 0; by++) {
        found = k >= by ? in->albedo[k - by] : 0;
        found = found == 0 && k + by < in->n ? in->albedo[k + by] : found;
    }
    return found;
}

/* Reads albedo, the factor of R; the light feature is relative to it. Radiance that is not
 * proportional to albedo is gloss. For metal it is linear in the metallic share, which is mixed
 * into the q feature. For a dielectric it is linear in 1/a, which is mixed into the share of media.
 * Under a sky it is linear in the incident light over a: the light feature has this, and the share
 * of media has the incident light itself, relative to the usual. */
static void read_albedo(const lf_view_row *in, bool halves, lf_pixels *out)
{
    const float of_gloss = 0.1f, of_metal = 1.0f;
    for (int k = 0; k < in->n; k++) {
        const int i = in->first + k;
        float all[LF_ALBEDO_NUMBERS], *a = out->albedo[i];
        if (!lf_q_is_fitted(out->q[i]))
            continue;
        const lf_packed_albedo packed = nearest_albedo(in, k);
        lf_albedo_unpack(packed, all);
        for (int c = 0; c < 3; c++)
            a[c] = packed == 0 ? 1.0f : fmaxf(all[c], LF_LEAST_ALBEDO);
        float inverse = 3.0f / (a[0] + a[1] + a[2]), metal = all[LF_ALBEDO_METAL];
        for (int v = halves ? 0 : LF_BOTH; v < LF_VARIANTS; v++) {
            float *light = &out->f[v][LF_LIGHT][i], *media = &out->f[v][LF_MEDIA][i];
            const float surface = 1.0f - *media;
            *media += in->white > 0.0f ? *light / in->white - surface
                                       : of_gloss * ((1.0f - metal) * inverse - 1.0f);
            *light *= inverse;
            out->f[v][LF_PIVOTS][i] += of_metal * metal;
        }
    }
}

lf_status lf_second_keep(lf_reconstruction *r, const lf_film *film, int row)
{
    lf_known_second *known = &r->second[row];
    const size_t n = (size_t)film->n_views * (size_t)film->width;
    if (!film->layout.has_w2)
        return LF_OK;
    if (!known->is)
        known->is = lf_calloc(n, sizeof *known->is);
    if (!known->is)
        return LF_E_NOMEM;
    memcpy(known->n, film->rows[row].n, sizeof known->n);
    lf_film_row_second(film, row, known->is);
    return LF_OK;
}

/* Uses the stored value during a fit: later, holes may have been filled, which counts do not show.
 */
static void read_second(const lf_reconstruction *r, const lf_film *film, int row, bool *out)
{
    const lf_reconstruction *whole = r->whole ? r->whole : r;
    const lf_known_second *known = &whole->second[row];
    const double *n = film->rows[row].n;
    if (!whole->ready && known->is && known->n[0] == n[0] && known->n[1] == n[1])
        memcpy(out, known->is, (size_t)film->n_views * (size_t)film->width * sizeof *out);
    else
        lf_film_row_second(film, row, out);
}

bool lf_pixels_read(lf_pixels *pixels, const lf_reconstruction *r, const lf_film *film, int row,
                    lf_reading what)
{
    const lf_film_row *state = &film->rows[row];
    double n[2];
    lf_view_row in = {.row = ((float)row + 0.5f) / LF_CELL_SIDE,
                      .deep = r->view.depth / r->cell_depth,
                      .still = r->view.still,
                      .white = r->view.white,
                      .n = film->width};
    lf_film_row_known(state, n);
    if (!(n[0] + n[1] > 0.0))
        return false;
    if (film->layout.has_w2 && what != LF_READ_PLACES)
        read_second(r, film, row, pixels->second);
    lf_film_open(film, row);
    const lf_packed_albedo *albedo = what != LF_READ_PLACES ? lf_film_albedo_at(film, row) : NULL;
    for (int k = 0; k < film->n_views; k++) {
        if (what >= LF_READ_SUMMED && !lf_view_is_fitted(r, row, k))
            continue;
        in.first = k * film->width;
        in.view = (float)k / (float)film->n_views - 0.5f;
        in.shift = r->shift[k];
        for (int h = 0; h < 2; h++) {
            const lf_film_half half = lf_film_at(film, row, h);
            in.q[h] = half.q + in.first;
            in.feature[h] = half.feature + in.first;
            in.share[h] = (float)(n[h] / (n[0] + n[1]));
        }
        in.albedo = albedo ? albedo + in.first : NULL;
        r->kernels->read(&in, what == LF_READ_HALVES, pixels);
        if (pixels->albedo && what != LF_READ_PLACES)
            read_albedo(&in, what == LF_READ_HALVES, pixels);
    }
    lf_film_close(film, row, false);
    return true;
}

void lf_pixels_reflect(const lf_pixels *pixels, int first, int n, float (*predicted)[4])
{
    for (int k = 0; k < n && pixels->albedo; k++)
        for (int c = 0; c < 3 && lf_pixel_is_fitted(pixels, (size_t)(first + k)); c++)
            predicted[k][c] *= pixels->albedo[first + k][c];
}

/* ------------------------------------------------------------------------------------ tables -- */

void lf_table_finish(lf_row_table *table)
{
    lf_free(table->layers);
    lf_free(table->terms);
    lf_free(table->share);
    memset(table, 0, sizeof *table);
}

/* The nodes of a band at one depth. */
static lf_deck layer_of(const lf_band *band, int z)
{
    bool there = z >= band->z0 && z - band->z0 < band->nz;
    return there ? band->layers[z - band->z0] : (lf_deck){0};
}

/* Both bands' nodes at one depth and one more on either side: the range in which their pixels are
 * interpolated. */
static lf_deck joined(const lf_band *a, const lf_band *b, int z)
{
    lf_deck one = layer_of(a, z), other = layer_of(b, z);
    if (one.nu == 0)
        one = other;
    if (other.nu == 0)
        other = one;
    int low = one.u0 < other.u0 ? one.u0 : other.u0, end = one.u0 + one.nu;
    end = end > other.u0 + other.nu ? end : other.u0 + other.nu;
    return one.nu > 0 ? (lf_deck){.u0 = low - 1, .nu = end - low + 2} : (lf_deck){.nu = 2};
}

static lf_status begin_layers(lf_row_table *table, const lf_band *a, const lf_band *b)
{
    const lf_band *one = a->nz > 0 ? a : b, *other = b->nz > 0 ? b : one;
    int low = one->z0 < other->z0 ? one->z0 : other->z0, end = one->z0 + one->nz;
    end = end > other->z0 + other->nz ? end : other->z0 + other->nz;
    table->z0 = low - 1;
    table->nz = end - low + 2;
    if (table->nz <= table->n_layers)
        return LF_OK;
    lf_free(table->layers);
    table->layers = lf_calloc((size_t)table->nz, sizeof *table->layers);
    table->n_layers = table->layers ? table->nz : 0;
    return table->layers ? LF_OK : LF_E_NOMEM;
}

static lf_status begin(lf_row_table *table, const lf_band *a, const lf_band *b)
{
    size_t places = 0;
    lf_status status = begin_layers(table, a, b);
    for (int i = 0; i < table->nz && status == LF_OK; i++) {
        table->layers[i] = joined(a, b, table->z0 + i);
        table->layers[i].first = places;
        places += (size_t)table->layers[i].nu;
    }
    if (status == LF_OK && places > table->size) {
        lf_free(table->terms);
        lf_free(table->share);
        table->terms = lf_calloc(places * LF_TABLE_TERMS * 4, sizeof *table->terms);
        table->share = lf_calloc(places, sizeof *table->share);
        table->size = table->terms && table->share ? places : 0;
        return table->size > 0 ? LF_OK : LF_E_NOMEM;
    }
    if (status != LF_OK)
        return status;
    memset(table->terms, 0, places * LF_TABLE_TERMS * 4 * sizeof *table->terms);
    memset(table->share, 0, places * sizeof *table->share);
    return LF_OK;
}

static void add_node(lf_row_table *table, const lf_cell *cell, int variant, float weight,
                     float above)
{
    static const int order[LF_TABLE_TERMS] = {-1,        LF_PLACE, LF_DEPTH,  LF_MEDIA,
                                              LF_PIVOTS, LF_VIEW,  LF_SPREAD, LF_LIGHT};
    const lf_deck *layer = &table->layers[cell->z - table->z0];
    size_t u = (size_t)(cell->u - layer->u0), nu = (size_t)layer->nu;
    float *terms = table->terms + (layer->first * LF_TABLE_TERMS + u) * 4;
    if (!cell->filled[variant])
        return;
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
    table->share[layer->first + u] += weight * cell->share;
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
