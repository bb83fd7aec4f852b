/* The loops of kernel.h, to be compiled for an instruction set. */
#include <math.h>
#include <string.h>

#include "render/reconstruct/kernel.h"

/* One half's features as they are, with the other's where it has none. */
typedef struct half_features {
    float nearness, spread, surface, light;
} half_features;

static inline half_features unpack(const lf_packed_feature *p)
{
    lf_feature f = lf_feature_unpack(*p);
    return (half_features){f.nearness, f.spread, f.surface, f.light};
}

static inline void place(const lf_view_row *in, lf_pixels *out, int variant, int i, float column,
                         const half_features *f, float q)
{
    float deep = in->deep;
    out->f[variant][LF_PLACE][i] =
        (column + in->shift * (f->nearness - in->still)) * (1.0f / LF_CELL_SIDE);
    out->f[variant][LF_DEPTH][i] = f->nearness * deep;
    out->f[variant][LF_MEDIA][i] = 1.0f - f->surface;
    out->f[variant][LF_PIVOTS][i] = q;
    out->f[variant][LF_SPREAD][i] = f->spread * deep;
    out->f[variant][LF_LIGHT][i] = f->light;
}

static inline int floor_int(float x)
{
    const float most = 0x1p24f;
    x = x > -most ? (x < most ? x : most) : -most;
    int i = (int)x;
    return i - ((float)i > x);
}

/* A node of a layer, or the layer's first with no weight. */
static inline int node_of(const lf_deck *layer, int u, float *weight)
{
    int i = u - layer->u0;
    bool there = i >= 0 && i + 1 < layer->nu;
    *weight = there ? *weight : 0.0f;
    return there ? i : 0;
}

static void read(const lf_view_row *in, bool halves, lf_pixels *out)
{
    for (int k = 0; k < in->n; k++) {
        int i = in->first + k;
        float wa = in->share[0] > 0.0f ? in->share[0] * in->q[0][k] : 0.0f,
              wb = in->share[1] > 0.0f ? in->share[1] * in->q[1][k] : 0.0f, q = wa + wb;
        out->q[i] = q;
        if (!(q > LF_LEAST_Q && q < 2.0f))
            continue;
        half_features a = unpack(&in->feature[wa > 0.0f ? 0 : 1][k]),
                      b = unpack(&in->feature[wb > 0.0f ? 1 : 0][k]);
        float t = wb / q, s = 1.0f - t, d = b.nearness - a.nearness, column = (float)k + 0.5f;
        const half_features both = {
            s * a.nearness + t * b.nearness,
            sqrtf(s * a.spread * a.spread + t * b.spread * b.spread + s * t * d * d),
            s * a.surface + t * b.surface, s * a.light + t * b.light};
        place(in, out, LF_BOTH, i, column, &both, q);
        out->f[LF_BOTH][LF_ROW][i] = in->row;
        out->f[LF_BOTH][LF_VIEW][i] = in->view;
        out->u[i] = floor_int(out->f[LF_BOTH][LF_PLACE][i]);
        out->z[i] = floor_int(out->f[LF_BOTH][LF_DEPTH][i]);
        if (!halves)
            continue;
        place(in, out, LF_HALF_A, i, column, &a, wa > 0.0f ? in->q[0][k] : q);
        place(in, out, LF_HALF_B, i, column, &b, wb > 0.0f ? in->q[1][k] : q);
    }
}

static void add(lf_moments *m, float w, const float n[3], const float f[LF_FEATURES])
{
    m->w += w;
    for (int i = 0; i < LF_FEATURES; i++)
        m->wf[i] += w * f[i];
    for (int i = 0; i < LF_FEATURES; i++) {
        float wf = w * f[i];
        for (int j = 0; j < LF_FEATURES; j++)
            m->wff[i][j] += wf * f[j];
    }
    for (int c = 0; c < 3; c++) {
        m->n[c] += n[c];
        for (int i = 0; i < LF_FEATURES; i++)
            m->nf[c][i] += n[c] * f[i];
    }
}

static void move(lf_moments *to, const lf_moments *from, float weight, const float shift[3])
{
    const float t[LF_FEATURES] = {shift[0], shift[1], shift[2]};
    float moved[LF_FEATURES];
    to->w += weight * from->w;
    for (int i = 0; i < LF_FEATURES; i++) {
        moved[i] = from->wf[i] + t[i] * from->w;
        to->wf[i] += weight * moved[i];
    }
    for (int i = 0; i < LF_FEATURES; i++) {
        float ti = t[i], wfi = from->wf[i];
        for (int j = 0; j < LF_FEATURES; j++)
            to->wff[i][j] += weight * (from->wff[i][j] + ti * moved[j] + wfi * t[j]);
    }
    for (int c = 0; c < 3; c++) {
        float n = from->n[c];
        to->n[c] += weight * n;
        for (int i = 0; i < LF_FEATURES; i++)
            to->nf[c][i] += weight * (from->nf[c][i] + t[i] * n);
    }
}

static void predict(const lf_row_table *table, const lf_pixels *pixels, int first, int n,
                    float (*out)[4])
{
    float *const *f = pixels->f[LF_BOTH];
    for (int k = 0; k < n; k++) {
        int i = first + k;
        if (!lf_pixel_is_fitted(pixels, (size_t)i))
            continue;
        float u = f[LF_PLACE][i] - 0.5f, z = f[LF_DEPTH][i] - 0.5f;
        int iu = floor_int(u), iz = floor_int(z) - table->z0;
        float tu = u - (float)iu, tz = z - (float)(iz + table->z0), weight[2] = {1.0f - tz, tz};
        if (iz < 0 || iz + 1 >= table->nz) {
            out[k][3] = -1.0f;
            continue;
        }
        const lf_deck *layer = &table->layers[iz];
        int node[2] = {node_of(&layer[0], iu, &weight[0]), node_of(&layer[1], iu, &weight[1])};
        const float x[LF_TABLE_TERMS] = {
            1.0f,          f[LF_PLACE][i],  f[LF_DEPTH][i], f[LF_MEDIA][i], f[LF_PIVOTS][i],
            f[LF_VIEW][i], f[LF_SPREAD][i], f[LF_LIGHT][i]};
        float w[2][8], sum[8] = {0}, own = 0.0f;
        for (int j = 0; j < 8; j++) {
            float across = j < 4 ? 1.0f - tu : tu;
            w[0][j] = weight[0] * across;
            w[1][j] = weight[1] * across;
        }
        for (int l = 0; l < 2; l++) {
            size_t stride = (size_t)layer[l].nu * 4, at = layer[l].first;
            const float *terms = table->terms + at * LF_TABLE_TERMS * 4 + (size_t)node[l] * 4,
                        *share = table->share + at + node[l];
            for (int term = 0; term < LF_TABLE_TERMS; term++)
                for (int j = 0; j < 8; j++)
                    sum[j] += x[term] * (w[l][j] * terms[(size_t)term * stride + (size_t)j]);
            own += w[l][0] * share[0] + w[l][4] * share[1];
        }
        float there = sum[3] + sum[7], inverse = there > 0.0f ? 1.0f / there : 0.0f;
        for (int c = 0; c < 3; c++)
            out[k][c] = (sum[c] + sum[c + 4]) * inverse;
        out[k][3] = there > 0.0f ? own * inverse : -1.0f;
    }
}
