/* Rows of an image, filtered as in PNG files and compressed. */
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "base/alloc.h"
#include "quilt/print/pdf.h"

/* Of zlib: interlaced rows gain little from more. */
#define LEVEL 4

enum { PLAIN, LEFT, ABOVE, N_FILTERS };

/* The bytes of a row as the file has them: 16-bit values have their high byte first. */
static void big_endian(const unsigned char *pixels, size_t n, int bits, unsigned char *out)
{
    const uint16_t *values = (const void *)pixels;
    if (bits == 8)
        memcpy(out, pixels, n);
    else
        for (size_t i = 0; i < n / 2; i++) {
            out[2 * i] = (unsigned char)(values[i] >> 8);
            out[2 * i + 1] = (unsigned char)values[i];
        }
}

/* The sum of the differences that a filter leaves; the least compresses best as a rule. */
static uint64_t cost_of(int filter, const unsigned char *row, const unsigned char *above, size_t n,
                        size_t pixel)
{
    uint64_t sum = 0;
    if (filter == PLAIN)
        for (size_t i = 0; i < n; i++)
            sum += (unsigned)abs((int8_t)row[i]);
    else if (filter == LEFT)
        for (size_t i = pixel; i < n; i++)
            sum += (unsigned)abs((int8_t)(row[i] - row[i - pixel]));
    else
        for (size_t i = 0; i < n; i++)
            sum += (unsigned)abs((int8_t)(row[i] - above[i]));
    return sum;
}

static void apply(int filter, const unsigned char *row, const unsigned char *above, size_t n,
                  size_t pixel, unsigned char *out)
{
    *out++ = (unsigned char)filter;
    if (filter == PLAIN)
        memcpy(out, row, n);
    else if (filter == ABOVE)
        for (size_t i = 0; i < n; i++)
            out[i] = (unsigned char)(row[i] - above[i]);
    else
        for (size_t i = 0; i < n; i++)
            out[i] = (unsigned char)(row[i] - (i < pixel ? 0 : row[i - pixel]));
}

/* above: NULL in a strip's first row, because strips are independent. */
static void filter_row(const unsigned char *row, const unsigned char *above, size_t n, size_t pixel,
                       unsigned char *out)
{
    int best = PLAIN;
    uint64_t least = cost_of(PLAIN, row, above, n, pixel);
    for (int filter = LEFT; filter < (above ? N_FILTERS : ABOVE); filter++) {
        const uint64_t cost = cost_of(filter, row, above, n, pixel);
        if (cost < least) {
            least = cost;
            best = filter;
        }
    }
    apply(best, row, above, n, pixel, out);
}

/* Grows a buffer whose content is not kept. */
static bool make_room(unsigned char **data, size_t *room, size_t n)
{
    if (*room >= n)
        return true;
    lf_free(*data);
    *data = lf_calloc(n, 1);
    *room = *data ? n : 0;
    return *data;
}

/* rows: room for the filtered rows, then two plain ones. */
static void filter_rows(const lf_pdf_image *image, const unsigned char *pixels, int n_rows,
                        size_t row_bytes, unsigned char *rows)
{
    const size_t pixel = (size_t)image->channels * (size_t)image->bits / 8;
    unsigned char *plain[2];
    plain[0] = rows + (size_t)n_rows * (row_bytes + 1);
    plain[1] = plain[0] + row_bytes;
    for (int y = 0; y < n_rows; y++) {
        unsigned char *row = plain[y % 2];
        big_endian(pixels + (size_t)y * row_bytes, row_bytes, image->bits, row);
        filter_row(row, y > 0 ? plain[(y + 1) % 2] : NULL, row_bytes, pixel,
                   rows + (size_t)y * (row_bytes + 1));
    }
}

static bool start_deflate(lf_pdf_strip *strip)
{
    if (strip->deflate)
        return deflateReset(strip->deflate) == Z_OK;
    strip->deflate = lf_calloc(1, sizeof *strip->deflate);
    if (strip->deflate &&
        deflateInit2(strip->deflate, LEVEL, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY) == Z_OK)
        return true;
    lf_free(strip->deflate);
    strip->deflate = NULL;
    return false;
}

lf_status lf_pdf_strip_pack(const lf_pdf_image *image, const void *pixels, int rows, bool last,
                            lf_pdf_strip *strip)
{
    const size_t row_bytes =
        (size_t)image->width * (size_t)image->channels * (size_t)image->bits / 8;
    strip->raw = (size_t)rows * (row_bytes + 1);
    if (!make_room(&strip->rows, &strip->rows_room, strip->raw + 2 * row_bytes) ||
        !start_deflate(strip) ||
        /* a flush takes a few bytes more than the bound of a finished stream */
        !make_room(&strip->data, &strip->room,
                   deflateBound(strip->deflate, (uLong)strip->raw) + 64))
        return LF_E_NOMEM;
    filter_rows(image, pixels, rows, row_bytes, strip->rows);
    strip->check = (uint32_t)adler32_z(adler32(0, NULL, 0), strip->rows, strip->raw);
    strip->deflate->next_in = strip->rows;
    strip->deflate->avail_in = (uInt)strip->raw;
    strip->deflate->next_out = strip->data;
    strip->deflate->avail_out = (uInt)strip->room;
    const int end = deflate(strip->deflate, last ? Z_FINISH : Z_SYNC_FLUSH);
    strip->size = strip->room - strip->deflate->avail_out;
    return end == (last ? Z_STREAM_END : Z_OK) && strip->deflate->avail_in == 0 ? LF_OK
                                                                                : LF_E_NOMEM;
}

void lf_pdf_strip_finish(lf_pdf_strip *strip)
{
    if (strip->deflate)
        deflateEnd(strip->deflate);
    lf_free(strip->deflate);
    lf_free(strip->data);
    lf_free(strip->rows);
    *strip = (lf_pdf_strip){0};
}
