/* Between the passes: the order of the files, copies among them, and which rows they have. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "render/film/film_merge_internal.h"

/* ------------------------------------------------------------------------------------- order -- */

static int compare(uint64_t a, uint64_t b)
{
    return (a > b) - (a < b);
}

static int compare_streams(const lf_merging_stream *a, const lf_merging_stream *b)
{
    return a->seed != b->seed ? compare(a->seed, b->seed) : compare(a->number, b->number);
}

/* By seeds and numbers of streams, then by rows; copies by their tie. */
static int compare_sources(const lf_merging *m, const lf_merging_source *a,
                           const lf_merging_source *b)
{
    int order = 0;
    for (int i = 0; order == 0 && i < a->n_streams && i < b->n_streams; i++)
        order = compare_streams(lf_merging_stream_at(m, a->first_stream + i),
                                lf_merging_stream_at(m, b->first_stream + i));
    if (order == 0)
        order = compare((uint64_t)a->n_streams, (uint64_t)b->n_streams);
    if (order == 0 && a->n_ranges > 0 && b->n_ranges > 0)
        order = compare((uint64_t)lf_merging_range_at(m, a->first_range)->first,
                        (uint64_t)lf_merging_range_at(m, b->first_range)->first);
    if (order == 0)
        order = compare(a->first.rows, b->first.rows);
    if (order == 0)
        order = compare(a->first.streams, b->first.streams);
    return order == 0 ? compare(a->tie, b->tie) : order;
}

static int by_content(const void *a, const void *b, void *merging)
{
    const int i = *(const int *)a, k = *(const int *)b;
    const int order = compare_sources(merging, lf_merging_source_at(merging, i),
                                      lf_merging_source_at(merging, k));
    return order == 0 ? compare((uint64_t)i, (uint64_t)k) : order;
}

/* The places of files in the order are in their `tie` by now. */
static int by_stream(const void *a, const void *b, void *merging)
{
    const lf_merging *m = merging;
    const lf_merging_stream *s = lf_merging_stream_at(m, *(const int *)a),
                            *t = lf_merging_stream_at(m, *(const int *)b);
    const int order = compare_streams(s, t);
    return order == 0 ? compare(lf_merging_source_at(m, s->file)->tie,
                                lf_merging_source_at(m, t->file)->tie)
                      : order;
}

/* ------------------------------------------------------------------------------------ copies -- */

/* Whether the films of both files have the same bytes from their first streams on; the images are
 * the same. */
static lf_status compare_bytes(lf_merging *m, int a, int b, bool *out_same, lf_error *err)
{
    enum { CHUNK = 1 << 16 };
    const lf_merging_source *of_a = lf_merging_source_at(m, a), *of_b = lf_merging_source_at(m, b);
    unsigned char *bytes = lf_calloc(2, CHUNK);
    int fd = -1;
    off_t done = 0;
    lf_status status = bytes ? lf_merging_seek(m, a, of_a->at, err)
                             : lf_error_set(err, LF_E_NOMEM, "merge", "out of memory");
    if (status == LF_OK)
        status = lf_file_open(of_b->path, NULL, UINT64_MAX, &fd, NULL, err);
    for (*out_same = true; status == LF_OK && *out_same;) {
        const ssize_t n = pread(m->fd, bytes, CHUNK, of_a->at + done),
                      k = pread(fd, bytes + CHUNK, CHUNK, of_b->at + done);
        if (n < 0 || k < 0)
            status = lf_error_set(err, LF_E_IO, n < 0 ? of_a->path : of_b->path, "cannot be read");
        else if (n == 0 && k == 0)
            break;
        *out_same = n == k && memcmp(bytes, bytes + CHUNK, (size_t)n) == 0;
        done += n;
    }
    if (fd >= 0)
        close(fd);
    lf_free(bytes);
    return status;
}

static bool could_be_copies(const lf_merging_source *a, const lf_merging_source *b)
{
    return a->n_streams == b->n_streams && a->first.rows == b->first.rows &&
           a->first.streams == b->first.streams;
}

/* Copies follow each other in the order. */
static lf_status find_copies(lf_merging *m, lf_error *err)
{
    int kept = -1;
    for (int k = 0; k < m->files.n; k++) {
        lf_merging_source *source = lf_merging_source_at(m, m->order[k]);
        bool same = false;
        lf_status status = LF_OK;
        if (kept >= 0 && could_be_copies(lf_merging_source_at(m, kept), source))
            status = compare_bytes(m, kept, m->order[k], &same, err);
        if (status != LF_OK)
            return status;
        if (same)
            source->copy_of = kept;
        else
            kept = m->order[k];
    }
    return LF_OK;
}

/* -------------------------------------------------------------------------------------- rows -- */

static lf_status refuse_twice(const lf_merging *m, const lf_merging_stream *s, int row,
                              lf_error *err)
{
    const int owner = m->owner[row];
    int last = row;
    while (last + 1 < m->like.layout.height && m->owner[last + 1] == owner &&
           lf_film_visited(m->counts[last + 1].visits))
        last++;
    char rows[32];
    return lf_error_set(err, LF_E_STATE, lf_merging_source_at(m, s->file)->path,
                        "has %s of seed %llu, stream %u, and so has %s; leave one out",
                        lf_merging_rows_text(row, last, rows, sizeof rows),
                        (unsigned long long)s->seed, s->number,
                        lf_merging_source_at(m, owner)->path);
}

/* Whether two rows have the same passes of a stream, but in other visits. */
static bool are_divided_otherwise(const lf_merging *m, int a, int b)
{
    const lf_film_counts *x = &m->sum[a], *y = &m->sum[b];
    bool same_passes = true, same_visits = true;
    for (int h = 0; h < 2; h++) {
        same_passes &= fabs(x->n[h] - y->n[h]) * m->like.layout.n_views < 0.25;
        same_visits &= x->visits[h] == y->visits[h];
    }
    return same_passes && !same_visits;
}

/* A job gives all rows their passes in the same visits. Compares each row of a stream with the
 * first, and with the one before it, of other files. */
static lf_status check_visits(const lf_merging *m, lf_error *err)
{
    int first = -1, before = -1;
    for (int row = 0; row < m->like.layout.height; row++) {
        const int others[2] = {first, before}, owner = m->owner[row];
        for (int i = 0; i < 2 && owner >= 0; i++) {
            const int other = others[i];
            if (other < 0 || m->owner[other] == owner || !are_divided_otherwise(m, other, row))
                continue;
            const uint32_t *has = m->sum[row].visits, *had = m->sum[other].visits;
            return lf_error_set(err, LF_E_STATE, lf_merging_source_at(m, owner)->path,
                                "has row %d in %u visits, but %s has row %d in %u: one is of "
                                "another job; make both again",
                                row, has[0] + has[1],
                                lf_merging_source_at(m, m->owner[other])->path, other,
                                had[0] + had[1]);
        }
        if (owner >= 0) {
            first = first < 0 ? row : first;
            before = row;
        }
    }
    return LF_OK;
}

/* The same stream of several files, which must have different rows: entries [from, to) of sorted.
 */
static lf_status check_group(lf_merging *m, int from, int to, lf_error *err)
{
    const int height = m->like.layout.height;
    for (int row = 0; row < height; row++)
        m->owner[row] = -1;
    for (int i = from; i < to; i++) {
        const lf_merging_stream *s = lf_merging_stream_at(m, m->sorted[i]);
        uint64_t ignored = 0;
        lf_status status = lf_merging_read_stream(m, s, &ignored, err);
        if (status != LF_OK)
            return status;
        for (int row = 0; row < height; row++) {
            if (!lf_film_visited(m->counts[row].visits))
                continue;
            if (m->owner[row] >= 0)
                return refuse_twice(m, s, row, err);
            m->owner[row] = s->file;
            m->sum[row] = m->counts[row];
            m->key[row] += lf_film_visits_key(s->seed, s->number, m->counts[row].visits);
        }
    }
    return check_visits(m, err);
}

int lf_merging_group_end(const lf_merging *m, int from)
{
    int to = from + 1;
    while (to < m->n_sorted && compare_streams(lf_merging_stream_at(m, m->sorted[from]),
                                               lf_merging_stream_at(m, m->sorted[to])) == 0)
        to++;
    return to;
}

static lf_status check_streams(lf_merging *m, int *out_n, lf_error *err)
{
    int n = 0;
    for (int from = 0, to; from < m->n_sorted; from = to, n++) {
        to = lf_merging_group_end(m, from);
        if (n == LF_FILM_MAX_STREAMS)
            return lf_error_set(err, LF_E_STATE, "merge",
                                "the parts have more than %d random streams", n);
        lf_status status = check_group(m, from, to, err);
        if (status != LF_OK)
            return status;
    }
    *out_n = n;
    return LF_OK;
}

static void count_rows(lf_merging *m, const lf_merging_source *source)
{
    for (int i = 0; i < source->n_ranges; i++) {
        const lf_merging_range *range = lf_merging_range_at(m, source->first_range + i);
        for (int row = range->first; row < range->first + range->n; row++) {
            m->n_holders[row]++;
            m->passes[row] += range->passes;
        }
    }
}

static void sum_up(const lf_merging *m, lf_merging_total *out)
{
    for (int row = 0; row < m->like.layout.height; row++) {
        if (m->n_holders[row] == 0)
            continue;
        if (out->n_rows++ == 0) {
            out->first_row = out->least_row = out->most_row = row;
            out->least_passes = out->most_passes = m->passes[row];
        }
        out->last_row = row;
        out->passes += m->passes[row];
        if (m->passes[row] < out->least_passes) {
            out->least_row = row;
            out->least_passes = m->passes[row];
        }
        if (m->passes[row] > out->most_passes) {
            out->most_row = row;
            out->most_passes = m->passes[row];
        }
    }
}

/* Sorts the files and, when copies are known, the streams of the others. */
static lf_status sort_all(lf_merging *m, lf_error *err)
{
    m->order = lf_calloc((size_t)m->files.n, sizeof *m->order);
    m->sorted = lf_calloc((size_t)m->streams.n, sizeof *m->sorted);
    if (!m->order || !m->sorted)
        return lf_error_set(err, LF_E_NOMEM, "merge", "out of memory");
    for (int i = 0; i < m->files.n; i++)
        m->order[i] = i;
    qsort_r(m->order, (size_t)m->files.n, sizeof *m->order, by_content, m);
    lf_status status = find_copies(m, err);
    if (status != LF_OK)
        return status;
    for (int k = 0; k < m->files.n; k++)
        lf_merging_source_at(m, m->order[k])->tie = (uint32_t)k;
    for (int i = 0; i < m->streams.n; i++)
        if (lf_merging_copy_of(m, lf_merging_stream_at(m, i)->file) < 0)
            m->sorted[m->n_sorted++] = i;
    qsort_r(m->sorted, (size_t)m->n_sorted, sizeof *m->sorted, by_stream, m);
    return LF_OK;
}

lf_status lf_merging_arrange(lf_merging *m, lf_merging_total *out, lf_error *err)
{
    lf_merging_total total = {0};
    lf_status status = sort_all(m, err);
    if (status == LF_OK)
        status = check_streams(m, &total.n_streams, err);
    if (status != LF_OK)
        return status;
    for (int i = 0; i < m->files.n; i++) {
        if (lf_merging_copy_of(m, i) >= 0)
            continue;
        total.n_files++;
        count_rows(m, lf_merging_source_at(m, i));
    }
    sum_up(m, &total);
    if (total.n_rows == 0)
        return lf_error_set(err, LF_E_STATE, lf_merging_source_at(m, 0)->path,
                            "has no samples yet, nor has any other part");
    *out = total;
    return LF_OK;
}

int lf_merging_at(const lf_merging *m, int k)
{
    return m->order[k];
}

int lf_merging_copy_of(const lf_merging *m, int file)
{
    return lf_merging_source_at(m, file)->copy_of;
}

int lf_merging_holder(const lf_merging *m, int row)
{
    for (int k = 0; k < m->files.n; k++) {
        const lf_merging_source *source = lf_merging_source_at(m, m->order[k]);
        for (int i = 0; i < source->n_ranges; i++) {
            const lf_merging_range *range = lf_merging_range_at(m, source->first_range + i);
            if (row >= range->first && row < range->first + range->n)
                return m->order[k];
        }
    }
    return -1;
}

const char *lf_merging_rows_text(int first, int last, char *buf, size_t size)
{
    if (first == last)
        snprintf(buf, size, "row %d", first);
    else
        snprintf(buf, size, "rows %d to %d", first, last);
    return buf;
}

bool lf_merging_gap(const lf_merging *m, int from, int *out_first, int *out_last)
{
    const int height = m->like.layout.height;
    while (from < height && m->n_holders[from] > 0)
        from++;
    *out_first = from;
    while (from < height && m->n_holders[from] == 0)
        from++;
    *out_last = from - 1;
    return *out_first < height;
}
