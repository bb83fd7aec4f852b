/* Profiles of lens sheets and printers: what files may hold, and where they are looked for. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "tests/quilt/profile_folders.h"

#define LENS "\"quiltd_lens\": 1, \"pitch_lpi\": 60.2"
#define CALIBRATION "\"printer\": \"ink\", \"visual_lpi\": 60.13, \"distance_mm\": 400"

static lf_lens_profile lens; /* large */
static lf_printer_profile printer;

/* ----------------------------------------------------------------------------------- reading -- */

static lf_status read_lens(const char *folder, const char *text, lf_error *err)
{
    return lf_profile_lens_read(lf_test_write(folder, "lens.json", text), NULL, &lens, err);
}

/* Refused in one line, with the file, this pointer and these words. */
static void refused(const char *folder, const char *text, const char *pointer, const char *words)
{
    lf_error err = {0};
    const lf_status status = read_lens(folder, text, &err);
    if (status != LF_E_FORMAT || strcmp(err.pointer, pointer) != 0 || !strstr(err.what, words) ||
        !strstr(err.where, "lens.json") || strchr(err.what, '\n'))
        fail_msg("%s: %s, %s: \"%s\" %s", text, lf_status_name(status), err.where, err.pointer,
                 err.what);
}

static void a_whole_lens_is_read(void **state)
{
    lf_error err = {0};
    lf_assert_ok(
        read_lens(*state,
                  "{ \"quiltd_lens\": 1, \"name\": \"Acme 60\", \"maker\": \"Acme\", \"source\": "
                  "\"a page\", \"pitch_lpi\": 60.2, \"thickness_mm\": 0.6, \"index\": 1.56, "
                  "\"radius_mm\": 0.23, \"viewing_angle\": 54, \"orientation\": \"horizontal\", "
                  "\"slant\": -9.5, \"lens_grid\": \"hexagonal\", \"spot_mm\": 0.03, \"sources\": "
                  "{\"index\": \"a page\"}, \"calibrations\": [{" CALIBRATION
                  ", \"phase_mm\": 0.01, \"skew_deg\": 0.1, \"error_lpi\": 0.001, \"order\": "
                  "\"reversed\", \"date\": \"2026-11-29\", \"chart_sha256\": "
                  "\"0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef\", "
                  "\"crosstalk\": [0.1, 0.8, 0.1]}] }",
                  &err),
        &err);
    assert_string_equal(lens.file.name, "lens");
    assert_string_equal(lens.title, "Acme 60");
    assert_string_equal(lens.maker, "Acme");
    assert_string_equal(lens.source, "a page");
    assert_true(lens.pitch_lpi == 60.2 && lens.optics.thickness_mm == 0.6);
    assert_true(lens.optics.index == 1.56 && lens.optics.radius_mm == 0.23);
    assert_true(lens.optics.angle == 54 && lens.optics.slant == -9.5 && lens.spot_mm == 0.03);
    assert_true(lens.horizontal && lens.has_horizontal);
    assert_int_equal(lens.optics.grid, LF_LENS_HEXAGONAL);
    assert_int_equal(lens.n_calibrations, 1);
    const lf_lens_calibration *c = &lens.calibrations[0];
    assert_string_equal(c->printer, "ink");
    assert_true(c->visual_lpi == 60.13 && c->distance_mm == 400 && c->phase_mm == 0.01);
    assert_true(c->skew_deg == 0.1 && c->error_lpi == 0.001 && c->reverse);
    assert_string_equal(c->date, "2026-11-29");
    assert_int_equal(strlen(c->chart_sha256), 64);
    assert_int_equal(c->n_crosstalk, 1);
    assert_int_equal(c->crosstalk_views, 8); /* as in charts */
    assert_true(c->crosstalk[0] == 0.1 && c->crosstalk[1] == 0.8 && c->crosstalk[2] == 0.1);
    assert_int_equal(strlen(lens.file.sha256), 64);
}

static void what_a_lens_does_not_say_is_unknown(void **state)
{
    lf_error err = {0};
    lf_assert_ok(read_lens(*state, "{" LENS "}", &err), &err);
    assert_true(lens.optics.thickness_mm == 0 && lens.optics.index == 0 && lens.spot_mm == 0);
    assert_true(!lens.has_horizontal && lens.n_calibrations == 0);
    assert_string_equal(lens.title, "");
}

static void the_hash_is_that_of_the_file(void **state)
{
    lf_error err = {0};
    /* printf '{"quiltd_lens": 1, "pitch_lpi": 60}' | sha256sum */
    lf_assert_ok(read_lens(*state, "{\"quiltd_lens\": 1, \"pitch_lpi\": 60}", &err), &err);
    assert_string_equal(lens.file.sha256,
                        "4c95ad4594f379be5c4b9f98e0eb4c319ae884de0cc568240d80ebf71532608f");
}

static void bad_lenses_are_refused(void **state)
{
    const char *f = *state;
    refused(f, "", "", "");
    refused(f, "[]", "", "object");
    refused(f, "{" LENS, "", "");
    refused(f, "{\"pitch_lpi\": 60}", "/quiltd_lens", "expected 1");
    refused(f, "{\"quiltd_lens\": 2, \"pitch_lpi\": 60}", "/quiltd_lens", "expected 1");
    refused(f, "{\"quiltd_lens\": 1.0, \"pitch_lpi\": 60}", "/quiltd_lens", "expected 1");
    refused(f, "{\"quiltd_lens\": 1}", "/pitch_lpi", "missing");
    refused(f, "{\"quiltd_printer\": 1, \"dpi\": 600}", "", "is the profile of a printer");
    refused(f, "{" LENS ", \"thicknes_mm\": 1}", "/thicknes_mm", "did you mean \"thickness_mm\"?");
    refused(f, "{" LENS ", \"zzz\": 1}", "/zzz", "unknown key");
    refused(f, "{" LENS ", \"thickness_mm\": NaN}", "", "");
    refused(f, "{" LENS ", \"thickness_mm\": 1e999}", "", "");
    refused(f, "{" LENS ", \"thickness_mm\": 1e30}", "/thickness_mm", "from 0.01");
    refused(f, "{" LENS ", \"thickness_mm\": 0}", "/thickness_mm", "from 0.01");
    refused(f, "{" LENS ", \"thickness_mm\": \"0.6\"}", "/thickness_mm", "number");
    refused(f, "{" LENS ", \"thickness_mm\": null}", "/thickness_mm", "number");
    refused(f, "{" LENS ", \"thickness_mm\": {}}", "/thickness_mm", "number");
    refused(f, "{" LENS ", \"index\": 0.9}", "/index", "from 1.1");
    refused(f, "{" LENS ", \"name\": 5}", "/name", "string");
    refused(f, "{" LENS ", \"name\": \"a\\nb\"}", "/name", "control");
    refused(f, "{" LENS ", \"orientation\": \"up\"}", "/orientation", "vertical");
    refused(f, "{" LENS ", \"lens_grid\": \"round\"}", "/lens_grid", "hexagonal");
    refused(f, "{" LENS ", \"index\": 1.5, \"index\": 1.6}", "", "duplicate");
    refused(f, "{" LENS ", \"sources\": []}", "/sources", "object");
    refused(f, "{" LENS ", \"sources\": {\"index\": \"x\"}}", "/sources/index", "no such key");
    refused(f, "{" LENS ", \"sources\": {\"pitch_lpi\": 1}}", "/sources/pitch_lpi", "string");
}

static void bad_calibrations_are_refused(void **state)
{
    const char *f = *state;
#define IN(what) "{" LENS ", \"calibrations\": [{" CALIBRATION what "}]}"
    refused(f, "{" LENS ", \"calibrations\": {}}", "/calibrations", "array");
    refused(f, "{" LENS ", \"calibrations\": [5]}", "/calibrations/0", "object");
    refused(f, "{" LENS ", \"calibrations\": [{" CALIBRATION "}, {}]}", "/calibrations/1/printer",
            "missing");
    refused(f, IN(", \"phase_m\": 1"), "/calibrations/0/phase_m", "did you mean \"phase_mm\"?");
    refused(f, IN(", \"phase_mm\": 1e4"), "/calibrations/0/phase_mm", "from -100");
    refused(f, IN(", \"date\": \"yesterday\""), "/calibrations/0/date", "2026-11-29");
    refused(f, IN(", \"date\": \"2026-11-29T\""), "/calibrations/0/date", "2026-11-29");
    refused(f, IN(", \"chart_sha256\": \"abc\""), "/calibrations/0/chart_sha256", "64");
    refused(f, IN(", \"crosstalk\": [0.5, 0.5]"), "/calibrations/0/crosstalk", "odd");
    refused(f, IN(", \"crosstalk_views\": 1"), "/calibrations/0/crosstalk_views", "from 2");
    refused(f, IN(", \"crosstalk\": []"), "/calibrations/0/crosstalk", "odd");
    refused(f, IN(", \"crosstalk\": [0.2, 0.5, 0.2]"), "/calibrations/0/crosstalk", "sum");
    refused(f, IN(", \"crosstalk\": [\"1\"]"), "/calibrations/0/crosstalk", "numbers");
    refused(f, IN(", \"crosstalk\": [-0.1, 1, 0.1]"), "/calibrations/0/crosstalk", "from 0 to 1");
    refused(f, IN(", \"crosstalk\": [0,0,0,0,0,0,0,0,0,1,0,0,0,0,0,0,0,0,0]"),
            "/calibrations/0/crosstalk", "at most 17");
    refused(f,
            "{" LENS ", \"calibrations\": [{\"printer\": \"../a\", \"visual_lpi\": 60, "
            "\"distance_mm\": 400}]}",
            "/calibrations/0/printer", "name");
#undef IN
}

static void files_that_are_too_long_or_deep_are_refused(void **state)
{
    lf_error err = {0};
    const size_t n = LF_PROFILE_BYTES + 1;
    char *text = lf_calloc(n + 1, 1);
    assert_non_null(text);
    memset(text, ' ', n);
    memcpy(text, "{" LENS "}", strlen("{" LENS "}"));
    assert_int_not_equal(read_lens(*state, text, &err), LF_OK);
    text[n - 1] = '\0';
    lf_assert_ok(read_lens(*state, text, &err), &err);
    memset(text, '[', n - 1);
    refused(*state, text, "", "");
    lf_free(text);
    /* one calibration more than there is room for */
    char *many = lf_calloc(65 * 80 + 200, 1);
    assert_non_null(many);
    strcat(many, "{" LENS ", \"calibrations\": [");
    for (int i = 0; i < 65; i++)
        strcat(strcat(many, i > 0 ? "," : ""), "{" CALIBRATION "}");
    strcat(many, "]}");
    refused(*state, many, "/calibrations", "at most 64");
    lf_free(many);
    /* texts that do not fit their fields */
    char name[400];
    snprintf(name, sizeof name, "{" LENS ", \"name\": \"%0300d\"}", 1);
    refused(*state, name, "/name", "at most 255");
}

static void a_printer_is_read(void **state)
{
    lf_error err = {0};
    const char *path = lf_test_write(
        *state, "ink.json",
        "{\"quiltd_printer\": 1, \"name\": \"Ink\", \"dpi\": \"720x1440\", \"native_dpi\": [360, "
        "720, 1440], \"dot_gain\": 0.15, \"ink_mm\": 0.02, \"icc\": \"a/ink.icc\"}");
    lf_assert_ok(lf_profile_printer_read(path, NULL, &printer, &err), &err);
    assert_true(printer.dpi == 720 && printer.dpi_down == 1440);
    assert_int_equal(printer.n_native, 3);
    assert_true(printer.native_dpi[2] == 1440);
    assert_true(printer.dot_gain == 0.15 && printer.ink_mm == 0.02);
    assert_string_equal(printer.icc, lf_test_path(*state, "a/ink.icc"));
    path = lf_test_write(*state, "ink.json",
                         "{\"quiltd_printer\": 1, \"dpi\": 720, \"icc\": "
                         "\"/etc/ink.icc\"}");
    lf_assert_ok(lf_profile_printer_read(path, NULL, &printer, &err), &err);
    assert_string_equal(printer.icc, "/etc/ink.icc");
    path = lf_test_write(*state, "ink.json",
                         "{\"quiltd_printer\": 1, \"dpi\": 720, "
                         "\"native_dpi\": [\"x\"]}");
    lf_assert_status(lf_profile_printer_read(path, NULL, &printer, &err), LF_E_FORMAT, NULL);
    assert_string_equal(err.pointer, "/native_dpi");
    path = lf_test_write(*state, "ink.json", "{" LENS "}");
    lf_assert_status(lf_profile_printer_read(path, NULL, &printer, &err), LF_E_FORMAT, NULL);
    assert_non_null(strstr(err.what, "is the profile of a lens"));
}

/* ------------------------------------------------------------------------------------- names -- */

static void the_first_folder_wins(void **state)
{
    lf_error err = {0};
    const char *f = *state;
    put_lens(f, "shipped/lenses/a.json", 10);
    put_lens(f, "shipped/lenses/b.json", 20);
    lf_assert_ok(lf_profile_lens_read("a", NULL, &lens, &err), &err);
    assert_true(lens.pitch_lpi == 10);
    put_lens(f, "own/quiltd/lenses/a.json", 30);
    lf_assert_ok(lf_profile_lens_read("a", NULL, &lens, &err), &err);
    assert_true(lens.pitch_lpi == 30);
    assert_string_equal(lens.file.path, lf_test_path(f, "own/quiltd/lenses/a.json"));
    lf_profile_entry *entries = NULL;
    int n = 0;
    lf_assert_ok(lf_profile_list(LF_PROFILE_LENS, &entries, &n, &err), &err);
    int of_ours = 0;
    for (int i = 0; i < n; i++) {
        if (strcmp(entries[i].name, "a") == 0)
            assert_true(entries[i].is_own);
        if (strcmp(entries[i].name, "b") == 0)
            assert_false(entries[i].is_own);
        of_ours += strcmp(entries[i].name, "a") == 0 || strcmp(entries[i].name, "b") == 0;
        assert_true(i == 0 || strcmp(entries[i - 1].name, entries[i].name) < 0);
    }
    assert_int_equal(of_ours, 2);
    lf_free(entries);
}

static void home_is_where_no_folder_of_settings_is_told(void **state)
{
    lf_error err = {0};
    char folder[PATH_MAX], *home = getenv("HOME") ? lf_strdup(getenv("HOME")) : NULL;
    (void)state;
    assert_int_equal(setenv("XDG_CONFIG_HOME", "relative", 1), 0); /* invalid, as if not there */
    assert_int_equal(setenv("HOME", "/home/a", 1), 0);
    lf_assert_ok(lf_profile_own_folder(LF_PROFILE_PRINTER, folder, &err), &err);
    assert_string_equal(folder, "/home/a/.config/quiltd/printers");
    assert_int_equal(setenv("XDG_CONFIG_HOME", "/x", 1), 0);
    lf_assert_ok(lf_profile_own_folder(LF_PROFILE_LENS, folder, &err), &err);
    assert_string_equal(folder, "/x/quiltd/lenses");
    unsetenv("HOME");
    unsetenv("XDG_CONFIG_HOME");
    lf_assert_status(lf_profile_own_folder(LF_PROFILE_LENS, folder, &err), LF_E_STATE, NULL);
    if (home)
        setenv("HOME", home, 1);
    lf_free(home);
}

static void unknown_names_are_refused_with_the_nearest(void **state)
{
    lf_error err = {0};
    put_lens(*state, "shipped/lenses/acme-60.json", 60);
    lf_assert_status(lf_profile_lens_read("acme-6", NULL, &lens, &err), LF_E_ARG, NULL);
    assert_string_equal(err.where, "acme-6");
    assert_non_null(strstr(err.what, "did you mean acme-60?"));
    static const char *const bad[] = {"", ".", "..", ".a", "-a", "a b", "a\n", "~root"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_false(lf_profile_is_name(bad[i]));
        lf_assert_status(lf_profile_lens_read(bad[i], NULL, &lens, &err), LF_E_ARG, NULL);
    }
    lf_assert_status(lf_profile_lens_read("no/such.json", NULL, &lens, &err), LF_E_IO, NULL);
}

static void paths_are_held_to_the_folders_that_may_be_read(void **state)
{
    lf_error err = {0};
    lf_roots roots = {0};
    put_lens(*state, "own/a.json", 30);
    put_lens(*state, "shipped/lenses/b.json", 20);
    lf_assert_ok(lf_roots_add(&roots, lf_test_path(*state, "own"), &err), &err);
    lf_assert_ok(lf_profile_lens_read(lf_test_path(*state, "own/a.json"), &roots, &lens, &err),
                 &err);
    lf_assert_status(
        lf_profile_lens_read(lf_test_path(*state, "shipped/lenses/b.json"), &roots, &lens, &err),
        LF_E_PATH, NULL);
    lf_assert_ok(lf_profile_lens_read("b", &roots, &lens, &err), &err); /* a name */
    lf_roots_finish(&roots);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        in_folders(a_whole_lens_is_read),
        in_folders(what_a_lens_does_not_say_is_unknown),
        in_folders(the_hash_is_that_of_the_file),
        in_folders(bad_lenses_are_refused),
        in_folders(bad_calibrations_are_refused),
        in_folders(files_that_are_too_long_or_deep_are_refused),
        in_folders(a_printer_is_read),
        in_folders(the_first_folder_wins),
        in_folders(home_is_where_no_folder_of_settings_is_told),
        in_folders(unknown_names_are_refused_with_the_nearest),
        in_folders(paths_are_held_to_the_folders_that_may_be_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
