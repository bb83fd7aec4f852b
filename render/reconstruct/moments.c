#include "render/reconstruct/moments.h"

#include <limits.h>
#include <string.h>

#include "render/reconstruct/bright.h"

lf_row_halves lf_row_halves_of(const lf_film *film, int row, const float (*albedo)[3])
{
    const lf_film_row *state = &film->rows[row];
    lf_row_halves out = {.albedo = albedo};
    bool alone = !(state->n[0] > 0.0 && state->n[1] > 0.0);
    for (int h = 0; h < 2; h++) {
        int as = alone ? (row + row / LF_CELL_SIDE) % 2 : h;
        if (!(state->n[h] > 0.0))
            continue;
        out.half[as] = lf_film_at(film, row, h);
        out.n[as] = (float)state->n[h];
    }
    return out;
}

static void add_product(lf_plane *to, float x, const float f[LF_FEATURES])
{
    to->constant += x;
    for (int i = 0; i < LF_FEATURES; i++)
        to->slope[i] += x * f[i];
}

/* answer: N/W of half h; other: what the other half has found, w the weight that it is fitted with.
 */
static void add_cross(lf_raw_sums *raw, int h, const float answer[3], const lf_pixel_found *other,
                      float w, const float f[LF_FEATURES])
{
    raw->weight[h] += w;
    for (int c = 0; c < 3; c++) {
        raw->cross[h][c] += answer[c] * other->n[c];
        add_product(&raw->product[h][c], answer[c] * w, f);
    }
}

static void add_known(lf_raw_sums *raw, const lf_film *film, const lf_film_known *known, float q,
                      const float *albedo)
{
    for (int c = 0; c < 3; c++)
        raw->albedo[c] += albedo ? albedo[c] : 1.0f;
    for (int c = 0; c < 3; c++)
        raw->known[c] += known ? known->b[c] : film->sky[c] * (1.0f - q);
    raw->q += q;
    raw->pixels += 1.0f;
}

void lf_fitted_read(const lf_film *film, const lf_row_halves *halves, bool second, size_t i,
                    lf_fitted *out)
{
    for (int h = 0; h < 2; h++) {
        lf_pixel_found *found = &out->found[h];
        *found = (lf_pixel_found){.w = 0.0f};
        out->w[h] = out->over[h] = 0.0f;
        if (!halves->half[h].scattered)
            continue;
        lf_pixel_found_add(found, &halves->half[h], i);
        for (int c = 0; c < 3 && halves->albedo; c++)
            found->n[c] /= halves->albedo[i][c];
        out->w[h] = second ? found->w2 : found->w;
        float w = lf_pixel_found_weight(film, found, second, halves->n[h] * halves->half[h].q[i]);
        out->over[h] = w;
        for (int c = 0; c < 3 && w > 0.0f; c++)
            out->answer[h][c] = found->n[c] / w;
    }
}

/* Sums of N^2/W of both halves. */
static void add_square(lf_cell_sums *cell, const lf_film *film, const lf_row_halves *halves,
                       bool second, size_t i, const lf_fitted *x)
{
    lf_pixel_found both = {.w = 0.0f};
    float nq = 0.0f;
    for (int h = 0; h < 2; h++) {
        if (!halves->half[h].scattered)
            continue;
        lf_pixel_found_join(&both, &x->found[h]);
        nq += halves->n[h] * halves->half[h].q[i];
    }
    float w = lf_pixel_found_weight(film, &both, second, nq);
    for (int c = 0; c < 3 && w > 0.0f; c++)
        cell->raw.square[c] += both.n[c] * both.n[c] / w;
}

static void add_pixel(lf_cell_sums *cell, const lf_reconstruct_kernels *kernels,
                      const lf_film *film, const lf_row_halves *halves, bool second, size_t i,
                      const lf_fitted *x, float f[2][LF_FEATURES])
{
    for (int h = 0; h < 2; h++)
        if (x->found[h].w != 0.0f)
            for (int of = 0; of < 2; of++)
                kernels->add(&cell->half[of][h], x->w[h], x->found[h].n, f[of]);
    for (int h = 0; h < 2; h++)
        if (x->over[h] > 0.0f && x->found[1 - h].w != 0.0f)
            add_cross(&cell->raw, h, x->answer[h], &x->found[1 - h], x->w[1 - h], f[h]);
    add_square(cell, film, halves, second, i, x);
}

static void add_view(lf_band *band, const lf_reconstruction *r, const lf_film *film,
                     const lf_pixels *pixels, const lf_row_halves *halves,
                     const lf_film_known *known, int row, int view)
{
    const int number = row / LF_CELL_SIDE;
    size_t first = (size_t)view * (size_t)film->width;
    for (size_t i = first; i < first + (size_t)film->width; i++) {
        if (!lf_pixel_is_fitted(pixels, i))
            continue;
        const int at = lf_band_find(band, pixels->u[i], pixels->z[i]);
        const lf_cell *cell = &band->cells[at];
        lf_cell_sums *sums = &band->sums[at];
        const float middle[3] = {(float)cell->u + 0.5f, (float)number + 0.5f,
                                 (float)cell->z + 0.5f};
        float f[2][LF_FEATURES];
        lf_fitted x;
        for (int h = 0; h < 2; h++)
            for (int j = 0; j < LF_FEATURES; j++)
                f[h][j] = pixels->f[h][j][i] - (j < 3 ? middle[j] : 0.0f);
        lf_fitted_read(film, halves, pixels->second[i], i, &x);
        if (r->whole)
            lf_bright_bound(r->whole, pixels, row, i, &x);
        add_pixel(sums, r->kernels, film, halves, pixels->second[i], i, &x, f);
        add_known(&sums->raw, film, known ? &known[i] : NULL, pixels->q[i],
                  pixels->albedo ? pixels->albedo[i] : NULL);
    }
}

static void add_row(lf_band *band, const lf_reconstruction *r, const lf_film *film,
                    const lf_pixels *pixels, int row)
{
    lf_film_open(film, row);
    const lf_row_halves halves = lf_row_halves_of(film, row, (const float(*)[3])pixels->albedo);
    const lf_film_known *known = lf_film_known_at(film, row);
    for (int view = 0; view < film->n_views; view++)
        if (lf_view_is_fitted(r, row, view))
            add_view(band, r, film, pixels, &halves, known, row, view);
    lf_film_close(film, row, false);
}

typedef struct lf_range {
    int low, high; /* low > high: empty */
} lf_range;

static void widen(lf_range *range, int x)
{
    range->low = x < range->low ? x : range->low;
    range->high = x > range->high ? x : range->high;
}

static lf_status begin_band(lf_band *band, lf_range z)
{
    return z.low > z.high ? lf_band_begin(band, 0, 0)
                          : lf_band_begin(band, z.low, z.high - z.low + 1);
}

/* Lists the cells of a row's fitted pixels, n of them; neighbours in one cell are listed once. */
static size_t list_places(const lf_pixels *pixels, size_t n, lf_cell_at *out)
{
    size_t listed = 0;
    for (size_t i = 0; i < n; i++) {
        const lf_cell_at here = {pixels->u[i], pixels->z[i]};
        if (lf_pixel_is_fitted(pixels, i) &&
            (listed == 0 || here.u != out[listed - 1].u || here.z != out[listed - 1].z))
            out[listed++] = here;
    }
    return listed;
}

/* A band with a cell at each of n places. */
static lf_status make_band(lf_band *band, const lf_cell_at *places, size_t n)
{
    lf_range z = {INT_MAX, INT_MIN};
    for (size_t i = 0; i < n; i++)
        widen(&z, places[i].z);
    lf_status status = begin_band(band, z);
    for (size_t i = 0; i < n && status == LF_OK; i++)
        lf_band_widen(band, places[i].u, places[i].z);
    if (status == LF_OK)
        status = lf_band_open(band);
    for (size_t i = 0; i < n && status == LF_OK; i++)
        lf_band_mark(band, places[i].u, places[i].z);
    return status == LF_OK ? lf_band_reserve(band) : status;
}

/* Reads rows twice: a thread with memory for all rows of a band would take eight times as much. */
lf_status lf_moments_gather(lf_reconstruction *r, const lf_film *film, int number,
                            lf_reconstruct_scratch *scratch)
{
    lf_band *band = &r->level[0].bands[number];
    lf_pixels *pixels = &scratch->row;
    const size_t n = (size_t)film->n_views * (size_t)film->width;
    const int first = number * LF_CELL_SIDE,
              end = first + LF_CELL_SIDE < film->height ? first + LF_CELL_SIDE : film->height;
    lf_status status = LF_OK;
    size_t listed = 0;
    for (int row = first; row < end && status == LF_OK; row++) {
        if (!r->whole)
            status = lf_second_keep(r, film, row);
        if (status == LF_OK && lf_pixels_read(pixels, r, film, row, LF_READ_PLACES))
            listed += list_places(pixels, n, scratch->places + listed);
    }
    if (status == LF_OK)
        status = make_band(band, scratch->places, listed);
    for (int row = first; row < end && status == LF_OK && band->n > 0; row++)
        if (lf_film_visited(film->rows[row].visits) &&
            lf_pixels_read(pixels, r, film, row, LF_READ_HALVES))
            add_row(band, r, film, pixels, row);
    return status;
}

/* Completes the part that moving omits (kernel.h). */
static void mirror(lf_moments *m)
{
    for (int i = 0; i < LF_FEATURES; i++)
        for (int j = 0; j < i; j++)
            m->wff[i][j] = m->wff[j][i];
}

/* The i-th cell of a band, and the cell above that contains it. */
static void add_cell(const lf_reconstruct_kernels *kernels, const lf_band *above,
                     const lf_band *below, int i, float side, int from_band, int to_band)
{
    const lf_cell *from = &below->cells[i];
    const int at = lf_band_find(above, lf_half_of(from->u), lf_half_of(from->z));
    const lf_cell *to = &above->cells[at];
    lf_cell_sums *sums = &above->sums[at];
    const float t[LF_FEATURES] = {
        ((float)from->u + 0.5f) * side - ((float)to->u + 0.5f) * 2.0f * side,
        ((float)from_band + 0.5f) * side - ((float)to_band + 0.5f) * 2.0f * side,
        ((float)from->z + 0.5f) * side - ((float)to->z + 0.5f) * 2.0f * side};
    for (int h = 0; h < 4; h++)
        kernels->move(&sums->half[h >> 1][h & 1], &below->sums[i].half[h >> 1][h & 1], 1.0f, t);
    lf_raw_add(&sums->raw, &below->sums[i].raw, t);
}

lf_status lf_moments_coarsen(lf_reconstruction *r, int level, int number)
{
    const lf_lattice *below = &r->level[level - 1];
    lf_band *band = &r->level[level].bands[number];
    lf_range z = {INT_MAX, INT_MIN};
    int first = 2 * number, end = 2 * number + 2 < below->n_bands ? 2 * number + 2 : below->n_bands;
    for (int b = first; b < end; b++) {
        const lf_band *child = &below->bands[b];
        if (child->n == 0)
            continue;
        widen(&z, lf_half_of(child->z0));
        widen(&z, lf_half_of(child->z0 + child->nz - 1));
    }
    lf_status status = begin_band(band, z);
    for (int b = first; b < end && status == LF_OK; b++)
        for (int i = 0; i < below->bands[b].n; i++)
            lf_band_widen(band, lf_half_of(below->bands[b].cells[i].u),
                          lf_half_of(below->bands[b].cells[i].z));
    if (status == LF_OK)
        status = lf_band_open(band);
    for (int b = first; b < end && status == LF_OK; b++)
        for (int i = 0; i < below->bands[b].n; i++)
            lf_band_mark(band, lf_half_of(below->bands[b].cells[i].u),
                         lf_half_of(below->bands[b].cells[i].z));
    if (status == LF_OK)
        status = lf_band_reserve(band);
    for (int b = first; b < end && status == LF_OK; b++)
        for (int i = 0; i < below->bands[b].n; i++)
            add_cell(r->kernels, band, &below->bands[b], i, (float)(1 << (level - 1)), b, number);
    for (int i = 0; i < band->n && status == LF_OK; i++)
        for (int h = 0; h < 4; h++)
            mirror(&band->sums[i].half[h >> 1][h & 1]);
    return status;
}
