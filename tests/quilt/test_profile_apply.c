/* What profiles give to a print: the pitch at a distance, and that options win. Shipped profiles.
 */
#include "tests/testing.h"

#include <jansson.h>

#include "base/alloc.h"
#include "tests/quilt/profile_folders.h"

static lf_lens_profile lens; /* large */
static lf_printer_profile printer;
static lf_profile_told told;

/* ------------------------------------------------------------------------------------- pitch -- */

static void the_pitch_at_a_distance_is_that_of_the_closed_form(void **state)
{
    /* 60.20 lpi, 0.6 mm, n = 1.56: computed by hand for the facts, five digits */
    static const double table[][2] = {{150, 60.046}, {300, 60.123},  {400, 60.142},
                                      {600, 60.161}, {1000, 60.177}, {2000, 60.188}};
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        lf_assert_close(lf_profile_pitch(60.2, 0, table[i][0], 0.6, 1.56), table[i][1], 0, 0.00051);
        /* there and back */
        lf_assert_close(lf_profile_pitch(lf_profile_pitch(60.2, 0, table[i][0], 0.6, 1.56),
                                         table[i][0], 0, 0.6, 1.56),
                        60.2, 1e-14, 0);
    }
    /* finer for further: a control against the wrong sign */
    assert_true(lf_profile_pitch(60, 400, 800, 0.6, 1.56) > 60);
    assert_true(lf_profile_pitch(60, 400, 200, 0.6, 1.56) < 60);
}

static void thickness_and_angle_belong_together(void **state)
{
    (void)state;
    /* the vertex model of the sheet of the facts: 65.1 degrees */
    lf_assert_close(lf_profile_angle(25.4 / 0.33665, 0.457, 1.557), 65.1, 0, 0.06);
    lf_assert_close(lf_profile_thickness(25.4 / 0.33665, 65.1, 1.557), 0.457, 0, 0.0006);
    for (double angle = 5; angle < 170; angle += 5)
        lf_assert_close(lf_profile_angle(60, lf_profile_thickness(60, angle, 1.56), 1.56), angle,
                        1e-9, 0);
    assert_true(lf_profile_angle(10, 0.01, 1.56) == 180);
}

/* ------------------------------------------------------------------------------------- apply -- */

static lf_lens_calibration measured(const char *with, double lpi, double distance_mm)
{
    lf_lens_calibration c = {.visual_lpi = lpi, .distance_mm = distance_mm};
    snprintf(c.printer, sizeof c.printer, "%s", with);
    return c;
}

/* acme: 60.2 lpi, 0.6 mm, n = 1.56; ink: 720 dpi */
static void make_profiles(void)
{
    lens = (lf_lens_profile){
        .file.name = "acme",
        .pitch_lpi = 60.2,
        .optics = {.thickness_mm = 0.6, .index = 1.56, .angle = 54, .radius_mm = 0.2},
        .spot_mm = 0.03};
    printer = (lf_printer_profile){.file.name = "ink", .dpi = 720, .dot_gain = 0.1, .ink_mm = 0.02};
    printer.registered = true;
}

static lf_print plain_print(void)
{
    lf_print print = {0};
    lf_param_defaults(lf_print_params, &print);
    return print;
}

static lf_print_given given_of(const char *option, lf_print *print, const char *text)
{
    lf_error err = {0};
    lf_print_given given = {0};
    const lf_param *row = option ? lf_param_find(lf_print_params, option) : NULL;
    if (row) {
        lf_assert_ok(lf_param_from_text(row, text, print, &err), &err);
        lf_print_give(&given, row);
    }
    return given;
}

/* What profiles give with one option of the user; NULL: none. */
static lf_status apply(const char *option, const char *text, lf_print *out, lf_error *err)
{
    *out = plain_print();
    const lf_print_given given = given_of(option, out, text);
    return lf_profile_apply(&lens, &printer, &given, out, &told, err);
}

static void a_calibration_gives_the_pitch(void **state)
{
    lf_error err = {0};
    lf_print print;
    (void)state;
    make_profiles();
    lens.calibrations[0] = measured("other", 61, 400);
    lens.calibrations[1] = measured("ink", 60.13, 400);
    lens.calibrations[1].phase_mm = 0.05;
    lens.calibrations[1].reverse = true;
    lens.calibrations[1].n_crosstalk = 1;
    lens.calibrations[1].crosstalk[1] = 1;
    lens.calibrations[1].crosstalk_views = 8;
    lens.n_calibrations = 2;
    lf_assert_ok(apply(NULL, NULL, &print, &err), &err);
    assert_true(print.lpi == 60.13 && print.dpi == 720 && print.optics.distance_mm == 400);
    assert_true(print.phase_mm == 0.05 && print.reverse);
    assert_true(print.optics.thickness_mm == 0.6 && print.optics.index == 1.56);
    assert_true(print.optics.angle == 54 && print.optics.radius_mm == 0.2);
    assert_true(print.blur.spot_mm == 0.03 && print.blur.dot_gain == 0.1);
    assert_true(print.blur.ink_mm == 0.02 && print.blur.n_crosstalk == 1);
    assert_true(print.blur.crosstalk[1] == 1 && print.blur.crosstalk_views == 8);
    assert_int_equal(told.warnings.length, 0);
    assert_non_null(strstr(told.lines.text, "lens acme: 60.1300 lpi at 400 mm, measured with ink"));
    assert_non_null(strstr(told.lines.text, "printer ink: 720 dpi"));
    /* elsewhere: by the thickness */
    lf_assert_ok(apply("distance", "1000", &print, &err), &err);
    const double right = 60.13 * (1 + 0.6 / (1.56 * 400)) / (1 + 0.6 / (1.56 * 1000));
    lf_assert_close(print.lpi, right, 1e-14, 0);
    assert_true(print.optics.distance_mm == 1000);
    assert_non_null(strstr(told.lines.text, "computed for 1000 mm"));
    assert_int_equal(told.warnings.length, 0);
}

/* A print's own values do not survive into a sheet that lacks them; a measured phase of 0 counts.
 */
static void the_sheet_is_that_of_the_profile_alone(void **state)
{
    lf_error err = {0};
    const lf_print_given none = {0};
    (void)state;
    make_profiles();
    lens.optics = (lf_optics){0};
    lens.spot_mm = 0;
    lens.calibrations[0] = measured("ink", 60.13, 400);
    lens.n_calibrations = 1;
    lf_print print = plain_print();
    print.phase_mm = 0.14;
    print.optics = (lf_optics){.thickness_mm = 0.9,
                               .index = 1.4,
                               .radius_mm = 1,
                               .angle = 30,
                               .slant = 10,
                               .distance_mm = 400};
    print.blur = (lf_print_blur){.spot_mm = 0.1, .n_crosstalk = 1, .crosstalk = {0, 1, 0}};
    lf_print own = print;
    lf_assert_ok(lf_profile_apply(&lens, &printer, &none, &print, &told, &err), &err);
    assert_true(print.phase_mm == 0 && print.optics.slant == 0);
    assert_true(print.optics.thickness_mm == 0 && print.optics.index == 0);
    assert_true(print.optics.radius_mm == 0 && print.optics.angle == 0);
    assert_true(print.blur.spot_mm == 0 && print.blur.n_crosstalk == 0);
    assert_non_null(strstr(told.lines.text, "phase 0 mm"));
    /* options win */
    lf_print_given given = given_of("phase", &own, "0.14");
    lf_print_give(&given, lf_param_find(lf_print_params, "slant"));
    lf_assert_ok(lf_profile_apply(&lens, &printer, &given, &own, &told, &err), &err);
    assert_true(own.phase_mm == 0.14 && own.optics.slant == 10 && own.optics.index == 0);
    assert_null(strstr(told.lines.text, "phase"));
}

static void a_phase_is_of_lenses_that_run_as_the_charts(void **state)
{
    lf_error err = {0};
    lf_print print;
    (void)state;
    make_profiles();
    lens.calibrations[0] = measured("ink", 60.13, 400);
    lens.calibrations[0].phase_mm = 0.05;
    lens.calibrations[0].reverse = true;
    lens.n_calibrations = 1;
    lf_assert_ok(apply(NULL, NULL, &print, &err), &err);
    assert_true(print.phase_mm == 0.05);
    assert_non_null(strstr(told.lines.text, "phase 0.05 mm, views in reverse order"));
    /* a chart is vertical unless something says otherwise */
    lf_assert_ok(apply("orientation", "horizontal", &print, &err), &err);
    assert_true(print.horizontal && print.phase_mm == 0 && print.lpi == 60.13);
    assert_null(strstr(told.lines.text, "phase"));
    assert_non_null(strstr(told.warnings.text,
                           "acme was measured with vertical lenses, so the phase of horizontal "
                           "ones is unknown; measure a chart with --orientation horizontal"));
    /* the calibration of the other lenses, at the same distance */
    lens.calibrations[1] = measured("ink", 60.12, 400);
    lens.calibrations[1].phase_mm = 0.07;
    lens.calibrations[1].horizontal = lens.calibrations[1].has_horizontal = true;
    lens.n_calibrations = 2;
    lf_assert_ok(apply("orientation", "horizontal", &print, &err), &err);
    assert_true(print.phase_mm == 0.07 && print.lpi == 60.12);
    assert_int_equal(told.warnings.length, 0);
    lf_assert_ok(apply(NULL, NULL, &print, &err), &err);
    assert_true(print.phase_mm == 0.05 && print.lpi == 60.13);
    /* a sheet that is used with horizontal lenses was measured so */
    lens.n_calibrations = 1;
    lens.horizontal = lens.has_horizontal = true;
    lf_assert_ok(apply(NULL, NULL, &print, &err), &err);
    assert_true(print.horizontal && print.phase_mm == 0.05);
    lf_assert_ok(apply("orientation", "vertical", &print, &err), &err);
    assert_true(print.phase_mm == 0);
    assert_non_null(strstr(told.warnings.text, "phase of vertical ones is unknown"));
}

/* Without a jig, the phase is one of the laying of the chart's sheet. */
static void a_phase_needs_a_registered_printer(void **state)
{
    lf_error err = {0};
    lf_print print;
    (void)state;
    make_profiles();
    printer.registered = false;
    lens.calibrations[0] = measured("ink", 60.13, 400);
    lens.calibrations[0].phase_mm = 0.071;
    lens.n_calibrations = 1;
    lf_assert_ok(apply(NULL, NULL, &print, &err), &err);
    assert_true(print.phase_mm == 0 && print.lpi == 60.13);
    assert_non_null(
        strstr(told.lines.text, "phase +0.071 mm not applied, because ink is not registered"));
    assert_int_equal(told.warnings.length, 0);
    lf_assert_ok(apply("phase", "0.02", &print, &err), &err);
    assert_true(print.phase_mm == 0.02);
    assert_null(strstr(told.lines.text, "phase"));
    lf_assert_ok(apply("orientation", "horizontal", &print, &err), &err);
    assert_true(print.phase_mm == 0);
    assert_int_equal(told.warnings.length, 0);
}

static void an_option_wins_over_profiles(void **state)
{
    static const struct {
        const char *option, *text;
        size_t place;
        double value;
    } of[] = {
#define AT(field) offsetof(lf_print, field)
        {"print", "59.5@600", AT(lpi), 59.5},
        {"print", "59.5@600", AT(dpi), 600},
        {"phase", "0.2", AT(phase_mm), 0.2},
        {"phase", "0", AT(phase_mm), 0},
        {"thickness", "0.5", AT(optics.thickness_mm), 0.5},
        {"index", "1.4", AT(optics.index), 1.4},
        {"radius", "0.3", AT(optics.radius_mm), 0.3},
        {"viewing-angle", "40", AT(optics.angle), 40},
        {"slant", "0", AT(optics.slant), 0},
        {"spot", "0.05", AT(blur.spot_mm), 0.05},
        {"dot-gain", "0", AT(blur.dot_gain), 0},
        {"ink-spread", "0.1", AT(blur.ink_mm), 0.1},
#undef AT
    };
    lf_error err = {0};
    lf_print print;
    (void)state;
    make_profiles();
    lens.calibrations[0] = measured("ink", 60.13, 400);
    lens.calibrations[0].phase_mm = 0.05;
    lens.optics.slant = 9;
    lens.n_calibrations = 1;
    for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
        lf_assert_ok(apply(of[i].option, of[i].text, &print, &err), &err);
        const double got = *(double *)(void *)((char *)&print + of[i].place);
        if (got != of[i].value)
            fail_msg("--%s %s: got %g", of[i].option, of[i].text, got);
    }
    lens.horizontal = lens.has_horizontal = true;
    lf_assert_ok(apply(NULL, NULL, &print, &err), &err);
    assert_true(print.horizontal);
    lf_assert_ok(apply("orientation", "vertical", &print, &err), &err);
    assert_false(print.horizontal);
    lens.calibrations[0].reverse = true;
    lf_assert_ok(apply("reverse", NULL, &print, &err), &err);
    assert_true(print.reverse);
    snprintf(printer.icc, sizeof printer.icc, "/a.icc");
    lf_assert_ok(apply("icc", "/b.icc", &print, &err), &err);
    assert_string_equal(print.icc_path, "/b.icc");
    lf_assert_ok(apply(NULL, NULL, &print, &err), &err);
    assert_string_equal(print.icc_path, "/a.icc");
}

static void the_thickness_that_was_given_counts_for_the_pitch(void **state)
{
    lf_error err = {0};
    lf_print print = plain_print();
    (void)state;
    make_profiles();
    lf_print_given given = given_of("distance", &print, "400");
    lf_assert_ok(lf_param_from_text(lf_param_find(lf_print_params, "thickness"), "2", &print, &err),
                 &err);
    lf_print_give(&given, lf_param_find(lf_print_params, "thickness"));
    lf_assert_ok(lf_profile_apply(&lens, &printer, &given, &print, &told, &err), &err);
    lf_assert_close(print.lpi, 60.2 / (1 + 2 / (1.56 * 400)), 1e-14, 0);
    assert_non_null(strstr(told.warnings.text, "the pitch is not measured"));
}

static void what_is_unknown_is_told(void **state)
{
    lf_error err = {0};
    lf_print print;
    (void)state;
    make_profiles();
    lf_assert_status(apply(NULL, NULL, &print, &err), LF_E_ARG, NULL);
    assert_string_equal(err.where, "--distance");
    /* from the angle */
    lens.optics.thickness_mm = 0;
    lf_assert_ok(apply("distance", "400", &print, &err), &err);
    lf_assert_close(print.optics.thickness_mm, lf_profile_thickness(60.2, 54, 1.56), 1e-14, 0);
    assert_non_null(strstr(told.warnings.text, "follow from the viewing angle"));
    lens.optics.index = 0;
    lf_assert_ok(apply("distance", "400", &print, &err), &err);
    assert_non_null(strstr(told.lines.text, "index unknown, taken as 1.56"));
    /* neither */
    lens.optics.angle = 0;
    lf_assert_ok(apply("distance", "400", &print, &err), &err);
    assert_true(print.lpi == 60.2);
    assert_non_null(strstr(told.warnings.text, "seen from far away"));
    /* measured at another distance only, of unknown thickness */
    lens.calibrations[0] = measured("ink", 60.13, 600);
    lens.n_calibrations = 1;
    lf_assert_status(apply("distance", "400", &print, &err), LF_E_ARG, NULL);
    assert_non_null(strstr(err.what, "its thickness is unknown"));
    lf_assert_ok(apply("distance", "600.01", &print, &err), &err);
    assert_true(print.lpi == 60.13);
}

static void of_several_calibrations_the_distance_chooses(void **state)
{
    lf_error err = {0};
    lf_print print;
    (void)state;
    make_profiles();
    lens.calibrations[0] = measured("ink", 60.13, 400);
    lens.calibrations[1] = measured("ink", 60.17, 1000);
    lens.n_calibrations = 2;
    lf_assert_status(apply(NULL, NULL, &print, &err), LF_E_ARG, NULL);
    assert_string_equal(err.where, "--distance");
    lf_assert_ok(apply("distance", "1000", &print, &err), &err);
    assert_true(print.lpi == 60.17);
    lf_assert_ok(apply("distance", "400", &print, &err), &err);
    assert_true(print.lpi == 60.13);
    lf_assert_ok(apply("distance", "900", &print, &err), &err);
    lf_assert_close(print.lpi, lf_profile_pitch(60.17, 1000, 900, 0.6, 1.56), 1e-14, 0);
}

static void one_profile_needs_the_rest_from_options(void **state)
{
    lf_error err = {0};
    const lf_print_given none = {0};
    lf_print print = plain_print();
    (void)state;
    make_profiles();
    lf_assert_status(lf_profile_apply(&lens, NULL, &none, &print, &told, &err), LF_E_ARG, NULL);
    assert_string_equal(err.where, "--lens");
    lf_assert_status(lf_profile_apply(NULL, &printer, &none, &print, &told, &err), LF_E_ARG, NULL);
    assert_string_equal(err.where, "--printer");
    const lf_print_given pitch = given_of("print", &print, "60.1@600");
    lf_assert_ok(lf_profile_apply(&lens, NULL, &pitch, &print, &told, &err), &err);
    assert_true(print.lpi == 60.1 && print.dpi == 600 && print.optics.thickness_mm == 0.6);
    lf_assert_ok(lf_profile_apply(NULL, &printer, &pitch, &print, &told, &err), &err);
    assert_true(print.lpi == 60.1 && print.dpi == 600 && print.blur.dot_gain == 0.1);
}

static void a_raster_that_the_driver_resamples_is_told(void **state)
{
    lf_error err = {0};
    lf_print print;
    (void)state;
    make_profiles();
    printer.native_dpi[0] = 360;
    printer.native_dpi[1] = 720;
    printer.n_native = 2;
    lf_assert_ok(apply("print", "60@720", &print, &err), &err);
    assert_int_equal(told.warnings.length, 0);
    lf_assert_ok(apply("print", "60@600", &print, &err), &err);
    assert_non_null(strstr(told.warnings.text, "600 dpi is not a native resolution of ink"));
    lf_assert_ok(apply("print", "60@720x1440", &print, &err), &err);
    assert_non_null(strstr(told.warnings.text, "1440 dpi is not a native resolution"));
}

/* Opening by names: the account for the manifest, and whose ICC files are held to the roots. */
static void profiles_are_accounted_for(void **state)
{
    lf_error err = {0};
    lf_roots roots = {0};
    lf_print print = plain_print();
    lf_profiles *profiles = lf_calloc(1, sizeof *profiles);
    assert_non_null(profiles);
    lf_assert_ok(lf_roots_add(&roots, *state, &err), &err);
    put_lens(*state, "own/quiltd/lenses/acme.json", 60.2);
    (void)lf_test_write(*state, "own/quiltd/printers/ink.json",
                        "{\"quiltd_printer\": 1, \"dpi\": 720, \"icc\": \"ink.icc\", "
                        "\"native_dpi\": [360, 720]}");
    const lf_print_given given = given_of("distance", &print, "400");
    print.icc_roots = &roots;
    lf_profile_names names = {0};
    lf_assert_ok(lf_profiles_open(&names, &roots, &given, &print, profiles, &err), &err);
    assert_null(profiles->account);
    assert_null(print.profiles);
    names = (lf_profile_names){.lens = "acme", .printer = "ink"};
    lf_assert_ok(lf_profiles_open(&names, &roots, &given, &print, profiles, &err), &err);
    assert_ptr_equal(print.profiles, profiles->account);
    const json_t *of_lens = json_object_get(profiles->account, "lens"),
                 *of_printer = json_object_get(profiles->account, "printer");
    assert_string_equal(json_string_value(json_object_get(of_lens, "profile")), "acme");
    assert_string_equal(json_string_value(json_object_get(of_lens, "sha256")),
                        profiles->lens.file.sha256);
    assert_true(json_number_value(json_object_get(of_lens, "pitch_lpi")) == 60.2);
    assert_true(json_number_value(json_object_get(of_printer, "dpi")) == 720);
    const json_t *native = json_object_get(of_printer, "native_dpi");
    assert_int_equal(json_array_size(native), 2);
    assert_true(json_number_value(json_array_get(native, 1)) == 720);
    assert_int_equal(json_array_size(json_object_get(profiles->account, "used")), 2);
    assert_int_equal(json_array_size(json_object_get(profiles->account, "warnings")), 2);
    assert_null(print.icc_roots); /* found by name: the folders are the program's own */
    lf_profiles_finish(profiles);
    print.icc_roots = &roots;
    names.printer = lf_test_path(*state, "own/quiltd/printers/ink.json");
    lf_assert_ok(lf_profiles_open(&names, &roots, &given, &print, profiles, &err), &err);
    assert_ptr_equal(print.icc_roots, &roots);
    lf_profiles_finish(profiles);
    lf_roots_finish(&roots);
    lf_free(profiles);
}

/* ----------------------------------------------------------------------------------- shipped -- */

static bool has_source(const json_t *profile, const char *key)
{
    return !json_object_get(profile, key) ||
           json_string_length(json_object_get(json_object_get(profile, "sources"), key)) > 10;
}

/* Every number of a shipped profile says where it is from. */
static void check_sources(const char *path)
{
    static const char *const numbers[] = {"pitch_lpi", "thickness_mm",  "index", "radius_mm",
                                          "spot_mm",   "viewing_angle", "dpi",   "native_dpi",
                                          "dot_gain",  "ink_mm"};
    lf_error err = {0};
    json_t *profile = NULL;
    lf_assert_ok(lf_profile_json(path, NULL, &profile, &err), &err);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        if (!has_source(profile, numbers[i]))
            fail_msg("%s: %s has no source", path, numbers[i]);
    assert_true(json_string_length(json_object_get(profile, "source")) > 10);
    json_decref(profile);
}

static void shipped_profiles_are_whole_and_consistent(void **state)
{
    lf_error err = {0};
    lf_profile_entry *entries = NULL;
    int n = 0, n_lenses = 0, n_both = 0;
    (void)state;
    unsetenv("XDG_CONFIG_HOME");
    setenv("QUILTD_PROFILES", lf_test_source("quilt/profiles"), 1);
    setenv("HOME", "/nonexistent", 1);
    lf_assert_ok(lf_profile_list(LF_PROFILE_PRINTER, &entries, &n, &err), &err);
    assert_true(n >= 5);
    for (int i = 0; i < n; i++) {
        lf_assert_ok(lf_profile_printer_read(entries[i].path, NULL, &printer, &err), &err);
        check_sources(entries[i].path);
    }
    lf_free(entries);
    lf_assert_ok(lf_profile_printer_read("epson-720", NULL, &printer, &err), &err);
    lf_assert_ok(lf_profile_list(LF_PROFILE_LENS, &entries, &n_lenses, &err), &err);
    assert_true(n_lenses >= 12);
    for (int i = 0; i < n_lenses; i++) {
        lf_assert_ok(lf_profile_lens_read(entries[i].name, NULL, &lens, &err), &err);
        check_sources(entries[i].path);
        const lf_optics *o = &lens.optics;
        const bool both = o->thickness_mm > 0 && o->angle > 0 && o->index > 0;
        n_both += both;
        /* the vertex model, within 2 degrees of what is said */
        if (both)
            lf_assert_close(lf_profile_angle(lens.pitch_lpi, o->thickness_mm, o->index), o->angle,
                            0, 2);
        lf_print print;
        lf_assert_ok(apply("distance", "400", &print, &err), &err);
        print.width_mm = print.height_mm = 50;
        lf_assert_ok(lf_print_choose_views(&print, 1000, "views", NULL, &err), &err);
        lf_assert_ok(lf_print_check(&print, NULL, &err), &err);
    }
    lf_free(entries);
    assert_true(n_both > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_pitch_at_a_distance_is_that_of_the_closed_form),
        cmocka_unit_test(thickness_and_angle_belong_together),
        cmocka_unit_test(a_calibration_gives_the_pitch),
        cmocka_unit_test(the_sheet_is_that_of_the_profile_alone),
        cmocka_unit_test(a_phase_needs_a_registered_printer),
        cmocka_unit_test(a_phase_is_of_lenses_that_run_as_the_charts),
        cmocka_unit_test(an_option_wins_over_profiles),
        cmocka_unit_test(the_thickness_that_was_given_counts_for_the_pitch),
        cmocka_unit_test(what_is_unknown_is_told),
        cmocka_unit_test(of_several_calibrations_the_distance_chooses),
        cmocka_unit_test(one_profile_needs_the_rest_from_options),
        cmocka_unit_test(a_raster_that_the_driver_resamples_is_told),
        in_folders(profiles_are_accounted_for),
        in_folders(shipped_profiles_are_whole_and_consistent),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
