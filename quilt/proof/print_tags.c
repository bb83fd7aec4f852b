#include "quilt/proof/print_tags.h"

#include <errno.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

/* Directories of prints have about twenty tags; other programs add some. */
#define MAX_ENTRIES 512
/* Other resolutions are none of a printer. */
#define LEAST_DPI 1.0
#define MOST_DPI 1e5
/* More than LZW (4,094) and deflate (1,032) can expand a byte. */
#define MAX_GROWTH 4200

enum {
    TAG_WIDTH = 256,
    TAG_HEIGHT = 257,
    TAG_BITS = 258,
    TAG_COMPRESSION = 259,
    TAG_PHOTOMETRIC = 262,
    TAG_FILL_ORDER = 266,
    TAG_OFFSETS = 273,
    TAG_ORIENTATION = 274,
    TAG_SAMPLES = 277,
    TAG_ROWS = 278,
    TAG_COUNTS = 279,
    TAG_RIGHT = 282,
    TAG_DOWN = 283,
    TAG_PLANAR = 284,
    TAG_UNIT = 296,
    TAG_PREDICTOR = 317,
    TAG_PALETTE = 320,
    TAG_TILE_WIDTH = 322,
    TAG_INK_SET = 332,
    TAG_EXTRA = 338,
    TAG_SAMPLE_FORMAT = 339,
    TAG_ICC = 34675
};

typedef struct entry {
    int tag, type;
    lf_tiff_list values; /* bytes 0: a type of no whole numbers */
} entry;

static lf_status damaged(const lf_tiff *tiff, const char *what, lf_error *err)
{
    return lf_error_set(err, LF_E_FORMAT, tiff->where, "damaged TIFF: %s; write the file again",
                        what);
}

static uint64_t number_of(const lf_tiff *tiff, const uint8_t *bytes, int n)
{
    uint64_t number = 0;
    for (int i = 0; i < n; i++)
        number = number << 8 | bytes[tiff->tags.big_endian ? i : n - 1 - i];
    return number;
}

bool lf_tiff_bytes(const lf_tiff *tiff, uint64_t at, void *out, size_t n)
{
    if (at > tiff->size || n > tiff->size - at)
        return false;
    for (size_t done = 0; done < n;) {
        const ssize_t got = pread(tiff->fd, (char *)out + done, n - done, (off_t)(at + done));
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            return false;
        done += (size_t)got;
    }
    return true;
}

bool lf_tiff_element(const lf_tiff *tiff, const lf_tiff_list *list, uint64_t i, uint64_t *out)
{
    uint8_t bytes[8];
    if (tiff->is_pdf && i < list->count) {
        *out = list->at;
        return true;
    }
    if (i >= list->count || list->bytes == 0 ||
        !lf_tiff_bytes(tiff, list->at + i * (uint64_t)list->bytes, bytes, (size_t)list->bytes))
        return false;
    *out = number_of(tiff, bytes, list->bytes);
    return true;
}

/* ----------------------------------------------------------------------------------- entries -- */

/* Bytes of a value of a TIFF type; 0: unknown. */
static int bytes_of(int type)
{
    static const int bytes[] = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8};
    return type >= 0 && type < (int)(sizeof bytes / sizeof *bytes) ? bytes[type] : 0;
}

static bool is_whole(int type)
{
    return type == 1 || type == 3 || type == 4 || type == 7 || type == 16;
}

/* False: the values do not lie inside the file. */
static bool parse_entry(const lf_tiff *tiff, const uint8_t *bytes, uint64_t at, entry *out)
{
    const int count_bytes = tiff->tags.big ? 8 : 4;
    const uint64_t room = tiff->tags.big ? 8 : 4;
    const uint64_t count = number_of(tiff, bytes + 4, count_bytes);
    *out =
        (entry){.tag = (int)number_of(tiff, bytes, 2), .type = (int)number_of(tiff, bytes + 2, 2)};
    const int size = bytes_of(out->type);
    out->values = (lf_tiff_list){.count = count, .bytes = size};
    if (size == 0)
        return true;
    if (count > tiff->size / (uint64_t)size)
        return false;
    out->values.at = count * (uint64_t)size <= room
                         ? at + 4 + (uint64_t)count_bytes
                         : number_of(tiff, bytes + 4 + count_bytes, count_bytes);
    return out->values.at <= tiff->size && count * (uint64_t)size <= tiff->size - out->values.at;
}

/* Sets *out to a tag's single number, cut to what an int holds. */
static bool take_int(const lf_tiff *tiff, const entry *e, int *out)
{
    uint64_t value;
    if (!is_whole(e->type) || !lf_tiff_element(tiff, &e->values, 0, &value))
        return false;
    *out = value < INT32_MAX ? (int)value : INT32_MAX;
    return true;
}

/* The number that all values are; 0: they differ. */
static bool take_same(const lf_tiff *tiff, const entry *e, int *out)
{
    uint64_t first, other;
    if (e->values.count > 64 || !is_whole(e->type) || !lf_tiff_element(tiff, &e->values, 0, &first))
        return false;
    *out = first < INT32_MAX ? (int)first : INT32_MAX;
    for (uint64_t i = 1; i < e->values.count; i++)
        if (!lf_tiff_element(tiff, &e->values, i, &other))
            return false;
        else if (other != first)
            *out = 0;
    return true;
}

static bool take_fraction(const lf_tiff *tiff, const entry *e, uint32_t out[2])
{
    uint8_t bytes[8];
    if (e->type != 5 || e->values.count < 1 || !lf_tiff_bytes(tiff, e->values.at, bytes, 8))
        return false;
    out[0] = (uint32_t)number_of(tiff, bytes, 4);
    out[1] = (uint32_t)number_of(tiff, bytes + 4, 4);
    return true;
}

static bool take_list(const entry *e, lf_tiff_list *out)
{
    *out = e->values;
    return is_whole(e->type) && e->values.count > 0;
}

/* False: the tag has no usable value. */
static bool take(lf_tiff *tiff, const entry *e)
{
    lf_print_tags *t = &tiff->tags;
    switch (e->tag) {
    case TAG_WIDTH:
        return take_int(tiff, e, &t->width);
    case TAG_HEIGHT:
        return take_int(tiff, e, &t->height);
    case TAG_BITS:
        return take_same(tiff, e, &t->bits);
    case TAG_COMPRESSION:
        return take_int(tiff, e, &t->compression);
    case TAG_PHOTOMETRIC:
        return take_int(tiff, e, &t->photometric);
    case TAG_FILL_ORDER:
        return take_int(tiff, e, &t->fill_order);
    case TAG_OFFSETS:
        return take_list(e, &tiff->offsets);
    case TAG_ORIENTATION:
        return take_int(tiff, e, &t->orientation);
    case TAG_SAMPLES:
        return take_int(tiff, e, &t->samples);
    case TAG_ROWS:
        return take_int(tiff, e, &t->rows_per_strip);
    case TAG_COUNTS:
        return take_list(e, &tiff->byte_counts);
    case TAG_RIGHT:
    case TAG_DOWN:
        return take_fraction(tiff, e, t->resolution[e->tag - TAG_RIGHT]);
    case TAG_PLANAR:
        return take_int(tiff, e, &t->planar);
    case TAG_UNIT:
        return take_int(tiff, e, &t->unit);
    case TAG_PREDICTOR:
        return take_int(tiff, e, &t->predictor);
    case TAG_PALETTE:
        return t->palette = true;
    case TAG_TILE_WIDTH:
        return t->tiled = true;
    case TAG_INK_SET:
        return take_int(tiff, e, &t->ink_set);
    case TAG_EXTRA:
        t->extra_samples = e->values.count < 64 ? (int)e->values.count : 64;
        return true;
    case TAG_SAMPLE_FORMAT:
        return take_same(tiff, e, &t->sample_format);
    case TAG_ICC:
        tiff->icc_at = e->values.at;
        t->icc_bytes = e->values.bytes == 1 ? e->values.count : 0;
        return true;
    default:
        return true;
    }
}

/* --------------------------------------------------------------------------------- directory -- */

static lf_status read_head(lf_tiff *tiff, uint64_t *out_directory, lf_error *err)
{
    uint8_t head[16] = {0};
    const bool there = lf_tiff_bytes(tiff, 0, head, 8);
    tiff->tags.big_endian = head[0] == 'M';
    const uint64_t version = number_of(tiff, head + 2, 2);
    if (!there || head[0] != head[1] || (head[0] != 'I' && head[0] != 'M') ||
        (version != 42 && version != 43))
        return lf_error_set(err, LF_E_FORMAT, tiff->where,
                            "not a TIFF or PDF; give the print that quiltrender wrote");
    tiff->tags.big = version == 43;
    *out_directory = number_of(tiff, head + 4, 4);
    if (tiff->tags.big) {
        if (!lf_tiff_bytes(tiff, 0, head, 16) || number_of(tiff, head + 4, 2) != 8)
            return damaged(tiff, "its BigTIFF head", err);
        *out_directory = number_of(tiff, head + 8, 8);
    }
    return LF_OK;
}

static lf_status read_directory(lf_tiff *tiff, uint64_t at, lf_error *err)
{
    const int head = tiff->tags.big ? 8 : 2, size = tiff->tags.big ? 20 : 12;
    const int next_bytes = tiff->tags.big ? 8 : 4;
    uint8_t bytes[20];
    bool seen[TAG_SAMPLE_FORMAT + 2] = {false};
    if (!lf_tiff_bytes(tiff, at, bytes, (size_t)head))
        return damaged(tiff, "no directory", err);
    const uint64_t n = number_of(tiff, bytes, head);
    if (n < 1 || n > MAX_ENTRIES)
        return damaged(tiff, "the number of its tags", err);
    at += (uint64_t)head;
    for (uint64_t i = 0; i < n; i++, at += (uint64_t)size) {
        entry e;
        if (!lf_tiff_bytes(tiff, at, bytes, (size_t)size))
            return damaged(tiff, "its directory ends early", err);
        const bool inside = parse_entry(tiff, bytes, at, &e);
        const int slot = e.tag <= TAG_SAMPLE_FORMAT ? e.tag
                         : e.tag == TAG_ICC         ? TAG_SAMPLE_FORMAT + 1
                                                    : -1;
        if (slot < 0)
            continue;
        if (!inside || seen[slot] || !take(tiff, &e))
            return lf_error_set(err, LF_E_FORMAT, tiff->where,
                                "damaged TIFF: tag %d; write the file again", e.tag);
        seen[slot] = true;
    }
    tiff->tags.more_pages = lf_tiff_bytes(tiff, at, bytes, (size_t)next_bytes) &&
                            number_of(tiff, bytes, next_bytes) != 0;
    return LF_OK;
}

/* ------------------------------------------------------------------------------------- sense -- */

static void set_dpi(lf_print_tags *t)
{
    for (int i = 0; i < 2; i++)
        if (t->resolution[i][1] > 0 && (t->unit == 2 || t->unit == 3)) {
            const double dpi =
                (double)t->resolution[i][0] / t->resolution[i][1] * (t->unit == 3 ? 2.54 : 1.0);
            t->dpi[i] = dpi >= LEAST_DPI && dpi <= MOST_DPI ? dpi : 0.0;
        }
}

static lf_status check_strips(lf_tiff *tiff, lf_error *err)
{
    lf_print_tags *t = &tiff->tags;
    if (t->rows_per_strip < 1 || t->rows_per_strip > t->height)
        t->rows_per_strip = t->height;
    t->n_strips = (t->height - 1) / t->rows_per_strip + 1;
    if (t->tiled || t->planar != 1)
        return LF_OK;
    if (tiff->offsets.count != (uint64_t)t->n_strips ||
        tiff->byte_counts.count != (uint64_t)t->n_strips)
        return damaged(tiff, "the number of its strips", err);
    return LF_OK;
}

static lf_status check(lf_tiff *tiff, lf_error *err)
{
    lf_print_tags *t = &tiff->tags;
    if (t->width < 1 || t->height < 1)
        return damaged(tiff, "no size", err);
    if (t->width > LF_PRINT_FILE_MAX_SIDE || t->height > LF_PRINT_FILE_MAX_SIDE)
        return lf_error_set(err, LF_E_FORMAT, tiff->where,
                            "has more than %d pixels a side; no printer takes it",
                            LF_PRINT_FILE_MAX_SIDE);
    if (t->samples < 1 || t->samples > 64 || t->bits < 0 || t->bits > 64)
        return damaged(tiff, "its samples", err);
    if (t->icc_bytes > LF_PRINT_FILE_MAX_PROFILE)
        return lf_error_set(err, LF_E_FORMAT, tiff->where,
                            "has a colour profile of over 16 MiB; embed a smaller one");
    const double raster =
        (double)t->width * t->height * t->samples * (t->bits > 0 ? t->bits : 1) / 8;
    if (raster > (double)tiff->size * (t->compression == 1 ? 1 : MAX_GROWTH))
        return damaged(tiff, "it is shorter than its pixels", err);
    set_dpi(t);
    return check_strips(tiff, err);
}

lf_status lf_tiff_read(lf_tiff *tiff, lf_error *err)
{
    uint64_t directory = 0;
    tiff->tags = (lf_print_tags){.samples = 1,
                                 .bits = 1,
                                 .ink_set = 1,
                                 .compression = 1,
                                 .predictor = 1,
                                 .planar = 1,
                                 .orientation = 1,
                                 .sample_format = 1,
                                 .fill_order = 1,
                                 .unit = 2,
                                 .file_bytes = tiff->size};
    lf_status status = read_head(tiff, &directory, err);
    if (status == LF_OK)
        status = read_directory(tiff, directory, err);
    return status == LF_OK ? check(tiff, err) : status;
}
