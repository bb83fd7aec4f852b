/* Rough glass as pivots that views share: mvpt against vpt by tiles, replicates being seeds; its
 * weights; and mistakes in either that must be caught. */
#include "tests/testing.h"

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 32, height = 24, n_views = 3, tile = 8, blocks_of_all = n_views * 12 + 1 };

/* Three answers, and the weights twice. */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 5 * blocks_of_all)
#define CERTAIN 1e-9

static void schedule(lf_renderer *r)
{
    lf_test_passes(r, 5 * n_views);
}

static void pictures(const char *integrator, lf_estimator estimator, unsigned faults, uint64_t seed,
                     lf_blocks *out)
{
    lf_scene *scene = lf_test_scene(lf_test_scene_text("rough-glass"));
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    r->faults = faults;
    lf_test_pictures(r, schedule, estimator, 16, seed, tile, out);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static void views_share_rough_glass_and_see_what_each_alone_does(void **state)
{
    (void)state;
    lf_blocks alone, shared;
    int where = 0;
    pictures("vpt", LF_ESTIMATOR_MIS, 0, 1000, &alone);
    for (int i = 0; i < 3; i++) {
        pictures("mvpt", (lf_estimator[]){LF_ESTIMATOR_MIS, LF_ESTIMATOR_CV, LF_ESTIMATOR_MWIS}[i],
                 0, 2000, &shared);
        double p = lf_blocks_welch(&shared, &alone, &where);
        if (!(p > LEVEL))
            fail_msg("answer %d, block %d: %.5g +- %.2g, alone %.5g +- %.2g, p %.2g", i, where,
                     shared.moments[where].mean, lf_moments_error(&shared.moments[where]),
                     alone.moments[where].mean, lf_moments_error(&alone.moments[where]), p);
        /* Its own power: 2 % of the whole picture would show. */
        assert_true(lf_blocks_welch_injected(&shared, &alone, blocks_of_all - 1, 1.02) < LEVEL);
        lf_blocks_finish(&shared);
    }
    pictures("mvpt", LF_ESTIMATOR_MIS, LF_FAULT_NO_LIGHT_PDF, 2000, &shared);
    assert_true(lf_blocks_welch(&shared, &alone, NULL) < CERTAIN);
    lf_blocks_finish(&shared);
    lf_blocks_finish(&alone);
}

static void weights_of_rough_glass_are_what_is_expected(void **state)
{
    (void)state;
    lf_test_assert_weights(lf_test_scene_text("rough-glass"), width, height, schedule, 16, tile,
                           LEVEL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(views_share_rough_glass_and_see_what_each_alone_does),
        cmocka_unit_test(weights_of_rough_glass_are_what_is_expected),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
