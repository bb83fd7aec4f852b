/* Prints as PDF files: the TIFF's pixels, in the exact place. And what both formats share: strips
 * made at the same time, and room on the disk. */
#include "tests/testing.h"

#include <fcntl.h>
#include <lcms2.h>
#include <sys/statvfs.h>

#include "base/alloc.h"
#include "base/thread.h"
#include "tests/quilt/pdf_read.h"
#include "tests/quilt/printed.h"

/* Writes a print to folder/name. */
static const char *write_print(const lf_print *print, const lf_views32 *views,
                               const lf_print_run *run, const char *folder, const char *name)
{
    const char *path = lf_test_path(folder, name);
    char manifest_path[PATH_MAX];
    lf_outfile file, manifest;
    lf_error err;
    snprintf(manifest_path, sizeof manifest_path, "%s.json", path);
    lf_assert_ok(lf_outfile_open(&file, path, true, &err), &err);
    lf_assert_ok(lf_outfile_open(&manifest, manifest_path, true, &err), &err);
    lf_assert_ok(lf_print_write(print, views, run, &file, &manifest, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
    lf_assert_ok(lf_outfile_commit(&manifest, true, &err), &err);
    return path;
}

static bool has_program(const char *name)
{
    char command[128];
    snprintf(command, sizeof command, "command -v %s > /dev/null 2>&1", name);
    if (system(command) == 0)
        return true;
    print_message("%s is not installed: the file is not checked by it\n", name);
    return false;
}

static const lf_print_run as_pdf = {.format = LF_PRINT_PDF};

/* pdf: of a raster whose bleed, marks and dpi these are. Own arithmetic. */
static void assert_boxes(const lf_pdf_read *pdf, const lf_print *print)
{
    const double dpi[2] = {print->dpi, print->dpi_down > 0 ? print->dpi_down : print->dpi},
                 trim[2] = {print->width_mm, print->height_mm};
    const int pixels[2] = {pdf->width, pdf->height};
    for (int axis = 0; axis < 2; axis++) {
        const double page = pixels[axis] * 72.0 / dpi[axis], middle = 0.5 * page,
                     half = 0.5 * trim[axis] * 72.0 / 25.4,
                     beyond = half + print->bleed_mm * 72.0 / 25.4;
        assert_true(pdf->media[axis] == 0.0);
        lf_assert_close(pdf->media[axis + 2], page, 0, 1e-6);
        lf_assert_close(pdf->matrix[axis == 0 ? 0 : 3], page, 0, 1e-6);
        lf_assert_close(pdf->trim[axis], middle - half, 0, 1e-6);
        lf_assert_close(pdf->trim[axis + 2], middle + half, 0, 1e-6);
        lf_assert_close(pdf->bleed[axis], fmax(middle - beyond, 0.0), 0, 1e-6);
        lf_assert_close(pdf->bleed[axis + 2], fmin(middle + beyond, page), 0, 1e-6);
    }
    assert_true(pdf->matrix[1] == 0 && pdf->matrix[2] == 0 && pdf->matrix[4] == 0 &&
                pdf->matrix[5] == 0);
}

static void assert_pixels(const lf_pdf_read *pdf, const lf_printed *tiff)
{
    assert_int_equal(pdf->width, tiff->width);
    assert_int_equal(pdf->height, tiff->height);
    assert_int_equal(pdf->channels, tiff->channels);
    assert_int_equal(pdf->bits, tiff->bits);
    assert_memory_equal(pdf->value, tiff->value,
                        sizeof *pdf->value * (size_t)pdf->width * (size_t)pdf->height *
                            (size_t)pdf->channels);
}

/* A printer's CMYK profile, good enough for a test: ink is what light lacks. */
static int less_light(const cmsUInt16Number in[], cmsUInt16Number out[], void *cargo)
{
    (void)cargo;
    for (int c = 0; c < 3; c++)
        out[c] = (cmsUInt16Number)(65535 - in[c]);
    out[3] = (cmsUInt16Number)(out[0] / 3);
    return 1;
}

static int lab_of_ink(const cmsUInt16Number in[], cmsUInt16Number out[], void *cargo)
{
    (void)cargo;
    out[0] = (cmsUInt16Number)(65535 - (in[0] + in[1] + in[2]) / 3);
    out[1] = out[2] = 32896;
    return 1;
}

static const char *make_cmyk(const char *folder)
{
    const char *path = lf_test_path(folder, "shop.icc");
    cmsHPROFILE profile = cmsCreateProfilePlaceholder(NULL);
    cmsPipeline *to_ink = cmsPipelineAlloc(NULL, 3, 4), *to_lab = cmsPipelineAlloc(NULL, 4, 3);
    cmsStage *ink = cmsStageAllocCLut16bit(NULL, 5, 3, 4, NULL),
             *lab = cmsStageAllocCLut16bit(NULL, 5, 4, 3, NULL);
    assert_true(profile && to_ink && to_lab && ink && lab);
    assert_true(cmsStageSampleCLut16bit(ink, less_light, NULL, 0));
    assert_true(cmsStageSampleCLut16bit(lab, lab_of_ink, NULL, 0));
    cmsPipelineInsertStage(to_ink, cmsAT_END, ink);
    cmsPipelineInsertStage(to_lab, cmsAT_END, lab);
    cmsSetProfileVersion(profile, 2.1);
    cmsSetDeviceClass(profile, cmsSigOutputClass);
    cmsSetColorSpace(profile, cmsSigCmykData);
    cmsSetPCS(profile, cmsSigLabData);
    assert_true(cmsWriteTag(profile, cmsSigAToB0Tag, to_lab));
    assert_true(cmsWriteTag(profile, cmsSigBToA0Tag, to_ink));
    assert_true(cmsSaveProfileToFile(profile, path));
    cmsCloseProfile(profile);
    cmsPipelineFree(to_ink);
    cmsPipelineFree(to_lab);
    return path;
}

static void a_pdf_has_the_pixels_of_the_tiff_in_their_exact_place(void **state)
{
    char icc[PATH_MAX];
    snprintf(icc, sizeof icc, "%s", make_cmyk(*state));
    for (int i = 0; i < 6; i++) {
        lf_print print = i % 2 ? lf_print_odd() : lf_print_sound();
        lf_views32 card;
        lf_printed tiff;
        lf_pdf_read pdf;
        print.bits = i < 2 || i == 4 ? 8 : 16;
        print.marks = i >= 2;
        print.dpi_down = i == 3 ? 812.8 : 0.0;
        print.icc_path = i >= 4 ? icc : NULL;
        print.mirror = i == 2;
        print.horizontal = i == 3;
        lf_card_make(&print, lf_card_speckle, NULL, &card);
        lf_printed_make(&print, &card, 0, &tiff);
        const char *path = write_print(&print, &card, &as_pdf, *state, "print.pdf");
        lf_pdf_read_file(path, &pdf);
        assert_pixels(&pdf, &tiff);
        assert_boxes(&pdf, &print);
        assert_int_equal(lf_pdf_read_has(&pdf, "(PDF/X-4)"), i >= 4);
        assert_int_equal(lf_pdf_read_has(&pdf, "/ColorSpace /DeviceCMYK"), i >= 4);
        assert_true(lf_pdf_read_has(&pdf, "/OutputIntents"));
        assert_false(lf_pdf_read_has(&pdf, "DCTDecode"));
        lf_pdf_read_finish(&pdf);
        lf_printed_finish(&tiff);
        lf_card_finish(&card);
    }
}

/* The densest pixel of a CMYK raster, in percent. */
static double most_ink(const lf_printed *tiff)
{
    const size_t n = (size_t)tiff->width * (size_t)tiff->height;
    long most = 0;
    for (size_t i = 0; i < n; i++) {
        const uint16_t *ink = tiff->value + 4 * i;
        const long sum = (long)ink[0] + ink[1] + ink[2] + ink[3];
        most = sum > most ? sum : most;
    }
    return 100.0 * (double)most / (tiff->bits == 8 ? 255 : 65535);
}

/* The profile of a press from libgs9-common, if it is there, has black ink. */
static void a_cmyk_print_tells_its_ink(void **state)
{
    static const char press[] = "/usr/share/color/icc/ghostscript/default_cmyk.icc";
    char icc[PATH_MAX];
    snprintf(icc, sizeof icc, "%s", make_cmyk(*state));
    for (int i = 0; i < 4; i++) {
        lf_print print = lf_print_odd();
        lf_views32 card;
        lf_printed tiff;
        print.bits = i % 2 ? 8 : 16;
        print.icc_path = i < 2 ? icc : press;
        if (access(print.icc_path, R_OK) != 0) {
            print_message("%s is not installed\n", press);
            continue;
        }
        lf_card_make(&print, lf_card_speckle, NULL, &card);
        lf_printed_make(&print, &card, 0, &tiff);
        const double told = json_number_value(
            json_object_get(json_object_get(tiff.manifest, "colour"), "most_ink_percent"));
        assert_int_equal(tiff.channels, 4);
        lf_assert_close(told, most_ink(&tiff), 0, 1e-9);
        assert_true(told > 50 && told < 400);
        lf_printed_finish(&tiff);
        lf_card_finish(&card);
    }
}

/* The output of a command, at most size - 1 bytes. */
static size_t output_of(const char *command, char *out, size_t size)
{
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    const size_t n = fread(out, 1, size - 1, pipe);
    out[n] = '\0';
    assert_int_equal(pclose(pipe), 0);
    return n;
}

static void programs_of_others_read_it(void **state)
{
    lf_print print = lf_print_odd();
    lf_views32 card;
    lf_printed tiff;
    char command[PATH_MAX + 128], text[4096];
    print.bits = 8;
    lf_card_make(&print, lf_card_speckle, NULL, &card);
    lf_printed_make(&print, &card, 0, &tiff);
    const char *path = write_print(&print, &card, &as_pdf, *state, "others.pdf");
    if (has_program("qpdf")) {
        const size_t n = (size_t)tiff.width * (size_t)tiff.height * 3;
        unsigned char *pixels = lf_calloc(n + 2, 1);
        snprintf(command, sizeof command, "qpdf --check '%s'", path);
        output_of(command, text, sizeof text);
        assert_non_null(strstr(text, "No syntax or stream encoding errors"));
        snprintf(command, sizeof command, "qpdf --show-object=5 --filtered-stream-data '%s'", path);
        assert_int_equal(output_of(command, (char *)pixels, n + 2), n);
        for (size_t i = 0; i < n; i++)
            assert_int_equal(pixels[i], tiff.value[i]);
        lf_free(pixels);
    }
    if (has_program("pdfinfo")) {
        double trim[4];
        snprintf(command, sizeof command, "pdfinfo -box '%s'", path);
        output_of(command, text, sizeof text);
        assert_non_null(strstr(text, "Pages:           1\n"));
        assert_non_null(strstr(text, "TrimBox:"));
        assert_int_equal(sscanf(strstr(text, "TrimBox:") + 8, "%lf %lf %lf %lf", trim, trim + 1,
                                trim + 2, trim + 3),
                         4);
        lf_assert_close(trim[2] - trim[0], print.width_mm * 72 / 25.4, 0, 0.011);
        lf_assert_close(trim[3] - trim[1], print.height_mm * 72 / 25.4, 0, 0.011);
    }
    if (has_program("pdfimages")) {
        snprintf(command, sizeof command, "pdfimages -list '%s' | grep -c ' image '", path);
        output_of(command, text, sizeof text);
        assert_string_equal(text, "1\n");
    }
    lf_printed_finish(&tiff);
    lf_card_finish(&card);
}

/* ----------------------------------------------------------------------------------- threads -- */

static void assert_same_bytes(const char *a, const char *b)
{
    char *bytes[2];
    size_t size[2];
    lf_error err;
    lf_assert_ok(lf_file_read(a, NULL, 1 << 28, &bytes[0], &size[0], &err), &err);
    lf_assert_ok(lf_file_read(b, NULL, 1 << 28, &bytes[1], &size[1], &err), &err);
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(bytes[0], bytes[1], size[0]);
    lf_free(bytes[0]);
    lf_free(bytes[1]);
}

/* Every way of drawing a row. */
static lf_print way(int i)
{
    lf_print print = lf_print_odd();
    print.height_mm = 12;
    print.horizontal = i == 1;
    print.optics.slant = i == 2 ? 12.0 : 0.0;
    print.optics.grid = i == 3 ? LF_LENS_SQUARE : LF_LENS_LINEAR;
    if (i == 3) {
        print.n_views = 4;
        print.phase_mm = 0.0;
    }
    print.bits = i % 2 ? 16 : 8;
    return print;
}

static void the_bytes_are_those_of_one_thread(void **state)
{
    for (int i = 0; i < 8; i++) {
        lf_print print = way(i % 4);
        lf_print_run run = {.format = i < 4 ? LF_PRINT_TIFF : LF_PRINT_PDF};
        lf_views32 card;
        char alone[PATH_MAX], name[16];
        lf_card_make(&print, lf_card_speckle, NULL, &card);
        snprintf(alone, sizeof alone, "%s", write_print(&print, &card, &run, *state, "alone.bin"));
        for (int threads = 1; threads <= 5; threads += 4) {
            assert_int_equal(lf_pool_create(threads, &run.pool), LF_OK);
            snprintf(name, sizeof name, "%d.bin", threads);
            assert_same_bytes(alone, write_print(&print, &card, &run, *state, name));
            lf_pool_destroy(run.pool);
        }
        lf_card_finish(&card);
    }
}

/* ------------------------------------------------------------------------------------ limits -- */

static lf_status try_to_write(const lf_print *print, const lf_print_run *run, const char *folder,
                              lf_error *err)
{
    static const float grey[3] = {0.5F, 0.5F, 0.5F};
    const lf_views32 views = {1, 1, 1, 3, 3, grey, NULL, NULL, NULL};
    lf_outfile file, manifest;
    lf_assert_ok(lf_outfile_open(&file, lf_test_path(folder, "huge.tif"), true, err), err);
    lf_assert_ok(lf_outfile_open(&manifest, lf_test_path(folder, "huge.json"), true, err), err);
    const lf_status status = lf_print_write(print, &views, run, &file, &manifest, err);
    lf_outfile_abandon(&file);
    lf_outfile_abandon(&manifest);
    return status;
}

static void a_disk_without_room_is_told_before_the_first_row(void **state)
{
    /* 4 TB; a job that starts is cancelled */
    struct statvfs disk;
    lf_cancel cancel = 1;
    lf_print_run run = {.cancel = &cancel};
    lf_print print = lf_print_sound();
    lf_error err;
    print.dpi = 9600;
    print.width_mm = 1000;
    print.height_mm = 5000;
    print.bits = 16;
    assert_int_equal(statvfs(*state, &disk), 0);
    if ((double)disk.f_bavail * (double)disk.f_frsize > 4e12)
        skip();
    assert_int_equal(try_to_write(&print, &run, *state, &err), LF_E_IO);
    assert_non_null(strstr(err.what, "needs 4.29e+03 GB, but "));
    assert_int_equal(
        lf_print_check_room(&print, LF_PRINT_TIFF, lf_test_path(*state, "a.tif"), &err), LF_E_IO);
    /* a tenth, and little */
    print.compress = LF_COMPRESS_LZW;
    assert_int_equal(
        lf_print_check_room(&print, LF_PRINT_TIFF, lf_test_path(*state, "a.tif"), &err), LF_E_IO);
    assert_non_null(strstr(err.what, "needs 429 GB"));
    /* all copies, and all frames of a set, whose folder is not there yet */
    print.width_mm = print.height_mm = 30;
    print.bleed_mm = 0;
    print.compress = LF_COMPRESS_NONE;
    print.sheet.columns = print.sheet.rows = 100;
    assert_int_equal(
        lf_print_check_room(&print, LF_PRINT_TIFF, lf_test_path(*state, "a.tif"), &err), LF_E_IO);
    print.sheet = (lf_print_sheet){0};
    lf_print frames = print;
    frames.frame_ppi = 600;
    frames.width_mm = frames.height_mm = 1000;
    frames.n_views = 1920;
    assert_int_equal(lf_print_check_room(&frames, LF_PRINT_TIFF, lf_test_path(*state, "f/"), &err),
                     LF_E_IO);
    assert_non_null(strstr(err.what, "needs 6.43e+03 GB"));
    print.width_mm = print.height_mm = 1;
    lf_assert_ok(lf_print_check_room(&print, LF_PRINT_TIFF, lf_test_path(*state, "a.tif"), &err),
                 &err);
}

static void what_pdf_cannot_hold_is_refused(void **state)
{
    lf_cancel cancel = 1;
    const lf_print_run run = {.format = LF_PRINT_PDF, .cancel = &cancel};
    lf_print print = lf_print_sound();
    lf_error err;
    print.width_mm = 5000;
    print.bleed_mm = 41;
    assert_int_equal(try_to_write(&print, &run, *state, &err), LF_E_ARG);
    assert_non_null(strstr(err.what, "a PDF page is 1.1 to 5080 mm long, not 5082 mm"));
    print.bleed_mm = 0;
    print.height_mm = 2000;
    assert_int_equal(try_to_write(&print, &run, *state, &err), LF_E_ARG);
    assert_non_null(strstr(err.what, "a PDF file holds 10"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_test_in_folder(a_pdf_has_the_pixels_of_the_tiff_in_their_exact_place),
        lf_test_in_folder(a_cmyk_print_tells_its_ink),
        lf_test_in_folder(programs_of_others_read_it),
        lf_test_in_folder(the_bytes_are_those_of_one_thread),
        lf_test_in_folder(a_disk_without_room_is_told_before_the_first_row),
        lf_test_in_folder(what_pdf_cannot_hold_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
