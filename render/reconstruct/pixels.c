#include "render/reconstruct/pixels.h"

#include "base/alloc.h"

/* Below it nothing that scatters adds up to a code of a display. */
#define LEAST_Q 1e-4f

lf_status lf_pixels_create(size_t n, lf_pixels **out)
{
    lf_pixels *p = lf_calloc(1, sizeof *p);
    bool whole = p;
    for (int i = 0; i < LF_VARIANTS && whole; i++) {
        p->feature[i] = lf_calloc(n, sizeof *p->feature[i]);
        whole = p->feature[i];
    }
    if (whole) {
        p->u = lf_calloc(n, sizeof *p->u);
        p->z = lf_calloc(n, sizeof *p->z);
        p->q = lf_calloc(n, sizeof *p->q);
        whole = p->u && p->z && p->q;
    }
    if (!whole) {
        lf_pixels_destroy(p);
        return LF_E_NOMEM;
    }
    *out = p;
    return LF_OK;
}

void lf_pixels_destroy(lf_pixels *pixels)
{
    if (!pixels)
        return;
    for (int i = 0; i < LF_VARIANTS; i++)
        lf_free(pixels->feature[i]);
    lf_free(pixels->u);
    lf_free(pixels->z);
    lf_free(pixels->q);
    lf_free(pixels);
}

/* Means of two halves with the weights wa and wb. */
static lf_feature pooled(const lf_feature *a, const lf_feature *b, float wa, float wb)
{
    float t = wb / (wa + wb), s = 1.0f - t, d = b->nearness - a->nearness;
    return (lf_feature){
        s * a->nearness + t * b->nearness,
        sqrtf(s * a->spread * a->spread + t * b->spread * b->spread + s * t * d * d),
        s * a->surface + t * b->surface, s * a->light + t * b->light};
}

static void place(lf_pixel_features *out, const lf_feature *feature, float q, float column,
                  float row, float shift, float view, float depth)
{
    const float side = 1.0f / LF_CELL_SIDE, deep = depth * (1.0f / LF_CELL_DEPTH);
    out->f[LF_PLACE] = (column + shift * (feature->nearness - 1.0f)) * side;
    out->f[LF_ROW] = row;
    out->f[LF_DEPTH] = feature->nearness * deep;
    out->f[LF_MEDIA] = 1.0f - feature->surface;
    out->f[LF_PIVOTS] = q;
    out->f[LF_VIEW] = view;
    out->f[LF_SPREAD] = feature->spread * deep;
    out->f[LF_LIGHT] = feature->light;
}

bool lf_pixels_read(lf_pixels *pixels, const lf_reconstruction *r, const lf_film *film, int row,
                    bool halves)
{
    const lf_film_row *state = &film->rows[row];
    const lf_film_half a = lf_film_at(film, row, 0), b = lf_film_at(film, row, 1);
    double n = state->n[0] + state->n[1];
    if (!(n > 0.0))
        return false;
    float share = (float)(state->n[1] / n), v = ((float)row + 0.5f) / LF_CELL_SIDE;
    for (int k = 0; k < film->n_views; k++) {
        float shift = r->shift[k], view = (float)k / (float)film->n_views - 0.5f;
        for (int column = 0; column < film->width; column++) {
            size_t i = (size_t)k * (size_t)film->width + (size_t)column;
            float wa = state->n[0] > 0.0 ? (1.0f - share) * a.q[i] : 0.0f,
                  wb = state->n[1] > 0.0 ? share * b.q[i] : 0.0f, x = (float)column + 0.5f;
            pixels->q[i] = wa + wb > LEAST_Q ? wa + wb : 0.0f;
            if (!(pixels->q[i] > 0.0f))
                continue;
            lf_feature fa = lf_feature_unpack(wa > 0.0f ? a.feature[i] : b.feature[i]),
                       fb = wb > 0.0f ? lf_feature_unpack(b.feature[i]) : fa,
                       both = pooled(&fa, &fb, wa, wb);
            lf_pixel_features *p = &pixels->feature[LF_BOTH][i];
            place(p, &both, wa + wb, x, v, shift, view, r->view.depth);
            pixels->u[i] = (int)floorf(p->f[LF_PLACE]);
            pixels->z[i] = (int)floorf(p->f[LF_DEPTH]);
            if (!halves)
                continue;
            float qa = wa > 0.0f ? a.q[i] : wa + wb, qb = wb > 0.0f ? b.q[i] : wa + wb;
            place(&pixels->feature[LF_HALF_A][i], &fa, qa, x, v, shift, view, r->view.depth);
            place(&pixels->feature[LF_HALF_B][i], &fb, qb, x, v, shift, view, r->view.depth);
        }
    }
    return true;
}
