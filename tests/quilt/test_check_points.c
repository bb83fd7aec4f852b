/* What single points of the checklist say: nothing that the options alone say, the printer's own
 * resolutions, bleed and marks that cannot be measured, and what the operator reads. */
#include "tests/testing.h"

#include "base/file.h"
#include "tests/quilt/checked.h"

enum { RASTER = 3, ORDER = 9, SHARE, VIEWS = 12, EDGES = 14, SAME = 17 };

static lf_print small_print(void)
{
    return (lf_print){
        .lpi = 60.13, .dpi = 600, .width_mm = 30, .height_mm = 3, .n_views = 7, .bits = 8};
}

static const char *said(const lf_checked *checked, int number)
{
    return checked->report.points[number - 1].measured;
}

static void the_options_alone_prove_nothing(void **state)
{
    (void)state;
    static const int by_writer[] = {ORDER, SHARE, SAME};
    const lf_print print = small_print();
    lf_checked waves, grey;
    lf_checked_make(&print, lf_card_waves, false, &waves);
    lf_checked_make(&print, lf_card_grey, false, &grey);
    lf_checked_run(&waves, true);
    for (int i = 0; i < 3; i++)
        assert_int_equal(lf_checked_point(&waves, by_writer[i]), LF_CHECK_PASS);
    lf_checked_run(&waves, false);
    lf_checked_run(&grey, false);
    for (int i = 0; i < 3; i++)
        assert_int_equal(lf_checked_point(&waves, by_writer[i]), LF_CHECK_NONE);
    assert_non_null(strstr(said(&waves, ORDER), "was not compared with what was written"));
    assert_non_null(strstr(said(&waves, SHARE), "by the options alone"));
    assert_non_null(strstr(said(&waves, SAME), "was not compared with what was written"));
    assert_int_equal(lf_checked_point(&waves, VIEWS), LF_CHECK_PASS); /* its stripes are measured */
    assert_int_equal(lf_checked_point(&grey, VIEWS), LF_CHECK_NONE);
    lf_checked_run(&grey, true);
    assert_int_equal(lf_checked_point(&grey, VIEWS), LF_CHECK_PASS);
    lf_checked_finish(&waves);
    lf_checked_finish(&grey);
}

/* Too many views are told without a look at the file. */
static void too_many_views_are_always_told(void **state)
{
    (void)state;
    lf_print print = small_print();
    lf_checked checked;
    print.n_views = 9;
    lf_checked_make(&print, lf_card_grey, false, &checked);
    lf_checked_run(&checked, false);
    assert_int_equal(lf_checked_point(&checked, VIEWS), LF_CHECK_WARN);
    lf_checked_finish(&checked);
}

static void the_printer_knows_its_resolutions(void **state)
{
    (void)state;
    static const struct {
        double dpi, native[2];
        lf_check_result result;
    } rows[] = {{720, {300, 600}, LF_CHECK_WARN},
                {600, {300, 600}, LF_CHECK_PASS},
                {635, {300, 635}, LF_CHECK_PASS},
                {720, {0, 0}, LF_CHECK_PASS},
                {635, {0, 0}, LF_CHECK_WARN}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        lf_print print = small_print();
        lf_checked checked;
        print.dpi = rows[i].dpi;
        json_t *profiles = rows[i].native[0] > 0
                               ? json_pack("{s:{s:s, s:[f,f]}}", "printer", "profile", "studio",
                                           "native_dpi", rows[i].native[0], rows[i].native[1])
                               : NULL;
        print.profiles = profiles;
        lf_checked_make(&print, lf_card_waves, false, &checked);
        lf_checked_run(&checked, false);
        assert_int_equal(lf_checked_point(&checked, RASTER), rows[i].result);
        if (profiles)
            assert_non_null(strstr(checked.report.points[RASTER - 1].limit, "printer's profile"));
        lf_checked_finish(&checked);
        json_decref(profiles);
    }
}

static void bleed_and_marks_that_are_there_are_named(void **state)
{
    (void)state;
    lf_print print = small_print();
    lf_checked checked;
    lf_checked_make(&print, lf_card_waves, false, &checked);
    lf_checked_run(&checked, true);
    assert_string_equal(said(&checked, EDGES), "no bleed and no marks");
    lf_checked_finish(&checked);

    print.marks = true;
    print.optics.slant = 9;
    lf_checked_make(&print, lf_card_waves, false, &checked);
    lf_checked_run(&checked, true);
    assert_non_null(strstr(said(&checked, EDGES), "marks: not measured for slanted lenses"));
    lf_checked_finish(&checked);

    print.optics.slant = 0;
    print.bleed_mm = 2;
    print.sheet.columns = print.sheet.rows = 2;
    lf_checked_make(&print, lf_card_waves, false, &checked);
    lf_checked_run(&checked, true);
    assert_non_null(strstr(said(&checked, EDGES), "bleed 2 mm, marks: not measured on a page"));
    /* the file has what the writer wrote, of which the order is known */
    assert_int_equal(lf_checked_point(&checked, ORDER), LF_CHECK_PASS);
    assert_int_equal(lf_checked_point(&checked, SAME), LF_CHECK_PASS);
    lf_checked_finish(&checked);
}

static void a_chart_that_was_just_written_is_what_was_written(void **state)
{
    (void)state;
    const lf_print print = lf_checked_chart();
    lf_checked checked;
    lf_checked_make(&print, NULL, true, &checked);
    lf_checked_run(&checked, true);
    assert_int_equal(lf_checked_point(&checked, SAME), LF_CHECK_PASS);
    assert_non_null(strstr(said(&checked, SAME), "are those that were written"));
    lf_checked_run(&checked, false);
    assert_int_equal(lf_checked_point(&checked, SAME), LF_CHECK_NONE);
    lf_checked_finish(&checked);
}

static void the_job_sheet_names_profiles_and_copies(void **state)
{
    (void)state;
    static const char *const needed[] = {"lens sheet acme-60, printer studio",
                                         "30 x 3 mm; 2 x 3 copies; label \"Job 12\""};
    lf_print print = small_print();
    lf_checked checked;
    lf_outfile file;
    lf_error err;
    json_t *profiles = json_pack("{s:{s:s}, s:{s:s}}", "lens", "profile", "acme-60", "printer",
                                 "profile", "studio");
    print.profiles = profiles;
    print.sheet.columns = 2;
    print.sheet.rows = 3;
    print.sheet.label = "Job 12";
    lf_checked_make(&print, lf_card_waves, false, &checked);
    lf_checked_run(&checked, true);
    const char *path = lf_test_path(checked.folder, "sheet.job.pdf");
    lf_assert_ok(lf_outfile_open(&file, path, false, &err), &err);
    lf_assert_ok(lf_print_report_sheet(&checked.report, &file, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, false, &err), &err);
    char command[PATH_MAX + 64], text[1 << 14] = "";
    snprintf(command, sizeof command, "pdftotext -layout '%s' - 2>/dev/null", path);
    FILE *from = popen(command, "r"); /* NOLINT(cert-env33-c) */
    const size_t n = from ? fread(text, 1, sizeof text - 1, from) : 0;
    if (from)
        (void)pclose(from);
    if (n == 0)
        print_message("pdftotext is not installed: the job sheet's words are not tested\n");
    for (size_t i = 0; i < sizeof needed / sizeof needed[0] && n > 0; i++)
        if (!strstr(text, needed[i]))
            fail_msg("the job sheet lacks \"%s\": %s", needed[i], text);
    lf_checked_finish(&checked);
    json_decref(profiles);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_options_alone_prove_nothing),
        cmocka_unit_test(too_many_views_are_always_told),
        cmocka_unit_test(the_printer_knows_its_resolutions),
        cmocka_unit_test(bleed_and_marks_that_are_there_are_named),
        cmocka_unit_test(a_chart_that_was_just_written_is_what_was_written),
        cmocka_unit_test(the_job_sheet_names_profiles_and_copies),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
