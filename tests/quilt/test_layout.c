#include "tests/testing.h"

#include "quilt/quilt.h"

static void presets_are_the_default_quilts_of_the_panels(void **state)
{
    (void)state;
    /* columns, rows, tile, aspect; sources in quilt/layout.c */
    static const struct {
        const char *name;
        int columns, rows, width, height;
        double aspect;
    } expected[] = {
        {"portrait", 8, 6, 420, 560, 0.75}, {"8.9", 5, 9, 819, 455, 1.6},
        {"15.6", 5, 9, 819, 455, 16 / 9.0}, {"8k", 5, 9, 1638, 910, 16 / 9.0},
        {"go", 11, 6, 372, 682, 0.5625},    {"16l", 7, 7, 857, 857, 16 / 9.0},
        {"16p", 11, 6, 545, 1000, 0.5625},  {"27l", 8, 6, 960, 720, 16 / 9.0},
        {"27p", 12, 4, 640, 1080, 0.5625},  {"32l", 7, 7, 1170, 1170, 16 / 9.0},
        {"32p", 11, 6, 744, 1364, 0.5625},  {"65", 8, 9, 1024, 910, 16 / 9.0},
        {"kiosk", 8, 6, 420, 560, 0.75},    {"hld", 1, 1, 2160, 3840, 0.5625},
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

/* Of those that are square: quilts of the 27" are as wide as their panel. */
static void the_tiles_of_a_preset_are_chosen_for_its_views(void **state)
{
    (void)state;
    for (int i = 0; lf_preset_at(i); i++) {
        const lf_layout *layout = &lf_preset_at(i)->layout;
        int columns = 0, rows = 0;
        if (layout->columns * layout->view_width > layout->rows * layout->view_height * 3 / 2)
            continue;
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
        cmocka_unit_test(no_tiles_are_better_than_those_chosen_for_any_number_of_views),
        cmocka_unit_test(the_tiles_of_a_preset_are_chosen_for_its_views),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
