/* quiltimport-picture: reads skies, quilts and views. Separate from meshes, whose library is not
 * needed here, and because there may be one file per view. */
#include <math.h>

#include "base/image_io.h"
#include "base/sandbox/reader.h"

static lf_status put_metadata(lf_parcel_writer *parcel, int width, int height,
                              const lf_image_metadata *meta, lf_error *err)
{
    const int64_t shape[] = {width,
                             height,
                             meta->layout,
                             llround(meta->pixel_aspect * 1e6),
                             meta->focal_35mm,
                             llround(meta->frame_rate * 1e6)};
    lf_status status = lf_parcel_put(parcel, LF_PARCEL_SHAPE, shape, 6, err);
    if (status == LF_OK && lf_image_depth_is_valid(&meta->depth))
        status = lf_parcel_put(parcel, LF_PARCEL_DEPTH, &meta->depth, LF_IMAGE_DEPTH_NUMBERS, err);
    return status == LF_OK ? lf_parcel_put(parcel, LF_PARCEL_WARNINGS, meta->notes.text,
                                           meta->notes.length, err)
                           : status;
}

static lf_status read_floats(int fd, lf_parcel_writer *parcel, lf_error *err)
{
    lf_image32 image = {0};
    lf_image_metadata meta;
    lf_status status = lf_image32_read_metadata(fd, LF_HERE, &image, &meta, err);
    if (status == LF_OK)
        status = put_metadata(parcel, image.width, image.height, &meta, err);
    if (status == LF_OK)
        status = lf_parcel_put(parcel, LF_PARCEL_PIXELS32, image.data,
                               3 * (size_t)image.width * (size_t)image.height, err);
    lf_image32_finish(&image);
    return status;
}

static lf_status read_bytes(int fd, bool on_white, lf_parcel_writer *parcel, lf_error *err)
{
    lf_image8 image = {0};
    lf_image_metadata meta;
    lf_status status = on_white ? lf_image8_read_on_white(fd, LF_HERE, &image, &meta, err)
                                : lf_image8_read_metadata(fd, LF_HERE, &image, &meta, err);
    if (status == LF_OK)
        status = put_metadata(parcel, image.width, image.height, &meta, err);
    for (int y = 0; y < image.height && status == LF_OK; y++)
        status = lf_parcel_append(parcel, LF_PARCEL_PIXELS8, image.data + (size_t)y * image.stride,
                                  3 * (size_t)image.width, err);
    lf_image8_finish(&image);
    return status;
}

static lf_status read_picture(const lf_import_request *request, int fd, lf_parcel_writer *parcel,
                              lf_error *err)
{
    lf_image_kind kind;
    lf_status status = lf_image_probe_open(fd, LF_HERE, &kind, err);
    if (status != LF_OK)
        return status;
    return request->floats || kind == LF_IMAGE_FLOAT
               ? read_floats(fd, parcel, err)
               : read_bytes(fd, request->on_white, parcel, err);
}

int main(void)
{
    return lf_reader_main(&(lf_import_reader){.read = read_picture});
}
