/* Pictures as PNG files. */
#include "tests/base/pictures.h"

#include <fcntl.h>
#include <unistd.h>

#include "base/alloc.h"

static bool holds(const char *path, const char *word)
{
    size_t n;
    char *data = lf_picture_bytes(path, &n);
    bool found = memmem(data, n, word, strlen(word));
    lf_free(data);
    return found;
}

static void a_png_comes_back_as_it_was_at_every_level(void **state)
{
    const char *path = lf_test_path(*state, "a.png");
    lf_image8 image = lf_picture_noise(61, 37);
    for (int level = 1; level <= 9; level++) {
        lf_picture_save_png(path, &image, level, NULL, 0);
        lf_image8 back = lf_picture_load8(path);
        assert_int_equal(back.width, 61);
        assert_int_equal(back.height, 37);
        assert_memory_equal(back.data, image.data, image.stride * 37);
        lf_image8_finish(&back);
    }
    lf_image8_finish(&image);
}

static void a_png_says_srgb_and_carries_its_texts(void **state)
{
    const char *path = lf_test_path(*state, "a.png");
    lf_image8 image = lf_picture_noise(3, 2);
    const lf_attribute attributes[] = {{"Software", "quiltd 1"}, {"Title", "W\xc3\xb6lkchen"}};
    lf_picture_save_png(path, &image, 1, attributes, 2);
    assert_true(holds(path, "sRGB"));
    assert_true(holds(path, "tEXtSoftware"));
    assert_true(holds(path, "quiltd 1"));
    assert_true(holds(path, "iTXtTitle"));
    assert_true(holds(path, "W\xc3\xb6lkchen"));
    assert_false(holds(path, "gAMA"));
    lf_image8_finish(&image);
}

/* Without the camera's place or its target, the distance of the glass is unknown. */
static void a_picture_with_depth_needs_both_ends_of_its_view(void **state)
{
    const char *path = lf_test_path(*state, "depth.png");
    const lf_attribute all[] = {{"quiltd.near", "2"},           {"quiltd.far", "inf"},
                                {"quiltd.fov_y", "20"},         {"quiltd.aspect", "0.75"},
                                {"quiltd.cone", "35"},          {"quiltd.views", "9"},
                                {"quiltd.width", "3"},          {"quiltd.height", "2"},
                                {"quiltd.target", "[0,0,1]"},   {"quiltd.position", "[0,3,5]"},
                                {"quiltd.placement", "centred"}};
    lf_image8 image = lf_picture_noise(6, 2);
    for (int left_out = 7; left_out <= 9; left_out++) {
        lf_attribute some[11];
        int n = 0;
        for (int i = 0; i < 11; i++)
            if (i != left_out)
                some[n++] = all[i];
        lf_picture_save_png(path, &image, 1, some, n);
        const int fd = open(path, O_RDONLY | O_CLOEXEC);
        lf_image8 back;
        lf_image_metadata meta;
        lf_error err;
        lf_assert_ok(lf_image8_read_metadata(fd, path, &back, &meta, &err), &err);
        lf_assert_close(meta.depth.distance, left_out == 7 ? 5 : 0, 1e-12, 0);
        lf_assert_close(meta.depth.width, left_out == 7 ? 3 : 0, 0, 0);
        lf_assert_close(meta.depth.height, 0, 0, 0);
        lf_image8_finish(&back);
        close(fd);
    }
    lf_image8_finish(&image);
}

static void frames_carry_the_rate_of_their_animation(void **state)
{
    const char *path = lf_test_path(*state, "rate.png");
    static const struct {
        const char *text;
        double rate;
    } cases[] = {{"12.5", 12.5}, {"23.976024", 23.976024},
                 {"1000", 1000}, {"1001", 0},
                 {"0", 0},       {"-3", 0},
                 {"nan", 0},     {"many", 0}};
    lf_image8 image = lf_picture_noise(6, 2);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const lf_attribute rate = {"quiltd.fps", cases[i].text};
        lf_image8 back;
        lf_image_metadata meta;
        lf_error err;
        lf_picture_save_png(path, &image, 1, &rate, 1);
        const int fd = open(path, O_RDONLY | O_CLOEXEC);
        lf_assert_ok(lf_image8_read_metadata(fd, path, &back, &meta, &err), &err);
        lf_assert_close(meta.frame_rate, cases[i].rate, 0, 0);
        lf_image8_finish(&back);
        close(fd);
    }
    lf_image8_finish(&image);
}

/* At every length but the whole, a file is refused. */
static void a_png_tells_its_size_if_it_is_whole(void **state)
{
    const char *path = lf_test_path(*state, "size.png");
    lf_image8 image = lf_picture_noise(7, 3);
    lf_error err;
    size_t n = 0;
    int width = -1, height = -1;
    lf_picture_save_png(path, &image, 1, NULL, 0);
    lf_image8_finish(&image);
    lf_assert_ok(lf_png_measure(path, NULL, &width, &height, &err), &err);
    assert_int_equal(width, 7);
    assert_int_equal(height, 3);
    char *bytes = lf_picture_bytes(path, &n);
    for (size_t length = n - 1; length > 0; length--) {
        assert_int_equal(truncate(path, (off_t)length), 0);
        assert_int_equal(lf_png_measure(path, NULL, &width, &height, &err),
                         length < 8 ? LF_E_STATE : LF_E_FORMAT);
    }
    bytes[17] = 2; /* 131079 pixels wide */
    FILE *file = fopen(path, "wbe");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, n, file), n);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(lf_png_measure(path, NULL, &width, &height, &err), LF_E_FORMAT);
    assert_non_null(strstr(err.what, "no valid size"));
    lf_free(bytes);
    assert_int_equal(lf_png_measure(lf_test_write(*state, "t.png", "text, not a PNG"), NULL, &width,
                                    &height, &err),
                     LF_E_STATE);
    assert_int_equal(lf_png_measure(lf_test_path(*state, "none.png"), NULL, &width, &height, &err),
                     LF_E_IO);
}

/* By their whole names; what is too long is cut. */
static void a_png_tells_its_texts_by_name(void **state)
{
    const char *path = lf_test_path(*state, "texts.png");
    char longer[400], exact[LF_PNG_TEXT], out[6][LF_PNG_TEXT];
    memset(longer, 'x', sizeof longer - 1);
    longer[sizeof longer - 1] = '\0';
    memcpy(exact, longer, sizeof exact - 1);
    exact[sizeof exact - 1] = '\0';
    const lf_attribute texts[] = {
        {"quiltd.ab", "2"}, {"quiltd.a", "1"}, {"quiltd.long", longer}, {"quiltd.exact", exact}};
    static const char *const names[6] = {"quiltd.a",     "quiltd.abc", "quiltd.long",
                                         "quiltd.exact", "quiltd.ab",  "quiltd."};
    const char *const expected[6] = {"1", "", exact, exact, "2", ""};
    lf_image8 image = lf_picture_noise(6, 2);
    lf_error err;
    memset(out, 'y', sizeof out);
    lf_picture_save_png(path, &image, 1, texts, 4);
    lf_image8_finish(&image);
    lf_assert_ok(lf_png_texts(path, NULL, names, 6, out, &err), &err);
    for (int i = 0; i < 6; i++)
        assert_string_equal(out[i], expected[i]);
    assert_int_equal(
        lf_png_texts(lf_test_write(*state, "t.png", "text, not a PNG"), NULL, names, 6, out, &err),
        LF_E_STATE);
    assert_string_equal(out[0], "");
}

static void every_kind_of_png_becomes_rgb(void **state)
{
    const char *path = lf_test_path(*state, "kind.png");
    const uint8_t palette[4][3] = {{1, 2, 3}, {50, 60, 70}, {255, 0, 128}, {9, 9, 9}};
    uint8_t rows[8][64];
    for (int interlaced = 0; interlaced < 2; interlaced++) {
        memset(rows, 0x1b, sizeof rows); /* indices 0 1 2 3 of two bits */
        lf_picture_png(path, 8, 8, 2, PNG_COLOR_TYPE_PALETTE, interlaced, NULL, &rows[0][0], 64);
        lf_image8 image = lf_picture_load8(path);
        for (int x = 0; x < 8; x++)
            assert_memory_equal(image.data + 3 * image.stride + 3 * (size_t)x, palette[x % 4], 3);
        lf_image8_finish(&image);
        lf_picture_png(path, 8, 8, 2, PNG_COLOR_TYPE_GRAY, interlaced, NULL, &rows[0][0], 64);
        image = lf_picture_load8(path);
        for (int x = 0; x < 8; x++)
            for (int c = 0; c < 3; c++)
                assert_int_equal(image.data[7 * image.stride + 3 * (size_t)x + (size_t)c],
                                 85 * (x % 4));
        lf_image8_finish(&image);
        /* 16 bits are rounded, alpha is dropped */
        const uint16_t samples[4] = {0x0180, 0x7fff, 0xff7f, 0x1234};
        for (int x = 0; x < 8; x++)
            for (int c = 0; c < 4; c++) {
                rows[0][x * 8 + c * 2] = (uint8_t)(samples[c] >> 8);
                rows[0][x * 8 + c * 2 + 1] = (uint8_t)samples[c];
            }
        lf_picture_png(path, 8, 1, 16, PNG_COLOR_TYPE_RGBA, interlaced, NULL, &rows[0][0], 64);
        image = lf_picture_load8(path);
        for (int c = 0; c < 3; c++)
            assert_int_equal(image.data[15 + c], (int)floor(samples[c] / 257.0 + 0.5));
        lf_image8_finish(&image);
    }
}

static void eight_bit_pictures_are_decoded_from_srgb(void **state)
{
    const char *path = lf_test_path(*state, "ramp.png");
    lf_image8 image = {0};
    assert_int_equal(lf_image8_init(&image, 256, 1, 3), LF_OK);
    for (int i = 0; i < 768; i++)
        image.data[i] = (uint8_t)(i / 3);
    lf_picture_save_png(path, &image, 6, NULL, 0);
    lf_image32 linear = lf_picture_load32(path);
    for (int i = 0; i < 256; i++) {
        double s = i / 255.0;
        lf_assert_close((double)linear.data[3 * i],
                        s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4), 1e-6, 0);
    }
    lf_image32_finish(&linear);
    lf_image8_finish(&image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_png_comes_back_as_it_was_at_every_level),
        cmocka_unit_test(a_png_says_srgb_and_carries_its_texts),
        cmocka_unit_test(a_picture_with_depth_needs_both_ends_of_its_view),
        cmocka_unit_test(frames_carry_the_rate_of_their_animation),
        cmocka_unit_test(a_png_tells_its_size_if_it_is_whole),
        cmocka_unit_test(a_png_tells_its_texts_by_name),
        cmocka_unit_test(every_kind_of_png_becomes_rgb),
        cmocka_unit_test(eight_bit_pictures_are_decoded_from_srgb),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
