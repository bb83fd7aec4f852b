/* Marks around prints, measured in the file in millimetres from the middle of the print, and looked
 * at through a simulated sheet. */
#include "tests/testing.h"

#include <math.h>

#include "base/alloc.h"
#include "tests/quilt/optical_oracle.h"
#include "tests/quilt/printed.h"

#define DPI 600
static const double pixel = 25.4 / DPI;

static lf_print sound_print(void)
{
    return (lf_print){.lpi = 60.13,
                      .dpi = DPI,
                      .width_mm = 60.0,
                      .height_mm = 30.0,
                      .bleed_mm = 2.0,
                      .phase_mm = 0.11,
                      .n_views = 4,
                      .bits = 16,
                      .marks = true};
}

/* Views of white, so that all ink is that of marks. */
static lf_printed printed_white(const lf_print *print)
{
    float *data = lf_calloc((size_t)print->n_views, 3 * sizeof *data);
    lf_printed out;
    assert_non_null(data);
    for (int i = 0; i < 3 * print->n_views; i++)
        data[i] = 1.0F;
    const lf_views32 views = {print->n_views, 1, 1, 3, 3, data, NULL, NULL, NULL};
    lf_printed_make(print, &views, 0, &out);
    lf_free(data);
    return out;
}

/* Ink at a place; x and y from the middle of the file. */
static double ink(const lf_printed *p, double x, double y)
{
    const int column = (int)floor(x / pixel + 0.5 * p->width);
    const int row = (int)floor(y / pixel + 0.5 * p->height);
    assert_in_range(column, 0, p->width - 1);
    assert_in_range(row, 0, p->height - 1);
    return 1.0 - lf_printed_linear(p, column, row, 1);
}

/* Where the ink between two places of a row (or column, down) has its middle, and how wide it is.
 */
static double middle_of_ink(const lf_printed *p, bool down, double from, double to, double other,
                            double *out_width)
{
    double mass = 0, moment = 0;
    const int n = down ? p->height : p->width;
    for (int i = 0; i < n; i++) {
        const double at = (i + 0.5 - 0.5 * n) * pixel;
        if (at < from || at > to)
            continue;
        const double v = down ? ink(p, other, at) : ink(p, at, other);
        mass += v;
        moment += v * at;
    }
    assert_true(mass > 0);
    *out_width = mass * pixel;
    return moment / mass;
}

static void expect_line(const lf_printed *p, bool down, double at, double other)
{
    double width;
    const double middle = middle_of_ink(p, down, at - 0.5, at + 0.5, other, &width);
    lf_assert_close(middle, at, 0.0, 0.003);
    lf_assert_close(width, 0.2, 0.0, 0.003);
}

static void crop_marks_stand_on_the_trim_edges_outside_of_the_bleed(void **state)
{
    (void)state;
    const lf_print print = sound_print();
    lf_printed p = printed_white(&print);
    for (int sx = -1; sx <= 1; sx += 2)
        for (int sy = -1; sy <= 1; sy += 2)
            for (double out = 1.1; out < 6.0; out += 1.2) {
                expect_line(&p, false, 30.0 * sx, (17.0 + out) * sy);
                expect_line(&p, true, 15.0 * sy, (32.0 + out) * sx);
            }
    lf_printed_finish(&p);
}

static void ticks_stand_on_the_axis_of_the_middle_lens_and_crosses_at_the_sides(void **state)
{
    (void)state;
    const lf_print print = sound_print();
    lf_printed p = printed_white(&print);
    double width;
    for (int s = -1; s <= 1; s += 2) {
        expect_line(&p, false, 0.11, (17.0 + 6.5) * s);
        /* the arms of the cross, beside the ring, and the ring */
        expect_line(&p, true, 0.0, (32.0 + 4.0 + 2.2) * s);
        expect_line(&p, true, 0.0, (32.0 + 4.0 - 2.2) * s);
        expect_line(&p, false, (32.0 + 4.0) * s, 2.2);
        expect_line(&p, false, (32.0 + 4.0) * s, -2.2);
        lf_assert_close(middle_of_ink(&p, true, 1.0, 2.0, (32.0 + 4.0 + 0.2) * s, &width),
                        sqrt(1.5 * 1.5 - 0.2 * 0.2), 0.0, 0.01);
    }
    lf_printed_finish(&p);
}

static void nothing_but_the_margin_changes(void **state)
{
    (void)state;
    lf_print print = sound_print();
    lf_printed with = printed_white(&print), without;
    print.marks = false;
    without = printed_white(&print);
    const int margin = (with.width - without.width) / 2;
    lf_assert_close(margin * pixel, 8.0, 0.0, 0.5 * pixel);
    assert_int_equal(with.height - without.height, 2 * margin);
    for (int y = 0; y < without.height; y++)
        assert_memory_equal(with.value + 3 * ((y + margin) * with.width + margin),
                            without.value + 3 * y * without.width,
                            3 * (size_t)without.width * sizeof *with.value);
    const json_t *size = json_object_get(with.manifest, "size");
    const json_t *box = json_object_get(size, "trim_box_mm");
    lf_assert_close(json_number_value(json_array_get(box, 0)), 0.5 * with.width * pixel - 30.0, 0.0,
                    1e-9);
    lf_assert_close(json_number_value(json_object_get(size, "marks_mm")), margin * pixel, 0.0,
                    1e-9);
    lf_printed_finish(&with);
    lf_printed_finish(&without);
}

/* The least and most ink that an eye straight in front sees of a strip through its lenses. */
static void see_strip(const lf_printed *p, double y, double sheet_at, double *out_least,
                      double *out_most)
{
    const lf_sheet sheet = lf_sheet_for(60.13, 400.0, 0.6, 1.56, sheet_at);
    double *light = malloc((size_t)p->width * sizeof *light);
    int first, last;
    assert_non_null(light);
    for (int x = 0; x < p->width; x++)
        light[x] = 1.0 - ink(p, (x + 0.5 - 0.5 * p->width) * pixel, y);
    lf_row_light row = lf_row_light_of(light, p->width, pixel);
    lf_lenses_inside(&sheet, &row, &first, &last);
    *out_least = 1.0;
    *out_most = 0.0;
    for (int k = first; k <= last; k++) {
        if (fabs(lf_focal_point(&sheet, k, 0.0, 400.0, true)) > 28.5)
            continue;
        const double seen =
            1.0 - lf_seen_through(&sheet, &row, k, 0.0, 400.0, 0.05 * sheet.pitch_mm, true);
        *out_least = fmin(*out_least, seen);
        *out_most = fmax(*out_most, seen);
    }
    lf_row_light_finish(&row);
    free(light);
}

static void
strips_look_dark_throughout_when_the_sheet_lies_right_and_bright_half_a_lens_off(void **state)
{
    (void)state;
    const lf_print print = sound_print();
    lf_printed p = printed_white(&print);
    const double pitch = 25.4 / 60.13;
    for (int s = -1; s <= 1; s += 2) {
        double least, most;
        see_strip(&p, (17.0 + 3.0) * s, 0.11, &least, &most);
        assert_true(least >= 0.9);
        see_strip(&p, (17.0 + 3.0) * s, 0.11 + 0.5 * pitch, &least, &most);
        assert_true(most <= 0.1);
        /* the strip is white before and behind it */
        assert_true(ink(&p, 0.11, (17.0 + 0.5) * s) == 0.0);
        assert_true(ink(&p, 0.11 + pitch, (17.0 + 6.5) * s) == 0.0);
    }
    lf_printed_finish(&p);
}

static void horizontal_lenses_have_the_same_marks_turned(void **state)
{
    (void)state;
    lf_print print = sound_print();
    lf_printed upright, turned;
    print.phase_mm = 0.0;
    print.width_mm = 50.8;
    print.height_mm = 25.4;
    print.bleed_mm = 2.54;
    upright = printed_white(&print);
    print.width_mm = 25.4;
    print.height_mm = 50.8;
    print.horizontal = true;
    turned = printed_white(&print);
    assert_int_equal(turned.width, upright.height);
    assert_int_equal(turned.height, upright.width);
    for (int y = 0; y < upright.height; y++)
        for (int x = 0; x < upright.width; x++)
            assert_int_equal(upright.value[3 * (y * upright.width + x)],
                             turned.value[3 * (x * turned.width + y)]);
    lf_printed_finish(&upright);
    lf_printed_finish(&turned);
}

/* Slanted lenses: the lines of the strips continue the lenses, and so does the tick. */
static void marks_lean_with_the_lenses(void **state)
{
    (void)state;
    static const struct {
        double slant;
        bool horizontal;
    } cases[] = {{12, false}, {-20, false}, {7, true}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lf_print print = sound_print();
        const double a = cases[i].slant * acos(-1.0) / 180, pitch = 25.4 / print.lpi / cos(a),
                     lean = (cases[i].horizontal ? 1 : -1) * tan(a);
        print.optics.slant = cases[i].slant;
        print.horizontal = cases[i].horizontal;
        lf_printed p = printed_white(&print);
        const double end = cases[i].horizontal ? 32 : 17;
        for (int s = -1; s <= 1; s += 2) {
            for (double out = 1.1; out < 5.0; out += 0.9)
                for (int k = -15; k <= 15; k += 5) {
                    const double along = (end + out) * s, axis = 0.11 / cos(a) + along * lean;
                    const double at = axis + (k - round(axis / pitch)) * pitch;
                    double width;
                    lf_assert_close(middle_of_ink(&p, cases[i].horizontal, at - 0.5 * pitch,
                                                  at + 0.5 * pitch, along, &width),
                                    at, 0.0, 0.02);
                    lf_assert_close(width, 0.25 * pitch, 0.0, 0.02);
                }
        }
        lf_printed_finish(&p);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(crop_marks_stand_on_the_trim_edges_outside_of_the_bleed),
        cmocka_unit_test(ticks_stand_on_the_axis_of_the_middle_lens_and_crosses_at_the_sides),
        cmocka_unit_test(nothing_but_the_margin_changes),
        cmocka_unit_test(
            strips_look_dark_throughout_when_the_sheet_lies_right_and_bright_half_a_lens_off),
        cmocka_unit_test(horizontal_lenses_have_the_same_marks_turned),
        cmocka_unit_test(marks_lean_with_the_lenses),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
