/* A page written by quilt/print/pdf.h, read by a reader of its own and, where it is installed, by
 * qpdf. */
#include "tests/testing.h"

#include <fcntl.h>

#include "base/alloc.h"
#include "quilt/print/pdf.h"
#include "tests/quilt/pdf_read.h"

static const lf_pdf_page a4 = {.width = 595.2, .height = 841.8, .title = "Job sheet"};

static lf_pdf *begin(lf_outfile *file, const char *path, const lf_pdf_page *page)
{
    lf_pdf *pdf = NULL;
    lf_error err;
    lf_assert_ok(lf_outfile_open(file, path, true, &err), &err);
    lf_assert_ok(lf_pdf_open(file, page, &pdf, &err), &err);
    return pdf;
}

static void end(lf_outfile *file, lf_pdf *pdf)
{
    lf_error err;
    lf_assert_ok(lf_pdf_close(pdf, &err), &err);
    lf_assert_ok(lf_outfile_commit(file, true, &err), &err);
}

/* The judge from outside, if there is one. */
static void assert_qpdf_accepts(const char *path)
{
    char command[PATH_MAX + 64];
    if (system("command -v qpdf > /dev/null 2>&1") != 0) {
        print_message("qpdf is not installed: the file is not checked by it\n");
        return;
    }
    snprintf(command, sizeof command, "qpdf --check '%s' > /dev/null", path);
    assert_int_equal(system(command), 0);
}

static void a_page_of_text_is_a_sound_file(void **state)
{
    lf_outfile file;
    lf_pdf_read read;
    const char *path = lf_test_path(*state, "job.pdf");
    lf_pdf *pdf = begin(&file, path, &a4);
    lf_pdf_text(pdf, 56.7, 780, 14, true, 0, "Pitch (60.13) lpi\\inch");
    lf_pdf_text(pdf, 56.7, 760, 10, false, 0.25, "M\xc3\xa4rz \xe2\x82\xac \xff");
    lf_pdf_rect(pdf, 56.7, 700, 100.5, 20, 0.8);
    end(&file, pdf);
    lf_pdf_read_file(path, &read);
    assert_int_equal(read.width, 0);
    assert_true(read.media[2] == 595.2 && read.media[3] == 841.8);
    assert_memory_equal(read.trim, read.media, sizeof read.trim);
    assert_true(lf_pdf_read_has(
        &read, "BT /B 14 Tf 0 g 56.7 780 Td (Pitch \\(60.13\\) lpi\\\\inch) Tj ET\n"));
    assert_true(lf_pdf_read_has(&read, "Tf 0.25 g 56.7 760 Td (M\\344rz ? ?) Tj"));
    assert_true(lf_pdf_read_has(&read, "0.8 g 56.7 700 100.5 20 re f\n"));
    assert_true(lf_pdf_read_has(&read, "/BaseFont /Helvetica-Bold"));
    assert_false(lf_pdf_read_has(&read, "GTS_PDFX"));
    assert_qpdf_accepts(path);
    lf_pdf_read_finish(&read);
}

static void widths_are_those_of_the_font(void **state)
{
    (void)state;
    lf_assert_close(lf_pdf_text_width(10, false, "Wi"), 9.44 + 2.22, 0, 1e-9);
    lf_assert_close(lf_pdf_text_width(10, true, "Wi"), 9.44 + 2.78, 0, 1e-9);
    lf_assert_close(lf_pdf_text_width(1000, false, "~ "), 584 + 278, 0, 1e-9);
    lf_assert_close(lf_pdf_text_width(1000, false, "\xc3\xa4"), 556, 0, 1e-9);
    assert_true(lf_pdf_text_width(10, true, "") == 0);
}

static void titles_of_any_letters_are_kept(void **state)
{
    lf_outfile file;
    lf_pdf_read read;
    lf_pdf_page page = a4;
    const char *path = lf_test_path(*state, "title.pdf");
    page.title = "<a & b> \xc3\xa4 \xf0\x9f\x98\x80 \xc0\xa8\x1f";
    end(&file, begin(&file, path, &page));
    lf_pdf_read_file(path, &read);
    assert_true(lf_pdf_read_has(&read, "&#60;a &#38; b&#62; \xc3\xa4 \xf0\x9f\x98\x80 &#63;"));
    assert_true(lf_pdf_read_has(&read, "/Title <FEFF003C0061002000260020006200"
                                       "3E002000E40020D83DDE000020003F003F003F>"));
    assert_qpdf_accepts(path);
    lf_pdf_read_finish(&read);
}

/* Rows of row values: eight that are like their neighbours on the left, then eight like those
 * above. */
static void fill(uint16_t *value, int row, int height, int bits)
{
    uint32_t x = 12345;
    for (int i = 0; i < row * height; i++) {
        x = x * 1664525u + 1013904223u;
        const int noise = (int)(x >> 29), slow = i / 7 * 3,
                  column = (int)((uint32_t)(i % row) * 2654435761u >> 25);
        const int v = (i / row / 8 % 2 ? slow : column) + noise;
        value[i] = (uint16_t)((bits == 8 ? v : 257 * v + 19 * noise) & (bits == 8 ? 255 : 65535));
    }
}

static void write_image(const char *path, const lf_pdf_image *image, const uint16_t *value,
                        int strip_rows)
{
    lf_outfile file;
    lf_error err;
    lf_pdf_strip strip = {0};
    const int row = image->width * image->channels;
    unsigned char *pixels = lf_calloc((size_t)(row * strip_rows), 2);
    lf_pdf *pdf = begin(&file, path, &a4);
    lf_assert_ok(lf_pdf_image_begin(pdf, image, &err), &err);
    for (int y = 0; y < image->height; y += strip_rows) {
        const int rows = image->height - y < strip_rows ? image->height - y : strip_rows;
        for (int i = 0; i < row * rows; i++)
            if (image->bits == 8)
                pixels[i] = (unsigned char)value[y * row + i];
            else
                memcpy(pixels + 2 * i, &value[y * row + i], 2);
        assert_int_equal(lf_pdf_strip_pack(image, pixels, rows, y + rows == image->height, &strip),
                         LF_OK);
        lf_assert_ok(lf_pdf_image_strip(pdf, &strip, &err), &err);
    }
    lf_assert_ok(lf_pdf_image_end(pdf, &err), &err);
    end(&file, pdf);
    lf_pdf_strip_finish(&strip);
    lf_free(pixels);
}

static void images_come_back_bit_for_bit(void **state)
{
    static const int channels[] = {1, 3, 4};
    uint16_t value[37 * 29 * 4];
    for (int c = 0; c < 3; c++)
        for (int bits = 8; bits <= 16; bits += 8)
            for (int rows = 1; rows <= 41; rows += 4) {
                const lf_pdf_image image = {37, 29, channels[c], bits, 10, 20, 37 * 0.12, 29 * .06};
                const char *path = lf_test_path(*state, "image.pdf");
                lf_pdf_read read;
                fill(value, 37 * channels[c], 29, bits);
                write_image(path, &image, value, rows);
                lf_pdf_read_file(path, &read);
                assert_int_equal(read.width, 37);
                assert_int_equal(read.height, 29);
                assert_int_equal(read.channels, channels[c]);
                assert_int_equal(read.bits, bits);
                assert_memory_equal(read.value, value,
                                    sizeof *value * 37 * 29 * (size_t)channels[c]);
                lf_assert_close(read.matrix[0], 4.44, 0, 1e-9);
                lf_assert_close(read.matrix[3], 1.74, 0, 1e-9);
                lf_assert_close(read.matrix[4], 10, 0, 0);
                lf_assert_close(read.matrix[5], 20, 0, 0);
                assert_true(lf_pdf_read_has(&read, "/Interpolate false"));
                if (rows == 13)
                    assert_qpdf_accepts(path);
                lf_pdf_read_finish(&read);
            }
}

static void identity_of(const char *path, char out[33])
{
    lf_pdf_read read;
    lf_pdf_read_file(path, &read);
    const char *id = strstr(read.bytes + read.size - 256, "/ID [<");
    assert_non_null(id);
    memcpy(out, id + 6, 32);
    out[32] = '\0';
    lf_pdf_read_finish(&read);
}

static void the_identity_follows_from_the_content(void **state)
{
    char ids[3][33];
    uint16_t value[5 * 4 * 3] = {0};
    const lf_pdf_image image = {5, 4, 3, 8, 0, 0, 50, 40};
    const char *path = lf_test_path(*state, "identity.pdf");
    for (int i = 0; i < 3; i++) {
        value[59] = i == 2;
        write_image(path, &image, value, 4);
        identity_of(path, ids[i]);
    }
    assert_string_equal(ids[0], ids[1]);
    assert_string_not_equal(ids[0], ids[2]);
}

static void a_printers_profile_makes_it_pdf_x(void **state)
{
    char profile[128] = "";
    const char *path = lf_test_path(*state, "x.pdf");
    for (int printer = 0; printer < 2; printer++) {
        lf_outfile file;
        lf_pdf_read read;
        lf_pdf_page page = a4;
        memcpy(profile + 12, printer ? "prtr" : "mntr", 4);
        page.profile = profile;
        page.profile_size = sizeof profile;
        page.profile_channels = 3;
        page.profile_name = "Shop (matt)";
        assert_int_equal(lf_pdf_page_is_x(&page), printer);
        end(&file, begin(&file, path, &page));
        lf_pdf_read_file(path, &read);
        assert_true(lf_pdf_read_has(&read, "/S /GTS_PDFX"));
        assert_true(lf_pdf_read_has(&read, "/OutputCondition (Shop \\(matt\\))"));
        assert_int_equal(lf_pdf_read_has(&read, "/GTS_PDFXVersion (PDF/X-4)"), printer);
        assert_int_equal(lf_pdf_read_has(&read, "<pdfxid:GTS_PDFXVersion>PDF/X-4<"), printer);
        lf_pdf_read_finish(&read);
    }
}

static void pages_that_readers_refuse_are_refused(void **state)
{
    static const double wrong[][2] = {{14400.1, 100}, {100, 14400.1}, {2.9, 100}, {NAN, 100}};
    lf_outfile file;
    lf_pdf *pdf = NULL;
    lf_error err;
    const char *path = lf_test_path(*state, "large.pdf");
    lf_assert_ok(lf_outfile_open(&file, path, true, &err), &err);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        const lf_pdf_page page = {.width = wrong[i][0], .height = wrong[i][1], .title = ""};
        assert_int_equal(lf_pdf_open(&file, &page, &pdf, &err), LF_E_ARG);
        assert_non_null(strstr(err.what, "write OUT.tif"));
    }
    const lf_pdf_page largest = {.width = 14400, .height = 3, .title = ""};
    lf_assert_ok(lf_pdf_open(&file, &largest, &pdf, &err), &err);
    lf_pdf_abandon(pdf);
    lf_pdf_abandon(NULL);
    lf_outfile_abandon(&file);
}

static void a_disk_that_is_full_is_an_error(void **state)
{
    (void)state;
    lf_outfile file = {.fd = open("/dev/full", O_WRONLY), .borrowed = true};
    lf_pdf *pdf = NULL;
    lf_error err;
    if (file.fd < 0)
        skip();
    assert_int_equal(lf_pdf_open(&file, &a4, &pdf, &err), LF_E_IO);
    close(file.fd);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(a_page_of_text_is_a_sound_file),
        cmocka_unit_test(widths_are_those_of_the_font),
        lf_test_in_folder(titles_of_any_letters_are_kept),
        lf_test_in_folder(images_come_back_bit_for_bit),
        lf_test_in_folder(the_identity_follows_from_the_content),
        lf_test_in_folder(a_printers_profile_makes_it_pdf_x),
        lf_test_in_folder(pages_that_readers_refuse_are_refused),
        cmocka_unit_test(a_disk_that_is_full_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
