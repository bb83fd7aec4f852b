/* The loops of kernel.h, to be compiled for an instruction set. */
#include <math.h>
#include <string.h>

#include "render/reconstruct/solve_lanes.h"

/* Pixels that are read together, without branches, so that compilers vectorise the loops. */
#ifndef READ_LANES
#define READ_LANES 8
#endif

/* Features of some pixels. */
typedef struct lane_features {
    float nearness[READ_LANES], spread[READ_LANES], surface[READ_LANES], light[READ_LANES];
} lane_features;

static inline void unpack(const lf_packed_feature *p, int n, lane_features *out)
{
    for (int j = 0; j < n; j++) {
        lf_feature f = lf_feature_unpack(p[j]);
        out->nearness[j] = f.nearness;
        out->spread[j] = f.spread;
        out->surface[j] = f.surface;
        out->light[j] = f.light;
    }
}

/* A half without features of its own gets the other half's. */
static inline void stand_in(const float *own, const lane_features *other, int n, lane_features *f)
{
    for (int j = 0; j < n; j++) {
        bool has = own[j] > 0.0f;
        f->nearness[j] = has ? f->nearness[j] : other->nearness[j];
        f->spread[j] = has ? f->spread[j] : other->spread[j];
        f->surface[j] = has ? f->surface[j] : other->surface[j];
        f->light[j] = has ? f->light[j] : other->light[j];
    }
}

static inline void mix(const lane_features *a, const lane_features *b, const float *of_b, int n,
                       lane_features *out)
{
    for (int j = 0; j < n; j++) {
        float t = of_b[j], s = 1.0f - t, d = b->nearness[j] - a->nearness[j];
        out->nearness[j] = s * a->nearness[j] + t * b->nearness[j];
        out->spread[j] = sqrtf(s * a->spread[j] * a->spread[j] + t * b->spread[j] * b->spread[j] +
                               s * t * d * d);
        out->surface[j] = s * a->surface[j] + t * b->surface[j];
        out->light[j] = s * a->light[j] + t * b->light[j];
    }
}

/* The coordinates of the pixels from k on, and their other features. */
static inline void place(const lf_view_row *in, int k, int n, const lane_features *f,
                         const float *q, float *const out[LF_FEATURES])
{
    const float deep = in->deep, shift = in->shift, still = in->still;
    const int first = in->first + k;
    for (int j = 0; j < n; j++)
        out[LF_PLACE][first + j] =
            ((float)(k + j) + 0.5f + shift * (f->nearness[j] - still)) * (1.0f / LF_CELL_SIDE);
    for (int j = 0; j < n; j++)
        out[LF_DEPTH][first + j] = f->nearness[j] * deep;
    for (int j = 0; j < n; j++)
        out[LF_MEDIA][first + j] = 1.0f - f->surface[j];
    for (int j = 0; j < n; j++)
        out[LF_PIVOTS][first + j] = q[j];
    for (int j = 0; j < n; j++)
        out[LF_SPREAD][first + j] = f->spread[j] * deep;
    for (int j = 0; j < n; j++)
        out[LF_LIGHT][first + j] = f->light[j];
}

static inline int floor_int(float x)
{
    const float most = 0x1p24f;
    x = x > -most ? (x < most ? x : most) : -most;
    int i = (int)x;
    return i - ((float)i > x);
}

/* floor_int for n numbers, in separate steps, because compilers do not vectorise it as a whole. */
static inline void floor_lanes(const float *x, int n, int *out)
{
    const float most = 0x1p24f;
    float clamped[READ_LANES];
    int down[READ_LANES];
    for (int j = 0; j < n; j++) {
        float least = x[j] > -most ? x[j] : -most;
        clamped[j] = least < most ? least : most;
    }
    for (int j = 0; j < n; j++)
        down[j] = (int)clamped[j];
    for (int j = 0; j < n; j++)
        out[j] = (float)down[j] > clamped[j] ? down[j] - 1 : down[j];
}

/* A node of a layer; outside the layer its first node, with weight 0. */
static inline int node_of(const lf_deck *layer, int u, float *weight)
{
    int i = u - layer->u0;
    bool there = i >= 0 && i + 1 < layer->nu;
    *weight = there ? *weight : 0.0f;
    return there ? i : 0;
}

/* place for both halves together. */
static inline void place_both(const lf_view_row *in, int k, int n, const lane_features *f,
                              const float *q, lf_pixels *out)
{
    float *const *to = out->f[LF_BOTH];
    const int first = in->first + k;
    place(in, k, n, f, q, to);
    for (int j = 0; j < n; j++) {
        to[LF_ROW][first + j] = in->row;
        to[LF_VIEW][first + j] = in->view;
    }
    floor_lanes(to[LF_PLACE] + first, n, out->u + first);
    floor_lanes(to[LF_DEPTH] + first, n, out->z + first);
}

static inline void read_lanes(const lf_view_row *in, int k, int n, bool halves, lf_pixels *out)
{
    /* a half without samples is not read */
    const int half[2] = {in->share[0] > 0.0f ? 0 : 1, in->share[1] > 0.0f ? 1 : 0};
    const float share_a = half[0] == 0 ? in->share[0] : 0.0f,
                share_b = half[1] == 1 ? in->share[1] : 0.0f;
    const float *qa = in->q[half[0]] + k, *qb = in->q[half[1]] + k;
    float wa[READ_LANES], wb[READ_LANES], q[READ_LANES], of_b[READ_LANES];
    float own_a[READ_LANES], own_b[READ_LANES];
    lane_features a, b, both;
    int any = 0;
    for (int j = 0; j < n; j++) {
        wa[j] = share_a * qa[j];
        wb[j] = share_b * qb[j];
        q[j] = wa[j] + wb[j];
    }
    for (int j = 0; j < n; j++)
        any |= lf_q_is_fitted(q[j]);
    memcpy(out->q + in->first + k, q, (size_t)n * sizeof *q);
    if (!any)
        return;
    unpack(in->feature[half[0]] + k, n, &a);
    unpack(in->feature[half[1]] + k, n, &b);
    both = a;
    stand_in(wa, &b, n, &a);
    stand_in(wb, &both, n, &b);
    for (int j = 0; j < n; j++) {
        of_b[j] = wb[j] / q[j];
        own_a[j] = wa[j] > 0.0f ? qa[j] : q[j];
        own_b[j] = wb[j] > 0.0f ? qb[j] : q[j];
    }
    mix(&a, &b, of_b, n, &both);
    place_both(in, k, n, &both, q, out);
    if (!halves)
        return;
    place(in, k, n, &a, own_a, out->f[LF_HALF_A]);
    place(in, k, n, &b, own_b, out->f[LF_HALF_B]);
}

static void read(const lf_view_row *in, bool halves, lf_pixels *out)
{
    int k = 0;
    for (; k + READ_LANES <= in->n; k += READ_LANES)
        read_lanes(in, k, READ_LANES, halves, out);
    if (k < in->n)
        read_lanes(in, k, in->n - k, halves, out);
}

static inline void add_row(float *to, float weight, const float *from)
{
    lf_by_feature sum, x;
    memcpy(&sum, to, sizeof sum);
    memcpy(&x, from, sizeof x);
    sum += weight * x;
    memcpy(to, &sum, sizeof sum);
}

static void add(lf_moments *restrict m, float w, const float n[3], const float f[LF_FEATURES])
{
    m->w += w;
    add_row(m->wf, w, f);
    for (int i = 0; i < LF_FEATURES; i++)
        add_row(m->wff[i], w * f[i], f);
    for (int c = 0; c < 3; c++) {
        m->n[c] += n[c];
        add_row(m->nf[c], n[c], f);
    }
}

static void move(lf_moments *restrict to, const lf_moments *restrict from, float weight,
                 const float shift[LF_FEATURES])
{
    lf_by_feature t, wf, moved, row, sum;
    memcpy(&t, shift, sizeof t);
    memcpy(&wf, from->wf, sizeof wf);
    moved = wf + t * from->w;
    to->w += weight * from->w;
    memcpy(&sum, to->wf, sizeof sum);
    sum += weight * moved;
    memcpy(to->wf, &sum, sizeof sum);
    for (int i = 0; i < 3; i++) {
        memcpy(&row, from->wff[i], sizeof row);
        memcpy(&sum, to->wff[i], sizeof sum);
        sum += weight * (row + shift[i] * moved + from->wf[i] * t);
        memcpy(to->wff[i], &sum, sizeof sum);
    }
    for (int i = 3; i < LF_FEATURES; i++)
        add_row(to->wff[i], weight, from->wff[i]);
    for (int c = 0; c < 3; c++) {
        to->n[c] += weight * from->n[c];
        memcpy(&row, from->nf[c], sizeof row);
        memcpy(&sum, to->nf[c], sizeof sum);
        sum += weight * (row + t * from->n[c]);
        memcpy(to->nf[c], &sum, sizeof sum);
    }
}

/* R, G, B and weight of two neighbouring nodes. */
typedef float node_terms __attribute__((vector_size(32)));

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
        node_terms sum = {0}, plane, next;
        float own = 0.0f;
        for (int l = 0; l < 2; l++) {
            size_t stride = (size_t)layer[l].nu * 4, at = layer[l].first;
            const float *terms = table->terms + at * LF_TABLE_TERMS * 4 + (size_t)node[l] * 4,
                        *share = table->share + at + node[l];
            const float a = weight[l] * (1.0f - tu), b = weight[l] * tu;
            memcpy(&plane, terms, sizeof plane);
            for (int term = 1; term < LF_TABLE_TERMS; term++) {
                memcpy(&next, terms + (size_t)term * stride, sizeof next);
                plane += x[term] * next;
            }
            sum += (node_terms){a, a, a, a, b, b, b, b} * plane;
            own += a * share[0] + b * share[1];
        }
        float there = sum[3] + sum[7], inverse = there > 0.0f ? 1.0f / there : 0.0f;
        for (int c = 0; c < 3; c++)
            out[k][c] = (sum[c] + sum[c + 4]) * inverse;
        out[k][3] = there > 0.0f ? own * inverse : -1.0f;
    }
}

/* What both halves have received in some pixels. */
typedef struct lane_found {
    float n[3][READ_LANES], w[READ_LANES], w2[READ_LANES];
} lane_found;

static inline void add_half(const lf_to_show *in, int h, int k, int n, lane_found *to)
{
    const lf_film_scattered *s = in->scattered[h] + k;
    const float *w2 = in->w2[h] ? in->w2[h] + k : NULL;
    for (int c = 0; c < 3; c++)
        for (int j = 0; j < n; j++)
            to->n[c][j] += s[j].n[c];
    for (int j = 0; j < n; j++)
        to->w[j] += s[j].w;
    for (int j = 0; j < n; j++)
        to->w2[j] += w2 ? w2[j] : s[j].w;
}

static inline void show_lanes(const lf_to_show *in, const lf_pixels *pixels, float (*predicted)[4],
                              int k, int n, float (*out)[3])
{
    const float *q = pixels->q + k;
    const bool *second = pixels->second + k;
    float w[READ_LANES], share[READ_LANES], shown[3][READ_LANES], x[3][READ_LANES];
    lane_found found = {.w = {0.0f}};
    if (in->scattered[0])
        add_half(in, 0, k, n, &found);
    if (in->scattered[1])
        add_half(in, 1, k, n, &found);
    for (int j = 0; j < n; j++) {
        float over = lf_film_weight(found.w[j], found.w2[j], second[j]);
        w[j] = over > in->least * (q[j] * in->n) ? over : 0.0f;
    }
    for (int j = 0; j < n; j++) {
        bool near = lf_q_is_fitted(q[j]) && predicted[k + j][3] >= 0.0f;
        share[j] = near ? predicted[k + j][3] : 1.0f;
        for (int c = 0; c < 3; c++)
            x[c][j] = near ? predicted[k + j][c] : 0.0f;
    }
    for (int c = 0; c < 3; c++)
        for (int j = 0; j < n; j++)
            shown[c][j] = lf_channel_show(found.n[c][j], w[j], x[c][j], share[j]);
    for (int j = 0; j < n; j++)
        for (int c = 0; c < 3; c++)
            out[k + j][c] = shown[c][j];
}

static void show(const lf_to_show *in, const lf_pixels *pixels, float (*predicted)[4], int n,
                 float (*out)[3])
{
    int k = 0;
    for (; k + READ_LANES <= n; k += READ_LANES)
        show_lanes(in, pixels, predicted, k, READ_LANES, out);
    if (k < n)
        show_lanes(in, pixels, predicted, k, n - k, out);
}
