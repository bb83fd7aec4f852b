/* Height maps of lens sheets: heights and volume in closed form, pitch and phase by lock-in. Own
 * arithmetic. */
#include "tests/testing.h"

#include <tiffio.h>

#include "base/alloc.h"
#include "quilt/print/relief.h"
#include "tests/quilt/printed.h"

/* 60 lpi on 1200 dpi, lenses of radius 0.25 mm. */
static lf_print sheet(void)
{
    lf_print print = lf_print_sound();
    print.dpi = 1200;
    print.width_mm = 20;
    print.height_mm = 6;
    print.relief = true;
    print.optics.radius_mm = 0.25;
    return print;
}

typedef struct height_map {
    int width, height;
    uint16_t *code;
    json_t *manifest;
} height_map;

static void read_map(const char *path, height_map *out)
{
    TIFF *tiff = TIFFOpen(path, "r");
    uint32_t width, height;
    uint16_t bits, samples, photometric;
    float resolution;
    assert_non_null(tiff);
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
    TIFFGetField(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetField(tiff, TIFFTAG_SAMPLESPERPIXEL, &samples);
    TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
    TIFFGetField(tiff, TIFFTAG_XRESOLUTION, &resolution);
    assert_true(bits == 16 && samples == 1 && photometric == PHOTOMETRIC_MINISBLACK);
    assert_true(resolution == 1200.0F);
    out->width = (int)width;
    out->height = (int)height;
    out->code = lf_calloc((size_t)width * height, sizeof *out->code);
    assert_non_null(out->code);
    for (uint32_t y = 0; y < height; y++)
        assert_int_equal(TIFFReadScanline(tiff, out->code + (size_t)y * width, y, 0), 1);
    TIFFClose(tiff);
}

static void make_map(const lf_print *print, const char *folder, height_map *out)
{
    static const char *const names[] = {"p.tif", "p.json", "p_relief.tif"};
    static const float grey[3] = {0.5F, 0.5F, 0.5F};
    const lf_views32 views = {1, 1, 1, 3, 3, grey, NULL, NULL, NULL};
    lf_outfile files[3];
    lf_error err;
    const lf_print_run run = {.relief = &files[2]};
    for (int i = 0; i < 3; i++)
        lf_assert_ok(lf_outfile_open(&files[i], lf_test_path(folder, names[i]), true, &err), &err);
    lf_assert_ok(lf_print_write(print, &views, &run, &files[0], &files[1], &err), &err);
    for (int i = 0; i < 3; i++)
        lf_assert_ok(lf_outfile_commit(&files[i], true, &err), &err);
    read_map(lf_test_path(folder, names[2]), out);
    out->manifest = json_load_file(lf_test_path(folder, names[1]), 0, NULL);
    assert_non_null(out->manifest);
}

static void finish_map(height_map *map)
{
    lf_free(map->code);
    json_decref(map->manifest);
}

static double relief_number(const height_map *map, const char *key)
{
    return json_number_value(json_object_get(json_object_get(map->manifest, "relief"), key));
}

/* Height over the feet at the distance u from the axis. */
static double circle(double radius, double reach, double u)
{
    return sqrt(radius * radius - u * u) - sqrt(radius * radius - reach * reach);
}

/* ----------------------------------------------------------------------------------- heights -- */

static void heights_are_those_of_a_circle(void **state)
{
    (void)state;
    lf_print print = sheet();
    lf_relief relief;
    lf_error err;
    const double p = 25.4 / 60;
    print.phase_mm = 0.05;
    lf_assert_ok(lf_relief_of(&print, &relief, &err), &err);
    lf_assert_close(relief.sag_mm, 0.25 - sqrt(0.0625 - p * p / 4), 0, 1e-12);
    for (int i = -20; i <= 20; i++) {
        const double u = i * p / 41;
        lf_assert_close(lf_relief_height(&relief, 0.05 + 3 * p + u, 1.7), circle(0.25, p / 2, u), 0,
                        1e-12);
    }
    print.horizontal = true;
    lf_assert_ok(lf_relief_of(&print, &relief, &err), &err);
    lf_assert_close(lf_relief_height(&relief, 1.7, 0.05 - 2 * p + 0.1), circle(0.25, p / 2, 0.1), 0,
                    1e-12);
}

static void leaning_lenses_lean_to_the_right_at_the_top(void **state)
{
    (void)state;
    lf_print print = sheet();
    lf_relief relief;
    lf_error err;
    const double p = 25.4 / 60, slant = 10 * M_PI / 180;
    print.optics.slant = 10;
    lf_assert_ok(lf_relief_of(&print, &relief, &err), &err);
    /* 5 mm up, the axis of the middle lens is 5 tan(slant) to the right */
    lf_assert_close(lf_relief_height(&relief, 5 * tan(slant), -5), relief.sag_mm, 0, 1e-12);
    lf_assert_close(lf_relief_height(&relief, 5 * tan(slant) + 0.1, -5),
                    circle(0.25, p / 2, 0.1 * cos(slant)), 0, 1e-12);
}

static void micro_lenses_are_parts_of_spheres(void **state)
{
    (void)state;
    lf_print print = sheet();
    lf_relief relief;
    lf_error err;
    const double p = 25.4 / 60;
    print.optics.radius_mm = 0.31;
    print.n_views = 4;
    print.optics.grid = LF_LENS_SQUARE;
    lf_assert_ok(lf_relief_of(&print, &relief, &err), &err);
    lf_assert_close(lf_relief_height(&relief, 2 * p + 0.1, -p + 0.15),
                    circle(0.31, p * sqrt(0.5), hypot(0.1, 0.15)), 0, 1e-12);
    lf_assert_close(lf_relief_height(&relief, 0.5 * p, 0.5 * p), 0, 0, 1e-12);
    print.optics.grid = LF_LENS_HEXAGONAL;
    lf_assert_ok(lf_relief_of(&print, &relief, &err), &err);
    for (int j = -3; j <= 3; j++) {
        const double x = (2 + (j & 1) * 0.5) * p, y = j * p * sqrt(3) / 2;
        lf_assert_close(lf_relief_height(&relief, x, y), relief.sag_mm, 0, 1e-12);
        lf_assert_close(lf_relief_height(&relief, x + 0.07, y - 0.11),
                        circle(0.31, p / sqrt(3), hypot(0.07, 0.11)), 0, 1e-12);
    }
    /* where three lenses meet */
    lf_assert_close(lf_relief_height(&relief, 0, p / sqrt(3)), 0, 0, 1e-12);
}

/* -------------------------------------------------------------------------------------- file -- */

static void the_file_has_pitch_phase_and_volume_of_the_sheet(void **state)
{
    for (int horizontal = 0; horizontal < 2; horizontal++) {
        lf_print print = sheet();
        height_map map;
        print.phase_mm = 0.083;
        print.horizontal = horizontal;
        print.mirror = true; /* the picture alone is mirrored */
        print.optics.thickness_mm = 0.6;
        print.optics.distance_mm = 400;
        make_map(&print, *state, &map);
        const double pitch = 25.4 / 60 / (1 + 0.6 / (1.56 * 400)), pixel = 25.4 / 1200;
        lf_assert_close(relief_number(&map, "pitch_mm"), pitch, 1e-12, 0);
        const double sag = circle(0.25, pitch / 2, 0);
        lf_assert_close(
            json_number_value(json_array_get(
                json_object_get(json_object_get(map.manifest, "relief"), "height_mm"), 1)),
            sag, 0, 1e-12);
        /* lock-in over whole lenses */
        const int n = horizontal ? map.height : map.width;
        const double whole = floor(n * pixel / pitch) * pitch;
        double cosine = 0, sine = 0, sum = 0;
        int counted = 0;
        for (int i = 0; i < n; i++) {
            const double u = (i + 0.5 - 0.5 * n) * pixel;
            const size_t at =
                horizontal ? (size_t)i * (size_t)map.width + 7 : 11 * (size_t)map.width + (size_t)i;
            const double h = map.code[at] / 65535.0 * sag;
            lf_assert_close(h,
                            circle(0.25, pitch / 2, u - 0.083 - pitch * round((u - 0.083) / pitch)),
                            0, sag / 65535);
            if (fabs(u) > 0.5 * whole)
                continue;
            cosine += h * cos(2 * M_PI * u / pitch);
            sine += h * sin(2 * M_PI * u / pitch);
            sum += h;
            counted++;
        }
        lf_assert_close(atan2(sine, cosine) * pitch / (2 * M_PI), 0.083, 0, 0.001);
        /* the mean height of a circle's segment */
        const double edge = sqrt(0.0625 - pitch * pitch / 4),
                     mean = (0.5 * pitch * edge + 0.0625 * asin(pitch / 0.5)) / pitch - edge;
        lf_assert_close(sum / counted, mean, 0.01, 0);
        finish_map(&map);
    }
}

static void the_margin_of_marks_is_flat(void **state)
{
    lf_print print = sheet();
    height_map map;
    print.marks = true;
    make_map(&print, *state, &map);
    const int margin = (int)lround(8 * 1200 / 25.4);
    assert_int_equal(map.width, lround(20 * 1200 / 25.4) + 2 * margin);
    int n_high = 0;
    for (int y = 0; y < map.height; y++)
        for (int x = 0; x < map.width; x++) {
            const bool inside =
                x >= margin && x < map.width - margin && y >= margin && y < map.height - margin;
            const uint16_t code = map.code[(size_t)y * (size_t)map.width + (size_t)x];
            assert_true(inside || code == 0);
            n_high += code > 32768;
        }
    assert_true(n_high > (map.width - 2 * margin) * (map.height - 2 * margin) / 2);
    finish_map(&map);
}

/* Two copies side by side: the lenses of one sheet, counted from the middle of the page. */
static void one_sheet_lies_over_all_copies(void **state)
{
    lf_print print = sheet();
    height_map map;
    print.sheet.columns = 2;
    print.sheet.rows = 1;
    print.sheet.gutter_mm = 3;
    print.optics.thickness_mm = 0.6;
    print.optics.distance_mm = 300;
    make_map(&print, *state, &map);
    const double pitch = 25.4 / 60 / (1 + 0.6 / (1.56 * 300)), sag = circle(0.25, pitch / 2, 0);
    int n_lenses = 0, n_flat = 0;
    assert_true(map.width > lround(43 * 1200 / 25.4));
    for (int x = 0; x < map.width; x++) {
        const double u = (x + 0.5 - 0.5 * map.width) * 25.4 / 1200,
                     from_axis = u - pitch * round(u / pitch);
        const uint16_t code = map.code[11 * (size_t)map.width + (size_t)x];
        const bool is_lens =
            fabs(code / 65535.0 * sag - circle(0.25, pitch / 2, from_axis)) < sag / 65535;
        assert_true(is_lens || code == 0);
        n_lenses += is_lens;
        n_flat += !is_lens;
        if (fabs(u) < 1.4)
            assert_int_equal(code, 0);
    }
    assert_true(n_lenses >= 2 * lround(20 * 1200 / 25.4));
    assert_true(n_flat > 100);
    finish_map(&map);
}

/* ------------------------------------------------------------------------------------ checks -- */

static void the_radius_follows_from_what_is_known(void **state)
{
    (void)state;
    lf_print print = sheet();
    lf_relief relief;
    lf_error err;
    print.optics = (lf_optics){.thickness_mm = 0.7, .index = 1.5};
    lf_assert_ok(lf_relief_of(&print, &relief, &err), &err);
    lf_assert_close(relief.radius_mm, 0.7 * 0.5 / 1.5, 1e-12, 0);
    assert_string_equal(relief.from, "thickness");
    assert_true(lf_relief_spot(&relief) < 1e-12);
    print.optics = (lf_optics){.angle = 40, .index = 1.5};
    lf_assert_ok(lf_relief_of(&print, &relief, &err), &err);
    /* the edge ray at 20 degrees in air, by Snell's law, meets the edge of the cell */
    const double inside = asin(sin(20 * M_PI / 180) / 1.5), t = 0.5 * (25.4 / 60) / tan(inside);
    lf_assert_close(relief.radius_mm, t / 3, 1e-12, 0);
    print.optics = (lf_optics){0};
    assert_int_equal(lf_relief_of(&print, &relief, &err), LF_E_ARG);
    assert_non_null(strstr(err.what, "needs the radius, the thickness or the viewing angle"));
}

static void lenses_that_cannot_be_are_refused(void **state)
{
    (void)state;
    lf_print print = sheet();
    lf_relief relief;
    lf_error err;
    print.optics.radius_mm = 0.2116;
    assert_int_equal(lf_print_check(&print, NULL, &err), LF_E_ARG);
    assert_non_null(strstr(err.what, "use at least 0.2117 mm"));
    print.optics.radius_mm = 0.2117;
    lf_assert_ok(lf_relief_of(&print, &relief, &err), &err);
    print.optics.thickness_mm = 0.2;
    assert_int_equal(lf_print_check(&print, NULL, &err), LF_E_ARG);
    assert_non_null(strstr(err.what, "do not fit in a sheet of 0.2 mm"));
}

static void a_focus_off_the_print_is_told(void **state)
{
    (void)state;
    lf_print print = sheet();
    lf_relief relief;
    lf_error err;
    lf_image_notes notes = {0};
    char line[512];
    size_t at = 0;
    print.n_views = 8;
    print.optics.distance_mm = 400;
    /* 0.25 mm focus at 0.6964 mm: a stripe is pitch / 8 */
    print.optics.thickness_mm = 0.6964 * (1 + 1 / 8.2);
    lf_assert_ok(lf_relief_of(&print, &relief, &err), &err);
    lf_relief_note(&relief, &notes);
    assert_false(lf_image_notes_next(&notes, &at, line, sizeof line));
    print.optics.thickness_mm = 0.6964 * (1 - 1 / 7.8);
    lf_assert_ok(lf_relief_of(&print, &relief, &err), &err);
    lf_relief_note(&relief, &notes);
    assert_true(lf_image_notes_next(&notes, &at, line, sizeof line));
    assert_non_null(strstr(line, "focus at 0.6964 mm, but the print lies at 0.6071 mm"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(heights_are_those_of_a_circle),
        cmocka_unit_test(leaning_lenses_lean_to_the_right_at_the_top),
        cmocka_unit_test(micro_lenses_are_parts_of_spheres),
        lf_test_in_folder(the_file_has_pitch_phase_and_volume_of_the_sheet),
        lf_test_in_folder(the_margin_of_marks_is_flat),
        lf_test_in_folder(one_sheet_lies_over_all_copies),
        cmocka_unit_test(the_radius_follows_from_what_is_known),
        cmocka_unit_test(lenses_that_cannot_be_are_refused),
        cmocka_unit_test(a_focus_off_the_print_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
