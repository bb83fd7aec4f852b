/* The answer of one row: its pixels' features, the planes of the nodes around each, and N/W of the
 * pixel itself by its share. */
#include <string.h>

#include "render/reconstruct/moments.h"

/* The prediction of R and the share of N/W about one pixel. */
typedef struct lf_prediction {
    float radiance[3], share;
} lf_prediction;

/* Between the eight nodes around; the pixel's own cell is one of them, so that there is one. */
static lf_prediction predict(const lf_reconstruction *r, int row, const float f[LF_FEATURES],
                             int variant)
{
    lf_prediction out = {{0}, 0};
    float at[3] = {f[LF_PLACE] - 0.5f, ((float)row + 0.5f) / LF_CELL_SIDE - 0.5f,
                   f[LF_DEPTH] - 0.5f},
          sum = 0.0f, t[3];
    int low[3];
    for (int i = 0; i < 3; i++) {
        low[i] = (int)floorf(at[i]);
        t[i] = at[i] - (float)low[i];
    }
    for (int i = 0; i < 8; i++) {
        int u = low[0] + (i & 1), v = low[1] + (i >> 1 & 1), z = low[2] + (i >> 2);
        float weight = (i & 1 ? t[0] : 1.0f - t[0]) * (i >> 1 & 1 ? t[1] : 1.0f - t[1]) *
                       (i >> 2 ? t[2] : 1.0f - t[2]);
        int n = v >= 0 && v < r->level[0].n_bands ? lf_band_find(&r->level[0].bands[v], u, z) : -1;
        if (n < 0 || !(weight > 0.0f))
            continue;
        const lf_cell *cell = &r->level[0].bands[v].cells[n];
        const float here[LF_FEATURES] = {at[0] - (float)u, at[1] - (float)v, at[2] - (float)z,
                                         f[LF_MEDIA],      f[LF_PIVOTS],     f[LF_VIEW],
                                         f[LF_SPREAD],     f[LF_LIGHT]};
        sum += weight;
        out.share += weight * cell->share;
        for (int c = 0; c < 3; c++) {
            const lf_plane *p = &cell->node[variant][c];
            float x = p->constant;
            for (int j = 0; j < LF_FEATURES; j++)
                x += p->slope[j] * here[j];
            out.radiance[c] += weight * x;
        }
    }
    float inverse = sum > 0.0f ? 1.0f / sum : 0.0f;
    out.share *= inverse;
    for (int c = 0; c < 3; c++)
        out.radiance[c] *= inverse;
    return out;
}

static void answer_pixel(const lf_reconstruction *r, const lf_film *film, int row, size_t i,
                         const lf_pixels *pixels, const lf_film_half half[2], const float known[3],
                         float out[3])
{
    const lf_film_row *state = &film->rows[row];
    float q = pixels->q[i], w = 0.0f, n[3] = {0};
    lf_prediction p = predict(r, row, pixels->feature[LF_BOTH][i].f, LF_BOTH);
    for (int h = 0; h < 2; h++) {
        if (!(state->n[h] > 0.0))
            continue;
        w += half[h].scattered[i].w;
        for (int c = 0; c < 3; c++)
            n[c] += half[h].scattered[i].n[c];
    }
    bool usable = lf_weight_is_usable(film, w, q * (float)(state->n[0] + state->n[1]));
    for (int c = 0; c < 3; c++) {
        float x = p.radiance[c];
        if (usable)
            x += p.share * (n[c] / w - x);
        out[c] = known[c] + q * (x > 0.0f ? x : 0.0f);
    }
}

lf_status lf_reconstruct_row(const lf_reconstruction *r, const lf_film *film, int row, float *out)
{
    lf_pixels *pixels;
    size_t n = (size_t)film->n_views * (size_t)film->width;
    if (!r->ready)
        return LF_E_STATE;
    lf_status status = lf_pixels_create(n, &pixels);
    if (status == LF_OK && !lf_pixels_read(pixels, r, film, row, false))
        status = LF_E_STATE;
    const lf_film_half half[2] = {lf_film_at(film, row, 0), lf_film_at(film, row, 1)};
    const lf_film_known *known = lf_film_known_at(film, row);
    for (size_t i = 0; i < n && status == LF_OK; i++) {
        float b[3], q = pixels->q[i];
        for (int c = 0; c < 3; c++)
            b[c] = known ? known[i].b[c] : film->sky[c] * (1.0f - q);
        if (q > 0.0f)
            answer_pixel(r, film, row, i, pixels, half, b, out + 3 * i);
        else
            memcpy(out + 3 * i, b, sizeof b);
    }
    lf_pixels_destroy(pixels);
    return status;
}
