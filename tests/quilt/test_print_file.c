/* The file of a print: its bytes, tags, colours and manifest, and what stands in the way of writing
 * it. */
#include "tests/testing.h"

#include <fcntl.h>
#include <lcms2.h>
#include <nettle/sha2.h>
#include <signal.h>
#include <sys/resource.h>

#include "base/alloc.h"
#include "quilt/print/print.h"
#include "tests/quilt/printed.h"

/* --------------------------------------------------------------------------- the file itself -- */

static uint32_t little(const uint8_t *p, int n)
{
    uint32_t v = 0;
    for (int i = n - 1; i >= 0; i--)
        v = v << 8 | p[i];
    return v;
}

/* The 12 bytes of a tag in a classic little-endian TIFF, found by hand; NULL when absent. */
static const uint8_t *tag_of(const lf_printed *printed, uint32_t tag)
{
    const uint8_t *file = printed->file;
    assert_memory_equal(file, "II*\0", 4);
    const uint8_t *directory = file + little(file + 4, 4);
    for (uint32_t i = 0; i < little(directory, 2); i++)
        if (little(directory + 2 + 12 * i, 2) == tag)
            return directory + 2 + 12 * i;
    return NULL;
}

static uint32_t short_tag(const lf_printed *printed, uint32_t tag)
{
    const uint8_t *entry = tag_of(printed, tag);
    assert_non_null(entry);
    return little(entry + 8, little(entry + 2, 2) == 3 && little(entry + 4, 4) == 1 ? 2 : 4);
}

static void assert_rational(const lf_printed *printed, uint32_t tag, uint32_t numerator)
{
    const uint8_t *entry = tag_of(printed, tag);
    assert_non_null(entry);
    assert_int_equal(little(entry + 2, 2), 5);
    assert_int_equal(little(entry + 4, 4), 1);
    const uint8_t *value = printed->file + little(entry + 8, 4);
    assert_int_equal(little(value, 4), numerator);
    assert_int_equal(little(value + 4, 4), 1);
}

static void assert_tags(const lf_print *print, const lf_printed *printed)
{
    static const uint32_t schemes[] = {1, 5, 8};
    assert_rational(printed, 282, (uint32_t)print->dpi);
    assert_rational(printed, 283, (uint32_t)print->dpi);
    assert_int_equal(short_tag(printed, 296), 2); /* inch */
    assert_int_equal(short_tag(printed, 274), 1); /* top left */
    assert_int_equal(short_tag(printed, 262), 2); /* RGB */
    assert_int_equal(short_tag(printed, 284), 1); /* one plane */
    assert_int_equal(short_tag(printed, 277), 3);
    assert_int_equal(short_tag(printed, 259), schemes[print->compress]);
    if (print->compress == LF_COMPRESS_NONE)
        assert_null(tag_of(printed, 317));
    else
        assert_int_equal(short_tag(printed, 317), 2);
    assert_int_equal(printed->bits, print->bits);
    assert_null(tag_of(printed, 306)); /* no date */
    const uint8_t *icc = tag_of(printed, 34675);
    assert_non_null(icc);
    cmsHPROFILE profile =
        cmsOpenProfileFromMem(printed->file + little(icc + 8, 4), little(icc + 4, 4));
    assert_non_null(profile);
    assert_int_equal(cmsGetColorSpace(profile), cmsSigRgbData);
    cmsCloseProfile(profile);
}

static void tags_are_exact_and_all_compressions_hold_the_same_picture(void **state)
{
    (void)state;
    static const int rasters[] = {600, 720, 1440, 301};
    for (int i = 0; i < 8; i++) {
        lf_print print = lf_print_sound();
        lf_views32 card;
        lf_printed plain = {0};
        print.bits = i % 2 ? 16 : 8;
        print.dpi = rasters[i / 2];
        print.n_views = 4;
        lf_card_make(&print, lf_card_speckle, NULL, &card);
        for (int compress = 0; compress < 3; compress++) {
            lf_printed printed;
            print.compress = (lf_compress)compress;
            lf_printed_make(&print, &card, 0, &printed);
            assert_tags(&print, &printed);
            if (compress == 0) {
                plain = printed;
            } else {
                lf_printed_assert_same(&plain, &printed);
                lf_printed_finish(&printed);
            }
        }
        lf_printed_finish(&plain);
        lf_card_finish(&card);
    }
}

static void the_same_print_twice_is_the_same_file_and_strips_do_not_matter(void **state)
{
    (void)state;
    static const int heights[] = {1, 7, 64};
    for (int horizontal = 0; horizontal < 2; horizontal++) {
        lf_print print = lf_print_odd();
        lf_views32 card;
        lf_printed a, b;
        print.horizontal = horizontal == 1;
        print.compress = LF_COMPRESS_DEFLATE;
        lf_card_make(&print, lf_card_speckle, NULL, &card);
        lf_printed_make(&print, &card, 0, &a);
        lf_printed_make(&print, &card, 0, &b);
        assert_int_equal(a.file_size, b.file_size);
        assert_memory_equal(a.file, b.file, a.file_size);
        lf_printed_finish(&b);
        for (size_t h = 0; h < sizeof heights / sizeof heights[0]; h++) {
            lf_printed_make(&print, &card, heights[h], &b);
            lf_printed_assert_same(&a, &b);
            lf_printed_finish(&b);
        }
        lf_printed_finish(&a);
        lf_card_finish(&card);
    }
}

/* Sizes of two strips are as long as a resolution, and here have its value. */
static void sizes_of_strips_are_not_taken_for_a_resolution(void **state)
{
    (void)state;
    lf_print print = lf_print_sound();
    lf_views32 card;
    lf_printed whole, halves;
    print.dpi = 60;
    print.lpi = 20;
    print.n_views = 2;
    print.height_mm = 61 / 60.0 * 25.4;
    lf_card_make(&print, lf_card_speckle, NULL, &card);
    lf_printed_make(&print, &card, 0, &whole);
    lf_printed_make(&print, &card, 60, &halves);
    assert_int_equal(whole.height, 61);
    lf_printed_assert_same(&whole, &halves);
    lf_printed_finish(&whole);
    lf_printed_finish(&halves);
    lf_card_finish(&card);
}

static void a_raster_that_may_pass_4_gib_is_a_big_tiff(void **state)
{
    (void)state;
    lf_print print = lf_print_sound();
    lf_print_colour *colour = NULL;
    lf_error err;
    lf_assert_ok(lf_print_colour_create(&print, &colour, &err), &err);
    for (int big = 0; big < 2; big++) {
        char *folder = lf_test_folder();
        lf_outfile file;
        lf_print_tiff *tiff = NULL;
        char head[4];
        const lf_print_page page = {
            .print = &print, .width = big ? 40000 : 20000, .height = 40000, .description = "big"};
        lf_assert_ok(lf_outfile_open(&file, lf_test_path(folder, "big.tif"), false, &err), &err);
        lf_assert_ok(lf_print_tiff_open(&file, &page, colour, 0, &tiff, &err), &err);
        lf_print_tiff_abandon(tiff);
        assert_int_equal(pread(file.fd, head, 4, 0), 4);
        assert_memory_equal(head, big ? "II+\0" : "II*\0", 4);
        lf_outfile_abandon(&file);
        lf_test_folder_remove(folder);
    }
    lf_print_colour_destroy(colour);
}

static void the_manifest_tells_what_was_printed(void **state)
{
    (void)state;
    lf_print print = lf_print_odd();
    lf_views32 card;
    lf_printed printed;
    struct sha256_ctx hash;
    uint8_t digest[SHA256_DIGEST_SIZE];
    char hex[2 * SHA256_DIGEST_SIZE + 1];
    print.parallax_lenses = 1.5;
    lf_card_make(&print, lf_card_speckle, NULL, &card);
    lf_printed_make(&print, &card, 0, &printed);
    sha256_init(&hash);
    sha256_update(&hash, printed.file_size, printed.file);
    sha256_digest(&hash, sizeof digest, digest);
    for (size_t i = 0; i < sizeof digest; i++)
        snprintf(hex + 2 * i, 3, "%02x", digest[i]);
    const json_t *file = json_object_get(printed.manifest, "file");
    assert_string_equal(json_string_value(json_object_get(file, "sha256")), hex);
    assert_string_equal(json_string_value(json_object_get(file, "name")), "print.tif");
    assert_int_equal(json_integer_value(json_object_get(file, "bytes")), printed.file_size);
    const json_t *lens = json_object_get(printed.manifest, "lens");
    assert_true(json_real_value(json_object_get(lens, "lpi")) == 61.37);
    lf_assert_close(json_real_value(json_object_get(lens, "pitch_mm")), 25.4 / 61.37, 1e-14, 0.0);
    assert_true(json_real_value(json_object_get(lens, "phase_mm")) == 0.17);
    assert_string_equal(json_string_value(json_object_get(lens, "orientation")), "vertical");
    const json_t *order = json_object_get(json_object_get(printed.manifest, "stripes"), "order");
    for (int m = 0; m < 7; m++)
        assert_int_equal(json_integer_value(json_array_get(order, (size_t)m)), 6 - m);
    assert_false(
        json_is_true(json_object_get(json_object_get(printed.manifest, "source"), "resampled")));
    assert_non_null(
        strstr(json_string_value(json_object_get(printed.manifest, "print_at")), "100 %"));
    assert_int_equal(json_array_size(json_object_get(printed.manifest, "warnings")), 1);
    lf_printed_finish(&printed);
    lf_card_finish(&card);
}

/* ---------------------------------------------------------------------------------- profiles -- */

static const char *save_profile(const char *folder, const char *name, cmsHPROFILE profile)
{
    const char *path = lf_test_path(folder, name);
    assert_non_null(profile);
    assert_true(cmsSaveProfileToFile(profile, path));
    cmsCloseProfile(profile);
    return path;
}

static cmsHPROFILE wide_profile(void)
{
    const cmsCIExyY white = {0.3127, 0.3290, 1.0};
    const cmsCIExyYTRIPLE primaries = {{0.64, 0.33, 1.0}, {0.21, 0.71, 1.0}, {0.15, 0.06, 1.0}};
    cmsToneCurve *curve = cmsBuildGamma(NULL, 2.19921875);
    cmsToneCurve *curves[3] = {curve, curve, curve};
    cmsHPROFILE profile = cmsCreateRGBProfile(&white, &primaries, curves);
    cmsFreeToneCurve(curve);
    return profile;
}

static void colours_are_converted_to_a_given_rgb_profile(void **state)
{
    (void)state;
    char *folder = lf_test_folder();
    lf_print print = lf_print_sound();
    lf_views32 card;
    lf_printed plain, same, wide;
    static const float colours[12] = {0.0F, 1.0F, 0.0F, 1.0F, 1.0F, 1.0F,
                                      0.0F, 0.0F, 0.0F, 0.2F, 0.2F, 0.2F};
    const lf_views32 pure = {4, 1, 1, 3, 3, colours, NULL, NULL, NULL};
    print.bits = 16;
    lf_card_make(&print, lf_card_speckle, NULL, &card);
    lf_printed_make(&print, &card, 0, &plain);
    print.icc_path = save_profile(folder, "srgb.icc", cmsCreate_sRGBProfile());
    lf_printed_make(&print, &card, 0, &same);
    for (int i = 0; i < plain.width * plain.height * 3; i++)
        /* the profile's numbers have 16 bits themselves */
        assert_true(abs(plain.value[i] - same.value[i]) <= 24);
    print.icc_path = save_profile(folder, "wide.icc", wide_profile());
    print.n_views = 4;
    print.stripes = LF_STRIPES_NEAREST;
    lf_printed_make(&print, &pure, 0, &wide);
    /* middle of the middle lens's stripes, from view 3 to view 0 */
    const int x[4] = {600 + 3, 600 + 1, 600 - 1, 600 - 4};
    /* sRGB's green is no pure green of the wide space */
    assert_true(lf_printed_at(&wide, x[0], 0, 0) > 30000);
    assert_true(lf_printed_at(&wide, x[0], 0, 1) > 64000);
    for (int c = 0; c < 3; c++) {
        assert_true(lf_printed_at(&wide, x[1], 0, c) >= 65500);
        assert_true(lf_printed_at(&wide, x[2], 0, c) <= 30);
        lf_assert_close(lf_printed_at(&wide, x[3], 0, c) / 65535.0, pow(0.2, 1.0 / 2.19921875), 0.0,
                        2e-3);
    }
    lf_printed_finish(&plain);
    lf_printed_finish(&same);
    lf_printed_finish(&wide);
    lf_card_finish(&card);
    lf_test_folder_remove(folder);
}

/* Ink from Lab: black alone, as much as L* is dark; and Lab from ink for the way back. */
static cmsInt32Number ink_of_lab(const cmsUInt16Number in[], cmsUInt16Number out[], void *context)
{
    (void)context;
    out[0] = out[1] = out[2] = 0;
    out[3] = (cmsUInt16Number)(65535 - in[0]);
    return 1;
}

static cmsInt32Number lab_of_ink(const cmsUInt16Number in[], cmsUInt16Number out[], void *context)
{
    (void)context;
    out[0] = (cmsUInt16Number)(65535 - in[3]);
    out[1] = out[2] = 0x8080;
    return 1;
}

static void write_lut(cmsHPROFILE profile, cmsTagSignature tag, cmsUInt32Number n_in,
                      cmsUInt32Number n_out, cmsSAMPLER16 sampler)
{
    cmsPipeline *pipeline = cmsPipelineAlloc(NULL, n_in, n_out);
    cmsStage *lut = cmsStageAllocCLut16bit(NULL, 9, n_in, n_out, NULL);
    assert_true(cmsStageSampleCLut16bit(lut, sampler, NULL, 0));
    cmsPipelineInsertStage(pipeline, cmsAT_BEGIN, cmsStageAllocToneCurves(NULL, n_in, NULL));
    cmsPipelineInsertStage(pipeline, cmsAT_END, lut);
    cmsPipelineInsertStage(pipeline, cmsAT_END, cmsStageAllocToneCurves(NULL, n_out, NULL));
    assert_true(cmsWriteTag(profile, tag, pipeline));
    cmsPipelineFree(pipeline);
}

static cmsHPROFILE ink_profile(void)
{
    cmsHPROFILE profile = cmsCreateProfilePlaceholder(NULL);
    cmsSetProfileVersion(profile, 4.3);
    cmsSetDeviceClass(profile, cmsSigOutputClass);
    cmsSetColorSpace(profile, cmsSigCmykData);
    cmsSetPCS(profile, cmsSigLabData);
    write_lut(profile, cmsSigAToB0Tag, 4, 3, lab_of_ink);
    write_lut(profile, cmsSigBToA0Tag, 3, 4, ink_of_lab);
    return profile;
}

static void a_cmyk_profile_makes_separations(void **state)
{
    (void)state;
    char *folder = lf_test_folder();
    lf_print print = lf_print_sound();
    static const float greys[6] = {0.0F, 0.0F, 0.0F, 1.0F, 1.0F, 1.0F};
    const lf_views32 views = {2, 1, 1, 3, 3, greys, NULL, NULL, NULL};
    lf_printed printed;
    print.n_views = 2;
    print.stripes = LF_STRIPES_NEAREST;
    print.icc_path = save_profile(folder, "ink.icc", ink_profile());
    lf_printed_make(&print, &views, 0, &printed);
    assert_int_equal(printed.channels, 4);
    assert_int_equal(short_tag(&printed, 262), 5); /* separated */
    assert_int_equal(short_tag(&printed, 332), 1); /* CMYK */
    assert_string_equal(
        json_string_value(json_object_get(json_object_get(printed.manifest, "colour"), "space")),
        "CMYK");
    /* view 1 is white and lies left of the middle, view 0 black and right of it */
    assert_in_range(lf_printed_at(&printed, 598, 0, 3), 0, 2);
    /* black goes to the estimated darkest ink, not to full ink */
    assert_in_range(lf_printed_at(&printed, 602, 0, 3), 240, 255);
    assert_int_equal(lf_printed_at(&printed, 602, 0, 0), 0);
    lf_printed_finish(&printed);
    lf_test_folder_remove(folder);
}

static void a_profile_that_cannot_be_used_is_named(void **state)
{
    (void)state;
    char *folder = lf_test_folder();
    lf_print print = lf_print_sound();
    lf_print_colour *colour = NULL;
    lf_roots roots = {0};
    lf_error err;
    cmsToneCurve *gamma = cmsBuildGamma(NULL, 2.2);
    print.icc_path = lf_test_path(folder, "absent.icc");
    lf_assert_status(lf_print_colour_create(&print, &colour, &err), LF_E_IO, &err);
    print.icc_path =
        lf_test_write(folder, "text.icc",
                      "this is no profile at all, but it is more than 128 bytes long, so that "
                      "only its contents can tell: one, two, three, four, five, six, seven");
    lf_assert_status(lf_print_colour_create(&print, &colour, &err), LF_E_FORMAT, &err);
    assert_non_null(strstr(err.where, "text.icc"));
    print.icc_path = save_profile(folder, "grey.icc", cmsCreateGrayProfile(cmsD50_xyY(), gamma));
    lf_assert_status(lf_print_colour_create(&print, &colour, &err), LF_E_FORMAT, &err);
    assert_non_null(strstr(err.what, "RGB or CMYK"));
    print.icc_path = save_profile(folder, "lab.icc", cmsCreateLab4Profile(NULL));
    lf_assert_status(lf_print_colour_create(&print, &colour, &err), LF_E_FORMAT, &err);
    print.icc_path = save_profile(folder, "srgb.icc", cmsCreate_sRGBProfile());
    lf_assert_ok(lf_roots_add(&roots, "/usr", &err), &err);
    print.icc_roots = &roots;
    lf_assert_status(lf_print_colour_create(&print, &colour, &err), LF_E_PATH, &err);
    assert_null(colour);
    lf_roots_finish(&roots);
    cmsFreeToneCurve(gamma);
    lf_test_folder_remove(folder);
}

static cmsHPROFILE named_profile(const wchar_t *name)
{
    cmsHPROFILE profile = wide_profile();
    cmsMLU *text = cmsMLUalloc(NULL, 1);
    assert_true(cmsMLUsetWide(text, "en", "US", name));
    assert_true(cmsWriteTag(profile, cmsSigProfileDescriptionTag, text));
    cmsMLUfree(text);
    return profile;
}

/* What a profile calls itself goes into a manifest and onto terminals. */
static void names_of_profiles_are_plain_text(void **state)
{
    static const struct {
        const wchar_t *name;
        const char *expected;
    } names[] = {{L"Paper 7", "Paper 7"}, {L"", "unnamed"}, {L"caf\u00e9\n\x1b[1m", "caf???[1m"}};
    (void)state;
    char *folder = lf_test_folder();
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        lf_print print = lf_print_sound();
        lf_print_colour *colour = NULL;
        lf_error err;
        print.icc_path = save_profile(folder, "named.icc", named_profile(names[i].name));
        lf_assert_ok(lf_print_colour_create(&print, &colour, &err), &err);
        assert_string_equal(lf_print_colour_name(colour), names[i].expected);
        lf_print_colour_destroy(colour);
    }
    lf_test_folder_remove(folder);
}

/* --------------------------------------------------------------------------- what goes wrong -- */

typedef struct attempt {
    lf_status status;
    lf_error err;
    int calls;
    double last;
    lf_cancel cancel;
} attempt;

static void note_progress(void *context, double fraction)
{
    attempt *a = context;
    assert_true(fraction > a->last && fraction <= 1.0);
    a->last = fraction;
    a->calls++;
}

static void cancel_at_once(void *context, double fraction)
{
    attempt *a = context;
    (void)fraction;
    a->calls++;
    atomic_store(&a->cancel, 1);
}

static void try_print(const lf_print *print, const char *folder, void (*progress)(void *, double),
                      attempt *out)
{
    static const float grey[3] = {0.5F, 0.5F, 0.5F};
    const lf_views32 views = {1, 1, 1, 3, 3, grey, NULL, NULL, NULL};
    const lf_print_run run = {.cancel = &out->cancel, .progress = progress, .context = out};
    lf_outfile tiff, manifest;
    lf_assert_ok(lf_outfile_open(&tiff, lf_test_path(folder, "p.tif"), false, &out->err),
                 &out->err);
    lf_assert_ok(lf_outfile_open(&manifest, lf_test_path(folder, "p.json"), false, &out->err),
                 &out->err);
    out->status = lf_print_write(print, &views, &run, &tiff, &manifest, &out->err);
    lf_outfile_abandon(&tiff);
    lf_outfile_abandon(&manifest);
}

static void progress_rises_to_one_and_cancel_stops_within_a_strip(void **state)
{
    (void)state;
    char *folder = lf_test_folder();
    lf_print print = lf_print_sound();
    attempt a = {.cancel = 0}, b = {.cancel = 0};
    print.height_mm = 100.0;
    try_print(&print, folder, note_progress, &a);
    lf_assert_ok(a.status, &a.err);
    assert_true(a.last == 1.0);
    assert_true(a.calls > 5);
    try_print(&print, folder, cancel_at_once, &b);
    lf_assert_status(b.status, LF_E_CANCELLED, &b.err);
    assert_int_equal(b.calls, 1);
    assert_int_equal(rmdir(folder), 0); /* nothing was left in it */
    free(folder);
}

static void a_full_disk_is_one_error_and_leaves_no_file(void **state)
{
    (void)state;
    struct rlimit before, small;
    lf_print print = lf_print_sound();
    print.height_mm = 100.0;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    small = before;
    void (*old)(int) = signal(SIGXFSZ, SIG_IGN);
    /* in the first strip, in the middle, and with the directory alone (100 mm are 2362 rows of 3600
     * bytes) */
    const rlim_t sizes[] = {100, 1000000, 2362UL * 3600 + 500};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        char *folder = lf_test_folder();
        attempt a = {.cancel = 0};
        small.rlim_cur = sizes[i];
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
        try_print(&print, folder, note_progress, &a);
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
        lf_assert_status(a.status, LF_E_IO, &a.err);
        assert_non_null(strstr(a.err.where, "p.tif"));
        assert_int_equal(rmdir(folder), 0);
        free(folder);
    }
    signal(SIGXFSZ, old);
}

/* ------------------------------------------------------------------------------------ memory -- */

static void an_a3_print_takes_little_memory_beyond_its_views(void **state)
{
    (void)state;
    char *folder = lf_test_folder();
    lf_print print = lf_print_sound();
    struct rusage before, after;
    attempt a = {.cancel = 0};
    print.width_mm = 420.0;
    print.height_mm = lf_test_long() ? 297.0 : 60.0; /* memory does not depend on it */
    print.n_views = 10;
    assert_int_equal(getrusage(RUSAGE_SELF, &before), 0);
    try_print(&print, folder, note_progress, &a);
    assert_int_equal(getrusage(RUSAGE_SELF, &after), 0);
    lf_assert_ok(a.status, &a.err);
    print_message("%ld kB more\n", after.ru_maxrss - before.ru_maxrss);
    assert_true(after.ru_maxrss - before.ru_maxrss < 40000);
    lf_test_folder_remove(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_a3_print_takes_little_memory_beyond_its_views),
        cmocka_unit_test(tags_are_exact_and_all_compressions_hold_the_same_picture),
        cmocka_unit_test(sizes_of_strips_are_not_taken_for_a_resolution),
        cmocka_unit_test(the_same_print_twice_is_the_same_file_and_strips_do_not_matter),
        cmocka_unit_test(a_raster_that_may_pass_4_gib_is_a_big_tiff),
        cmocka_unit_test(the_manifest_tells_what_was_printed),
        cmocka_unit_test(colours_are_converted_to_a_given_rgb_profile),
        cmocka_unit_test(a_cmyk_profile_makes_separations),
        cmocka_unit_test(a_profile_that_cannot_be_used_is_named),
        cmocka_unit_test(names_of_profiles_are_plain_text),
        cmocka_unit_test(progress_rises_to_one_and_cancel_stops_within_a_strip),
        cmocka_unit_test(a_full_disk_is_one_error_and_leaves_no_file),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
