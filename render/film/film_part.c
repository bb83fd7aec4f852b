#include "render/film/film_part.h"

#include <endian.h>
#include <errno.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

#include "base/alloc.h"
#include "render/film/film_file.h"

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "rows are written as they lie in memory; other byte orders need a conversion here"
#endif

enum { LAYOUT_BYTES = 4 * 4 + 3 * 4, STREAM_BYTES = 12, COUNT_BYTES = 24 };
static const char magic[8] = "quiltdST";
_Static_assert(sizeof magic + 4 == LF_FILM_START_BYTES, "magic and version");

/* ----------------------------------------------------------------------------------- numbers -- */

/* A position in a part's content, which advances. */
typedef struct cursor {
    unsigned char *p;
} cursor;
/* The same, for reading. */
typedef struct reading {
    const unsigned char *p;
} reading;

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

static uint32_t get_u32(reading *c)
{
    uint32_t x;
    memcpy(&x, c->p, sizeof x);
    c->p += sizeof x;
    return le32toh(x);
}

static uint64_t get_u64(reading *c)
{
    uint64_t x;
    memcpy(&x, c->p, sizeof x);
    c->p += sizeof x;
    return le64toh(x);
}

static double get_f64(reading *c)
{
    uint64_t bits = get_u64(c);
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* ------------------------------------------------------------------------------------- parts -- */

static uint32_t checksum(const lf_film_part *part, const unsigned char size[8])
{
    uLong crc = crc32_z(0, (const unsigned char *)part->name, 4);
    crc = crc32_z(crc, size, 8);
    crc = part->n_made > 0 ? crc32_z(crc, part->made, part->n_made) : crc;
    return (uint32_t)(part->n_bulk > 0 ? crc32_z(crc, part->bulk, part->n_bulk) : crc);
}

void lf_film_heads_add(uint32_t *heads, const unsigned char head[LF_FILM_HEAD_BYTES])
{
    *heads = (uint32_t)crc32_z(*heads, head, LF_FILM_HEAD_BYTES);
}

lf_status lf_film_part_write(lf_outfile *file, const lf_film_part *part, uint32_t *heads,
                             lf_error *err)
{
    unsigned char head[LF_FILM_HEAD_BYTES], *size = head + 8;
    put_u64(&(cursor){size}, part->n_made + part->n_bulk);
    memcpy(head, part->name, 4);
    put_u32(&(cursor){head + 4}, checksum(part, size));
    lf_film_heads_add(heads, head);
    lf_status status = lf_outfile_write(file, head, sizeof head, err);
    if (status == LF_OK && part->n_made > 0)
        status = lf_outfile_write(file, part->made, part->n_made, err);
    if (status == LF_OK && part->n_bulk > 0)
        status = lf_outfile_write(file, part->bulk, part->n_bulk, err);
    return status;
}

lf_status lf_film_bytes_read(int fd, void *data, size_t n, lf_error *err)
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

lf_status lf_film_part_next(int fd, unsigned char head[LF_FILM_HEAD_BYTES], lf_error *err)
{
    return lf_film_bytes_read(fd, head, LF_FILM_HEAD_BYTES, err);
}

bool lf_film_part_is(const unsigned char head[LF_FILM_HEAD_BYTES], const char *name)
{
    return memcmp(head, name, 4) == 0;
}

bool lf_film_part_has_size(const unsigned char head[LF_FILM_HEAD_BYTES], uint64_t size)
{
    return get_u64(&(reading){head + 8}) == size;
}

lf_status lf_film_part_read(int fd, const unsigned char head[LF_FILM_HEAD_BYTES],
                            const lf_film_part *part, lf_error *err)
{
    if (!lf_film_part_is(head, part->name) ||
        !lf_film_part_has_size(head, part->n_made + part->n_bulk))
        return lf_error_set(err, LF_E_FORMAT, "state",
                            "expected part %s, found other data; the file is damaged", part->name);
    lf_status status = lf_film_bytes_read(fd, part->made, part->n_made, err);
    if (status == LF_OK)
        status = lf_film_bytes_read(fd, part->bulk, part->n_bulk, err);
    if (status == LF_OK && get_u32(&(reading){head + 4}) != checksum(part, head + 8))
        return lf_error_set(err, LF_E_FORMAT, "state",
                            "part %s is damaged: its checksum does not match", part->name);
    return status;
}

static lf_status read_next(int fd, const lf_film_part *part, uint32_t *heads, lf_error *err)
{
    unsigned char head[LF_FILM_HEAD_BYTES];
    lf_status status = lf_film_part_next(fd, head, err);
    if (status == LF_OK)
        lf_film_heads_add(heads, head);
    return status == LF_OK ? lf_film_part_read(fd, head, part, err) : status;
}

/* ---------------------------------------------------------------------------------- identity -- */

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

lf_status lf_film_identity_write(lf_outfile *file, const lf_film *film, uint32_t *heads,
                                 lf_error *err)
{
    unsigned char start[LF_FILM_START_BYTES], picture[LF_PICTURE_BYTES], layout[LAYOUT_BYTES];
    memcpy(start, magic, sizeof magic);
    put_u32(&(cursor){start + sizeof magic}, LF_FILM_VERSION);
    memcpy(picture, film->picture, sizeof picture);
    put_layout(film, (cursor){layout});
    const lf_film_part parts[] = {{.name = "PICT", .made = picture, .n_made = sizeof picture},
                                  {.name = "LAYO", .made = layout, .n_made = sizeof layout}};
    lf_status status = lf_outfile_write(file, start, sizeof start, err);
    for (int i = 0; i < 2 && status == LF_OK; i++)
        status = lf_film_part_write(file, &parts[i], heads, err);
    return status;
}

static lf_status read_start(int fd, lf_error *err)
{
    unsigned char start[LF_FILM_START_BYTES];
    lf_status status = lf_film_bytes_read(fd, start, sizeof start, err);
    if (status != LF_OK)
        return status;
    if (memcmp(start, magic, sizeof magic) != 0)
        return lf_error_set(err, LF_E_FORMAT, "state", "this is not a saved image");
    uint32_t version = get_u32(&(reading){start + sizeof magic});
    if (version != LF_FILM_VERSION)
        return lf_error_set(err, LF_E_STATE, "state",
                            "the saved image has version %u, but this program reads version %d",
                            version, LF_FILM_VERSION);
    return LF_OK;
}

static bool get_layout(reading c, lf_film_layout *out, float sky[3])
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

lf_status lf_film_identity_read(int fd, lf_film *out, uint32_t *heads, lf_error *err)
{
    unsigned char layout_bytes[LAYOUT_BYTES];
    const lf_film_part parts[] = {
        {.name = "PICT", .made = out->picture, .n_made = sizeof out->picture},
        {.name = "LAYO", .made = layout_bytes, .n_made = sizeof layout_bytes}};
    lf_status status = read_start(fd, err);
    for (int i = 0; i < 2 && status == LF_OK; i++)
        status = read_next(fd, &parts[i], heads, err);
    if (status == LF_OK && !get_layout((reading){layout_bytes}, &out->layout, out->sky))
        return lf_error_set(err, LF_E_FORMAT, "state", "its layout is invalid");
    return status;
}

/* -------------------------------------------------------------------------- streams and rows -- */

static void put_counts(cursor *c, const lf_film_counts *counts)
{
    put_f64(c, counts->n[0]);
    put_f64(c, counts->n[1]);
    put_u32(c, counts->visits[0]);
    put_u32(c, counts->visits[1]);
}

static lf_film_counts get_counts(reading *c)
{
    lf_film_counts counts;
    for (int h = 0; h < 2; h++)
        counts.n[h] = get_f64(c);
    for (int h = 0; h < 2; h++)
        counts.visits[h] = get_u32(c);
    return counts;
}

size_t lf_film_stream_bytes(int height)
{
    return STREAM_BYTES + (size_t)height * COUNT_BYTES;
}

lf_status lf_film_stream_write(lf_outfile *file, const lf_film_stream *stream, int height,
                               uint32_t *heads, lf_error *err)
{
    uint64_t visits = 0;
    lf_film_part whole = {.name = "STRM", .n_made = lf_film_stream_bytes(height)};
    whole.made = lf_calloc(1, whole.n_made);
    if (!whole.made)
        return lf_error_set(err, LF_E_NOMEM, "state", "not enough memory to write it");
    cursor c = {whole.made};
    put_u64(&c, stream->seed);
    put_u32(&c, stream->number);
    for (int row = 0; row < height; row++) {
        put_counts(&c, &stream->rows[row]);
        visits += (uint64_t)stream->rows[row].visits[0] + stream->rows[row].visits[1];
    }
    lf_status status = visits > 0 ? lf_film_part_write(file, &whole, heads, err) : LF_OK;
    lf_free(whole.made);
    return status;
}

lf_status lf_film_stream_read(int fd, const unsigned char head[LF_FILM_HEAD_BYTES], int height,
                              lf_film_stream *out, lf_error *err)
{
    lf_film_part whole = {.name = "STRM", .n_made = lf_film_stream_bytes(height)};
    whole.made = lf_calloc(1, whole.n_made);
    lf_status status = whole.made ? lf_film_part_read(fd, head, &whole, err)
                                  : lf_error_set(err, LF_E_NOMEM, "state", "out of memory");
    if (status == LF_OK) {
        reading c = {whole.made};
        out->seed = get_u64(&c);
        out->number = get_u32(&c);
        for (int row = 0; row < height && status == LF_OK; row++) {
            out->rows[row] = get_counts(&c);
            if (!lf_film_counts_possible(&out->rows[row]))
                status = lf_error_set(err, LF_E_FORMAT, "state", "row %d has invalid counts", row);
        }
    }
    lf_free(whole.made);
    return status;
}

void lf_film_row_put(uint32_t number, const lf_film_row *row, unsigned char out[LF_FILM_ROW_BYTES])
{
    cursor c;
    c.p = out;
    put_u32(&c, number);
    put_u32(&c, row->met);
    put_f64(&c, row->passes);
    put_counts(&c, &(lf_film_counts){{row->n[0], row->n[1]}, {row->visits[0], row->visits[1]}});
    for (int h = 0; h < 2; h++)
        put_f64(&c, row->coarse[h]);
}

lf_film_row lf_film_row_get(const unsigned char bytes[LF_FILM_ROW_BYTES], uint32_t *out_number)
{
    reading c = {bytes};
    lf_film_row row = {.relative_error = -1.0};
    *out_number = get_u32(&c);
    row.met = get_u32(&c);
    row.passes = get_f64(&c);
    const lf_film_counts counts = get_counts(&c);
    for (int h = 0; h < 2; h++) {
        row.n[h] = counts.n[h];
        row.visits[h] = counts.visits[h];
        row.coarse[h] = get_f64(&c);
    }
    return row;
}

lf_status lf_film_end_write(lf_outfile *file, uint32_t heads, lf_error *err)
{
    unsigned char of_all[4];
    put_u32(&(cursor){of_all}, heads);
    const lf_film_part end = {.name = "END ", .made = of_all, .n_made = sizeof of_all};
    return lf_film_part_write(file, &end, &heads, err);
}

lf_status lf_film_end_read(int fd, const unsigned char head[LF_FILM_HEAD_BYTES], uint32_t heads,
                           lf_error *err)
{
    unsigned char of_all[4];
    char more;
    const lf_film_part end = {.name = "END ", .made = of_all, .n_made = sizeof of_all};
    lf_status status = lf_film_part_read(fd, head, &end, err);
    if (status == LF_OK && get_u32(&(reading){of_all}) != heads)
        return lf_error_set(err, LF_E_FORMAT, "state", "its parts do not belong together");
    return status != LF_OK || read(fd, &more, 1) == 0
               ? status
               : lf_error_set(err, LF_E_FORMAT, "state", "the file has data after its end");
}
