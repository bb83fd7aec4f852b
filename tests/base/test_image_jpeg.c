/* Pictures as JPEG files. */
#include "tests/base/pictures.h"

#include <math.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/file.h"

static void a_jpeg_is_read_as_rgb(void **state)
{
    const char *path = lf_test_path(*state, "a.jpg");
    for (int components = 1; components <= 3; components += 2) {
        lf_picture_jpeg(path, 90, 70, components, components == 1 ? JCS_GRAYSCALE : JCS_RGB);
        lf_image8 image = lf_picture_load8(path);
        assert_int_equal(image.width, 90);
        assert_int_equal(image.height, 70);
        for (int i = 0; i < 90 * 70; i++)
            for (int c = 0; c < 3; c++)
                lf_assert_close(
                    image.data[3 * i + c],
                    255 * (double)lf_picture_smooth(i % 90, i / 90, components == 1 ? 0 : c), 0, 6);
        lf_image8_finish(&image);
    }
}

static void a_jpeg_that_is_cut_off_is_refused(void **state)
{
    const char *path = lf_test_path(*state, "a.jpg");
    lf_picture_jpeg(path, 90, 70, 3, JCS_RGB);
    size_t n;
    char *data = lf_picture_bytes(path, &n);
    lf_picture_write(path, data, n / 2);
    lf_picture_refused(path, "JPEG");
    lf_free(data);
}

/* ------------------------------------------------------------------------------------- write -- */

static void row_of(void *context, int y, uint8_t *out)
{
    const int width = *(const int *)context;
    for (int x = 0; x < width; x++)
        for (int c = 0; c < 3; c++)
            out[3 * x + c] = (uint8_t)lround(255 * (double)lf_picture_smooth(x, y, c));
}

/* The mean error of what is read back, in codes. */
static double error_of(const char *path, int width, int height, int quality)
{
    lf_outfile file = {.fd = -1};
    lf_error err = {0};
    uint8_t *row = lf_calloc((size_t)width, 3);
    double sum = 0;
    assert_non_null(row);
    lf_assert_ok(lf_outfile_open(&file, path, true, &err), &err);
    lf_assert_ok(lf_jpeg_write_rows(&file, width, height, row_of, &width, quality, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
    lf_image8 image = lf_picture_load8(path);
    assert_int_equal(image.width, width);
    assert_int_equal(image.height, height);
    for (int y = 0; y < height; y++) {
        row_of(&width, y, row);
        for (int i = 0; i < 3 * width; i++)
            sum += abs(image.data[3 * y * width + i] - row[i]);
    }
    lf_image8_finish(&image);
    lf_free(row);
    return sum / (3.0 * width * height);
}

static void what_is_written_is_read_back(void **state)
{
    const char *path = lf_test_path(*state, "w.jpg");
    assert_true(error_of(path, 90, 70, LF_JPEG_QUALITY) < 1.5);
    assert_true(error_of(path, 1, 1, LF_JPEG_QUALITY) < 3);
    const double good = error_of(path, 301, 211, 100), bad = error_of(path, 301, 211, 5);
    assert_true(good < 1 && bad > 2 * good); /* more than libjpeg's buffer, odd sides */
}

static void what_no_jpeg_can_be_is_refused(void **state)
{
    static const int cases[][3] = {{65501, 1, 92}, {1, 65501, 92}, {4, 4, 0}, {4, 4, 101}};
    const char *path = lf_test_path(*state, "no.jpg");
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        lf_outfile file = {.fd = -1};
        lf_error err = {0};
        int width = cases[i][0];
        lf_assert_ok(lf_outfile_open(&file, path, true, &err), &err);
        assert_int_equal(
            lf_jpeg_write_rows(&file, width, cases[i][1], row_of, &width, cases[i][2], &err),
            LF_E_ARG);
        assert_non_null(strstr(err.what, "cannot write a JPEG"));
        lf_outfile_abandon(&file);
    }
    assert_true(access(path, F_OK) != 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_jpeg_is_read_as_rgb),
        cmocka_unit_test(a_jpeg_that_is_cut_off_is_refused),
        cmocka_unit_test(what_is_written_is_read_back),
        cmocka_unit_test(what_no_jpeg_can_be_is_refused),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
