/* What files that were written say of their picture, and whether two are the same picture. */
#ifndef LF_TESTS_DAEMON_WRITTEN_H
#define LF_TESTS_DAEMON_WRITTEN_H

#include <string.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/image_io.h"
#include "tests/testing.h"

/* Whether a PNG, an EXR or the manifest of a print was made of the reconstructed picture. */
static inline bool written_reconstructed(const char *path)
{
    char *text = NULL;
    size_t n = 0;
    lf_error err = {0};
    lf_assert_ok(lf_file_read(path, NULL, 1 << 24, &text, &n, &err), &err);
    const char *end = text + n, *at = memmem(text, n, "reconstruct", 11);
    at = at ? at + 11 : NULL;
    while (at && end - at > 3 && strncmp(at, "on", 2) != 0 && strncmp(at, "off", 3) != 0)
        at++;
    const bool is_on = at && strncmp(at, "on", 2) == 0;
    if (!at || end - at <= 3)
        fail_msg("%s does not say whether it is reconstructed", path);
    lf_free(text);
    return is_on;
}

/* The largest difference of two PNG pictures of one size, in codes. */
static inline int written_difference(const char *a, const char *b)
{
    char other[PATH_MAX]; /* lf_test_path forgets */
    lf_image8 x = {0}, y = {0};
    lf_error err = {0};
    int most = 0;
    snprintf(other, sizeof other, "%s", b);
    lf_assert_ok(lf_image8_read(a, NULL, &x, &err), &err);
    lf_assert_ok(lf_image8_read(other, NULL, &y, &err), &err);
    assert_int_equal(x.width, y.width);
    assert_int_equal(x.height, y.height);
    for (size_t row = 0; row < (size_t)x.height; row++)
        for (size_t i = 0; i < (size_t)x.width * 3; i++) {
            int d = abs(x.data[row * x.stride + i] - y.data[row * y.stride + i]);
            most = d > most ? d : most;
        }
    lf_image8_finish(&x);
    lf_image8_finish(&y);
    return most;
}

#endif
