/* The spot behind a measured crosstalk: its closed form, and the fit. The oracle adds up light with
 * loops of its own. */
#include "tests/testing.h"

#include "quilt/print/blur.h"

#define SHARES (2 * LF_PRINT_CROSSTALK + 1)

/* ----------------------------------------------------------------------------------- oracles -- */

/* Part of [left, right] in [low, high]. */
static double common(double left, double right, double low, double high)
{
    return fmax(fmin(right, high) - fmax(left, low), 0.0);
}

/* The light of stripe k in an eye that looks at the middle of stripe 0, with the raster's pixels at
 * many places under the stripes. The spot is a sum of narrow boxes, the ink's Gaussian by sampling.
 */
static double share_by_sums(double box, double ink, double beside, double stripe, int k)
{
    enum { PLACES = 40, PARTS = 60 };
    const double reach = 0.5 * box + 5.0 * ink;
    double sum = 0.0, weights = 0.0;
    for (int place = 0; place < PLACES; place++)
        for (int part = 0; part < PARTS; part++) {
            const double x = reach * ((part + 0.5) / PARTS * 2.0 - 1.0);
            double weight = fabs(x) <= 0.5 * box;
            if (ink > 0.0)
                weight = 0.5 * (erf((x + 0.5 * box) / ink / sqrt(2.0)) -
                                erf((x - 0.5 * box) / ink / sqrt(2.0)));
            const double shift = (place + 0.5) / PLACES, at = x + beside,
                         pixel = floor(at - shift) + shift;
            sum += weight * common(pixel, pixel + 1.0, (k - 0.5) * stripe, (k + 0.5) * stripe);
            weights += weight;
        }
    return sum / weights;
}

static void kernels_are_sums_over_pixels(void **state)
{
    (void)state;
    static const struct {
        double box, ink, beside, stripe;
    } of[] = {{0.6, 0.0, 0.0, 1.25},  {0.6, 0.3, 0.0, 1.25}, {2.1, 0.0, 0.4, 1.7},
              {0.05, 0.8, -0.7, 1.0}, {3.0, 1.1, 0.2, 2.5},  {0.01, 0.0, 0.0, 0.8}};
    for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
        const lf_print_spot spot = {of[i].box, of[i].ink};
        double kernel[7], sum = 0.0;
        lf_blur_kernel(&spot, of[i].beside, of[i].stripe, 3, kernel);
        for (int k = -3; k <= 3; k++) {
            lf_assert_close(kernel[3 + k],
                            share_by_sums(of[i].box, of[i].ink, of[i].beside, of[i].stripe, k), 0.0,
                            0.004);
            sum += kernel[3 + k];
        }
        assert_true(sum <= 1.0 + 1e-9);
    }
}

/* By hand: stripes of many pixels, so that the pixels do not blur. */
static void wide_stripes_have_shares_by_hand(void **state)
{
    (void)state;
    const double stripe = 1e3;
    double kernel[3];
    const lf_print_spot twice = {2.0 * stripe, 0.0}, half = {0.5 * stripe, 0.0};
    lf_blur_kernel(&twice, 0.0, stripe, 1, kernel);
    lf_assert_close(kernel[0], 0.25, 0.0, 1e-3);
    lf_assert_close(kernel[1], 0.5, 0.0, 1e-3);
    lf_assert_close(kernel[2], 0.25, 0.0, 1e-3);
    lf_blur_kernel(&half, 0.5 * stripe, stripe, 1, kernel); /* on the border */
    lf_assert_close(kernel[0], 0.0, 0.0, 1e-9);
    lf_assert_close(kernel[1], 0.5, 0.0, 1e-9);
    lf_assert_close(kernel[2], 0.5, 0.0, 1e-9);
    /* one pixel per stripe and a narrow spot: pixels lie under two stripes, 1/8 3/4 1/8 */
    const lf_print_spot narrow = {1e-3, 0.0};
    lf_blur_kernel(&narrow, 0.0, 1.0, 1, kernel);
    lf_assert_close(kernel[0], 0.125, 0.0, 1e-5);
    lf_assert_close(kernel[1], 0.75, 0.0, 1e-5);
}

/* --------------------------------------------------------------------------------------- fit -- */

/* A print whose chart of 8 views shows this spot. */
static lf_print measured_print(const lf_print_spot *spot, double beside_px, int n_views)
{
    lf_print print = {.lpi = 60.13,
                      .dpi = 600.0,
                      .width_mm = 50.0,
                      .height_mm = 10.0,
                      .n_views = n_views,
                      .blur = {.n_crosstalk = 3, .crosstalk_views = 8}};
    double kernel[7], sum = 0.0;
    lf_blur_kernel(spot, beside_px, 600.0 / 60.13 / 8.0, 3, kernel);
    for (int i = 0; i < 7; i++)
        sum += kernel[i];
    for (int i = 0; i < 7; i++) /* views run against the print */
        print.blur.crosstalk[i] = kernel[6 - i] / sum;
    return print;
}

static void a_spot_is_found_again_for_any_views(void **state)
{
    (void)state;
    static const struct {
        double width, beside; /* pixels */
    } of[] = {{0.4, 0.0}, {0.8, 0.3}, {1.2, -0.4}, {0.2, 0.0}};
    for (size_t i = 0; i < sizeof of / sizeof *of; i++)
        for (int n_views = 4; n_views <= 10; n_views += 2) {
            const lf_print_spot spot = {sqrt(12.0) * of[i].width, of[i].width};
            lf_print print = measured_print(&spot, of[i].beside, n_views);
            lf_blur blur;
            assert_int_equal(lf_blur_of_print(&print, &blur), LF_OK);
            lf_assert_close(blur.spot.ink_px, spot.ink_px, 0.03, 0.02);
            lf_assert_close(blur.beside_px, of[i].beside, 0.0, 0.02);
            lf_assert_close(blur.extra_px, 600.0 / 60.13 / 8.0, 1e-12, 0.0);
            assert_true(blur.extra[3] > 0.6);
            /* the cells of a print in the other order are turned */
            print.reverse = true;
            assert_int_equal(lf_blur_of_print(&print, &blur), LF_OK);
            lf_assert_close(blur.beside_px, -of[i].beside, 0.0, 0.02);
        }
}

/* What the pixels alone leak is no blur of the spot. */
static void a_sharp_kernel_stays_sharp(void **state)
{
    (void)state;
    const lf_print_spot point = {0.01, 0.0};
    lf_print print = measured_print(&point, 0.0, 10);
    lf_blur blur;
    assert_true(print.blur.crosstalk[3] < 0.87); /* of pixels */
    assert_int_equal(lf_blur_of_print(&print, &blur), LF_OK);
    assert_true(blur.spot.ink_px < 0.1 && blur.spot.box_px < 0.4);
    lf_assert_close(blur.beside_px, 0.0, 0.0, 1e-9);
    assert_true(blur.extra[3] > 0.98);
}

/* A ghost from far away is no part of a spot: spots of its own have it. */
static void what_no_spot_has_is_kept(void **state)
{
    (void)state;
    const lf_print_spot spot = {1.0, 0.3};
    lf_print print = measured_print(&spot, 0.0, 8);
    lf_blur blur;
    for (int i = 0; i < 7; i++)
        print.blur.crosstalk[i] *= 0.8;
    print.blur.crosstalk[0] += 0.2; /* view i - 3: three stripes to the right */
    assert_int_equal(lf_blur_of_print(&print, &blur), LF_OK);
    assert_true(blur.extra[6] > 0.15);
    assert_true(blur.extra[0] < 0.02);
}

/* ---------------------------------------------------------------------------------- manifest -- */

static void a_crosstalk_is_read_back_from_a_manifest(void **state)
{
    (void)state;
    const lf_print_blur blur = {
        .n_crosstalk = 1, .crosstalk = {0.1, 0.7, 0.2}, .crosstalk_views = 8};
    lf_print_blur taken = {.ink_mm = 0.02};
    lf_error err;
    json_t *manifest = json_pack("{s:o}", "crosstalk", lf_blur_crosstalk_json(&blur));
    lf_assert_ok(lf_print_take_crosstalk(manifest, "m.json", &taken, &err), &err);
    assert_true(taken.n_crosstalk == 1 && taken.crosstalk_views == 8 && taken.ink_mm == 0.02);
    assert_memory_equal(taken.crosstalk, blur.crosstalk, sizeof blur.crosstalk);
    json_decref(manifest);
    assert_null(lf_blur_crosstalk_json(&(lf_print_blur){0}));
    static const char *const wrong[] = {
        "{\"crosstalk\": 7}",
        "{\"crosstalk\": {}}",
        "{\"crosstalk\": {\"views\": 8, \"shares\": [0.5, 0.5]}}",
        "{\"crosstalk\": {\"views\": -1, \"shares\": [0, 1, 0]}}",
        "{\"crosstalk\": {\"views\": 65, \"shares\": [0, 1, 0]}}",
        "{\"crosstalk\": {\"views\": 8, \"shares\": [0, \"1\", 0]}}",
        "{\"crosstalk\": {\"views\": 8, \"shares\": [-0.1, 1.1, 0]}}",
        "{\"crosstalk\": {\"views\": 8, \"shares\": [0,0,0,0,0,0,0,0,0,1,0,0,0,0,0,0,0,0,0]}}"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        lf_print_blur kept = blur;
        manifest = json_loads(wrong[i], 0, NULL);
        assert_non_null(manifest);
        lf_assert_status(lf_print_take_crosstalk(manifest, "m.json", &kept, &err), LF_E_FORMAT,
                         NULL);
        assert_non_null(strstr(err.what, "crosstalk"));
        assert_memory_equal(&kept, &blur, sizeof blur);
        json_decref(manifest);
    }
    manifest = json_object();
    lf_assert_ok(lf_print_take_crosstalk(manifest, "m.json", &taken, &err), &err);
    assert_int_equal(taken.n_crosstalk, 1); /* as it was */
    json_decref(manifest);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kernels_are_sums_over_pixels),
        cmocka_unit_test(wide_stripes_have_shares_by_hand),
        cmocka_unit_test(a_spot_is_found_again_for_any_views),
        cmocka_unit_test(a_sharp_kernel_stays_sharp),
        cmocka_unit_test(what_no_spot_has_is_kept),
        cmocka_unit_test(a_crosstalk_is_read_back_from_a_manifest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
