/* The first pass: what the files hold. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "render/film/film_merge_internal.h"
#include "render/transport/sampler.h"

/* ------------------------------------------------------------------------------------- lists -- */

/* Room for one more entry; NULL: out of memory. */
static void *list_more(lf_merging_list *list, size_t size)
{
    if (list->n == list->n_allocated) {
        const size_t wanted = list->n > 0 ? 2 * (size_t)list->n : 4;
        if (wanted > INT32_MAX)
            return NULL;
        unsigned char *data = lf_calloc(wanted, size);
        if (!data)
            return NULL;
        if (list->n > 0)
            memcpy(data, list->data, (size_t)list->n * size);
        lf_free(list->data);
        list->data = data;
        list->n_allocated = (int)wanted;
    }
    return (unsigned char *)list->data + (size_t)list->n++ * size;
}

lf_merging_source *lf_merging_source_at(const lf_merging *m, int file)
{
    return (lf_merging_source *)m->files.data + file;
}

const lf_merging_range *lf_merging_range_at(const lf_merging *m, int index)
{
    return (const lf_merging_range *)m->ranges.data + index;
}

const lf_merging_stream *lf_merging_stream_at(const lf_merging *m, int index)
{
    return (const lf_merging_stream *)m->streams.data + index;
}

static lf_status no_memory(lf_error *err)
{
    return lf_error_set(err, LF_E_NOMEM, "merge", "out of memory");
}

lf_status lf_merging_create(lf_merging **out, lf_error *err)
{
    lf_merging *m = lf_calloc(1, sizeof *m);
    if (!m)
        return no_memory(err);
    m->fd = m->open = -1;
    *out = m;
    return LF_OK;
}

void lf_merging_destroy(lf_merging *m)
{
    if (!m)
        return;
    for (int i = 0; i < m->files.n; i++)
        lf_free(lf_merging_source_at(m, i)->path);
    void *const all[] = {m->files.data, m->ranges.data, m->streams.data, m->order,
                         m->sorted,     m->key,         m->n_holders,    m->passes,
                         m->whole,      m->counts,      m->sum,          m->owner};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
        lf_free(all[i]);
    if (m->fd >= 0)
        close(m->fd);
    lf_free(m);
}

/* ------------------------------------------------------------------------------------ errors -- */

lf_status lf_merging_blame(const char *path, const lf_error *why, lf_error *err)
{
    return why->status == LF_E_FORMAT
               ? lf_error_set(err, why->status, path, "is damaged (%s); make this part again",
                              why->what)
               : lf_error_set(err, why->status, path, "%s", why->what);
}

lf_status lf_merging_changed(const char *path, lf_error *err)
{
    return lf_error_set(err, LF_E_FORMAT, path,
                        "changed while it was read; merge again when all parts are complete");
}

/* ------------------------------------------------------------------------------------- parts -- */

uint64_t lf_merging_digest_add(uint64_t digest, const unsigned char *bytes, size_t n)
{
    for (size_t i = 0; i + 8 <= n; i += 8) {
        uint64_t x;
        memcpy(&x, bytes + i, sizeof x);
        digest = lf_hash64(digest, x);
    }
    return digest;
}

size_t lf_merging_row_bytes(const lf_film_layout *layout)
{
    return LF_FILM_HEAD_BYTES + LF_FILM_ROW_BYTES + lf_film_used_bytes(layout);
}

static bool same_file(const struct stat *a, const struct stat *b)
{
    return a->st_dev == b->st_dev && a->st_ino == b->st_ino && a->st_size == b->st_size &&
           a->st_mtim.tv_sec == b->st_mtim.tv_sec && a->st_mtim.tv_nsec == b->st_mtim.tv_nsec;
}

lf_status lf_merging_seek(lf_merging *m, int file, off_t at, lf_error *err)
{
    const lf_merging_source *source = lf_merging_source_at(m, file);
    struct stat now;
    if (m->open != file) {
        if (m->fd >= 0)
            close(m->fd);
        m->fd = m->open = -1;
        lf_status status = lf_file_open(source->path, NULL, UINT64_MAX, &m->fd, NULL, err);
        if (status != LF_OK)
            return status;
        m->open = file;
        if (fstat(m->fd, &now) != 0 || !same_file(&now, &source->seen))
            return lf_merging_changed(source->path, err);
    }
    return lseek(m->fd, at, SEEK_SET) == at
               ? LF_OK
               : lf_error_set(err, LF_E_IO, source->path, "cannot be read: %s", strerror(errno));
}

lf_status lf_merging_read_stream(lf_merging *m, const lf_merging_stream *stream, uint64_t *digest,
                                 lf_error *err)
{
    unsigned char head[LF_FILM_HEAD_BYTES];
    const char *path = lf_merging_source_at(m, stream->file)->path;
    lf_film_stream read = {.rows = m->counts};
    lf_error why = {0};
    lf_status status = lf_merging_seek(m, stream->file, stream->at, err);
    if (status != LF_OK)
        return status;
    status = lf_film_part_next(m->fd, head, &why);
    if (status == LF_OK)
        status = lf_film_stream_read(m->fd, head, m->like.layout.height, &read, &why);
    if (status != LF_OK)
        return lf_merging_blame(path, &why, err);
    *digest = lf_merging_digest_add(*digest, head, sizeof head);
    return LF_OK;
}

/* -------------------------------------------------------------------------------------- look -- */

/* A file that is being looked at. */
typedef struct lf_merging_look {
    lf_merging *m;
    lf_merging_source *source;
    lf_merging_file found;
    int fd;
    lf_film_counts *counts; /* [height] of its streams that no row has had yet */
    unsigned char head[LF_FILM_HEAD_BYTES];
} lf_merging_look;

static lf_status damaged(lf_error *err, const char *what)
{
    return lf_error_set(err, LF_E_FORMAT, "state", "%s", what);
}

/* Visits that are too many stay so. */
static void add_count(lf_film_counts *to, const lf_film_counts *from, int half)
{
    const uint32_t room = UINT32_MAX - to->visits[half];
    to->visits[half] += from->visits[half] < room ? from->visits[half] : room;
    to->n[half] += from->n[half];
}

static lf_status look_at_stream(lf_merging_look *look, lf_error *err)
{
    lf_merging *m = look->m;
    lf_film_stream read = {.rows = m->counts};
    const off_t at = lseek(look->fd, 0, SEEK_CUR) - LF_FILM_HEAD_BYTES;
    lf_status status = lf_film_stream_read(look->fd, look->head, m->like.layout.height, &read, err);
    if (status != LF_OK)
        return status;
    if (look->source->n_streams > 0) {
        const lf_merging_stream *last = lf_merging_stream_at(m, m->streams.n - 1);
        if (read.seed < last->seed || (read.seed == last->seed && read.number <= last->number))
            return damaged(err, "its random streams are not in order");
    } else {
        look->found.seed = read.seed;
        look->found.stream = read.number;
    }
    lf_merging_stream *stream = list_more(&m->streams, sizeof *stream);
    if (!stream)
        return no_memory(err);
    *stream = (lf_merging_stream){read.seed, at, read.number, m->files.n - 1};
    look->found.n_streams = ++look->source->n_streams;
    for (int row = 0; row < m->like.layout.height; row++)
        for (int h = 0; h < 2; h++)
            add_count(&look->counts[row], &m->counts[row], h);
    look->source->first.streams =
        lf_merging_digest_add(look->source->first.streams, look->head, sizeof look->head);
    return LF_OK;
}

/* Remembers a row. */
static lf_status note_row(lf_merging_look *look, int number, const lf_film_row *row, lf_error *err)
{
    lf_merging *m = look->m;
    lf_merging_file *found = &look->found;
    lf_merging_range *last = NULL;
    if (found->n_rows > 0)
        last = (lf_merging_range *)m->ranges.data + m->ranges.n - 1;
    if (!last || last->first + last->n != number ||
        memcmp(&last->passes, &row->passes, sizeof row->passes) != 0) {
        last = list_more(&m->ranges, sizeof *last);
        if (!last)
            return no_memory(err);
        *last = (lf_merging_range){row->passes, number, 0};
        look->source->n_ranges++;
    }
    last->n++;
    m->whole[number] |= row->n[0] + row->n[1] > row->coarse[0] + row->coarse[1];
    if (found->n_rows++ == 0) {
        found->first_row = number;
        found->least_passes = found->most_passes = row->passes;
    }
    found->last_row = number;
    if (row->passes < found->least_passes)
        found->least_passes = row->passes;
    if (row->passes > found->most_passes)
        found->most_passes = row->passes;
    return LF_OK;
}

/* Whether a row's passes are its samples; both are sums of the same visits. */
static bool same_samples(const lf_film_row *row, int n_views)
{
    const double of_samples = (row->n[0] + row->n[1]) * n_views;
    return fabs(row->passes - of_samples) <= 1e-9 * of_samples;
}

/* Whether a row's samples are those of its streams: several may be added in another order. */
static bool same_counts(const lf_film_row *row, const lf_film_counts *streams, int n_streams)
{
    const double most = n_streams == 1 ? 0.0 : 1e-9;
    for (int h = 0; h < 2; h++)
        if (row->visits[h] != streams->visits[h] ||
            !(fabs(row->n[h] - streams->n[h]) <= most * row->n[h]))
            return false;
    return true;
}

/* Reads what stands before a row's numbers, and skips these. */
static lf_status look_at_row(lf_merging_look *look, lf_error *err)
{
    const lf_film_layout *layout = &look->m->like.layout;
    unsigned char bytes[LF_FILM_ROW_BYTES];
    lf_merging_source *source = look->source;
    const size_t bulk = lf_film_used_bytes(layout);
    uint32_t number;
    if (!lf_film_part_has_size(look->head, sizeof bytes + bulk))
        return damaged(err, "a row has another size than its layout");
    lf_status status = lf_film_bytes_read(look->fd, bytes, sizeof bytes, err);
    if (status != LF_OK)
        return status;
    const lf_film_row row = lf_film_row_get(bytes, &number);
    if (number >= (uint32_t)layout->height ||
        (look->found.n_rows > 0 && number <= (uint32_t)look->found.last_row))
        return damaged(err, "its rows are not in order");
    if (!lf_film_row_possible(&row) || !lf_film_visited(row.visits) ||
        !same_counts(&row, &look->counts[number], source->n_streams) ||
        !same_samples(&row, layout->n_views))
        return lf_error_set(err, LF_E_FORMAT, "state", "row %u has invalid counts", number);
    if (look->found.n_rows == 0)
        source->rows_at = lseek(look->fd, 0, SEEK_CUR) - (off_t)(LF_FILM_HEAD_BYTES + sizeof bytes);
    source->first.rows = lf_merging_digest_add(source->first.rows, look->head, sizeof look->head);
    source->first.rows = lf_merging_digest_add(source->first.rows, bytes, sizeof bytes);
    look->counts[number] = (lf_film_counts){0};
    if (lseek(look->fd, (off_t)bulk, SEEK_CUR) < 0)
        return lf_error_set(err, LF_E_IO, "state", "cannot read: %s", strerror(errno));
    return note_row(look, (int)number, &row, err);
}

static lf_status look_at_parts(lf_merging_look *look, uint32_t heads, lf_error *err)
{
    for (;;) {
        lf_status status = lf_film_part_next(look->fd, look->head, err);
        if (status == LF_OK && lf_film_part_is(look->head, "STRM") && look->found.n_rows == 0)
            status = look_at_stream(look, err);
        else if (status == LF_OK && lf_film_part_is(look->head, "ROW "))
            status = look_at_row(look, err);
        else if (status == LF_OK)
            return lf_film_end_read(look->fd, look->head, heads, err);
        if (status != LF_OK)
            return status;
        lf_film_heads_add(&heads, look->head);
    }
}

/* Rows that streams have visited and the file does not have. */
static lf_status check_rows(const lf_merging_look *look, lf_error *err)
{
    for (int row = 0; row < look->m->like.layout.height; row++)
        if (lf_film_visited(look->counts[row].visits))
            return lf_error_set(err, LF_E_FORMAT, "state", "row %d is missing", row);
    return LF_OK;
}

/* Memory that depends on the height, from the first file on. */
static lf_status make_room(lf_merging *m, lf_error *err)
{
    const size_t height = (size_t)m->like.layout.height;
    m->key = lf_calloc(height, sizeof *m->key);
    m->n_holders = lf_calloc(height, sizeof *m->n_holders);
    m->passes = lf_calloc(height, sizeof *m->passes);
    m->whole = lf_calloc(height, sizeof *m->whole);
    m->counts = lf_calloc(height, sizeof *m->counts);
    m->sum = lf_calloc(height, sizeof *m->sum);
    m->owner = lf_calloc(height, sizeof *m->owner);
    return m->key && m->n_holders && m->passes && m->whole && m->counts && m->sum && m->owner
               ? LF_OK
               : no_memory(err);
}

static lf_status check_image(lf_merging *m, const lf_film *given, lf_error *err)
{
    if (m->files.n == 1) {
        m->like = *given;
        return make_room(m, err);
    }
    const char *first = lf_merging_source_at(m, 0)->path;
    if (memcmp(given->picture, m->like.picture, sizeof given->picture) != 0 ||
        !lf_film_same_layout(&given->layout, &m->like.layout))
        return lf_error_set(err, LF_E_STATE, "state",
                            "is of another scene, camera or settings than %s", first);
    return memcmp(given->sky, m->like.sky, sizeof given->sky) == 0
               ? LF_OK
               : lf_error_set(err, LF_E_STATE, "state", "is of another sky than %s", first);
}

static lf_status look_at(lf_merging_look *look, lf_error *err)
{
    lf_merging *m = look->m;
    lf_film given = {0};
    uint32_t heads = 0;
    lf_status status = lf_film_identity_read(look->fd, &given, &heads, err);
    if (status == LF_OK)
        status = check_image(m, &given, err);
    if (status != LF_OK)
        return status;
    const lf_film_layout *layout = &m->like.layout;
    look->found = (lf_merging_file){
        .n_views = layout->n_views, .width = layout->width, .height = layout->height};
    look->counts = lf_calloc((size_t)layout->height, sizeof *look->counts);
    if (!look->counts)
        return no_memory(err);
    status = look_at_parts(look, heads, err);
    if (status == LF_OK)
        status = check_rows(look, err);
    lf_free(look->counts);
    return status;
}

lf_status lf_merging_add(lf_merging *m, int fd, const char *path, uint32_t tie,
                         lf_merging_file *out, lf_error *err)
{
    lf_merging_source *source = list_more(&m->files, sizeof *source);
    lf_error why = {0};
    if (!source)
        return no_memory(err);
    *source = (lf_merging_source){.path = lf_strdup(path),
                                  .at = lseek(fd, 0, SEEK_CUR),
                                  .first_range = m->ranges.n,
                                  .first_stream = m->streams.n,
                                  .copy_of = -1,
                                  .tie = tie};
    if (!source->path)
        return no_memory(err);
    if (source->at < 0 || fstat(fd, &source->seen) != 0)
        return lf_error_set(err, LF_E_IO, path, "cannot be read: %s", strerror(errno));
    lf_merging_look look = {.m = m, .source = source, .fd = fd};
    if (look_at(&look, &why) != LF_OK)
        return lf_merging_blame(path, &why, err);
    *out = look.found;
    return LF_OK;
}
