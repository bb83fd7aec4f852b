/* The checklist as a user meets it: quiltrender checks what it has written, quiltprint check what
 * has travelled. */
#include "tests/daemon/quiltrender.h"

#include <jansson.h>

/* Runs quiltprint; its words are parted by single blanks. */
static int quiltprint(const char *words, char *out, size_t size)
{
    char command[4 * PATH_MAX];
    snprintf(command, sizeof command, "'%s' %s 2>&1", lf_test_built("quiltprint"), words);
    FILE *from = popen(command, "r"); /* NOLINT(cert-env33-c) */
    assert_non_null(from);
    out[fread(out, 1, size - 1, from)] = '\0';
    const int status = pclose(from);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static void remove_outputs(const char *folder, const char *stem)
{
    static const char *const endings[] = {"tif", "json", "check.txt", "check.json", "job.pdf"};
    char name[64];
    for (size_t i = 0; i < sizeof endings / sizeof endings[0]; i++) {
        snprintf(name, sizeof name, "%s.%s", stem, endings[i]);
        (void)unlink(lf_test_path(folder, name));
    }
}

static void a_written_print_is_checked(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    json_error_t json_error;
    qr_run(&o, "%s -o %s/sheet.tif --print 60.13@600 --print-size 30x20 --marks", f->quilt,
           f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "sheet.tif: 16 of 18 points hold, 2 do not apply\n"));
    assert_true(qr_exists(f->folder, "sheet.check.txt"));
    assert_true(qr_exists(f->folder, "sheet.job.pdf"));
    json_t *root = json_load_file(lf_test_path(f->folder, "sheet.check.json"), 0, &json_error);
    assert_int_equal(json_integer_value(json_object_get(root, "failed")), 0);
    json_decref(root);
    remove_outputs(f->folder, "sheet");
}

static void a_chart_is_checked(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    qr_run(&o, "-o %s/chart.tif --chart 60+-0.2/0.1@600 --print-size 80x60", f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "chart.tif: "));
    char *text = NULL;
    size_t size;
    lf_error err;
    lf_assert_ok(
        lf_file_read(lf_test_path(f->folder, "chart.check.txt"), NULL, 1 << 16, &text, &size, &err),
        &err);
    assert_non_null(strstr(text, "sampled rows are those that were written"));
    assert_null(strstr(text, "not written here"));
    lf_free(text);
    remove_outputs(f->folder, "chart");
}

static void the_check_can_be_off(void **state)
{
    const qr_files *f = *state;
    qr_outcome o;
    qr_run(&o, "%s -o %s/plain.tif --print 60.13@600 --print-size 30x20 --check off", f->quilt,
           f->folder);
    assert_int_equal(o.code, 0);
    assert_null(strstr(o.err, "points"));
    assert_false(qr_exists(f->folder, "plain.check.txt"));
    assert_false(qr_exists(f->folder, "plain.job.pdf"));
    remove_outputs(f->folder, "plain");
    qr_run(&o, "%s -o %s/q.png --check off", f->quilt, f->folder);
    qr_assert_fails(&o, 2, "--check: needs --print");
}

static void a_pdf_is_checked(void **state)
{
    const qr_files *f = *state;
    char words[2 * PATH_MAX], out[1 << 14];
    qr_outcome o;
    qr_run(&o, "%s -o %s/sheet.pdf --print 60.13@600 --print-size 30x20 --marks", f->quilt,
           f->folder);
    assert_int_equal(o.code, 0);
    assert_non_null(strstr(o.err, "sheet.pdf: 17 of 18 points hold, 1 does not apply\n"));
    assert_true(qr_exists(f->folder, "sheet.job.pdf"));
    snprintf(words, sizeof words, "check %s/sheet.pdf", f->folder);
    assert_int_equal(quiltprint(words, out, sizeof out), 0);
    assert_non_null(strstr(out, "15 PASS  PDF boxes: one image"));
    (void)unlink(lf_test_path(f->folder, "sheet.pdf"));
    remove_outputs(f->folder, "sheet");
}

/* Neither replaced by a check, nor removed without one. */
static void files_of_others_beside_a_print_stay(void **state)
{
    const qr_files *f = *state;
    static const char *const names[] = {"own.check.txt", "own.check.json", "own.job.pdf"};
    for (int i = 0; i < 3; i++) {
        qr_outcome o;
        (void)lf_test_write(f->folder, names[i], "mine");
        qr_run(&o, "%s -o %s/own.tif --print 60.13@600 --print-size 30x20", f->quilt, f->folder);
        qr_assert_fails(&o, 2, names[i]);
        assert_false(qr_exists(f->folder, "own.tif"));
        qr_succeed("%s -o %s/own.tif --print 60.13@600 --print-size 30x20 --check off", f->quilt,
                   f->folder);
        assert_true(qr_exists(f->folder, names[i]));
        remove_outputs(f->folder, "own");
    }
}

static void reports_of_an_earlier_print_do_not_stay(void **state)
{
    const qr_files *f = *state;
    for (int i = 0; i < 2; i++) /* a report may replace an earlier one */
        qr_succeed("%s -o %s/old.tif --print 60.13@600 --print-size 30x20", f->quilt, f->folder);
    assert_true(qr_exists(f->folder, "old.job.pdf"));
    qr_succeed("%s -o %s/old.tif --print 60@600 --print-size 30x20 --check off", f->quilt,
               f->folder);
    assert_true(qr_exists(f->folder, "old.tif"));
    assert_false(qr_exists(f->folder, "old.check.txt"));
    assert_false(qr_exists(f->folder, "old.check.json"));
    assert_false(qr_exists(f->folder, "old.job.pdf"));
    remove_outputs(f->folder, "old");
}

static void quiltprint_checks_a_print_that_has_travelled(void **state)
{
    const qr_files *f = *state;
    char words[2 * PATH_MAX], out[1 << 14];
    json_error_t json_error;
    qr_succeed("%s -o %s/sheet.tif --print 60.13@600 --print-size 30x20", f->quilt, f->folder);
    snprintf(words, sizeof words, "check %s/sheet.tif", f->folder);
    assert_int_equal(quiltprint(words, out, sizeof out), 0);
    assert_non_null(strstr(out, " 1 PASS  pixel size: 709 x 472 pixels\n"));
    snprintf(words, sizeof words, "check %s/sheet.tif --json", f->folder);
    assert_int_equal(quiltprint(words, out, sizeof out), 0);
    json_t *root = json_loads(out, 0, &json_error);
    assert_int_equal(json_integer_value(json_object_get(root, "failed")), 0);
    json_decref(root);

    assert_int_equal(
        rename(lf_test_path(f->folder, "sheet.json"), lf_test_path(f->folder, "other.json")), 0);
    snprintf(words, sizeof words, "check %s/sheet.tif", f->folder);
    assert_int_equal(quiltprint(words, out, sizeof out), 1);
    assert_non_null(strstr(out, "there is no manifest"));
    snprintf(words, sizeof words, "check %s/sheet.tif --manifest %s/other.json", f->folder,
             f->folder);
    assert_int_equal(quiltprint(words, out, sizeof out), 0);
    assert_int_equal(truncate(lf_test_path(f->folder, "sheet.tif"), 3000), 0);
    assert_int_equal(quiltprint(words, out, sizeof out), 1);
    assert_non_null(strstr(out, " of 18 points fail; see their remedies\n"));
    (void)unlink(lf_test_path(f->folder, "other.json"));
    remove_outputs(f->folder, "sheet");
}

static void mistakes_of_a_command_line_are_told(void **state)
{
    const qr_files *f = *state;
    char words[2 * PATH_MAX], out[1 << 14];
    assert_int_equal(quiltprint("check", out, sizeof out), 2);
    assert_string_equal(out, "quiltprint: check: expects one PRINT.tif or .pdf, got 0 names\n");
    snprintf(words, sizeof words, "check %s/none.tif", f->folder);
    assert_int_equal(quiltprint(words, out, sizeof out), 1);
    assert_non_null(strstr(out, "none.tif: cannot open"));
    snprintf(words, sizeof words, "check %s", f->quilt); /* a PNG */
    assert_int_equal(quiltprint(words, out, sizeof out), 1);
    assert_non_null(strstr(out, "FAIL"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_written_print_is_checked),
        cmocka_unit_test(a_chart_is_checked),
        cmocka_unit_test(the_check_can_be_off),
        cmocka_unit_test(a_pdf_is_checked),
        cmocka_unit_test(files_of_others_beside_a_print_stay),
        cmocka_unit_test(reports_of_an_earlier_print_do_not_stay),
        cmocka_unit_test(quiltprint_checks_a_print_that_has_travelled),
        cmocka_unit_test(mistakes_of_a_command_line_are_told),
    };
    return cmocka_run_group_tests(tests, qr_set_up, qr_tear_down);
}
