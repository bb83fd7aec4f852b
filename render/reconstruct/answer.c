/* The answer of one row: what the nodes around its pixels predict, and N/W of the pixel itself by
 * its share. */
#include <string.h>

#include "base/alloc.h"
#include "render/reconstruct/moments.h"
#include "render/reconstruct/scratch.h"

/* N, W and W' of both halves. */
static lf_pixel_found found_at(const lf_film_row *state, const lf_film_half half[2], size_t i)
{
    lf_pixel_found found = {.w = 0.0f};
    for (int h = 0; h < 2; h++)
        if (state->n[h] > 0.0)
            lf_pixel_found_add(&found, &half[h], i);
    return found;
}

/* n: what both halves have found, over w, which is 0 where that is no answer. predicted[3]: the
 * share of N/W, below 0 where no node is near. */
static void answer_pixel(const float n[3], float w, float q, const float known[3],
                         const float predicted[4], float out[3])
{
    bool near = predicted[3] >= 0.0f;
    for (int c = 0; c < 3; c++) {
        float x = near ? predicted[c] : 0.0f, share = near ? predicted[3] : 1.0f;
        if (w > 0.0f)
            x += share * (n[c] / w - x);
        out[c] = known[c] + q * (x > 0.0f ? x : 0.0f);
    }
}

static void answer_row(const lf_film *film, int row, const lf_reconstruct_scratch *scratch,
                       float *out)
{
    const lf_film_row *state = &film->rows[row];
    const lf_film_half half[2] = {lf_film_at(film, row, 0), lf_film_at(film, row, 1)};
    const lf_film_known *known = lf_film_known_at(film, row);
    const float *q = scratch->rows[0].q;
    size_t pixels = (size_t)film->n_views * (size_t)film->width;
    for (size_t i = 0; i < pixels; i++) {
        float b[3];
        for (int c = 0; c < 3; c++)
            b[c] = known ? known[i].b[c] : film->sky[c] * (1.0f - q[i]);
        const lf_pixel_found found = found_at(state, half, i);
        float w = lf_pixel_found_weight(film, &found, scratch->rows[0].second[i],
                                        q[i] * (float)(state->n[0] + state->n[1]));
        const float none[4] = {0.0f, 0.0f, 0.0f, -1.0f};
        bool fitted = lf_pixel_is_fitted(&scratch->rows[0], i);
        answer_pixel(found.n, w, q[i], b, fitted ? scratch->predicted[i] : none, out + 3 * i);
    }
}

lf_status lf_reconstruct_row(lf_reconstruction *r, const lf_film *film, int row, float *out)
{
    if (!r->ready || !lf_film_visited(film->rows[row].visits))
        return LF_E_STATE;
    lf_reconstruct_scratch *scratch = lf_scratch_take(r);
    if (!scratch)
        return LF_E_NOMEM;
    lf_status status = lf_table_make(&scratch->table, r, row, LF_BOTH);
    if (status == LF_OK && lf_pixels_read(&scratch->rows[0], r, film, row, false)) {
        r->kernels->predict(&scratch->table, &scratch->rows[0], 0, film->n_views * film->width,
                            scratch->predicted);
        answer_row(film, row, scratch, out);
    }
    lf_scratch_give(r, scratch);
    return status;
}
