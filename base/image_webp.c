#include <string.h>

#include <webp/decode.h>

#include "base/image_formats.h"

static bool recognises_webp(const uint8_t *head, size_t n)
{
    return n >= 12 && memcmp(head, "RIFF", 4) == 0 && memcmp(head + 8, "WEBP", 4) == 0;
}

static lf_status read_webp(const lf_image_source *source, lf_image8 *out, lf_error *err)
{
    WebPBitstreamFeatures features;
    lf_image8 image = {0};
    size_t size = (size_t)source->size_bytes;
    if (WebPGetFeatures(source->data, size, &features) != VP8_STATUS_OK)
        return lf_error_set(err, LF_E_FORMAT, source->where,
                            "WebP: the file is damaged or cut off");
    if (features.has_animation)
        return lf_error_set(err, LF_E_FORMAT, source->where,
                            "WebP: animations are not supported; save one frame");
    lf_status status = lf_image_check_shape(source, features.width, features.height, 4, err);
    if (status != LF_OK)
        return status;
    status = lf_image8_init(&image, features.width, features.height, 4);
    if (status != LF_OK)
        return lf_error_set(err, status, source->where, "not enough memory for the image");
    if (!WebPDecodeRGBAInto(source->data, size, image.data, image.stride * (size_t)image.height,
                            (int)image.stride)) {
        lf_image8_finish(&image);
        return lf_error_set(err, LF_E_FORMAT, source->where,
                            "WebP: the file is damaged or cut off");
    }
    *out = image;
    return LF_OK;
}

static const char *const endings[] = {".webp", NULL};

const lf_image_format lf_format_webp = {.name = "WebP",
                                        .endings = endings,
                                        .kind = LF_IMAGE_8BIT,
                                        .recognises = recognises_webp,
                                        .read8 = read_webp};
