/* Own view, drift and parallax of prints, against tables and against prints of known shifts. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "quilt/proof/study.h"
#include "tests/quilt/printed.h"

static const char *folder;

static int make_folder(void **state)
{
    (void)state;
    folder = lf_test_folder();
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    lf_test_folder_remove((char *)(uintptr_t)folder);
    return 0;
}

/* A table made by another program: lenticular sheets of 60.13 lpi, spots of half a stripe. */
static void own_views_are_those_of_the_table(void **state)
{
    (void)state;
    static const struct {
        int views;
        double dpi;
        lf_stripes stripes;
        double mean, worst;
    } rows[] = {
        {10, 600, LF_STRIPES_FRACTIONAL, 0.722, 0.499}, {10, 600, LF_STRIPES_NEAREST, 0.870, 0.000},
        {8, 600, LF_STRIPES_FRACTIONAL, 0.826, 0.624},  {8, 600, LF_STRIPES_NEAREST, 0.943, 0.698},
        {6, 600, LF_STRIPES_FRACTIONAL, 0.920, 0.832},  {6, 600, LF_STRIPES_NEAREST, 0.991, 0.899},
        {10, 1200, LF_STRIPES_FRACTIONAL, 0.958, 0.937}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        lf_print print = lf_print_sound();
        lf_proof_sheet sheet;
        print.lpi = 60.13;
        print.dpi = rows[i].dpi;
        print.n_views = rows[i].views;
        print.stripes = rows[i].stripes;
        lf_proof_sheet_of(&print, &sheet, NULL);
        const lf_own_view own = lf_proof_own_view(&print, &sheet);
        lf_assert_close(own.mean, rows[i].mean, 0, 0.008);
        lf_assert_close(own.worst, rows[i].worst, 0, 0.012);
        assert_true(own.mean + own.beside > 0.99 && own.mean + own.beside < 1.001);
    }
}

static void a_wrong_pitch_drifts(void **state)
{
    (void)state;
    lf_print print = lf_print_sound(), wrong;
    lf_proof_sheet sheet;
    print.lpi = 60.13;
    print.width_mm = 210;
    print.optics.distance_mm = 300;
    lf_proof_sheet_of(&print, &sheet, NULL);
    lf_assert_close(lf_proof_drift(&print, &sheet, 300), 0, 0, 1e-9);
    wrong = print;
    wrong.lpi = 60.0;
    lf_assert_close(lf_proof_drift(&wrong, &sheet, 300), 0.13 * 210 / 25.4, 1e-6, 0);
    assert_true(lf_proof_drift(&print, &sheet, 600) > 0.1);
}

static void what_is_not_known_is_assumed_in_words(void **state)
{
    (void)state;
    lf_print print = lf_print_sound();
    lf_proof_sheet sheet;
    lf_image_notes notes = {0};
    lf_proof_sheet_of(&print, &sheet, &notes);
    assert_non_null(strstr(notes.text, "thickness is not known"));
    assert_non_null(strstr(notes.text, "distance is not known"));
    /* the sheet still has the pitch that was measured */
    lf_assert_close(sheet.pitch_mm * (1 + sheet.thickness_mm / (sheet.index * 400)), 25.4 / 60,
                    1e-12, 0);
    print.optics.thickness_mm = 0.6;
    print.optics.distance_mm = 500;
    notes = (lf_image_notes){0};
    lf_proof_sheet_of(&print, &sheet, &notes);
    assert_int_equal(notes.length, 0);
    /* a sheet of points has its views in rows */
    lf_print points = print;
    points.n_views = 15;
    points.optics.grid = LF_LENS_SQUARE;
    points.optics.view_rows = 3;
    lf_proof_sheet of_points;
    lf_proof_sheet_of(&points, &of_points, NULL);
    assert_int_equal(of_points.n_views, 5);
    lf_assert_close(of_points.spot_mm, 25.4 / 60 / 10, 1e-9, 0);
}

/* The largest share of its cell that the middle lens shows an eye, by following the ray back: found
 * by moving the eye, not by the formula. */
static double seen_by(double x_mm, double distance_mm, double thickness_mm, double index)
{
    const double inside = asin(sin(atan2(x_mm, distance_mm)) / index);
    return thickness_mm * tan(inside);
}

static void ranges_of_views_are_those_of_rays(void **state)
{
    (void)state;
    lf_print print = lf_print_sound();
    print.optics.thickness_mm = 0.548;
    print.optics.index = 1.552;
    print.optics.distance_mm = 400;
    for (int i = 0; i < 3; i++) {
        const double distance = (const double[]){400, 250, 1000}[i];
        lf_proof_sheet sheet;
        lf_proof_sheet_of(&print, &sheet, NULL);
        double jump = 0, view = 0;
        while (seen_by(jump, distance, 0.548, 1.552) < 0.5 * 25.4 / 60)
            jump += 0.01;
        while (seen_by(view, distance, 0.548, 1.552) < 0.5 * 25.4 / 60 / sheet.n_views)
            view += 0.01;
        lf_assert_close(lf_proof_view_range(&sheet, distance), 2 * jump, 0, 0.05);
        lf_assert_close(lf_proof_view_step(&sheet, distance), 2 * view, 0, 0.05);
        if (i == 0)
            lf_assert_close(jump, 268, 0, 2); /* 240 without Snell's law */
        lf_assert_close(lf_proof_eye_at(&sheet, distance, -0.5), -jump, 0, 0.05);
    }
    /* a thick sheet of coarse lenses: light that cannot leave it */
    print.lpi = 10;
    lf_proof_sheet sheet;
    lf_proof_sheet_of(&print, &sheet, NULL);
    assert_true(lf_proof_view_range(&sheet, 400) < 2 * 400 * 6);
}

/* ---------------------------------------------------------------------------------- parallax -- */

typedef struct scene {
    double shift; /* of all points, lenses from view to view */
    bool flips, horizontal;
    int flat; /* from this lens on, a soft sky; 0: nowhere */
} scene;

static double wave(double x, double y)
{
    return 0.5 + 0.2 * sin(0.9 * x + 1.3 * sin(0.02 * y)) + 0.14 * sin(0.37 * x + 2.0) +
           0.12 * sin(1.9 * x + 0.015 * y);
}

static float draw(const void *context, int view, int row, int column, int c)
{
    const scene *s = context;
    const int lens = s->horizontal ? row : column, along = s->horizontal ? column : row;
    (void)c;
    if (s->flips) { /* noise that no shift brings together */
        const double noise = 43758.5453 * sin(12.9898 * lens + 78.233 * (along / 20) + 37.7 * view);
        return (float)(noise - floor(noise));
    }
    if (s->flat > 0 && lens >= s->flat)
        return 0.4F + 0.0005F * (float)along;
    return (float)wave(lens - s->shift * view, along);
}

static void depth_of(const scene *s, lf_print *print, lf_proof_depth *out, lf_print_file **file)
{
    lf_views32 views;
    lf_printed printed;
    lf_proof_sheet sheet;
    lf_error err;
    *print = lf_print_sound();
    print->width_mm = print->height_mm = 41;
    print->n_views = 6;
    print->horizontal = s->horizontal;
    lf_card_make(print, draw, s, &views);
    lf_printed_make(print, &views, 0, &printed);
    const char *path = lf_test_path(folder, "print.tif");
    FILE *stream = fopen(path, "wb");
    assert_int_equal(fwrite(printed.file, 1, printed.file_size, stream), printed.file_size);
    fclose(stream);
    lf_card_finish(&views);
    lf_printed_finish(&printed);
    lf_assert_ok(lf_print_file_open(path, NULL, file, &err), &err);
    lf_proof_sheet_of(print, &sheet, NULL);
    lf_assert_ok(lf_proof_depth_of(*file, &sheet, 400, NULL, out, &err), &err);
}

static void shifts_of_prints_are_measured(void **state)
{
    (void)state;
    static const scene scenes[] = {{0.6, false, false, 0},
                                   {-0.5, false, false, 0},
                                   {2.0, false, false, 0},
                                   {-3.0, false, false, 0},
                                   {1.5, false, true, 0}};
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        const double shift = scenes[i].shift;
        lf_print print;
        lf_print_file *file;
        lf_proof_depth depth;
        depth_of(&scenes[i], &print, &depth, &file);
        double sum = 0;
        int n = 0;
        for (int k = 0; k < depth.columns * depth.rows; k++)
            if (!isnan(depth.shift[k])) {
                sum += (double)depth.shift[k];
                n++;
            }
        print_message("shift %g: mean %.2f of %d blocks, most %.2f\n", shift, sum / n, n,
                      depth.most);
        assert_true(n >= depth.columns * depth.rows / 2);
        lf_assert_close(sum / n, shift, 0.1, 0.2);
        assert_true(depth.measured > LF_PROOF_FLIP);
        assert_true(fabs(shift) > 1 ? depth.over > 0.7 : depth.over < 0.1);
        /* in front of the print: left and right, or top and bottom, cut it */
        assert_int_equal(depth.cut[0] && depth.cut[1], shift < 0 && !print.horizontal);
        assert_false(depth.cut[2] || depth.cut[3]);
        lf_proof_depth_finish(&depth);
        lf_print_file_close(file);
    }
}

/* A sky beside a thing that moves: the thing is marked, also in blocks that hold both. */
static void what_does_not_move_is_not_marked(void **state)
{
    (void)state;
    for (int horizontal = 0; horizontal < 2; horizontal++) {
        lf_print print;
        lf_print_file *file;
        lf_proof_depth depth;
        /* 97 lenses across; the border lies in the fourth of six blocks */
        depth_of(&(scene){-3, false, horizontal, 58}, &print, &depth, &file);
        const int n = LF_PROOF_BLOCK / LF_PROOF_CELL, n_columns = depth.columns * n;
        int marked[2] = {0}, all[2] = {0};
        for (int y = 0; y < depth.rows * n; y++)
            for (int x = 0; x < n_columns; x++) {
                const int lens = (horizontal ? y : x) * LF_PROOF_CELL;
                const bool sky = lens >= 60;
                if (lens < 52 || sky) {
                    marked[sky] += depth.doubled[y * n_columns + x];
                    all[sky]++;
                }
            }
        print_message("marked: %d of %d, sky %d of %d\n", marked[0], all[0], marked[1], all[1]);
        assert_true(marked[0] > all[0] / 2);
        assert_int_equal(marked[1], 0);
        lf_proof_depth_finish(&depth);
        lf_print_file_close(file);
    }
}

static void a_flip_has_no_parallax(void **state)
{
    (void)state;
    for (int horizontal = 0; horizontal < 2; horizontal++) {
        lf_print print;
        lf_print_file *file;
        lf_proof_depth depth;
        depth_of(&(scene){0, true, horizontal, 0}, &print, &depth, &file);
        print_message("flip: %.2f matched, most %.2f\n", depth.measured, depth.most);
        assert_true(depth.measured < LF_PROOF_FLIP);
        lf_proof_depth_finish(&depth);
        lf_print_file_close(file);
    }
}

static void too_much_parallax_is_hatched_and_cut_edges_are_outlined(void **state)
{
    (void)state;
    uint8_t doubled[8 * 8] = {0};
    lf_proof_depth depth = {
        .width = 32, .height = 32, .columns = 2, .rows = 2, .doubled = doubled, .cut = {true}};
    lf_image32 image;
    int red[4] = {0}, blue = 0;
    for (int k = 0; k < 64; k++) /* on the right */
        doubled[k] = k % 8 >= 4;
    assert_int_equal(lf_image32_init(&image, 64, 64, 3), LF_OK);
    lf_proof_depth_mark(&depth, &image);
    for (int y = 0; y < 64; y++)
        for (int x = 0; x < 64; x++) {
            const float *p = image.data + 3 * (64 * y + x);
            red[y / 32 * 2 + x / 32] += p[0] > 0.5F;
            blue += p[2] > 0.5F;
            assert_true(p[2] < 0.5F || x < 2);
        }
    assert_int_equal(red[0] + red[2], 0);
    assert_true(red[1] > 100 && red[3] > 100);
    assert_int_equal(blue, 2 * 64);
    lf_image32_finish(&image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(own_views_are_those_of_the_table),
        cmocka_unit_test(a_wrong_pitch_drifts),
        cmocka_unit_test(what_is_not_known_is_assumed_in_words),
        cmocka_unit_test(ranges_of_views_are_those_of_rays),
        cmocka_unit_test(shifts_of_prints_are_measured),
        cmocka_unit_test(what_does_not_move_is_not_marked),
        cmocka_unit_test(a_flip_has_no_parallax),
        cmocka_unit_test(too_much_parallax_is_hatched_and_cut_edges_are_outlined),
    };
    return cmocka_run_group_tests_name("what a print does to its viewers", tests, make_folder,
                                       remove_folder);
}
