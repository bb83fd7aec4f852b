/* The answer of one row: what the nodes around its pixels predict, and N/W of the pixel itself by
 * its share. */
#include "render/reconstruct/bright.h"
#include "render/reconstruct/scratch.h"

/* What a row is answered from. */
typedef struct lf_answered_row {
    const lf_film *film;
    const lf_reconstruct_scratch *scratch, *bounded; /* bounded NULL: nothing is */
    lf_row_halves halves;
    int row;
} lf_answered_row;

static void answer_pixel(const lf_reconstruction *r, const lf_answered_row *o, size_t i,
                         float out[3])
{
    static const float none[4] = {0.0f, 0.0f, 0.0f, -1.0f};
    const lf_pixels *pixels = &o->scratch->rows[0];
    const lf_film_row *state = &o->film->rows[o->row];
    bool fitted = lf_pixel_is_fitted(pixels, i);
    lf_fitted x;
    lf_bright_pixel bright;
    lf_pixel_found both = {.w = 0.0f};
    for (int h = 0; h < 2; h++)
        if (o->halves.half[h].scattered)
            lf_pixel_found_add(&both, &o->halves.half[h], i);
    float w = lf_pixel_found_weight(o->film, &both, pixels->second[i],
                                    pixels->q[i] * (float)(state->n[0] + state->n[1]));
    lf_pixel_show(both.n, w, fitted ? o->scratch->predicted[i] : none, out);
    if (!fitted || !o->bounded)
        return;
    lf_fitted_read(o->film, &o->halves, pixels->second[i], i, &x);
    lf_bright_split(r, pixels, o->row, i, &x, &bright);
    if (!(bright.share > 0.0f))
        return;
    for (int c = 0; c < 3; c++) {
        bright.below[0][c] += bright.below[1][c];
        bright.above[0][c] += bright.above[1][c];
    }
    lf_bright_mix(bright.share, bright.below[0], bright.above[0], w, o->bounded->predicted[i], out);
}

static void answer_row(const lf_reconstruction *r, const lf_answered_row *o, float *out)
{
    const lf_film *film = o->film;
    const lf_film_known *known = lf_film_known_at(film, o->row);
    const float *q = o->scratch->rows[0].q;
    size_t pixels = (size_t)film->n_views * (size_t)film->width;
    for (size_t i = 0; i < pixels; i++) {
        float x[3];
        answer_pixel(r, o, i, x);
        for (int c = 0; c < 3; c++) {
            float b = known ? known[i].b[c] : film->sky[c] * (1.0f - q[i]);
            out[3 * i + (size_t)c] = b + q[i] * x[c];
        }
    }
}

static void predict(const lf_reconstruction *r, lf_reconstruct_scratch *scratch,
                    const lf_pixels *pixels, int n)
{
    r->kernels->predict(&scratch->table, pixels, 0, n, scratch->predicted);
}

lf_status lf_reconstruct_row(lf_reconstruction *r, const lf_film *film, int row, float *out)
{
    if (!r->ready || !lf_film_visited(film->rows[row].visits))
        return LF_E_STATE;
    lf_reconstruct_scratch *scratch = lf_scratch_take(r),
                           *bounded = r->is_bright ? lf_scratch_take(r->bounded) : NULL;
    lf_status status = scratch && (bounded || !r->is_bright) ? LF_OK : LF_E_NOMEM;
    if (status == LF_OK)
        status = lf_table_make(&scratch->table, r, row, LF_BOTH);
    if (status == LF_OK && bounded)
        status = lf_table_make(&bounded->table, r->bounded, row, LF_BOTH);
    if (status == LF_OK && lf_pixels_read(&scratch->rows[0], r, film, row, LF_READ_ALL)) {
        const lf_answered_row o = {film, scratch, bounded, lf_row_halves_of(film, row), row};
        predict(r, scratch, &scratch->rows[0], film->n_views * film->width);
        if (bounded)
            predict(r->bounded, bounded, &scratch->rows[0], film->n_views * film->width);
        answer_row(r, &o, out);
    }
    if (scratch)
        lf_scratch_give(r, scratch);
    if (bounded)
        lf_scratch_give(r->bounded, bounded);
    return status;
}
