/* Several prints on a sheet: each copy is cut out and looked at from its own middle through its
 * part of the one lens sheet. The arithmetic of the places is the test's own. */
#include "tests/testing.h"

#include <complex.h>

#include "base/alloc.h"
#include "tests/quilt/optical_oracle.h"
#include "tests/quilt/printed.h"

#define LPI 60.13
#define DPI 600
#define DISTANCE 400.0
#define THICKNESS 0.6
#define INDEX 1.56
#define SIZE 24.0
#define GUTTER 2.0
#define COPIES 4
#define VIEWS 6

static const double pi = 3.14159265358979323846, pixel = 25.4 / DPI, visual = 25.4 / LPI;

static double mechanical(void)
{
    return visual / (1.0 + THICKNESS / (INDEX * DISTANCE));
}

/* Four copies across the lenses and two along them. */
static lf_print sheet_print(bool horizontal)
{
    return (lf_print){.lpi = LPI,
                      .dpi = DPI,
                      .width_mm = horizontal ? 3.0 : SIZE,
                      .height_mm = horizontal ? SIZE : 3.0,
                      .n_views = VIEWS,
                      .bits = 16,
                      .horizontal = horizontal,
                      .optics = {.thickness_mm = THICKNESS,
                                 .index = INDEX,
                                 .distance_mm = DISTANCE,
                                 .map = LF_MAP_UNIFORM},
                      .sheet = {.columns = horizontal ? 2 : COPIES,
                                .rows = horizontal ? COPIES : 2,
                                .gutter_mm = GUTTER}};
}

/* Where copy i across must have its middle: on a lens. */
static double middle_of(int i)
{
    const int step = (int)ceil((SIZE + GUTTER) / mechanical());
    return (i * step - (COPIES - 1) * step / 2) * mechanical();
}

/* A print of views that are each of one colour, grey[view][channel]. */
static lf_printed printed_of(const lf_print *print, double grey[VIEWS][3])
{
    float *data = lf_calloc(VIEWS, 3 * sizeof *data);
    lf_printed out;
    assert_non_null(data);
    for (int i = 0; i < 3 * VIEWS; i++)
        data[i] = (float)grey[i / 3][i % 3];
    const lf_views32 views = {VIEWS, 1, 1, 3, 3, data, NULL, NULL, NULL};
    lf_printed_make(print, &views, 0, &out);
    lf_free(data);
    return out;
}

/* -------------------------------------------------------------------------- a line of pixels -- */

/* Light across the lenses, one channel. */
typedef struct line {
    int n;
    double *light;
} line;

static line line_of(const lf_printed *p, bool horizontal, int along, int c)
{
    line out = {horizontal ? p->height : p->width, NULL};
    out.light = lf_calloc((size_t)out.n, sizeof *out.light);
    assert_non_null(out.light);
    for (int i = 0; i < out.n; i++)
        out.light[i] = lf_printed_linear(p, horizontal ? along : i, horizontal ? i : along, c);
    return out;
}

/* A page on which someone pasted the line of one print with its middle at each of these places, as
 * nearly as whole pixels can be. */
static line pasted(const line *one, int n_page, const double *middles)
{
    line out = {n_page, lf_calloc((size_t)n_page, sizeof *out.light)};
    assert_non_null(out.light);
    for (int i = 0; i < COPIES; i++) {
        const int first = (int)lround(middles[i] / pixel + 0.5 * n_page - 0.5 * one->n);
        memcpy(out.light + first, one->light, (size_t)one->n * sizeof *out.light);
    }
    return out;
}

/* ---------------------------------------------------------------------------- how it is seen -- */

/* How far the stripes of the copy around `middle` are from where the eye in front of it looks, in
 * mm, by a lock-in at the visual pitch. re and im: views coded by a turning phase. */
static double phase_error(const line *re, const line *im, double middle)
{
    double complex sum = 0.0;
    const double lens = mechanical() * round(middle / mechanical());
    const double seen = lens + (lens - middle) * THICKNESS / (INDEX * DISTANCE);
    for (int j = 0; j < re->n; j++) {
        const double x = (j + 0.5 - 0.5 * re->n) * pixel - middle;
        if (fabs(x) >= 0.5 * SIZE - 1.0)
            continue;
        const double window = 1.0 + cos(pi * x / (0.5 * SIZE - 1.0));
        const double complex signal = CMPLX(re->light[j] - 0.5, im->light[j] - 0.5);
        sum += window * signal * cexp(CMPLX(0.0, 2.0 * pi * (x + middle - seen) / visual));
    }
    return carg(-sum) * visual / (2.0 * pi);
}

static void code_views(double grey[VIEWS][3])
{
    for (int i = 0; i < VIEWS; i++) {
        grey[i][0] = 0.5 + 0.5 * cos(2.0 * pi * (i + 0.5) / VIEWS);
        grey[i][1] = 0.5 + 0.5 * sin(2.0 * pi * (i + 0.5) / VIEWS);
        grey[i][2] = 0.0;
    }
}

/* Mean light that eye i in front of the middle of a copy sees, in its part of the line alone. */
static double card_light(const line *page, double middle, int i)
{
    const int first = (int)lround((middle - 0.5 * SIZE) / pixel + 0.5 * page->n),
              n = (int)floor(SIZE / pixel);
    const double card_middle = (first + 0.5 * n - 0.5 * page->n) * pixel;
    lf_row_light row = lf_row_light_of(page->light + first, n, pixel);
    /* the lenses of the whole sheet, from the card's middle */
    const int own = (int)round(middle / mechanical());
    const lf_sheet sheet = {mechanical(), THICKNESS, INDEX, own * mechanical() - card_middle};
    const double eye = middle - card_middle +
                       (i - 0.5 * (VIEWS - 1)) * (visual / VIEWS) * INDEX * DISTANCE / THICKNESS;
    int begin, end;
    double sum = 0.0;
    lf_lenses_inside(&sheet, &row, &begin, &end);
    assert_true(end - begin > 40);
    for (int k = begin; k <= end; k++)
        sum += lf_seen_through(&sheet, &row, k, eye, DISTANCE, 0.5 * visual / VIEWS, false);
    lf_row_light_finish(&row);
    return sum / (end - begin + 1);
}

/* The least share of its own view that an eye sees at the copies. */
static double least_own(line white[VIEWS], const double *middles)
{
    double least = 1.0;
    for (int c = 0; c < COPIES; c++)
        for (int i = 0; i < VIEWS; i++)
            least = fmin(least, card_light(&white[i], middles[c], i));
    return least;
}

/* Lines in which one view is white. */
static void white_lines(const lf_print *print, int along, line out[VIEWS])
{
    for (int third = 0; third < VIEWS / 3; third++) {
        double grey[VIEWS][3] = {{0}};
        for (int c = 0; c < 3; c++)
            grey[3 * third + c][c] = 1.0;
        lf_printed printed = printed_of(print, grey);
        for (int c = 0; c < 3; c++)
            out[3 * third + c] = line_of(&printed, print->horizontal, along, c);
        lf_printed_finish(&printed);
    }
}

static void free_lines(line *lines, int n)
{
    for (int i = 0; i < n; i++)
        lf_free(lines[i].light);
}

/* ------------------------------------------------------------------------------------- tests -- */

static void each_copy_is_in_phase_with_the_lens_at_its_middle(void **state)
{
    (void)state;
    double grey[VIEWS][3];
    code_views(grey);
    for (int i = 0; i < 4; i++) {
        const bool horizontal = i % 2;
        lf_print print = sheet_print(horizontal);
        print.optics.map = i < 2 ? LF_MAP_UNIFORM : LF_MAP_EXACT;
        lf_printed printed = printed_of(&print, grey);
        for (int row = 0; row < 2; row++) {
            const int n_along = horizontal ? printed.width : printed.height;
            const int along = row == 0 ? 30 : n_along - 30;
            line lines[2] = {line_of(&printed, horizontal, along, 0),
                             line_of(&printed, horizontal, along, 1)};
            for (int c = 0; c < COPIES; c++)
                lf_assert_close(phase_error(&lines[0], &lines[1], middle_of(c)), 0.0, 0.0, 5e-4);
            free_lines(lines, 2);
        }
        lf_printed_finish(&printed);
    }
}

/* Lenses that lean by so much, clockwise: the eye in front of a copy's middle sees phase 0 there.
 */
static double slanted_error(const lf_printed *p, bool horizontal, double slant, double right,
                            double down)
{
    double complex sum = 0.0;
    const double u_right = horizontal ? -sin(slant) : cos(slant),
                 u_down = horizontal ? cos(slant) : sin(slant);
    for (int y = 0; y < p->height; y++)
        for (int x = 0; x < p->width; x++) {
            const double a = (x + 0.5 - 0.5 * p->width) * pixel - right,
                         b = (y + 0.5 - 0.5 * p->height) * pixel - down;
            if (hypot(a, b) >= 4.5)
                continue;
            const double window = 1.0 + cos(pi * hypot(a, b) / 4.5);
            const double complex signal =
                CMPLX(lf_printed_linear(p, x, y, 0) - 0.5, lf_printed_linear(p, x, y, 1) - 0.5);
            sum +=
                window * signal * cexp(CMPLX(0.0, 2.0 * pi * (a * u_right + b * u_down) / visual));
        }
    return carg(-sum) * visual / (2.0 * pi);
}

static void copies_of_slanted_lenses_are_on_lenses_of_the_sheet(void **state)
{
    (void)state;
    double grey[VIEWS][3];
    code_views(grey);
    for (int i = 0; i < 4; i++) {
        const bool horizontal = i / 2;
        const double degrees = i % 2 ? 12.5 : -7.0, slant = degrees * pi / 180.0;
        lf_print print = sheet_print(horizontal);
        print.width_mm = print.height_mm = 10.0;
        print.sheet.columns = 3;
        print.sheet.rows = 2;
        print.optics.slant = degrees;
        print.optics.map = i < 2 ? LF_MAP_AUTO : LF_MAP_UNIFORM;
        lf_printed printed = printed_of(&print, grey);
        const json_t *copies =
            json_object_get(json_object_get(printed.manifest, "sheet"), "copies");
        assert_int_equal(json_array_size(copies), 6);
        for (size_t c = 0; c < 6; c++) {
            const json_t *middle = json_object_get(json_array_get(copies, c), "middle_mm");
            const double right = json_number_value(json_array_get(middle, 0)),
                         down = json_number_value(json_array_get(middle, 1));
            const double u = horizontal ? down * cos(slant) - right * sin(slant)
                                        : right * cos(slant) + down * sin(slant);
            lf_assert_close(u / mechanical() - round(u / mechanical()), 0.0, 0.0, 1e-9);
            lf_assert_close(slanted_error(&printed, horizontal, slant, right, down), 0.0, 0.0,
                            1e-3);
            /* negative control: the lenses lean the other way */
            assert_true(fabs(slanted_error(&printed, horizontal, -slant, right + 2.0, down + 2.0)) >
                        0.01);
        }
        lf_printed_finish(&printed);
    }
}

/* A copy has the pixels of a print whose phase is where the copy's middle is on its pixels. */
static void copies_of_micro_sheets_are_on_lenses_both_ways(void **state)
{
    (void)state;
    for (int hexagonal = 0; hexagonal < 2; hexagonal++) {
        lf_print print = sheet_print(false);
        float data[9][3];
        for (int i = 0; i < 27; i++)
            data[i / 3][i % 3] = (float)((i * 7) % 27) / 26.0F;
        const lf_views32 views = {9, 1, 1, 3, 3, data[0], NULL, NULL, NULL};
        print.width_mm = print.height_mm = 8.0;
        print.n_views = 9;
        print.optics.grid = hexagonal ? LF_LENS_HEXAGONAL : LF_LENS_SQUARE;
        print.sheet.columns = 2;
        lf_printed page, one;
        lf_printed_make(&print, &views, 0, &page);
        const json_t *copies = json_object_get(json_object_get(page.manifest, "sheet"), "copies");
        print.sheet = (lf_print_sheet){0};
        for (size_t c = 0; c < 4; c++) {
            const json_t *middle = json_object_get(json_array_get(copies, c), "middle_mm");
            const double right = json_number_value(json_array_get(middle, 0)),
                         down = json_number_value(json_array_get(middle, 1)),
                         row = mechanical() * (hexagonal ? sqrt(0.75) : 1.0);
            lf_assert_close(remainder(right, mechanical()), 0.0, 0.0, 1e-9);
            lf_assert_close(remainder(down, hexagonal ? 2.0 * row : row), 0.0, 0.0, 1e-9);
            const int n = (int)lround(8.0 / pixel),
                      left = (int)lround(right / pixel + 0.5 * page.width - 0.5 * n),
                      top = (int)lround(down / pixel + 0.5 * page.height - 0.5 * n);
            print.phase_mm = right - (left + 0.5 * n - 0.5 * page.width) * pixel;
            print.optics.phase_down_mm = down - (top + 0.5 * n - 0.5 * page.height) * pixel;
            lf_printed_make(&print, &views, 0, &one);
            for (int y = 0; y < n; y++)
                for (int x = 0; x < 3 * n; x++)
                    assert_in_range(one.value[3 * n * y + x] + 2 -
                                        page.value[3 * (page.width * (top + y) + left) + x],
                                    0, 4);
            lf_printed_finish(&one);
        }
        lf_printed_finish(&page);
    }
}

static void each_copy_alone_shows_every_view_from_its_own_middle(void **state)
{
    (void)state;
    double middles[COPIES];
    for (int i = 0; i < COPIES; i++)
        middles[i] = middle_of(i);
    for (int horizontal = 0; horizontal < 2; horizontal++) {
        const lf_print print = sheet_print(horizontal);
        line white[VIEWS];
        white_lines(&print, 30, white);
        for (int c = 0; c < COPIES; c++)
            for (int i = 0; i < VIEWS; i++)
                for (int j = 0; j < VIEWS; j++)
                    assert_true(j == i || card_light(&white[i], middles[c], i) >
                                              2.0 * card_light(&white[j], middles[c], i));
        /* lenticular.md 1.4: 0.92 in the mean for 6 views on A4 */
        assert_true(least_own(white, middles) > 0.9);
        free_lines(white, VIEWS);
    }
}

/* Negative controls: copies on whole pixels, on lenses of the visual pitch, and on no lens. */
static void copies_that_are_placed_otherwise_are_found(void **state)
{
    (void)state;
    double grey[VIEWS][3], on_lens[COPIES], of_visual[COPIES], on_none[COPIES];
    double worst_pixel = 0.0, worst_visual = 0.0, worst_none = 0.0;
    lf_print print = sheet_print(false);
    code_views(grey);
    print.sheet = (lf_print_sheet){0};
    lf_printed printed = printed_of(&print, grey);
    line one[2] = {line_of(&printed, false, 30, 0), line_of(&printed, false, 30, 1)};
    lf_printed_finish(&printed);
    for (int i = 0; i < COPIES; i++) {
        on_lens[i] = middle_of(i);
        of_visual[i] = middle_of(i) / mechanical() * visual;
        on_none[i] = (i - 0.5 * (COPIES - 1)) * (SIZE + GUTTER);
    }
    const int n_page = 4 * one[0].n + 400;
    line pixels[2] = {pasted(&one[0], n_page, on_lens), pasted(&one[1], n_page, on_lens)};
    line none[2] = {pasted(&one[0], n_page, on_none), pasted(&one[1], n_page, on_none)};
    line views[2] = {pasted(&one[0], n_page, of_visual), pasted(&one[1], n_page, of_visual)};
    for (int i = 0; i < COPIES; i++) {
        worst_pixel = fmax(worst_pixel, fabs(phase_error(&pixels[0], &pixels[1], on_lens[i])));
        worst_visual = fmax(worst_visual, fabs(phase_error(&views[0], &views[1], of_visual[i])));
        worst_none = fmax(worst_none, fabs(phase_error(&none[0], &none[1], on_none[i])));
    }
    assert_true(worst_pixel > 0.01 && worst_pixel < 0.5 * pixel + 1e-3);
    assert_true(worst_visual > 0.01);
    assert_true(worst_none > 0.05);
    free_lines(one, 2);
    free_lines(pixels, 2);
    free_lines(none, 2);
    free_lines(views, 2);
}

static void copies_on_no_lens_show_other_views(void **state)
{
    (void)state;
    double on_none[COPIES];
    lf_print print = sheet_print(false);
    line one[VIEWS], page[VIEWS];
    print.sheet = (lf_print_sheet){0};
    white_lines(&print, 30, one);
    for (int i = 0; i < COPIES; i++)
        on_none[i] = (i - 0.5 * (COPIES - 1)) * (SIZE + GUTTER);
    for (int i = 0; i < VIEWS; i++)
        page[i] = pasted(&one[i], 4 * one[0].n + 400, on_none);
    assert_true(least_own(page, on_none) < 0.5);
    free_lines(one, VIEWS);
    free_lines(page, VIEWS);
}

/* ---------------------------------------------------------------------------------- the page -- */

static double number_at(const json_t *array, size_t i)
{
    return json_number_value(json_array_get(array, i));
}

static void the_manifest_has_the_box_and_the_lens_of_each_copy(void **state)
{
    (void)state;
    double grey[VIEWS][3] = {{0}};
    lf_print print = sheet_print(false);
    print.mirror = true;
    lf_printed printed = printed_of(&print, grey);
    const json_t *sheet = json_object_get(printed.manifest, "sheet"),
                 *copies = json_object_get(sheet, "copies");
    assert_int_equal(json_array_size(copies), 8);
    lf_assert_close(json_number_value(json_object_get(sheet, "mechanical_pitch_mm")), mechanical(),
                    0.0, 1e-12);
    for (size_t i = 0; i < 8; i++) {
        const json_t *copy = json_array_get(copies, i), *box = json_object_get(copy, "trim_box_mm");
        const double middle = middle_of((int)i % COPIES);
        assert_int_equal(json_integer_value(json_object_get(copy, "lens")),
                         lround(middle / mechanical()));
        /* the file is mirrored */
        lf_assert_close(number_at(box, 0), 0.5 * printed.width * pixel - middle - 0.5 * SIZE, 0.0,
                        1e-9);
        lf_assert_close(number_at(box, 2) - number_at(box, 0), SIZE, 0.0, 1e-9);
        lf_assert_close(number_at(box, 3) - number_at(box, 1), 3.0, 0.0, 1e-9);
    }
    const json_t *first = json_object_get(json_array_get(copies, 0), "trim_box_mm"),
                 *below = json_object_get(json_array_get(copies, COPIES), "trim_box_mm");
    assert_true(number_at(below, 1) - number_at(first, 3) >= GUTTER - 1e-9);
    assert_true(number_at(below, 1) - number_at(first, 3) < GUTTER + 2.0 * pixel);
    const json_t *whole = json_object_get(json_object_get(printed.manifest, "size"), "trim_box_mm");
    lf_assert_close(number_at(whole, 2) - number_at(whole, 0),
                    middle_of(COPIES - 1) - middle_of(0) + SIZE, 0.0, 1e-9);
    lf_printed_finish(&printed);
}

static void a_page_is_white_between_copies_and_the_same_in_strips_of_any_height(void **state)
{
    (void)state;
    double grey[VIEWS][3] = {{0}};
    lf_print print = sheet_print(true);
    print.sheet.paper_width_mm = 26.0;
    print.sheet.paper_height_mm = 130.0;
    print.sheet.label = "A";
    print.sheet.label_mm = 0.8;
    print.marks = true;
    print.sheet.rows = 3;
    float black[3] = {0};
    const lf_views32 views = {1, 1, 1, 3, 3, black, NULL, NULL, NULL};
    lf_printed whole = printed_of(&print, grey);
    lf_assert_close(whole.width * pixel, 26.0, 0.0, 0.5 * pixel);
    lf_assert_close(whole.height * pixel, 130.0, 0.0, 0.5 * pixel);
    for (int rows = 1; rows < 100; rows = 7 * rows) {
        lf_printed strips;
        lf_printed_make(&print, &views, rows, &strips);
        lf_printed_assert_same(&whole, &strips);
        lf_printed_finish(&strips);
    }
    /* the gutter between the two columns, beside the pictures */
    assert_int_equal(lf_printed_at(&whole, whole.width / 2, whole.height / 2, 0), 65535);
    assert_int_equal(lf_printed_at(&whole, whole.width / 2 + 60, whole.height / 2, 0), 0);
    assert_int_equal(lf_printed_at(&whole, whole.width / 2 - 60, whole.height / 2, 0), 0);
    lf_printed_finish(&whole);
}

/* Ink of a white page at a place from its middle, in mm. */
static double ink(const lf_printed *p, double right, double down)
{
    return 1.0 - lf_printed_linear(p, (int)floor(right / pixel + 0.5 * p->width),
                                   (int)floor(down / pixel + 0.5 * p->height), 1);
}

static void labels_are_below_the_bleed_and_crop_marks_at_every_copy(void **state)
{
    (void)state;
    double grey[VIEWS][3];
    lf_print print = sheet_print(false);
    for (int i = 0; i < VIEWS; i++)
        grey[i][0] = grey[i][1] = grey[i][2] = 1.0;
    print.bleed_mm = 1.5;
    print.sheet.gutter_mm = 16.0;
    print.sheet.columns = 2;
    print.sheet.label = "H";
    print.sheet.label_mm = 3.5; /* squares of 0.5 mm */
    print.marks = true;
    lf_printed p = printed_of(&print, grey);
    const json_t *copies = json_object_get(json_object_get(p.manifest, "sheet"), "copies");
    for (size_t i = 0; i < 4; i++) {
        const json_t *box = json_object_get(json_array_get(copies, i), "trim_box_mm");
        const double left = number_at(box, 0) - 0.5 * p.width * pixel,
                     right = number_at(box, 2) - 0.5 * p.width * pixel,
                     top = number_at(box, 1) - 0.5 * p.height * pixel,
                     bottom = number_at(box, 3) - 0.5 * p.height * pixel;
        /* an H whose left top corner is 1 mm to the right and 1 mm below the bleed */
        const double x = left + 1.0, y = bottom + 1.5 + 1.0;
        assert_true(ink(&p, x + 0.25, y + 0.25) == 1.0 && ink(&p, x + 2.25, y + 0.25) == 1.0);
        assert_true(ink(&p, x + 1.25, y + 1.75) == 1.0 && ink(&p, x + 1.25, y + 0.25) == 0.0);
        assert_true(ink(&p, x + 1.25, y + 3.75) == 0.0 && ink(&p, x + 0.25, y - 0.25) == 0.0);
        for (double out = 1.2; out < 6.0; out += 0.6) {
            assert_true(ink(&p, left, bottom + 1.5 + out) > 0.5);
            assert_true(ink(&p, right, top - 1.5 - out) > 0.5);
            assert_true(ink(&p, left - 1.5 - out, top) > 0.5);
            assert_true(ink(&p, right + 1.5 + out, bottom) > 0.5);
        }
        /* nothing in the picture and its bleed */
        for (double down = top - 1.4; down < bottom + 1.4; down += 0.1)
            for (double across = left - 1.4; across < right + 1.4; across += 0.1)
                assert_true(ink(&p, across, down) == 0.0);
    }
    lf_printed_finish(&p);
}

static void crop_marks_end_before_the_next_copy(void **state)
{
    (void)state;
    double grey[VIEWS][3];
    lf_print print = sheet_print(false);
    for (int i = 0; i < VIEWS; i++)
        grey[i][0] = grey[i][1] = grey[i][2] = 1.0;
    print.sheet.gutter_mm = 4.0;
    print.sheet.columns = 2;
    print.sheet.rows = 1;
    print.marks = true;
    lf_printed p = printed_of(&print, grey);
    const json_t *copies = json_object_get(json_object_get(p.manifest, "sheet"), "copies");
    const json_t *box = json_object_get(json_array_get(copies, 0), "trim_box_mm"),
                 *next = json_object_get(json_array_get(copies, 1), "trim_box_mm");
    const double right = number_at(box, 2) - 0.5 * p.width * pixel,
                 top = number_at(box, 1) - 0.5 * p.height * pixel,
                 left = number_at(next, 0) - 0.5 * p.width * pixel;
    assert_true(ink(&p, right + 1.5, top) > 0.5);
    for (double x = left - 0.9; x < left + 3.0; x += 0.05) /* the outer half of the line */
        assert_true(ink(&p, x, top - 0.06) == 0.0);
    lf_printed_finish(&p);
}

/* ---------------------------------------------------------------------------------- mistakes -- */

static void expect_refusal(const lf_print *print, const char *words)
{
    lf_error err;
    assert_int_equal(lf_print_check(print, NULL, &err), LF_E_ARG);
    if (!strstr(err.what, words))
        fail_msg("\"%s\" is not in \"%s\"", words, err.what);
}

static void what_does_not_fit_is_refused_in_words(void **state)
{
    (void)state;
    lf_print print = sheet_print(false);
    assert_int_equal(lf_print_check(&print, NULL, NULL), LF_OK);
    print.sheet.paper_width_mm = 100.0;
    print.sheet.paper_height_mm = 100.0;
    expect_refusal(&print, "use larger paper or fewer copies");
    print.sheet.paper_width_mm = 110.0;
    assert_int_equal(lf_print_check(&print, NULL, NULL), LF_OK);
    print.sheet.paper_height_mm = 7.9; /* 3 + 2 + 3 */
    expect_refusal(&print, "8.1 mm, but the paper 110x7.9 has 7.9 mm");
    print.sheet.paper_width_mm = print.sheet.paper_height_mm = 0.0;
    print.sheet.label = "a text of which no one could read a word below so small a print";
    expect_refusal(&print, "not readable");
    print.sheet.label = NULL;
    print.width_mm = 3000.0;
    expect_refusal(&print, "use fewer copies");
}

static void notes_tell_of_what_is_unknown_or_changed(void **state)
{
    (void)state;
    lf_image_notes notes = {0};
    char note[512], text[128];
    size_t at = 0;
    lf_print print = sheet_print(false);
    lf_print_note_sheet(&print, VIEWS, &notes);
    assert_false(lf_image_notes_next(&notes, &at, note, sizeof note));
    assert_string_equal(lf_print_layout_text(&print, VIEWS, text, sizeof text),
                        "4x2 copies, 26.16 mm apart across and 5.04 mm down");
    print.optics = (lf_optics){0};
    print.sheet.label = "Köln, im Frühling: zwölf Karten";
    lf_print_note_sheet(&print, VIEWS, &notes);
    assert_true(lf_image_notes_next(&notes, &at, note, sizeof note));
    assert_non_null(strstr(note, "the outermost may be 0.04 mm off"));
    assert_true(lf_image_notes_next(&notes, &at, note, sizeof note));
    assert_non_null(strstr(note, "\"Koln, im Fruhling: zwolf Karten\""));
    assert_true(lf_image_notes_next(&notes, &at, note, sizeof note));
    assert_non_null(strstr(note, "instead of 2.5 mm"));
    print.sheet = (lf_print_sheet){0};
    assert_string_equal(lf_print_layout_text(&print, VIEWS, text, sizeof text), "");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_copy_is_in_phase_with_the_lens_at_its_middle),
        cmocka_unit_test(copies_of_slanted_lenses_are_on_lenses_of_the_sheet),
        cmocka_unit_test(copies_of_micro_sheets_are_on_lenses_both_ways),
        cmocka_unit_test(each_copy_alone_shows_every_view_from_its_own_middle),
        cmocka_unit_test(copies_that_are_placed_otherwise_are_found),
        cmocka_unit_test(copies_on_no_lens_show_other_views),
        cmocka_unit_test(the_manifest_has_the_box_and_the_lens_of_each_copy),
        cmocka_unit_test(a_page_is_white_between_copies_and_the_same_in_strips_of_any_height),
        cmocka_unit_test(labels_are_below_the_bleed_and_crop_marks_at_every_copy),
        cmocka_unit_test(crop_marks_end_before_the_next_copy),
        cmocka_unit_test(what_does_not_fit_is_refused_in_words),
        cmocka_unit_test(notes_tell_of_what_is_unknown_or_changed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
