/* The loops of kernel.h, to be compiled for an instruction set. */
#include <math.h>
#include <string.h>

#include "render/reconstruct/kernel.h"

/* Below it nothing that scatters adds up to a code of a display. */
#define LEAST_Q 1e-4f

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
    float deep = in->depth * (1.0f / LF_CELL_DEPTH);
    out->f[variant][LF_PLACE][i] =
        (column + in->shift * (f->nearness - 1.0f)) * (1.0f / LF_CELL_SIDE);
    out->f[variant][LF_DEPTH][i] = f->nearness * deep;
    out->f[variant][LF_MEDIA][i] = 1.0f - f->surface;
    out->f[variant][LF_PIVOTS][i] = q;
    out->f[variant][LF_SPREAD][i] = f->spread * deep;
    out->f[variant][LF_LIGHT][i] = f->light;
}

static inline int floor_int(float x)
{
    int i = (int)x;
    return i - ((float)i > x);
}

/* Pixels may have moved away from where they were fitted: the nearest nodes are theirs then. */
static inline int within(int i, int first, int n)
{
    i = i < first ? first : i;
    return i < first + n ? i : first + n - 1;
}

static inline float clamp01(float x)
{
    return x > 0.0f ? (x < 1.0f ? x : 1.0f) : 0.0f;
}

static void read(const lf_view_row *in, bool halves, lf_pixels *out)
{
    for (int k = 0; k < in->n; k++) {
        int i = in->first + k;
        float wa = in->share[0] * in->q[0][k], wb = in->share[1] * in->q[1][k], q = wa + wb;
        out->q[i] = q > LEAST_Q ? q : 0.0f;
        if (!(q > LEAST_Q))
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
    size_t layer = (size_t)table->nu * LF_TABLE_TERMS * 4, stride = (size_t)table->nu * 4;
    for (int k = 0; k < n; k++) {
        int i = first + k;
        if (!(pixels->q[i] > 0.0f))
            continue;
        float u = f[LF_PLACE][i] - 0.5f, z = f[LF_DEPTH][i] - 0.5f;
        int iu = within(floor_int(u), table->u0, table->nu - 1),
            iz = within(floor_int(z), table->z0, table->nz - 1);
        float tu = clamp01(u - (float)iu), tz = clamp01(z - (float)iz);
        const float x[LF_TABLE_TERMS] = {
            1.0f,          f[LF_PLACE][i],  f[LF_DEPTH][i], f[LF_MEDIA][i], f[LF_PIVOTS][i],
            f[LF_VIEW][i], f[LF_SPREAD][i], f[LF_LIGHT][i]};
        float w[2][8], sum[8] = {0};
        for (int j = 0; j < 8; j++) {
            float across = j < 4 ? 1.0f - tu : tu;
            w[0][j] = (1.0f - tz) * across;
            w[1][j] = tz * across;
        }
        size_t at = (size_t)(iu - table->u0) * 4 + (size_t)(iz - table->z0) * layer;
        const float *a = table->terms + at, *b = a + layer;
        for (int term = 0; term < LF_TABLE_TERMS; term++)
            for (int j = 0; j < 8; j++)
                sum[j] += x[term] * (w[0][j] * a[(size_t)term * stride + (size_t)j] +
                                     w[1][j] * b[(size_t)term * stride + (size_t)j]);
        const float *share =
            table->share + (size_t)(iz - table->z0) * (size_t)table->nu + (iu - table->u0);
        float own = w[0][0] * share[0] + w[0][4] * share[1] + w[1][0] * share[table->nu] +
                    w[1][4] * share[table->nu + 1],
              weight = sum[3] + sum[7], inverse = weight > 0.0f ? 1.0f / weight : 0.0f;
        for (int c = 0; c < 3; c++)
            out[k][c] = (sum[c] + sum[c + 4]) * inverse;
        out[k][3] = weight > 0.0f ? own * inverse : -1.0f;
    }
}
