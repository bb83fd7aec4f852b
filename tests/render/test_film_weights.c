/* The best detector of mistakes there is: W and W' are, in the mean, n q in every pixel.
 * Differences W - n q are taken half by half (one row offset, one slice for both), averaged over
 * blocks of 8 x 8 pixels of one view, and compared with 0 over seeds. */
#include "tests/testing.h"

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 24, height = 16, n_views = 7, blocks_of_a_view = 6, replicates = 40 };

/* Blocks of all comparisons below: 12 runs, W and W', 43 blocks each (61 of ten views). */
#define LEVEL                                                                                      \
    lf_sidak(LF_FALSE_ALARM,                                                                       \
             2 * (11 * (n_views * blocks_of_a_view + 1) + 10 * blocks_of_a_view + 1))

static void whole_cycles(lf_renderer *r)
{
    lf_test_passes(r, 10 * n_views);
}

static void two_passes(lf_renderer *r)
{
    lf_test_passes(r, 2);
}

/* What a live picture begins with: forced collisions, few base views. */
static void live(lf_renderer *r)
{
    for (int i = 0; i < 4; i++)
        assert_int_equal(lf_renderer_pass(r, NULL, 1 + i % 2, NULL, NULL, NULL), LF_OK);
}

static void assert_weights(const char *text, lf_test_schedule schedule)
{
    lf_test_assert_weights(text, width, height, schedule, replicates, 8, LEVEL);
}

static void invariant_2_weights_are_n_q_with_media_and_surfaces(void **state)
{
    (void)state;
    assert_weights(lf_test_scene_views("mixed", 7), two_passes);
    assert_weights(lf_test_scene_views("mixed", 7), live);
}

static void invariant_2_weights_are_n_q_with_a_lens(void **state)
{
    (void)state;
    assert_weights(
        lf_test_scene_patched(
            "mixed", "{'camera': {'views': 7, 'lens_radius': 0.15, 'focus_distance': 4.2}}"),
        whole_cycles);
    assert_weights(
        lf_test_scene_patched(
            "mixed", "{'camera': {'views': 7, 'lens_radius': 0.15, 'focus_distance': 4.2}}"),
        live);
}

static void invariant_2_weights_are_n_q_in_overlapping_media(void **state)
{
    (void)state;
    assert_weights(
        lf_test_scene_patched("fogs", "{'camera': {'views': 7, 'placement': 'inclusive'}}"),
        whole_cycles);
    assert_weights(
        lf_test_scene_patched("fogs", "{'camera': {'views': 7, 'placement': 'inclusive'}}"), live);
}

static void invariant_2_weights_are_n_q_beside_mirrors(void **state)
{
    (void)state;
    assert_weights(lf_test_scene_views("lamp", 7), two_passes);
    assert_weights(lf_test_scene_views("mist", 7), live);
}

static void invariant_2_weights_are_n_q_on_glossy_surfaces_with_bent_normals(void **state)
{
    (void)state;
    assert_weights(lf_test_scene_views("glossy", 7), whole_cycles);
    assert_weights(
        lf_test_scene_patched(
            "glossy", "{'camera': {'views': 7, 'lens_radius': 0.15, 'focus_distance': 4.2}}"),
        live);
    assert_weights(lf_test_scene_views("glossy", 10), two_passes);
}

/* Power: 1 % of q in one block of the middle view, 0.3 % of it over the picture. */
static void invariant_2_weights_are_n_q_and_a_bias_of_one_per_cent_would_be_seen(void **state)
{
    (void)state;
    lf_blocks blocks[3];
    lf_scene *scene = lf_test_scene(lf_test_scene_views("mixed", 7));
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    lf_test_weight_blocks(r, whole_cycles, replicates, 8, blocks);
    for (int second = 0; second < 2; second++) {
        int seen = 0, bright = 0;
        assert_true(lf_blocks_p_zero(&blocks[second], NULL) > LEVEL);
        for (int i = 3 * blocks_of_a_view; i < 4 * blocks_of_a_view; i++) {
            double q = blocks[2].moments[i].mean;
            bright += q > 0.5;
            seen += q > 0.5 && lf_p_mean(&blocks[second].moments[i], -0.01 * q) < LEVEL;
        }
        print_message("W%s: 1 %% seen in %d of %d blocks\n", second ? "'" : "", seen, bright);
        assert_true(seen == bright && bright >= 3);
        int whole = blocks[second].n - 1;
        assert_true(lf_p_mean(&blocks[second].moments[whole],
                              -0.003 * blocks[2].moments[whole].mean) < LEVEL);
    }
    for (int i = 0; i < 3; i++)
        lf_blocks_finish(&blocks[i]);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(invariant_2_weights_are_n_q_with_media_and_surfaces),
        cmocka_unit_test(invariant_2_weights_are_n_q_with_a_lens),
        cmocka_unit_test(invariant_2_weights_are_n_q_in_overlapping_media),
        cmocka_unit_test(invariant_2_weights_are_n_q_beside_mirrors),
        cmocka_unit_test(invariant_2_weights_are_n_q_on_glossy_surfaces_with_bent_normals),
        cmocka_unit_test(invariant_2_weights_are_n_q_and_a_bias_of_one_per_cent_would_be_seen),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
