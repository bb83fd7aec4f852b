/* What max_depth cuts off is counted. In a white furnace every vertex that is left out would have
 * found 1, so that the picture lacks just what is counted: 1 - picture = share q, where every pivot
 * weighs the same. Lanes count what single paths do. Negative control: a share that is 5 % off is
 * rejected. */
#include "tests/testing.h"

#include "tests/render/grids.h"
#include "tests/scene_file.h"

enum { width = 16, height = 12, n_views = 3, replicates = 24 };

#define CAMERA                                                                                     \
    "'camera': { 'position': [0, 0, 5], 'fov_y': 30, 'aspect': 1.3333333333, 'views': 3, 'cone': " \
    "30 }"
#define SKY "'lights': { 'sky': { 'type': 'environment', 'radiance': 1 } }"
#define LIMIT "'render': { 'max_depth': 3 }"
#define GROUND                                                                                     \
    "'meshes': { 'ground': { 'shape': 'quad', 'material': 'white', 'transform': { 'scale': 2, "    \
    "'translate': [0, -0.7, 0] } } }, 'materials': { 'white': { 'albedo': 1 } }"

/* What cameras and paths count of one seed. */
static void one_seed(lf_renderer *r, uint64_t seed, double *out_missing, double *out_share)
{
    double sum = 0.0, q = 0.0;
    lf_render_stats stats;
    lf_test_reseed(r, seed);
    lf_renderer_stats(r, &stats);
    const int64_t suffixes = stats.suffixes;
    const double cut = stats.suffixes_cut;
    lf_test_cycles(r, 8);
    lf_renderer_stats(r, &stats);
    double *picture = lf_test_picture(r, LF_ESTIMATOR_MIS),
           *w = malloc(sizeof *w * n_views * width * height),
           *all_q = malloc(sizeof *w * n_views * width * height);
    lf_test_weights(r, false, w, all_q);
    for (int i = 0; i < n_views * width * height; i++) {
        sum += (1.0 - picture[i]) / (n_views * width * height);
        q += all_q[i] / (n_views * width * height);
    }
    *out_missing = sum;
    *out_share = q * (stats.suffixes_cut - cut) / (double)(stats.suffixes - suffixes);
    free(picture);
    free(w);
    free(all_q);
}

static void assert_counted(lf_scene *scene, const char *integrator)
{
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    lf_moments apart = {0}, off = {0};
    for (int k = 0; k < replicates; k++) {
        double missing, share;
        one_seed(r, lf_hash64(lf_test_seed(), (uint64_t)k), &missing, &share);
        lf_moments_add(&apart, missing - share);
        lf_moments_add(&off, missing - 1.05 * share);
    }
    const double level = lf_sidak(LF_FALSE_ALARM, 4);
    if (!(lf_p_mean(&apart, 0.0) > level))
        fail_msg("%s: apart by %.5g +- %.2g, twentieth %.5g", integrator, apart.mean,
                 lf_moments_error(&apart), apart.mean - off.mean);
    assert_true(lf_p_mean(&off, 0.0) < level);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static const char *const integrators[] = {"vpt", "mvpt"};

static void shapes_lack_what_is_counted(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        assert_counted(lf_test_scene("{" CAMERA ", " LIMIT ", " SKY
                                     ", 'volumes': { 'v': { 'shape': 'box', 'density': 4, "
                                     "'albedo': 1 } } }"),
                       integrators[i]);
        assert_counted(lf_test_scene("{" CAMERA ", " LIMIT ", " SKY ", " GROUND
                                     ", 'volumes': { 'v': { 'shape': 'box', 'density': 4, "
                                     "'albedo': 1 } } }"),
                       integrators[i]);
    }
}

/* Glass of index 1 around what scatters: paths behind its faces carry what it leaves. */
static void glass_counts_what_it_leaves(void **state)
{
    (void)state;
    lf_render_stats stats[2];
    for (int i = 0; i < 2; i++) {
        lf_scene *scene = lf_test_scene(lf_test_scene_patched(
            "glass-of-index-1", "{'materials': {'glass': {'absorption': %d}}}", i ? 100 : 0));
        lf_renderer *r = lf_test_renderer(scene, "vpt", width, height, NULL);
        lf_test_cycles(r, 8);
        lf_renderer_stats(r, &stats[i]);
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
    assert_true(lf_render_cut(&stats[0]) > 0.5);
    assert_true(lf_render_cut(&stats[1]) < 0.1);
}

/* The share of a grid's paths, in lanes or one by one. */
static void measure(const char *more, bool in_lanes, lf_moments *out)
{
    char text[1024];
    snprintf(text, sizeof text, "{" CAMERA ", " LIMIT ", " SKY ", %s" LF_TEST_VOLUMES("") "}",
             more);
    lf_scene *scene =
        lf_test_grid_scene(text, lf_test_grid(lf_test_rough, 12, 10, 9), 0.15, 0.3, 20.0f, false);
    lf_renderer *r = lf_test_renderer(scene, "vpt", width, height, NULL);
    lf_render_settings settings = *lf_renderer_settings(r);
    settings.skip = in_lanes ? LF_SKIP_ALL : LF_SKIP_ALL & ~LF_SKIP_PATHS;
    *out = (lf_moments){0};
    for (int k = 0; k < replicates; k++) {
        lf_render_stats stats;
        settings.seed = lf_hash64(lf_test_seed(), (uint64_t)k);
        lf_assert_ok(lf_renderer_restart(r, scene, &settings, NULL), NULL);
        lf_test_cycles(r, 8);
        lf_renderer_stats(r, &stats);
        lf_moments_add(out, lf_render_cut(&stats));
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static void lanes_count_what_single_paths_do(void **state)
{
    (void)state;
    static const char *const more[] = {"", GROUND ", "};
    for (int i = 0; i < 2; i++) {
        lf_moments lanes, single;
        measure(more[i], true, &lanes);
        measure(more[i], false, &single);
        const double level = lf_sidak(LF_FALSE_ALARM, 2);
        if (!(lf_p_welch(&lanes, &single) > level))
            fail_msg("%d: %.5g +- %.2g and %.5g +- %.2g", i, lanes.mean, lf_moments_error(&lanes),
                     single.mean, lf_moments_error(&single));
        lanes.mean *= 1.05;
        assert_true(lf_p_welch(&lanes, &single) < level);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shapes_lack_what_is_counted),
        cmocka_unit_test(glass_counts_what_it_leaves),
        cmocka_unit_test(lanes_count_what_single_paths_do),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
