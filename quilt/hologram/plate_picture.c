/* Pictures of a plate as files: PNG, 16-bit TIFF, EXR with halfs. */
#include <assert.h>
#include <string.h>

#include "base/alloc.h"
#include "base/version.h"
#include "quilt/hologram/plate.h"

#define PNG_LEVEL 4

/* -------------------------------------------------------------------------------------- TIFF -- */

/* A little-endian TIFF without compression, whose pixels follow its directory. */
enum {
    TIFF_SHORT = 3,
    TIFF_LONG = 4,
    TIFF_ASCII = 2,
    TIFF_ENTRIES = 11,
    TIFF_BITS = 8 + 2 + 12 * TIFF_ENTRIES + 4, /* values that do not fit into an entry */
    TIFF_TEXT = TIFF_BITS + 6,
    TIFF_TEXT_BYTES = 32,
    TIFF_HEAD = TIFF_TEXT + TIFF_TEXT_BYTES,
};

static void put(uint32_t value, int bytes, uint8_t *out)
{
    for (int i = 0; i < bytes; i++)
        out[i] = (uint8_t)(value >> 8 * i & 0xff);
}

static uint8_t *put_entry(uint8_t *at, int tag, int type, int n, uint32_t value)
{
    put((uint32_t)tag, 2, at);
    put((uint32_t)type, 2, at + 2);
    put((uint32_t)n, 4, at + 4);
    put(value, 4, at + 8);
    return at + 12;
}

static lf_status write_tiff(lf_outfile *file, int width, int height, int channels,
                            const uint8_t *samples, lf_error *err)
{
    const size_t bytes = (size_t)width * (size_t)height * (size_t)channels * 2;
    static const char program[] = "quiltd " LF_VERSION;
    uint8_t head[TIFF_HEAD] = "II*\0\10";
    static_assert(sizeof program > 4 && sizeof program <= TIFF_TEXT_BYTES, "it has its place");
    if (bytes > UINT32_MAX - TIFF_HEAD)
        return lf_error_set(err, LF_E_ARG, file->path, "is too large for a TIFF; use exr");
    put(TIFF_ENTRIES, 2, head + 8);
    uint8_t *at = head + 10;
    at = put_entry(at, 256, TIFF_LONG, 1, (uint32_t)width);
    at = put_entry(at, 257, TIFF_LONG, 1, (uint32_t)height);
    at = put_entry(at, 258, TIFF_SHORT, channels, channels == 1 ? 16 : TIFF_BITS);
    at = put_entry(at, 259, TIFF_SHORT, 1, 1);                     /* no compression */
    at = put_entry(at, 262, TIFF_SHORT, 1, channels == 1 ? 1 : 2); /* grey from black, or RGB */
    at = put_entry(at, 273, TIFF_LONG, 1, TIFF_HEAD);
    at = put_entry(at, 274, TIFF_SHORT, 1, 1); /* top left */
    at = put_entry(at, 277, TIFF_SHORT, 1, (uint32_t)channels);
    at = put_entry(at, 278, TIFF_LONG, 1, (uint32_t)height); /* one strip */
    at = put_entry(at, 279, TIFF_LONG, 1, (uint32_t)bytes);
    at = put_entry(at, 305, TIFF_ASCII, (int)sizeof program, TIFF_TEXT);
    put(0, 4, at);
    for (int i = 0; i < 3; i++)
        put(16, 2, head + TIFF_BITS + 2 * i);
    memcpy(head + TIFF_TEXT, program, sizeof program);
    const lf_status status = lf_outfile_write(file, head, sizeof head, err);
    return status == LF_OK ? lf_outfile_write(file, samples, bytes, err) : status;
}

/* --------------------------------------------------------------------------------------- EXR -- */

typedef struct half_picture {
    size_t row; /* samples */
    const uint8_t *samples;
} half_picture;

static void fill_row(void *context, int y, float *row)
{
    const half_picture *picture = context;
    const uint8_t *from = picture->samples + 2 * picture->row * (size_t)y;
    for (size_t i = 0; i < picture->row; i++)
        row[i] = lf_plate_half_value((uint16_t)(from[2 * i] | from[2 * i + 1] << 8));
}

static lf_status write_exr(lf_outfile *file, int width, int height, int n_channels,
                           const uint8_t *samples, lf_error *err)
{
    static const char *const rgb[] = {"R", "G", "B"}, *const grey[] = {"Y"};
    half_picture picture = {(size_t)width * (size_t)n_channels, samples};
    const lf_channels32 channels = {.names = n_channels == 1 ? grey : rgb,
                                    .n = n_channels,
                                    .rows = fill_row,
                                    .context = &picture,
                                    .is_half = true};
    return lf_exr_write_channels(file, width, height, &channels, NULL, 0, err);
}

/* --------------------------------------------------------------------------------------- all -- */

typedef struct byte_picture {
    size_t row;
    const uint8_t *samples;
} byte_picture;

static void copy_row(void *context, int y, uint8_t *row)
{
    const byte_picture *picture = context;
    memcpy(row, picture->samples + picture->row * (size_t)y, picture->row);
}

static lf_status write_png(lf_outfile *file, int width, int height, const uint8_t *samples,
                           lf_error *err)
{
    byte_picture picture = {3 * (size_t)width, samples};
    return lf_png_write_rows(file, width, height, copy_row, &picture, PNG_LEVEL, NULL, 0, err);
}

lf_status lf_plate_picture_write(const lf_plate *plate, const char *path, int width, int height,
                                 const uint8_t *samples, lf_error *err)
{
    const int channels = plate->is_grey ? 1 : 3;
    lf_outfile file;
    lf_status status = lf_outfile_open(&file, path, true, err);
    if (status != LF_OK)
        return status;
    status =
        plate->format == LF_PLATE_TIFF  ? write_tiff(&file, width, height, channels, samples, err)
        : plate->format == LF_PLATE_EXR ? write_exr(&file, width, height, channels, samples, err)
                                        : write_png(&file, width, height, samples, err);
    if (status == LF_OK)
        return lf_outfile_commit(&file, true, err);
    lf_outfile_abandon(&file);
    return status;
}
