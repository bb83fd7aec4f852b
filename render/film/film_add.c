/* Merges two films of one image. */
#include <math.h>
#include <string.h>

#include "render/film/film.h"
#include "render/film/film_difference.h"
#include "render/film/film_round.h"
#include "render/transport/sampler.h"

/* The mean over both; a constant stays exact. */
static double pooled(double a, double n_a, double b, double n_b)
{
    if (n_a == 0.0 || a == b)
        return b;
    return n_b == 0.0 ? a : (n_a * a + n_b * b) / (n_a + n_b);
}

static void add_feature(lf_packed_feature *to, double weight_to, lf_packed_feature from,
                        double weight_from, uint32_t random)
{
    weight_to = weight_to > 0.0 ? weight_to : 0.0;
    weight_from = weight_from > 0.0 ? weight_from : 0.0;
    if (!(weight_to + weight_from > 0.0))
        return;
    const lf_feature a = lf_feature_unpack(*to), b = lf_feature_unpack(from),
                     mixed = lf_feature_mix(&a, weight_to, &b, weight_from);
    *to = lf_feature_pack(&mixed, random);
}

/* n q of both halves, clamped to 0. */
static double pivots_of(const lf_film_half half[2], const double n[2], size_t i)
{
    return fmax(n[0] * (double)half[0].q[i] + n[1] * (double)half[1].q[i], 0.0);
}

static void add_albedo(lf_packed_albedo *to, double weight_to, lf_packed_albedo from,
                       double weight_from, uint32_t random)
{
    float a[LF_ALBEDO_NUMBERS], b[LF_ALBEDO_NUMBERS];
    weight_to = *to != 0 ? weight_to : 0.0;
    weight_from = from != 0 ? weight_from : 0.0;
    if (!(weight_to + weight_from > 0.0))
        return;
    lf_albedo_unpack(*to, a);
    lf_albedo_unpack(from, b);
    for (int c = 0; c < LF_ALBEDO_NUMBERS; c++)
        a[c] = (float)((weight_to * (double)a[c] + weight_from * (double)b[c]) /
                       (weight_to + weight_from));
    *to = lf_albedo_pack(a, random);
}

/* n is the known visits' (lf_film_row_known). */
static void add_half(lf_film_half *to, double n_to, const lf_film_half *from, double n_from,
                     size_t i, uint32_t random)
{
    lf_film_scattered *a = &to->scattered[i];
    const lf_film_scattered *b = &from->scattered[i];
    for (int c = 0; c < 3; c++)
        a->n[c] = lf_film_round((double)a->n[c] + (double)b->n[c], random);
    a->w = lf_film_round((double)a->w + (double)b->w, random);
    if (to->w2)
        to->w2[i] = lf_film_round((double)to->w2[i] + (double)from->w2[i], random);
    if (to->feature)
        add_feature(&to->feature[i], n_to * (double)to->q[i], from->feature[i],
                    n_from * (double)from->q[i], random);
    to->q[i] = lf_film_round(pooled((double)to->q[i], n_to, (double)from->q[i], n_from), random);
}

/* The mean of one half, from the mean of both and their difference. */
static double of_half(const double n[2], int half, double both, double difference)
{
    return both + (half == 0 ? n[1] : -n[0]) / (n[0] + n[1]) * difference;
}

/* a and b: n of the known visits; one film may have none. */
static void add_known(lf_film_known *to, const double a[2], const lf_film_known *from,
                      const double b[2], uint32_t random)
{
    float d_to[3], d_from[3], difference[3] = {0};
    double n_a = a[0] + a[1], n_b = b[0] + b[1];
    if (!(n_b > 0.0))
        return;
    if (!(n_a > 0.0)) {
        *to = *from;
        return;
    }
    lf_difference_unpack(to->difference, d_to);
    lf_difference_unpack(from->difference, d_from);
    for (int c = 0; c < 3; c++) {
        double x = (double)to->b[c], y = (double)from->b[c], half[2];
        for (int h = 0; h < 2; h++)
            half[h] = pooled(of_half(a, h, x, (double)d_to[c]), a[h],
                             of_half(b, h, y, (double)d_from[c]), b[h]);
        if (a[0] + b[0] > 0.0 && a[1] + b[1] > 0.0)
            difference[c] = (float)(half[0] - half[1]);
        to->b[c] = lf_film_round(pooled(x, n_a, y, n_b), random);
    }
    to->difference = lf_difference_pack(difference, (float)(random >> 8) * 0x1p-24f);
}

/* Random bits of what a row's visits were: the same for both films' in either order. */
static uint64_t key_of(const lf_film *film, int row)
{
    uint64_t key = 0;
    for (int i = 0; i < film->n_streams; i++) {
        const lf_film_stream *s = &film->streams[i];
        key += lf_film_visits_key(s->seed, s->number, s->rows[row].visits);
    }
    return key;
}

/* n of both films' visits that are means of q, B and features in the sum: as lf_film_row_known. */
static void known_of(const lf_film_row *a, const lf_film_row *b, double of_a[2], double of_b[2])
{
    double whole = 0.0;
    for (int h = 0; h < 2; h++)
        whole += a->n[h] - a->coarse[h] + b->n[h] - b->coarse[h];
    for (int h = 0; h < 2; h++) {
        of_a[h] = a->n[h] - (whole > 0.0 ? a->coarse[h] : 0.0);
        of_b[h] = b->n[h] - (whole > 0.0 ? b->coarse[h] : 0.0);
    }
}

static void add_row(lf_film *film, const lf_film *from, int row)
{
    double a[2], b[2];
    known_of(&film->rows[row], &from->rows[row], a, b);
    uint64_t key = lf_hash64(key_of(film, row) + key_of(from, row), (uint64_t)row);
    size_t width = (size_t)film->width, pixels = (size_t)film->n_views * width;
    lf_film_half to[2] = {lf_film_at(film, row, 0), lf_film_at(film, row, 1)};
    const lf_film_half other[2] = {lf_film_at(from, row, 0), lf_film_at(from, row, 1)};
    lf_film_known *known = lf_film_known_at(film, row);
    for (int h = 0; h < 2; h++)
        if (film->rows[row].coarse[h] > 0.0 && a[h] == 0.0)
            lf_film_clear_known(film, row, h);
    const lf_film_known *more = lf_film_known_at(from, row);
    lf_packed_albedo *albedo = lf_film_albedo_at(film, row);
    const lf_packed_albedo *more_albedo = lf_film_albedo_at(from, row);
    /* As in a visit: equal numbers, in N and W or in two views, stay equal. */
    for (size_t i = 0; i < pixels; i++) {
        uint32_t random = (uint32_t)(lf_hash64(key, i % width) >> 32);
        if (albedo) /* before q is added up */
            add_albedo(&albedo[i], pivots_of(to, a, i), more_albedo[i], pivots_of(other, b, i),
                       random);
        for (int h = 0; h < 2; h++)
            add_half(&to[h], a[h], &other[h], b[h], i, random);
        if (known)
            add_known(&known[i], a, &more[i], b, random);
    }
}

static void add_counts(lf_film_row *to, const lf_film_row *from)
{
    for (int h = 0; h < 2; h++) {
        to->n[h] += from->n[h];
        to->coarse[h] += from->coarse[h];
        to->visits[h] += from->visits[h];
    }
    to->passes += from->passes;
    to->provisional = false;
    to->met |= from->met;
    to->relative_error = -1.0;
    to->holes = 0;
}

/* The first row of which a half has visits of a stream in both films; height = none. */
static int overlap(const lf_film_stream *a, const lf_film_stream *b, int height)
{
    int row = 0;
    while (row < height && !(a->rows[row].visits[0] && b->rows[row].visits[0]) &&
           !(a->rows[row].visits[1] && b->rows[row].visits[1]))
        row++;
    return row;
}

static lf_status check_streams(const lf_film *film, const lf_film *from, lf_error *err)
{
    int n = film->n_streams;
    for (int i = 0; i < from->n_streams; i++) {
        const lf_film_stream *b = &from->streams[i],
                             *a = lf_film_find_stream(film, b->seed, b->number);
        int row = a ? overlap(a, b, film->height) : film->height;
        if (row < film->height)
            return lf_error_set(err, LF_E_STATE, "film",
                                "both films have samples of seed %llu, stream %u in row %d",
                                (unsigned long long)b->seed, b->number, row);
        n += !a;
    }
    return n <= LF_FILM_MAX_STREAMS
               ? LF_OK
               : lf_error_set(err, LF_E_STATE, "film", "the sum has more than %d random streams",
                              LF_FILM_MAX_STREAMS);
}

/* The first row whose counts cannot be added; height = none. */
static int overflow(const lf_film *film, const lf_film *from)
{
    int row = 0;
    for (; row < film->height; row++) {
        lf_film_row sum = film->rows[row];
        add_counts(&sum, &from->rows[row]);
        if (!lf_film_row_possible(&sum))
            break;
    }
    return row;
}

static lf_status check(const lf_film *film, const lf_film *from, lf_error *err)
{
    int full = overflow(film, from);
    if (full < film->height)
        return lf_error_set(err, LF_E_STATE, "film", "row %d of the sum has too many samples",
                            full);
    return check_streams(film, from, err);
}

static void add_stream(lf_film_stream *to, const lf_film_stream *from, int height)
{
    for (int row = 0; row < height; row++) {
        for (int h = 0; h < 2; h++) {
            to->rows[row].n[h] += from->rows[row].n[h];
            to->rows[row].visits[h] += from->rows[row].visits[h];
        }
    }
}

lf_status lf_film_mix(lf_film *film, const lf_film *from, lf_error *err)
{
    int index;
    if (!lf_film_alike(film, from))
        return lf_error_set(err, LF_E_STATE, "film",
                            "films with other views or another layout cannot be mixed");
    lf_status status = check(film, from, err);
    for (int i = 0; i < from->n_streams && status == LF_OK; i++)
        if (lf_film_stream_at(film, from->streams[i].seed, from->streams[i].number, &index) !=
            LF_OK)
            status = lf_error_set(err, LF_E_NOMEM, "film", "out of memory");
    if (status != LF_OK)
        return status;
    for (int row = 0; row < film->height; row++) {
        lf_film_row *state = &film->rows[row];
        if (!lf_film_visited(from->rows[row].visits))
            continue;
        if (lf_film_visited(state->visits))
            add_row(film, from, row);
        else
            memcpy(film->data + (size_t)row * film->row_bytes,
                   from->data + (size_t)row * from->row_bytes, film->row_bytes);
        add_counts(state, &from->rows[row]);
        lf_film_lend_known(film, row);
    }
    for (int i = 0; i < from->n_streams; i++)
        if (lf_film_stream_at(film, from->streams[i].seed, from->streams[i].number, &index) ==
            LF_OK)
            add_stream(&film->streams[index], &from->streams[i], film->height);
    return LF_OK;
}

lf_status lf_film_add(lf_film *film, const lf_film *from, lf_error *err)
{
    const char *refusal = lf_film_refusal(film, from);
    return refusal ? lf_error_set(err, LF_E_STATE, "film", "cannot add a film %s", refusal)
                   : lf_film_mix(film, from, err);
}
