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

enum { LARGE_N = 4, LARGE_W = 33, LARGE_H = 21 };

/* A quilt of two columns, as a file has it: the views of a row lie side by side. */
static void make_quilt(lf_quilt_file *quilt)
{
    lf_image8 *image = &quilt->image8;
    *quilt = (lf_quilt_file){.layout = {.n_views = LARGE_N}};
    lf_assert_ok(lf_image8_init(image, 2 * LARGE_W, 2 * LARGE_H, 3), NULL);
    for (size_t i = 0; i < image->stride * (size_t)image->height; i++)
        image->data[i] = (uint8_t)(31 * i % 251);
    quilt->views8 = (lf_views8){LARGE_N, LARGE_W, LARGE_H, 0, image->stride, image->data};
}

/* Views of a quilt file become packed ones, with the same bytes for any number of threads. */
static void a_quilts_views_are_replaced(void **state)
{
    (void)state;
    static const lf_standing how[] = {{.focus = 0.1}, {.zoom = 1.5, .crop_y = 0.25, .focus = -0.2}};
    for (int i = 0; i < 2; i++) {
        static uint8_t expected[LARGE_N][LARGE_H][LARGE_W][3];
        for (int threads = 0; threads <= 3; threads++) {
            lf_quilt_file quilt;
            lf_pool *pool = NULL;
            lf_error err;
            make_quilt(&quilt);
            const size_t row = quilt.image8.stride;
            quilt.views8.view_stride = row * LARGE_H / 3; /* views overlap: any stride will do */
            if (threads == 0)
                lf_standing_views8(&how[i], &quilt.views8, &expected[0][0][0][0], NULL);
            else
                lf_assert_ok(lf_pool_create(threads, &pool), NULL);
            lf_assert_ok(lf_quilt_stand(&how[i], "q.png", &quilt, pool, &err), &err);
            assert_int_equal(quilt.views8.n_views, LARGE_N);
            assert_int_equal(quilt.views8.width, LARGE_W);
            assert_int_equal(quilt.views8.height, LARGE_H);
            for (int view = 0; view < LARGE_N; view++)
                for (int y = 0; y < LARGE_H; y++)
                    assert_memory_equal(lf_views8_row(&quilt.views8, view, y), expected[view][y],
                                        sizeof expected[view][y]);
            lf_pool_destroy(pool);
            lf_quilt_finish(&quilt);
        }
    }
}

static void crop_moves_down_too(void **state)
{
    (void)state;
    enum { W = 4, H = 20 };
    static uint8_t in[H][W][3], out[H][W][3];
    for (int y = 0; y < H; y++)
        memset(in[y], 10 * y + 5, sizeof in[y]);
    const lf_views8 views = {1, W, H, sizeof in, sizeof in[0], &in[0][0][0]};
    const lf_standing standing = {.zoom = 1, .crop_y = 0.5};
    lf_standing_views8(&standing, &views, &out[0][0][0], NULL);
    for (int y = 0; y < H; y++) /* what was 5 pixels below the middle is in the middle */
        assert_int_equal(out[y][1][0], y < H - 5 ? in[y + 5][1][0] : 0);
}

/* A view that only moves, by a part of a pixel, is drawn with other code than one that is scaled.
 */
static void moving_is_scaling_by_one(void **state)
{
    (void)state;
    enum { N = 3, W = 17, H = 3 };
    static uint8_t in[N * H * W * 3], moved[N * H * W * 3], scaled[N * H * W * 3];
    for (size_t i = 0; i < sizeof in; i++)
        in[i] = (uint8_t)(97 * i % 241);
    const lf_views8 views = {N, W, H, sizeof in / N, sizeof in / N / H, in};
    for (double focus = -1; focus <= 1; focus += 0.07) {
        const lf_standing moves = {.focus = focus}, scales = {.focus = focus, .zoom = 1 + 1e-9};
        lf_standing_views8(&moves, &views, moved, NULL);
        lf_standing_views8(&scales, &views, scaled, NULL);
        for (size_t i = 0; i < sizeof in; i++)
            lf_assert_close(moved[i], scaled[i], 0, 1); /* both round */
    }
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
        cmocka_unit_test(a_quilts_views_are_replaced),
        cmocka_unit_test(crop_moves_down_too),
        cmocka_unit_test(moving_is_scaling_by_one),
        cmocka_unit_test(float_views_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
