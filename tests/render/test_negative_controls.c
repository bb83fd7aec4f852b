/* Deliberate mistakes in the estimator (lf_fault), each of which one of the statistical tests must
 * catch; and the same tests with the same numbers pass without them. */
#include "tests/testing.h"

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 32, height = 24, n_views = 7 };

/* What the sound estimator may fail by: four runs of the weights' test and one of agreement. */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 5 * (n_views * 12 + 1))
/* What a mistake must be rejected with. */
#define CERTAIN 1e-9

static void whole_cycles(lf_renderer *r)
{
    lf_test_passes(r, 4 * n_views);
}

static void live(lf_renderer *r)
{
    for (int i = 0; i < 6; i++)
        assert_int_equal(lf_renderer_pass(r, NULL, 2, NULL, NULL, NULL), LF_OK);
}

/* Smallest p of W - n q, or of W' - n q, over blocks of every view. */
static double p_of_weights_of(const char *text, bool second, unsigned faults,
                              lf_test_schedule schedule)
{
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    lf_blocks blocks[3];
    r->faults = faults;
    lf_test_weight_blocks(r, schedule, 24, 8, blocks);
    double p = lf_blocks_p_zero(&blocks[second], NULL);
    for (int i = 0; i < 3; i++)
        lf_blocks_finish(&blocks[i]);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return p;
}

static double p_of_weights(unsigned faults, lf_test_schedule schedule)
{
    return p_of_weights_of(lf_test_scene_views("mixed", 7), false, faults, schedule);
}

static double p_of_glossy_weights(unsigned faults)
{
    return p_of_weights_of(lf_test_scene_views("glossy", 7), true, faults, whole_cycles);
}

/* Pictures of one integrator by mis. */
static void pictures(const char *integrator, unsigned faults, uint64_t seed, lf_blocks *out)
{
    lf_scene *scene = lf_test_scene(lf_test_scene_views("mixed", 7));
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    r->faults = faults;
    lf_test_pictures(r, whole_cycles, LF_ESTIMATOR_MIS, 24, seed, 8, out);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static lf_blocks native;

static int draw_native(void **state)
{
    (void)state;
    pictures("vpt", 0, 100, &native);
    return 0;
}

static int finish(void **state)
{
    lf_blocks_finish(&native);
    return lf_test_finish(state);
}

static double p_of_agreement(unsigned faults)
{
    lf_blocks shared;
    pictures("mvpt", faults, 200, &shared);
    double p = lf_blocks_welch(&shared, &native, NULL);
    lf_blocks_finish(&shared);
    return p;
}

static void nothing_is_found_where_nothing_is_wrong(void **state)
{
    (void)state;
    assert_true(p_of_weights(0, whole_cycles) > LEVEL);
    assert_true(p_of_weights(0, live) > LEVEL);
    assert_true(p_of_glossy_weights(0) > LEVEL);
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

static void lobes_cut_at_the_horizon_are_caught(void **state)
{
    (void)state;
    assert_true(p_of_glossy_weights(LF_FAULT_HORIZON) < CERTAIN);
}

/* A card whose upper edge runs along the rows, seen by a whole cycle: every ray of a row meets it
 * or none does, so that with B and q of the row's own plane W and n q agree in every visit of every
 * row, not only in the mean. Largest difference in a row, per sample. With another plane one row in
 * two visits differs by all of it: unseen in 24 with probability 2^-24. */
static double worst_row(unsigned faults)
{
    const char *card = lf_test_scene_patched(
        "bare-camera", "{'camera': {'views': 7}, 'meshes': {'card': {'shape': 'quad', "
                       "'transform': {'scale': 4, 'rotate': [90, 0, 0], "
                       "'translate': [0, -3.336, 0]}}}}");
    enum { pixels = n_views * width };
    double *d = malloc(height * pixels * sizeof *d), *q = malloc(height * pixels * sizeof *q),
           worst = 0.0;
    lf_scene *scene = lf_test_scene(card);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    r->faults = faults;
    for (int k = 0; k < 24; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed(), (uint64_t)k));
        assert_int_equal(lf_renderer_pass(r, NULL, n_views, NULL, NULL, NULL), LF_OK);
        lf_test_weights(r, false, d, q);
        for (int row = 0; row < height; row++) {
            double sum = 0.0;
            for (int i = 0; i < pixels; i++)
                sum += d[row * pixels + i];
            worst = fmax(worst, fabs(sum) / pixels);
        }
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    free(q);
    free(d);
    return worst;
}

static void a_q_of_another_row_offset_is_caught(void **state)
{
    (void)state;
    assert_true(worst_row(0) < 1e-5);
    assert_true(worst_row(LF_FAULT_OTHER_ROW) > 0.99);
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
        cmocka_unit_test(lobes_cut_at_the_horizon_are_caught),
        cmocka_unit_test(a_q_of_another_row_offset_is_caught),
    };
    return cmocka_run_group_tests(tests, draw_native, finish);
}
