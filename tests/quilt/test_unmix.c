/* Dots to print so that an eye sees a given light: closed forms, the gamut, parts. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "quilt/print/unmix.h"

static const double pi = 3.14159265358979323846;

#define MOST 512

static double random_of(uint32_t *seed)
{
    *seed = *seed * 1664525U + 1013904223U;
    return (double)(*seed >> 8) * 0x1p-24;
}

/* What an eye sees at every place, in one lane. */
static void see(const lf_crosstalk *k, const double *dots, int lane, double *out)
{
    for (int t = 0; t < k->n_places; t++) {
        out[t] = 0.0;
        for (int d = 0; d < k->width; d++)
            out[t] += lf_crosstalk_row(k, t)[d] * dots[(k->first[t] + d) * LF_UNMIX_LANES + lane];
    }
}

/* Prints wanted with the stripes themselves as the first print. Returns the squares' sum of what
 * is seen otherwise; light[n][LF_UNMIX_LANES]. */
static double unmixed(const lf_crosstalk *k, const double *wanted, double *light)
{
    lf_unmix unmix;
    double seen[MOST], sum = 0.0;
    assert_int_equal(lf_unmix_init(&unmix, k), LF_OK);
    const lf_unmix_part all = lf_unmix_part_of(&unmix, 0, k->n_dots);
    lf_unmix_light(&unmix, &all, wanted, light);
    for (int lane = 0; lane < LF_UNMIX_LANES; lane++) {
        see(k, light, lane, seen);
        for (int t = 0; t < k->n_places; t++)
            sum += pow(seen[t] - wanted[t * LF_UNMIX_LANES + lane], 2);
    }
    lf_unmix_finish(&unmix);
    return sum;
}

/* ------------------------------------------------------------------------------ closed forms -- */

/* Two stripes with the shares 0.8 and 0.2 have the inverse [0.8 -0.2; -0.2 0.8] / 0.6. */
static void two_views_have_the_inverse_of_a_2_x_2_matrix(void **state)
{
    (void)state;
    const double kernel[3] = {0.2, 0.8, 0.2};
    const double wanted[2 * LF_UNMIX_LANES] = {0.3, 0.5, 0.4, 0.5, 0.6, 0.5, 0.4, 0.2};
    double light[2 * LF_UNMIX_LANES];
    lf_crosstalk k;
    assert_int_equal(lf_crosstalk_of_kernel(kernel, 2, 1, &k), LF_OK);
    lf_assert_close(k.share[0], 0.8, 0.0, 1e-12);
    lf_assert_close(k.share[1], 0.2, 0.0, 1e-12);
    memcpy(light, wanted, sizeof light);
    unmixed(&k, wanted, light);
    for (int lane = 0; lane < LF_UNMIX_LANES - 1; lane++) {
        const double a = wanted[lane], b = wanted[LF_UNMIX_LANES + lane];
        lf_assert_close(light[lane], (0.8 * a - 0.2 * b) / 0.6, 0.0, 1e-6);
        lf_assert_close(light[LF_UNMIX_LANES + lane], (0.8 * b - 0.2 * a) / 0.6, 0.0, 1e-6);
    }
    lf_crosstalk_finish(&k);
}

/* [0.75 0.25 0; 0.2 0.6 0.2; 0 0.25 0.75]: from light to what is seen and back. */
static void three_views_come_back(void **state)
{
    (void)state;
    const double kernel[3] = {0.2, 0.6, 0.2};
    const double light[3] = {0.1, 0.9, 0.4};
    const double seen[3] = {0.75 * 0.1 + 0.25 * 0.9, 0.2 * 0.1 + 0.6 * 0.9 + 0.2 * 0.4,
                            0.25 * 0.9 + 0.75 * 0.4};
    double wanted[3 * LF_UNMIX_LANES], printed[3 * LF_UNMIX_LANES];
    lf_crosstalk k;
    assert_int_equal(lf_crosstalk_of_kernel(kernel, 3, 1, &k), LF_OK);
    for (int i = 0; i < 3 * LF_UNMIX_LANES; i++)
        printed[i] = wanted[i] = seen[i / LF_UNMIX_LANES];
    unmixed(&k, wanted, printed);
    for (int i = 0; i < 3 * LF_UNMIX_LANES; i++)
        lf_assert_close(printed[i], light[i / LF_UNMIX_LANES], 0.0, 1e-6);
    lf_crosstalk_finish(&k);
}

/* A kernel weakens a wave of frequency f by H(f) = sum of kernel[d] cos(2 pi f d), far from the
 * ends. */
static void waves_are_amplified_by_fourier(void **state)
{
    (void)state;
    enum { N = 200 };
    const double kernel[5] = {0.02, 0.13, 0.70, 0.13, 0.02};
    double wanted[N * LF_UNMIX_LANES], light[N * LF_UNMIX_LANES];
    lf_crosstalk k;
    assert_int_equal(lf_crosstalk_of_kernel(kernel, N, 2, &k), LF_OK);
    for (int i = 0; i < N * LF_UNMIX_LANES; i++)
        light[i] = wanted[i] =
            0.5 + 0.1 * cos(2.0 * pi * 0.125 * (i % LF_UNMIX_LANES + 1) * (i / LF_UNMIX_LANES));
    unmixed(&k, wanted, light);
    for (int i = 80 * LF_UNMIX_LANES; i < 120 * LF_UNMIX_LANES; i++) {
        const double f = 2.0 * pi * 0.125 * (i % LF_UNMIX_LANES + 1);
        const double h = 0.70 + 2.0 * 0.13 * cos(f) + 2.0 * 0.02 * cos(2.0 * f);
        lf_assert_close(light[i], 0.5 + 0.1 / h * cos(f * (i / LF_UNMIX_LANES)), 0.0, 1e-6);
    }
    lf_crosstalk_finish(&k);
}

/* ------------------------------------------------------------------------------------- spots -- */

static void a_spot_has_the_shares_of_its_area(void **state)
{
    (void)state;
    const double middle[3] = {2.5, 4.0, 6.75};
    lf_crosstalk_look look = {.middle = middle, .n_places = 3, .n_dots = 12, .spot = {1.0, 0.0}};
    lf_crosstalk k;
    double dots[12 * LF_UNMIX_LANES] = {0.0}, seen[3];
    assert_int_equal(lf_crosstalk_of_look(&look, &k), LF_OK);
    dots[2 * LF_UNMIX_LANES] = dots[4 * LF_UNMIX_LANES] = dots[6 * LF_UNMIX_LANES] = 1.0;
    see(&k, dots, 0, seen);
    lf_assert_close(seen[0], 1.0, 0.0, 1e-12);  /* on pixel 2 */
    lf_assert_close(seen[1], 0.5, 0.0, 1e-12);  /* between 3 and 4 */
    lf_assert_close(seen[2], 0.75, 0.0, 1e-12); /* from 6.25 to 7.25 */
    lf_crosstalk_finish(&k);

    /* a narrow box in ink: the Gaussian's integral over the pixel */
    look.spot = (lf_print_spot){1e-3, 0.5};
    assert_int_equal(lf_crosstalk_of_look(&look, &k), LF_OK);
    see(&k, dots, 0, seen);
    lf_assert_close(seen[0],
                    erf(0.5 / (0.5 * sqrt(2.0))) +
                        0.5 * (erf(2.5 / (0.5 * sqrt(2.0))) - erf(1.5 / (0.5 * sqrt(2.0)))),
                    0.0, 2e-4);
    lf_crosstalk_finish(&k);
}

static void spots_that_are_too_wide_are_refused(void **state)
{
    (void)state;
    const double middle[1] = {50.0};
    lf_crosstalk_look look = {.middle = middle, .n_places = 1, .n_dots = 100, .spot = {70.0, 0.0}};
    lf_crosstalk k;
    assert_int_equal(lf_crosstalk_of_look(&look, &k), LF_E_ARG);
    look.spot.box_px = 5.0;
    look.n_dots = 5;
    assert_int_equal(lf_crosstalk_of_look(&look, &k), LF_E_ARG);
}

/* ------------------------------------------------------------------------------------- gamut -- */

/* Places at the middles of 8 stripes on 9.978 pixels, of 40 lenses. */
static void raster_look(double *middle, double ink_px, lf_crosstalk *out)
{
    const int n = 8 * 40;
    for (int t = 0; t < n; t++)
        middle[t] = (t + 0.5) * 9.978 / 8.0 + 0.3;
    const lf_crosstalk_look look = {
        .middle = middle, .n_places = n, .n_dots = 400, .spot = {0.5 * 9.978 / 8.0, ink_px}};
    assert_int_equal(lf_crosstalk_of_look(&look, out), LF_OK);
}

/* What a print within the gamut shows is shown again. */
static void what_the_gamut_allows_is_seen_exactly(void **state)
{
    (void)state;
    double middle[MOST], wanted[MOST * LF_UNMIX_LANES], light[MOST * LF_UNMIX_LANES], seen[MOST];
    uint32_t seed = 5;
    lf_crosstalk k;
    raster_look(middle, 0.3, &k);
    for (int i = 0; i < k.n_dots * LF_UNMIX_LANES; i++)
        light[i] = 0.4 + 0.2 * random_of(&seed);
    for (int lane = 0; lane < LF_UNMIX_LANES; lane++) {
        see(&k, light, lane, seen);
        for (int t = 0; t < k.n_places; t++)
            wanted[t * LF_UNMIX_LANES + lane] = seen[t];
    }
    for (int i = 0; i < k.n_dots * LF_UNMIX_LANES; i++)
        light[i] = 0.5;
    const double sum = unmixed(&k, wanted, light);
    assert_true(sqrt(sum / (k.n_places * LF_UNMIX_LANES)) < 1e-6);
    lf_crosstalk_finish(&k);
}

/* Black and white at random: within the gamut, and never worse than the print that came in. */
static void views_beyond_the_gamut_are_never_worse(void **state)
{
    (void)state;
    double middle[MOST], wanted[MOST * LF_UNMIX_LANES], light[MOST * LF_UNMIX_LANES],
        plain[MOST * LF_UNMIX_LANES];
    lf_crosstalk k;
    for (uint32_t round = 0; round < 40; round++) {
        uint32_t seed = 77 * round + 1;
        double before = 0.0, seen[MOST];
        raster_look(middle, round % 4 * 0.4, &k);
        for (int i = 0; i < k.n_places * LF_UNMIX_LANES; i++)
            wanted[i] = round % 2 ? random_of(&seed) : (double)(random_of(&seed) > 0.5);
        for (int i = 0; i < k.n_dots * LF_UNMIX_LANES; i++) {
            const int t = (int)((i / LF_UNMIX_LANES + 0.2) * 8.0 / 9.978);
            light[i] = plain[i] =
                wanted[(t < k.n_places ? t : k.n_places - 1) * LF_UNMIX_LANES + i % LF_UNMIX_LANES];
        }
        for (int lane = 0; lane < LF_UNMIX_LANES; lane++) {
            see(&k, plain, lane, seen);
            for (int t = 0; t < k.n_places; t++)
                before += pow(seen[t] - wanted[t * LF_UNMIX_LANES + lane], 2);
        }
        assert_true(unmixed(&k, wanted, light) < before);
        for (int i = 0; i < k.n_dots * LF_UNMIX_LANES; i++)
            assert_true(light[i] >= 0.0 && light[i] <= 1.0);
        lf_crosstalk_finish(&k);
    }
}

/* The least squares within the gamut, against a search of all prints in steps of 0.01. */
static void beyond_the_gamut_the_squares_are_least(void **state)
{
    (void)state;
    const double kernel[3] = {0.2, 0.6, 0.2};
    const double cases[][3] = {{0, 1, 0}, {1, 0, 0.1}, {0.05, 0.3, 0.95}, {1, 0.9, 0}};
    lf_crosstalk k;
    assert_int_equal(lf_crosstalk_of_kernel(kernel, 3, 1, &k), LF_OK);
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        double wanted[3 * LF_UNMIX_LANES], light[3 * LF_UNMIX_LANES], best = 1e9;
        for (int i = 0; i < 3 * LF_UNMIX_LANES; i++)
            light[i] = wanted[i] = cases[c][i / LF_UNMIX_LANES];
        const double found = unmixed(&k, wanted, light) / LF_UNMIX_LANES;
        for (int i = 0; i < 101 * 101 * 101; i++) {
            const double x = i % 101 * 0.01, y = i / 101 % 101 * 0.01, z = i / 10201 * 0.01;
            best = fmin(best, pow(0.75 * x + 0.25 * y - cases[c][0], 2) +
                                  pow(0.2 * x + 0.6 * y + 0.2 * z - cases[c][1], 2) +
                                  pow(0.25 * y + 0.75 * z - cases[c][2], 2));
        }
        assert_true(found < best + 2e-4);
    }
    lf_crosstalk_finish(&k);
}

/* A part with rows around it gives what the whole gives. */
static void a_part_is_solved_as_the_whole_is(void **state)
{
    (void)state;
    double middle[MOST], wanted[MOST * LF_UNMIX_LANES], whole[MOST * LF_UNMIX_LANES],
        part[MOST * LF_UNMIX_LANES];
    uint32_t seed = 9;
    lf_crosstalk k;
    lf_unmix unmix;
    raster_look(middle, 0.3, &k);
    for (int i = 0; i < k.n_places * LF_UNMIX_LANES; i++)
        wanted[i] = 0.4 + 0.2 * random_of(&seed);
    for (int i = 0; i < k.n_dots * LF_UNMIX_LANES; i++)
        whole[i] = part[i] = 0.5;
    unmixed(&k, wanted, whole);
    assert_int_equal(lf_unmix_init(&unmix, &k), LF_OK);
    const lf_unmix_part middle_part = lf_unmix_part_of(&unmix, 120, 260);
    lf_unmix_light(&unmix, &middle_part, wanted, part);
    for (int i = 160 * LF_UNMIX_LANES; i < 220 * LF_UNMIX_LANES; i++)
        lf_assert_close(part[i], whole[i], 0.0, 1e-4);
    for (int i = 0; i < 120 * LF_UNMIX_LANES; i++)
        assert_true(part[i] == 0.5);
    lf_unmix_finish(&unmix);
    lf_crosstalk_finish(&k);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_views_have_the_inverse_of_a_2_x_2_matrix),
        cmocka_unit_test(three_views_come_back),
        cmocka_unit_test(waves_are_amplified_by_fourier),
        cmocka_unit_test(a_spot_has_the_shares_of_its_area),
        cmocka_unit_test(spots_that_are_too_wide_are_refused),
        cmocka_unit_test(what_the_gamut_allows_is_seen_exactly),
        cmocka_unit_test(views_beyond_the_gamut_are_never_worse),
        cmocka_unit_test(beyond_the_gamut_the_squares_are_least),
        cmocka_unit_test(a_part_is_solved_as_the_whole_is),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
