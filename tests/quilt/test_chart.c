/* Pitch test charts, measured in the file, and read through simulated lens sheets: nothing here
 * knows how they are drawn but what users are told. */
#include "tests/testing.h"

#include <math.h>
#include <tiffio.h>

#include "tests/quilt/optical_oracle.h"
#include "tests/quilt/printed.h"

#define DPI 600
static const double pixel = 25.4 / DPI;

static lf_print sound_chart(void)
{
    return (lf_print){.lpi = 60.0,
                      .chart_range = 0.5,
                      .chart_step = 0.1,
                      .dpi = DPI,
                      .width_mm = 120.0,
                      .height_mm = 50.0,
                      .bits = 8};
}

/* Ink of a pixel, 0..1. */
static double ink(const lf_printed *p, int x, int y)
{
    return 1.0 - lf_printed_linear(p, x, y, 1);
}

/* ------------------------------------------------------------------------------------- bands -- */

typedef struct band {
    int y;            /* a row through its middle */
    int left, right;  /* pixels of its grating: [left, right) */
    double labelled;  /* what its label says */
    double from, end; /* mm, by the manifest */
} band;

/* Bands by the manifest's places; gratings by what is dark in a row. */
static int find_bands(const lf_printed *p, band *bands, int most)
{
    const json_t *list = json_object_get(json_object_get(p->manifest, "chart"), "bands");
    const int n = (int)json_array_size(list);
    const double half =
        0.5 *
        json_number_value(json_object_get(json_object_get(p->manifest, "chart"), "grating_mm"));
    assert_true(n <= most);
    for (int i = 0; i < n; i++) {
        const json_t *b = json_array_get(list, (size_t)i);
        bands[i].from = json_number_value(json_object_get(b, "from_mm"));
        bands[i].end = json_number_value(json_object_get(b, "to_mm"));
        bands[i].labelled = json_number_value(json_object_get(b, "lpi"));
        bands[i].y = (int)(0.5 * (bands[i].from + bands[i].end) / pixel);
        bands[i].left = (int)ceil(0.5 * p->width - half / pixel) + 1;
        bands[i].right = (int)floor(0.5 * p->width + half / pixel) - 1;
    }
    return n;
}

/* Lines per inch from the middles of the dark lines, weighed by ink, and a straight line through
 * them; *out_middle is where a line would lie nearest the middle of the print. */
static double measure(const lf_printed *p, const band *b, double *out_middle)
{
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, mass = 0, moment = 0;
    bool begun = false; /* the first line may be cut: begin behind a gap */
    for (int x = b->left; x < b->right; x++) {
        const double v = ink(p, x, b->y);
        if (v < 0.002 && begun && mass > 0) {
            const double at = (moment / mass + 0.5 - 0.5 * p->width) * pixel;
            sx += n, sxx += n * n, sy += at, sxy += n * at, n += 1;
        }
        if (v < 0.002)
            begun = true, mass = moment = 0;
        mass += v;
        moment += v * x;
    }
    assert_true(n > 100);
    const double pitch = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    const double first = (sy - pitch * sx) / n;
    *out_middle = first - pitch * round(first / pitch);
    return 25.4 / pitch;
}

static void every_band_has_the_pitch_that_it_is_said_to_have(void **state)
{
    (void)state;
    const lf_print print = sound_chart();
    lf_printed p;
    band bands[32] = {0};
    lf_printed_chart(&print, &p);
    const int n = find_bands(&p, bands, 32);
    assert_int_equal(n, 11);
    for (int i = 0; i < n; i++) {
        double middle;
        const double lpi = measure(&p, &bands[i], &middle);
        lf_assert_close(bands[i].labelled, 59.5 + 0.1 * i, 0.0, 1e-9);
        lf_assert_close(lpi / bands[i].labelled, 1.0, 0.0, 1e-5);
        lf_assert_close(middle, 0.0, 0.0, 0.001);
    }
    lf_printed_finish(&p);
}

/* ------------------------------------------------------------------------------------ labels -- */

static const char glyphs[] = "0123456789.";
static const char *const drawn[] = {
    ".###.#...##..###.#.###..##...#.###.", "..#...##....#....#....#....#...###.",
    ".###.#...#....#...#...#...#...#####", "#####...#...#.....#.....##...#.###.",
    "...#...##..#.#.#..#.#####...#....#.", "######....####.....#....##...#.###.",
    "..##..#...#....####.#...##...#.###.", "#####....#...#...#...#....#....#...",
    ".###.#...##...#.###.#...##...#.###.", ".###.#...##...#.####....#...#..##..",
    "..........................##...##.."};

/* The number written between two columns of pixels, about a row. */
static double read_number(const lf_printed *p, int x0, int x1, int y0, int y1)
{
    int left = x1, top = y1, bottom = y0, length = 0;
    char text[16] = "";
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++)
            if (ink(p, x, y) > 0.5) {
                left = x < left ? x : left;
                top = y < top ? y : top;
                bottom = y > bottom ? y : bottom;
            }
    const double square = 2.5 / 7.0 / pixel;
    lf_assert_close((bottom + 1 - top) * pixel, 2.5, 0.0, 1.01 * pixel);
    for (; left + (6 * length + 5) * square < x1 && length < 15; length++) {
        char cells[36] = "";
        for (int c = 0; c < 35; c++) {
            const int column = 6 * length + c % 5, row = c / 5;
            const int x = (int)(left + (column + 0.5) * square);
            const int y = (int)(top + (row + 0.5) * square);
            cells[c] = ink(p, x, y) > 0.5 ? '#' : '.';
        }
        int digit = 0;
        while (digit < 11 && strcmp(drawn[digit], cells) != 0)
            digit++;
        if (digit == 11)
            break;
        text[length] = glyphs[digit];
    }
    return strtod(text, NULL);
}

static void the_labels_at_both_ends_say_the_pitch_in_digits_large_enough(void **state)
{
    (void)state;
    lf_print print = sound_chart();
    print.lpi = 48.367; /* with the step, every digit */
    print.chart_step = 0.125;
    lf_printed p;
    band bands[32] = {0};
    lf_printed_chart(&print, &p);
    const int n = find_bands(&p, bands, 32);
    for (int i = 0; i < n; i++) {
        const int y0 = (int)(bands[i].from / pixel), y1 = (int)(bands[i].end / pixel);
        lf_assert_close(read_number(&p, 0, bands[i].left - 2, y0, y1), bands[i].labelled, 0.0,
                        1e-9);
        lf_assert_close(read_number(&p, bands[i].right + 2, p.width, y0, y1), bands[i].labelled,
                        0.0, 1e-9);
    }
    lf_printed_finish(&p);
}

/* ----------------------------------------------------------------------------- under a sheet -- */

/* How much brightness varies along a band, seen through the sheet. */
static double unevenness(const lf_printed *p, const band *b, const lf_sheet *sheet)
{
    double *light = malloc((size_t)p->width * sizeof *light);
    double low = 1, high = 0;
    int first, last;
    assert_non_null(light);
    for (int x = 0; x < p->width; x++)
        light[x] = 1.0 - ink(p, x, b->y);
    lf_row_light row = lf_row_light_of(light, p->width, pixel);
    lf_lenses_inside(sheet, &row, &first, &last);
    for (int k = first; k <= last; k++) {
        const double at = lf_focal_point(sheet, k, 0.0, 400.0, true) / pixel + 0.5 * p->width;
        if (at < b->left + 3 || at > b->right - 3)
            continue;
        const double seen =
            lf_seen_through(sheet, &row, k, 0.0, 400.0, 0.25 * sheet->pitch_mm, true);
        low = fmin(low, seen);
        high = fmax(high, seen);
    }
    lf_row_light_finish(&row);
    free(light);
    return high - low;
}

static void the_band_that_looks_even_under_a_sheet_is_labelled_with_its_pitch(void **state)
{
    (void)state;
    const lf_print print = sound_chart();
    static const double sheets[][2] = {
        {59.5, 59.5}, {59.83, 59.8}, {60.0, 60.0}, {60.13, 60.1}, {60.46, 60.5}};
    lf_printed p;
    band bands[32] = {0};
    lf_printed_chart(&print, &p);
    const int n = find_bands(&p, bands, 32);
    for (size_t s = 0; s < sizeof sheets / sizeof *sheets; s++) {
        /* the lens need not lie on a line of the chart */
        const lf_sheet sheet = lf_sheet_for(sheets[s][0], 400.0, 0.6, 1.56, 0.07);
        int best = 0;
        double least = 2.0, next = 2.0;
        for (int i = 0; i < n; i++) {
            const double u = unevenness(&p, &bands[i], &sheet);
            if (u < least)
                next = least, least = u, best = i;
            else if (u < next)
                next = u;
        }
        print_message("sheet of %.2f: band %.1f varies by %.3f, the next best by %.3f\n",
                      sheets[s][0], bands[best].labelled, least, next);
        lf_assert_close(bands[best].labelled, sheets[s][1], 0.0, 1e-9);
        assert_true(next > 1.2 * least);
    }
    lf_printed_finish(&p);
}

/* --------------------------------------------------------------------------------- the sheet -- */

/* Length of the ruler that a row runs through: ticks by their edges, from the ink of the pixels
 * that they cut. */
static double ruler_length(const lf_printed *p, int y)
{
    double at[64] = {0}, left = 0;
    int n = 0;
    for (int x = 1; x < p->width; x++) {
        const double before = ink(p, x - 1, y), here = ink(p, x, y);
        if (before == 0 && here > 0)
            left = x + 1 - here;
        if (before > 0 && here == 0) {
            assert_true(n < 64);
            at[n++] = 0.5 * (left + x - 1 + before);
        }
    }
    assert_int_equal(n, 11); /* a tick every 10 mm */
    for (int i = 1; i < 11; i++)
        lf_assert_close((at[i] - at[i - 1]) * pixel, 10.0, 0.0, 0.001);
    return (at[10] - at[0]) * pixel;
}

static void sizes_on_paper_are_exact(void **state)
{
    (void)state;
    lf_print print = sound_chart();
    lf_printed p;
    print.bits = 16;
    lf_printed_chart(&print, &p);
    assert_int_equal(p.width, lround(120.0 / pixel));
    assert_int_equal(p.height, lround(50.0 / pixel));
    lf_assert_close(ruler_length(&p, (int)((50.0 - 8.0 + 2.0) / pixel)), 100.0, 0.0, 0.001);
    lf_assert_close(
        json_number_value(json_object_get(json_object_get(p.manifest, "chart"), "ruler_mm")), 100.0,
        0.0, 1e-9);
    /* XResolution 600/1 in inches: the tag's eight bytes stand in the file */
    static const unsigned char ratio[8] = {0x58, 0x02, 0, 0, 1, 0, 0, 0};
    int found = 0;
    for (size_t i = 0; i + sizeof ratio <= p.file_size; i++)
        found += memcmp(p.file + i, ratio, sizeof ratio) == 0;
    assert_true(found >= 2);
    lf_printed_finish(&p);
}

static void horizontal_lenses_get_the_chart_turned_and_mirror_turns_it_over(void **state)
{
    (void)state;
    lf_print print = sound_chart();
    lf_printed upright, turned, mirrored;
    print.width_mm = 254.0 / 5; /* whole pixels */
    print.height_mm = 254.0 / 10;
    print.chart_range = 0.1;
    lf_printed_chart(&print, &upright);
    print.mirror = true;
    lf_printed_chart(&print, &mirrored);
    print.mirror = false;
    print.horizontal = true;
    print.width_mm = 254.0 / 10;
    print.height_mm = 254.0 / 5;
    lf_printed_chart(&print, &turned);
    const int w = upright.width, h = upright.height;
    assert_int_equal(turned.width, h);
    assert_int_equal(turned.height, w);
    for (int y = 0; y < h; y++)
        for (int x = 0; x < w; x++) {
            const int v = upright.value[3 * (y * w + x)];
            assert_int_equal(turned.value[3 * (x * h + h - 1 - y)], v);
            assert_int_equal(mirrored.value[3 * (y * w + w - 1 - x)], v);
        }
    lf_printed_finish(&upright);
    lf_printed_finish(&turned);
    lf_printed_finish(&mirrored);
}

static void refuses(lf_print print, const char *word)
{
    lf_error err = {0};
    assert_int_equal(lf_chart_check(&print, &err), LF_E_ARG);
    if (!strstr(err.what, word))
        fail_msg("\"%s\" does not say \"%s\"", err.what, word);
}

static void charts_that_cannot_be_are_refused(void **state)
{
    (void)state;
    const lf_print sound = sound_chart();
    lf_print p;
    lf_error err;
    lf_assert_ok(lf_chart_check(&sound, &err), &err);
    p = sound, p.chart_step = 0.0, refuses(p, "needs range and step");
    p = sound, p.chart_range = 0.0, refuses(p, "needs range and step");
    p = sound, p.chart_step = 0.6, refuses(p, "step");
    p = sound, p.chart_range = (double)NAN, refuses(p, "range");
    p = sound, p.lpi = 5.2, refuses(p, "at least 5 lpi");
    p = sound, p.dpi = 100, refuses(p, "at least 2 per line");
    p = sound, p.bleed_mm = 3.0, refuses(p, "bleed");
    p = sound, p.optics.slant = 12.0, refuses(p, "straight lenses");
    p = sound, p.n_views = 4, refuses(p, "views");
    p = sound, p.height_mm = 20.0, refuses(p, "11 bands");
    p = sound, p.chart_step = 1e-4, refuses(p, "bands");
    p = sound, p.width_mm = 20.0, refuses(p, "along the bands");
    p = sound, p.n_views = 1, p.chart_step = 0.1;
    assert_int_equal(lf_print_check(&p, NULL, &err), LF_E_ARG); /* a picture has no step */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_band_has_the_pitch_that_it_is_said_to_have),
        cmocka_unit_test(the_labels_at_both_ends_say_the_pitch_in_digits_large_enough),
        cmocka_unit_test(the_band_that_looks_even_under_a_sheet_is_labelled_with_its_pitch),
        cmocka_unit_test(sizes_on_paper_are_exact),
        cmocka_unit_test(horizontal_lenses_get_the_chart_turned_and_mirror_turns_it_over),
        cmocka_unit_test(charts_that_cannot_be_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
