#include "render/film/film_sum.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "render/film/film_difference.h"
#include "render/film/film_round.h"
#include "render/transport/sampler.h"

static size_t pixels_of(const lf_film_layout *layout)
{
    return (size_t)layout->n_views * (size_t)layout->width;
}

size_t lf_film_sum_bytes(const lf_film_layout *layout)
{
    return pixels_of(layout) *
           (2 * sizeof(lf_half_sum) + (layout->has_features ? 2 * sizeof(lf_feature_sum) : 0) +
            (layout->has_known ? sizeof(lf_known_sum) : 0) +
            (layout->has_albedo ? sizeof(lf_albedo_sum) : 0));
}

lf_status lf_film_sum_init(lf_film_sum *sum, const lf_film_layout *layout)
{
    *sum = (lf_film_sum){.layout = *layout, .pixels = pixels_of(layout)};
    bool made = true;
    for (int h = 0; h < 2; h++) {
        sum->half[h] = lf_calloc(sum->pixels, sizeof *sum->half[h]);
        if (layout->has_features)
            sum->feature[h] = lf_calloc(sum->pixels, sizeof *sum->feature[h]);
        made = made && sum->half[h] && (sum->feature[h] || !layout->has_features);
    }
    if (layout->has_known)
        sum->known = lf_calloc(sum->pixels, sizeof *sum->known);
    if (layout->has_albedo)
        sum->albedo = lf_calloc(sum->pixels, sizeof *sum->albedo);
    if (made && (sum->known || !layout->has_known) && (sum->albedo || !layout->has_albedo))
        return LF_OK;
    lf_film_sum_finish(sum);
    return LF_E_NOMEM;
}

void lf_film_sum_finish(lf_film_sum *sum)
{
    for (int h = 0; h < 2; h++) {
        lf_free(sum->half[h]);
        lf_free(sum->feature[h]);
    }
    lf_free(sum->known);
    lf_free(sum->albedo);
    memset(sum, 0, sizeof *sum);
}

void lf_film_sum_begin(lf_film_sum *sum, bool whole)
{
    for (int h = 0; h < 2; h++) {
        memset(sum->half[h], 0, sum->pixels * sizeof *sum->half[h]);
        if (sum->feature[h])
            memset(sum->feature[h], 0, sum->pixels * sizeof *sum->feature[h]);
        sum->n_known[h] = 0.0;
    }
    if (sum->known)
        memset(sum->known, 0, sum->pixels * sizeof *sum->known);
    if (sum->albedo)
        memset(sum->albedo, 0, sum->pixels * sizeof *sum->albedo);
    sum->row = (lf_film_row){.relative_error = -1.0};
    sum->whole = whole;
}

/* --------------------------------------------------------------------------------------- add -- */

/* Moves a mean; a constant stays exact. */
static inline void mean(double *of, double share, double x)
{
    *of += share * (x - *of);
}

/* The weight of a film in means: n of its known visits, and their share so far. */
typedef struct lf_sum_shares {
    double n[2], half[2], both;
} lf_sum_shares;

static void add_half(lf_half_sum *to, const lf_film_half *from, size_t i, double share)
{
    const lf_film_scattered *b = &from->scattered[i];
    for (int c = 0; c < 3; c++)
        to->n[c] += (double)b->n[c];
    to->w += b->w == LF_FILM_SETTLED ? LF_SUM_MARK : (double)b->w;
    if (from->w2)
        to->w2 += (double)from->w2[i];
    if (share > 0.0)
        mean(&to->q, share, (double)from->q[i]);
}

static void add_feature(lf_feature_sum *to, lf_packed_feature packed, double weight)
{
    if (!(weight > 0.0))
        return;
    const lf_feature b = lf_feature_unpack(packed);
    const double t = weight / (to->weight + weight), s = 1.0 - t,
                 d = (double)b.nearness - to->nearness, spread = (double)b.spread;
    to->variance = s * to->variance + t * spread * spread + s * t * d * d;
    mean(&to->nearness, t, (double)b.nearness);
    mean(&to->surface, t, (double)b.surface);
    mean(&to->light, t, (double)b.light);
    to->weight += weight;
}

static void add_albedo(lf_albedo_sum *to, lf_packed_albedo packed, double weight)
{
    float of[LF_ALBEDO_NUMBERS];
    if (packed == 0 || !(weight > 0.0))
        return;
    lf_albedo_unpack(packed, of);
    to->weight += weight;
    for (int c = 0; c < LF_ALBEDO_NUMBERS; c++)
        mean(&to->of[c], weight / to->weight, (double)of[c]);
}

static void add_known(lf_known_sum *to, const lf_film_known *from, const lf_sum_shares *s)
{
    float difference[3];
    const double n = s->n[0] + s->n[1];
    if (!(n > 0.0))
        return;
    lf_difference_unpack(from->difference, difference);
    for (int c = 0; c < 3; c++) {
        const double both = (double)from->b[c], d = (double)difference[c],
                     half[2] = {both + s->n[1] / n * d, both - s->n[0] / n * d};
        mean(&to->b[c], s->both, both);
        for (int h = 0; h < 2; h++)
            if (s->half[h] > 0.0)
                mean(&to->half[h][c], s->half[h], half[h]);
    }
}

/* Counts a film's row, and returns its weights. */
static lf_sum_shares count(lf_film_sum *sum, const lf_film_row *from)
{
    lf_sum_shares s = {{0}, {0}, 0};
    for (int h = 0; h < 2; h++) {
        s.n[h] = from->n[h] - (sum->whole ? from->coarse[h] : 0.0);
        sum->n_known[h] += s.n[h];
        s.half[h] = s.n[h] > 0.0 ? s.n[h] / sum->n_known[h] : 0.0;
        sum->row.n[h] += from->n[h];
        sum->row.coarse[h] += from->coarse[h];
        /* more than possible stays so */
        const uint32_t room = UINT32_MAX - sum->row.visits[h];
        sum->row.visits[h] += from->visits[h] < room ? from->visits[h] : room;
    }
    if (s.n[0] + s.n[1] > 0.0)
        s.both = (s.n[0] + s.n[1]) / (sum->n_known[0] + sum->n_known[1]);
    sum->row.passes += from->passes;
    sum->row.met |= from->met;
    return s;
}

void lf_film_sum_add(lf_film_sum *sum, const lf_film *from, int row)
{
    const lf_sum_shares s = count(sum, &from->rows[row]);
    lf_film_open(from, row);
    const lf_film_half half[2] = {lf_film_at(from, row, 0), lf_film_at(from, row, 1)};
    const lf_film_known *known = lf_film_known_at(from, row);
    const lf_packed_albedo *albedo = lf_film_albedo_at(from, row);
    for (size_t i = 0; i < sum->pixels; i++) {
        double pivots = 0.0;
        for (int h = 0; h < 2; h++) {
            const double weight = s.n[h] * (double)half[h].q[i];
            pivots += weight;
            add_half(&sum->half[h][i], &half[h], i, s.half[h]);
            if (sum->feature[h])
                add_feature(&sum->feature[h][i], half[h].feature[i], weight);
        }
        if (albedo)
            add_albedo(&sum->albedo[i], albedo[i], pivots);
        if (known)
            add_known(&sum->known[i], &known[i], &s);
    }
    lf_film_close(from, row, false);
}

/* --------------------------------------------------------------------------------------- put -- */

static lf_packed_feature pack_feature(const lf_feature_sum *sum, uint32_t random)
{
    const lf_feature f = {(float)sum->nearness, (float)sqrt(fmax(sum->variance, 0.0)),
                          (float)sum->surface, (float)sum->light};
    return sum->weight > 0.0 ? lf_feature_pack(&f, random) : (lf_packed_feature){0};
}

static lf_packed_albedo pack_albedo(const lf_albedo_sum *sum, uint32_t random)
{
    float of[LF_ALBEDO_NUMBERS];
    for (int c = 0; c < LF_ALBEDO_NUMBERS; c++)
        of[c] = (float)sum->of[c];
    return sum->weight > 0.0 ? lf_albedo_pack(of, random) : 0;
}

static void put_half(const lf_half_sum *from, const lf_film_half *to, size_t i, uint32_t random)
{
    lf_film_scattered *a = &to->scattered[i];
    for (int c = 0; c < 3; c++)
        a->n[c] = lf_film_round(from->n[c], random);
    a->w = lf_film_round(from->w, random);
    if (to->w2)
        to->w2[i] = lf_film_round(from->w2, random);
    to->q[i] = lf_film_round(from->q, random);
}

static void put_known(const lf_known_sum *from, bool both, lf_film_known *to, uint32_t random)
{
    float difference[3] = {0};
    for (int c = 0; c < 3; c++) {
        if (both)
            difference[c] = (float)(from->half[0][c] - from->half[1][c]);
        to->b[c] = lf_film_round(from->b[c], random);
    }
    to->difference = lf_difference_pack(difference, (float)(random >> 8) * 0x1p-24f);
}

/* Whether all weight of a pixel is marks. */
static bool is_settled(const lf_film_sum *sum, size_t i)
{
    const double w = sum->half[0][i].w + sum->half[1][i].w;
    return w > 0.0 && w < LF_SUM_MARK * (2.0 * LF_FILM_MAX_STREAMS);
}

bool lf_film_sum_put(const lf_film_sum *sum, uint64_t key, const lf_film *film, int row)
{
    const bool both = sum->n_known[0] > 0.0 && sum->n_known[1] > 0.0;
    const size_t width = (size_t)sum->layout.width;
    lf_film_open(film, row);
    const lf_film_half half[2] = {lf_film_at(film, row, 0), lf_film_at(film, row, 1)};
    lf_film_known *known = lf_film_known_at(film, row);
    lf_packed_albedo *albedo = lf_film_albedo_at(film, row);
    /* As in a visit: equal numbers, in N and W or in two views, stay equal. */
    for (size_t i = 0; i < sum->pixels; i++) {
        const uint32_t random = (uint32_t)(lf_hash64(key, i % width) >> 32);
        for (int h = 0; h < 2; h++) {
            put_half(&sum->half[h][i], &half[h], i, random);
            if (half[h].feature)
                half[h].feature[i] = pack_feature(&sum->feature[h][i], random);
        }
        if (is_settled(sum, i))
            lf_film_settle(half, sum->half[0][i].w > 0.0 ? 0 : 1, i);
        if (albedo)
            albedo[i] = pack_albedo(&sum->albedo[i], random);
        if (known)
            put_known(&sum->known[i], both, &known[i], random);
    }
    film->rows[row] = sum->row;
    lf_film_lend_known(film, row);
    lf_film_close(film, row, true);
    return lf_film_row_possible(&sum->row);
}
