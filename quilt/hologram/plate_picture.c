/* Pictures of a plate as files: PNG, EXR with halfs, and 16-bit TIFF of plate_tiff.c. */
#include <string.h>

#include "quilt/hologram/plate.h"

#define PNG_LEVEL 4

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
    status = plate->format == LF_PLATE_TIFF
                 ? lf_plate_tiff_write(plate, &file, width, height, samples, err)
             : plate->format == LF_PLATE_EXR
                 ? write_exr(&file, width, height, channels, samples, err)
                 : write_png(&file, width, height, samples, err);
    if (status == LF_OK)
        return lf_outfile_commit(&file, true, err);
    lf_outfile_abandon(&file);
    return status;
}
