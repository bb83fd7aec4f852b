/* Pictures with what else their files say. All fail the running test when anything goes wrong. */
#ifndef LF_TESTS_BASE_SAID_H
#define LF_TESTS_BASE_SAID_H

#include "tests/base/pictures.h"

#include <fcntl.h>

static inline lf_image32 lf_picture_said(const char *path, lf_image_said *said)
{
    lf_image32 image = {0};
    lf_error err;
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_true(fd >= 0);
    lf_assert_ok(lf_image32_read_said(fd, path, &image, said, &err), &err);
    close(fd);
    return image;
}

static inline lf_image8 lf_codes_said(const char *path, lf_image_said *said)
{
    lf_image8 image = {0};
    lf_error err;
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_true(fd >= 0);
    lf_assert_ok(lf_image8_read_said(fd, path, &image, said, &err), &err);
    assert_int_equal(image.channels, 3);
    close(fd);
    return image;
}

/* NULL: nothing is told; else one line, with this word. */
static inline void lf_said_tells(const lf_image_said *said, const char *word)
{
    int length = (int)said->notes.length;
    size_t lines = 0;
    for (int i = 0; i < length; i++)
        lines += said->notes.text[i] == '\n';
    char text[LF_IMAGE_NOTES + 1];
    snprintf(text, sizeof text, "%.*s", length, said->notes.text);
    if (lines != (word ? 1 : 0) || (word && !strstr(text, word)))
        fail_msg("\"%s\" is told, and not %s", text, word ? word : "nothing");
}

/* The shape of pixels, and the orientation that was obeyed. */
static inline void lf_said_is(const lf_image_said *said, double pixel_aspect, int orientation)
{
    lf_assert_close(said->pixel_aspect, pixel_aspect, 0, 1e-6);
    assert_int_equal(said->orientation, orientation);
}

static inline void lf_pixel_is(const lf_image32 *image, int x, int y, const double rgb[3],
                               double tolerance)
{
    assert_true(x < image->width && y < image->height);
    for (int c = 0; c < 3; c++)
        lf_assert_close((double)image->data[3 * (y * image->width + x) + c], rgb[c], 0, tolerance);
}

#endif
