#include "base/sandbox/raster.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/image_io.h"
#include "base/sandbox/import.h"

static lf_status check_floats(const lf_raster *picture, lf_error *err)
{
    size_t n = 3 * (size_t)picture->width * (size_t)picture->height;
    for (size_t i = 0; i < n; i++)
        if (!isfinite(picture->data32[i]))
            return lf_error_set(err, LF_E_FORMAT, "",
                                "the reader's answer has a pixel that is not a finite number");
    return LF_OK;
}

static void take_depth(lf_raster *out)
{
    size_t n;
    const double *numbers = lf_parcel_get(&out->parcel, LF_PARCEL_DEPTH, &n);
    lf_image_depth depth;
    static_assert(sizeof depth == LF_IMAGE_DEPTH_NUMBERS * sizeof *numbers, "only numbers");
    if (n != LF_IMAGE_DEPTH_NUMBERS)
        return;
    memcpy(&depth, numbers, sizeof depth);
    if (lf_image_depth_is_valid(&depth))
        out->meta.depth = depth;
}

/* Takes the pixels of *out's parcel, which is untrusted. */
static lf_status take_pixels(lf_raster *out, lf_error *err)
{
    size_t n, n8, n32, n_notes;
    const int64_t *shape = lf_parcel_get(&out->parcel, LF_PARCEL_SHAPE, &n);
    out->data8 = lf_parcel_get(&out->parcel, LF_PARCEL_PIXELS8, &n8);
    out->data32 = lf_parcel_get(&out->parcel, LF_PARCEL_PIXELS32, &n32);
    if (n < 2 || n > 6 || !out->data8 == !out->data32 || shape[0] < 1 ||
        shape[0] > LF_IMAGE_MAX_SIDE || shape[1] < 1 || shape[1] > LF_IMAGE_MAX_SIDE ||
        (uint64_t)(3 * shape[0] * shape[1]) != n8 + n32)
        return lf_error_set(err, LF_E_FORMAT, "", "the reader's answer has no image");
    out->width = (int)shape[0];
    out->height = (int)shape[1];
    if (n >= 3 && shape[2] == LF_IMAGE_CUBE && shape[1] == 6 * shape[0])
        out->meta.layout = LF_IMAGE_CUBE;
    if (n >= 4 && shape[3] >= 10000 && shape[3] <= 100000000)
        out->meta.pixel_aspect = (double)shape[3] / 1e6;
    if (n >= 5 && shape[4] > 0 && shape[4] <= LF_IMAGE_MAX_FOCAL)
        out->meta.focal_35mm = (int)shape[4];
    if (n == 6 && shape[5] > 0 && shape[5] <= LF_IMAGE_MAX_RATE * INT64_C(1000000))
        out->meta.frame_rate = (double)shape[5] / 1e6;
    take_depth(out);
    const char *notes = lf_parcel_get(&out->parcel, LF_PARCEL_WARNINGS, &n_notes);
    lf_image_note_lines(&out->meta.notes, notes, n_notes);
    return out->data32 ? check_floats(out, err) : LF_OK;
}

static lf_status import(int fd, const char *path, bool floats, bool on_white, lf_raster *out,
                        lf_error *err)
{
    lf_import_request request = {.kind = LF_IMPORT_PICTURE, .floats = floats, .on_white = on_white};
    lf_raster picture = {0};
    lf_error wrong;
    /* only for messages: the file is open already */
    snprintf(request.path, sizeof request.path, "%s", path);
    lf_status status = lf_import_run(&request, fd, path, NULL, NULL, &picture.parcel, err);
    if (status != LF_OK)
        return status;
    status = take_pixels(&picture, &wrong);
    if (status == LF_OK && floats && !picture.data32)
        status = lf_error_set(&wrong, LF_E_FORMAT, "",
                              "the reader's answer has no floating-point pixels");
    if (status != LF_OK) {
        lf_raster_close(&picture);
        return lf_error_set(err, status, path, "%s", wrong.what);
    }
    *out = picture;
    return LF_OK;
}

lf_status lf_raster_import(int fd, const char *path, bool floats, lf_raster *out, lf_error *err)
{
    return import(fd, path, floats, false, out, err);
}

static lf_status open_file(const char *path, const lf_roots *roots, bool floats, bool on_white,
                           lf_raster *out, lf_error *err)
{
    int fd;
    lf_status status = lf_file_open(path, roots, LF_IMAGE_MAX_BYTES, &fd, NULL, err);
    if (status != LF_OK)
        return status;
    status = import(fd, path, floats, on_white, out, err);
    close(fd);
    return status;
}

lf_status lf_raster_open(const char *path, const lf_roots *roots, bool floats, lf_raster *out,
                         lf_error *err)
{
    return open_file(path, roots, floats, false, out, err);
}

lf_status lf_raster_open_on_white(const char *path, const lf_roots *roots, lf_raster *out,
                                  lf_error *err)
{
    return open_file(path, roots, false, true, out, err);
}

void lf_raster_close(lf_raster *picture)
{
    lf_parcel_close(&picture->parcel);
    *picture = (lf_raster){0};
}
