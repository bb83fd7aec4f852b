/* Compensated prints with an exact map, looked at by Snell's law at any place along the lenses. The
 * oracle shares no code with the map. */
#include "tests/testing.h"

#include "tests/quilt/printed.h"

#define SIDE_MM 40.0
#define DISTANCE_MM 45.0
#define THICKNESS_MM 2.0
#define INDEX 1.56
#define SPOT_MM 0.026
#define DARK 0.45
#define BRIGHT 0.55
#define N_VIEWS 7
#define LIT 3

/* Where an eye in front of the middle sees the point (x, y) of the lens plane on the print: farther
 * out by this factor. */
static double factor_at(double x, double y)
{
    const double r = sqrt(x * x + y * y);
    return r > 0.0 ? 1.0 + THICKNESS_MM * tan(asin(sin(atan(r / DISTANCE_MM)) / INDEX)) / r : 1.0;
}

/* The place across, at `along` on the print, behind the line `lens_mm` of the lens plane. */
static double behind(double lens_mm, double along)
{
    double lens_along = along;
    for (int i = 0; i < 60; i++)
        lens_along = along / factor_at(lens_mm, lens_along);
    return lens_mm * factor_at(lens_mm, lens_along);
}

static lf_print exact_print(bool horizontal, double phase_mm)
{
    lf_print print = lf_print_sound();
    print.lpi = 60.13;
    print.width_mm = print.height_mm = SIDE_MM;
    print.n_views = N_VIEWS;
    print.bits = 16;
    print.horizontal = horizontal;
    print.phase_mm = phase_mm;
    print.optics =
        (lf_optics){.thickness_mm = THICKNESS_MM, .index = INDEX, .distance_mm = DISTANCE_MM};
    print.blur.spot_mm = SPOT_MM;
    return print;
}

static float lit_view(const void *context, int view, int row, int column, int c)
{
    (void)context, (void)row, (void)column, (void)c;
    return view == LIT ? (float)BRIGHT : (float)DARK;
}

/* Light of the pixel at `across` on a line along the sheet. */
static double light_at(const lf_print *print, const lf_printed *printed, int line, int across)
{
    return print->horizontal ? lf_printed_linear(printed, line, across, 1)
                             : lf_printed_linear(printed, across, line, 1);
}

/* share[i]: of the lit view in an eye at view i, the mean of all lenses at a line. */
static void look(const lf_print *print, const lf_printed *printed, int line, double share[N_VIEWS])
{
    const double pixel = 25.4 / print->dpi, visual = 25.4 / print->lpi,
                 along = (line + 0.5 - 0.5 * printed->width) * pixel;
    const double pitch = visual / (1.0 + THICKNESS_MM / (INDEX * DISTANCE_MM));
    for (int i = 0; i < N_VIEWS; i++) {
        double sum = 0.0;
        int n = 0;
        for (int lens = -200; lens <= 200; lens++) {
            /* the stripe of view i, by the conventions: views run from right to left */
            const double stripe = lens + (N_VIEWS - 1 - i + 0.5) / N_VIEWS - 0.5;
            const double at = behind((stripe + print->phase_mm / visual) * pitch, along) / pixel +
                              0.5 * printed->width;
            const double left = at - 0.5 * SPOT_MM / pixel, right = at + 0.5 * SPOT_MM / pixel;
            if (left < 30.0 || right > printed->width - 30.0)
                continue;
            double light = 0.0;
            for (int x = (int)left; x <= (int)right; x++)
                light += (fmin(right, x + 1.0) - fmax(left, x)) *
                         light_at(print, printed, line, x) / (right - left);
            sum += (light - DARK) / (BRIGHT - DARK);
            n++;
        }
        assert_true(n > 80);
        share[i] = sum / n;
    }
}

static void places_are_those_of_an_exact_map(void **state)
{
    (void)state;
    static const double lines[] = {0.0, 0.2, 0.5, 0.76, 0.999};
    for (int horizontal = 0; horizontal < 2; horizontal++) {
        lf_print print = exact_print(horizontal, 0.1);
        lf_views32 views;
        lf_printed plain, better;
        lf_card_make(&print, lit_view, NULL, &views);
        lf_printed_make(&print, &views, 0, &plain);
        print.compensation.on = true;
        lf_printed_make(&print, &views, 0, &better);
        assert_string_equal(
            json_string_value(json_object_get(json_object_get(better.manifest, "lens"), "map")),
            "exact");
        for (size_t l = 0; l < sizeof lines / sizeof *lines; l++) {
            double off[N_VIEWS], on[N_VIEWS];
            const int line = (int)(lines[l] * plain.width);
            look(&print, &plain, line, off);
            look(&print, &better, line, on);
            print_message("line %d: own share %.3f -> %.3f, ghosts %.3f %.3f -> %.3f %.3f\n", line,
                          off[LIT], on[LIT], off[LIT - 1], off[LIT + 1], on[LIT - 1], on[LIT + 1]);
            assert_true(off[LIT] < 0.9);
            assert_true(1.0 - on[LIT] < 0.25 * (1.0 - off[LIT]));
            for (int i = 0; i < N_VIEWS; i++)
                assert_true(i == LIT || fabs(on[i]) <= 0.012);
        }
        lf_printed_finish(&plain);
        lf_printed_finish(&better);
        lf_card_finish(&views);
    }
}

/* Strips of any height, and a print whose map is nearly uniform, give the same. */
static float speckle(const void *context, int view, int row, int column, int c)
{
    return 0.3F + 0.4F * lf_card_speckle(context, view, row, column, c);
}

static void strips_do_not_change_an_exact_print(void **state)
{
    (void)state;
    for (int horizontal = 0; horizontal < 2; horizontal++) {
        lf_print print = exact_print(horizontal, 0.03);
        print.width_mm = print.height_mm = 12.0;
        print.optics.distance_mm = 30.0;
        print.compensation.on = true;
        lf_views32 views;
        lf_printed whole, strips;
        lf_card_make(&print, speckle, NULL, &views);
        lf_printed_make(&print, &views, 0, &whole);
        lf_printed_make(&print, &views, 5, &strips);
        lf_printed_assert_same(&whole, &strips);
        assert_true(json_equal(json_object_get(whole.manifest, "compensation"),
                               json_object_get(strips.manifest, "compensation")));
        lf_printed_finish(&whole);
        lf_printed_finish(&strips);
        lf_card_finish(&views);
    }
}

static void from_far_away_the_map_is_uniform(void **state)
{
    (void)state;
    for (int horizontal = 0; horizontal < 2; horizontal++) {
        lf_print print = exact_print(horizontal, 0.03);
        print.width_mm = print.height_mm = 12.0;
        print.optics.distance_mm = 1e6;
        print.compensation.on = true;
        lf_print uniform = print;
        uniform.optics.map = LF_MAP_UNIFORM;
        /* views of one shape for both */
        static float grey[3 * N_VIEWS];
        for (int i = 0; i < 3 * N_VIEWS; i++)
            grey[i] = 0.35F + 0.05F * (float)(i / 3);
        const lf_views32 views = {N_VIEWS, 1, 1, 3, 3, grey, NULL, NULL, NULL};
        lf_printed a, b;
        int most = 0;
        lf_printed_make(&print, &views, 0, &a);
        lf_printed_make(&uniform, &views, 0, &b);
        for (int y = 0; y < a.height; y++)
            for (int x = 0; x < a.width; x++)
                most =
                    (int)fmax(most, abs(lf_printed_at(&a, x, y, 1) - lf_printed_at(&b, x, y, 1)));
        print_message("from far away: differs by %d of 65535\n", most);
        assert_true(most <= 40);
        lf_printed_finish(&a);
        lf_printed_finish(&b);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(places_are_those_of_an_exact_map),
        cmocka_unit_test(strips_do_not_change_an_exact_print),
        cmocka_unit_test(from_far_away_the_map_is_uniform),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
