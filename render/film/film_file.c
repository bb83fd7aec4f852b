#include "render/film/film_file.h"

#include <endian.h>
#include <errno.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

#include "base/alloc.h"

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "rows are written as they lie in memory; other byte orders need a conversion here"
#endif

enum {
    HEAD_BYTES = 16,
    LAYOUT_BYTES = 4 * 4 + 3 * 4,
    STREAM_BYTES = 12,
    COUNT_BYTES = 24,
    ROW_BYTES = 56
};
static const char magic[8] = "quiltdST";

/* ----------------------------------------------------------------------------------- numbers -- */

/* A position in a part's content, which advances. */
typedef struct cursor {
    unsigned char *p;
} cursor;

static void put_u32(cursor *c, uint32_t x)
{
    x = htole32(x);
    memcpy(c->p, &x, sizeof x);
    c->p += sizeof x;
}

static void put_u64(cursor *c, uint64_t x)
{
    x = htole64(x);
    memcpy(c->p, &x, sizeof x);
    c->p += sizeof x;
}

static void put_f64(cursor *c, double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    put_u64(c, bits);
}

static uint32_t get_u32(cursor *c)
{
    uint32_t x;
    memcpy(&x, c->p, sizeof x);
    c->p += sizeof x;
    return le32toh(x);
}

static uint64_t get_u64(cursor *c)
{
    uint64_t x;
    memcpy(&x, c->p, sizeof x);
    c->p += sizeof x;
    return le64toh(x);
}

static double get_f64(cursor *c)
{
    uint64_t bits = get_u64(c);
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* ------------------------------------------------------------------------------------- parts -- */

/* Content in two pieces: what was made for it, and memory as it lies. */
typedef struct lf_film_part {
    const char *name; /* four letters */
    unsigned char *made;
    size_t n_made;
    unsigned char *bulk;
    size_t n_bulk;
} lf_film_part;

static uint32_t checksum(const lf_film_part *part, const unsigned char size[8])
{
    uLong crc = crc32_z(0, (const unsigned char *)part->name, 4);
    crc = crc32_z(crc, size, 8);
    crc = part->n_made > 0 ? crc32_z(crc, part->made, part->n_made) : crc;
    return (uint32_t)(part->n_bulk > 0 ? crc32_z(crc, part->bulk, part->n_bulk) : crc);
}

static lf_status write_part(lf_outfile *file, const lf_film_part *part, lf_error *err)
{
    unsigned char head[HEAD_BYTES], *size = head + 8;
    put_u64(&(cursor){size}, part->n_made + part->n_bulk);
    memcpy(head, part->name, 4);
    put_u32(&(cursor){head + 4}, checksum(part, size));
    lf_status status = lf_outfile_write(file, head, sizeof head, err);
    if (status == LF_OK && part->n_made > 0)
        status = lf_outfile_write(file, part->made, part->n_made, err);
    if (status == LF_OK && part->n_bulk > 0)
        status = lf_outfile_write(file, part->bulk, part->n_bulk, err);
    return status;
}

static lf_status read_all(int fd, void *data, size_t n, lf_error *err)
{
    char *p = data;
    while (n > 0) {
        ssize_t got = read(fd, p, n);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return lf_error_set(err, LF_E_IO, "state", "cannot read: %s", strerror(errno));
        if (got == 0)
            return lf_error_set(err, LF_E_FORMAT, "state", "the file ends too early");
        p += got;
        n -= (size_t)got;
    }
    return LF_OK;
}

/* Reads the content of a part whose head has been read. */
static lf_status read_content(int fd, unsigned char head[HEAD_BYTES], const lf_film_part *part,
                              lf_error *err)
{
    if (memcmp(head, part->name, 4) != 0 ||
        get_u64(&(cursor){head + 8}) != part->n_made + part->n_bulk)
        return lf_error_set(err, LF_E_FORMAT, "state",
                            "expected part %s, found other data; the file is damaged", part->name);
    lf_status status = read_all(fd, part->made, part->n_made, err);
    if (status == LF_OK)
        status = read_all(fd, part->bulk, part->n_bulk, err);
    if (status == LF_OK && get_u32(&(cursor){head + 4}) != checksum(part, head + 8))
        return lf_error_set(err, LF_E_FORMAT, "state",
                            "part %s is damaged: its checksum does not match", part->name);
    return status;
}

static lf_status read_part(int fd, const lf_film_part *part, lf_error *err)
{
    unsigned char head[HEAD_BYTES];
    lf_status status = read_all(fd, head, sizeof head, err);
    return status == LF_OK ? read_content(fd, head, part, err) : status;
}

/* ------------------------------------------------------------------------------------- write -- */

static void put_layout(const lf_film *film, cursor c)
{
    const lf_film_layout *l = &film->layout;
    put_u32(&c, (uint32_t)l->n_views);
    put_u32(&c, (uint32_t)l->width);
    put_u32(&c, (uint32_t)l->height);
    put_u32(&c, (uint32_t)l->has_w2 | (uint32_t)l->has_native << 1 | (uint32_t)l->has_known << 2 |
                    (uint32_t)l->has_delta << 3 | (uint32_t)l->has_signed << 4 |
                    (uint32_t)l->has_features << 5 | (uint32_t)l->has_albedo << 6);
    for (int i = 0; i < 3; i++) {
        uint32_t bits;
        memcpy(&bits, &film->sky[i], sizeof bits);
        put_u32(&c, bits);
    }
}

static void put_counts(cursor *c, const lf_film_counts *counts)
{
    put_f64(c, counts->n[0]);
    put_f64(c, counts->n[1]);
    put_u32(c, counts->visits[0]);
    put_u32(c, counts->visits[1]);
}

/* A stream without samples is omitted. */
static lf_status write_stream(const lf_film *film, const lf_film_stream *stream, lf_outfile *file,
                              lf_error *err)
{
    uint64_t visits = 0;
    lf_film_part whole = {.name = "STRM",
                          .n_made = STREAM_BYTES + (size_t)film->height * COUNT_BYTES};
    whole.made = lf_calloc(1, whole.n_made);
    if (!whole.made)
        return lf_error_set(err, LF_E_NOMEM, "state", "not enough memory to write it");
    cursor c = {whole.made};
    put_u64(&c, stream->seed);
    put_u32(&c, stream->number);
    for (int row = 0; row < film->height; row++) {
        put_counts(&c, &stream->rows[row]);
        visits += (uint64_t)stream->rows[row].visits[0] + stream->rows[row].visits[1];
    }
    lf_status status = visits > 0 ? write_part(file, &whole, err) : LF_OK;
    lf_free(whole.made);
    return status;
}

static lf_status write_row(const lf_film *film, int row, lf_outfile *file, lf_error *err)
{
    const lf_film_row *state = &film->rows[row];
    unsigned char head[ROW_BYTES];
    cursor c = {head};
    put_u32(&c, (uint32_t)row);
    put_u32(&c, state->met);
    put_f64(&c, state->passes);
    put_counts(&c,
               &(lf_film_counts){{state->n[0], state->n[1]}, {state->visits[0], state->visits[1]}});
    for (int h = 0; h < 2; h++)
        put_f64(&c, state->coarse[h]);
    const lf_film_part whole = {"ROW ", head, sizeof head,
                                film->data + (size_t)row * film->row_bytes,
                                lf_film_used_bytes(&film->layout)};
    return write_part(file, &whole, err);
}

lf_status lf_film_write(const lf_film *film, lf_outfile *file, const lf_cancel *cancel,
                        lf_error *err)
{
    unsigned char start[sizeof magic + 4], picture[LF_PICTURE_BYTES], layout[LAYOUT_BYTES];
    memcpy(start, magic, sizeof magic);
    put_u32(&(cursor){start + sizeof magic}, LF_FILM_VERSION);
    memcpy(picture, film->picture, sizeof picture);
    put_layout(film, (cursor){layout});
    const lf_film_part parts[] = {{.name = "PICT", .made = picture, .n_made = sizeof picture},
                                  {.name = "LAYO", .made = layout, .n_made = sizeof layout}};
    lf_status status = lf_outfile_write(file, start, sizeof start, err);
    for (int i = 0; i < 2 && status == LF_OK; i++)
        status = write_part(file, &parts[i], err);
    for (int i = 0; i < film->n_streams && status == LF_OK; i++)
        status = write_stream(film, &film->streams[i], file, err);
    for (int row = 0; row < film->height && status == LF_OK; row++) {
        if (cancel && atomic_load_explicit(cancel, memory_order_relaxed))
            return lf_error_set(err, LF_E_CANCELLED, "state", "interrupted");
        if (lf_film_visited(film->rows[row].visits))
            status = write_row(film, row, file, err);
    }
    return status == LF_OK ? write_part(file, &(lf_film_part){.name = "END "}, err) : status;
}

/* -------------------------------------------------------------------------------------- read -- */

static lf_status read_start(int fd, lf_error *err)
{
    unsigned char start[sizeof magic + 4];
    lf_status status = read_all(fd, start, sizeof start, err);
    if (status != LF_OK)
        return status;
    if (memcmp(start, magic, sizeof magic) != 0)
        return lf_error_set(err, LF_E_FORMAT, "state", "this is not a saved image");
    uint32_t version = get_u32(&(cursor){start + sizeof magic});
    if (version != LF_FILM_VERSION)
        return lf_error_set(err, LF_E_STATE, "state",
                            "the saved image has version %u, but this program reads version %d",
                            version, LF_FILM_VERSION);
    return LF_OK;
}

static bool get_layout(cursor c, lf_film_layout *out, float sky[3])
{
    uint32_t size[3], flags;
    for (int i = 0; i < 3; i++)
        size[i] = get_u32(&c);
    flags = get_u32(&c);
    *out = (lf_film_layout){.n_views = (int)size[0],
                            .width = (int)size[1],
                            .height = (int)size[2],
                            .has_w2 = flags & 1,
                            .has_native = flags & 2,
                            .has_known = flags & 4,
                            .has_delta = flags & 8,
                            .has_signed = flags & 16,
                            .has_features = flags & 32,
                            .has_albedo = flags & 64};
    memcpy(sky, c.p, 3 * sizeof *sky);
    return size[0] - 1 < LF_MAX_VIEWS && size[1] - 1 < LF_MAX_VIEW_SIDE &&
           size[2] - 1 < LF_MAX_VIEW_SIDE && flags < 128 && (out->has_known || !out->has_native) &&
           (out->has_native || !out->has_delta) && (out->has_features || !out->has_albedo);
}

/* Reads only identity, layout and sky of *out. */
static lf_status read_identity(int fd, lf_film *out, lf_error *err)
{
    unsigned char layout_bytes[LAYOUT_BYTES];
    const lf_film_part parts[] = {
        {.name = "PICT", .made = out->picture, .n_made = sizeof out->picture},
        {.name = "LAYO", .made = layout_bytes, .n_made = sizeof layout_bytes}};
    lf_status status = read_start(fd, err);
    for (int i = 0; i < 2 && status == LF_OK; i++)
        status = read_part(fd, &parts[i], err);
    if (status == LF_OK && !get_layout((cursor){layout_bytes}, &out->layout, out->sky))
        return lf_error_set(err, LF_E_FORMAT, "state", "its layout is invalid");
    return status;
}

static lf_status read_empty(int fd, const lf_film *like, lf_film *out, lf_error *err)
{
    lf_film given = {0};
    lf_status status = read_identity(fd, &given, err);
    if (status != LF_OK)
        return status;
    const char *refusal = like ? lf_film_refusal(like, &given) : NULL;
    if (refusal)
        return lf_error_set(err, LF_E_STATE, "state", "the saved image is %s", refusal);
    if (lf_film_init(out, &given.layout) != LF_OK)
        return lf_error_set(err, LF_E_NOMEM, "state", "not enough memory to read it");
    memcpy(out->picture, given.picture, sizeof given.picture);
    memcpy(out->sky, given.sky, sizeof given.sky);
    return LF_OK;
}

static lf_film_counts get_counts(cursor *c)
{
    lf_film_counts counts;
    for (int h = 0; h < 2; h++)
        counts.n[h] = get_f64(c);
    for (int h = 0; h < 2; h++)
        counts.visits[h] = get_u32(c);
    return counts;
}

static lf_status read_stream(int fd, unsigned char head[HEAD_BYTES], lf_film *film, lf_error *err)
{
    lf_film_part whole = {.name = "STRM",
                          .n_made = STREAM_BYTES + (size_t)film->height * COUNT_BYTES};
    int index = 0, n = film->n_streams;
    if (n == LF_FILM_MAX_STREAMS)
        return lf_error_set(err, LF_E_FORMAT, "state", "it has more than %d random streams", n);
    whole.made = lf_calloc(1, whole.n_made);
    lf_status status = whole.made ? read_content(fd, head, &whole, err)
                                  : lf_error_set(err, LF_E_NOMEM, "state", "out of memory");
    if (status == LF_OK) {
        cursor c = {whole.made};
        uint64_t seed = get_u64(&c);
        if (lf_film_stream_at(film, seed, get_u32(&c), &index) != LF_OK)
            status = lf_error_set(err, LF_E_NOMEM, "state", "out of memory");
        else if (film->n_streams == n || index != n)
            status = lf_error_set(err, LF_E_FORMAT, "state", "its random streams are not in order");
        for (int row = 0; row < film->height && status == LF_OK; row++) {
            film->streams[index].rows[row] = get_counts(&c);
            if (!lf_film_counts_possible(&film->streams[index].rows[row]))
                status = lf_error_set(err, LF_E_FORMAT, "state", "row %d has invalid counts", row);
        }
    }
    lf_free(whole.made);
    return status;
}

/* Reads the next row. */
static lf_status read_row(int fd, unsigned char head[HEAD_BYTES], lf_film *film, int *row,
                          lf_error *err)
{
    unsigned char bytes[ROW_BYTES];
    cursor c = {bytes};
    /* Read into the next row's memory, and moved when the number is known and valid: rows without
     * visits may contain anything. */
    const lf_film_part whole = {"ROW ", bytes, sizeof bytes,
                                film->data + (size_t)(*row + 1) * film->row_bytes,
                                lf_film_used_bytes(&film->layout)};
    if (*row + 1 >= film->height)
        return lf_error_set(err, LF_E_FORMAT, "state", "it has more rows than its layout");
    lf_status status = read_content(fd, head, &whole, err);
    if (status != LF_OK)
        return status;
    uint32_t number = get_u32(&c), met = get_u32(&c);
    double passes = get_f64(&c);
    const lf_film_counts counts = get_counts(&c);
    double coarse[2];
    for (int h = 0; h < 2; h++)
        coarse[h] = get_f64(&c);
    const lf_film_row state = {.n = {counts.n[0], counts.n[1]},
                               .coarse = {coarse[0], coarse[1]},
                               .passes = passes,
                               .visits = {counts.visits[0], counts.visits[1]},
                               .met = met,
                               .relative_error = -1.0};
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
    memmove(film->data + (size_t)number * film->row_bytes, whole.bulk, whole.n_bulk);
    film->rows[number] = state;
    *row = (int)number;
    return LF_OK;
}

static lf_status read_end(int fd, unsigned char head[HEAD_BYTES], lf_error *err)
{
    char more;
    lf_status status = read_content(fd, head, &(lf_film_part){.name = "END "}, err);
    return status != LF_OK || read(fd, &more, 1) == 0
               ? status
               : lf_error_set(err, LF_E_FORMAT, "state", "the file has data after its end");
}

static lf_status read_rest(int fd, lf_film *film, lf_error *err)
{
    unsigned char head[HEAD_BYTES];
    int row = -1;
    for (;;) {
        lf_status status = read_all(fd, head, sizeof head, err);
        if (status == LF_OK && memcmp(head, "STRM", 4) == 0 && row < 0)
            status = read_stream(fd, head, film, err);
        else if (status == LF_OK && memcmp(head, "ROW ", 4) == 0)
            status = read_row(fd, head, film, &row, err);
        else if (status == LF_OK)
            return read_end(fd, head, err);
        if (status != LF_OK)
            return status;
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
    lf_status status = read_empty(fd, like, &film, err);
    if (status == LF_OK)
        status = read_rest(fd, &film, err);
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
    unsigned char head[HEAD_BYTES], seed[8] = {0};
    lf_film given = {0};
    lf_status status = read_identity(fd, &given, err);
    if (status == LF_OK)
        status = read_all(fd, head, sizeof head, err);
    if (status == LF_OK && memcmp(head, "STRM", 4) == 0)
        status = read_all(fd, seed, sizeof seed, err);
    if (status != LF_OK)
        return status;
    *out_layout = given.layout;
    *out_seed = get_u64(&(cursor){seed});
    return LF_OK;
}

/* Marks the rows that a stream has visited; the head of its part has been read. */
static lf_status mark_rows(int fd, unsigned char head[HEAD_BYTES], int height, bool *visited,
                           lf_error *err)
{
    lf_film_part whole = {.name = "STRM", .n_made = STREAM_BYTES + (size_t)height * COUNT_BYTES};
    whole.made = lf_calloc(1, whole.n_made);
    if (!whole.made)
        return lf_error_set(err, LF_E_NOMEM, "state", "out of memory");
    lf_status status = read_content(fd, head, &whole, err);
    cursor c = {whole.made + STREAM_BYTES};
    for (int row = 0; row < height && status == LF_OK; row++) {
        const lf_film_counts counts = get_counts(&c);
        visited[row] |= lf_film_visited(counts.visits);
    }
    lf_free(whole.made);
    return status;
}

lf_status lf_film_count_rows(int fd, int *out_rows, lf_error *err)
{
    unsigned char head[HEAD_BYTES];
    lf_film given = {0};
    lf_status status = read_identity(fd, &given, err);
    if (status != LF_OK)
        return status;
    const int height = given.layout.height;
    bool *visited = lf_calloc((size_t)height, sizeof *visited);
    if (!visited)
        return lf_error_set(err, LF_E_NOMEM, "state", "out of memory");
    while (status == LF_OK && (status = read_all(fd, head, sizeof head, err)) == LF_OK &&
           memcmp(head, "STRM", 4) == 0)
        status = mark_rows(fd, head, height, visited, err);
    int n = 0;
    for (int row = 0; row < height; row++)
        n += visited[row];
    lf_free(visited);
    if (status == LF_OK)
        *out_rows = n;
    return status;
}
