/* What is sent to a panel that is not sRGB: what it then shows is. */
#include "tests/testing.h"

#include "quilt/quilt.h"

static lf_codes codes_of(lf_response response)
{
    lf_codes codes;
    lf_error err;
    lf_assert_ok(lf_response_codes(&response, &codes, &err), &err);
    return codes;
}

static double light_of(int code)
{
    double s = code / 255.0;
    return s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4);
}

static void a_panel_that_is_srgb_gets_what_there_is(void **state)
{
    (void)state;
    const lf_response same[] = {
        {0}, {.gamma = (double)INFINITY}, {.white = 6500}, {.white_x = 0.3127, .white_y = 0.3290}};
    for (size_t k = 0; k < sizeof same / sizeof *same; k++) {
        lf_codes codes = codes_of(same[k]);
        assert_true(codes.same);
        for (int c = 0; c < 3; c++)
            for (int i = 0; i < 256; i++)
                assert_int_equal(codes.code[c][i], i);
    }
}

/* code^gamma is the light that was meant, to half a code; no code is lost at the ends. */
static void a_panels_gamma_is_undone(void **state)
{
    (void)state;
    const double gammas[] = {1, 1.8, 2.2, 2.4, 4};
    for (size_t k = 0; k < 5; k++) {
        lf_codes codes = codes_of((lf_response){.gamma = gammas[k]});
        assert_false(codes.same);
        for (int c = 0; c < 3; c++)
            for (int i = 0; i < 256; i++) {
                int code = codes.code[c][i];
                assert_true(pow(fmax(code - 0.51, 0) / 255, gammas[k]) <= light_of(i));
                assert_true(pow((code + 0.51) / 255, gammas[k]) >= light_of(i));
            }
        assert_true(codes.code[1][0] == 0 && codes.code[1][255] == 255);
    }
}

/* ------------------------------------------------------------------------------------- white -- */

static double det(const double m[3][3])
{
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/* How much XYZ each channel of a panel gives whose primaries are those of Rec. 709 and whose white
 * is at x, y: by Cramer's rule. */
static void primaries_of(double x, double y, double out[3][3])
{
    static const double xy[3][2] = {{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}};
    const double white[3] = {x / y, 1, (1 - x - y) / y};
    double m[3][3];
    for (int c = 0; c < 3; c++) {
        m[0][c] = xy[c][0] / xy[c][1];
        m[1][c] = 1;
        m[2][c] = (1 - xy[c][0] - xy[c][1]) / xy[c][1];
    }
    for (int c = 0; c < 3; c++) {
        double replaced[3][3];
        memcpy(replaced, m, sizeof m);
        for (int i = 0; i < 3; i++)
            replaced[i][c] = white[i];
        for (int i = 0; i < 3; i++)
            out[i][c] = m[i][c] * det((const double(*)[3])replaced) / det((const double(*)[3])m);
    }
}

/* Chromaticity of what such a panel shows of these codes. */
static void shown(const lf_codes *codes, const double primaries[3][3], int level, double out[2])
{
    double xyz[3] = {0};
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < 3; c++)
            xyz[i] += primaries[i][c] * light_of(codes ? codes->code[c][level] : level);
    out[0] = xyz[0] / (xyz[0] + xyz[1] + xyz[2]);
    out[1] = xyz[1] / (xyz[0] + xyz[1] + xyz[2]);
}

static void white_on_any_panel_is_d65(void **state)
{
    (void)state;
    const double whites[][2] = {{0.2831, 0.2971}, {0.3457, 0.3585}, {0.33, 0.31}, {0.29, 0.33}};
    for (size_t k = 0; k < 4; k++) {
        double primaries[3][3], at[2], x = whites[k][0], y = whites[k][1];
        lf_codes codes = codes_of((lf_response){.white_x = x, .white_y = y});
        primaries_of(x, y, primaries);
        int most = 0;
        for (int c = 0; c < 3; c++)
            most = codes.code[c][255] > most ? codes.code[c][255] : most;
        assert_int_equal(most, 255); /* as bright as it goes */
        for (int level = 128; level < 256; level += 127) {
            shown(&codes, (const double(*)[3])primaries, level, at);
            lf_assert_close(at[0], 0.3127, 0, 0.0015);
            lf_assert_close(at[1], 0.3290, 0, 0.0015);
            /* negative control */
            shown(NULL, (const double(*)[3])primaries, level, at);
            assert_true(hypot(at[0] - 0.3127, at[1] - 0.3290) > 0.01);
        }
    }
}

/* The published chromaticities of D50, D55, D75; 9300 K after the formula. */
static void a_temperature_is_that_of_daylight(void **state)
{
    (void)state;
    const double daylight_of[][3] = {{5000, 0.3457, 0.3585},
                                     {5500, 0.3324, 0.3474},
                                     {7500, 0.2990, 0.3149},
                                     {9300, 0.2831, 0.2971}};
    for (size_t k = 0; k < 4; k++) {
        lf_codes warm = codes_of((lf_response){.white = daylight_of[k][0]}),
                 same = codes_of(
                     (lf_response){.white_x = daylight_of[k][1], .white_y = daylight_of[k][2]});
        for (int c = 0; c < 3; c++)
            for (int i = 0; i < 256; i++)
                assert_true(abs(warm.code[c][i] - same.code[c][i]) <= 1);
    }
    lf_codes warm = codes_of((lf_response){.white = 5000}),
             cold = codes_of((lf_response){.white = 9300});
    assert_true(warm.code[2][255] == 255 && warm.code[0][255] < 240);
    assert_true(cold.code[0][255] == 255 && cold.code[2][255] < 240);
}

static void whites_that_cannot_be_are_refused(void **state)
{
    (void)state;
    const lf_response bad[] = {{.white = 6500, .white_x = 0.3, .white_y = 0.3},
                               {.white_x = 0.3},
                               {.white_y = 0.3},
                               {.white_x = 0.7, .white_y = 0.3},
                               {.white_x = 0.1, .white_y = 0.6}};
    lf_codes codes = {.same = true};
    lf_error err;
    for (size_t k = 0; k < 5; k++)
        lf_assert_status(lf_response_codes(&bad[k], &codes, &err), LF_E_ARG, &err);
    assert_true(codes.same);
}

static void every_subpixel_gets_its_channels_code(void **state)
{
    (void)state;
    lf_codes codes = codes_of((lf_response){.gamma = 2.2, .white = 9000});
    lf_image8 image = {0};
    lf_pool *pool;
    assert_int_equal(lf_image8_init(&image, 37, 11, 3), LF_OK);
    assert_int_equal(lf_pool_create(2, &pool), LF_OK);
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < 37 * 11 * 3; i++)
            image.data[i] = (uint8_t)(i * 7);
        lf_codes_apply(&codes, &image, pass ? pool : NULL);
        for (int i = 0; i < 37 * 11 * 3; i++)
            assert_int_equal(image.data[i], codes.code[i % 3][(uint8_t)(i * 7)]);
    }
    lf_pool_destroy(pool);
    lf_image8_finish(&image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_panel_that_is_srgb_gets_what_there_is),
        cmocka_unit_test(a_panels_gamma_is_undone),
        cmocka_unit_test(white_on_any_panel_is_d65),
        cmocka_unit_test(a_temperature_is_that_of_daylight),
        cmocka_unit_test(whites_that_cannot_be_are_refused),
        cmocka_unit_test(every_subpixel_gets_its_channels_code),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
