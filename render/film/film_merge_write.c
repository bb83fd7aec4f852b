/* The second pass: writes the merged film, a block of rows at a time. */
#include <string.h>

#include "base/alloc.h"
#include "render/film/film_merge_internal.h"
#include "render/film/film_sum.h"
#include "render/transport/sampler.h"

/* Memory for a block, in bytes; one row may need more. A file is opened once per block that it has
 * rows of, so sums over many files need large blocks; copies stay in the cache. */
#define BLOCK_BYTES ((size_t)8 << 20)
#define SUMMED_BYTES ((size_t)128 << 20)

/* Consecutive rows. A row of one file is copied; others are summed up. */
typedef struct lf_merging_block {
    lf_film film, one; /* height: rows of a block; 1 */
    lf_film_sum *sums; /* [film.height]; NULL: no row needs one */
    unsigned char (*heads)[LF_FILM_HEAD_BYTES + LF_FILM_ROW_BYTES]; /* of copied rows */
    int first, n;
} lf_merging_block;

static lf_status no_memory(lf_error *err)
{
    return lf_error_set(err, LF_E_NOMEM, "merge", "not enough memory for one row");
}

static bool is_summed(const lf_merging *m)
{
    for (int row = 0; row < m->like.layout.height; row++)
        if (m->n_holders[row] > 1)
            return true;
    return false;
}

static void finish_block(lf_merging_block *block)
{
    for (int i = 0; block->sums && i < block->film.height; i++)
        lf_film_sum_finish(&block->sums[i]);
    lf_free(block->sums);
    lf_free(block->heads);
    lf_film_finish(&block->film);
    lf_film_finish(&block->one);
}

static lf_status init_block(const lf_merging *m, lf_merging_block *block, lf_error *err)
{
    lf_film_layout layout = m->like.layout;
    const bool summed = is_summed(m);
    const size_t bytes = lf_merging_row_bytes(&layout) + (summed ? lf_film_sum_bytes(&layout) : 0);
    const size_t most = (summed ? SUMMED_BYTES : BLOCK_BYTES) / bytes, rows = most > 0 ? most : 1;
    *block = (lf_merging_block){0};
    if (rows < (size_t)layout.height)
        layout.height = (int)rows;
    lf_status status = lf_film_init(&block->film, &layout);
    block->heads = lf_calloc((size_t)layout.height, sizeof *block->heads);
    if (summed)
        block->sums = lf_calloc((size_t)layout.height, sizeof *block->sums);
    if (!block->heads || (summed && !block->sums))
        status = LF_E_NOMEM;
    for (int i = 0; block->sums && i < layout.height && status == LF_OK; i++)
        status = lf_film_sum_init(&block->sums[i], &layout);
    layout.height = 1;
    if (status == LF_OK && summed)
        status = lf_film_init(&block->one, &layout);
    if (status == LF_OK)
        return LF_OK;
    finish_block(block);
    return no_memory(err);
}

/* -------------------------------------------------------------------------------------- read -- */

/* Reads a row, which was looked at before, at the position of the file. */
static lf_status read_row(lf_merging *m, lf_merging_source *source, int row,
                          lf_merging_block *block, lf_error *err)
{
    const int at = row - block->first;
    const bool copied = m->n_holders[row] == 1;
    lf_film *film = copied ? &block->film : &block->one;
    unsigned char *head = block->heads[at], *made = head + LF_FILM_HEAD_BYTES;
    const lf_film_part part = {"ROW ", made, LF_FILM_ROW_BYTES,
                               film->data + (copied ? (size_t)at * film->row_bytes : 0),
                               lf_film_used_bytes(&film->layout)};
    lf_error why = {0};
    uint32_t number;
    lf_status status = lf_film_part_next(m->fd, head, &why);
    if (status == LF_OK)
        status = lf_film_part_read(m->fd, head, &part, &why);
    if (status != LF_OK)
        return lf_merging_blame(source->path, &why, err);
    const lf_film_row counts = lf_film_row_get(made, &number);
    source->second.rows = lf_merging_digest_add(source->second.rows, head, LF_FILM_HEAD_BYTES);
    source->second.rows = lf_merging_digest_add(source->second.rows, made, LF_FILM_ROW_BYTES);
    if (number != (uint32_t)row || !lf_film_row_possible(&counts))
        return lf_merging_changed(source->path, err);
    if (!copied) {
        film->rows[0] = counts;
        lf_film_sum_add(&block->sums[at], film, 0);
    }
    return LF_OK;
}

/* Reads the rows of a file that are in the block. */
static lf_status read_file(lf_merging *m, int file, lf_merging_block *block, lf_error *err)
{
    lf_merging_source *source = lf_merging_source_at(m, file);
    off_t at = source->rows_at;
    const off_t row_bytes = (off_t)lf_merging_row_bytes(&m->like.layout);
    for (int i = 0; i < source->n_ranges; i++) {
        const lf_merging_range *range = lf_merging_range_at(m, source->first_range + i);
        const int end = range->first + range->n, last = block->first + block->n,
                  from = range->first > block->first ? range->first : block->first,
                  to = end < last ? end : last;
        lf_status status = LF_OK;
        if (from < to)
            status = lf_merging_seek(m, file, at + (from - range->first) * row_bytes, err);
        for (int row = from; row < to && status == LF_OK; row++)
            status = read_row(m, source, row, block, err);
        if (status != LF_OK)
            return status;
        at += range->n * row_bytes;
    }
    return LF_OK;
}

/* ------------------------------------------------------------------------------------- write -- */

static lf_status write_row(lf_merging *m, const lf_merging_block *block, int row, lf_outfile *file,
                           lf_error *err)
{
    const int at = row - block->first;
    unsigned char *head = block->heads[at], *made = head + LF_FILM_HEAD_BYTES,
                  *bulk = block->film.data + (size_t)at * block->film.row_bytes;
    const size_t n = lf_film_used_bytes(&block->film.layout);
    if (m->n_holders[row] == 1) {
        lf_film_heads_add(&m->heads, head);
        lf_status status = lf_outfile_write(file, head, sizeof *block->heads, err);
        return status == LF_OK ? lf_outfile_write(file, bulk, n, err) : status;
    }
    /* as in lf_film_mix */
    const uint64_t key = lf_hash64(m->key[row], (uint64_t)row);
    if (!lf_film_sum_put(&block->sums[at], key, &block->film, at))
        return lf_error_set(err, LF_E_STATE, "merge", "row %d of the sum has too many samples",
                            row);
    lf_film_row_put((uint32_t)row, &block->film.rows[at], made);
    const lf_film_part part = {"ROW ", made, LF_FILM_ROW_BYTES, bulk, n};
    return lf_film_part_write(file, &part, &m->heads, err);
}

static lf_status do_block(lf_merging *m, lf_merging_block *block, lf_outfile *file, lf_error *err)
{
    lf_status status = LF_OK;
    for (int i = 0; block->sums && i < block->n; i++)
        if (m->n_holders[block->first + i] > 1)
            lf_film_sum_begin(&block->sums[i], m->whole[block->first + i]);
    for (int k = 0; k < m->files.n && status == LF_OK; k++)
        if (lf_merging_copy_of(m, m->order[k]) < 0)
            status = read_file(m, m->order[k], block, err);
    for (int row = block->first; row < block->first + block->n && status == LF_OK; row++)
        if (m->n_holders[row] > 0)
            status = write_row(m, block, row, file, err);
    return status;
}

static lf_status write_rows(lf_merging *m, lf_outfile *file, lf_merging_fn progress, void *context,
                            const lf_cancel *cancel, lf_error *err)
{
    const int height = m->like.layout.height;
    lf_merging_block block;
    lf_status status = init_block(m, &block, err);
    if (status != LF_OK)
        return status;
    for (int row = 0; row < height && status == LF_OK; row += block.n) {
        const int left = height - row;
        block.first = row;
        block.n = left < block.film.height ? left : block.film.height;
        if (cancel && atomic_load_explicit(cancel, memory_order_relaxed))
            status = lf_error_set(err, LF_E_CANCELLED, "merge", "interrupted");
        else
            status = do_block(m, &block, file, err);
        if (status == LF_OK && progress)
            progress(context, (double)(row + block.n) / height);
    }
    finish_block(&block);
    return status;
}

/* One stream of several files: entries [from, to) of sorted. */
static lf_status write_stream(lf_merging *m, int from, int to, lf_outfile *file, lf_error *err)
{
    const int height = m->like.layout.height;
    const lf_merging_stream *first = lf_merging_stream_at(m, m->sorted[from]);
    memset(m->sum, 0, (size_t)height * sizeof *m->sum);
    for (int i = from; i < to; i++) {
        const lf_merging_stream *s = lf_merging_stream_at(m, m->sorted[i]);
        lf_status status =
            lf_merging_read_stream(m, s, &lf_merging_source_at(m, s->file)->second.streams, err);
        if (status != LF_OK)
            return status;
        for (int row = 0; row < height; row++)
            if (lf_film_visited(m->counts[row].visits))
                m->sum[row] = m->counts[row];
    }
    const lf_film_stream whole = {first->seed, first->number, m->sum};
    return lf_film_stream_write(file, &whole, height, &m->heads, err);
}

/* What was merged is what was looked at. */
static lf_status check_digests(const lf_merging *m, lf_error *err)
{
    for (int i = 0; i < m->files.n; i++) {
        const lf_merging_source *s = lf_merging_source_at(m, i);
        if (s->copy_of < 0 &&
            (s->first.rows != s->second.rows || s->first.streams != s->second.streams))
            return lf_merging_changed(s->path, err);
    }
    return LF_OK;
}

lf_status lf_merging_write(lf_merging *m, lf_outfile *file, lf_merging_fn progress, void *context,
                           const lf_cancel *cancel, lf_error *err)
{
    m->heads = 0;
    lf_status status = lf_film_identity_write(file, &m->like, &m->heads, err);
    for (int from = 0, to; from < m->n_sorted && status == LF_OK; from = to) {
        to = lf_merging_group_end(m, from);
        status = write_stream(m, from, to, file, err);
    }
    if (status == LF_OK)
        status = write_rows(m, file, progress, context, cancel, err);
    if (status == LF_OK)
        status = check_digests(m, err);
    return status == LF_OK ? lf_film_end_write(file, m->heads, err) : status;
}
