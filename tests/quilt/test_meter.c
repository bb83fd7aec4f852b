#include "tests/testing.h"

#include "quilt/quilt.h"

enum { N = 1000 };

static void fill(float *rgb, int from, int to, float value)
{
    for (int i = 3 * from; i < 3 * to; i++)
        rgb[i] = value;
}

static double exposure_of(const float *rgb, size_t n)
{
    static lf_meter meter;
    memset(&meter, 0, sizeof meter);
    lf_meter_add(&meter, n, rgb);
    return lf_meter_exposure(&meter);
}

/* One grey becomes 0.8: to an eighth of a stop, and what a sixteenth of an octave is wide. */
static void an_even_picture_becomes_light_grey(void **state)
{
    (void)state;
    float rgb[3 * N];
    for (int i = -60; i <= 60; i++) {
        float value = (float)exp2(i / 4.0 + 0.03);
        fill(rgb, 0, N, value);
        double stops = exposure_of(rgb, N);
        lf_assert_close((double)value * exp2(stops), 0.8, 0.1, 0);
        assert_true(stops * 8 == round(stops * 8));
        fill(rgb, 0, N, 2 * value);
        assert_true(exposure_of(rgb, N) == stops - 1);
    }
}

/* Luminance of the primaries by Rec. 709. */
static void colours_count_as_bright_as_they_look(void **state)
{
    (void)state;
    const double weight[3] = {0.2126, 0.7152, 0.0722};
    for (int c = 0; c < 3; c++) {
        float rgb[3] = {0};
        rgb[c] = 1;
        lf_assert_close(weight[c] * exp2(exposure_of(rgb, 1)), 0.8, 0.1, 0);
    }
}

static void a_few_bright_pixels_black_ones_and_no_numbers_change_nothing(void **state)
{
    (void)state;
    float rgb[3 * N];
    fill(rgb, 0, N, 0.3f);
    double stops = exposure_of(rgb, N);
    fill(rgb, 0, 20, 1e6f);
    assert_true(exposure_of(rgb, N) == stops);
    /* 4.9 % and, as a negative control, 5.1 % of what counts */
    fill(rgb, 0, 49, 1e6f);
    assert_true(fabs(exposure_of(rgb, N) - stops) <= 0.125);
    fill(rgb, 0, 51, 1e6f);
    assert_true(exposure_of(rgb, N) < -15);
    fill(rgb, 0, 51, 0.3f);
    fill(rgb, 0, 400, 0.0f);
    fill(rgb, 400, 500, -1.0f);
    fill(rgb, 500, 600, NAN);
    fill(rgb, 600, 700, INFINITY);
    assert_true(exposure_of(rgb, N) == stops);
    fill(rgb, 0, N, 0.0f);
    assert_true(exposure_of(rgb, N) == 0);
    fill(rgb, 0, N, 1e-38f);
    assert_true(exposure_of(rgb, N) == 32);
    fill(rgb, 0, N, 3e38f);
    assert_true(exposure_of(rgb, N) == -32);
}

/* Counts are the same in whatever parts a picture comes. */
static void parts_add_up_to_the_whole(void **state)
{
    (void)state;
    float rgb[3 * N];
    static lf_meter whole, first, rest, views;
    for (int i = 0; i < 3 * N; i++)
        rgb[i] = (float)exp2(i % 997 / 50.0 - 12);
    lf_meter_add(&whole, N, rgb);
    lf_meter_add(&first, 333, rgb);
    lf_meter_add(&rest, N - 333, rgb + 3 * 333);
    lf_meter_merge(&rest, &first);
    assert_memory_equal(&whole, &rest, sizeof whole);
    lf_meter_add_views(&views, &(lf_views32){.n_views = 5,
                                             .width = 10,
                                             .height = 20,
                                             .view_stride = 30,
                                             .row_stride = 150,
                                             .data = rgb});
    assert_memory_equal(&whole, &views, sizeof whole);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_even_picture_becomes_light_grey),
        cmocka_unit_test(colours_count_as_bright_as_they_look),
        cmocka_unit_test(a_few_bright_pixels_black_ones_and_no_numbers_change_nothing),
        cmocka_unit_test(parts_add_up_to_the_whole),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
