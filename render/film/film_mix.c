/* Adds a film to another of the same views. */
#include <string.h>

#include "render/film/film_sum.h"
#include "render/transport/sampler.h"

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

static bool has_whole_visits(const lf_film_row *row)
{
    return row->n[0] + row->n[1] > row->coarse[0] + row->coarse[1];
}

/* check has seen that there is a sum. */
static void add_row(lf_film *film, const lf_film *from, lf_film_sum *sum, int row)
{
    const uint64_t key = lf_hash64(key_of(film, row) + key_of(from, row), (uint64_t)row);
    lf_film_sum_begin(sum,
                      has_whole_visits(&film->rows[row]) || has_whole_visits(&from->rows[row]));
    lf_film_sum_add(sum, film, row);
    lf_film_sum_add(sum, from, row);
    (void)lf_film_sum_put(sum, key, film, row);
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

static void copy_row(const lf_film *film, const lf_film *from, int row)
{
    lf_film_open(film, row);
    lf_film_open(from, row);
    memcpy(lf_film_row_at(film, row), lf_film_row_at(from, row), film->row_bytes);
    lf_film_close(from, row, false);
    lf_film_close(film, row, true);
}

/* Makes room for all that can fail. */
static lf_status prepare(lf_film *film, const lf_film *from, lf_film_sum *out, lf_error *err)
{
    int index;
    lf_status status = lf_film_sum_init(out, &film->layout);
    for (int i = 0; i < from->n_streams && status == LF_OK; i++)
        status = lf_film_stream_at(film, from->streams[i].seed, from->streams[i].number, &index);
    if (status == LF_OK)
        return LF_OK;
    lf_film_sum_finish(out);
    return lf_error_set(err, LF_E_NOMEM, "film", "out of memory");
}

lf_status lf_film_mix(lf_film *film, const lf_film *from, lf_error *err)
{
    lf_film_sum sum;
    int index;
    if (!lf_film_alike(film, from))
        return lf_error_set(err, LF_E_STATE, "film",
                            "films with other views or another layout cannot be mixed");
    lf_status status = check(film, from, err);
    if (status == LF_OK)
        status = prepare(film, from, &sum, err);
    if (status != LF_OK)
        return status;
    for (int row = 0; row < film->height; row++) {
        lf_film_row *state = &film->rows[row];
        if (!lf_film_visited(from->rows[row].visits))
            continue;
        if (lf_film_visited(state->visits)) {
            add_row(film, from, &sum, row);
            continue;
        }
        copy_row(film, from, row);
        add_counts(state, &from->rows[row]);
    }
    lf_film_sum_finish(&sum);
    for (int i = 0; i < from->n_streams; i++)
        if (lf_film_stream_at(film, from->streams[i].seed, from->streams[i].number, &index) ==
            LF_OK)
            add_stream(&film->streams[index], &from->streams[i], film->height);
    return LF_OK;
}
