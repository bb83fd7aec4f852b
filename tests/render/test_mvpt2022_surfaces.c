/* Pivots on surfaces in mvpt2022 and mismvpt: by the selections that are consistent the answers are
 * those of vpt, tile by tile, on what is matt, glossy, mirrors, shines, leans away or stands in
 * fog; and weights come to the samples. */
#include "tests/testing.h"

#include "tests/render/papers.h"
#include "tests/scene_file.h"

static const struct {
    const char *what, *scene, *patch;
    papers_power power;
} scenes[] = {
    {"matt, seen through a lens", "bent", "{'camera': {'lens_radius': 0.15}}", {1.07, 0.6, 1.01}},
    {"glossy, leaning", "glossy", "{}", {1.1, 0.6, 1.04}},
    {"a lamp and a mirror", "lamp", "{}", {1.07, 0.6, 1.01}},
    {"what shines", "emissive-ball", "{}", {1.07, 0.6, 1.01}},
    {"coated, in fog", "mixed", "{}", {1.07, 0.6, 1.01}},
};
#define N_SCENES (int)(sizeof scenes / sizeof scenes[0])

static const struct {
    const char *integrator, *selection;
} ways[] = {{"mvpt2022", "none"}, {"mvpt2022", "partition"}, {"mismvpt", NULL}};
#define N_WAYS (int)(sizeof ways / sizeof ways[0])

#define LEVEL lf_sidak(0.5 * LF_FALSE_ALARM, 2 * N_SCENES * N_WAYS * papers_tiles)

static void surfaces_agree_with_vpt(void **state)
{
    (void)state;
    static const lf_estimator by[2] = {LF_ESTIMATOR_MIS, LF_ESTIMATOR_CV};
    for (int i = 0; i < N_SCENES; i++) {
        lf_scene *scene =
            lf_test_scene(lf_test_scene_patched(scenes[i].scene, "%s", scenes[i].patch));
        lf_blocks native = papers_native(scene, 16 * papers_views);
        for (int j = 0; j < N_WAYS; j++) {
            lf_blocks seen[2];
            char what[128];
            lf_renderer *r = papers_renderer(scene, ways[j].integrator, papers_width, papers_height,
                                             NULL, ways[j].selection);
            snprintf(what, sizeof what, "%s: %s, %s", scenes[i].what, ways[j].integrator,
                     ways[j].selection ? ways[j].selection : "");
            papers_pictures(r, 4 * papers_views, 200 + (uint64_t)(N_WAYS * i + j), by, seen);
            lf_renderer_destroy(r);
            for (int k = 0; k < (ways[j].selection ? 2 : 1); k++)
                papers_assert_agreement(&seen[k], &native, what, LEVEL, scenes[i].power);
            for (int k = 0; k < 2; k++)
                lf_blocks_finish(&seen[k]);
        }
        lf_blocks_finish(&native);
        lf_scene_unref(scene);
    }
}

static void four_cycles(lf_renderer *r)
{
    lf_test_cycles(r, 4);
}

/* Of consistent selections the weights of a view pixel come to its samples, whoever drew them: 5 %
 * are seen in half of the tiles. */
static void weights_come_to_samples(void **state)
{
    (void)state;
    const double level = lf_sidak(0.5 * LF_FALSE_ALARM, N_SCENES * (papers_tiles - 1));
    for (int i = 0; i < N_SCENES; i++) {
        lf_scene *scene =
            lf_test_scene(lf_test_scene_patched(scenes[i].scene, "%s", scenes[i].patch));
        lf_renderer *r = papers_renderer(scene, "mvpt2022", papers_width, papers_height, NULL,
                                         ways[i % 2].selection);
        lf_blocks seen[3];
        double worst = 1.0;
        int found = 0;
        lf_test_weight_blocks(r, four_cycles, papers_replicates(), papers_tile, seen);
        lf_renderer_destroy(r);
        for (int k = 0; k < papers_tiles - 1; k++) {
            const lf_moments *at = &seen[0].moments[k];
            worst = fmin(worst, lf_p_mean(at, 0.0));
            found += lf_p_mean(at, at->mean < 0 ? 0.05 : -0.05) < level;
        }
        print_message("%s, %s: W/n is 1 with p %.2g; 5 %% seen in %d of %d tiles\n", scenes[i].what,
                      ways[i % 2].selection, worst, found, papers_tiles - 1);
        assert_true(worst > level);
        assert_true(2 * found >= papers_tiles - 1);
        for (int k = 0; k < 3; k++)
            lf_blocks_finish(&seen[k]);
        lf_scene_unref(scene);
    }
}

int main(void)
{
    lf_papers_add();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surfaces_agree_with_vpt),
        cmocka_unit_test(weights_come_to_samples),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
