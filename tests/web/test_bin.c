/* Images of programs: bitmaps become RGB from the top, other files stay as they are, and all of
 * them have a limit. */
#include "tests/testing.h"

#include "daemon/web/bin.h"
#include "daemon/web/memory.h"
#include "tests/web/bitmap.h"

#include <fcntl.h>

static bool no_room(void *context)
{
    (*(int *)context)++;
    return false;
}

static lf_bins bins_of(uint64_t limit, int *n_asked)
{
    return (lf_bins){.limit = limit, .make_room = no_room, .context = n_asked};
}

static lf_bin *take(lf_bins *bins, const uint8_t *data, size_t n, size_t step)
{
    lf_bin *bin = NULL;
    assert_int_equal(lf_bin_create(bins, &bin), LF_OK);
    for (size_t at = 0; at < n; at += step)
        lf_bin_take(bin, data + at, n - at < step ? n - at : step);
    return bin;
}

static void check_pixels(const lf_bin *bin, int width, int height)
{
    assert_int_equal(lf_bin_width(bin), width);
    assert_int_equal(lf_bin_height(bin), height);
    assert_int_equal(lf_memory_bytes(lf_bin_fd(bin)), 3 * width * height);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            uint8_t rgb[3], expected[3];
            assert_int_equal(pread(lf_bin_fd(bin), rgb, 3, 3 * (y * width + x)), 3);
            bitmap_pixel(x, y, expected);
            assert_memory_equal(rgb, expected, 3);
        }
}

static void a_bitmap_becomes_rgb_from_the_top(void **state)
{
    (void)state;
    static const struct {
        int width, height, bits;
    } rows[] = {{1, 1, 24},  {2, 1, 24}, {3, 2, 24},  {5, 7, 24},
                {5, -7, 24}, {4, 3, 32}, {7, -5, 32}, {1, 1, 32}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        for (size_t step = 1; step < 200; step = step * 3 + 1) {
            int asked = 0;
            size_t n = 0;
            lf_error err = {0};
            lf_bins bins = bins_of(1000, &asked);
            uint8_t *bmp = bitmap_make(rows[i].width, rows[i].height, rows[i].bits, &n);
            lf_bin *bin = take(&bins, bmp, n, step);
            lf_assert_ok(lf_bin_finish(bin, &err), &err);
            check_pixels(bin, rows[i].width, abs(rows[i].height));
            assert_int_equal(bins.used, n);
            lf_bin_destroy(bin);
            assert_int_equal(bins.used, 0);
            free(bmp);
        }
}

/* Nobody can change what quiltd gets. */
static void the_file_is_sealed(void **state)
{
    (void)state;
    int asked = 0;
    lf_bins bins = bins_of(1000, &asked);
    lf_error err = {0};
    lf_bin *bin = take(&bins, (const uint8_t *)"\xff\xd8 a file", 9, 4);
    char text[16] = "";
    lf_assert_ok(lf_bin_finish(bin, &err), &err);
    assert_int_equal(lf_bin_width(bin), 0);
    assert_int_equal(pread(lf_bin_fd(bin), text, sizeof text, 0), 9);
    assert_string_equal(text, "\xff\xd8 a file");
    assert_true(pwrite(lf_bin_fd(bin), "x", 1, 0) < 0);
    lf_bin_destroy(bin);
}

/* A colour table's place, and masks that say what is usual. */
static void masks_may_say_what_is_usual(void **state)
{
    (void)state;
    size_t n = 0;
    int asked = 0;
    lf_error err = {0};
    lf_bins bins = bins_of(1000, &asked);
    uint8_t *plain = bitmap_make(3, 2, 32, &n), masked[200] = {0};
    memcpy(masked, plain, BITMAP_HEAD);
    masked[10] = 70;
    masked[30] = 3;
    bitmap_word(masked + 54, 0xff0000);
    bitmap_word(masked + 58, 0xff00);
    bitmap_word(masked + 62, 0xff);
    memcpy(masked + 70, plain + BITMAP_HEAD, n - BITMAP_HEAD);
    lf_bin *bin = take(&bins, masked, n + 16, 11);
    lf_assert_ok(lf_bin_finish(bin, &err), &err);
    check_pixels(bin, 3, 2);
    lf_bin_destroy(bin);
    bitmap_word(masked + 54, 0xff);
    bin = take(&bins, masked, n + 16, 11);
    lf_assert_status(lf_bin_finish(bin, &err), LF_E_FORMAT, &err);
    lf_bin_destroy(bin);
    free(plain);
}

/* A good bitmap of 3x2 with one number changed. */
static void check_refused(int offset, uint32_t word, const char *words)
{
    size_t n = 0;
    int asked = 0;
    lf_error err = {0};
    lf_bins bins = bins_of(4096, &asked);
    uint8_t *bmp = bitmap_make(3, 2, 24, &n);
    bitmap_word(bmp + offset, word);
    lf_bin *bin = take(&bins, bmp, n, 7);
    lf_assert_status(lf_bin_finish(bin, &err), LF_E_FORMAT, &err);
    if (!strstr(err.what, words))
        fail_msg("%d: %u: %s", offset, word, err.what);
    assert_int_equal(lf_bin_fd(bin), -1);
    assert_int_equal(bins.used, 0);
    lf_bin_destroy(bin);
    free(bmp);
}

static void other_bitmaps_are_refused(void **state)
{
    (void)state;
    check_refused(14, 12, "bits"); /* OS/2 */
    check_refused(28, 8, "bits");  /* with a palette */
    check_refused(28, 16, "bits");
    check_refused(30, 1, "compression"); /* run lengths */
    check_refused(30, 3, "compression"); /* masks with 24 bits */
    check_refused(10, 53, "follow");     /* pixels within the header */
    check_refused(10, 70000, "follow");
    check_refused(18, 0, "sides");
    check_refused(18, 0x80000000u, "sides");
    check_refused(22, 0, "sides");
    check_refused(22, 0x80000000u, "sides"); /* its opposite is no int */
    check_refused(18, 16385, "sides");
    check_refused(18, 16000, "more than"); /* 96,000 bytes of RGB */
    check_refused(22, 3, "too early");
}

static void an_image_has_a_limit(void **state)
{
    (void)state;
    static uint8_t data[2001];
    int asked = 0;
    lf_error err = {0};
    lf_bins bins = bins_of(2000, &asked);
    lf_bin *bin = take(&bins, data, 2000, 100);
    lf_assert_ok(lf_bin_finish(bin, &err), &err);
    lf_bin_destroy(bin);
    bin = take(&bins, data, 2001, 100);
    lf_assert_status(lf_bin_finish(bin, &err), LF_E_ARG, &err);
    assert_non_null(strstr(err.what, "--image-limit"));
    assert_int_equal(bins.used, 0);
    lf_bin_destroy(bin);
    bin = take(&bins, data, 1, 1);
    lf_assert_status(lf_bin_finish(bin, &err), LF_E_ARG, &err);
    lf_bin_destroy(bin);
    assert_int_equal(asked, 0);
}

/* The third image of full size finds no room, until one goes. */
static void all_images_have_a_limit(void **state)
{
    (void)state;
    static uint8_t data[2000];
    int asked = 0;
    lf_error err = {0};
    lf_bins bins = bins_of(2000, &asked);
    lf_bin *first = take(&bins, data, 2000, 500), *second = take(&bins, data, 2000, 500);
    lf_bin *third = take(&bins, data, 2000, 500);
    lf_assert_status(lf_bin_finish(third, &err), LF_E_BUSY, &err);
    assert_int_equal(asked, 1);
    lf_bin_destroy(third);
    lf_bin_destroy(first);
    third = take(&bins, data, 2000, 500);
    lf_assert_ok(lf_bin_finish(third, &err), &err);
    lf_bin_destroy(second);
    lf_bin_destroy(third);
    assert_int_equal(bins.used, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_bitmap_becomes_rgb_from_the_top),
        cmocka_unit_test(the_file_is_sealed),
        cmocka_unit_test(masks_may_say_what_is_usual),
        cmocka_unit_test(other_bitmaps_are_refused),
        cmocka_unit_test(an_image_has_a_limit),
        cmocka_unit_test(all_images_have_a_limit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
