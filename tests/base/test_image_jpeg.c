/* Pictures as JPEG files. */
#include "tests/base/pictures.h"

#include "base/alloc.h"

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_jpeg_is_read_as_rgb),
        cmocka_unit_test(a_jpeg_that_is_cut_off_is_refused),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
