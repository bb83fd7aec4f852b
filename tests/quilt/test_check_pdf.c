/* The checklist on prints as PDF: what quiltrender writes passes, its pixels are those that another
 * reader sees, and damage fails points. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "base/file.h"
#include "quilt/proof/print_file.h"
#include "tests/quilt/checked.h"
#include "tests/quilt/pdf_read.h"

enum {
    SIZE = 1,
    RESOLUTION,
    LOSSLESS = 5,
    PITCH = 6,
    PDF = 15,
    MANIFEST = 16,
    SAME = 17,
    STORED = 18
};

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

/* --------------------------------------------------------------------------------- good ones -- */

static void good_pdfs_pass(void **state)
{
    (void)state;
    lf_print prints[7];
    int failed = 0;
    for (size_t i = 0; i < sizeof prints / sizeof prints[0]; i++)
        prints[i] = small_print();
    prints[1].bits = 16;
    prints[2].mirror = true;
    prints[2].phase_mm = 0.05;
    prints[3].horizontal = true;
    prints[3].width_mm = 4;
    prints[3].height_mm = 30;
    prints[4].dpi = 720;
    prints[4].dpi_down = 1440;
    prints[5].sheet.columns = 2;
    prints[5].sheet.rows = 2;
    prints[6].optics.slant = 9;
    for (size_t i = 0; i < sizeof prints / sizeof prints[0]; i++) {
        lf_checked checked;
        lf_checked_make_pdf(&prints[i], lf_card_waves, false, &checked);
        lf_checked_run(&checked, true);
        if (lf_print_report_count(&checked.report, LF_CHECK_FAIL) > 0 ||
            lf_checked_point(&checked, PDF) != LF_CHECK_PASS ||
            lf_checked_point(&checked, RESOLUTION) != LF_CHECK_PASS ||
            lf_checked_point(&checked, SAME) != LF_CHECK_PASS) {
            char *text = lf_print_report_text(&checked.report);
            print_message("print %zu: %s\n", i, text);
            lf_free(text);
            failed++;
        }
        lf_checked_finish(&checked);
    }
    assert_int_equal(failed, 0);
}

/* The stripes are measured in the PDF itself, without any rows that were kept. */
static void the_picture_of_a_pdf_is_measured(void **state)
{
    (void)state;
    const lf_print print = small_print();
    lf_checked checked;
    char line[2048];
    lf_checked_make_pdf(&print, lf_card_waves, false, &checked);
    lf_checked_run(&checked, true);
    assert_string_equal(lf_print_report_line(&checked.report, line, sizeof line),
                        "17 of 18 points hold, 1 does not apply");
    lf_checked_run(&checked, false);
    assert_int_equal(lf_checked_point(&checked, PITCH), LF_CHECK_PASS);
    lf_checked_finish(&checked);
}

static void a_chart_as_pdf_is_checked(void **state)
{
    (void)state;
    const lf_print print = lf_checked_chart();
    lf_checked checked;
    lf_checked_make_pdf(&print, NULL, true, &checked);
    lf_checked_run(&checked, true);
    assert_int_equal(lf_print_report_count(&checked.report, LF_CHECK_FAIL), 0);
    assert_int_equal(lf_checked_point(&checked, PDF), LF_CHECK_PASS);
    lf_checked_finish(&checked);
}

/* Also from the last row to the first, as no stream runs. */
static void its_pixels_are_those_that_another_reader_sees(void **state)
{
    (void)state;
    for (int bits = 8; bits <= 16; bits += 8) {
        lf_print print = small_print();
        lf_checked checked;
        lf_print_file *file = NULL;
        lf_pdf_read pdf;
        lf_error err;
        print.bits = bits;
        lf_checked_make_pdf(&print, lf_card_waves, false, &checked);
        lf_pdf_read_file(checked.tiff, &pdf);
        lf_assert_ok(lf_print_file_open(checked.tiff, NULL, &file, &err), &err);
        const lf_print_tags *tags = lf_print_file_tags(file);
        assert_true(tags->width == pdf.width && tags->height == pdf.height);
        assert_true(tags->bits == bits && tags->samples == pdf.channels);
        assert_true(tags->dpi[0] == 600 && tags->dpi[1] == 600);
        const size_t n = (size_t)pdf.width * (size_t)pdf.channels;
        uint16_t *row = lf_calloc(n, sizeof *row);
        assert_non_null(row);
        for (int i = 0; i < 2 * pdf.height; i++) {
            const int y = i < pdf.height ? i : 2 * pdf.height - 1 - i;
            if (i >= pdf.height && y % 9 > 0)
                continue;
            lf_assert_ok(lf_print_file_raw(file, y, row, &err), &err);
            for (size_t k = 0; k < n; k++)
                assert_int_equal(bits == 8 ? ((const uint8_t *)row)[k] : row[k],
                                 pdf.value[(size_t)y * n + k]);
        }
        lf_free(row);
        lf_print_file_close(file);
        lf_pdf_read_finish(&pdf);
        lf_checked_finish(&checked);
    }
}

/* ------------------------------------------------------------------------------- spoilt ones -- */

typedef struct spoilt_case {
    const char *from, *to; /* of the same length */
    int point;
} spoilt_case;

static const spoilt_case cases[] = {
    {"/TrimBox [2", "/TrimBox [3", PDF},
    {"/BleedBox [2", "/BleedBox [1", PDF},
    {"/MediaBox [0 0 ", "/MediaBox [1 0 ", PDF},
    {"q 1", "q 2", PDF},
    {"q 1", "q 2", RESOLUTION},
    {" 0 0 cm /I Do Q", " 1 0 cm /I Do Q", PDF},
    {"/Interpolate false", "/Interpolate true ", PDF},
    {"/OutputIntents [", "/OutputIntenXs [", PDF},
    {"/Parent 2 0 R", "/Rotate 90   ", LOSSLESS},
    {"/Width 1", "/Width 2", SIZE},
    {"%%EOF", "%%EOX", STORED},
    {"/I Do Q", "/J Do Q", STORED},
    {"/Predictor 15", "/Predictor 12", STORED},
    {"/Filter /FlateDecode", "/Filter /DCTDecode  ", STORED},
};

/* The first place of a text after another one. */
static char *place_of(char *data, size_t size, const char *text)
{
    return memmem(data, size, text, strlen(text));
}

static void put_file(const char *path, const char *data, size_t size)
{
    FILE *out = fopen(path, "wb");
    assert_non_null(out);
    assert_int_equal(fwrite(data, 1, size, out), size);
    fclose(out);
}

static void spoilt_pdfs_are_told(void **state)
{
    (void)state;
    const lf_print print = small_print();
    lf_checked checked;
    char *data = NULL, line[2048];
    size_t size = 0;
    lf_error err;
    int missed = 0;
    lf_checked_make_pdf(&print, lf_card_waves, false, &checked);
    lf_assert_ok(lf_file_read(checked.tiff, NULL, UINT32_MAX, &data, &size, &err), &err);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const spoilt_case *c = &cases[i];
        char *at = place_of(data, size, c->from);
        if (!at || strlen(c->from) != strlen(c->to))
            fail_msg("case %zu: \"%s\" is not in the file", i, c->from);
        memcpy(at, c->to, strlen(c->to));
        put_file(checked.tiff, data, size);
        memcpy(at, c->from, strlen(c->from));
        lf_checked_hash(&checked);
        lf_checked_run(&checked, false);
        if (lf_checked_point(&checked, c->point) == LF_CHECK_FAIL)
            continue;
        print_message("%s: %s\n", c->to, lf_print_report_line(&checked.report, line, sizeof line));
        missed++;
    }
    lf_free(data);
    lf_checked_finish(&checked);
    assert_int_equal(missed, 0);
}

/* Of another program, or cut: no word of a TIFF. */
static void other_pdfs_are_refused_in_words(void **state)
{
    (void)state;
    static const char other[] = "%PDF-1.4\n1 0 obj\n<< >>\nendobj\ntrailer\n<< >>\n%%EOF\n";
    const lf_print print = small_print();
    lf_checked checked;
    lf_checked_make_pdf(&print, lf_card_waves, false, &checked);
    for (int way = 0; way < 2; way++) {
        if (way == 0)
            assert_int_equal(truncate(checked.tiff, 5000), 0);
        else
            put_file(checked.tiff, other, sizeof other - 1);
        lf_checked_run(&checked, false);
        assert_int_equal(lf_checked_point(&checked, STORED), LF_CHECK_FAIL);
        assert_non_null(
            strstr(checked.report.points[STORED - 1].measured, "a PDF that quiltrender"));
        assert_null(strstr(checked.report.points[STORED - 1].measured, "TIFF"));
        assert_int_equal(lf_checked_point(&checked, PDF), LF_CHECK_NONE);
        assert_null(strstr(checked.report.points[PDF - 1].measured, "TIFF"));
    }
    lf_checked_finish(&checked);
}

static void damaged_bytes_fail_points_only(void **state)
{
    (void)state;
    lf_print print = small_print();
    lf_checked checked;
    char *data = NULL;
    size_t size = 0;
    lf_error err;
    print.marks = false;
    print.width_mm = 12;
    lf_checked_make_pdf(&print, lf_card_waves, false, &checked);
    lf_assert_ok(lf_file_read(checked.tiff, NULL, UINT32_MAX, &data, &size, &err), &err);
    for (unsigned i = 0; i < 24; i++) {
        /* half of them near the end, where the objects are */
        const unsigned random = i * 2654435761u;
        const size_t at = i % 2 ? size - 1 - random % 6000 : random % size;
        const char before = data[at];
        data[at] = (char)(before ^ (char)(1 << i % 8));
        put_file(checked.tiff, data, size);
        lf_checked_run(&checked, i % 3 == 0);
        assert_int_equal(lf_checked_point(&checked, MANIFEST), LF_CHECK_FAIL);
        data[at] = before;
    }
    lf_free(data);
    lf_checked_finish(&checked);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(good_pdfs_pass),
        cmocka_unit_test(the_picture_of_a_pdf_is_measured),
        cmocka_unit_test(a_chart_as_pdf_is_checked),
        cmocka_unit_test(its_pixels_are_those_that_another_reader_sees),
        cmocka_unit_test(spoilt_pdfs_are_told),
        cmocka_unit_test(other_pdfs_are_refused_in_words),
        cmocka_unit_test(damaged_bytes_fail_points_only),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
