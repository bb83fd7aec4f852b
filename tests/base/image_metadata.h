/* Pictures with what else their files say. All fail the running test when anything goes wrong. */
#ifndef LF_TESTS_BASE_IMAGE_METADATA_H
#define LF_TESTS_BASE_IMAGE_METADATA_H

#include "tests/base/pictures.h"

#include <fcntl.h>

static inline lf_image32 lf_picture_metadata(const char *path, lf_image_metadata *meta)
{
    lf_image32 image = {0};
    lf_error err;
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_true(fd >= 0);
    lf_assert_ok(lf_image32_read_metadata(fd, path, &image, meta, &err), &err);
    close(fd);
    return image;
}

static inline lf_image8 lf_codes_metadata(const char *path, lf_image_metadata *meta)
{
    lf_image8 image = {0};
    lf_error err;
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_true(fd >= 0);
    lf_assert_ok(lf_image8_read_metadata(fd, path, &image, meta, &err), &err);
    assert_int_equal(image.channels, 3);
    close(fd);
    return image;
}

/* NULL: nothing is told; else one line, with this word. */
static inline void lf_metadata_notes(const lf_image_metadata *meta, const char *word)
{
    int length = (int)meta->notes.length;
    size_t lines = 0;
    for (int i = 0; i < length; i++)
        lines += meta->notes.text[i] == '\n';
    char text[LF_IMAGE_NOTES + 1];
    snprintf(text, sizeof text, "%.*s", length, meta->notes.text);
    if (lines != (word ? 1 : 0) || (word && !strstr(text, word)))
        fail_msg("\"%s\" is told, and not %s", text, word ? word : "nothing");
}

/* The shape of pixels, and the orientation that was obeyed. */
static inline void lf_metadata_is(const lf_image_metadata *meta, double pixel_aspect,
                                  int orientation)
{
    lf_assert_close(meta->pixel_aspect, pixel_aspect, 0, 1e-6);
    assert_int_equal(meta->orientation, orientation);
}

static inline void lf_pixel_is(const lf_image32 *image, int x, int y, const double rgb[3],
                               double tolerance)
{
    assert_true(x < image->width && y < image->height);
    for (int c = 0; c < 3; c++)
        lf_assert_close((double)image->data[3 * (y * image->width + x) + c], rgb[c], 0, tolerance);
}

#endif
