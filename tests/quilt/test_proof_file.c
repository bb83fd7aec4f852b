/* Prints read back as a printer would get them: tags, rows and light of every kind of file, and
 * what is said of files that are damaged or of another kind. */
#include "tests/testing.h"

#include <jansson.h>
#include <lcms2.h>
#include <tiffio.h>

#include "base/alloc.h"
#include "base/file.h"
#include "quilt/proof/print_file.h"
#include "tests/quilt/printed.h"

static const char *folder;

static int make_folder(void **state)
{
    (void)state;
    folder = lf_test_folder();
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    lf_test_folder_remove((char *)(uintptr_t)folder);
    return 0;
}

static const char *write_bytes(const char *name, const void *bytes, size_t n)
{
    const char *path = lf_test_path(folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, n, file), n);
    fclose(file);
    return path;
}

static lf_printed printed_of(const lf_print *print)
{
    lf_printed printed;
    lf_views32 views;
    lf_card_make(print, lf_card_speckle, NULL, &views);
    lf_printed_make(print, &views, 0, &printed);
    lf_card_finish(&views);
    return printed;
}

/* -------------------------------------------------------------------------------- our prints -- */

static void assert_row(lf_print_file *file, const lf_printed *printed, int y)
{
    const size_t n = 3 * (size_t)printed->width;
    float *light = lf_calloc(n, sizeof *light);
    uint16_t *raw = lf_calloc(n, sizeof *raw);
    lf_error err;
    lf_assert_ok(lf_print_file_raw(file, y, raw, &err), &err);
    lf_assert_ok(lf_print_file_row(file, y, light, &err), &err);
    for (int x = 0; x < printed->width; x++)
        for (int c = 0; c < 3; c++) {
            const size_t i = 3 * (size_t)x + (size_t)c;
            assert_int_equal(printed->bits == 16 ? raw[i] : ((uint8_t *)raw)[i],
                             lf_printed_at(printed, x, y, c));
            lf_assert_close((double)light[i], lf_printed_linear(printed, x, y, c), 1e-3, 2e-4);
        }
    lf_free(light);
    lf_free(raw);
}

static void reads_every_file_that_is_written(void **state)
{
    (void)state;
    static const int schemes[] = {1, 5, 8};
    for (int kind = 0; kind < 6; kind++) {
        lf_print print = lf_print_odd();
        lf_print_file *file;
        lf_error err;
        print.bits = kind % 2 ? 16 : 8;
        print.compress = (lf_compress)(kind / 2);
        print.dpi = 812.8;
        print.dpi_down = 600;
        lf_printed printed = printed_of(&print);
        const char *path = write_bytes("print.tif", printed.file, printed.file_size);
        lf_assert_ok(lf_print_file_open(path, NULL, &file, &err), &err);
        const lf_print_tags *tags = lf_print_file_tags(file);
        assert_int_equal(tags->width, printed.width);
        assert_int_equal(tags->height, printed.height);
        assert_int_equal(tags->bits, print.bits);
        assert_int_equal(tags->samples, 3);
        assert_int_equal(tags->photometric, 2);
        assert_int_equal(tags->compression, schemes[print.compress]);
        assert_int_equal(tags->predictor, print.compress == LF_COMPRESS_NONE ? 1 : 2);
        assert_int_equal(tags->orientation, 1);
        assert_int_equal(tags->unit, 2);
        assert_int_equal(tags->resolution[0][0], 4064);
        assert_int_equal(tags->resolution[0][1], 5);
        assert_int_equal(tags->resolution[1][0], 600);
        assert_int_equal(tags->resolution[1][1], 1);
        assert_true(tags->dpi[0] == 4064.0 / 5 && tags->dpi[1] == 600);
        assert_false(tags->big || tags->big_endian || tags->more_pages || tags->tiled);
        assert_null(lf_print_file_unreadable(file));
        assert_null(lf_print_file_profile_problem(file));
        assert_int_equal(tags->file_bytes, printed.file_size);
        for (int y = 0; y < printed.height; y++)
            assert_row(file, &printed, y);
        assert_row(file, &printed, 0); /* any order */
        assert_row(file, &printed, printed.height / 2);
        lf_print_file_close(file);
        lf_printed_finish(&printed);
    }
}

/* --------------------------------------------------------------------------- files of others -- */

typedef struct other {
    const char *mode;
    int photometric, samples, bits, compression, planar, extra, unit;
    bool tiled;
    const char *unreadable; /* a part of what is said; NULL: rows can be read */
    double dpi;             /* 0: 200 */
} other;

/* Row y holds y + 10 c + x. */
static void fill_row(uint8_t *row, int y, const other *o)
{
    for (int i = 0; i < 32 * o->samples; i++)
        if (o->bits == 16)
            ((uint16_t *)(void *)row)[i] = (uint16_t)(1000 * y + i);
        else
            row[i] = (uint8_t)(10 * y + i);
}

static const char *write_other(const other *o)
{
    const char *path = lf_test_path(folder, "other.tif");
    TIFF *tiff = TIFFOpen(path, o->mode);
    uint8_t row[32 * 32 * 4 * 2];
    assert_non_null(tiff);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 32);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 16);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, o->samples);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, o->bits);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, o->photometric);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, o->compression);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, o->planar);
    TIFFSetField(tiff, TIFFTAG_XRESOLUTION, o->dpi > 0 ? o->dpi : 200.0);
    TIFFSetField(tiff, TIFFTAG_YRESOLUTION, 100.0);
    TIFFSetField(tiff, TIFFTAG_RESOLUTIONUNIT, o->unit);
    if (o->extra)
        TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, (uint16_t[]){2});
    if (o->tiled) {
        TIFFSetField(tiff, TIFFTAG_TILEWIDTH, 32);
        TIFFSetField(tiff, TIFFTAG_TILELENGTH, 16);
        memset(row, 0, sizeof row);
        assert_true(TIFFWriteTile(tiff, row, 0, 0, 0, 0) > 0);
    } else {
        TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 16);
        for (int plane = 0; plane < (o->planar == 2 ? o->samples : 1); plane++)
            for (int y = 0; y < 16; y++) {
                fill_row(row, y, o);
                assert_int_equal(TIFFWriteScanline(tiff, row, (uint32_t)y, (uint16_t)plane), 1);
            }
    }
    TIFFClose(tiff);
    return path;
}

/* Pixels larger than an inch, and resolutions that no printer has, are taken as unknown. */
static void resolutions_that_no_printer_has_are_unknown(void **state)
{
    (void)state;
    static const struct {
        double dpi, expected;
    } rows[] = {{0.0001, 0}, {0.99, 0}, {1, 1}, {100000, 100000}, {150000, 0}, {4e9, 0}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const other plain = {"w", 2, 3, 8, 1, 1, 0, 2, false, NULL, rows[i].dpi};
        lf_print_file *file;
        lf_error err;
        lf_assert_ok(lf_print_file_open(write_other(&plain), NULL, &file, &err), &err);
        lf_assert_close(lf_print_file_tags(file)->dpi[0], rows[i].expected, 0, 1e-6);
        lf_print_file_close(file);
    }
}

static void assert_other(const other *o)
{
    const char *path = write_other(o);
    lf_print_file *file;
    uint8_t row[32 * 4 * 2], expected[32 * 4 * 2];
    float light[32 * 3];
    lf_error err;
    lf_assert_ok(lf_print_file_open(path, NULL, &file, &err), &err);
    const lf_print_tags *tags = lf_print_file_tags(file);
    assert_int_equal(tags->big, strchr(o->mode, '8') ? 1 : 0);
    assert_int_equal(tags->big_endian, strchr(o->mode, 'b') ? 1 : 0);
    assert_true(tags->dpi[0] == (o->unit == 3 ? 508.0 : o->unit == 2 ? 200.0 : 0.0));
    assert_true(tags->dpi[1] == (o->unit == 3 ? 254.0 : o->unit == 2 ? 100.0 : 0.0));
    if (o->unreadable) {
        assert_non_null(strstr(lf_print_file_unreadable(file), o->unreadable));
        lf_assert_status(lf_print_file_row(file, 0, light, &err), LF_E_FORMAT, &err);
        assert_non_null(strstr(err.what, o->unreadable));
    } else {
        assert_null(lf_print_file_unreadable(file));
        assert_non_null(lf_print_file_profile_problem(file));
        fill_row(expected, 9, o);
        lf_assert_ok(lf_print_file_raw(file, 9, row, &err), &err);
        assert_memory_equal(row, expected, lf_print_file_raw_bytes(file));
    }
    lf_print_file_close(file);
}

static void reads_files_of_other_programs_or_names_what_it_cannot_read(void **state)
{
    (void)state;
    static const other others[] = {
        {"wl8", 2, 3, 8, 1, 1, 0, 2, false, NULL, 0},
        {"wb", 2, 3, 16, 1, 1, 0, 3, false, NULL, 0},
        {"wb8", 5, 4, 16, 8, 1, 0, 1, false, NULL, 0},
        {"wb", 5, 4, 8, 5, 1, 0, 2, false, NULL, 0},
        {"wl", 5, 4, 16, 1, 1, 0, 2, false, NULL, 0},
        {"wl", 2, 3, 8, 7, 1, 0, 2, false, "JPEG", 0},
        {"wl", 2, 4, 8, 1, 1, 1, 2, false, "alpha", 0},
        {"wl", 1, 1, 8, 1, 1, 0, 2, false, "colour space", 0},
        {"wl", 2, 3, 8, 1, 2, 0, 2, false, "plane per channel", 0},
        {"wl", 2, 3, 8, 1, 1, 0, 2, true, "tiles", 0},
        {"wl", 2, 3, 8, 32773, 1, 0, 2, false, "compression other", 0},
        {"wl", 2, 4, 8, 1, 1, 0, 2, false, "number of channels", 0},
    };
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        assert_other(&others[i]);
}

static void cmyk_without_a_profile_is_ideal_inks(void **state)
{
    (void)state;
    lf_print_file *file;
    lf_error err;
    float light[6];
    const uint8_t pixels[8] = {0, 0, 0, 0, 255, 51, 0, 51};
    lf_assert_ok(
        lf_print_file_open(write_other(&(other){"wl", 5, 4, 8, 1, 1, 0, 2, false, NULL, 0}), NULL,
                           &file, &err),
        &err);
    lf_print_file_light(file, pixels, 2, light);
    const double expected[6] = {1, 1, 1, 0, 0.64, 0.8};
    for (int i = 0; i < 6; i++)
        lf_assert_close((double)light[i], expected[i], 0, 1e-6);
    lf_print_file_close(file);
}

/* ---------------------------------------------------------------------------------- profiles -- */

static const char *save_profile(const char *name, cmsHPROFILE profile)
{
    const char *path = lf_test_path(folder, name);
    assert_true(cmsSaveProfileToFile(profile, path));
    cmsCloseProfile(profile);
    return path;
}

/* Wider primaries and a power of 2.2. */
static const char *wide_rgb(void)
{
    const cmsCIExyY white = {0.3127, 0.3290, 1.0};
    const cmsCIExyYTRIPLE primaries = {{0.64, 0.33, 1.0}, {0.21, 0.71, 1.0}, {0.15, 0.06, 1.0}};
    cmsToneCurve *curve = cmsBuildGamma(NULL, 2.2);
    cmsToneCurve *curves[3] = {curve, curve, curve};
    cmsHPROFILE profile = cmsCreateRGBProfile(&white, &primaries, curves);
    cmsFreeToneCurve(curve);
    return save_profile("wide.icc", profile);
}

static void a_wide_rgb_profile_is_undone(void **state)
{
    (void)state;
    lf_print print = lf_print_sound();
    lf_print_file *file;
    lf_error err;
    print.width_mm = 10;
    print.bits = 16;
    lf_printed plain = printed_of(&print);
    print.icc_path = wide_rgb();
    lf_printed wide = printed_of(&print);
    assert_int_not_equal(lf_printed_at(&plain, 9, 3, 0), lf_printed_at(&wide, 9, 3, 0));
    lf_assert_ok(
        lf_print_file_open(write_bytes("wide.tif", wide.file, wide.file_size), NULL, &file, &err),
        &err);
    assert_null(lf_print_file_profile_problem(file));
    float *light = lf_calloc((size_t)wide.width, 3 * sizeof *light);
    lf_assert_ok(lf_print_file_row(file, 3, light, &err), &err);
    for (int i = 0; i < 3 * wide.width; i++)
        lf_assert_close((double)light[i], lf_printed_linear(&plain, i / 3, 3, i % 3), 2e-3, 5e-4);
    lf_free(light);
    lf_print_file_close(file);
    lf_printed_finish(&plain);
    lf_printed_finish(&wide);
}

/* The Lab colour of ideal inks whose cyan takes half of the red light only. */
static cmsInt32Number ink_to_lab(const cmsUInt16Number in[], cmsUInt16Number out[], void *context)
{
    float light[3];
    for (int k = 0; k < 3; k++)
        light[k] = (1.0F - (k == 0 ? 0.5F : 1.0F) * (float)in[k] / 65535.0F) *
                   (1.0F - (float)in[3] / 65535.0F);
    cmsDoTransform(context, light, out, 1);
    return 1;
}

static cmsHPROFILE ink_profile(void)
{
    const cmsCIExyY white = {0.3127, 0.3290, 1.0};
    const cmsCIExyYTRIPLE primaries = {{0.64, 0.33, 1.0}, {0.30, 0.60, 1.0}, {0.15, 0.06, 1.0}};
    cmsToneCurve *line = cmsBuildGamma(NULL, 1.0);
    cmsToneCurve *lines[3] = {line, line, line};
    cmsHPROFILE scene = cmsCreateRGBProfile(&white, &primaries, lines),
                lab = cmsCreateLab2Profile(NULL), ink = cmsCreateProfilePlaceholder(NULL);
    cmsHTRANSFORM to_lab = cmsCreateTransform(scene, TYPE_RGB_FLT, lab, TYPE_LabV2_16,
                                              INTENT_RELATIVE_COLORIMETRIC, cmsFLAGS_NOOPTIMIZE);
    cmsPipeline *pipeline = cmsPipelineAlloc(NULL, 4, 3);
    cmsStage *table = cmsStageAllocCLut16bit(NULL, 17, 4, 3, NULL);
    assert_true(cmsStageSampleCLut16bit(table, ink_to_lab, to_lab, 0));
    cmsSetProfileVersion(ink, 2.1);
    cmsSetDeviceClass(ink, cmsSigOutputClass);
    cmsSetColorSpace(ink, cmsSigCmykData);
    cmsSetPCS(ink, cmsSigLabData);
    assert_true(cmsPipelineInsertStage(pipeline, cmsAT_END, table));
    assert_true(cmsWriteTag(ink, cmsSigAToB0Tag, pipeline));
    cmsPipelineFree(pipeline);
    cmsDeleteTransform(to_lab);
    cmsCloseProfile(scene);
    cmsCloseProfile(lab);
    cmsFreeToneCurve(line);
    return ink;
}

static void a_printers_profile_is_read_through_its_table(void **state)
{
    (void)state;
    char *icc = NULL;
    size_t size = 0;
    lf_print_file *file;
    lf_error err;
    float light[9];
    const uint8_t pixels[12] = {0, 0, 0, 0, 255, 0, 0, 0, 0, 0, 0, 255};
    lf_assert_ok(
        lf_file_read(save_profile("ink.icc", ink_profile()), NULL, 1 << 24, &icc, &size, &err),
        &err);
    const char *path = write_other(&(other){"wl", 5, 4, 8, 1, 1, 0, 2, false, NULL, 0});
    TIFF *tiff = TIFFOpen(path, "r+");
    assert_non_null(tiff);
    TIFFSetField(tiff, TIFFTAG_ICCPROFILE, (uint32_t)size, icc);
    assert_true(TIFFRewriteDirectory(tiff));
    TIFFClose(tiff);
    lf_assert_ok(lf_print_file_open(path, NULL, &file, &err), &err);
    assert_null(lf_print_file_profile_problem(file));
    lf_print_file_light(file, pixels, 3, light);
    const double expected[9] = {1, 1, 1, 0.5, 1, 1, 0, 0, 0};
    for (int i = 0; i < 9; i++)
        lf_assert_close((double)light[i], expected[i], 0, 0.01);
    lf_print_file_close(file);
    lf_free(icc);
}

/* ----------------------------------------------------------------------------- damaged files -- */

/* Opens and reads all rows; errors have a text. True: no error. */
static bool survives(const char *path)
{
    lf_print_file *file;
    lf_error err = {0};
    lf_status status = lf_print_file_open(path, NULL, &file, &err);
    if (status != LF_OK) {
        assert_true(err.what[0] != '\0');
        return false;
    }
    const lf_print_tags *tags = lf_print_file_tags(file);
    float *row = lf_calloc((size_t)tags->width, 3 * sizeof *row);
    assert_non_null(row);
    for (int y = 0; y < tags->height && status == LF_OK; y++)
        status = lf_print_file_row(file, y, row, &err);
    assert_true(status == LF_OK || err.what[0] != '\0');
    lf_free(row);
    lf_print_file_close(file);
    return status == LF_OK;
}

static void damaged_files_are_refused_in_words(void **state)
{
    (void)state;
    for (int compress = 0; compress < 3; compress++) {
        lf_print print = lf_print_sound();
        print.width_mm = 3;
        print.height_mm = 1;
        print.compress = (lf_compress)compress;
        lf_printed printed = printed_of(&print);
        assert_true(survives(write_bytes("whole.tif", printed.file, printed.file_size)));
        for (size_t n = 0; n < printed.file_size; n += 97)
            assert_false(survives(write_bytes("cut.tif", printed.file, n)));
        for (size_t at = 0; at < printed.file_size; at += 41) {
            const uint8_t was = printed.file[at];
            printed.file[at] = (uint8_t)~was;
            survives(write_bytes("spoilt.tif", printed.file, printed.file_size));
            printed.file[at] = was;
        }
        lf_printed_finish(&printed);
    }
}

/* The value field of a tag in a classic little-endian file. */
static uint8_t *value_of(lf_printed *printed, int tag)
{
    uint8_t *file = printed->file;
    uint8_t *at = file + (file[4] | file[5] << 8 | file[6] << 16);
    const int n = at[0] | at[1] << 8;
    for (at += 2; at < file + printed->file_size && at[0] + 256 * at[1] != tag; at += 12)
        assert_true(at < file + printed->file_size - 12 && n > 0);
    return at + 8;
}

static void assert_refused(int tag, uint32_t value, const char *what)
{
    lf_print print = lf_print_sound();
    lf_print_file *file;
    lf_error err;
    lf_printed printed = printed_of(&print);
    uint8_t *field = value_of(&printed, tag);
    for (int i = 0; i < 4; i++)
        field[i] = (uint8_t)(value >> 8 * i);
    field[-6] = 4; /* a long */
    lf_assert_status(lf_print_file_open(write_bytes("lie.tif", printed.file, printed.file_size),
                                        NULL, &file, &err),
                     LF_E_FORMAT, &err);
    if (!strstr(err.what, what))
        fail_msg("%s", err.what);
    lf_printed_finish(&printed);
}

static void files_that_lie_about_their_size_are_refused(void **state)
{
    (void)state;
    assert_refused(256, 0, "no size");
    assert_refused(256, 2000000, "shorter than its pixels");
    assert_refused(256, 3000000000U, "no printer takes it");
    assert_refused(257, 2000000, "shorter than its pixels");
    assert_refused(278, 1, "number of its strips");
    assert_refused(277, 0, "its samples");
    lf_print_file *file;
    lf_error err;
    lf_assert_status(lf_print_file_open(write_bytes("x.tif", "GIF89a..", 8), NULL, &file, &err),
                     LF_E_FORMAT, &err);
    assert_non_null(strstr(err.what, "not a TIFF"));
    lf_assert_status(lf_print_file_open(lf_test_path(folder, "none.tif"), NULL, &file, &err),
                     LF_E_IO, &err);
}

/* ---------------------------------------------------------------------------------- manifest -- */

static void the_manifest_lies_beside_the_print(void **state)
{
    (void)state;
    const char *print = lf_test_path(folder, "a.b.tif");
    json_t *manifest = (json_t *)&manifest;
    lf_error err;
    lf_assert_ok(lf_print_file_manifest(print, NULL, &manifest, &err), &err);
    assert_null(manifest);
    write_bytes("a.b.json", "{\"quiltd_print\": 1, \"lens\": {}}", 31);
    lf_assert_ok(lf_print_file_manifest(print, NULL, &manifest, &err), &err);
    assert_int_equal(json_integer_value(json_object_get(manifest, "quiltd_print")), 1);
    json_decref(manifest);
    write_bytes("a.b.json", "{\"quiltd\": 1}", 13);
    lf_assert_status(lf_print_file_manifest(print, NULL, &manifest, &err), LF_E_FORMAT, &err);
    write_bytes("a.b.json", "[[", 2);
    lf_assert_status(lf_print_file_manifest(print, NULL, &manifest, &err), LF_E_FORMAT, &err);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_every_file_that_is_written),
        cmocka_unit_test(reads_files_of_other_programs_or_names_what_it_cannot_read),
        cmocka_unit_test(resolutions_that_no_printer_has_are_unknown),
        cmocka_unit_test(cmyk_without_a_profile_is_ideal_inks),
        cmocka_unit_test(a_wide_rgb_profile_is_undone),
        cmocka_unit_test(a_printers_profile_is_read_through_its_table),
        cmocka_unit_test(damaged_files_are_refused_in_words),
        cmocka_unit_test(files_that_lie_about_their_size_are_refused),
        cmocka_unit_test(the_manifest_lies_beside_the_print),
    };
    return cmocka_run_group_tests_name("prints read back", tests, make_folder, remove_folder);
}
