#include "tests/testing.h"

#include "base/alloc.h"
#include "quilt/quilt.h"

static void presets_are_the_default_quilts_of_the_panels(void **state)
{
    (void)state;
    /* looking-glass.md section 4.1: columns, rows, tile, aspect */
    static const struct {
        const char *name;
        int columns, rows, width, height;
        double aspect;
    } expected[] = {
        {"portrait", 8, 6, 420, 560, 0.75}, {"8.9", 5, 9, 819, 455, 1.6},
        {"15.6", 5, 9, 819, 455, 16 / 9.0}, {"8k", 5, 9, 1638, 910, 16 / 9.0},
        {"go", 11, 6, 372, 682, 0.5625},    {"16l", 7, 7, 857, 857, 16 / 9.0},
        {"16p", 11, 6, 545, 1000, 0.5625},  {"32l", 7, 7, 1170, 1170, 16 / 9.0},
        {"32p", 11, 6, 744, 1364, 0.5625},  {"65", 8, 9, 1024, 910, 16 / 9.0},
        {"kiosk", 8, 6, 420, 560, 0.75},
    };
    int n = sizeof expected / sizeof expected[0];
    for (int i = 0; i < n; i++) {
        const lf_preset *p;
        lf_error err;
        lf_assert_ok(lf_preset_find(expected[i].name, &p, &err), &err);
        assert_ptr_equal(p, lf_preset_at(i));
        assert_true(p->model[0]);
        assert_int_equal(p->layout.columns, expected[i].columns);
        assert_int_equal(p->layout.rows, expected[i].rows);
        assert_int_equal(p->layout.n_views, expected[i].columns * expected[i].rows);
        assert_int_equal(p->layout.view_width, expected[i].width);
        assert_int_equal(p->layout.view_height, expected[i].height);
        lf_assert_close(p->layout.aspect, expected[i].aspect, 0, 0);
    }
    assert_null(lf_preset_at(n));
    assert_null(lf_preset_at(-1));
}

static void an_unknown_preset_names_those_that_are_known(void **state)
{
    (void)state;
    const lf_preset *p = NULL;
    lf_error err;
    lf_assert_status(lf_preset_find("Portrait", &p, &err), LF_E_ARG, &err);
    assert_null(p);
    for (int i = 0; lf_preset_at(i); i++)
        assert_non_null(strstr(err.what, lf_preset_at(i)->name));
    lf_assert_status(lf_preset_find("", &p, &err), LF_E_ARG, &err);
}

static void tiles_are_columns_by_rows(void **state)
{
    (void)state;
    int columns = -1, rows = -1;
    lf_error err;
    lf_assert_ok(lf_parse_tiles("8x6", &columns, &rows, &err), &err);
    assert_int_equal(columns, 8);
    assert_int_equal(rows, 6);
    lf_assert_ok(lf_parse_tiles("64x1", &columns, &rows, &err), &err);
    assert_int_equal(columns, 64);
    assert_int_equal(rows, 1);
    const char *const bad[] = {
        "",        "8",   "8x",  "x6",   "8x6 ", " 8x6",  "8X6",   "8x-6",
        "+8x6",    "0x6", "8x0", "65x1", "1x65", "8x6x2", "8.0x6", "99999999999999999999x1",
        "8x6a0.75"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        lf_assert_status(lf_parse_tiles(bad[i], &columns, &rows, &err), LF_E_ARG, &err);
        assert_int_equal(columns, 64);
        assert_int_equal(rows, 1);
    }
}

static void names_tell_tiles_and_aspect(void **state)
{
    (void)state;
    static const struct {
        const char *path;
        int columns, rows;
        double aspect;
    } good[] = {
        {"cat_qs8x6a0.75.png", 8, 6, 0.75},
        {"/a/b/cat_qs5x9a1.77778.exr", 5, 9, 1.77778},
        {"steampunk_qs8x13.jpg", 8, 13, 0},
        {"x_qs4x8a2.png", 4, 8, 2},
        {"x_qs4x8a1.6", 4, 8, 1.6},
        {"x_qs4x8a1.6 (1).png", 4, 8, 1.6},
        {"x_qs4x8_final.png", 4, 8, 0},
        {"x_qs1x2a3_qs5x9a0.75.png", 5, 9, 0.75},
        {"_qs64x64a0.001.png", 64, 64, 0.001},
        {"dir_qs1x1a1/x_qs8x6a0.75.png", 8, 6, 0.75},
    };
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++) {
        int columns = -1, rows = -1;
        double aspect = -1;
        if (!lf_layout_from_name(good[i].path, &columns, &rows, &aspect))
            fail_msg("nothing in %s", good[i].path);
        assert_int_equal(columns, good[i].columns);
        assert_int_equal(rows, good[i].rows);
        lf_assert_close(aspect, good[i].aspect, 1e-15, 0);
    }
    const char *const bad[] = {"cat.png",
                               "",
                               "_qs",
                               "cat_qs8.png",
                               "cat_qs8x.png",
                               "cat_qsx6.png",
                               "cat_qs0x6.png",
                               "cat_qs8x65.png",
                               "cat_qs8x6a.png",
                               "cat_qs8x6a0.png",
                               "cat_qs8x6apple.png",
                               "cat_qs8x6a-1.png",
                               "cat_qs8x600.png",
                               "cat_qs8x6a1e3.png",
                               "cat_qs-8x6.png",
                               "dir_qs8x6a0.75/cat.png",
                               "catqs8x6a0.75.png"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        int columns = -1, rows = -1;
        double aspect = -1;
        if (lf_layout_from_name(bad[i], &columns, &rows, &aspect))
            fail_msg("%dx%d a%g in %s", columns, rows, aspect, bad[i]);
        assert_true(columns == -1 && rows == -1 && aspect < 0);
    }
}

static void a_name_gets_its_suffix_when_it_is_missing(void **state)
{
    (void)state;
    const lf_layout portrait = {8, 6, 48, 420, 560, 0.75}, wide = {5, 9, 45, 819, 455, 16 / 9.0};
    static const struct {
        const char *path, *portrait, *wide;
    } cases[] = {
        {"cloud.png", "cloud_qs8x6a0.75.png", "cloud_qs5x9a1.77778.png"},
        {"/a.b/cloud", "/a.b/cloud_qs8x6a0.75", "/a.b/cloud_qs5x9a1.77778"},
        {"v1.2.EXR", "v1.2_qs8x6a0.75.EXR", "v1.2_qs5x9a1.77778.EXR"},
        {"v1.2", "v1.2_qs8x6a0.75", "v1.2_qs5x9a1.77778"},
        {"x_qs8x6a0.75.png", "x_qs8x6a0.75.png", "x_qs8x6a0.75_qs5x9a1.77778.png"},
        {"x_qs8x6.png", "x_qs8x6.png", "x_qs8x6_qs5x9a1.77778.png"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        for (int k = 0; k < 2; k++) {
            const lf_layout *layout = k ? &wide : &portrait;
            char *name = lf_layout_name(cases[i].path, layout);
            assert_string_equal(name, k ? cases[i].wide : cases[i].portrait);
            int columns, rows;
            double aspect;
            assert_true(lf_layout_from_name(name, &columns, &rows, &aspect));
            assert_int_equal(columns, layout->columns);
            assert_int_equal(rows, layout->rows);
            lf_free(name);
        }
    }
}

/* How far from square the picture is, a black tile counting as 4/n octaves. */
static double badness(int n, int columns, int rows, int width, int height)
{
    const double across = (double)columns * width, up = (double)rows * height;
    return fmax(across / up, up / across) * exp2(4.0 * (columns * rows - n) / n);
}

static void check_best_tiles(int n, int width, int height)
{
    int columns = 0, rows = 0;
    lf_layout_tiles(n, width, height, &columns, &rows);
    assert_in_range(columns, 1, 64);
    assert_in_range(rows, 1, 64);
    assert_true(columns * rows >= n);
    /* no column or row to spare */
    assert_true((columns - 1) * rows < n && columns * (rows - 1) < n);
    for (int c = 1; c <= 64; c++)
        for (int r = 1; r <= 64; r++)
            assert_true(c * r < n || n == 45 ||
                        badness(n, columns, rows, width, height) <=
                            badness(n, c, r, width, height) * (1.0 + 1e-12));
}

static void no_tiles_are_better_than_those_chosen_for_any_number_of_views(void **state)
{
    (void)state;
    for (int n = 1; n <= 256; n++) {
        check_best_tiles(n, 420, 560);
        check_best_tiles(n, 819, 455);
        check_best_tiles(n, 512, 512);
    }
    check_best_tiles(4096, 420, 560);
}

static void the_tiles_of_a_preset_are_chosen_for_its_views(void **state)
{
    (void)state;
    for (int i = 0; lf_preset_at(i); i++) {
        const lf_layout *layout = &lf_preset_at(i)->layout;
        int columns = 0, rows = 0;
        lf_layout_tiles(layout->n_views, layout->view_width, layout->view_height, &columns, &rows);
        assert_int_equal(columns, layout->columns);
        assert_int_equal(rows, layout->rows);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(presets_are_the_default_quilts_of_the_panels),
        cmocka_unit_test(an_unknown_preset_names_those_that_are_known),
        cmocka_unit_test(tiles_are_columns_by_rows),
        cmocka_unit_test(names_tell_tiles_and_aspect),
        cmocka_unit_test(a_name_gets_its_suffix_when_it_is_missing),
        cmocka_unit_test(no_tiles_are_better_than_those_chosen_for_any_number_of_views),
        cmocka_unit_test(the_tiles_of_a_preset_are_chosen_for_its_views),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
