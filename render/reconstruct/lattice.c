#include "render/reconstruct/lattice.h"

#include <string.h>

#include "base/alloc.h"

void lf_band_drop_sums(lf_band *band)
{
    lf_pages_free(band->sums);
    band->sums = NULL;
    band->sums_size = 0;
}

void lf_band_lend_sums(lf_band *to, lf_band *from)
{
    lf_band_drop_sums(to);
    to->sums = from->sums;
    to->sums_size = from->sums_size;
    from->sums = NULL;
    from->sums_size = 0;
}

void lf_band_finish(lf_band *band)
{
    lf_band_drop_sums(band);
    lf_free(band->layers);
    lf_free(band->index);
    lf_pages_free(band->cells);
    memset(band, 0, sizeof *band);
}

lf_status lf_band_begin(lf_band *band, int z0, int nz)
{
    band->n = band->nz = 0;
    if (nz > band->n_layers) {
        lf_free(band->layers);
        band->layers = lf_calloc((size_t)nz, sizeof *band->layers);
        band->n_layers = band->layers ? nz : 0;
        if (!band->layers)
            return LF_E_NOMEM;
    }
    band->z0 = z0;
    band->nz = nz;
    for (int i = 0; i < nz; i++)
        band->layers[i] = (lf_deck){0};
    return LF_OK;
}

lf_status lf_band_open(lf_band *band)
{
    band->n_places = 0;
    for (int i = 0; i < band->nz; i++) {
        band->layers[i].first = band->n_places;
        band->n_places += (size_t)band->layers[i].nu;
    }
    if (band->n_places > band->index_size) {
        lf_free(band->index);
        band->index = lf_calloc(band->n_places, sizeof *band->index);
        band->index_size = band->index ? band->n_places : 0;
        if (!band->index)
            return LF_E_NOMEM;
    }
    for (size_t i = 0; i < band->n_places; i++)
        band->index[i] = -1;
    return LF_OK;
}

/* Stores the position in each cell. */
static void place_cells(lf_band *band)
{
    for (int j = 0; j < band->nz; j++) {
        const lf_deck *layer = &band->layers[j];
        for (int i = 0; i < layer->nu; i++) {
            int number = band->index[layer->first + (size_t)i];
            if (number >= 0) {
                band->cells[number].u = layer->u0 + i;
                band->cells[number].z = band->z0 + j;
            }
        }
    }
}

/* Zeroed sums of n cells. */
static lf_status reserve_sums(lf_band *band, int n)
{
    if (n <= band->sums_size) {
        if (n > 0)
            memset(band->sums, 0, (size_t)n * sizeof *band->sums);
        return LF_OK;
    }
    lf_band_drop_sums(band);
    band->sums = lf_pages((size_t)n, sizeof *band->sums);
    band->sums_size = band->sums ? n : 0;
    return band->sums ? LF_OK : LF_E_NOMEM;
}

lf_status lf_band_reserve(lf_band *band)
{
    int n = 0;
    for (size_t i = 0; i < band->n_places; i++)
        if (band->index[i] >= 0)
            band->index[i] = n++;
    if (n > band->size) { /* with room for what the next fit has more: fresh pages are dear */
        const int room = n + n / 4;
        lf_pages_free(band->cells);
        band->cells = lf_pages((size_t)room, sizeof *band->cells);
        band->size = band->cells ? room : 0;
        if (!band->cells)
            return LF_E_NOMEM;
    }
    band->n = n;
    if (n > 0)
        memset(band->cells, 0, (size_t)n * sizeof *band->cells);
    place_cells(band);
    return reserve_sums(band, n);
}

/* The band of the n-th cell around one, and its number there, -1: no cell. */
static const lf_band *band_around(const lf_lattice *l, int number, const lf_cell *cell, int n,
                                  int *out_at, float *weight)
{
    const lf_around a = lf_around_at(n);
    const int v = number + a.dv;
    const bool is_in = v >= 0 && v < l->n_bands;
    *out_at = is_in ? lf_band_find(&l->bands[v], cell->u + a.du, cell->z + a.dz) : -1;
    *weight = a.weight;
    return is_in ? &l->bands[v] : NULL;
}

const lf_cell *lf_cell_around(const lf_lattice *l, int number, const lf_cell *cell, int n,
                              float *weight)
{
    int at;
    const lf_band *band = band_around(l, number, cell, n, &at, weight);
    return at >= 0 ? &band->cells[at] : NULL;
}

const lf_cell_sums *lf_sums_around(const lf_lattice *l, int number, const lf_cell *cell, int n,
                                   float *weight)
{
    int at;
    const lf_band *band = band_around(l, number, cell, n, &at, weight);
    return at >= 0 ? &band->sums[at] : NULL;
}

void lf_raw_add(lf_raw_sums *to, const lf_raw_sums *from, const float shift[3])
{
    for (int c = 0; c < 3; c++) {
        to->square[c] += from->square[c];
        to->known[c] += from->known[c];
        to->albedo[c] += from->albedo[c];
        for (int h = 0; h < 2; h++) {
            const lf_plane *a = &from->product[h][c];
            lf_plane *b = &to->product[h][c];
            to->cross[h][c] += from->cross[h][c];
            b->constant += a->constant;
            for (int i = 0; i < LF_FEATURES; i++)
                b->slope[i] += a->slope[i] + (i < 3 ? shift[i] * a->constant : 0.0f);
        }
    }
    for (int h = 0; h < 2; h++)
        to->weight[h] += from->weight[h];
    to->q += from->q;
    to->pixels += from->pixels;
}
