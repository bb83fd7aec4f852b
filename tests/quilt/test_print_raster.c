/* Printers whose raster is no whole number of dots an inch, or not the same both ways: every pixel
 * against a brute-force interlacer that knows inches alone, and what the file says of itself. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "quilt/prints.h"
#include "tests/quilt/printed.h"

typedef struct raster_case {
    double right, down; /* dots per inch across the page and down it */
    double lpi, phase_mm;
    int n_views;
    bool horizontal;
} raster_case;

static const raster_case cases[] = {
    {812.8, 812.8, 60.13, 0, 7, false}, {720, 1440, 60, 0.013, 12, false},
    {720, 1440, 60.13, 0.11, 9, false}, {1440, 720, 60.13, -0.07, 11, false},
    {720, 1440, 60.13, 0.05, 11, true}, {1440, 720, 50.2, 0, 14, true},
    {600.25, 360, 40.1, 0, 8, false},   {812.8, 406.4, 75.55, 0.2, 5, true},
};

static lf_print print_of(const raster_case *c, lf_stripes stripes)
{
    return (lf_print){.lpi = c->lpi,
                      .dpi = c->right,
                      .dpi_down = c->down == c->right ? 0 : c->down,
                      .width_mm = 12.3,
                      .height_mm = 9.1,
                      .phase_mm = c->phase_mm,
                      .n_views = c->n_views,
                      .horizontal = c->horizontal,
                      .stripes = stripes,
                      .bits = 16};
}

/* Numbers of lens and view at so many inches from the middle of the print, across the lenses. */
static void stripe_at(const raster_case *c, double inches, long *out_lens, int *out_view,
                      double *out_from_border)
{
    double lenses = (inches - c->phase_mm / 25.4) * c->lpi + 0.5, within = lenses - floor(lenses);
    double stripe = c->n_views * within;
    *out_lens = (long)floor(lenses);
    *out_view = c->n_views - 1 - (int)fmin(floor(stripe), c->n_views - 1);
    *out_from_border = fabs(stripe - round(stripe));
}

/* The light of a card there; along: the pixel's number along the lenses. */
static double card_at(const raster_case *c, const lf_print_shape *shape, long lens, int view,
                      int along, int channel)
{
    int sample = (int)(lens - shape->first_lens);
    sample = sample < 0 ? 0 : sample >= shape->n_lenses ? shape->n_lenses - 1 : sample;
    return (double)lf_card_speckle(NULL, view, c->horizontal ? sample : along,
                                   c->horizontal ? along : sample, channel);
}

static void assert_size(const raster_case *c, const lf_print *print, const lf_printed *printed)
{
    assert_int_equal(printed->width, lround(print->width_mm / 25.4 * c->right));
    assert_int_equal(printed->height, lround(print->height_mm / 25.4 * c->down));
}

static double inches_of(const raster_case *c, const lf_printed *printed, double x, double y)
{
    return c->horizontal ? (y - 0.5 * printed->height) / c->down
                         : (x - 0.5 * printed->width) / c->right;
}

static void every_pixel_is_the_stripe_at_its_middle(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const raster_case *c = &cases[i];
        const lf_print print = print_of(c, LF_STRIPES_NEAREST);
        lf_print_shape shape;
        lf_views32 card;
        lf_printed printed;
        int n = 0;
        lf_print_shape_of(&print, &shape);
        lf_card_make(&print, lf_card_speckle, NULL, &card);
        lf_printed_make(&print, &card, 0, &printed);
        assert_size(c, &print, &printed);
        for (int y = 0; y < printed.height; y++)
            for (int x = 0; x < printed.width; x++) {
                long lens;
                int view;
                double border;
                stripe_at(c, inches_of(c, &printed, x + 0.5, y + 0.5), &lens, &view, &border);
                if (border < 1e-6)
                    continue;
                double right = card_at(c, &shape, lens, view, c->horizontal ? x : y, 1);
                if (fabs(lf_printed_linear(&printed, x, y, 1) - right) > 1e-4)
                    fail_msg("case %zu, pixel %d %d: %g, not %g", i, x, y,
                             lf_printed_linear(&printed, x, y, 1), right);
                n++;
            }
        assert_true(n > printed.width * printed.height * 9 / 10);
        lf_printed_finish(&printed);
        lf_card_finish(&card);
    }
}

/* By 256 points of each pixel. */
static void every_pixel_is_the_mix_of_what_it_covers(void **state)
{
    (void)state;
    enum { POINTS = 256 };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const raster_case *c = &cases[i];
        const lf_print print = print_of(c, LF_STRIPES_FRACTIONAL);
        lf_print_shape shape;
        lf_views32 card;
        lf_printed printed;
        lf_print_shape_of(&print, &shape);
        lf_card_make(&print, lf_card_speckle, NULL, &card);
        lf_printed_make(&print, &card, 0, &printed);
        assert_size(c, &print, &printed);
        for (int y = 0; y < printed.height; y += 7)
            for (int x = 0; x < printed.width; x += c->horizontal ? 7 : 1) {
                double sum = 0;
                for (int k = 0; k < POINTS; k++) {
                    long lens;
                    int view;
                    double border, step = (k + 0.5) / POINTS;
                    stripe_at(c, inches_of(c, &printed, x + step, y + step), &lens, &view, &border);
                    sum += card_at(c, &shape, lens, view, c->horizontal ? x : y, 0) / POINTS;
                }
                if (fabs(lf_printed_linear(&printed, x, y, 0) - sum) > 2.0 / POINTS)
                    fail_msg("case %zu, pixel %d %d: %g, not %g", i, x, y,
                             lf_printed_linear(&printed, x, y, 0), sum);
            }
        lf_printed_finish(&printed);
        lf_card_finish(&card);
    }
}

/* ------------------------------------------------------------------------------ what it says -- */

static uint32_t little(const uint8_t *p, int n)
{
    uint32_t v = 0;
    for (int i = n - 1; i >= 0; i--)
        v = v << 8 | p[i];
    return v;
}

static void fraction_of(const lf_printed *printed, uint32_t tag, uint32_t out[2])
{
    const uint8_t *directory = printed->file + little(printed->file + 4, 4);
    out[0] = out[1] = 0;
    for (uint32_t i = 0; i < little(directory, 2); i++) {
        const uint8_t *entry = directory + 2 + 12 * i;
        if (little(entry, 2) != tag)
            continue;
        assert_int_equal(little(entry + 2, 2), 5);
        out[0] = little(printed->file + little(entry + 8, 4), 4);
        out[1] = little(printed->file + little(entry + 8, 4) + 4, 4);
    }
}

static const struct {
    double right, down;
    uint32_t x[2], y[2];
    const char *json;   /* of the size in the manifest … */
    const char *option; /* … and of the options */
} said[] = {
    {600, 0, {600, 1}, {600, 1}, "600", "600"},
    {600, 600, {600, 1}, {600, 1}, "600", "600"},
    {812.8, 0, {4064, 5}, {4064, 5}, "812.8", "812.8"},
    {720, 1440, {720, 1}, {1440, 1}, "[720.0,1440.0]", "\"720x1440\""},
    {99.97, 1016.5, {9997, 100}, {2033, 2}, "[99.97,1016.5]", "\"99.97x1016.5\""},
};

static void assert_json(const json_t *value, const char *expected, double tolerance)
{
    json_t *other = json_loads(expected, JSON_DECODE_ANY, NULL);
    assert_non_null(other);
    assert_non_null(value);
    assert_int_equal(json_typeof(value), json_typeof(other));
    if (json_is_array(other))
        for (size_t i = 0; i < 2; i++)
            lf_assert_close(json_number_value(json_array_get(value, i)),
                            json_number_value(json_array_get(other, i)), tolerance, 0);
    else if (json_is_string(other))
        assert_string_equal(json_string_value(value), json_string_value(other));
    else
        lf_assert_close(json_number_value(value), json_number_value(other), tolerance, 0);
    json_decref(other);
}

static void the_file_says_its_raster_exactly(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof said / sizeof *said; i++)
        for (int marks = 0; marks < 2; marks++) {
            lf_print print = lf_print_sound();
            lf_views32 card;
            lf_printed printed;
            uint32_t x[2], y[2];
            const double down = said[i].down > 0 ? said[i].down : said[i].right;
            print.dpi = said[i].right;
            print.dpi_down = said[i].down;
            print.lpi = 20;
            print.n_views = 2;
            print.marks = marks;
            lf_card_make(&print, lf_card_speckle, NULL, &card);
            lf_printed_make(&print, &card, 0, &printed);
            fraction_of(&printed, 282, x);
            fraction_of(&printed, 283, y);
            assert_memory_equal(x, said[i].x, sizeof x);
            assert_memory_equal(y, said[i].y, sizeof y);
            const json_t *size = json_object_get(printed.manifest, "size"),
                         *options = json_object_get(printed.manifest, "options");
            assert_json(json_object_get(size, "dpi"), said[i].json, 1e-12);
            assert_json(json_object_get(options, "dpi"), said[i].option, 1e-12);
            const json_t *mm = json_object_get(size, "raster_mm");
            lf_assert_close(json_number_value(json_array_get(mm, 0)),
                            printed.width * 25.4 / said[i].right, 1e-12, 0);
            lf_assert_close(json_number_value(json_array_get(mm, 1)), printed.height * 25.4 / down,
                            1e-12, 0);
            assert_int_equal(printed.width, lround(50.8 / 25.4 * said[i].right) +
                                                (marks ? 2 * lround(8 / 25.4 * said[i].right) : 0));
            assert_int_equal(printed.height, lround(2.54 / 25.4 * down) +
                                                 (marks ? 2 * lround(8 / 25.4 * down) : 0));
            lf_printed_finish(&printed);
            lf_card_finish(&card);
        }
}

/* The lines of a chart's bands, an inch apart their number apart, on either raster. */
static void a_chart_has_its_lines_an_inch_in_every_raster(void **state)
{
    (void)state;
    static const double rasters[][2] = {{600, 600}, {812.8, 812.8}, {720, 1440}, {1440, 720}};
    for (size_t i = 0; i < 4; i++)
        for (int horizontal = 0; horizontal < 2; horizontal++) {
            const lf_print print = {.lpi = 20,
                                    .dpi = rasters[i][0],
                                    .dpi_down = rasters[i][1],
                                    .width_mm = 80,
                                    .height_mm = 80,
                                    .horizontal = horizontal,
                                    .bits = 8,
                                    .chart_range = 0.5,
                                    .chart_step = 0.5};
            lf_printed printed;
            lf_printed_chart(&print, &printed);
            const double across = rasters[i][horizontal], along = rasters[i][!horizontal];
            /* the middle of the middle band, from the top of the chart; 3 bands between 5 and 8 mm
             */
            const double middle = 5 + 1.5 * (80 - 13) / 3 - 0.05 * (80 - 13) / 3;
            const int row = (int)(middle / 25.4 * along);
            for (int inch = -1; inch <= 1; inch++) {
                const int n = horizontal ? printed.height : printed.width;
                const int at = (int)(0.5 * n + inch * across);
                const int gap = (int)(0.5 * n + inch * across + 0.5 * across / 20);
                const int on = horizontal ? lf_printed_at(&printed, printed.width - 1 - row, at, 0)
                                          : lf_printed_at(&printed, at, row, 0),
                          off = horizontal
                                    ? lf_printed_at(&printed, printed.width - 1 - row, gap, 0)
                                    : lf_printed_at(&printed, gap, row, 0);
                if (on > 8 || off < 247)
                    fail_msg("%gx%g, %d inch: %d on a line, %d beside it", rasters[i][0],
                             rasters[i][1], inch, on, off);
            }
            lf_printed_finish(&printed);
        }
}

/* ----------------------------------------------------------------------------------- options -- */

static void the_option_takes_one_number_or_two(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        double lpi, dpi, down;
    } good[] = {{"60.13@600", 60.13, 600, 0},
                {"60.13@812.8", 60.13, 812.8, 0},
                {"60@720x1440", 60, 720, 1440},
                {"60@720x720", 60, 720, 0},
                {"60@812.8x406.4", 60, 812.8, 406.4}};
    static const char *const bad[] = {
        "60@",    "60@720x",    "60@x720", "60@720x1440x2", "60@0x2d0", "60@720,5",
        "60@49",  "60@720x49",  "60@9601", "60@720x9600.1", "60@ 720",  "60@720 x 720",
        "60@inf", "60@nanx600", "60@72e",  "60@720X1440",   "60",       "60@720*1440"};
    const lf_param *row = lf_param_find(lf_print_params, "print");
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        lf_print print = {.bits = 8};
        lf_error err;
        lf_assert_ok(lf_param_from_text(row, good[i].text, &print, &err), &err);
        assert_true(print.lpi == good[i].lpi && print.dpi == good[i].dpi &&
                    print.dpi_down == good[i].down);
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        lf_print print = {.bits = 8};
        lf_error err = {0};
        if (lf_param_from_text(row, bad[i], &print, &err) != LF_E_ARG ||
            !strstr(err.what, "DPI a number from 50 to 9600 dpi, or two as XxY"))
            fail_msg("%s: \"%s\"", bad[i], err.what);
        assert_true(print.dpi == 0 && print.lpi == 0);
    }
}

static void json_takes_a_number_or_a_text_of_two(void **state)
{
    (void)state;
    static const struct {
        const char *json;
        double dpi, down; /* 0: refused */
    } cases_of[] = {{"600", 600, 0},         {"812.8", 812.8, 0},
                    {"\"812.8\"", 812.8, 0}, {"\"720x1440\"", 720, 1440},
                    {"\"720x\"", 0, 0},      {"49", 0, 0},
                    {"[720, 1440]", 0, 0},   {"\"720x9601\"", 0, 0},
                    {"true", 0, 0}};
    for (size_t i = 0; i < sizeof cases_of / sizeof *cases_of; i++) {
        lf_print print;
        lf_error err = {0};
        char text[64];
        snprintf(text, sizeof text, "{\"dpi\": %s}", cases_of[i].json);
        json_t *values = json_loads(text, 0, NULL);
        lf_param_defaults(lf_print_params, &print);
        lf_status status = lf_param_from_json(lf_print_params, values, &print, "export", &err);
        if ((status == LF_OK) != (cases_of[i].dpi > 0) ||
            (status == LF_OK &&
             (print.dpi != cases_of[i].dpi || print.dpi_down != cases_of[i].down)))
            fail_msg("%s: %s \"%s\"", text, lf_status_name(status), err.what);
        json_decref(values);
    }
}

/* The finer direction across the lenses gives the views their number. */
static void views_are_counted_across_the_lenses(void **state)
{
    (void)state;
    for (int horizontal = 0; horizontal < 2; horizontal++) {
        lf_print print = {.lpi = 60,
                          .dpi = 720,
                          .dpi_down = 1440,
                          .width_mm = 20,
                          .height_mm = 20,
                          .horizontal = horizontal,
                          .bits = 8};
        lf_error err;
        lf_assert_ok(lf_print_choose_views(&print, 1000, "x", NULL, &err), &err);
        assert_int_equal(print.n_views, horizontal ? 19 : 9);
        print.n_views = horizontal ? 25 : 13;
        lf_assert_status(lf_print_check(&print, NULL, &err), LF_E_ARG, &err);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_pixel_is_the_stripe_at_its_middle),
        cmocka_unit_test(every_pixel_is_the_mix_of_what_it_covers),
        cmocka_unit_test(the_file_says_its_raster_exactly),
        cmocka_unit_test(a_chart_has_its_lines_an_inch_in_every_raster),
        cmocka_unit_test(the_option_takes_one_number_or_two),
        cmocka_unit_test(json_takes_a_number_or_a_text_of_two),
        cmocka_unit_test(views_are_counted_across_the_lenses),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
