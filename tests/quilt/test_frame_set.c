/* Frame sets: every view as a picture of the print's size. */
#include "tests/testing.h"

#include <tiffio.h>

#include "base/alloc.h"
#include "tests/quilt/printed.h"

enum { WIDTH = 48, HEIGHT = 31 }; /* of a frame: 4 x 2.6 mm at 300 ppi, rounded */

static lf_print frames_of(bool horizontal)
{
    lf_print print = lf_print_sound();
    print.width_mm = 3.6;
    print.height_mm = 2.2;
    print.bleed_mm = 0.2;
    print.n_views = 3;
    print.horizontal = horizontal;
    print.frame_ppi = 300;
    return print;
}

/* A grey of view, row and column, which no shift or swap keeps. */
static float value_at(int view, int row, int column)
{
    return (float)((view * 37 + row * 5 + column * 3) % 101) / 101.0F;
}

static lf_views32 make_views(int n, int width, int height, float *data)
{
    for (int view = 0; view < n; view++)
        for (int row = 0; row < height; row++)
            for (int column = 0; column < width; column++)
                for (int c = 0; c < 3; c++)
                    data[((view * height + row) * width + column) * 3 + c] =
                        value_at(view, row, column);
    const size_t line = 3 * (size_t)width;
    return (lf_views32){n, width, height, line * (size_t)height, line, data, NULL, NULL, NULL};
}

static const char *name_of(int i)
{
    static char name[32];
    snprintf(name, sizeof name, "f%d", i);
    return name;
}

static void write_set(const lf_print *print, const lf_views32 *views, const char *folder)
{
    lf_outfile files[LF_FRAME_SET_TOLD + 3];
    const lf_print_run run = {0};
    lf_error err;
    for (int i = 0; i < LF_FRAME_SET_TOLD + 3; i++)
        lf_assert_ok(lf_outfile_open(&files[i], lf_test_path(folder, name_of(i)), true, &err),
                     &err);
    lf_assert_ok(lf_frame_set_write(print, views, &run, files, &err), &err);
    for (int i = 0; i < LF_FRAME_SET_TOLD + 3; i++)
        lf_assert_ok(lf_outfile_commit(&files[i], true, &err), &err);
}

static int code_of(double light)
{
    return (int)lround(255 *
                       (light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1 / 2.4) - 0.055));
}

static void assert_frame(const char *path, float (*value)(int view, int x, int y), int view)
{
    TIFF *tiff = TIFFOpen(path, "r");
    uint32_t width, height, profile_size;
    float x_resolution, y_resolution;
    void *profile;
    uint8_t row[3 * WIDTH];
    assert_non_null(tiff);
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
    TIFFGetField(tiff, TIFFTAG_XRESOLUTION, &x_resolution);
    TIFFGetField(tiff, TIFFTAG_YRESOLUTION, &y_resolution);
    assert_int_equal(TIFFGetField(tiff, TIFFTAG_ICCPROFILE, &profile_size, &profile), 1);
    assert_true(x_resolution == 300.0F && y_resolution == 300.0F);
    assert_int_equal(width, WIDTH - 1);
    assert_int_equal(height, HEIGHT);
    for (uint32_t y = 0; y < height; y++) {
        assert_int_equal(TIFFReadScanline(tiff, row, y, 0), 1);
        for (uint32_t x = 0; x < 3 * width; x++)
            assert_int_equal(row[x], code_of(value(view, (int)x / 3, (int)y)));
    }
    TIFFClose(tiff);
}

static float upright(int view, int x, int y)
{
    return value_at(view, y, x);
}

/* The rolled rig's picture has the print's down as its right, and its rows run from right to
 * left. */
static float rolled(int view, int x, int y)
{
    return value_at(view, WIDTH - 2 - x, y);
}

static void frames_are_the_views_pixel_for_pixel(void **state)
{
    static float data[3 * WIDTH * HEIGHT * 3];
    for (int way = 0; way < 3; way++) {
        lf_print print = frames_of(way > 0);
        lf_print_shape shape;
        print.rolled = way == 2;
        print.blur = (lf_print_blur){.spot_mm = 0.02, .ink_mm = 0.02, .dot_gain = 0.2};
        print.blur.n_crosstalk = 1; /* a frame has no stripes that could be compensated */
        const lf_print frame = lf_frame_set_print(&print);
        assert_true(frame.blur.n_crosstalk == 0 && frame.blur.dot_gain == 0.0);
        assert_true(frame.blur.spot_mm == 0.0 && frame.blur.ink_mm == 0.0);
        lf_print compensated = print;
        compensated.compensation.on = true;
        assert_false(lf_frame_set_print(&compensated).compensation.on);
        lf_print_shape_of(&frame, &shape);
        const lf_views32 views = make_views(3, shape.view_width, shape.view_height, data);
        assert_int_equal(shape.view_width, way == 2 ? HEIGHT : WIDTH - 1);
        assert_int_equal(shape.view_height, way == 2 ? WIDTH - 1 : HEIGHT);
        write_set(&print, &views, *state);
        for (int i = 0; i < 3; i++)
            assert_frame(lf_test_path(*state, name_of(LF_FRAME_SET_TOLD + i)),
                         way == 2 ? rolled : upright, i);
    }
}

static void the_order_is_told(void **state)
{
    static float data[6 * 2 * 2 * 3];
    lf_print print = frames_of(false);
    const lf_views32 views = make_views(6, 2, 2, data);
    char *text;
    size_t size;
    lf_error err;
    write_set(&print, &views, *state);
    lf_assert_ok(lf_file_read(lf_test_path(*state, "f0"), NULL, 1 << 16, &text, &size, &err), &err);
    assert_non_null(strstr(text, "f2  leftmost camera\nf3  camera 2 from the left\n"
                                 "f4  rightmost camera\n"));
    assert_non_null(strstr(text, "60 lenses per inch"));
    assert_non_null(strstr(text, "47 x 31 pixels at 300 per inch"));
    lf_free(text);
    json_t *told = json_load_file(lf_test_path(*state, "f1"), 0, NULL);
    const json_t *frames = json_object_get(told, "frames");
    assert_int_equal(json_array_size(frames), 3);
    static const int shown[] = {1, 3, 5};
    for (size_t i = 0; i < 3; i++) {
        const json_t *frame = json_array_get(frames, i);
        assert_int_equal(json_integer_value(json_object_get(frame, "view")), shown[i]);
        assert_int_equal(strlen(json_string_value(json_object_get(frame, "sha256"))), 64);
    }
    json_decref(told);
}

static void what_frames_cannot_have_is_refused(void **state)
{
    (void)state;
    lf_error err;
    for (int i = 0; i < 9; i++) {
        lf_print print = frames_of(false);
        print.marks = i == 0;
        print.mirror = i == 1;
        print.reverse = i == 2;
        print.optics.grid = i == 3 ? LF_LENS_SQUARE : LF_LENS_LINEAR;
        print.frame_ppi = i == 4 ? 601 : 300;
        print.sheet.columns = i == 5 ? 2 : 0;
        print.sheet.rows = i == 5 ? 1 : 0;
        print.sheet.label = i == 6 ? "job 7" : NULL;
        print.sheet.guard = i == 7 ? 1 : 0;
        print.sheet.morph = i == 8 ? 1 : 0;
        assert_int_equal(lf_frame_set_check(&print, &err), LF_E_ARG);
        assert_true(i == 4 || strstr(err.what, "; leave "));
    }
    const lf_print print = frames_of(false);
    lf_assert_ok(lf_frame_set_check(&print, &err), &err);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(frames_are_the_views_pixel_for_pixel),
        lf_test_in_folder(the_order_is_told),
        cmocka_unit_test(what_frames_cannot_have_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
