/* The answer of one row: what the nodes around its pixels predict, and N/W of the pixel itself by
 * its share. */
#include <math.h>
#include <string.h>

#include "render/reconstruct/bright.h"
#include "render/reconstruct/scratch.h"

/* What a row is answered from. */
typedef struct lf_answered_row {
    const lf_film *film;
    const lf_reconstruct_scratch *scratch, *bounded; /* bounded NULL: nothing is */
    lf_row_halves halves;
    int row;
} lf_answered_row;

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

/* Goes over to the bounded fit where that has a share. */
static void mix_bounded(const lf_reconstruction *r, const lf_answered_row *o, size_t i,
                        float out[3])
{
    const lf_pixels *pixels = &o->scratch->rows[0];
    const lf_film_row *state = &o->film->rows[o->row];
    lf_fitted x;
    lf_bright_pixel bright;
    lf_pixel_found both = {.w = 0.0f};
    lf_fitted_read(o->film, &o->halves, pixels->second[i], i, &x);
    lf_bright_split(r, pixels, o->row, i, &x, &bright);
    if (!(bright.share > 0.0f))
        return;
    for (int c = 0; c < 3; c++) {
        bright.below[0][c] += bright.below[1][c];
        bright.above[0][c] += bright.above[1][c];
    }
    for (int h = 0; h < 2; h++)
        lf_pixel_found_join(&both, &x.found[h]);
    float w = lf_pixel_found_weight(o->film, &both, pixels->second[i],
                                    pixels->q[i] * (float)(state->n[0] + state->n[1]));
    lf_bright_mix(bright.share, bright.below[0], bright.above[0], w, o->bounded->predicted[i], out);
}

/* B + q R. Correction weights may leave q beyond 0..1: then the sky would be dimmed, or shown more
 * than once, in a dot beside its neighbours. Where all else follows from q it is taken to be within
 * (as it is when its noise is gone); a B that was found has the same noise, and keeps it. */
static void answer_row(const lf_reconstruction *r, const lf_answered_row *o, float (*out)[3])
{
    const lf_film *film = o->film;
    const lf_film_known *known = lf_film_known_at(film, o->row);
    const lf_pixels *pixels = &o->scratch->rows[0];
    const lf_to_show in = to_show(o);
    const size_t n = (size_t)film->n_views * (size_t)film->width;
    r->kernels->show(&in, pixels, o->scratch->predicted, (int)n, out);
    for (size_t i = 0; i < n && o->bounded; i++)
        if (lf_pixel_is_fitted(pixels, i))
            mix_bounded(r, o, i, out[i]);
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

static void predict(const lf_reconstruction *r, lf_reconstruct_scratch *scratch,
                    const lf_pixels *pixels, int n)
{
    r->kernels->predict(&scratch->table, pixels, 0, n, scratch->predicted);
    lf_pixels_reflect(pixels, 0, n, scratch->predicted);
}

lf_status lf_reconstruct_row(lf_reconstruction *r, const lf_film *film, int row, float *out)
{
    if (!r->ready || !lf_film_is_known(&film->rows[row]))
        return LF_E_STATE;
    lf_reconstruct_scratch *scratch = lf_scratch_take(r),
                           *bounded = r->is_bright ? lf_scratch_take(r->bounded) : NULL;
    lf_status status = scratch && (bounded || !r->is_bright) ? LF_OK : LF_E_NOMEM;
    if (status == LF_OK)
        status = lf_table_make(&scratch->table, r, row, LF_BOTH);
    if (status == LF_OK && bounded)
        status = lf_table_make(&bounded->table, r->bounded, row, LF_BOTH);
    if (status == LF_OK && lf_pixels_read(&scratch->rows[0], r, film, row, LF_READ_ALL)) {
        const lf_row_halves halves =
            lf_row_halves_of(film, row, (const float(*)[3])scratch->rows[0].albedo);
        const lf_answered_row o = {film, scratch, bounded, halves, row};
        predict(r, scratch, &scratch->rows[0], film->n_views * film->width);
        if (bounded)
            predict(r->bounded, bounded, &scratch->rows[0], film->n_views * film->width);
        answer_row(r, &o, (float(*)[3])out);
    }
    if (scratch)
        lf_scratch_give(r, scratch);
    if (bounded)
        lf_scratch_give(r->bounded, bounded);
    return status;
}
