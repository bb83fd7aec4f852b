/* Pictures as Radiance HDR files. */
#include "tests/base/pictures.h"

static void flat_hdr_pixels_are_shared_exponents(void **state)
{
    const char *path = lf_test_path(*state, "a.hdr");
    char data[256];
    size_t n = lf_picture_hdr_header(data, "-Y 1 +X 4", "");
    const unsigned char pixels[] = {128, 64, 0,  129, 255, 1,   2,  128,
                                    10,  20, 30, 0,   200, 100, 50, 140};
    memcpy(data + n, pixels, sizeof pixels);
    lf_picture_write(path, data, n + sizeof pixels);
    lf_image32 image = lf_picture_load32(path);
    const float expected[] = {1, 0.5f, 0, 255 / 256.0f, 1 / 256.0f,  2 / 256.0f,
                              0, 0,    0, 200 * 16.0f,  100 * 16.0f, 50 * 16.0f};
    assert_memory_equal(image.data, expected, sizeof expected);
    lf_image32_finish(&image);
    n = lf_picture_hdr_header(data, "-Y 1 +X 4", "EXPOSURE= 2\nEXPOSURE=2\nCOLORCORR=1 2 4\n");
    memcpy(data + n, pixels, sizeof pixels);
    lf_picture_write(path, data, n + sizeof pixels);
    image = lf_picture_load32(path);
    lf_assert_close((double)image.data[0], 0.25, 0, 0);
    lf_assert_close((double)image.data[1], 0.0625, 0, 0);
    lf_image32_finish(&image);
}

static void both_kinds_of_runs_are_unrolled(void **state)
{
    const char *path = lf_test_path(*state, "a.hdr");
    char data[512];
    size_t n = lf_picture_hdr_header(data, "-Y 2 +X 300", "");
    unsigned char *to = (unsigned char *)data + n;
    /* new: per component a literal of 2, then runs; the second line old: a pixel, repeated 1 * 43
     * and 256 times */
    const unsigned char head[] = {2, 2, 300 >> 8, 300 & 255};
    memcpy(to, head, 4);
    to += 4;
    for (int c = 0; c < 4; c++) {
        const unsigned char runs[] = {2,
                                      (unsigned char)(10 + c),
                                      (unsigned char)(20 + c),
                                      255,
                                      (unsigned char)(30 + c),
                                      255,
                                      (unsigned char)(40 + c),
                                      128 + 44,
                                      (unsigned char)(50 + c)};
        memcpy(to, runs, sizeof runs);
        to += sizeof runs;
    }
    const unsigned char old[] = {8, 16, 32, 136, 1, 1, 1, 43, 1, 1, 1, 1};
    memcpy(to, old, sizeof old);
    to += sizeof old;
    lf_picture_write(path, data, (size_t)((char *)to - data));
    lf_image32 image = lf_picture_load32(path);
    for (int x = 0; x < 300; x++) {
        int base = x == 0 ? 10 : x == 1 ? 20 : x < 129 ? 30 : x < 256 ? 40 : 50;
        for (int c = 0; c < 3; c++) {
            lf_assert_close((double)image.data[3 * x + c], ldexp(base + c, base + 3 - 136), 0, 0);
            lf_assert_close((double)image.data[900 + 3 * x + c], 8 << c, 0, 0);
        }
    }
    lf_image32_finish(&image);
}

static void flipped_axes_are_turned_back(void **state)
{
    const char *path = lf_test_path(*state, "a.hdr");
    for (int k = 0; k < 8; k++) {
        bool columns = k & 4, x_down = k & 2, y_up = k & 1;
        char line[64], data[256];
        if (columns)
            sprintf(line, "%cX 3 %cY 2", x_down ? '-' : '+', y_up ? '+' : '-');
        else
            sprintf(line, "%cY 2 %cX 3", y_up ? '+' : '-', x_down ? '-' : '+');
        size_t n = lf_picture_hdr_header(data, line, "");
        for (int i = 0; i < 6; i++) {
            int x = columns ? i / 2 : i % 3, y = columns ? i % 2 : i / 3;
            unsigned char pixel[4] = {
                (unsigned char)((x_down ? 2 - x : x) + 3 * (y_up ? 1 - y : y) + 1), 0, 0, 136};
            memcpy(data + n, pixel, 4);
            n += 4;
        }
        lf_picture_write(path, data, n);
        lf_image32 image = lf_picture_load32(path);
        assert_int_equal(image.width, 3);
        assert_int_equal(image.height, 2);
        for (int i = 0; i < 6; i++)
            lf_assert_close((double)image.data[3 * i], i + 1, 0, 0);
        lf_image32_finish(&image);
    }
}

static void a_bad_hdr_says_what_is_wrong(void **state)
{
    const char *path = lf_test_path(*state, "bad.hdr");
    const char *const cases[][2] = {
        {"#?RADIANCE\nFORMAT=Radiance_spectra\n\n-Y 1 +X 1\nabcd", "32-bit_rle_rgbe"},
        {"#?RADIANCE\nEXPOSURE=0\n\n-Y 1 +X 1\nabcd", "EXPOSURE"},
        {"#?RADIANCE\nEXPOSURE=nan\n\n-Y 1 +X 1\nabcd", "EXPOSURE"},
        {"#?RADIANCE\n\n-Y 1 +Z 1\nabcd", "resolution"},
        {"#?RADIANCE\n\n-Y 1 +X 1 0\nabcd", "resolution"},
        {"#?RADIANCE\n\n-Y 0 +X 1\nabcd", "0"},
        {"#?RADIANCE\n\n-Y 60000 +X 60000\nabcd", "60000x60000"},
        {"#?RADIANCE\n\n-Y 1 +X 2\nabcd", "too early"},
        {"#?RADIANCE\n\n-Y 1 +X 2\n\1\1\1\2", "precedes the first"},
        {"#?RADIANCE\n\n-Y 1 +X 2\nabcd\1\1\1\2", "longer than"},
        {"#?RADIANCE\nno end", "header"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        lf_picture_write(path, cases[i][0], strlen(cases[i][0]));
        lf_picture_refused(path, cases[i][1]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flat_hdr_pixels_are_shared_exponents),
        cmocka_unit_test(both_kinds_of_runs_are_unrolled),
        cmocka_unit_test(flipped_axes_are_turned_back),
        cmocka_unit_test(a_bad_hdr_says_what_is_wrong),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
