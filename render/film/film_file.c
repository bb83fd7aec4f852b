#include "render/film/film_file.h"

#include <endian.h>
#include <string.h>

#include "base/alloc.h"
#include "render/film/film_pack.h"
#include "render/film/film_part.h"

/* ------------------------------------------------------------------------------------- write -- */

static lf_status write_row(const lf_film *film, int row, lf_outfile *file, uint32_t *heads,
                           lf_error *err)
{
    unsigned char head[LF_FILM_ROW_BYTES];
    lf_film_row_put((uint32_t)row, &film->rows[row], head);
    lf_film_open(film, row);
    const lf_film_part whole = {"ROW ", head, sizeof head, lf_film_row_at(film, row),
                                lf_film_used_bytes(&film->layout)};
    const lf_status status = lf_film_part_write(file, &whole, heads, err);
    lf_film_close(film, row, false);
    return status;
}

lf_status lf_film_write(const lf_film *film, lf_outfile *file, const lf_cancel *cancel,
                        lf_error *err)
{
    uint32_t heads = 0;
    lf_status status = lf_film_identity_write(file, film, &heads, err);
    for (int i = 0; i < film->n_streams && status == LF_OK; i++)
        status = lf_film_stream_write(file, &film->streams[i], film->height, &heads, err);
    for (int row = 0; row < film->height && status == LF_OK; row++) {
        if (cancel && atomic_load_explicit(cancel, memory_order_relaxed))
            return lf_error_set(err, LF_E_CANCELLED, "state", "interrupted");
        if (lf_film_visited(film->rows[row].visits))
            status = write_row(film, row, file, &heads, err);
    }
    return status == LF_OK ? lf_film_end_write(file, heads, err) : status;
}

/* -------------------------------------------------------------------------------------- read -- */

static lf_status read_empty(int fd, const lf_film *like, lf_film *out, uint32_t *heads,
                            lf_error *err)
{
    lf_film given = {0};
    lf_status status = lf_film_identity_read(fd, &given, heads, err);
    if (status != LF_OK)
        return status;
    const char *refusal = like ? lf_film_refusal(like, &given) : NULL;
    if (refusal)
        return lf_error_set(err, LF_E_STATE, "state", "the saved image is %s", refusal);
    const int n_threads = like && like->packed ? lf_film_packed_threads(like->packed) : 0;
    if (lf_film_init_packed(out, &given.layout, n_threads) != LF_OK)
        return lf_error_set(err, LF_E_NOMEM, "state", "not enough memory to read it");
    memcpy(out->picture, given.picture, sizeof given.picture);
    memcpy(out->sky, given.sky, sizeof given.sky);
    return LF_OK;
}

static lf_status read_stream(int fd, const unsigned char head[LF_FILM_HEAD_BYTES], lf_film *film,
                             lf_error *err)
{
    int index = 0, n = film->n_streams;
    if (n == LF_FILM_MAX_STREAMS)
        return lf_error_set(err, LF_E_FORMAT, "state", "it has more than %d random streams", n);
    lf_film_stream given = {.rows = lf_calloc((size_t)film->height, sizeof *given.rows)};
    lf_status status = given.rows ? lf_film_stream_read(fd, head, film->height, &given, err)
                                  : lf_error_set(err, LF_E_NOMEM, "state", "out of memory");
    if (status == LF_OK && lf_film_stream_at(film, given.seed, given.number, &index) != LF_OK)
        status = lf_error_set(err, LF_E_NOMEM, "state", "out of memory");
    else if (status == LF_OK && (film->n_streams == n || index != n))
        status = lf_error_set(err, LF_E_FORMAT, "state", "its random streams are not in order");
    if (status == LF_OK)
        memcpy(film->streams[index].rows, given.rows, (size_t)film->height * sizeof *given.rows);
    lf_free(given.rows);
    return status;
}

/* Moves what was read as one row to the row that it is. */
static void move_row(const lf_film *film, int from, int to)
{
    if (from == to)
        return;
    lf_film_open(film, to);
    memcpy(lf_film_row_at(film, to), lf_film_row_at(film, from), lf_film_used_bytes(&film->layout));
    lf_film_close(film, to, true);
}

/* Reads the next row; that after *row is open. */
static lf_status read_open(int fd, const unsigned char head[LF_FILM_HEAD_BYTES], lf_film *film,
                           int *row, lf_error *err)
{
    unsigned char bytes[LF_FILM_ROW_BYTES];
    /* Read into the next row's memory, and moved when the number is known and valid: rows without
     * visits may contain anything. */
    const lf_film_part whole = {"ROW ", bytes, sizeof bytes, lf_film_row_at(film, *row + 1),
                                lf_film_used_bytes(&film->layout)};
    lf_status status = lf_film_part_read(fd, head, &whole, err);
    if (status != LF_OK)
        return status;
    uint32_t number;
    const lf_film_row state = lf_film_row_get(bytes, &number);
    uint64_t given[2] = {0, 0};
    if (number <= (uint32_t)*row && *row >= 0)
        return lf_error_set(err, LF_E_FORMAT, "state", "its rows are not in order");
    if (number >= (uint32_t)film->height)
        return lf_error_set(err, LF_E_FORMAT, "state", "it has more rows than its layout");
    for (int i = 0; i < film->n_streams; i++)
        for (int h = 0; h < 2; h++)
            given[h] += film->streams[i].rows[number].visits[h];
    if (!lf_film_row_possible(&state) || given[0] != state.visits[0] || given[1] != state.visits[1])
        return lf_error_set(err, LF_E_FORMAT, "state", "row %u has invalid counts", number);
    move_row(film, *row + 1, (int)number);
    film->rows[number] = state;
    *row = (int)number;
    return LF_OK;
}

static lf_status read_row(int fd, const unsigned char head[LF_FILM_HEAD_BYTES], lf_film *film,
                          int *row, lf_error *err)
{
    const int next = *row + 1;
    if (next >= film->height)
        return lf_error_set(err, LF_E_FORMAT, "state", "it has more rows than its layout");
    lf_film_open(film, next);
    const lf_status status = read_open(fd, head, film, row, err);
    lf_film_close(film, next, *row == next);
    return status;
}

static lf_status read_rest(int fd, lf_film *film, uint32_t heads, lf_error *err)
{
    unsigned char head[LF_FILM_HEAD_BYTES];
    int row = -1;
    for (;;) {
        lf_status status = lf_film_part_next(fd, head, err);
        if (status == LF_OK && lf_film_part_is(head, "STRM") && row < 0)
            status = read_stream(fd, head, film, err);
        else if (status == LF_OK && lf_film_part_is(head, "ROW "))
            status = read_row(fd, head, film, &row, err);
        else if (status == LF_OK)
            return lf_film_end_read(fd, head, heads, err);
        if (status != LF_OK)
            return status;
        lf_film_heads_add(&heads, head);
    }
}

/* Rows that streams have visited and the file has not. */
static bool rows_missing(const lf_film *film)
{
    for (int i = 0; i < film->n_streams; i++)
        for (int row = 0; row < film->height; row++)
            if (lf_film_visited(film->streams[i].rows[row].visits) &&
                !lf_film_visited(film->rows[row].visits))
                return true;
    return false;
}

lf_status lf_film_read(int fd, const lf_film *like, lf_film *out, lf_error *err)
{
    lf_film film = {0};
    uint32_t heads = 0;
    lf_status status = read_empty(fd, like, &film, &heads, err);
    if (status == LF_OK)
        status = read_rest(fd, &film, heads, err);
    if (status == LF_OK && rows_missing(&film))
        status = lf_error_set(err, LF_E_FORMAT, "state", "rows are missing");
    if (status != LF_OK) {
        lf_film_finish(&film);
        return status;
    }
    *out = film;
    return LF_OK;
}

lf_status lf_film_look(int fd, lf_film_layout *out_layout, uint64_t *out_seed, lf_error *err)
{
    unsigned char head[LF_FILM_HEAD_BYTES];
    uint64_t seed = 0;
    lf_film given = {0};
    uint32_t ignored = 0;
    lf_status status = lf_film_identity_read(fd, &given, &ignored, err);
    if (status == LF_OK)
        status = lf_film_part_next(fd, head, err);
    if (status == LF_OK && lf_film_part_is(head, "STRM"))
        status = lf_film_bytes_read(fd, &seed, sizeof seed, err);
    if (status != LF_OK)
        return status;
    *out_layout = given.layout;
    *out_seed = le64toh(seed);
    return LF_OK;
}

lf_status lf_film_count_rows(int fd, int *out_rows, lf_error *err)
{
    unsigned char head[LF_FILM_HEAD_BYTES];
    lf_film given = {0};
    uint32_t ignored = 0;
    lf_status status = lf_film_identity_read(fd, &given, &ignored, err);
    if (status != LF_OK)
        return status;
    const int height = given.layout.height;
    bool *visited = lf_calloc((size_t)height, sizeof *visited);
    lf_film_stream stream = {.rows = lf_calloc((size_t)height, sizeof *stream.rows)};
    if (!visited || !stream.rows)
        status = lf_error_set(err, LF_E_NOMEM, "state", "out of memory");
    while (status == LF_OK && (status = lf_film_part_next(fd, head, err)) == LF_OK &&
           lf_film_part_is(head, "STRM")) {
        status = lf_film_stream_read(fd, head, height, &stream, err);
        for (int row = 0; row < height && status == LF_OK; row++)
            visited[row] |= lf_film_visited(stream.rows[row].visits);
    }
    int n = 0;
    for (int row = 0; row < height && visited; row++)
        n += visited[row];
    lf_free(stream.rows);
    lf_free(visited);
    if (status == LF_OK)
        *out_rows = n;
    return status;
}
