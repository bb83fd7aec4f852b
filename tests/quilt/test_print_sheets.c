/* Slanted and micro prints: weights, samples, what is refused, and any options at all. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "quilt/lens.h"
#include "quilt/print/print.h"
#include "tests/quilt/printed.h"

static const double pi = 3.14159265358979323846;

/* --------------------------------------------------------------------------------- the phase -- */

static void the_phase_of_a_panel_gives_its_views(void **state)
{
    (void)state;
    lf_calibration panel = {.screen_width_px = 317,
                            .screen_height_px = 211,
                            .pitch = 47.57,
                            .slope = -5.44,
                            .center = 0.17,
                            .dpi = 338,
                            .config_version = "3.0"};
    for (int variant = 0; variant < 4; variant++) {
        panel.flip_image_x = variant & 1;
        panel.flip_subp = variant & 2;
        const lf_lens lens = lf_lens_of_panel(&panel, LF_INVERT_AUTO);
        for (int i = 0; i < 500; i++) {
            const int x = i * 31 % 317, y = i * 17 % 211, c = i % 3;
            double z;
            const double phase = lf_lens_phase(&lens, (x + 0.5) / 317.0, (y + 0.5) / 211.0, c);
            const int view = lf_view_of_subpixel(&panel, 48, LF_INVERT_AUTO, x, y, c, &z);
            const double part = phase - floor(phase);
            assert_true(z == 48 * fmin(fmax(lens.from_right ? 1 - part : part, 1e-5), 0.999999));
            assert_int_equal(view, (int)z);
        }
    }
}

/* Forward by Snell's law, and back. */
static void the_map_finds_the_lens_that_an_eye_looks_through(void **state)
{
    (void)state;
    static const struct {
        double thickness, index, distance;
    } cases[] = {{0.6, 1.56, 400}, {2.5, 1.5, 150}, {50, 1.1, 20}, {0.01, 3, 1e6}, {20, 3, 20}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const lf_lens lens = {.thickness = cases[i].thickness,
                              .index = cases[i].index,
                              .distance = cases[i].distance};
        for (double r = 0.01; r < 3000; r *= 1.7) {
            const double seen =
                r +
                cases[i].thickness * tan(asin(sin(atan(r / cases[i].distance)) / cases[i].index));
            lf_assert_close(lf_lens_factor(&lens, seen) * seen, r, 1e-9, 1e-9);
        }
        assert_true(lf_lens_factor(&lens, 0.0) < 1.0);
    }
    assert_true(lf_lens_factor(&(lf_lens){0}, 10.0) == 1.0);
}

/* Between points of a line, the interpolated map is off by no more than is said, and somewhere by
 * a part of that. */
static void the_error_of_an_interpolated_map_is_bounded(void **state)
{
    (void)state;
    static const struct {
        double thickness, index, distance, step;
    } cases[] = {{0.6, 1.56, 400, 1.35}, {0.6, 1.56, 400, 40}, {2.5, 1.5, 150, 3},
                 {50, 1.1, 20, 0.5},     {20, 3, 20, 5},       {1, 1.6, 20, 0.04}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const lf_lens lens = {.thickness = cases[i].thickness,
                              .index = cases[i].index,
                              .distance = cases[i].distance};
        const double step = cases[i].step, most = lf_lens_factor_error(&lens, step);
        double worst = 0;
        for (double x = -6 * cases[i].distance; x < 6 * cases[i].distance; x += 0.7 * step)
            for (double y = 0; y < 4 * cases[i].distance; y = 2 * y + step) {
                const double low = lf_lens_factor(&lens, hypot(x, y)),
                             high = lf_lens_factor(&lens, hypot(x + step, y));
                for (double k = 0.25; k < 1; k += 0.25) {
                    const double radius = hypot(x + k * step, y),
                                 off = low + k * (high - low) - lf_lens_factor(&lens, radius);
                    worst = fmax(worst, radius * fabs(off));
                }
            }
        if (!(worst <= most + 1e-12 && worst > 0.02 * most))
            fail_msg("case %zu: off by %g, said %g", i, worst, most);
    }
}

/* In the middle, and where it meets the uniform one, the exact map has the same lens 0 and pitch.
 */
static void both_maps_agree_in_the_middle(void **state)
{
    (void)state;
    lf_print print = lf_print_sound();
    print.phase_mm = 0.3;
    print.optics.thickness_mm = 0.6;
    print.optics.distance_mm = 300;
    const lf_lens exact = lf_lens_of_print(&print);
    print.optics.map = LF_MAP_UNIFORM;
    const lf_lens uniform = lf_lens_of_print(&print);
    assert_true(exact.thickness > 0 && uniform.thickness == 0);
    lf_assert_close(lf_lens_phase(&uniform, 0.3, 0.0, 1), 0.0, 0.0, 1e-12);
    for (double x = -2; x < 2; x += 0.37)
        lf_assert_close(lf_lens_phase(&exact, x, 0.1, 0), lf_lens_phase(&uniform, x, 0.1, 0), 0.0,
                        1e-6);
    assert_true(fabs(lf_lens_phase(&exact, 300, 0, 0) - lf_lens_phase(&uniform, 300, 0, 0)) > 0.05);
}

/* ------------------------------------------------------------------------------- the weights -- */

static void a_share_is_the_area_of_the_pixel_below_a_line(void **state)
{
    (void)state;
    enum { SIDE = 400 };
    static const double changes[][2] = {{1, 0},      {0, 1},     {0.8, -0.3},
                                        {-0.3, 0.8}, {0.5, 0.5}, {7, 0.01}};
    for (size_t i = 0; i < sizeof changes / sizeof *changes; i++) {
        const double right = changes[i][0], down = changes[i][1];
        const lf_pixel_spread spread = lf_pixel_spread_of(right, down);
        for (double t = -1.0; t <= 1.0; t += 0.1) {
            int below = 0;
            for (int k = 0; k < SIDE * SIDE; k++)
                below += right * ((k % SIDE + 0.5) / SIDE - 0.5) +
                             down * ((k / SIDE + 0.5) / SIDE - 0.5) <
                         t;
            lf_assert_close(lf_pixel_share(&spread, t), below / (double)(SIDE * SIDE), 0.0, 3e-3);
        }
        assert_true(lf_pixel_share(&spread, 10) == 1.0 && lf_pixel_share(&spread, -10) == 0.0);
    }
}

/* ----------------------------------------------------------------------------------- samples -- */

static lf_print slanted_print(void)
{
    lf_print print = lf_print_odd();
    print.width_mm = 12;
    print.height_mm = 9;
    print.optics.slant = 14;
    return print;
}

static lf_print micro_print(lf_lens_grid grid)
{
    lf_print print = lf_print_odd();
    print.lpi = 60;
    print.n_views = 25;
    print.width_mm = 12;
    print.height_mm = 9;
    print.optics.grid = grid;
    return print;
}

static void made(const lf_print *print, int rows_per_strip, lf_printed *out)
{
    lf_views32 card;
    lf_card_make(print, lf_card_speckle, NULL, &card);
    lf_printed_make(print, &card, rows_per_strip, out);
    lf_card_finish(&card);
}

/* A slant that moves nothing by a thousandth of a stripe. */
static void the_smallest_slant_is_a_straight_print(void **state)
{
    (void)state;
    for (int kind = 0; kind < 4; kind++) {
        lf_print print = lf_print_odd();
        print.horizontal = kind & 1;
        print.reverse = kind & 2;
        print.width_mm = print.height_mm = 11.7;
        print.view_aspect = 1;
        lf_printed straight, slanted;
        /* a picture of another shape, so that both are sampled in the same way */
        float pictures[7][8][8][3];
        for (int i = 0; i < 7 * 8 * 8 * 3; i++)
            (&pictures[0][0][0][0])[i] =
                lf_card_speckle(NULL, i / 192, i / 24 % 8, i / 3 % 8, i % 3);
        const lf_views32 views = {7, 8, 8, 192, 24, &pictures[0][0][0][0], NULL, NULL, NULL};
        lf_printed_make(&print, &views, 0, &straight);
        print.optics.slant = 1e-7;
        lf_printed_make(&print, &views, 0, &slanted);
        assert_int_equal(straight.width, slanted.width);
        for (int i = 0; i < straight.width * straight.height * 3; i++)
            assert_true(abs(straight.value[i] - slanted.value[i]) < 8);
        lf_printed_finish(&straight);
        lf_printed_finish(&slanted);
    }
}

static void strips_of_any_height_have_the_same_picture(void **state)
{
    (void)state;
    lf_print prints[8] = {slanted_print(), slanted_print(), micro_print(LF_LENS_SQUARE),
                          micro_print(LF_LENS_HEXAGONAL), slanted_print()};
    prints[1].horizontal = true;
    prints[3].optics.slant = 2;
    prints[4].optics.thickness_mm = 0.5;
    prints[4].optics.distance_mm = 200;
    /* horizontal ones, straight, steep, and in three columns */
    for (int i = 5; i < 8; i++) {
        prints[i] = prints[4];
        prints[i].horizontal = true;
        prints[i].optics.slant = i == 5 ? 0 : i == 6 ? 55 : 9;
    }
    prints[7].width_mm = 4;
    prints[7].sheet.columns = 3;
    for (size_t i = 0; i < sizeof prints / sizeof *prints; i++) {
        lf_printed one, seven, all;
        made(&prints[i], 1, &one);
        made(&prints[i], 7, &seven);
        made(&prints[i], 1000, &all);
        lf_printed_assert_same(&one, &seven);
        lf_printed_assert_same(&one, &all);
        lf_printed_finish(&one);
        lf_printed_finish(&seven);
        lf_printed_finish(&all);
    }
}

/* Thick, near and coarse, where the map bends within a block of pixels. */
static void every_pixel_is_under_its_place_of_the_map(void **state)
{
    (void)state;
    const float light[2][3] = {{0, 0, 0}, {1, 1, 1}};
    const lf_views32 views = {2, 1, 1, 3, 3, &light[0][0], NULL, NULL, NULL};
    for (int kind = 0; kind < 3; kind++) {
        lf_print print = lf_print_sound();
        lf_printed printed;
        print.lpi = 30;
        print.n_views = 2;
        print.dpi = print.dpi_down = 150;
        print.width_mm = print.height_mm = 40;
        print.stripes = LF_STRIPES_NEAREST;
        print.horizontal = kind == 1;
        print.optics = (lf_optics){
            .thickness_mm = 3, .index = 1.5, .distance_mm = 40, .slant = kind == 2 ? 8 : 0};
        lf_printed_make(&print, &views, 0, &printed);
        const lf_lens lens = lf_lens_of_print(&print);
        for (int y = 0; y < printed.height; y++)
            for (int x = 0; x < printed.width; x++) {
                const double phase =
                                 lf_lens_phase(&lens, (x + 0.5 - 0.5 * printed.width) / 150 * 25.4,
                                               (y + 0.5 - 0.5 * printed.height) / 150 * 25.4, 0),
                             part = phase + 0.5 - floor(phase + 0.5);
                const bool is_left = part < 0.5;
                if (fmin(fabs(part - 0.5), fmin(part, 1 - part)) < 1e-5)
                    continue;
                const int value = printed.value[3 * (y * printed.width + x)];
                if ((value > 128) != (lens.from_right == is_left))
                    fail_msg("kind %d: pixel %d, %d is %d", kind, x, y, value);
            }
        lf_printed_finish(&printed);
    }
}

/* Rows of copies in turn have what each of them has alone. */
static void copies_do_not_change_each_other(void **state)
{
    (void)state;
    enum { SIDE = 9, PIXELS = 200 };
    float light[8][SIDE][SIDE][3], in_turn[3 * PIXELS], alone[3 * PIXELS];
    lf_print print = slanted_print();
    lf_error err;
    lf_tone *tone;
    for (int i = 0; i < 8 * SIDE * SIDE * 3; i++)
        (&light[0][0][0][0])[i] = (float)(i * 37 % 101) / 100;
    print.n_views = 8;
    print.lpi = 40;
    print.dpi = print.dpi_down = 600;
    print.width_mm = print.height_mm = PIXELS * 25.4 / 600;
    print.bleed_mm = 0;
    print.horizontal = true;
    const lf_views32 views = {8,    SIDE, SIDE, SIDE * SIDE * 3, SIDE * 3, &light[0][0][0][0],
                              NULL, NULL, NULL};
    lf_print_shape shape;
    lf_print_source source;
    lf_print_shape_of(&print, &shape);
    assert_int_equal(shape.raster_width, PIXELS);
    lf_assert_ok(lf_tone_create(0, "srgb", &tone, &err), &err);
    assert_int_equal(lf_print_source_init(&source, &print, &shape, &views, tone), LF_OK);
    lf_slanted *both, *one;
    assert_int_equal(lf_slanted_create(&print, &shape, &source, &both), LF_OK);
    assert_int_equal(lf_slanted_create(&print, &shape, &source, &one), LF_OK);
    lf_slanted_row(both, 70, in_turn);
    shape.shift_right_mm = 1.3;
    lf_slanted_row(both, 70, in_turn);
    lf_slanted_row(one, 70, alone);
    assert_memory_equal(in_turn, alone, sizeof alone);
    lf_slanted_destroy(both);
    lf_slanted_destroy(one);
    lf_print_source_finish(&source);
    lf_tone_destroy(tone);
}

/* Every axis of a lens that touches the picture lies between two samples, in every row. */
static void samples_reach_every_lens(void **state)
{
    (void)state;
    for (int i = -11; i <= 11; i++) {
        lf_print print = slanted_print();
        lf_print_shape shape;
        print.optics.slant = 5.3 * i;
        print.phase_mm = 0.021 * i;
        lf_print_shape_of(&print, &shape);
        const double pitch = 25.4 / print.lpi / cos(print.optics.slant * pi / 180),
                     half = 0.5 * shape.raster_width * 25.4 / print.dpi,
                     last = shape.first_across_mm + (shape.n_lenses - 1) * shape.step_across_mm;
        if (i == 0)
            continue;
        lf_assert_close(shape.step_across_mm, pitch, 1e-12, 0.0);
        assert_true(shape.first_across_mm <= -half - 0.5 * pitch);
        assert_true(last >= half + 0.5 * pitch);
        assert_true(shape.n_lenses < 2 * half / pitch + 5);
        lf_assert_close(shape.window_center_x_mm, 0.5 * (shape.first_across_mm + last), 0.0, 1e-9);
        lf_assert_close(shape.window_width_mm, shape.n_lenses * pitch, 1e-12, 0.0);
        /* lens first_lens crosses the middle row at its sample */
        const lf_lens lens = lf_lens_of_print(&print);
        lf_assert_close(lf_lens_phase(&lens, shape.first_across_mm, 0.0, 0), shape.first_lens, 0.0,
                        1e-9);
    }
}

/* ----------------------------------------------------------------------------------- refused -- */

static void assert_refused(const lf_print *print, const char *words)
{
    lf_error err;
    lf_assert_status(lf_print_check(print, NULL, &err), LF_E_ARG, NULL);
    if (!strstr(err.what, words))
        fail_msg("\"%s\" lacks \"%s\"", err.what, words);
}

static void what_a_sheet_cannot_have_is_refused_in_words(void **state)
{
    (void)state;
    lf_print p;
    lf_error err;
    p = slanted_print(), p.optics.slant = 61, assert_refused(&p, "slant");
    p = slanted_print(), p.optics.slant = (double)NAN, assert_refused(&p, "slant");
    p = slanted_print(), p.optics.map = LF_MAP_EXACT, assert_refused(&p, "thickness");
    p.optics.thickness_mm = 1, assert_refused(&p, "distance");
    p.optics.distance_mm = 300, lf_assert_ok(lf_print_check(&p, NULL, &err), &err);
    p = slanted_print(), p.optics.view_rows = 3, assert_refused(&p, "micro");
    p = slanted_print(), p.optics.phase_down_mm = 1, assert_refused(&p, "micro");
    p = micro_print(LF_LENS_SQUARE), p.horizontal = true, assert_refused(&p, "orientation");
    p = micro_print(LF_LENS_SQUARE), p.marks = true, assert_refused(&p, "marks");
    p = micro_print(LF_LENS_SQUARE), p.n_views = 26, assert_refused(&p, "rows");
    p.optics.view_rows = 13, assert_refused(&p, "each way");
    p.optics.view_rows = 2, p.n_views = 24, lf_assert_ok(lf_print_check(&p, NULL, &err), &err);
    p.optics.view_rows = 30, assert_refused(&p, "rows");
}

/* A micro sheet has as many views as its lens shows both ways, or those that there are. */
static void views_of_micro_sheets_are_chosen(void **state)
{
    (void)state;
    static const struct {
        int most, rows, chosen; /* 0: refused */
    } cases[] = {{9999, 0, 81}, {81, 0, 81}, {64, 0, 64},   {48, 0, 0},    {48, 6, 48}, {48, 5, 45},
                 {9999, 3, 27}, {1, 0, 1},   {100, 0, 100}, {144, 0, 144}, {169, 0, 81}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lf_print p = micro_print(LF_LENS_SQUARE);
        lf_error err = {0};
        p.n_views = 0;
        p.optics.view_rows = cases[i].rows;
        const lf_status status = lf_print_choose_views(&p, cases[i].most, "x", NULL, &err);
        assert_int_equal(status == LF_OK, cases[i].chosen > 0);
        assert_int_equal(p.n_views, cases[i].chosen);
    }
    /* a leaning lens is longer along a row */
    lf_print p = slanted_print();
    lf_error err = {0};
    p.n_views = 0;
    p.lpi = 60;
    p.optics.slant = 45;
    lf_assert_ok(lf_print_choose_views(&p, 99, "x", NULL, &err), &err);
    assert_int_equal(p.n_views, 13);
}

/* Not all views, and not more. */
static void a_micro_sheet_shows_all_views_or_none(void **state)
{
    (void)state;
    const lf_print print = micro_print(LF_LENS_SQUARE);
    const float light[3 * 24] = {0};
    const lf_views32 views = {24, 1, 1, 3, 3, light, NULL, NULL, NULL};
    const lf_print_run run = {0};
    lf_outfile file = {.fd = -1};
    lf_error err;
    lf_assert_status(lf_print_write(&print, &views, &run, &file, &file, &err), LF_E_ARG, &err);
    assert_non_null(strstr(err.what, "there are 24, but 5 x 5"));
}

static void the_manifest_tells_the_sheet(void **state)
{
    (void)state;
    lf_print print = slanted_print();
    lf_printed printed;
    print.lpi = 60;
    print.optics.thickness_mm = 0.6;
    print.optics.distance_mm = 400;
    made(&print, 0, &printed);
    const json_t *lens = json_object_get(printed.manifest, "lens");
    assert_string_equal(json_string_value(json_object_get(lens, "map")), "exact");
    assert_string_equal(json_string_value(json_object_get(lens, "grid")), "linear");
    lf_assert_close(json_number_value(json_object_get(lens, "slant")), 14, 0, 0);
    assert_true(json_is_true(json_object_get(lens, "index_is_assumed")));
    lf_assert_close(json_number_value(json_object_get(lens, "mechanical_lpi")),
                    60 * (1 + 0.6 / (1.56 * 400)), 1e-12, 0);
    lf_printed_finish(&printed);
    print = micro_print(LF_LENS_HEXAGONAL);
    print.n_views = 24;
    print.optics.view_rows = 4;
    print.mirror = true;
    made(&print, 0, &printed);
    const json_t *stripes = json_object_get(printed.manifest, "stripes");
    assert_int_equal(json_integer_value(json_object_get(stripes, "rows")), 4);
    assert_int_equal(json_array_size(json_object_get(stripes, "order")), 6);
    assert_int_equal(json_integer_value(json_array_get(json_object_get(stripes, "order"), 0)), 0);
    assert_int_equal(json_integer_value(json_array_get(json_object_get(stripes, "row_order"), 0)),
                     0);
    assert_true(
        json_is_null(json_object_get(json_object_get(printed.manifest, "lens"), "mechanical_lpi")));
    lf_printed_finish(&printed);
}

/* ------------------------------------------------------------------------------- any options -- */

static double any_of(const double *values, size_t n, uint32_t *random)
{
    *random = *random * 1664525u + 1013904223u;
    return values[(*random >> 10) % n];
}

/* Whatever passes the check can be printed, and every pixel is a mixture of views. */
static void any_sheet_is_refused_or_printed(void **state)
{
    (void)state;
    static const double lpi[] = {5, 20, 25, 61.3, 600, NAN}, dpi[] = {50, 300, 600, 9600},
                        slant[] = {0, 0, 1e-9, -60, 60, 33, 7, INFINITY, NAN},
                        thickness[] = {0, 0, 0.01, 0.6, 3, 50, -1, NAN},
                        index[] = {0, 0, 1.1, 1.5, 3, 0.9},
                        distance[] = {0, 20, 300, 1e6, 500, INFINITY},
                        phase[] = {0, 100, -100, 0.1}, whole[] = {1, 2, 4, 4, 9, 9, 60, 3};
    const char *many = getenv("QUILTD_LONG");
    uint32_t random = 5;
    int printed_ones = 0;
    for (int i = 0; i < (many ? 20000 : 1500); i++) {
        lf_print print = lf_print_sound();
        lf_error err;
#define ANY(list) any_of(list, sizeof(list) / sizeof *(list), &random)
        print.width_mm = print.height_mm = 1;
        print.lpi = ANY(lpi);
        print.dpi = ANY(dpi);
        print.dpi_down = ANY(dpi);
        if (print.dpi > 700 && print.dpi_down > 700)
            print.dpi_down = 50;
        print.phase_mm = ANY(phase);
        print.n_views = i % 50 ? (int)ANY(whole) : i % 100 / 50 - 1;
        print.horizontal = ANY(whole) < 2;
        print.rolled = print.horizontal && ANY(whole) < 2;
        print.stripes = ANY(whole) < 2 ? LF_STRIPES_NEAREST : LF_STRIPES_FRACTIONAL;
        print.optics = (lf_optics){.slant = ANY(slant),
                                   .grid = (lf_lens_grid)((int)ANY(whole) % 3 & 3),
                                   .map = (lf_lens_map)((int)ANY(whole) % 3 & 3),
                                   .thickness_mm = ANY(thickness),
                                   .index = ANY(index),
                                   .distance_mm = ANY(distance),
                                   .view_rows = ANY(whole) > 2 ? 0 : (int)ANY(whole),
                                   .phase_down_mm = i % 3 ? 0 : ANY(phase)};
#undef ANY
        if (lf_print_check(&print, NULL, &err) != LF_OK)
            continue;
        float white[3 * 4096];
        for (size_t k = 0; k < sizeof white / sizeof *white; k++)
            white[k] = 0.5F;
        const lf_views32 views = {print.n_views, 2, 2, 0, 6, white, NULL, NULL, NULL};
        lf_printed printed;
        lf_printed_make(&print, &views, 0, &printed);
        for (int k = 0; k < printed.width * printed.height * 3; k++)
            assert_in_range(printed.value[k], 187, 189);
        lf_printed_finish(&printed);
        printed_ones++;
    }
    print_message("%d printed\n", printed_ones);
    assert_true(printed_ones > 60);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_phase_of_a_panel_gives_its_views),
        cmocka_unit_test(the_map_finds_the_lens_that_an_eye_looks_through),
        cmocka_unit_test(the_error_of_an_interpolated_map_is_bounded),
        cmocka_unit_test(both_maps_agree_in_the_middle),
        cmocka_unit_test(a_share_is_the_area_of_the_pixel_below_a_line),
        cmocka_unit_test(the_smallest_slant_is_a_straight_print),
        cmocka_unit_test(strips_of_any_height_have_the_same_picture),
        cmocka_unit_test(every_pixel_is_under_its_place_of_the_map),
        cmocka_unit_test(copies_do_not_change_each_other),
        cmocka_unit_test(samples_reach_every_lens),
        cmocka_unit_test(what_a_sheet_cannot_have_is_refused_in_words),
        cmocka_unit_test(views_of_micro_sheets_are_chosen),
        cmocka_unit_test(a_micro_sheet_shows_all_views_or_none),
        cmocka_unit_test(the_manifest_tells_the_sheet),
        cmocka_unit_test(any_sheet_is_refused_or_printed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
