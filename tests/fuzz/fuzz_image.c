/* Any bytes as a picture, which quiltimport-picture reads, and quiltimport for surfaces: refused in
 * words, or a picture within the limits, of finite numbers where they are floats. */
#include "tests/fuzz/fuzz.h"

#include <math.h>

#include "base/alloc.h"
#include "base/image_io.h"
#include "base/image_rgba.h"

static void check_shape(int width, int height, int channels)
{
    lf_fuzz_require(width >= 1 && width <= LF_IMAGE_MAX_SIDE);
    lf_fuzz_require(height >= 1 && height <= LF_IMAGE_MAX_SIDE);
    lf_fuzz_require(channels == 3);
}

static void check_refusal(const lf_error *err)
{
    lf_fuzz_require(err->what[0] != 0);
    lf_fuzz_require_text(err->what);
}

static void check_said(const lf_image_metadata *meta, int width, int height)
{
    char line[512];
    for (size_t at = 0; lf_image_notes_next(&meta->notes, &at, line, sizeof line);) {
        lf_fuzz_require(line[0] != 0);
        lf_fuzz_require_text(line);
    }
    lf_fuzz_require(meta->layout == LF_IMAGE_PLAIN ||
                    (meta->layout == LF_IMAGE_CUBE && height == 6 * width));
}

static unsigned read8(int fd)
{
    lf_image8 picture = {0};
    lf_image_metadata meta;
    lf_error err = {0};
    unsigned sum = 0;
    if (lf_image8_read_metadata(fd, "fuzz", &picture, &meta, &err) != LF_OK) {
        check_refusal(&err);
        return 0;
    }
    check_shape(picture.width, picture.height, picture.channels);
    check_said(&meta, picture.width, picture.height);
    lf_fuzz_require(picture.stride >= 3 * (size_t)picture.width);
    for (int y = 0; y < picture.height; y++)
        for (int i = 0; i < 3 * picture.width; i++)
            sum += picture.data[(size_t)y * picture.stride + (size_t)i];
    lf_image8_finish(&picture);
    return sum;
}

static void read32(int fd)
{
    lf_image32 picture = {0};
    lf_image_metadata meta;
    lf_error err = {0};
    if (lf_image32_read_metadata(fd, "fuzz", &picture, &meta, &err) != LF_OK) {
        check_refusal(&err);
        return;
    }
    check_shape(picture.width, picture.height, picture.channels);
    check_said(&meta, picture.width, picture.height);
    for (size_t i = 0; i < 3 * (size_t)picture.width * (size_t)picture.height; i++)
        lf_fuzz_require(isfinite(picture.data[i]));
    lf_image32_finish(&picture);
}

static unsigned read_rgba(const uint8_t *data, size_t size)
{
    uint8_t *rgba = NULL;
    int width = 0, height = 0;
    lf_error err = {0};
    unsigned sum = 0;
    if (lf_image_rgba_decode(data, size, "fuzz", &rgba, &width, &height, &err) != LF_OK) {
        check_refusal(&err);
        return 0;
    }
    check_shape(width, height, 3);
    for (size_t i = 0; i < 4 * (size_t)width * (size_t)height; i++)
        sum += rgba[i];
    lf_free(rgba);
    return sum;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static volatile unsigned sum; /* every pixel is looked at */
    lf_image_kind kind;
    lf_error err = {0};
    int fd = lf_fuzz_file(data, size);
    sum = read_rgba(data, size);
    if (lf_image_probe_open(fd, "fuzz", &kind, &err) != LF_OK) {
        check_refusal(&err);
    } else {
        if (kind == LF_IMAGE_8BIT)
            sum = read8(fd);
        read32(fd);
    }
    close(fd);
    return 0;
}
