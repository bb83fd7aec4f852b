/* More base samples where the error is, in papers/: counts a pixel come out as expected, and
 * behind a pilot the answers of amvpt2022 are still those of vpt, tile by tile. */
#include "tests/testing.h"

#include "render/papers/count.h"
#include "tests/render/papers.h"
#include "tests/scene_file.h"

/* Over the phase a pixel gets as many samples as it expects, whatever the visits; and what they are
 * worth alone comes to the passes. */
static void counts_come_out_as_expected(void **state)
{
    (void)state;
    static const double expected[] = {0.125, 0.3, 1, 1.7, 16};
    enum { phases = 4096 };
    for (size_t i = 0; i < sizeof expected / sizeof expected[0]; i++) {
        double n = 2, sum = 0, alone = 0;
        for (int k = 0; k < phases; k++) {
            n = 2;
            for (int visit = 0; visit < 3; visit++) {
                double given = 0.2 * (visit + 1);
                lf_count_share s = lf_count_share_of(expected[i], (k + 0.5) / phases, n, given);
                sum += s.end - s.begin;
                alone += (s.end - s.begin) * (double)s.alone;
                n += given;
            }
        }
        lf_assert_close(sum / phases, expected[i] * (n - 2), 1e-3, 0);
        lf_assert_close(alone / phases, n - 2, 1e-3, 0);
    }
}

static const struct {
    const char *what, *scene, *selection;
    papers_power power;
} scenes[] = {
    {"coated, in fog", "mixed", "none", {1.07, 0.6, 1.01}},
    {"a lamp and a mirror", "lamp", "partition", {1.07, 0.6, 1.02}},
};
#define N_SCENES (int)(sizeof scenes / sizeof scenes[0])
#define LEVEL lf_sidak(LF_FALSE_ALARM, 2 * N_SCENES * papers_tiles)

static void adaptive_answers_agree_with_vpt(void **state)
{
    (void)state;
    static const lf_estimator by[2] = {LF_ESTIMATOR_MIS, LF_ESTIMATOR_CV};
    for (int i = 0; i < N_SCENES; i++) {
        lf_scene *scene = lf_test_scene(lf_test_scene_text(scenes[i].scene));
        lf_blocks native = papers_native(scene, 16 * papers_views), seen[2];
        lf_renderer *r = papers_renderer(scene, "amvpt2022", papers_width, papers_height, NULL,
                                         scenes[i].selection);
        papers_pictures(r, 6 * papers_views, 200 + (uint64_t)i, by, seen);
        const lf_general *g = r->state;
        float least = 16, most = 0;
        for (int k = 0; k < g->counts.tiles_down * g->counts.tiles_across * papers_height; k++) {
            least = fminf(least, g->counts.tile[k]);
            most = fmaxf(most, g->counts.tile[k]);
        }
        print_message("%d maps, counts from %g to %g\n", g->n_maps, (double)least, (double)most);
        assert_true(g->n_maps == 1 && most > 2 * least);
        lf_renderer_destroy(r);
        for (int k = 0; k < 2; k++) {
            papers_assert_agreement(&seen[k], &native, scenes[i].what, LEVEL, scenes[i].power);
            lf_blocks_finish(&seen[k]);
        }
        lf_blocks_finish(&native);
        lf_scene_unref(scene);
    }
}

int main(void)
{
    lf_papers_add();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(counts_come_out_as_expected),
        cmocka_unit_test(adaptive_answers_agree_with_vpt),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
