#include "base/image_rgba.h"

#include <string.h>

#include "base/image_formats.h"

static const lf_image_format *const formats[] = {&lf_format_png, &lf_format_jpeg, &lf_format_webp};

static const char ktx2[] = "\xabKTX 20\xbb\r\n\x1a\n";

/* NULL: unknown format. */
static const lf_image_format *format_of(const uint8_t *data, size_t size)
{
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
        if (formats[i]->recognises(data, size))
            return formats[i];
    return NULL;
}

static bool is_ktx2(const void *data, size_t size)
{
    return size >= sizeof ktx2 - 1 && memcmp(data, ktx2, sizeof ktx2 - 1) == 0;
}

lf_status lf_image_rgba_decode(const void *data, size_t size, const char *where, uint8_t **out_rgba,
                               int *out_width, int *out_height, lf_error *err)
{
    lf_image_source source = {
        .fd = -1, .size_bytes = size, .where = where, .data = data, .channels = 4};
    lf_image8 image = {0};
    if (size > LF_IMAGE_MAX_BYTES)
        return lf_error_set(err, LF_E_FORMAT, where, "the image has more than 4 GiB");
    const lf_image_format *format = format_of(data, size);
    if (!format)
        return lf_error_set(err, LF_E_FORMAT, where,
                            is_ktx2(data, size) ? "KTX2 images are not supported"
                                                : "not an image; expected PNG, JPEG or WebP");
    lf_status status = format->read8(&source, &image, err);
    if (status != LF_OK)
        return status;
    *out_rgba = image.data;
    *out_width = image.width;
    *out_height = image.height;
    return LF_OK;
}
