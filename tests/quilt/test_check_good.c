/* The checklist on good prints of many settings: no point fails, and those that can be measured
 * are. */
#include "tests/testing.h"

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
} good_case;

#define F LF_STRIPES_FRACTIONAL
#define N LF_STRIPES_NEAREST
#define W lf_card_waves
#define S lf_card_speckle
/* clang-format off */
static const good_case cases[] = {
    {"usual", 60.13, 600, 0, 40, 5, 0, 0, 7, 8, F, 0, 0, 0, 0, 0, W, true},
    {"8 of 9.98", 60.13, 600, 0, 40, 5, 0, 0, 8, 8, F, 0, 0, 0, 0, 0, W, true},
    {"speckle", 60.13, 600, 0, 40, 5, 0, 0, 8, 8, F, 0, 0, 0, 0, 0, S, true},
    {"9 of 9.98", 60.13, 600, 0, 40, 5, 0, 0, 9, 8, F, 0, 0, 0, 0, 0, W, true},
    {"10 of 9.98", 60.13, 600, 0, 40, 5, 0, 0, 10, 8, F, 0, 0, 0, 0, 0, W, false},
    {"nearest", 60.13, 600, 0, 40, 5, 0, 0, 7, 8, N, 0, 0, 0, 0, 0, W, true},
    {"nearest 8", 60.13, 600, 0, 40, 5, 0.05, 0, 8, 8, N, 0, 0, 0, 0, 0, W, true},
    {"nearest 60", 60, 600, 0, 40, 5, 0, 0, 8, 8, N, 0, 0, 0, 0, 0, W, true},
    {"nearest 10", 60.13, 600, 0, 40, 5, 0, 0, 10, 8, N, 0, 0, 0, 0, 0, W, false},
    {"16 bits", 60.13, 600, 0, 40, 5, 0, 0, 7, 16, F, 0, 0, 0, 0, 0, W, true},
    {"16 bits nearest", 60.13, 600, 0, 40, 5, 0, 0, 7, 16, N, 0, 0, 0, 0, 0, W, true},
    {"lzw", 60.13, 600, 0, 40, 5, 0, 0, 7, 8, F, LF_COMPRESS_LZW, 0, 0, 0, 0, W, true},
    {"deflate", 60.13, 600, 0, 40, 5, 0, 0, 7, 16, F, LF_COMPRESS_DEFLATE, 0, 0, 0, 0, W, true},
    {"horizontal", 60.13, 600, 0, 5, 40, 0, 0, 7, 8, F, 0, true, 0, 0, 0, W, true},
    {"horizontal nearest", 60.13, 600, 0, 5, 40, 0.1, 0, 7, 8, N, 0, true, 0, 0, 0, W, true},
    {"horizontal marks", 60.13, 600, 0, 5, 40, 0, 2, 7, 8, F, 0, true, 0, 0, true, W, true},
    {"reverse", 60.13, 600, 0, 40, 5, 0, 0, 7, 8, F, 0, 0, true, 0, 0, W, true},
    {"mirror", 60.13, 600, 0, 40, 5, 0.11, 0, 7, 8, F, 0, 0, 0, true, 0, W, true},
    {"mirror and reverse", 60.13, 600, 0, 40, 5, -0.07, 0, 7, 8, N, 0, 0, true, true, 0, W, true},
    {"mirror horizontal", 60.13, 600, 0, 5, 40, 0.07, 0, 7, 8, F, 0, true, 0, true, 0, W, true},
    {"marks", 60.13, 600, 0, 40, 5, 0, 0, 7, 8, F, 0, 0, 0, 0, true, W, true},
    {"marks of 10", 60.13, 600, 0, 40, 5, 0.1, 3, 10, 8, F, 0, 0, 0, 0, true, W, true},
    {"marks mirrored", 60.13, 600, 0, 40, 5, 0.1, 3, 8, 8, F, 0, 0, 0, true, true, W, true},
    {"bleed", 60.13, 600, 0, 40, 5, 0, 3, 7, 8, F, 0, 0, 0, 0, 0, W, true},
    {"raster of two", 60.13, 720, 1440, 40, 5, 0, 0, 9, 8, F, 0, 0, 0, 0, 0, W, true},
    {"turned", 60.13, 720, 1440, 5, 40, 0.02, 1, 9, 8, F, 0, true, 0, 0, true, W, true},
    {"812.8 dpi", 60.13, 812.8, 0, 40, 5, 0, 0, 8, 8, F, 0, 0, 0, 0, 0, W, true},
    {"40 lpi", 40.1, 600, 0, 50, 5, 0.2, 0, 12, 8, F, 0, 0, 0, 0, 0, W, true},
    {"75 lpi", 75.08, 720, 0, 40, 5, 0, 0, 7, 8, F, 0, 0, 0, 0, 0, S, true},
    {"1200 dpi", 60.13, 1200, 0, 30, 3, 0, 0, 15, 8, F, 0, 0, 0, 0, 0, W, true},
    {"two views", 60.13, 600, 0, 40, 5, 0, 0, 2, 8, N, 0, 0, 0, 0, 0, S, true},
    {"one view", 60.13, 600, 0, 40, 5, 0, 0, 1, 8, F, 0, 0, 0, 0, 0, W, true},
    {"still", 60.13, 600, 0, 40, 5, 0, 0, 7, 8, F, 0, 0, 0, 0, 0, lf_card_still, true},
    {"grey", 60.13, 600, 0, 40, 5, 0, 0, 7, 8, F, 0, 0, 0, 0, 0, lf_card_grey, false},
    {"grey nearest", 60.13, 600, 0, 40, 5, 0, 0, 7, 8, N, 0, 0, 0, 0, 0, lf_card_grey, false},
    {"small", 60.13, 600, 0, 1, 1, 0, 0, 7, 8, F, 0, 0, 0, 0, 0, W, false},
};
/* clang-format on */

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
                      .marks = c->marks};
}

static void good_prints_pass(void **state)
{
    (void)state;
    int failed = 0;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const lf_print print = print_of(&cases[i]);
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
    assert_int_equal(failed, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(good_prints_pass),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
