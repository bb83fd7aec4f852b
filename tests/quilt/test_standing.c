/* Finished views are moved, scaled and shifted. */
#include "tests/testing.h"

#include "quilt/rgbd.h"

static void finished_views_move_scale_and_shift(void **state)
{
    (void)state;
    enum { N = 3, W = 20, H = 10 };
    static uint8_t in[N][H][W][3], out[N][H][W][3];
    for (int i = 0; i < N * H * W; i++) {
        uint8_t *to = &in[0][0][0][0] + 3 * i;
        to[0] = (uint8_t)(10 * (i % W) + 5);
        to[1] = (uint8_t)(20 * (i / W % H) + 5);
        to[2] = (uint8_t)(50 * (i / W / H) + 5);
    }
    const lf_views8 views = {N, W, H, sizeof in[0], sizeof in[0][0], &in[0][0][0][0]};
    lf_standing standing = {.focus = 0.1};
    lf_standing_views8(&standing, &views, &out[0][0][0][0], NULL);
    for (int i = 0; i < N; i++)
        for (int x = 0; x < W; x++) {
            int from = x - 2 * (i - 1); /* two pixels to the right in the last view */
            from = from < 0 ? -1 - from : from >= W ? 2 * W - 1 - from : from;
            assert_memory_equal(out[i][4][x], in[i][4][from], 3);
        }
    standing = (lf_standing){.zoom = 2, .crop_x = 0.25};
    lf_standing_views8(&standing, &views, &out[0][0][0][0], NULL);
    lf_assert_close(out[1][5][10][0], 10 * (12.5 + 0.25), 0, 0.6); /* the middle is at 12.5 */
    lf_assert_close(out[1][5][10][1], 20 * 5.25 - 5, 0, 0.6);
    standing = (lf_standing){.zoom = 0.5};
    lf_standing_views8(&standing, &views, &out[0][0][0][0], NULL);
    assert_int_equal(out[1][5][4][0], 0);
    lf_assert_close(out[1][5][5][0], 10, 0, 0.6); /* the mean of 5 and 15 */
    assert_int_equal(out[1][1][5][2], 0);
    standing.on_paper = true;
    lf_standing_views8(&standing, &views, &out[0][0][0][0], NULL);
    assert_int_equal(out[1][1][5][2], 255);
    lf_assert_close(out[1][5][5][0], 10, 0, 0.6);
    assert_true(lf_standing_is_plain(&(lf_standing){.zoom = 1}));
    assert_false(lf_standing_is_plain(&(lf_standing){.zoom = 1, .crop_y = 0.1}));
}

static void float_views_are_refused(void **state)
{
    (void)state;
    lf_quilt_file quilt = {.is_float = true};
    lf_error err = {0};
    const lf_standing moved = {.focus = 0.1}, plain = {0};
    assert_int_equal(lf_quilt_stand(&moved, "x.exr", &quilt, NULL, &err), LF_E_ARG);
    assert_non_null(strstr(err.what, "8-bit"));
    lf_assert_ok(lf_quilt_stand(&plain, "x.exr", &quilt, NULL, &err), &err);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(finished_views_move_scale_and_shift),
        cmocka_unit_test(float_views_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
