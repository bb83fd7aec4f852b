#include "base/image.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"

#define MAX_SIDE 65536
#define MAX_SAMPLES ((size_t)1 << 31)

static lf_status check_shape(int width, int height, int channels)
{
    if (width < 1 || width > MAX_SIDE || height < 1 || height > MAX_SIDE || channels < 1 ||
        channels > 4)
        return LF_E_ARG;
    if ((size_t)width * (size_t)height > MAX_SAMPLES / (size_t)channels)
        return LF_E_ARG;
    return LF_OK;
}

lf_status lf_image8_init(lf_image8 *image, int width, int height, int channels)
{
    lf_status status = check_shape(width, height, channels);
    if (status != LF_OK)
        return status;
    size_t stride = (size_t)width * (size_t)channels;
    uint8_t *data = lf_calloc((size_t)height, stride);
    if (!data)
        return LF_E_NOMEM;
    *image = (lf_image8){
        .width = width, .height = height, .channels = channels, .stride = stride, .data = data};
    return LF_OK;
}

lf_status lf_image32_init(lf_image32 *image, int width, int height, int channels)
{
    lf_status status = check_shape(width, height, channels);
    if (status != LF_OK)
        return status;
    float *data = lf_calloc((size_t)height * (size_t)width * (size_t)channels, sizeof *data);
    if (!data)
        return LF_E_NOMEM;
    *image = (lf_image32){.width = width, .height = height, .channels = channels, .data = data};
    return LF_OK;
}

void lf_image8_finish(lf_image8 *image)
{
    lf_free(image->data);
    *image = (lf_image8){0};
}

void lf_image32_finish(lf_image32 *image)
{
    lf_free(image->data);
    *image = (lf_image32){0};
}

void lf_orient(int orientation, const void *in, size_t in_stride, int width, int height,
               size_t pixel_bytes, void *out)
{
    const bool swaps = lf_orientation_swaps(orientation);
    const bool right = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8,
               down = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
    const int out_width = swaps ? height : width, out_height = swaps ? width : height;
    uint8_t *to = out;
    const size_t row_bytes = (size_t)out_width * pixel_bytes;
    for (int y = 0; y < out_height && orientation < 2; y++)
        memcpy(to + (size_t)y * row_bytes, (const uint8_t *)in + (size_t)y * in_stride, row_bytes);
    for (int y = 0; y < out_height && orientation >= 2; y++)
        for (int x = 0; x < out_width; x++, to += pixel_bytes) {
            const int column = swaps ? y : x, row = swaps ? x : y;
            const size_t at_x = (size_t)(right ? width - 1 - column : column),
                         at_y = (size_t)(down ? height - 1 - row : row);
            memcpy(to, (const uint8_t *)in + at_y * in_stride + at_x * pixel_bytes, pixel_bytes);
        }
}

void lf_srgb_light(float out[256])
{
    for (int i = 0; i < 256; i++) {
        double v = i / 255.0;
        out[i] = (float)(v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4));
    }
}
