/* The checklist's report, its job sheet, mistakes of callers, and files from strangers. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "base/file.h"
#include "tests/quilt/checked.h"
#include "tests/quilt/pdf_read.h"
#include "tests/quilt/printed.h"

static lf_print small_print(void)
{
    return (lf_print){.lpi = 60.13,
                      .dpi = 600,
                      .width_mm = 30,
                      .height_mm = 3,
                      .n_views = 7,
                      .bits = 8,
                      .marks = true,
                      .bleed_mm = 1};
}

static lf_checked checked_of(const lf_print *print)
{
    lf_checked checked;
    lf_checked_make(print, lf_card_waves, false, &checked);
    return checked;
}

/* ------------------------------------------------------------------------------------ report -- */

static void the_report_counts_and_names_its_points(void **state)
{
    (void)state;
    const lf_print print = small_print();
    lf_checked checked = checked_of(&print);
    char line[2048];
    lf_checked_run(&checked, true);
    assert_string_equal(lf_print_report_line(&checked.report, line, sizeof line),
                        "16 of 18 points hold, 2 do not apply");
    assert_int_equal(lf_checked_point(&checked, 13), LF_CHECK_NONE); /* depth is not known */
    assert_int_equal(lf_checked_point(&checked, 15), LF_CHECK_NONE); /* no PDF */
    assert_int_equal(truncate(checked.tiff, 5000), 0);
    lf_checked_run(&checked, false);
    assert_non_null(
        strstr(lf_print_report_line(&checked.report, line, sizeof line), "whole file fails ("));
    assert_non_null(strstr(line, "manifest fails ("));
    lf_checked_finish(&checked);
}

static void the_text_and_the_json_say_the_same(void **state)
{
    (void)state;
    const lf_print print = small_print();
    lf_checked checked = checked_of(&print);
    lf_checked_run(&checked, true);
    char *text = lf_print_report_text(&checked.report);
    json_t *root = lf_print_report_json(&checked.report);
    assert_non_null(text);
    assert_int_equal(json_integer_value(json_object_get(root, "quiltd_check")), 1);
    assert_int_equal(json_integer_value(json_object_get(root, "passed")), 16);
    assert_int_equal(json_integer_value(json_object_get(root, "failed")), 0);
    const json_t *points = json_object_get(root, "points");
    assert_int_equal(json_array_size(points), LF_CHECK_POINTS);
    for (size_t i = 0; i < LF_CHECK_POINTS; i++) {
        const json_t *point = json_array_get(points, i);
        const char *name = json_string_value(json_object_get(point, "name"));
        assert_int_equal(json_integer_value(json_object_get(point, "point")), i + 1);
        assert_non_null(strstr(text, name));
        assert_non_null(strstr(text, json_string_value(json_object_get(point, "measured"))));
    }
    assert_non_null(strstr(text, checked.report.sha256));
    json_decref(root);
    lf_free(text);
    lf_checked_finish(&checked);
}

static int words_of(const char *text)
{
    int n = 0;
    for (const char *c = text; *c; c++)
        n += *c != ' ' && (c == text || c[-1] == ' ');
    return n;
}

static void every_failure_has_a_short_remedy(void **state)
{
    (void)state;
    lf_print print = small_print();
    lf_checked checked = checked_of(&print);
    int n_failed = 0;
    for (int round = 0; round < 3; round++) {
        if (round == 1)
            assert_int_equal(truncate(checked.tiff, 5000), 0);
        if (round == 2)
            assert_int_equal(unlink(checked.manifest), 0);
        lf_checked_run(&checked, true);
        for (int i = 0; i < LF_CHECK_POINTS; i++) {
            const lf_check_point *point = &checked.report.points[i];
            const bool bad = point->result == LF_CHECK_FAIL || point->result == LF_CHECK_WARN;
            n_failed += bad;
            assert_int_equal(point->remedy[0] != '\0', bad);
            assert_true(words_of(point->remedy) <= 20);
            assert_true(point->measured[0] != '\0');
        }
    }
    assert_true(n_failed > 4);
    lf_checked_finish(&checked);
}

static void a_chart_is_checked_too(void **state)
{
    (void)state;
    const lf_print print = lf_checked_chart();
    lf_checked checked;
    lf_checked_make(&print, NULL, true, &checked);
    lf_checked_run(&checked, true);
    assert_int_equal(lf_print_report_count(&checked.report, LF_CHECK_FAIL), 0);
    assert_int_equal(lf_checked_point(&checked, 1), LF_CHECK_PASS);
    assert_int_equal(lf_checked_point(&checked, 16), LF_CHECK_PASS);
    assert_int_equal(lf_checked_point(&checked, 6), LF_CHECK_NONE);
    lf_checked_finish(&checked);
}

/* Micro sheets: their stripes are not measured, and that is said. */
static void a_micro_sheet_is_not_called_wrong(void **state)
{
    (void)state;
    lf_print print = small_print();
    print.optics.grid = LF_LENS_SQUARE;
    print.n_views = 16;
    print.marks = false;
    lf_checked checked = checked_of(&print);
    lf_checked_run(&checked, true);
    assert_int_equal(lf_print_report_count(&checked.report, LF_CHECK_FAIL), 0);
    assert_int_equal(lf_checked_point(&checked, 6), LF_CHECK_NONE);
    assert_int_equal(lf_checked_point(&checked, 11),
                     LF_CHECK_PASS); /* by the rows that were kept */
    assert_non_null(strstr(checked.report.points[5].measured, "micro"));
    lf_checked_finish(&checked);
}

/* Compensated prints, also those whose blur comes from a chart alone: their strip is made with the
 * kernel of the manifest. */
static void a_compensated_print_is_not_called_wrong(void **state)
{
    (void)state;
    static const lf_print_blur charted = {.n_crosstalk = 2,
                                          .crosstalk = {0.02, 0.16, 0.66, 0.14, 0.02},
                                          .crosstalk_views = 8},
                               known = {.spot_mm = 0.026, .ink_mm = 0.015, .dot_gain = 0.15},
                               gain = {.dot_gain = 0.2};
    static const struct {
        const lf_print_blur *blur;
        int n_views;
        bool horizontal, exact;
    } of[] = {{&charted, 8, false, false}, {&charted, 10, false, true}, {&charted, 5, true, true},
              {&known, 2, false, false},   {&known, 8, true, false},    {&gain, 6, false, false}};
    for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
        lf_print print = small_print();
        print.marks = false;
        print.blur = *of[i].blur;
        print.n_views = of[i].n_views;
        print.compensation.on = true;
        print.compensation.headroom = i % 2 ? 0.1 : 0.0;
        if (of[i].horizontal) {
            print.horizontal = true;
            print.width_mm = 3;
            print.height_mm = 30;
        }
        if (of[i].exact)
            print.optics = (lf_optics){.thickness_mm = 1.0, .distance_mm = 300.0};
        lf_checked checked = checked_of(&print);
        for (int with = 0; with < 2; with++) {
            char line[2048];
            lf_checked_run(&checked, with);
            if (lf_print_report_count(&checked.report, LF_CHECK_FAIL) > 0)
                fail_msg("print %zu: %s", i,
                         lf_print_report_line(&checked.report, line, sizeof line));
            assert_int_equal(lf_checked_point(&checked, 10), with ? LF_CHECK_PASS : LF_CHECK_NONE);
            assert_int_equal(lf_checked_point(&checked, 11), with ? LF_CHECK_PASS : LF_CHECK_NONE);
        }
        if (of[i].blur == &charted) { /* the file does not say its blur any more */
            json_t *manifest = json_load_file(checked.manifest, 0, NULL);
            assert_int_equal(json_object_del(manifest, "crosstalk"), 0);
            assert_int_equal(json_dump_file(manifest, checked.manifest, 0), 0);
            json_decref(manifest);
            lf_checked_run(&checked, true);
            assert_int_equal(lf_checked_point(&checked, 16), LF_CHECK_FAIL);
        }
        lf_checked_finish(&checked);
    }
}

static void the_power_of_the_measurement_is_stated(void **state)
{
    (void)state;
    lf_print print = small_print();
    print.marks = false;
    lf_checked waves = checked_of(&print), grey;
    lf_checked_make(&print, lf_card_grey, false, &grey);
    lf_checked_run(&waves, false);
    lf_checked_run(&grey, false);
    assert_non_null(strstr(waves.report.points[5].measured, " um (picture), to 0."));
    assert_int_equal(lf_checked_point(&grey, 6), LF_CHECK_NONE);
    assert_non_null(strstr(grey.report.points[5].measured, "its views differ too little"));
    lf_checked_finish(&waves);
    print.n_views = 10;
    waves = checked_of(&print);
    lf_checked_run(&waves, false);
    assert_non_null(strstr(waves.report.points[5].measured, "10 views in 9.978 pixels"));
    lf_checked_finish(&waves);
    lf_checked_finish(&grey);
}

/* --------------------------------------------------------------------------------- job sheet -- */

static void the_job_sheet_has_what_the_operator_needs(void **state)
{
    (void)state;
    const lf_print print = small_print();
    lf_checked checked = checked_of(&print);
    const char *path = lf_test_path(checked.folder, "sheet.job.pdf");
    lf_outfile file;
    lf_pdf_read pdf;
    lf_error err;
    lf_checked_run(&checked, true);
    lf_assert_ok(lf_outfile_open(&file, path, false, &err), &err);
    lf_assert_ok(lf_print_report_sheet(&checked.report, &file, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, false, &err), &err);
    lf_pdf_read_file(path, &pdf);
    assert_true(fabs(pdf.media[2] - 595.28) < 0.01 && fabs(pdf.media[3] - 841.89) < 0.01);
    assert_true(pdf.width > 20 && pdf.height > 20 && pdf.channels == 3);
    lf_pdf_read_finish(&pdf);

    static const char *const needed[] = {
        "sheet.tif",      "30 x 3 mm", "60.13 per inch",       "6 5 4 3 2 1 0",
        "Print at 100 %", "TOP",       "16 of 18 points hold", "borderless"};
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
            fail_msg("the job sheet lacks \"%s\"", needed[i]);
    assert_true(n == 0 || strstr(text, checked.report.sha256));
    lf_checked_finish(&checked);
}

/* A report of a file that is gone still gives a sheet, without an image. */
static void a_job_sheet_needs_no_readable_file(void **state)
{
    (void)state;
    const lf_print print = small_print();
    lf_checked checked = checked_of(&print);
    lf_outfile file;
    lf_pdf_read pdf;
    lf_error err;
    const char *path = lf_test_path(checked.folder, "sheet.job.pdf");
    assert_int_equal(truncate(checked.tiff, 100), 0);
    assert_int_equal(unlink(checked.manifest), 0);
    lf_checked_run(&checked, false);
    lf_assert_ok(lf_outfile_open(&file, path, false, &err), &err);
    lf_assert_ok(lf_print_report_sheet(&checked.report, &file, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, false, &err), &err);
    lf_pdf_read_file(path, &pdf);
    assert_int_equal(pdf.width, 0);
    lf_pdf_read_finish(&pdf);
    lf_checked_finish(&checked);
}

/* --------------------------------------------------------------------------------- strangers -- */

static void names_that_are_not_there_are_errors(void **state)
{
    (void)state;
    const lf_print print = small_print();
    lf_checked checked = checked_of(&print);
    lf_print_report report;
    lf_print_check_options options = {.manifest = lf_test_path(checked.folder, "other.json")};
    lf_error err;
    assert_int_equal(
        lf_print_check_file(lf_test_path(checked.folder, "none.tif"), NULL, &report, &err),
        LF_E_IO);
    assert_non_null(strstr(err.where, "none.tif"));
    assert_int_equal(lf_print_check_file(checked.tiff, &options, &report, &err), LF_E_IO);
    assert_non_null(strstr(err.where, "other.json"));
    lf_checked_finish(&checked);
}

/* No byte of the file or its manifest may do more than fail points. */
static void damaged_bytes_fail_points_only(void **state)
{
    (void)state;
    lf_print print = small_print();
    print.compress = LF_COMPRESS_LZW;
    print.marks = false;
    print.width_mm = 12;
    lf_checked checked = checked_of(&print);
    for (int file = 0; file < 2; file++) {
        const char *path = file == 0 ? checked.tiff : checked.manifest;
        char *data = NULL;
        size_t size = 0;
        lf_error err;
        lf_assert_ok(lf_file_read(path, NULL, UINT32_MAX, &data, &size, &err), &err);
        for (unsigned i = 0; i < 40; i++) {
            /* half of them near the end, where the directory is */
            const unsigned random = i * 2654435761u;
            const size_t at = i % 2 ? size - 1 - random % 300 : random % size;
            const char before = data[at];
            data[at] = (char)(before ^ (char)(1 << i % 8));
            FILE *out = fopen(path, "wb");
            assert_non_null(out);
            assert_int_equal(fwrite(data, 1, size, out), size);
            fclose(out);
            lf_checked_run(&checked, i % 3 == 0);
            char *text = lf_print_report_text(&checked.report);
            assert_non_null(text);
            lf_free(text);
            if (file == 0)
                assert_int_equal(lf_checked_point(&checked, 16), LF_CHECK_FAIL);
            data[at] = before;
        }
        FILE *out = fopen(path, "wb");
        assert_int_equal(fwrite(data, 1, size, out), size);
        fclose(out);
        lf_free(data);
    }
    lf_checked_finish(&checked);
}

/* Manifests whose values are of other types or out of all range. */
static void strange_manifests_fail_the_manifest(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "{}",
        "[]",
        "{\"quiltd_print\": 1}",
        "{\"quiltd_print\": 1, \"options\": 3, \"file\": []}",
        "{\"quiltd_print\": 1, \"options\": {\"lpi\": 1e300, \"width\": 5, \"height\": 5}}",
        "{\"quiltd_print\": 1, \"options\": {\"lpi\": \"60\", \"width\": 5, \"height\": 5}}",
        "{\"quiltd_print\": 1, \"options\": {\"lpi\": 60, \"width\": -1, \"height\": 5}}",
        "{\"quiltd_print\": 1, \"options\": {\"lpi\": 60, \"width\": 5, \"height\": 5, \"views\": "
        "100000}}",
        "{\"quiltd_print\": 1, \"options\": {\"lpi\": 5, \"dpi\": 9600, \"width\": 5000, "
        "\"height\": 5000, \"views\": 1900}}",
        "{\"quiltd_print\": 1, \"options\": {\"lpi\": 60, \"width\": 5, \"height\": 5, \"views\": "
        "7}, \"file\": {\"sha256\": 4}, \"lens\": [1], \"stripes\": {\"order\": \"x\"}, "
        "\"chart\": 7, \"warnings\": {\"a\": 1}}",
        "{\"quiltd_print\": 1, \"chart\": {}, \"options\": {\"lpi\": 60}}",
    };
    lf_print print = small_print();
    print.marks = false;
    lf_checked checked = checked_of(&print);
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        FILE *out = fopen(checked.manifest, "wb");
        assert_non_null(out);
        fputs(texts[i], out);
        fclose(out);
        lf_checked_run(&checked, false);
        assert_int_equal(lf_checked_point(&checked, 16), LF_CHECK_FAIL);
        char *text = lf_print_report_text(&checked.report);
        assert_non_null(text);
        lf_free(text);
    }
    lf_checked_finish(&checked);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_report_counts_and_names_its_points),
        cmocka_unit_test(the_text_and_the_json_say_the_same),
        cmocka_unit_test(every_failure_has_a_short_remedy),
        cmocka_unit_test(a_chart_is_checked_too),
        cmocka_unit_test(a_micro_sheet_is_not_called_wrong),
        cmocka_unit_test(a_compensated_print_is_not_called_wrong),
        cmocka_unit_test(the_power_of_the_measurement_is_stated),
        cmocka_unit_test(the_job_sheet_has_what_the_operator_needs),
        cmocka_unit_test(a_job_sheet_needs_no_readable_file),
        cmocka_unit_test(names_that_are_not_there_are_errors),
        cmocka_unit_test(damaged_bytes_fail_points_only),
        cmocka_unit_test(strange_manifests_fail_the_manifest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
