/* Mixed images: exact at both ends, rounded between them, and the same before and after
 * interlacing. */
#include "tests/testing.h"

#include "quilt/quilt.h"

enum { WIDTH = 256, HEIGHT = 256 };

/* A pixel of `from` for each column's code, one of `to` for each row's. */
static void every_pair_of_codes_is_rounded_to_nearest(void **state)
{
    (void)state;
    static const int weights[] = {0, 1, 64, 127, 128, 255, LF_BLEND_WHOLE};
    lf_image8 from = {0}, to = {0}, out = {0};
    lf_pool *pool;
    lf_assert_ok(lf_pool_create(2, &pool), NULL);
    lf_assert_ok(lf_image8_init(&from, WIDTH, HEIGHT, 3), NULL);
    lf_assert_ok(lf_image8_init(&to, WIDTH, HEIGHT, 3), NULL);
    lf_assert_ok(lf_image8_init(&out, WIDTH, HEIGHT, 3), NULL);
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++) {
        from.data[i] = (uint8_t)(i / 3 % WIDTH);
        to.data[i] = (uint8_t)(i / 3 / WIDTH);
    }
    for (size_t k = 0; k < 2 * sizeof weights / sizeof *weights; k++) {
        const int weight = weights[k / 2];
        lf_blend(&from, &to, weight, &out, k % 2 ? pool : NULL);
        for (int i = 0; i < WIDTH * HEIGHT * 3; i++) {
            const double share = weight / 256.0,
                         exact = from.data[i] * (1 - share) + to.data[i] * share;
            assert_int_equal(out.data[i], (int)floor(exact + 0.5));
        }
    }
    lf_blend(&from, &to, LF_BLEND_WHOLE, &from, pool); /* in place */
    assert_memory_equal(from.data, to.data, WIDTH * HEIGHT * 3);
    lf_pool_destroy(pool);
    lf_image8_finish(&from);
    lf_image8_finish(&to);
    lf_image8_finish(&out);
}

enum { VIEWS = 7, VIEW = 24, BYTES = VIEWS * VIEW * VIEW * 3 };

static lf_views8 views_of(const uint8_t data[BYTES])
{
    return (lf_views8){.n_views = VIEWS,
                       .width = VIEW,
                       .height = VIEW,
                       .view_stride = VIEW * VIEW * 3,
                       .row_stride = VIEW * 3,
                       .data = data};
}

static void mixed_panel_images_are_those_of_mixed_views(void **state)
{
    (void)state;
    static uint8_t data[3][BYTES];
    lf_calibration calibration;
    lf_interlacer *interlacer;
    lf_image8 panel[4] = {{0}};
    lf_error err;
    lf_calibration_portrait(&calibration);
    calibration.screen_width_px = 96;
    calibration.screen_height_px = 128;
    lf_assert_ok(lf_interlacer_create(&calibration, VIEWS, VIEW, VIEW, 1, LF_FILTER_NEAREST,
                                      LF_INVERT_AUTO, &interlacer, &err),
                 &err);
    for (int k = 0; k < 4; k++)
        lf_assert_ok(lf_image8_init(&panel[k], 96, 128, 3), NULL);
    for (int i = 0; i < BYTES; i++) {
        data[0][i] = (uint8_t)(i * 7 + i / 41);
        data[1][i] = (uint8_t)(i * 13 + i / 97);
    }
    for (int weight = 0; weight <= LF_BLEND_WHOLE; weight += 32) {
        lf_image8 all[3];
        for (int k = 0; k < 3; k++)
            all[k] = (lf_image8){VIEW, VIEW * VIEWS, 3, VIEW * 3, data[k]};
        lf_blend(&all[0], &all[1], weight, &all[2], NULL);
        for (int k = 0; k < 3; k++) {
            const lf_views8 views = views_of(data[k]);
            lf_interlace(interlacer, &views, &panel[k], NULL);
        }
        lf_blend(&panel[0], &panel[1], weight, &panel[3], NULL);
        assert_memory_equal(panel[3].data, panel[2].data, 96 * 128 * 3);
        assert_true(weight % LF_BLEND_WHOLE == 0 ||
                    memcmp(panel[3].data, panel[0].data, 96 * 128 * 3) != 0);
    }
    for (int k = 0; k < 4; k++)
        lf_image8_finish(&panel[k]);
    lf_interlacer_destroy(interlacer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_pair_of_codes_is_rounded_to_nearest),
        cmocka_unit_test(mixed_panel_images_are_those_of_mixed_views),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
