#include "render/reconstruct/lattice.h"

#include <string.h>

#include "base/alloc.h"

void lf_band_finish(lf_band *band)
{
    lf_free(band->index);
    lf_free(band->cells);
    memset(band, 0, sizeof *band);
}

lf_status lf_band_begin(lf_band *band, int u0, int nu, int z0, int nz)
{
    size_t places = (size_t)nu * (size_t)nz;
    if (places > band->index_size) {
        lf_free(band->index);
        band->index = lf_calloc(places, sizeof *band->index);
        band->index_size = band->index ? places : 0;
        if (!band->index)
            return LF_E_NOMEM;
    }
    band->u0 = u0;
    band->nu = nu;
    band->z0 = z0;
    band->nz = nz;
    band->n = 0;
    for (size_t i = 0; i < places; i++)
        band->index[i] = -1;
    return LF_OK;
}

lf_status lf_band_reserve(lf_band *band)
{
    size_t places = (size_t)band->nu * (size_t)band->nz;
    int n = 0;
    for (size_t i = 0; i < places; i++)
        if (band->index[i] >= 0)
            band->index[i] = n++;
    if (n > band->size) {
        lf_free(band->cells);
        band->cells = lf_calloc((size_t)n, sizeof *band->cells);
        band->size = band->cells ? n : 0;
        if (!band->cells)
            return LF_E_NOMEM;
    }
    band->n = n;
    memset(band->cells, 0, (size_t)n * sizeof *band->cells);
    for (int j = 0; j < band->nz; j++) {
        for (int i = 0; i < band->nu; i++) {
            int number = band->index[(size_t)j * (size_t)band->nu + (size_t)i];
            if (number >= 0) {
                band->cells[number].u = band->u0 + i;
                band->cells[number].z = band->z0 + j;
            }
        }
    }
    return LF_OK;
}

void lf_raw_add(lf_raw_sums *to, const lf_raw_sums *from, const float shift[3])
{
    for (int c = 0; c < 3; c++) {
        to->square[c] += from->square[c];
        to->known[c] += from->known[c];
        for (int h = 0; h < 2; h++) {
            const lf_plane *a = &from->product[h][c];
            lf_plane *b = &to->product[h][c];
            to->cross[h][c] += from->cross[h][c];
            b->constant += a->constant;
            for (int i = 0; i < LF_FEATURES; i++)
                b->slope[i] += a->slope[i] + (i < 3 ? shift[i] * a->constant : 0.0f);
        }
    }
    to->q += from->q;
    to->pixels += from->pixels;
}
