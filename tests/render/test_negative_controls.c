/* Deliberate mistakes in the estimator (lf_fault), each of which one of the statistical tests must catch; and the same tests with the
 * same numbers pass without them. */
#include "tests/testing.h"

#include "tests/stat/fixture.h"
#include "tests/stat/scenes.h"

enum { width = 32, height = 24, n_views = 7 };

/* What the sound estimator may fail by: three runs of the weights' test and one of agreement. */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 4 * (n_views * 12 + 1))
/* What a mistake must be rejected with. */
#define CERTAIN 1e-9

static const char scene_text[] = LF_TEST_MIXED("7", "");
static void whole_cycles(lf_renderer *r)
{
    lf_test_passes(r, 4 * n_views);
}

static void live(lf_renderer *r)
{
    for (int i = 0; i < 6; i++)
        assert_int_equal(lf_renderer_pass(r, 0, 1, 2, NULL, NULL, NULL), LF_OK);
}

/* Smallest p of W - n q over blocks of every view. */
static double p_of_weights(unsigned faults, lf_test_schedule schedule)
{
    lf_scene *scene = lf_test_scene(scene_text);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    lf_blocks blocks[3];
    r->plan.faults = faults;
    lf_test_weight_blocks(r, schedule, 24, 8, blocks);
    double p = lf_blocks_p_zero(&blocks[0], NULL);
    for (int i = 0; i < 3; i++)
        lf_blocks_finish(&blocks[i]);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return p;
}

/* Pictures of one integrator by mis. */
static void pictures(const char *integrator, unsigned faults, uint64_t seed, lf_blocks *out)
{
    lf_scene *scene = lf_test_scene(scene_text);
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    lf_blocks_init(out, n_views, width, height, 8);
    r->plan.faults = faults;
    for (int k = 0; k < 24; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + seed, (uint64_t)k));
        whole_cycles(r);
        lf_blocks_add_picture(out, r, LF_ESTIMATOR_MIS);
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static double p_of_agreement(unsigned faults)
{
    lf_blocks native, shared;
    pictures("vpt", 0, 100, &native);
    pictures("mvpt", faults, 200, &shared);
    double p = lf_blocks_welch(&shared, &native, NULL);
    lf_blocks_finish(&native);
    lf_blocks_finish(&shared);
    return p;
}

static void nothing_is_found_where_nothing_is_wrong(void **state)
{
    (void)state;
    assert_true(p_of_weights(0, whole_cycles) > LEVEL);
    assert_true(p_of_weights(0, live) > LEVEL);
    assert_true(p_of_agreement(0) > LEVEL);
}

static void a_missing_ratio_of_distances_is_caught(void **state)
{
    (void)state;
    assert_true(p_of_weights(LF_FAULT_NO_H, whole_cycles) < CERTAIN);
}

static void a_forgotten_visibility_is_caught(void **state)
{
    (void)state;
    assert_true(p_of_weights(LF_FAULT_NO_VISIBILITY, whole_cycles) < CERTAIN);
}

static void realised_counts_are_caught(void **state)
{
    (void)state;
    assert_true(p_of_weights(LF_FAULT_REALISED, live) < CERTAIN);
}

static void swapped_views_are_caught(void **state)
{
    (void)state;
    assert_true(p_of_weights(LF_FAULT_SWAPPED_VIEWS, whole_cycles) < CERTAIN);
}

static void a_missing_light_pdf_is_caught(void **state)
{
    (void)state;
    assert_true(p_of_agreement(LF_FAULT_NO_LIGHT_PDF) < CERTAIN);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_is_found_where_nothing_is_wrong),
        cmocka_unit_test(a_missing_ratio_of_distances_is_caught),
        cmocka_unit_test(a_forgotten_visibility_is_caught),
        cmocka_unit_test(realised_counts_are_caught),
        cmocka_unit_test(swapped_views_are_caught),
        cmocka_unit_test(a_missing_light_pdf_is_caught),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
