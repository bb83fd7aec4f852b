#include "render/film/film.h"

#include <string.h>

#include "base/alloc.h"
#include "render/film/film_difference.h"
#include "render/film/film_pack.h"
#include "render/film/film_round.h"
#include "render/transport/sampler.h"

/* Films of this size use huge pages. In smaller films, unvisited rows would dominate their memory,
 * and the gain is small. */
#define HUGE_FROM ((size_t)16 << 20)

static size_t pixels_of(const lf_film_layout *layout)
{
    return (size_t)layout->n_views * (size_t)layout->width;
}

static size_t half_bytes(const lf_film_layout *layout)
{
    return pixels_of(layout) *
           (sizeof(lf_film_scattered) + sizeof(float) + (layout->has_w2 ? sizeof(float) : 0) +
            (layout->has_features ? sizeof(lf_packed_feature) : 0));
}

size_t lf_film_used_bytes(const lf_film_layout *layout)
{
    return 2 * half_bytes(layout) +
           (layout->has_known ? pixels_of(layout) * sizeof(lf_film_known) : 0) +
           (layout->has_albedo ? pixels_of(layout) * sizeof(lf_packed_albedo) : 0);
}

/* Makes room for one more stream; row arrays of removed streams (lf_film_clear) are reused. */
static lf_status make_room(lf_film *film)
{
    size_t n = (size_t)film->n_streams;
    if (film->n_streams == film->n_allocated) {
        size_t n_wanted = n > 0 ? 2 * n : 1;
        lf_film_stream *streams = lf_calloc(n_wanted, sizeof *streams);
        if (!streams)
            return LF_E_NOMEM;
        if (n > 0)
            memcpy(streams, film->streams, n * sizeof *streams);
        lf_free(film->streams);
        film->streams = streams;
        film->n_allocated = (int)n_wanted;
    }
    lf_film_stream *next = &film->streams[n];
    if (!next->rows)
        next->rows = lf_calloc((size_t)film->height, sizeof *next->rows);
    return next->rows ? LF_OK : LF_E_NOMEM;
}

uint64_t lf_film_stream_random(const lf_film_stream *s)
{
    return s->number == 0 ? s->seed : lf_hash64(lf_hash64(s->seed, 0), s->number);
}

uint64_t lf_film_visits_key(uint64_t seed, uint32_t number, const uint32_t visits[2])
{
    return lf_film_visited(visits)
               ? lf_hash64(lf_hash64(seed, number), (uint64_t)visits[0] << 32 | (uint64_t)visits[1])
               : 0;
}

/* The number of streams before this one. */
static int count_before(const lf_film *film, uint64_t seed, uint32_t number)
{
    int from = 0, to = film->n_streams;
    while (from < to) {
        int middle = from + (to - from) / 2;
        const lf_film_stream *s = &film->streams[middle];
        if (s->seed < seed || (s->seed == seed && s->number < number))
            from = middle + 1;
        else
            to = middle;
    }
    return from;
}

const lf_film_stream *lf_film_find_stream(const lf_film *film, uint64_t seed, uint32_t number)
{
    int at = count_before(film, seed, number);
    const lf_film_stream *s = &film->streams[at];
    return at < film->n_streams && s->seed == seed && s->number == number ? s : NULL;
}

lf_status lf_film_stream_at(lf_film *film, uint64_t seed, uint32_t number, int *out_index)
{
    int at = count_before(film, seed, number);
    *out_index = at;
    if (lf_film_find_stream(film, seed, number))
        return LF_OK;
    if (film->n_streams == LF_FILM_MAX_STREAMS)
        return LF_E_STATE;
    if (make_room(film) != LF_OK)
        return LF_E_NOMEM;
    lf_film_stream fresh = {seed, number, film->streams[film->n_streams].rows};
    memset(fresh.rows, 0, (size_t)film->height * sizeof *fresh.rows);
    memmove(film->streams + at + 1, film->streams + at,
            (size_t)(film->n_streams - at) * sizeof fresh);
    film->streams[at] = fresh;
    film->n_streams++;
    return LF_OK;
}

size_t lf_film_packed_from = (size_t)128 << 20;

/* Whether packing saves memory: open rows must be few. */
static bool is_packed(const lf_film *film, int n_threads)
{
    if (n_threads == 0 || film->data_bytes < lf_film_packed_from)
        return false;
    return lf_film_packed_from == 0 || lf_pack_open_rows(n_threads) <= film->height / 4;
}

static bool make_data(lf_film *film, int n_threads)
{
    if (is_packed(film, n_threads)) {
        const lf_pack_planes planes = {pixels_of(&film->layout), half_bytes(&film->layout),
                                       film->layout.has_w2, film->layout.has_features};
        film->packed = lf_film_packed_create(&planes, film->row_bytes, film->height, n_threads);
        return film->packed;
    }
    /* Mapped, so that rows use memory only from the first visit on of the row, or of a row within
     * LF_HUGE_PAGE. */
    film->data = lf_pages(film->data_bytes, 1);
    if (film->data && film->data_bytes >= HUGE_FROM)
        (void)lf_advise_huge(film->data, film->data_bytes);
    return film->data;
}

lf_status lf_film_init_packed(lf_film *film, const lf_film_layout *layout, int n_threads)
{
    *film = (lf_film){.layout = *layout,
                      .n_views = layout->n_views,
                      .width = layout->width,
                      .height = layout->height};
    film->row_bytes = (lf_film_used_bytes(layout) + 63) / 64 * 64;
    film->data_bytes = film->row_bytes * (size_t)film->height;
    film->rows = lf_calloc((size_t)film->height, sizeof *film->rows);
    if (!make_data(film, n_threads) || !film->rows || make_room(film) != LF_OK) {
        lf_film_finish(film);
        return LF_E_NOMEM;
    }
    lf_film_clear(film);
    return LF_OK;
}

lf_status lf_film_init(lf_film *film, const lf_film_layout *layout)
{
    return lf_film_init_packed(film, layout, 0);
}

void lf_film_release(lf_film *film)
{
    lf_pages_free(film->data);
    lf_film_packed_destroy(film->packed);
    film->data = NULL;
    film->packed = NULL;
}

void lf_film_finish(lf_film *film)
{
    lf_film_release(film);
    for (int i = 0; i < film->n_allocated; i++)
        lf_free(film->streams[i].rows);
    lf_free(film->streams);
    lf_free(film->rows);
    memset(film, 0, sizeof *film);
}

bool lf_film_same_layout(const lf_film_layout *a, const lf_film_layout *b)
{
    return a->n_views == b->n_views && a->width == b->width && a->height == b->height &&
           a->has_w2 == b->has_w2 && a->has_native == b->has_native &&
           a->has_known == b->has_known && a->has_delta == b->has_delta &&
           a->has_signed == b->has_signed && a->has_features == b->has_features &&
           a->has_albedo == b->has_albedo;
}

bool lf_film_has_layout(const lf_film *film, const lf_film_layout *layout)
{
    return (film->data || film->packed) && lf_film_same_layout(&film->layout, layout);
}

bool lf_film_alike(const lf_film *film, const lf_film *b)
{
    return lf_film_has_layout(film, &b->layout) && memcmp(film->sky, b->sky, sizeof film->sky) == 0;
}

const char *lf_film_refusal(const lf_film *film, const lf_film *b)
{
    if (memcmp(film->picture, b->picture, sizeof film->picture) != 0 ||
        !lf_film_has_layout(film, &b->layout))
        return "from another scene, camera or settings";
    if (memcmp(film->sky, b->sky, sizeof film->sky) != 0)
        return "from this scene with another sky";
    return NULL;
}

bool lf_film_counts_possible(const lf_film_counts *counts)
{
    for (int h = 0; h < 2; h++)
        if (!(counts->n[h] >= 0.0 && counts->n[h] < 1e12) ||
            counts->visits[h] > LF_FILM_MAX_VISITS ||
            (counts->n[h] > 0.0) != (counts->visits[h] > 0))
            return false;
    return true;
}

bool lf_film_row_possible(const lf_film_row *row)
{
    const lf_film_counts counts = {{row->n[0], row->n[1]}, {row->visits[0], row->visits[1]}};
    for (int h = 0; h < 2; h++)
        if (!(row->coarse[h] >= 0.0 && row->coarse[h] <= row->n[h]))
            return false;
    return lf_film_counts_possible(&counts) && row->passes >= 0.0 && row->passes < 1e15;
}

void lf_film_row_known(const lf_film_row *row, double out[2])
{
    double whole[2] = {row->n[0] - row->coarse[0], row->n[1] - row->coarse[1]};
    bool any = whole[0] + whole[1] > 0.0;
    for (int h = 0; h < 2; h++)
        out[h] = any ? whole[h] : row->n[h];
    if (row->provisional)
        out[0] = 1.0;
}

void lf_film_clear(lf_film *film)
{
    for (int row = 0; row < film->height; row++)
        film->rows[row] = (lf_film_row){.relative_error = -1.0};
    film->n_streams = 0;
    if (film->packed)
        lf_film_packed_clear(film->packed);
}

void lf_film_open(const lf_film *film, int row)
{
    if (film->packed)
        lf_film_packed_open(film->packed, row);
}

void lf_film_close(const lf_film *film, int row, bool changed)
{
    if (film->packed)
        lf_film_packed_close(film->packed, row, changed);
}

unsigned char *lf_film_row_at(const lf_film *film, int row)
{
    return film->packed ? lf_film_packed_row(film->packed, row)
                        : film->data + (size_t)row * film->row_bytes;
}

/* The arrays of a half, consecutive from p on. */
static lf_film_half half_at(const lf_film_layout *layout, unsigned char *p)
{
    size_t pixels = pixels_of(layout);
    lf_film_half half = {.scattered = (lf_film_scattered *)(void *)p};
    p += pixels * sizeof *half.scattered;
    half.w2 = layout->has_w2 ? (float *)(void *)p : NULL;
    p += layout->has_w2 ? pixels * sizeof *half.w2 : 0;
    half.q = (float *)(void *)p;
    p += pixels * sizeof *half.q;
    half.feature = layout->has_features ? (lf_packed_feature *)(void *)p : NULL;
    return half;
}

lf_film_half lf_film_at(const lf_film *film, int row, int half)
{
    return half_at(&film->layout,
                   lf_film_row_at(film, row) + (size_t)half * half_bytes(&film->layout));
}

lf_film_known *lf_film_known_at(const lf_film *film, int row)
{
    unsigned char *p = lf_film_row_at(film, row) + 2 * half_bytes(&film->layout);
    return film->layout.has_known ? (lf_film_known *)(void *)p : NULL;
}

lf_packed_albedo *lf_film_albedo_at(const lf_film *film, int row)
{
    const lf_film_layout *l = &film->layout;
    unsigned char *end = lf_film_row_at(film, row) + lf_film_used_bytes(l);
    return l->has_albedo ? (lf_packed_albedo *)(void *)end - pixels_of(l) : NULL;
}

/* ------------------------------------------------------------------------------------ visits -- */

lf_status lf_film_sums_init(lf_film_sums *sums, const lf_film_layout *layout)
{
    size_t pixels = pixels_of(layout), colours = 3 * pixels * sizeof(float);
    size_t native = layout->has_native ? colours : 0, known = layout->has_known ? colours : 0,
           features = layout->has_features ? pixels * sizeof(lf_feature) : 0,
           albedo = layout->has_albedo ? LF_ALBEDO_NUMBERS * pixels * sizeof(float) : 0;
    lf_film_layout summed = *layout;
    summed.has_features = false; /* a visit's own are not packed */
    size_t half_size = half_bytes(&summed);
    *sums = (lf_film_sums){.data = lf_calloc(1, native + half_size + known + features + albedo)};
    if (!sums->data)
        return LF_E_NOMEM;
    /* Sums come first and q after them, so that one range of memory is zeroed. */
    unsigned char *half = sums->data + native, *behind = half + half_size;
    sums->native = native ? (float(*)[3])(void *)sums->data : NULL;
    sums->half = half_at(&summed, half);
    sums->known = known ? (float(*)[3])(void *)behind : NULL;
    sums->feature = features ? (lf_feature *)(void *)(behind + known) : NULL;
    sums->albedo = albedo ? (float(*)[LF_ALBEDO_NUMBERS])(void *)(behind + known + features) : NULL;
    sums->zeroed_bytes = native + half_size - pixels * sizeof(float);
    return LF_OK;
}

void lf_film_sums_finish(lf_film_sums *sums)
{
    lf_free(sums->data);
    memset(sums, 0, sizeof *sums);
}

void lf_film_sums_begin(lf_film_sums *sums)
{
    memset(sums->data, 0, sums->zeroed_bytes);
}

lf_film_sums lf_film_sums_of(const lf_film *film, int row, int half)
{
    return (lf_film_sums){.half = lf_film_at(film, row, half)};
}

static inline float add(float a, float b, uint32_t random)
{
    return lf_film_round((double)a + (double)b, random);
}

/* A running mean: a constant stays exact, for any number of visits. */
static inline float mean(float a, double share, double x, uint32_t random)
{
    return lf_film_round((double)a + share * (x - (double)a), random);
}

/* Effect of merging a visit on means: the visit's share of its half and of both halves, and the
 * other half's share before it. Coarse visits have no share, unless there are no others. */
typedef struct lf_merge_shares {
    double half, both, other;
    double sign; /* of the half in the difference */
    float inverse_weight;
} lf_merge_shares;

static void merge_known(lf_film_known *known, const lf_film_sums *sums, size_t pixel,
                        const lf_merge_shares *s, uint32_t random)
{
    float difference[3];
    /* most pixels know the same in every visit */
    if (known->difference == 0 && !sums->native &&
        memcmp(known->b, sums->known[pixel], sizeof known->b) == 0)
        return;
    lf_difference_unpack(known->difference, difference);
    for (int c = 0; c < 3; c++) {
        double x = (double)sums->known[pixel][c];
        if (sums->native)
            x += (double)(sums->native[pixel][c] * s->inverse_weight);
        double step = x - (double)known->b[c] - s->sign * s->other * (double)difference[c];
        difference[c] = s->other > 0.0 ? difference[c] + (float)(s->sign * s->half * step) : 0.0f;
        known->b[c] = mean(known->b[c], s->both, x, random);
    }
    known->difference = lf_difference_pack(difference, (float)(random >> 8) * 0x1p-24f);
}

static lf_merge_shares shares_of(const lf_film_row *row, int half, double weight, bool coarse)
{
    double own = row->n[half] - (coarse ? 0.0 : row->coarse[half]),
           others = row->n[1 - half] - (coarse ? 0.0 : row->coarse[1 - half]), n = own + others;
    return (lf_merge_shares){.half = weight / (own + weight),
                             .both = weight / (n + weight),
                             .other = n > 0.0 ? others / n : 0.0,
                             .sign = half == 0 ? 1.0 : -1.0,
                             .inverse_weight = (float)(1.0 / weight)};
}

bool lf_film_meet(lf_film *film, int row, bool any)
{
    film->rows[row].met |= any;
    return film->rows[row].met || film->layout.has_known;
}

/* Before the first visit of a row. */
static void clear_row(lf_film *film, int row)
{
    if (!lf_film_visited(film->rows[row].visits))
        memset(lf_film_row_at(film, row), 0, film->row_bytes);
}

/* n of the visits that were not coarse. */
static double whole_visits(const lf_film_row *row, int half)
{
    return row->n[half] - row->coarse[half];
}

void lf_film_clear_known(const lf_film *film, int row, int half)
{
    size_t pixels = pixels_of(&film->layout);
    lf_film_half of = lf_film_at(film, row, half);
    memset(of.q, 0, pixels * sizeof *of.q);
    if (of.feature)
        memset(of.feature, 0, pixels * sizeof *of.feature);
}

/* Called before the first visit of a half, or of the row, that has its own q, B and features. */
static void drop_coarse(const lf_film *film, int row, int half)
{
    const lf_film_row *state = &film->rows[row];
    lf_film_known *known = lf_film_known_at(film, row);
    lf_packed_albedo *albedo = lf_film_albedo_at(film, row);
    if (!(state->coarse[0] + state->coarse[1] > 0.0))
        return;
    if (!(whole_visits(state, half) > 0.0))
        lf_film_clear_known(film, row, half);
    if (whole_visits(state, 0) + whole_visits(state, 1) > 0.0)
        return;
    if (known)
        memset(known, 0, pixels_of(&film->layout) * sizeof *known);
    if (albedo)
        memset(albedo, 0, pixels_of(&film->layout) * sizeof *albedo);
}

/* A half that has none has the other's for the time being. */
void lf_film_lend_known(const lf_film *film, int row)
{
    const lf_film_row *state = &film->rows[row];
    size_t pixels = pixels_of(&film->layout);
    for (int h = 0; h < 2; h++) {
        if (!(state->coarse[h] > 0.0) || whole_visits(state, h) > 0.0 ||
            !(whole_visits(state, 1 - h) > 0.0))
            continue;
        lf_film_half to = lf_film_at(film, row, h), from = lf_film_at(film, row, 1 - h);
        memcpy(to.q, from.q, pixels * sizeof *to.q);
        if (to.feature)
            memcpy(to.feature, from.feature, pixels * sizeof *to.feature);
    }
}

static void count(lf_film *film, int stream, int row, int half, double passes)
{
    lf_film_row *state = &film->rows[row];
    lf_film_counts *own = &film->streams[stream].rows[row];
    state->provisional = false;
    state->visits[half]++;
    state->n[half] += passes / film->n_views;
    state->passes += passes;
    own->visits[half]++;
    own->n[half] += passes / film->n_views;
}

void lf_film_count(lf_film *film, int stream, int row, int half, double passes)
{
    lf_film_open(film, row);
    clear_row(film, row);
    lf_film_close(film, row, !lf_film_visited(film->rows[row].visits));
    count(film, stream, row, half, passes);
}

/* Columns that are merged together: their random numbers are the same in all views. */
#define SPAN 64

/* before: q of all visits before this one, with its share. Features that no ray has met are
 * unchanged; so are they if correction weights make q negative. */
static void merge_features(lf_packed_feature *restrict to, const float *restrict before,
                           const lf_feature *restrict from, const float *restrict now, float share,
                           const uint32_t *restrict random, size_t n)
{
    const uint32_t to_nearest = UINT32_C(1) << 31;
    for (size_t i = 0; i < n; i++) {
        const lf_feature a = lf_feature_unpack(to[i]), b = from[i];
        const uint32_t any = random[i];
        float earlier = (1.0f - share) * before[i], later = share * now[i],
              weight = later > 0.0f ? later : 0.0f,
              sum = (earlier > 0.0f ? earlier : 0.0f) + weight;
        float t = weight / (sum > 1e-30f ? sum : 1e-30f), s = 1.0f - t, d = b.nearness - a.nearness;
        const lf_feature mixed = {
            a.nearness + t * d,
            sqrtf(s * (a.spread * a.spread) + t * (b.spread * b.spread + s * (d * d))),
            a.surface + t * (b.surface - a.surface), a.light + t * (b.light - a.light)};
        to[i] = lf_feature_pack(&mixed, weight > 0.0f ? any : to_nearest);
    }
}

/* Source and destination of merging a visit. */
typedef struct lf_merge {
    lf_film_half to;
    const lf_film_sums *sums;
    const float *other_q; /* of the other half */
    lf_film_known *known;
    lf_packed_albedo *albedo;
    lf_merge_shares shares;
    bool features, q;
} lf_merge;

/* For pixels [first, first + n), before q is merged: means weighted by q, of both halves. */
static void merge_albedo(const lf_merge *merge, size_t first, size_t n,
                         const uint32_t *restrict random)
{
    const float now = (float)merge->shares.both, other = (1.0f - now) * (float)merge->shares.other,
                own = 1.0f - now - other;
    for (size_t k = 0; k < n; k++) {
        const size_t i = first + k;
        const bool known = merge->albedo[i] != 0;
        float mixed[LF_ALBEDO_NUMBERS],
            later = now * merge->sums->half.q[i],
            earlier = known ? own * merge->to.q[i] + other * merge->other_q[i] : 0.0f;
        if (!(later > 0.0f))
            continue;
        lf_albedo_unpack(merge->albedo[i], mixed);
        for (int c = 0; c < LF_ALBEDO_NUMBERS; c++)
            mixed[c] += later / (later + (earlier > 0.0f ? earlier : 0.0f)) *
                        (merge->sums->albedo[i][c] - mixed[c]);
        merge->albedo[i] = lf_albedo_pack(mixed, random[k]);
    }
}

/* n pixels from the first on. */
static void merge_span(const lf_merge *merge, size_t first, size_t n, const uint32_t random[SPAN])
{
    const lf_film_half *to = &merge->to, *from = &merge->sums->half;
    if (merge->features)
        merge_features(to->feature + first, to->q + first, merge->sums->feature + first,
                       from->q + first, (float)merge->shares.half, random, n);
    if (merge->albedo)
        merge_albedo(merge, first, n, random);
    for (size_t k = 0; k < n; k++) {
        size_t i = first + k;
        lf_film_scattered *a = &to->scattered[i];
        const lf_film_scattered *b = &from->scattered[i];
        for (int c = 0; c < 3; c++)
            a->n[c] = add(a->n[c], b->n[c], random[k]);
        a->w = add(a->w, b->w, random[k]);
        if (to->w2)
            to->w2[i] = add(to->w2[i], from->w2[i], random[k]);
        if (merge->q)
            to->q[i] = mean(to->q[i], merge->shares.half, (double)from->q[i], random[k]);
        if (merge->known)
            merge_known(&merge->known[i], merge->sums, i, &merge->shares, random[k]);
    }
}

static void put_provisional(lf_film *film, int row, const lf_film_sums *sums, double passes)
{
    const uint32_t to_nearest = UINT32_C(1) << 31;
    const float inverse_weight = (float)(film->n_views / passes);
    const lf_film_half to = lf_film_at(film, row, 0);
    lf_film_known *known = lf_film_known_at(film, row);
    lf_packed_albedo *albedo = lf_film_albedo_at(film, row);
    const size_t n = pixels_of(&film->layout);
    film->rows[row].provisional = true;
    if (!sums) {
        lf_film_clear_known(film, row, 0);
        return;
    }
    memcpy(to.q, sums->half.q, n * sizeof *to.q);
    for (size_t i = 0; i < n; i++) {
        if (to.q[i] < 0.0f)
            continue;
        if (to.feature)
            to.feature[i] = lf_feature_pack(&sums->feature[i], to_nearest);
        if (albedo)
            albedo[i] = lf_albedo_pack(sums->albedo[i], to_nearest);
        for (int c = 0; c < 3 && known; c++)
            known[i].b[c] =
                sums->known[i][c] + (sums->native ? sums->native[i][c] * inverse_weight : 0.0f);
    }
}

void lf_film_put_provisional(lf_film *film, int row, const lf_film_sums *sums, double passes)
{
    lf_film_open(film, row);
    if (film->packed) /* what an earlier film left in its memory would be packed too */
        clear_row(film, row);
    put_provisional(film, row, sums, passes);
    lf_film_close(film, row, true);
}

static void merge(lf_film *film, int stream, int row, int half, const lf_film_sums *sums,
                  double passes, uint64_t key)
{
    const double weight = passes / film->n_views;
    lf_film_row *state = &film->rows[row];
    clear_row(film, row);
    if (!sums->coarse)
        drop_coarse(film, row, half);
    const bool known = !sums->coarse || !(whole_visits(state, 0) + whole_visits(state, 1) > 0.0);
    const lf_merge all = {
        lf_film_at(film, row, half),
        sums,
        lf_film_at(film, row, 1 - half).q,
        known ? lf_film_known_at(film, row) : NULL,
        known && lf_film_wants_albedo(film, row) ? lf_film_albedo_at(film, row) : NULL,
        shares_of(state, half, weight, sums->coarse),
        known && film->layout.has_features && state->visits[half] < LF_FEATURE_VISITS,
        known};
    size_t width = (size_t)film->width, views = weight > 0.0 ? (size_t)film->n_views : 0;
    for (size_t column = 0; column < width; column += SPAN) {
        size_t n = width - column < SPAN ? width - column : SPAN;
        uint32_t random[SPAN];
        /* One random number per column: equal numbers, in N and W or in two views, stay equal. */
        for (size_t k = 0; k < n; k++)
            random[k] = (uint32_t)(lf_hash64(key, column + k) >> 32);
        for (size_t view = 0; view < views; view++)
            merge_span(&all, view * width + column, n, random);
    }
    count(film, stream, row, half, passes);
    state->coarse[half] += sums->coarse ? weight : 0.0;
    lf_film_lend_known(film, row);
}

void lf_film_merge(lf_film *film, int stream, int row, int half, const lf_film_sums *sums,
                   double passes, uint64_t key)
{
    lf_film_open(film, row);
    merge(film, stream, row, half, sums, passes, key);
    lf_film_close(film, row, true);
}
