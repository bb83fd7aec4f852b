#include "tests/testing.h"

#include "quilt/quilt.h"

static lf_tone *tone_of(double exposure, const char *tonemap)
{
    lf_tone *tone;
    lf_error err;
    lf_assert_ok(lf_tone_create(exposure, tonemap, &tone, &err), &err);
    return tone;
}

/* The formulas, slowly. */
static double light_of(double exposure, bool filmic, float value)
{
    double x = (double)value * exp2(exposure);
    if (isnan(x) || x <= 0)
        return 0;
    if (isinf(x))
        return 1;
    if (filmic)
        x = fmin(x, 1e9), x = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
    return fmin(x, 1);
}

static double level_of(double exposure, bool filmic, float value)
{
    double light = light_of(exposure, filmic, value);
    double srgb = light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1 / 2.4) - 0.055;
    return 255 * srgb;
}

static int code_of(double exposure, bool filmic, float value)
{
    return (int)floor(level_of(exposure, filmic, value) + 0.5);
}

static int mapped(const lf_tone *tone, float value)
{
    const float in[3] = {value, value, value};
    uint8_t out[3];
    lf_tone_map(tone, 1, in, out);
    assert_true(out[0] == out[1] && out[1] == out[2]);
    return out[0];
}

static float float_of(uint32_t bits)
{
    float f;
    memcpy(&f, &bits, sizeof f);
    return f;
}

static const double exposures[] = {0, 1, -1, 0.3, -2.7, 10, -10, 63.9, -64};

static void codes_are_the_rounded_formula_over_all_floats(void **state)
{
    (void)state;
    const uint32_t step = lf_test_long() ? 97 : 10007;
    for (int k = 0; k < 18; k++) {
        bool filmic = k & 1;
        lf_tone *tone = tone_of(exposures[k / 2], filmic ? "filmic" : "srgb");
        for (uint64_t bits = 0; bits <= UINT32_MAX; bits += step) {
            float f = float_of((uint32_t)bits);
            if (mapped(tone, f) != code_of(exposures[k / 2], filmic, f))
                fail_msg("%a at %g stops, %d: %d, expected %d", (double)f, exposures[k / 2], filmic,
                         mapped(tone, f), code_of(exposures[k / 2], filmic, f));
        }
        lf_tone_destroy(tone);
    }
}

/* Where one code gives way to the next, to the last bit. */
static void codes_change_exactly_where_the_formula_does(void **state)
{
    (void)state;
    for (int k = 0; k < 18; k++) {
        bool filmic = k & 1;
        double exposure = exposures[k / 2];
        lf_tone *tone = tone_of(exposure, filmic ? "filmic" : "srgb");
        int n_steps = 0;
        for (int code = 1; code < 256; code++) {
            uint32_t below = 0, at = 0x7f800000;
            while (at - below > 1) {
                uint32_t middle = below + (at - below) / 2;
                *(code_of(exposure, filmic, float_of(middle)) >= code ? &at : &below) = middle;
            }
            for (uint32_t bits = at - 3; bits <= at + 3 && bits < 0x7f800000; bits++)
                assert_int_equal(mapped(tone, float_of(bits)),
                                 code_of(exposure, filmic, float_of(bits)));
            n_steps += mapped(tone, float_of(at)) - mapped(tone, float_of(at - 1));
        }
        assert_int_equal(n_steps, 255);
        lf_tone_destroy(tone);
    }
}

static void what_is_no_light_is_black_and_too_much_is_white(void **state)
{
    (void)state;
    for (int filmic = 0; filmic < 2; filmic++) {
        lf_tone *tone = tone_of(0, filmic ? "filmic" : "srgb");
        const float dark[] = {
            NAN, -NAN, -INFINITY, -1, -0.0f, 0, 1e-40f, float_of(0x7f800001), float_of(0xffffffff)};
        for (size_t i = 0; i < sizeof dark / sizeof dark[0]; i++)
            assert_int_equal(mapped(tone, dark[i]), 0);
        assert_int_equal(mapped(tone, INFINITY), 255);
        assert_int_equal(mapped(tone, 3e38f), 255);
        lf_tone_destroy(tone);
    }
}

/* The values of an 8-bit picture come back as they were. */
static void decoding_and_mapping_are_inverse(void **state)
{
    (void)state;
    lf_tone *tone = tone_of(0, "srgb");
    for (int i = 0; i < 256; i++) {
        double s = i / 255.0;
        assert_int_equal(
            mapped(tone, (float)(s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4))), i);
    }
    lf_tone_destroy(tone);
}

static void any_number_of_pixels_is_mapped_alike(void **state)
{
    (void)state;
    static float in[3 * 700];
    uint8_t out[3 * 700 + 1];
    lf_tone *tone = tone_of(0.5, "filmic");
    for (int i = 0; i < 2100; i++)
        in[i] = (float)(i % 997) * 0.002f;
    for (size_t n = 0; n <= 700; n += n < 100 ? 1 : 50) {
        memset(out, 0xab, sizeof out);
        lf_tone_map(tone, n, in, out);
        for (size_t i = 0; i < 3 * n; i++)
            assert_int_equal(out[i], code_of(0.5, true, in[i]));
        assert_int_equal(out[3 * n], 0xab);
    }
    lf_tone_destroy(tone);
}

static void display_light_is_what_the_codes_are_made_of(void **state)
{
    (void)state;
    for (int filmic = 0; filmic < 2; filmic++) {
        lf_tone *tone = tone_of(-0.7, filmic ? "filmic" : "srgb");
        float in[30];
        for (int i = 0; i < 30; i++)
            in[i] = (float)pow(2, i - 20) * (i % 7 ? 1.0f : -1.0f);
        in[3] = NAN;
        in[4] = INFINITY;
        float out[30];
        lf_tone_linear(tone, 10, in, out);
        for (int i = 0; i < 30; i++)
            lf_assert_close((double)out[i], light_of(-0.7, filmic, in[i]), 1e-7, 0);
        lf_tone_linear(tone, 10, in, in); /* in place */
        assert_memory_equal(in, out, sizeof in);
        lf_tone_destroy(tone);
    }
}

/* -------------------------------------------------------------------------------------- aces -- */

/* Hill's formulas, pixel by pixel: matrices by columns, and as rational as they were published. */
static void aces_of(double exposure, const float in[3], double out[3])
{
    static const double before[3][3] = {{.59719, .076, .0284},
                                        {.35458, .90834, .13383},
                                        {.04823, .01566, .83777}},
                        after[3][3] = {{1.60475, -.10208, -.00327},
                                       {-.53108, 1.10813, -.07276},
                                       {-.07367, -.00605, 1.07602}};
    double v[3] = {0, 0, 0}, w[3] = {0, 0, 0};
    for (int k = 0; k < 3; k++)
        for (int c = 0; c < 3; c++)
            v[c] += before[k][c] * fmax((double)in[k] * exp2(exposure), 0);
    for (int k = 0; k < 3; k++)
        for (int c = 0; c < 3; c++)
            w[c] += after[k][c] * (v[k] * v[k] + .0245786 * v[k] - .000090537) /
                    (.983729 * v[k] * v[k] + .432951 * v[k] + .238081);
    for (int c = 0; c < 3; c++)
        out[c] = fmin(fmax(w[c], 0), 1);
}

static double random_value(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 40) * 0x1p-24;
}

static void aces_is_the_published_fit(void **state)
{
    (void)state;
    enum { N = 20000 };
    static float in[3 * N], light[3 * N];
    static uint8_t codes[3 * N];
    uint64_t seed = 7;
    for (int i = 0; i < 3 * N; i++)
        in[i] = (float)exp2(16 * random_value(&seed) - 10);
    lf_tone *tone = tone_of(0.4, "aces");
    lf_tone_linear(tone, N, in, light);
    lf_tone_map(tone, N, in, codes);
    for (int i = 0; i < 3 * N; i++) {
        double expected[3];
        aces_of(0.4, in + i / 3 * 3, expected);
        lf_assert_close((double)light[i], expected[i % 3], 1e-6, 1e-7);
        assert_int_equal(codes[i], code_of(0, false, light[i]));
    }
    lf_tone_linear(tone, N, in, in);
    assert_memory_equal(in, light, sizeof in);
    lf_tone_destroy(tone);
}

/* Bright red goes towards white, which a curve a channel cannot do; grey stays grey; what is no
 * number is black and takes nothing with it. */
static void aces_mixes_channels(void **state)
{
    (void)state;
    lf_tone *tone = tone_of(0, "aces"), *apart = tone_of(0, "filmic");
    const float in[5][3] = {
        {20, 0, 0}, {0.18f, 0.18f, 0.18f}, {NAN, 1, -1}, {INFINITY, INFINITY, INFINITY}, {0, 0, 0}};
    uint8_t out[5][3], one[3];
    lf_tone_map(tone, 5, in[0], out[0]);
    lf_tone_map(apart, 1, in[0], one);
    assert_true(out[0][0] == 255 && out[0][1] > 100 && out[0][2] > 100);
    assert_true(one[0] == 255 && one[1] == 0 && one[2] == 0);
    assert_true(out[1][0] == out[1][1] && out[1][1] == out[1][2]);
    assert_int_equal(out[1][0], code_of(0, false,
                                        (float)((.18 * .2045786 - .000090537) /
                                                (.18 * (.983729 * .18 + .432951) + .238081))));
    assert_true(out[2][0] < out[2][1] && out[2][2] < out[2][1]);
    for (int c = 0; c < 3; c++) {
        assert_int_equal(out[3][c], 255);
        assert_int_equal(out[4][c], 0);
    }
    lf_tone_destroy(tone);
    lf_tone_destroy(apart);
}

/* Brighter in is never darker out; the matrices are rounded, so that a channel of grey may be a
 * code off. */
static void aces_rises(void **state)
{
    (void)state;
    lf_tone *tone = tone_of(0, "aces");
    int before[3] = {0};
    for (uint32_t bits = 0; bits <= 0x7f800000; bits += 10007) {
        const float in[3] = {float_of(bits), float_of(bits), float_of(bits)};
        uint8_t out[3];
        lf_tone_map(tone, 1, in, out);
        for (int c = 0; c < 3; c++) {
            assert_true(out[c] >= before[c] && abs(out[c] - out[0]) <= 1);
            before[c] = out[c];
        }
    }
    assert_int_equal(before[0], 255);
    lf_tone_destroy(tone);
}

/* The means of n values from low to high, each all over 8x8 pixels of a view, are within 0.03 codes
 * of what they are before rounding. */
static void check_means(const lf_tone *tone, bool filmic, double low, double high, int n)
{
    for (int k = 0; k < n; k++) {
        const float value = (float)(low + (high - low) * k / n);
        float in[24];
        int sum = 0, least = 255, most = 0;
        for (int i = 0; i < 24; i++)
            in[i] = value;
        for (int row = 0; row < 8; row++) {
            uint8_t out[24];
            lf_tone_dither(tone, k % 45, row, 8, in, out);
            for (int i = 0; i < 24; i++) {
                sum += out[i];
                least = out[i] < least ? out[i] : least;
                most = out[i] > most ? out[i] : most;
            }
        }
        double mean = sum / 192.0, wanted = level_of(0, filmic, value);
        if (fabs(mean - wanted) > 0.03)
            fail_msg("%g: mean code %g, expected %g", (double)value, mean, wanted);
        assert_true(most - least <= 1);
    }
}

static void dithered_codes_have_the_mean_before_rounding(void **state)
{
    (void)state;
    for (int filmic = 0; filmic < 2; filmic++) {
        lf_tone *tone = tone_of(0, filmic ? "filmic" : "srgb");
        check_means(tone, filmic, 0, 0.01, 1000);
        check_means(tone, filmic, 0.01, filmic ? 8 : 1.1, 5000);
        lf_tone_destroy(tone);
    }
}

/* Black, white, what is no light and the values of an 8-bit picture: no noise in what is exact. */
static void codes_before_rounding_are_not_dithered(void **state)
{
    (void)state;
    lf_tone *tone = tone_of(0, "srgb");
    for (int i = 0; i < 256 + 5; i++) {
        const float odd[] = {NAN, -1, -INFINITY, INFINITY, 3};
        const double s = i / 255.0;
        const float value = i >= 256
                                ? odd[i - 256]
                                : (float)(s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4));
        const float in[24] = {value, value, value, value, value, value, value, value,
                              value, value, value, value, value, value, value, value,
                              value, value, value, value, value, value, value, value};
        for (int row = 0; row < 8; row++) {
            uint8_t out[24];
            lf_tone_dither(tone, 0, row, 8, in, out);
            for (int c = 0; c < 24; c++)
                assert_int_equal(out[c], i < 256 ? i : i < 259 ? 0 : 255);
        }
    }
    lf_tone_destroy(tone);
}

/* The pattern is that of the pixel's column, whatever the width; each view has another. */
static void dither_follows_column_and_view(void **state)
{
    (void)state;
    enum { WIDTH = 300 };
    static float in[3 * WIDTH];
    static const char *const maps[] = {"srgb", "filmic", "aces", "neutral"};
    for (int i = 0; i < 3 * WIDTH; i++)
        in[i] = 0.4f + 0.0005f * (float)(i / 3 % 8);
    for (int m = 0; m < 4; m++) {
        lf_tone *tone = tone_of(0, maps[m]);
        static uint8_t out[3 * WIDTH], other[3 * WIDTH];
        lf_tone_dither(tone, 0, 5, WIDTH, in, out);
        for (int i = 3 * 8; i < 3 * WIDTH; i++)
            assert_int_equal(out[i], out[i - 3 * 8]);
        lf_tone_dither(tone, 1, 5, WIDTH, in, other);
        assert_memory_not_equal(out, other, sizeof out);
        lf_tone_dither(tone, 8, 5, WIDTH, in, other);
        assert_memory_equal(out, other, sizeof out);
        lf_tone_destroy(tone);
    }
}

static void unknown_curves_and_exposures_are_refused(void **state)
{
    (void)state;
    lf_tone *tone = NULL;
    lf_error err;
    lf_assert_status(lf_tone_create(0, "agx", &tone, &err), LF_E_ARG, &err);
    lf_assert_status(lf_tone_create(0, "", &tone, &err), LF_E_ARG, &err);
    lf_assert_status(lf_tone_create(NAN, "srgb", &tone, &err), LF_E_ARG, &err);
    lf_assert_status(lf_tone_create(64.1, "srgb", &tone, &err), LF_E_ARG, &err);
    lf_assert_status(lf_tone_create(-INFINITY, "srgb", &tone, &err), LF_E_ARG, &err);
    assert_null(tone);
    lf_tone_destroy(NULL);
}

/* ----------------------------------------------------------------------------------- neutral -- */

/* Khronos' formulas worked out by hand: below 0.8 less what surfaces reflect, above it bent towards
 * 1 and, of a pure colour, towards white. */
static void neutral_is_as_worked_out_by_hand(void **state)
{
    (void)state;
    static const struct {
        float in[3];
        double out[3];
    } cases[] = {{{0.5f, 0.5f, 0.5f}, {0.46, 0.46, 0.46}},
                 {{0.04f, 0.04f, 0.04f}, {0.01, 0.01, 0.01}},
                 {{0.6f, 0.3f, 0.1f}, {0.56, 0.26, 0.06}},
                 {{2.0f, 2.0f, 2.0f}, {0.96, 0.96, 0.96}},
                 {{1.0f, 0.0f, 0.0f}, {0.88, 0.015560, 0.015560}}};
    lf_tone *tone = tone_of(0, "neutral");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        float light[3];
        lf_tone_linear(tone, 1, cases[i].in, light);
        for (int c = 0; c < 3; c++)
            lf_assert_close((double)light[c], cases[i].out[c], 0, 2e-6);
    }
    lf_tone_destroy(tone);
}

/* However bright, a grey is grey, brighter for more light, and below 1. */
static void neutral_rises_and_stays_below_white(void **state)
{
    (void)state;
    lf_tone *tone = tone_of(0, "neutral");
    float before = -1.0f;
    for (double stops = -12.0; stops < 10.0; stops += 0.25) {
        const float value = (float)exp2(stops), in[3] = {value, value, value};
        float light[3];
        lf_tone_linear(tone, 1, in, light);
        assert_true(light[0] > before && light[0] < 1.0f);
        lf_assert_close((double)light[1], (double)light[0], 1e-6, 0);
        before = light[0];
    }
    lf_tone_destroy(tone);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(codes_are_the_rounded_formula_over_all_floats),
        cmocka_unit_test(codes_change_exactly_where_the_formula_does),
        cmocka_unit_test(what_is_no_light_is_black_and_too_much_is_white),
        cmocka_unit_test(decoding_and_mapping_are_inverse),
        cmocka_unit_test(any_number_of_pixels_is_mapped_alike),
        cmocka_unit_test(display_light_is_what_the_codes_are_made_of),
        cmocka_unit_test(aces_is_the_published_fit),
        cmocka_unit_test(aces_mixes_channels),
        cmocka_unit_test(aces_rises),
        cmocka_unit_test(neutral_is_as_worked_out_by_hand),
        cmocka_unit_test(neutral_rises_and_stays_below_white),
        cmocka_unit_test(dithered_codes_have_the_mean_before_rounding),
        cmocka_unit_test(codes_before_rounding_are_not_dithered),
        cmocka_unit_test(dither_follows_column_and_view),
        cmocka_unit_test(unknown_curves_and_exposures_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
