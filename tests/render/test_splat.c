/* Sums that anybody may add to (render/cameras/splat.h): they do not depend on the order, what is
 * less than a step counts in the mean, and what is too much is told. */
#include "tests/testing.h"

#include "render/cameras/splat.h"
#include "render/transport/sampler.h"

static void sums_do_not_depend_on_the_order(void **state)
{
    (void)state;
    const lf_film_layout layout = {.n_views = 2, .width = 3, .height = 2, .has_known = true};
    lf_film_scattered seen[2][6];
    for (int way = 0; way < 2; way++) {
        lf_splats splats = {0};
        lf_film_sums sums = {0};
        lf_assert_ok(lf_splats_init(&splats, &layout), NULL);
        lf_assert_ok(lf_film_sums_init(&sums, &layout), NULL);
        lf_splats_scale(&splats, 2.0f);
        for (int i = 0; i < 5000; i++) {
            const int n = way ? 4999 - i : i;
            lf_tracer tracer = {.rng = lf_hash64(5, (uint64_t)n)};
            const float y = expf(6.0f * lf_rng(&tracer) - 5.0f);
            lf_splats_add(&splats, &tracer, n % 2, (size_t)(n % 6), lf_v3(y, -0.1f * y, 3.0f * y),
                          0.3 * (double)y);
        }
        for (int row = 0; row < 2; row++) {
            lf_film_sums_begin(&sums);
            lf_splats_take(&splats, row, &sums);
            for (int k = 0; k < 6; k++)
                if (row == k % 2)
                    seen[way][k] = sums.half.scattered[k];
        }
        /* it is empty by then */
        lf_film_sums_begin(&sums);
        lf_splats_take(&splats, 0, &sums);
        assert_true(sums.half.scattered[0].w == 0.0f);
        assert_int_equal(lf_splats_lost(&splats), 0);
        lf_film_sums_finish(&sums);
        lf_splats_finish(&splats);
    }
    assert_memory_equal(seen[0], seen[1], sizeof seen[0]);
    assert_true(seen[0][3].w > 1.0f);
    lf_assert_close((double)seen[0][3].n[2], 10.0 * (double)seen[0][3].w, 1e-6, 0);
}

/* What is far less than a step counts in the mean, what is too much is dropped and told. */
static void small_sums_stay_and_great_ones_are_told(void **state)
{
    (void)state;
    enum { N = 200000 };
    const lf_film_layout layout = {.n_views = 1, .width = 2, .height = 1, .has_known = true};
    lf_splats splats = {0};
    lf_film_sums sums = {0};
    lf_tracer tracer = {.rng = lf_test_seed()};
    lf_assert_ok(lf_splats_init(&splats, &layout), NULL);
    lf_assert_ok(lf_film_sums_init(&sums, &layout), NULL);
    lf_splats_scale(&splats, 1.0f);
    const double small = 0.01 * LF_SPLAT_WEIGHT;
    for (int i = 0; i < N; i++)
        lf_splats_add(&splats, &tracer, 0, 0, lf_v3(0.0f, 0.0f, 0.0f), small);
    lf_film_sums_begin(&sums);
    lf_splats_take(&splats, 0, &sums);
    /* five standard deviations of 2000 successes */
    lf_assert_close((double)sums.half.scattered[0].w, N * small, 0.12, 0);
    static const float bad[] = {INFINITY, NAN, -4e10f, 4e10f};
    for (int i = 0; i < 4; i++)
        lf_splats_add(&splats, &tracer, 0, 0, lf_v3(bad[i], 0.0f, 0.0f), 1.0);
    assert_int_equal(lf_splats_lost(&splats), 4);
    /* what is below 0 takes away, a third of a step as well */
    for (int i = 0; i < N; i++)
        lf_splats_add(&splats, &tracer, 0, 1, lf_v3(i % 2 ? -3.0f : 2.0f, -0x1p-25f / 3.0f, 0.0f),
                      0.0);
    assert_int_equal(lf_splats_lost(&splats), 4);
    lf_film_sums_begin(&sums);
    lf_splats_take(&splats, 0, &sums);
    lf_assert_close((double)sums.half.scattered[1].n[0], -0.5 * N, 1e-6, 0);
    /* five standard deviations, of sqrt(2 N) / 3 */
    lf_assert_close((double)sums.half.scattered[1].n[1], -N * 0x1p-25 / 3.0, 0.016, 0);
    /* and sums that go round, each once, whatever the others do */
    for (int i = 0; i < 40; i++)
        lf_splats_add(&splats, &tracer, 0, 0, lf_v3(2e10f, i < 39 ? 2e10f : 1e10f, 0.0f), 1.0);
    assert_int_equal(lf_splats_lost(&splats), 6);
    lf_film_sums_begin(&sums);
    lf_splats_take(&splats, 0, &sums);
    lf_assert_close((double)sums.half.scattered[0].n[1], 79e10 - 0x1p39, 1e-6, 0);
    /* downwards as upwards */
    lf_splats_finish(&splats);
    lf_assert_ok(lf_splats_init(&splats, &layout), NULL);
    lf_splats_scale(&splats, 2.0f);
    for (int i = 0; i < 40; i++)
        lf_splats_add(&splats, &tracer, 0, 0, lf_v3(-2e10f, 0.0f, 0.0f), 1.0);
    assert_true(lf_splats_lost(&splats) > 0);
    lf_film_sums_finish(&sums);
    lf_splats_finish(&splats);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sums_do_not_depend_on_the_order),
        cmocka_unit_test(small_sums_stay_and_great_ones_are_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
