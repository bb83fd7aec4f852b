/* What is stated of the shown picture's error before rare bright paths, which two halves meet in
 * one pixel by chance. Films are made of numbers with a known truth, in place of what was found. */
#include "tests/render/reconstruct_testing.h"
#include "tests/scene_file.h"

#include <math.h>

#include "render/reconstruct/shown_error.h"
#include "render/transport/sampler.h"

enum { width = 48, height = 48, views = 5, values = 3 * width * height * views, SEEDS = 96 };

static float uniform(uint64_t salt, int row, int half, int column)
{
    uint64_t place = (uint64_t)((row * 2 + half) * width + column);
    return (float)(lf_hash64(lf_hash64(lf_test_seed(), salt), place) >> 40) * 0x1p-24f;
}

/* Dark, with spots of 3x3 pixels that no feature knows. */
static float truth_at(int row, int column)
{
    const uint64_t place = (uint64_t)((row / 3) * width + column / 3);
    return lf_hash64(77, place) % 12 == 0 ? 0.6f : 0.05f;
}

/* Of mean 1: RARE in a pixel of sixteen of each half, all views alike, as they share their paths.
 */
#define RARE 12.0f
static float noise_at(uint64_t salt, int row, int half, int column)
{
    const float p = 1.0f / 16.0f;
    return uniform(salt, row, half, column) < p ? RARE : (1.0f - p * RARE) / (1.0f - p);
}

static void make_film(lf_renderer *r, uint64_t salt, float *truth)
{
    for (int row = 0; row < height; row++) {
        lf_film_known *known = lf_film_known_at(&r->film, row);
        for (int i = 0; i < views * width; i++) {
            const float q =
                0.5f * (lf_film_at(&r->film, row, 0).q[i] + lf_film_at(&r->film, row, 1).q[i]);
            for (int h = 0; h < 2; h++) {
                const lf_film_half half = lf_film_at(&r->film, row, h);
                half.scattered[i].w = (float)r->film.rows[row].n[h] * half.q[i];
                if (half.w2)
                    half.w2[i] = half.scattered[i].w;
                for (int c = 0; c < 3; c++)
                    half.scattered[i].n[c] = half.scattered[i].w * truth_at(row, i % width) *
                                             noise_at(salt, row, h, i % width);
            }
            for (int c = 0; c < 3; c++)
                truth[3 * (row * views * width + i) + c] = q * truth_at(row, i % width);
        }
        if (known)
            for (int i = 0; i < views * width; i++)
                known[i] = (lf_film_known){.difference = 0};
    }
}

/* Means over films, and how often the bound holds. */
typedef struct lf_told {
    double shown, stated;
    int held;
} lf_told;

static lf_told tell(lf_renderer *r)
{
    float *x = malloc(values * sizeof *x), *truth = malloc(values * sizeof *truth);
    lf_told out = {.held = 0};
    assert_non_null(x);
    assert_non_null(truth);
    for (uint64_t k = 0; k < SEEDS; k++) {
        double stated, shown;
        make_film(r, k, truth);
        lf_assert_ok(lf_renderer_show(r, x, NULL), NULL);
        assert_true(r->shown->is_bright);
        shown = lf_test_rel_mse(x, truth, values);
        out.held += lf_renderer_shown_error(r, 0.05, &stated, NULL) >= shown;
        out.shown += shown / SEEDS;
        out.stated += stated / SEEDS;
    }
    free(x);
    free(truth);
    return out;
}

/* Of eight seeds: 0.54 to 0.63 of the error is stated, and the bound holds in 67 to 78 of 96 (72.6,
 * deviation 3.4). When a half was wholly trusted that a pixel is bright: 0.42 to 0.47, and 38 to 50
 * (44.8, deviation 4.7). Limits lie between: false alarms are below 1 in 1000, and as seldom would
 * that pass. It is no bound of 95 % yet (docs/lab/error-estimates.md). */
static void rare_bright_paths_are_stated(void **state)
{
    (void)state;
    lf_renderer *r =
        reconstruct_renderer(lf_test_scene_views("metal-wall", 5), width, height, NULL);
    reconstruct_visits(r, NULL, 4);
    const lf_told t = tell(r);
    print_message("off by %.3g, stated %.2f of it; the bound holds in %d of %d\n", t.shown,
                  t.stated / t.shown, t.held, SEEDS);
    assert_true(t.stated > 0.5 * t.shown && t.stated < 2.0 * t.shown);
    assert_true(t.held >= 60);
    lf_renderer_destroy(r);
}

/* ------------------------------------------------------------------------------ closed forms -- */

/* Rows that differ in the variance alone, or in the bias alone, say as much against the estimate.
 */
static void the_bound_counts_the_noise_of_the_variance(void **state)
{
    (void)state;
    enum { ROWS = 64 };
    lf_shown_row variance[ROWS], bias[ROWS], opposite[ROWS];
    const lf_shown_chosen none = {0.0, 0.0}, some = {0.5, 1.5};
    double estimate;
    for (int i = 0; i < ROWS; i++) {
        const double x = i % 2 ? 2.0 : 0.0;
        variance[i] = (lf_shown_row){x, 0.0};
        bias[i] = (lf_shown_row){0.0, x};
        opposite[i] = (lf_shown_row){x, 2.0 - x};
    }
    const double bound = lf_shown_error_bound(variance, ROWS, &none, 0.05, &estimate);
    lf_assert_close(estimate, 1.0, 1e-12, 0.0);
    /* 63 differences of 2: the deviation of the mean is sqrt(2/64), with 63 degrees of freedom */
    lf_assert_close(bound, 1.0 + lf_upper_quantile(0.05, 63.0) * sqrt(2.0 / ROWS), 1e-12, 0.0);
    lf_assert_close(lf_shown_error_bound(bias, ROWS, &none, 0.05, &estimate), bound, 1e-12, 0.0);
    /* all rows say the same in sum */
    lf_assert_close(lf_shown_error_bound(opposite, ROWS, &none, 0.05, &estimate), 2.0, 1e-12, 0.0);
    lf_assert_close(lf_shown_error_bound(opposite, ROWS, &some, 0.05, &estimate), 3.5, 1e-12, 0.0);
    lf_assert_close(estimate, 2.5, 1e-12, 0.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rare_bright_paths_are_stated),
        cmocka_unit_test(the_bound_counts_the_noise_of_the_variance),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
