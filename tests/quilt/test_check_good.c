/* The checklist on good prints of many settings: no point fails, and those that can be measured
 * are. */
#include "tests/testing.h"

#include <lcms2.h>

#include "base/alloc.h"
#include "tests/quilt/checked.h"
#include "tests/quilt/printed.h"

typedef struct good_case {
    const char *name;
    double lpi, right, down, width, height, phase, bleed;
    int n_views, bits;
    lf_stripes stripes;
    lf_compress compress;
    bool horizontal, reverse, mirror, marks;
    lf_card_value *value;
    bool measured; /* pitch and phase are measured in the file */
    enum { NO_PROFILE, WIDE_RGB, INKS } profile;
    double slant, thickness; /* an exact map for 300 mm with a thickness */
} good_case;

#define LZW LF_COMPRESS_LZW
#define DEFLATE LF_COMPRESS_DEFLATE
#define F LF_STRIPES_FRACTIONAL
#define N LF_STRIPES_NEAREST
#define W lf_card_waves
#define S lf_card_speckle
static const good_case cases[] = {
    {"usual", 60.13, 600, 0, 40, 5, 0, 0, 7, 8, F, 0, 0, 0, 0, 0, W, true, 0, 0, 0},
    {"8 of 9.98", 60.13, 600, 0, 40, 5, 0, 0, 8, 8, F, 0, 0, 0, 0, 0, W, true, 0, 0, 0},
    {"speckle", 60.13, 600, 0, 40, 5, 0, 0, 8, 8, F, 0, 0, 0, 0, 0, S, true, 0, 0, 0},
    {"9 of 9.98", 60.13, 600, 0, 40, 5, 0, 0, 9, 8, F, 0, 0, 0, 0, 0, W, true, 0, 0, 0},
    {"10 of 9.98", 60.13, 600, 0, 40, 5, 0, 0, 10, 8, F, 0, 0, 0, 0, 0, W, false, 0, 0, 0},
    {"nearest", 60.13, 600, 0, 40, 5, 0, 0, 7, 8, N, 0, 0, 0, 0, 0, W, true, 0, 0, 0},
    {"nearest 8", 60.13, 600, 0, 40, 5, 0.05, 0, 8, 8, N, 0, 0, 0, 0, 0, W, true, 0, 0, 0},
    {"nearest 60", 60, 600, 0, 40, 5, 0, 0, 8, 8, N, 0, 0, 0, 0, 0, W, true, 0, 0, 0},
    {"nearest 10", 60.13, 600, 0, 40, 5, 0, 0, 10, 8, N, 0, 0, 0, 0, 0, W, false, 0, 0, 0},
    {"16 bits", 60.13, 600, 0, 40, 5, 0, 0, 7, 16, F, 0, 0, 0, 0, 0, W, true, 0, 0, 0},
    {"16 bits nearest", 60.13, 600, 0, 40, 5, 0, 0, 7, 16, N, 0, 0, 0, 0, 0, W, true, 0, 0, 0},
    {"lzw", 60.13, 600, 0, 40, 5, 0, 0, 7, 8, F, LZW, 0, 0, 0, 0, W, true, 0, 0, 0},
    {"deflate", 60.13, 600, 0, 40, 5, 0, 0, 7, 16, F, DEFLATE, 0, 0, 0, 0, W, true, 0, 0, 0},
    {"horizontal", 60.13, 600, 0, 5, 40, 0, 0, 7, 8, F, 0, true, 0, 0, 0, W, true, 0, 0, 0},
    {"horizontal nearest",
     60.13,
     600,
     0,
     5,
     40,
     0.1,
     0,
     7,
     8,
     N,
     0,
     true,
     0,
     0,
     0,
     W,
     true,
     0,
     0,
     0},
    {"horizontal marks",
     60.13,
     600,
     0,
     5,
     40,
     0,
     2,
     7,
     8,
     F,
     0,
     true,
     0,
     0,
     true,
     W,
     true,
     0,
     0,
     0},
    {"reverse", 60.13, 600, 0, 40, 5, 0, 0, 7, 8, F, 0, 0, true, 0, 0, W, true, 0, 0, 0},
    {"mirror", 60.13, 600, 0, 40, 5, 0.11, 0, 7, 8, F, 0, 0, 0, true, 0, W, true, 0, 0, 0},
    {"mirror and reverse",
     60.13,
     600,
     0,
     40,
     5,
     -0.07,
     0,
     7,
     8,
     N,
     0,
     0,
     true,
     true,
     0,
     W,
     true,
     0,
     0,
     0},
    {"mirror horizontal",
     60.13,
     600,
     0,
     5,
     40,
     0.07,
     0,
     7,
     8,
     F,
     0,
     true,
     0,
     true,
     0,
     W,
     true,
     0,
     0,
     0},
    {"marks", 60.13, 600, 0, 40, 5, 0, 0, 7, 8, F, 0, 0, 0, 0, true, W, true, 0, 0, 0},
    {"marks of 10", 60.13, 600, 0, 40, 5, 0.1, 3, 10, 8, F, 0, 0, 0, 0, true, W, true, 0, 0, 0},
    {"marks mirrored",
     60.13,
     600,
     0,
     40,
     5,
     0.1,
     3,
     8,
     8,
     F,
     0,
     0,
     0,
     true,
     true,
     W,
     true,
     0,
     0,
     0},
    {"bleed", 60.13, 600, 0, 40, 5, 0, 3, 7, 8, F, 0, 0, 0, 0, 0, W, true, 0, 0, 0},
    {"raster of two", 60.13, 720, 1440, 40, 5, 0, 0, 9, 8, F, 0, 0, 0, 0, 0, W, true, 0, 0, 0},
    {"turned", 60.13, 720, 1440, 5, 40, 0.02, 1, 9, 8, F, 0, true, 0, 0, true, W, true, 0, 0, 0},
    {"812.8 dpi", 60.13, 812.8, 0, 40, 5, 0, 0, 8, 8, F, 0, 0, 0, 0, 0, W, true, 0, 0, 0},
    {"40 lpi", 40.1, 600, 0, 50, 5, 0.2, 0, 12, 8, F, 0, 0, 0, 0, 0, W, true, 0, 0, 0},
    {"75 lpi", 75.08, 720, 0, 40, 5, 0, 0, 7, 8, F, 0, 0, 0, 0, 0, S, true, 0, 0, 0},
    {"1200 dpi", 60.13, 1200, 0, 30, 3, 0, 0, 15, 8, F, 0, 0, 0, 0, 0, W, true, 0, 0, 0},
    {"two views", 60.13, 600, 0, 40, 5, 0, 0, 2, 8, N, 0, 0, 0, 0, 0, S, true, 0, 0, 0},
    {"one view", 60.13, 600, 0, 40, 5, 0, 0, 1, 8, F, 0, 0, 0, 0, 0, W, true, 0, 0, 0},
    {"still", 60.13, 600, 0, 40, 5, 0, 0, 7, 8, F, 0, 0, 0, 0, 0, lf_card_still, true, 0, 0, 0},
    {"grey", 60.13, 600, 0, 40, 5, 0, 0, 7, 8, F, 0, 0, 0, 0, 0, lf_card_grey, false, 0, 0, 0},
    {"grey nearest", 60.13, 600, 0, 40, 5, 0, 0, 7, 8, N, 0, 0, 0, 0, 0,
     lf_card_grey,   false, 0,   0, 0},
    {"wide RGB", 60.13, 600, 0, 40, 5, 0, 0, 7, 8, F, 0, 0, 0, 0, true, W, true, WIDE_RGB, 0, 0},
    {"wide RGB, 16 bits",
     60.13,
     600,
     0,
     40,
     5,
     0,
     0,
     8,
     16,
     F,
     0,
     0,
     0,
     0,
     0,
     W,
     true,
     WIDE_RGB,
     0,
     0},
    {"CMYK", 60.13, 600, 0, 40, 5, 0, 0, 7, 8, F, 0, 0, 0, 0, true, W, true, INKS, 0, 0},
    {"CMYK nearest", 60.13, 600, 0, 40, 5, 0, 2, 7, 8, N, 0, 0, 0, 0, 0, W, true, INKS, 0, 0},
    {"CMYK LZW", 60.13, 600, 0, 40, 5, 0, 0, 7, 16, F, LZW, 0, 0, 0, 0, W, true, INKS, 0, 0},
    {"slanted", 60.13, 600, 0, 40, 5, 0.1, 0, 7, 8, F, 0, 0, 0, 0, 0, W, true, 0, 10, 0},
    {"slanted nearest", 60.13, 600, 0, 40, 5, 0, 0, 7, 8, N, 0, 0, 0, 0, 0, W, true, 0, 25, 0},
    {"slanted the other way",
     60.13,
     600,
     0,
     5,
     40,
     0,
     1,
     7,
     8,
     F,
     0,
     true,
     0,
     true,
     0,
     W,
     true,
     0,
     -9,
     0},
    {"much slanted", 60.13, 600, 0, 40, 5, 0, 0, 8, 8, F, 0, 0, 0, 0, 0, W, false, 0, 40, 0},
    {"exact", 60.13, 600, 0, 60, 5, 0.1, 0, 7, 8, F, 0, 0, true, 0, 0, W, true, 0, 0, 2},
    {"exact, 16 bits", 60.13, 600, 0, 60, 5, 0, 0, 7, 16, F, 0, 0, 0, true, 0, W, true, 0, 0, 0.6},
    {"exact nearest", 60.13, 600, 0, 60, 5, 0, 0, 7, 8, N, 0, 0, 0, 0, true, W, true, 0, 0, 2},
    {"exact and slanted", 60.13, 600, 0, 60, 5, 0, 0, 7, 8, F, 0, 0, 0, 0, 0, W, true, 0, 8, 1},
    {"small", 60.13, 600, 0, 1, 1, 0, 0, 7, 8, F, 0, 0, 0, 0, 0, W, false, 0, 0, 0},
};

static lf_print print_of(const good_case *c)
{
    return (lf_print){.lpi = c->lpi,
                      .dpi = c->right,
                      .dpi_down = c->down,
                      .width_mm = c->width,
                      .height_mm = c->height,
                      .phase_mm = c->phase,
                      .bleed_mm = c->bleed,
                      .n_views = c->n_views,
                      .bits = c->bits,
                      .stripes = c->stripes,
                      .compress = c->compress,
                      .horizontal = c->horizontal,
                      .reverse = c->reverse,
                      .mirror = c->mirror,
                      .marks = c->marks,
                      .optics = {.slant = c->slant,
                                 .thickness_mm = c->thickness,
                                 .distance_mm = c->thickness > 0 ? 300 : 0}};
}

/* ---------------------------------------------------------------------------------- profiles -- */

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

static void put_table(cmsHPROFILE profile, cmsTagSignature tag, cmsUInt32Number n_in,
                      cmsUInt32Number n_out, cmsSAMPLER16 sampler)
{
    cmsPipeline *pipeline = cmsPipelineAlloc(NULL, n_in, n_out);
    cmsStage *table = cmsStageAllocCLut16bit(NULL, 9, n_in, n_out, NULL);
    assert_true(cmsStageSampleCLut16bit(table, sampler, NULL, 0));
    cmsPipelineInsertStage(pipeline, cmsAT_BEGIN, cmsStageAllocToneCurves(NULL, n_in, NULL));
    cmsPipelineInsertStage(pipeline, cmsAT_END, table);
    cmsPipelineInsertStage(pipeline, cmsAT_END, cmsStageAllocToneCurves(NULL, n_out, NULL));
    assert_true(cmsWriteTag(profile, tag, pipeline));
    cmsPipelineFree(pipeline);
}

/* A press with black ink alone. */
static cmsHPROFILE ink_profile(void)
{
    cmsHPROFILE profile = cmsCreateProfilePlaceholder(NULL);
    cmsSetProfileVersion(profile, 4.3);
    cmsSetDeviceClass(profile, cmsSigOutputClass);
    cmsSetColorSpace(profile, cmsSigCmykData);
    cmsSetPCS(profile, cmsSigLabData);
    put_table(profile, cmsSigAToB0Tag, 4, 3, lab_of_ink);
    put_table(profile, cmsSigBToA0Tag, 3, 4, ink_of_lab);
    return profile;
}

static cmsHPROFILE wide_profile(void)
{
    const cmsCIExyY white = {0.3127, 0.3290, 1.0};
    const cmsCIExyYTRIPLE primaries = {{0.64, 0.33, 1.0}, {0.21, 0.71, 1.0}, {0.15, 0.06, 1.0}};
    cmsToneCurve *curve = cmsBuildGamma(NULL, 2.2);
    cmsToneCurve *curves[3] = {curve, curve, curve};
    cmsHPROFILE profile = cmsCreateRGBProfile(&white, &primaries, curves);
    cmsFreeToneCurve(curve);
    return profile;
}

static const char *profile_in(const char *folder, const good_case *c)
{
    const char *path = lf_test_path(folder, "print.icc");
    if (c->profile == NO_PROFILE)
        return NULL;
    cmsHPROFILE profile = c->profile == INKS ? ink_profile() : wide_profile();
    assert_true(cmsSaveProfileToFile(profile, path));
    cmsCloseProfile(profile);
    return path;
}

/* ------------------------------------------------------------------------------------ prints -- */

static void good_prints_pass(void **state)
{
    (void)state;
    int failed = 0;
    char *folder = lf_test_folder();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        lf_print print = print_of(&cases[i]);
        print.icc_path = profile_in(folder, &cases[i]);
        lf_checked checked;
        char line[2048];
        lf_checked_make(&print, cases[i].value, false, &checked);
        for (int with = 0; with < (i % 3 == 0 ? 2 : 1); with++) {
            lf_checked_run(&checked, with);
            const bool measured = lf_checked_point(&checked, 7) == LF_CHECK_PASS;
            if (lf_print_report_count(&checked.report, LF_CHECK_FAIL) > 0 ||
                (!with && measured != cases[i].measured)) {
                char *text = lf_print_report_text(&checked.report);
                print_message("%s: %s\n%s", cases[i].name,
                              lf_print_report_line(&checked.report, line, sizeof line), text);
                lf_free(text);
                failed++;
            }
        }
        lf_checked_finish(&checked);
    }
    lf_test_folder_remove(folder);
    assert_int_equal(failed, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(good_prints_pass),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
