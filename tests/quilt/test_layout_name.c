#include "tests/testing.h"

#include "base/alloc.h"
#include "quilt/quilt.h"

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
        {"x_qs4x8a1.60.png", 4, 8, 1.6},
        {"x_qs08x6.png", 8, 6, 0},
        {"x_qs8x6a0.75.0001.png", 8, 6, 0.75},
        {"x_qs8x6a0.75_60fps.mp4", 8, 6, 0.75},
        {"x_qs8x6a0.5625, last.png", 8, 6, 0.5625},
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
                               "cat_qs8x6a0.75x.png",
                               "cat_qs8x6a1,5.png",
                               "cat_qs8x6a0x3.png",
                               "cat_qs8x6ainf.png",
                               "cat_qs8x6anan.png",
                               "cat_qs8x6a+1.png",
                               "cat_qs0x8x6.png",
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tiles_are_columns_by_rows),
        cmocka_unit_test(names_tell_tiles_and_aspect),
        cmocka_unit_test(a_name_gets_its_suffix_when_it_is_missing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
