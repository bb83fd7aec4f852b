#include "tests/testing.h"

#include <sys/stat.h>

#include "base/alloc.h"
#include "quilt/quilt.h"

#define WIDTH 11
#define HEIGHT 7

/* A value that tells view, place and channel. */
static uint8_t value8(int view, int x, int y, int c)
{
    return (uint8_t)(view * 37 + x * 5 + y * 11 + c * 101);
}

static float value32(int view, int x, int y, int c)
{
    return (float)(view * 1000 + y * 100 + x) + (float)c * 0.125f;
}

/* In the film's order [row][view][column]. */
static uint8_t *views8_of(int n_views, lf_views8 *out)
{
    uint8_t *data = lf_calloc((size_t)n_views * HEIGHT * WIDTH, 3);
    assert_non_null(data);
    for (int i = 0; i < n_views * HEIGHT * WIDTH * 3; i++)
        data[i] = value8(i / 3 / WIDTH % n_views, i / 3 % WIDTH, i / 3 / WIDTH / n_views, i % 3);
    *out = (lf_views8){n_views, WIDTH, HEIGHT, WIDTH * 3, (size_t)n_views * WIDTH * 3, data};
    return data;
}

static float *views32_of(int n_views, lf_views32 *out)
{
    float *data = lf_calloc((size_t)n_views * HEIGHT * WIDTH * 3, sizeof *data);
    assert_non_null(data);
    for (int i = 0; i < n_views * HEIGHT * WIDTH * 3; i++)
        data[i] = value32(i / 3 / WIDTH % n_views, i / 3 % WIDTH, i / 3 / WIDTH / n_views, i % 3);
    *out = (lf_views32){n_views, WIDTH, HEIGHT, WIDTH * 3, (size_t)n_views * WIDTH * 3,
                        data,    NULL,  NULL,   NULL};
    return data;
}

static lf_layout layout_of(int columns, int rows, int n_views)
{
    return (lf_layout){columns, rows, n_views, WIDTH, HEIGHT, 1.5};
}

static void save_quilt(const char *path, bool is_float, const lf_layout *layout)
{
    lf_outfile file;
    lf_error err;
    const lf_attribute attribute = {"integrator", "mvpt"};
    lf_assert_ok(lf_outfile_open(&file, path, true, &err), &err);
    if (is_float) {
        lf_views32 views;
        float *data = views32_of(layout->n_views, &views);
        lf_assert_ok(lf_quilt_write_exr(&file, &views, layout, &attribute, 1, &err), &err);
        lf_free(data);
    } else {
        lf_views8 views;
        uint8_t *data = views8_of(layout->n_views, &views);
        lf_assert_ok(lf_quilt_write_png(&file, &views, layout, &attribute, 1, &err), &err);
        lf_free(data);
    }
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
}

static void assert_views(const lf_quilt_file *q, int n_known)
{
    const int n = q->layout.n_views;
    assert_int_equal(q->layout.view_width, WIDTH);
    assert_int_equal(q->layout.view_height, HEIGHT);
    assert_int_equal(q->is_float ? q->views32.n_views : q->views8.n_views, n);
    for (int i = 0; i < n * HEIGHT * WIDTH * 3; i++) {
        int c = i % 3, x = i / 3 % WIDTH, y = i / 3 / WIDTH % HEIGHT, view = i / 3 / WIDTH / HEIGHT;
        if (q->is_float)
            assert_true(lf_views32_row(&q->views32, view, y)[3 * x + c] ==
                        (view < n_known ? value32(view, x, y, c) : 0));
        else
            assert_int_equal(lf_views8_row(&q->views8, view, y)[3 * x + c],
                             view < n_known ? value8(view, x, y, c) : 0);
    }
}

static void a_quilt_comes_back_as_its_views(void **state)
{
    static const int tiles[][3] = {{5, 9, 45}, {8, 6, 48}, {3, 4, 10},
                                   {1, 1, 1},  {7, 1, 7},  {2, 5, 3}};
    for (int i = 0; i < 12; i++) {
        bool is_float = i & 1;
        lf_layout layout = layout_of(tiles[i / 2][0], tiles[i / 2][1], tiles[i / 2][2]);
        char *path = lf_layout_name(lf_test_path(*state, is_float ? "a.exr" : "a.png"), &layout);
        save_quilt(path, is_float, &layout);
        lf_quilt_file q = {0};
        lf_error err;
        lf_assert_ok(lf_quilt_read(path, NULL, 0, 0, &q, &err), &err);
        assert_int_equal(q.is_float, is_float);
        assert_int_equal(q.layout.columns, layout.columns);
        assert_int_equal(q.layout.rows, layout.rows);
        assert_int_equal(q.layout.n_views, layout.columns * layout.rows);
        lf_assert_close(q.layout.aspect, 1.5, 0, 0);
        assert_views(&q, layout.n_views); /* tiles without a view are black */
        lf_quilt_finish(&q);
        lf_quilt_finish(&q);
        lf_free(path);
    }
}

static void view_0_is_at_the_bottom_left_and_the_next_to_its_right(void **state)
{
    lf_layout layout = layout_of(3, 2, 6);
    const char *png = lf_test_path(*state, "order.png"), *exr = lf_test_path(*state, "order.exr");
    save_quilt(png, false, &layout);
    save_quilt(exr, true, &layout);
    lf_image8 image8 = {0};
    lf_image32 image32 = {0};
    lf_error err;
    lf_assert_ok(lf_image8_read(png, NULL, &image8, &err), &err);
    lf_assert_ok(lf_image32_read(exr, NULL, &image32, &err), &err);
    assert_int_equal(image8.width, 3 * WIDTH);
    assert_int_equal(image8.height, 2 * HEIGHT);
    static const int views[2][3] = {{3, 4, 5}, {0, 1, 2}}; /* as one sees them */
    for (int i = 0; i < 6 * WIDTH * HEIGHT; i++) {
        int x = i % (3 * WIDTH), y = i / (3 * WIDTH), view = views[y / HEIGHT][x / WIDTH];
        for (int c = 0; c < 3; c++) {
            assert_int_equal(image8.data[3 * i + c], value8(view, x % WIDTH, y % HEIGHT, c));
            assert_true(image32.data[3 * i + c] == value32(view, x % WIDTH, y % HEIGHT, c));
        }
    }
    lf_image8_finish(&image8);
    lf_image32_finish(&image32);
}

static void padding_at_the_right_and_the_top_is_left_out(void **state)
{
    lf_views8 views;
    uint8_t *data = views8_of(6, &views);
    lf_image8 image = {0};
    lf_error err;
    assert_int_equal(lf_image8_init(&image, 3 * WIDTH + 2, 2 * HEIGHT + 1, 3), LF_OK);
    memset(image.data, 99, image.stride * (size_t)image.height);
    for (int view = 0; view < 6; view++)
        for (int y = 0; y < HEIGHT; y++)
            memcpy(image.data + (size_t)(1 + (1 - view / 3) * HEIGHT + y) * image.stride +
                       view % 3 * WIDTH * 3,
                   lf_views8_row(&views, view, y), WIDTH * 3);
    const char *path = lf_test_path(*state, "padded.png");
    lf_outfile file;
    lf_assert_ok(lf_outfile_open(&file, path, true, &err), &err);
    lf_assert_ok(lf_png_write(&file, &image, 6, NULL, 0, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
    lf_quilt_file q = {0};
    lf_assert_ok(lf_quilt_read(path, NULL, 3, 2, &q, &err), &err);
    assert_views(&q, 6);
    lf_assert_close(q.layout.aspect, (double)WIDTH / HEIGHT, 0, 0); /* the name says none */
    lf_quilt_finish(&q);
    lf_image8_finish(&image);
    lf_free(data);
}

static void assert_noted(const lf_quilt_file *q, const char *lines)
{
    assert_int_equal(q->notes.length, strlen(lines));
    assert_memory_equal(q->notes.text, lines, strlen(lines));
}

static void a_layout_comes_from_the_name_or_the_caller(void **state)
{
    lf_layout layout = layout_of(4, 3, 12);
    const char *plain = lf_test_path(*state, "plain.png"),
               *named = lf_test_path(*state, "named_qs12x1a2.png");
    save_quilt(plain, false, &layout);
    save_quilt(named, false, &layout);
    lf_quilt_file q = {0};
    lf_error err;
    lf_assert_status(lf_quilt_read(plain, NULL, 0, 0, &q, &err), LF_E_ARG, &err);
    assert_non_null(strstr(err.what, "--quilt"));
    assert_null(q.image8.data);
    /* the caller wins, the aspect stays, and a note says so */
    lf_assert_ok(lf_quilt_read(named, NULL, 4, 3, &q, &err), &err);
    assert_views(&q, 12);
    lf_assert_close(q.layout.aspect, 2, 0, 0);
    assert_noted(&q, "is cut into 4x3 views, but its name says 12x1\n");
    lf_quilt_finish(&q);
    lf_assert_ok(lf_quilt_read(named, NULL, 11, 1, &q, &err), &err);
    assert_noted(&q, "is cut into 11x1 views, but its name says 12x1\n");
    lf_quilt_finish(&q);
    lf_assert_ok(lf_quilt_read(plain, NULL, 4, 3, &q, &err), &err);
    assert_noted(&q, "");
    lf_quilt_finish(&q);
    lf_assert_ok(lf_quilt_read(plain, NULL, 5, 4, &q, &err), &err);
    assert_noted(&q, "44x21 pixels are no multiple of 5x4 views; 4 columns at the right and 1 rows "
                     "at the top are left out\n");
    lf_quilt_finish(&q);
    lf_assert_ok(lf_quilt_read(named, NULL, 0, 0, &q, &err), &err); /* padding of a named quilt */
    assert_noted(&q, "");
    lf_quilt_finish(&q);
    lf_assert_status(lf_quilt_read(plain, NULL, 60, 3, &q, &err), LF_E_FORMAT, &err);
}

static void a_folder_is_one_view_a_picture_in_name_order(void **state)
{
    for (int is_float = 0; is_float < 2; is_float++) {
        char folder[256], name[64];
        snprintf(folder, sizeof folder, "%s/%s", (const char *)*state,
                 is_float ? "floating-point images" : "bytes");
        assert_int_equal(mkdir(folder, 0700), 0);
        for (int view = 6; view >= 0; view--) {
            lf_outfile file;
            lf_error err;
            snprintf(name, sizeof name, "view_%03d.%s", view, is_float ? "exr" : "png");
            lf_assert_ok(lf_outfile_open(&file, lf_test_path(folder, name), true, &err), &err);
            if (is_float) {
                lf_views32 views;
                float *data = views32_of(7, &views);
                lf_assert_ok(lf_view_write_exr(&file, &views, view, 1.5, NULL, 0, &err), &err);
                lf_free(data);
            } else {
                lf_views8 views;
                uint8_t *data = views8_of(7, &views);
                views.data = lf_views8_row(&views, view, 0);
                views.n_views = 1;
                lf_layout one = layout_of(1, 1, 1);
                lf_assert_ok(lf_quilt_write_png(&file, &views, &one, NULL, 0, &err), &err);
                lf_free(data);
            }
            lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
        }
        lf_test_write(folder, "notes.txt", "not a view");
        lf_test_write(folder, ".hidden.png", "not a view");
        assert_true(lf_is_quilt(folder, NULL));
        lf_quilt_file q = {0};
        lf_error err;
        lf_assert_ok(lf_quilt_read(folder, NULL, 0, 0, &q, &err), &err);
        assert_int_equal(q.is_float, is_float);
        assert_int_equal(q.layout.n_views, 7);
        assert_true(q.layout.columns * q.layout.rows >= 7);
        assert_views(&q, 7);
        lf_quilt_finish(&q);
        if (!is_float)
            continue;
        lf_layout layout = layout_of(1, 1, 1); /* of another kind */
        save_quilt(lf_test_path(folder, "view_007.exr"), false, &layout);
        lf_assert_status(lf_quilt_read(folder, NULL, 0, 0, &q, &err), LF_E_FORMAT, &err);
        assert_non_null(strstr(err.what, "floating-point images"));
    }
}

static void what_is_no_quilt_is_refused(void **state)
{
    const char *scene = lf_test_write(*state, "scene.json", "{ \"quiltd\": 1 }");
    const char *empty = lf_test_path(*state, "empty"),
               *none = lf_test_path(*state, "none_qs2x2a1.png");
    assert_int_equal(mkdir(empty, 0700), 0);
    lf_quilt_file q = {0};
    lf_error err;
    assert_false(lf_is_quilt(scene, NULL));
    assert_false(lf_is_quilt(none, NULL));
    lf_assert_status(lf_quilt_read(scene, NULL, 2, 2, &q, &err), LF_E_FORMAT, &err);
    lf_assert_status(lf_quilt_read(none, NULL, 0, 0, &q, &err), LF_E_IO, &err);
    lf_assert_status(lf_quilt_read(empty, NULL, 0, 0, &q, &err), LF_E_FORMAT, &err);
    assert_non_null(strstr(err.what, "no images"));
}

static void quilts_outside_the_roots_are_not_read(void **state)
{
    lf_layout layout = layout_of(2, 2, 4);
    const char *path = lf_test_path(*state, "root_qs2x2a1.5.png");
    save_quilt(path, false, &layout);
    lf_roots roots = {0};
    lf_quilt_file q = {0};
    lf_error err;
    lf_assert_ok(lf_roots_add(&roots, "/usr", &err), &err);
    lf_assert_status(lf_quilt_read(path, &roots, 0, 0, &q, &err), LF_E_PATH, &err);
    lf_assert_status(lf_quilt_read(*state, &roots, 0, 0, &q, &err), LF_E_PATH, &err);
    lf_assert_ok(lf_roots_add(&roots, *state, &err), &err);
    lf_assert_ok(lf_quilt_read(path, &roots, 0, 0, &q, &err), &err);
    lf_quilt_finish(&q);
    lf_roots_finish(&roots);
}

static void views_that_do_not_fit_the_layout_are_not_written(void **state)
{
    (void)state;
    lf_views8 views;
    uint8_t *data = views8_of(6, &views);
    lf_layout bad[] = {layout_of(3, 2, 5), layout_of(1, 5, 6), layout_of(3, 2, 6),
                       layout_of(3, 2, 6), layout_of(6000, 2, 6)};
    bad[2].view_width++;
    bad[3].view_height--;
    lf_outfile file = {.fd = -1};
    lf_error err;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        lf_assert_status(lf_quilt_write_png(&file, &views, &bad[i], NULL, 0, &err), LF_E_ARG, &err);
    lf_free(data);
}

static void assert_notes(const char *path, const char *line)
{
    lf_quilt_file q = {0};
    lf_error err;
    lf_assert_ok(lf_quilt_read(path, NULL, 0, 0, &q, &err), &err);
    assert_noted(&q, line);
    lf_quilt_finish(&q);
}

/* Of a folder each line once. */
static void what_pictures_say_in_vain_is_noted(void **state)
{
    static const char plain[] = "#?RADIANCE\n\n-Y 1 +X 2\nabcdabcd",
                      said[] = "#?RADIANCE\nGAMMA=2\n\n-Y 1 +X 2\nabcdabcd",
                      line[] = "ignored GAMMA=2; the values are read as linear light\n";
    assert_notes(lf_test_write(*state, "plain_qs2x1a1.hdr", plain), "");
    assert_notes(lf_test_write(*state, "said_qs2x1a1.hdr", said), line);
    assert_int_equal(mkdir(lf_test_path(*state, "noted"), 0700), 0);
    lf_test_write(*state, "noted/0.hdr", plain);
    lf_test_write(*state, "noted/1.hdr", said);
    lf_test_write(*state, "noted/2.hdr", said);
    assert_notes(lf_test_path(*state, "noted"), line);
}

static void real_quilts_are_read_as_four_by_eight(void **state)
{
    (void)state;
    static const char *const names[] = {"quilts/kirurobo_example02_qs4x8a1.6.png",
                                        "quilts/kirurobo_startup_qs4x8a1.6.png"};
    for (int i = 0; i < 2; i++) {
        const char *path = lf_test_shared(names[i]);
        if (!path)
            skip();
        assert_true(lf_is_quilt(path, NULL));
        lf_quilt_file q = {0};
        lf_error err;
        lf_assert_ok(lf_quilt_read(path, NULL, 0, 0, &q, &err), &err);
        assert_int_equal(q.layout.columns, 4);
        assert_int_equal(q.layout.rows, 8);
        assert_int_equal(q.layout.n_views, 32);
        assert_int_equal(q.layout.view_width, 512);
        assert_int_equal(q.layout.view_height, 256);
        lf_assert_close(q.layout.aspect, 1.6, 0, 1e-12);
        lf_image8 image = {0};
        lf_assert_ok(lf_image8_read(path, NULL, &image, &err), &err);
        assert_memory_equal(lf_views8_row(&q.views8, 0, 255), image.data + 2047 * image.stride,
                            512 * 3);
        assert_memory_equal(lf_views8_row(&q.views8, 31, 0), image.data + 3 * 512 * 3, 512 * 3);
        lf_image8_finish(&image);
        lf_quilt_finish(&q);
    }
}

/* Also by the error itself. */
static void tiles_that_do_not_divide_a_picture_are_an_error_of_its_format(void **state)
{
    static const uint8_t pixels[3 * 4 * 3] = {0};
    const lf_raster picture = {.width = 4, .height = 3, .data8 = pixels};
    const lf_photo photo = {0};
    lf_quilt_file q;
    lf_error err = {0};
    (void)state;
    lf_assert_status(lf_quilt_cut(&picture, "p", &(lf_quilt_tiles){3, 1, 3}, &photo, &q, &err),
                     LF_E_FORMAT, &err);
    assert_int_equal(err.status, LF_E_FORMAT);
    assert_non_null(strstr(err.what, "3x1 tiles do not divide 4x3 pixels"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_quilt_comes_back_as_its_views),
        cmocka_unit_test(view_0_is_at_the_bottom_left_and_the_next_to_its_right),
        cmocka_unit_test(padding_at_the_right_and_the_top_is_left_out),
        cmocka_unit_test(a_layout_comes_from_the_name_or_the_caller),
        cmocka_unit_test(a_folder_is_one_view_a_picture_in_name_order),
        cmocka_unit_test(what_is_no_quilt_is_refused),
        cmocka_unit_test(quilts_outside_the_roots_are_not_read),
        cmocka_unit_test(views_that_do_not_fit_the_layout_are_not_written),
        cmocka_unit_test(what_pictures_say_in_vain_is_noted),
        cmocka_unit_test(real_quilts_are_read_as_four_by_eight),
        cmocka_unit_test(tiles_that_do_not_divide_a_picture_are_an_error_of_its_format),
    };
    return cmocka_run_group_tests(tests, lf_test_folder_setup, lf_test_folder_teardown);
}
