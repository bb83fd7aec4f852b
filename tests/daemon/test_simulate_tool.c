/* quiltrender PRINT.tif --simulate: images, films, numbers, and what is said of mistakes. */
#include "tests/daemon/quiltrender.h"

#include <jansson.h>

#include "base/image_io.h"

/* Two images, one red and one blue, as a print of two views. */
static int set_up(void **state)
{
    const int result = qr_set_up(state);
    const qr_files *f = *state;
    assert_int_equal(mkdir(lf_test_path(f->folder, "flip"), 0700), 0);
    for (int i = 0; i < 2; i++) {
        lf_image8 image;
        lf_outfile file;
        lf_error err;
        const char *path = lf_test_path(f->folder, i == 0 ? "flip/a.png" : "flip/b.png");
        assert_int_equal(lf_image8_init(&image, 30, 20, 3), LF_OK);
        for (int k = 0; k < 30 * 20; k++)
            image.data[k / 30 * (int)image.stride + k % 30 * 3 + 2 * i] = 255;
        lf_assert_ok(lf_outfile_open(&file, path, true, &err), &err);
        lf_assert_ok(lf_png_write(&file, &image, 1, NULL, 0, &err), &err);
        lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
        lf_image8_finish(&image);
    }
    qr_succeed("%s/flip/ -o %s/flip.tif --print 60.13@600 --print-size 30x20 --views 2 --bleed 2 "
               "--marks",
               f->folder, f->folder);
    return result;
}

static lf_image8 see(const qr_files *f, const char *options, qr_outcome *o)
{
    lf_image8 image;
    lf_error err;
    qr_run(o, "%s/flip.tif --simulate -o %s/seen.png%s", f->folder, f->folder, options);
    if (o->code != 0)
        fail_msg("%s", o->err);
    lf_assert_ok(lf_image8_read(lf_test_path(f->folder, "seen.png"), NULL, &image, &err), &err);
    return image;
}

/* All of the pixels in a column are mostly of channel c. */
static void assert_mostly(const lf_image8 *image, int x, int c)
{
    for (int y = 0; y < image->height; y++) {
        const uint8_t *p = image->data + (size_t)y * image->stride + 3 * (size_t)x;
        if (p[c] < 200 || p[2 - c] > 100)
            fail_msg("(%d, %d) is %d %d %d", x, y, p[0], p[1], p[2]);
    }
}

static void an_eye_on_either_side_sees_its_image(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    lf_image8 image = see(f, " --eye -90,0,400", &o);
    assert_non_null(strstr(o.err, "distance is not known"));
    assert_non_null(strstr(o.err, "the views jump"));
    assert_non_null(strstr(o.err, "from its own view"));
    assert_int_equal(image.width, 71); /* lenses on 30 mm */
    assert_int_equal(image.height, 47);
    for (int x = 0; x < image.width; x += 7)
        assert_mostly(&image, x, 0);
    lf_image8_finish(&image);
    image = see(f, " --eye 90,0,400 --width 100", &o);
    assert_int_equal(image.width, 100);
    for (int x = 0; x < image.width; x += 7)
        assert_mostly(&image, x, 2);
    lf_image8_finish(&image);
    /* beyond the range, the first image is there again */
    image = see(f, " --eye 265,0,400", &o);
    assert_mostly(&image, 30, 0);
    lf_image8_finish(&image);
}

static void another_sheet_shows_bands(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    lf_image8 image = see(f, " --eye -90,0,400 --print 61@600 --width 100", &o);
    assert_non_null(strstr(o.err, "the views shift by 1"));
    int red = 0, blue = 0;
    for (int x = 0; x < image.width; x++) {
        red += image.data[3 * x] > 200;
        blue += image.data[3 * x + 2] > 200;
    }
    assert_true(red > 20 && blue > 20);
    lf_image8_finish(&image);
}

static void both_eyes_are_seen(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    lf_image8 image = see(f, " --stereo --eye-distance 180 --eye 0,0,400 --width 80", &o);
    assert_int_equal(image.width, 160);
    assert_mostly(&image, 40, 0);
    assert_mostly(&image, 120, 2);
    lf_image8_finish(&image);
    image = see(f, " --stereo=anaglyph --eye-distance 180 --eye 0,0,400 --width 80", &o);
    assert_int_equal(image.width, 80);
    const uint8_t *p = image.data + 10 * image.stride + 3 * 40;
    assert_true(p[0] > 200 && p[2] > 200); /* red of the left eye, blue of the right one */
    lf_image8_finish(&image);
}

static void bleed_and_marks_are_shown_when_asked_for(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    lf_image8 image = see(f, " --eye -90,0,400 --untrimmed", &o);
    assert_in_range(image.width, 117, 119); /* 30 + 2 (2 + 8) mm */
    const uint8_t *corner = image.data;
    assert_true(corner[0] > 250 && corner[1] > 250 && corner[2] > 250);
    lf_image8_finish(&image);
}

/* Paper beyond the trim edge is cut off before anyone looks. */
static void no_margin_is_seen_at_the_edges(void **state)
{
    const qr_files *f = *state;
    static const char *const eyes[] = {"-90,0,400", "-90,150,400", "-110,-150,400"};
    qr_succeed("%s/flip/ -o %s/edge.tif --print 60.13@600 --print-size 30x20 --views 2 --marks",
               f->folder, f->folder);
    for (int i = 0; i < 6; i++) {
        lf_image8 image;
        lf_error err;
        qr_succeed("%s/edge.tif --simulate -o %s/seen.png --eye %s%s", f->folder, f->folder,
                   eyes[i / 2], i % 2 ? " --width 300" : "");
        lf_assert_ok(lf_image8_read(lf_test_path(f->folder, "seen.png"), NULL, &image, &err), &err);
        for (int x = 0; x < image.width; x++)
            assert_mostly(&image, x, 0);
        lf_image8_finish(&image);
    }
}

/* Of a page, an eye in front of the first copy sees this one. */
static void the_first_copy_of_a_page_is_shown(void **state)
{
    const qr_files *f = *state;
    static const char sheet[] = "--thickness 0.6 --distance 400";
    qr_outcome o;
    for (int round = 0; round < 3; round++) {
        static const char *const kinds[] = {"--label copy", "--mirror", "--orientation horizontal"};
        qr_succeed("%s/flip/ -o %s/page.tif --print 60.13@600 --print-size 30x20 --views 2 "
                   "--copies 2x3 --gutter 5 --marks --map uniform %s %s",
                   f->folder, f->folder, sheet, kinds[round]);
        for (int side = 0; side < 2; side++) {
            lf_image8 image;
            lf_error err;
            const int at = side ? 90 : -90;
            qr_run(&o, "%s/page.tif --simulate -o %s/seen.png --eye %d,%d,400", f->folder,
                   f->folder, round < 2 ? at : 0, round < 2 ? 0 : at);
            assert_int_equal(o.code, 0);
            assert_non_null(strstr(o.err, "a page of 2x3 copies; the first one is shown"));
            lf_assert_ok(lf_image8_read(lf_test_path(f->folder, "seen.png"), NULL, &image, &err),
                         &err);
            for (int x = 0; x < image.width; x++)
                assert_mostly(&image, x, side ? 2 : 0);
            lf_image8_finish(&image);
        }
    }
    assert_int_equal(unlink(lf_test_path(f->folder, "page.json")), 0);
    qr_run(&o, "%s/page.tif --simulate -o %s/seen.png --print 60.13@600 --copies 2x3", f->folder,
           f->folder);
    qr_assert_fails(&o, 2, "where its copies are");
}

/* ---------------------------------------------------------------------------------- profiles -- */

/* The sheet's profile alone is enough: the file knows its raster, and its manifest the printer. */
static void a_lens_is_enough(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    setenv("XDG_CONFIG_HOME", f->folder, 1);
    assert_int_equal(mkdir(lf_test_path(f->folder, "quiltd"), 0700), 0);
    assert_int_equal(mkdir(lf_test_path(f->folder, "quiltd/lenses"), 0700), 0);
    assert_int_equal(mkdir(lf_test_path(f->folder, "quiltd/printers"), 0700), 0);
    lf_test_write(
        f->folder, "quiltd/lenses/own.json",
        "{\"quiltd_lens\": 1, \"pitch_lpi\": 60.2, \"thickness_mm\": 0.6, "
        "\"calibrations\": [{\"printer\": \"here\", \"visual_lpi\": 60.13, "
        "\"distance_mm\": 400, \"crosstalk_views\": 6, \"crosstalk\": [0.2, 0.6, 0.2]}]}");
    lf_test_write(f->folder, "quiltd/printers/here.json",
                  "{\"quiltd_printer\": 1, \"dpi\": 720, \"dot_gain\": 0.1}");
    /* no profile was used for the print */
    qr_run(&o, "%s/flip.tif --simulate -o %s/seen.png --lens own", f->folder, f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "the pitch is not measured"));
    /* with profiles; the raster is the file's */
    qr_succeed("%s -o %s/known.tif --lens own --printer here --print-size 30x20 --views 6 "
               "--print 60.13@600",
               f->quilt, f->folder);
    qr_run(&o, "%s/known.tif --simulate -o %s/seen.png --lens own", f->folder, f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "60.1300 lpi at 400 mm, measured with here"));
    assert_non_null(strstr(o.err, "printer here: 600 dpi as given"));
    const char *own = strstr(o.err, "an eye gets ");
    assert_non_null(own);
    assert_in_range(atoi(own + strlen("an eye gets ")), 58, 61); /* the crosstalk's 0.6 */
    /* nothing is left of the sheet that a print was made for */
    lf_test_write(f->folder, "quiltd/lenses/bare.json",
                  "{\"quiltd_lens\": 1, \"pitch_lpi\": 60.2}");
    qr_succeed("%s -o %s/thick.tif --print 60.13@600 --print-size 30x20 --views 6 --thickness 0.6 "
               "--distance 400",
               f->quilt, f->folder);
    qr_run(&o, "%s/thick.tif --simulate -o %s/seen.png --lens bare", f->folder, f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "the sheet's thickness is not known"));
    /* a manifest may be anyone's: it names no files */
    json_error_t where;
    const char *path = lf_test_path(f->folder, "known.json");
    json_t *manifest = json_load_file(path, 0, &where), *own_printer;
    assert_non_null(manifest);
    own_printer = json_object_get(json_object_get(manifest, "profiles"), "printer");
    json_object_set_new(own_printer, "profile",
                        json_string(lf_test_path(f->folder, "quiltd/printers/here.json")));
    assert_int_equal(json_dump_file(manifest, lf_test_path(f->folder, "known.json"), 0), 0);
    json_decref(manifest);
    qr_run(&o, "%s/known.tif --simulate -o %s/seen.png --lens own", f->folder, f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "the pitch is not measured"));
    unsetenv("XDG_CONFIG_HOME");
    /* the printer's profile is not here */
    qr_run(&o, "%s/known.tif --simulate -o %s/seen.png --lens %s/quiltd/lenses/own.json", f->folder,
           f->folder, f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "the pitch is not measured"));
}

static void numbers_are_written_as_json(void **state)
{
    const qr_files *f = *state;
    json_error_t where;
    qr_succeed("%s/flip.tif --simulate -o %s/proof.json --thickness 0.6 --distance 400", f->folder,
               f->folder);
    json_t *report = json_load_file(lf_test_path(f->folder, "proof.json"), 0, &where);
    assert_non_null(report);
    const json_t *views = json_object_get(report, "views");
    lf_assert_close(json_real_value(json_object_get(views, "range_mm")),
                    2 * 400 * tan(asin(1.56 * sin(atan(25.4 / 60.13 / 2 / 0.6)))), 1e-4, 0);
    assert_int_equal(json_integer_value(json_object_get(views, "count")), 2);
    assert_true(json_is_null(json_object_get(report, "parallax"))); /* nothing to match: a flip */
    assert_int_equal(json_array_size(json_object_get(report, "assumed")), 0);
    json_decref(report);
}

static void mistakes_are_one_line(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    qr_run(&o, "--simulate -o %s/x.png", f->folder);
    qr_assert_fails(&o, 2, "PRINT.tif: is missing");
    qr_run(&o, "%s/flip.tif --simulate", f->folder);
    qr_assert_fails(&o, 2, "-o: is missing");
    qr_run(&o, "%s/flip.tif --simulate -o %s/x.pdf", f->folder, f->folder);
    qr_assert_fails(&o, 2, "must end in");
    qr_run(&o, "%s --simulate -o %s/x.png", f->scene, f->folder);
    qr_assert_fails(&o, 1, "not a TIFF");
    qr_run(&o, "%s/flip.pdf --simulate -o %s/x.png", f->folder, f->folder);
    qr_assert_fails(&o, 2, "is a PDF; --simulate reads TIFF");
    qr_run(&o, "%s/flip --simulate -o %s/x.png", f->folder, f->folder);
    qr_assert_fails(&o, 2, "is a folder; --simulate takes one interlaced print");
    qr_run(&o, "%s/flip.tif -o %s/x.png --mark", f->folder, f->folder);
    qr_assert_fails(&o, 2, "--mark: needs --simulate");
    qr_run(&o, "%s/flip.tif --simulate --stereo -o %s/x.gif", f->folder, f->folder);
    qr_assert_fails(&o, 2, "--stereo: is for images");
    static const char *const eyes[] = {"1", "1,2", "1,2,3,4", "a,0,400", "0,0,0", "0,0,nan", ",,"};
    for (size_t i = 0; i < sizeof eyes / sizeof *eyes; i++) {
        qr_run(&o, "%s/flip.tif --simulate --eye %s -o %s/x.png", f->folder, eyes[i], f->folder);
        assert_int_equal(o.code, 2);
        assert_non_null(strstr(o.err, "--eye: "));
    }
    assert_false(qr_exists(f->folder, "x.png"));
}

/* A proof never replaces the print or its manifest. */
static void the_print_and_its_manifest_stay(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    qr_run(&o, "%s/flip.tif --simulate -o %s/flip.json", f->folder, f->folder);
    qr_assert_fails(&o, 2, "is the manifest of a print");
    qr_succeed("%s/flip.tif --simulate -o %s/seen.png", f->folder, f->folder);
    assert_int_equal(symlink("flip.tif", lf_test_path(f->folder, "link.png")), 0);
    qr_run(&o, "%s/flip.tif --simulate -o %s/link.png", f->folder, f->folder);
    qr_assert_fails(&o, 2, "-o: is the print itself");
    /* other numbers are replaced */
    for (int i = 0; i < 2; i++)
        qr_succeed("%s/flip.tif --simulate -o %s/numbers.json", f->folder, f->folder);
}

static void options_without_a_use_are_refused(void **state)
{
    const qr_files *f = *state;
    static const char *const useless[] = {
        "--label x", "--relief",   "--frame-set 100", "--guard 1",       "--morph 2",
        "--marks",   "--bits 16",  "--icc x",         "--compensate on", "--headroom .1",
        "--bleed 2", "--gutter 5", "--paper 210x297"};
    static const char *const wrong[][2] = {
        {"x.gif --mark", "--mark: is for images"},
        {"x.json --mark", "--mark: is for images"},
        {"x.png --mark --stereo=anaglyph", "--mark: is red and blue"},
        {"x.png --eye-distance 60", "--eye-distance: needs --stereo"}};
    qr_outcome o;
    for (size_t i = 0; i < sizeof useless / sizeof *useless; i++) {
        qr_run(&o, "%s/flip.tif --simulate -o %s/x.png %s", f->folder, f->folder, useless[i]);
        qr_assert_fails(&o, 2, "does nothing with --simulate");
    }
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        qr_run(&o, "%s/flip.tif --simulate -o %s/%s", f->folder, f->folder, wrong[i][0]);
        qr_assert_fails(&o, 2, wrong[i][1]);
    }
    qr_succeed("%s/flip.tif --simulate -o %s/seen.png --map exact --stripes nearest --spot .02",
               f->folder, f->folder);
}

static void a_print_that_was_resized_is_refused(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    char *json = NULL;
    size_t size;
    lf_error err;
    qr_succeed("%s/flip/ -o %s/other.tif --print 60@600 --print-size 20x20 --views 2", f->folder,
               f->folder);
    lf_assert_ok(
        lf_file_read(lf_test_path(f->folder, "flip.json"), NULL, 1 << 20, &json, &size, &err),
        &err);
    lf_assert_ok(lf_outfile_text(lf_test_path(f->folder, "other.json"), json, &err), &err);
    lf_free(json);
    qr_run(&o, "%s/other.tif --simulate -o %s/x.png", f->folder, f->folder);
    qr_assert_fails(&o, 1, "something resized it");
    assert_int_equal(unlink(lf_test_path(f->folder, "other.json")), 0);
    qr_run(&o, "%s/other.tif --simulate -o %s/x.png", f->folder, f->folder);
    qr_assert_fails(&o, 2, "has no manifest");
    qr_succeed("%s/other.tif --simulate -o %s/x.png --print 60@600 --views 2", f->folder,
               f->folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_eye_on_either_side_sees_its_image),
        cmocka_unit_test(another_sheet_shows_bands),
        cmocka_unit_test(both_eyes_are_seen),
        cmocka_unit_test(bleed_and_marks_are_shown_when_asked_for),
        cmocka_unit_test(no_margin_is_seen_at_the_edges),
        cmocka_unit_test(the_first_copy_of_a_page_is_shown),
        cmocka_unit_test(a_lens_is_enough),
        cmocka_unit_test(numbers_are_written_as_json),
        cmocka_unit_test(mistakes_are_one_line),
        cmocka_unit_test(the_print_and_its_manifest_stay),
        cmocka_unit_test(options_without_a_use_are_refused),
        cmocka_unit_test(a_print_that_was_resized_is_refused),
    };
    return cmocka_run_group_tests_name("quiltrender --simulate", tests, set_up, qr_tear_down);
}
