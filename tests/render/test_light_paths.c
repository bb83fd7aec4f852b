/* Light paths (render/rows/light_paths.h) in balance with camera paths: pictures with and without
 * them agree tile by tile, for every kind of light that has them; mistakes in the balance are
 * rejected; and the bytes do not depend on threads, bands and interruptions.
 * tests/render/test_sun_off_mirror.c has a closed form. */
#include "tests/testing.h"

#include <unistd.h>

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 24, height = 18, block = 6, n_views = 5, blocks_of_views = 12 * n_views + 1 };
/* paths of a pass, about one for each pixel of a view */
enum { PATHS = 400 };

/* Scenes of the table below, with two integrators each, and the controls. */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 20 * blocks_of_views)
/* What a mistake must be rejected with. */
#define CERTAIN 1e-9

static const char *const lights[] = {
    "{}",
    "{'lights': {'sun': {'angle': 0}}}",
    "{'lights': {'second': {'type': 'distant', 'direction': [-0.3, -0.9, 0.2], 'irradiance': 1,"
    " 'angle': 50}, 'sky': {'type': 'environment', 'radiance': 0.2}}}",
    "{'lights': {'sun': null, 'lamp': {'type': 'sphere', 'position': [0.2, 1, 0.2],"
    " 'radius': 0.15, 'radiance': 20}}}",
    "{'lights': {'sun': null, 'point': {'type': 'point', 'position': [0.2, 1, 0.2],"
    " 'intensity': 2}, 'spot': {'type': 'spot', 'position': [-0.8, 0.9, 0.3],"
    " 'direction': [1, -0.6, -0.2], 'intensity': 4}}}",
    "{'materials': {'ball': {'type': 'principled', 'transmission': 1, 'roughness': 0.4,"
    " 'glass': 'solid'}}}",
    "{'materials': {'ball': {'type': 'principled', 'albedo': [0.3, 0.5, 0.7], 'roughness': 0.5,"
    " 'coat': 0.5, 'coat_roughness': 0.5}, 'floor': {'alpha': 0.7}}}"};
enum { N_LIGHTS = sizeof lights / sizeof lights[0] };

static void pictures(const char *text, const char *integrator, int paths, unsigned faults,
                     int cycles, uint64_t salt, lf_blocks *out)
{
    lf_test_light_paths(paths);
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    r->faults = faults;
    lf_blocks_init(out, n_views, width, height, block);
    for (int k = 0; k < 12; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + salt, (uint64_t)k));
        lf_test_cycles(r, cycles);
        lf_blocks_add_picture(out, r, LF_ESTIMATOR_MIS);
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static void assert_alike(const lf_blocks *a, const lf_blocks *b, const char *what, int i)
{
    int where = 0;
    const double p = lf_blocks_welch(a, b, &where);
    if (!(p > LEVEL))
        fail_msg("%s, lights %d: block %d is %.6g +- %.2g and %.6g +- %.2g, p %.2g", what, i, where,
                 a->moments[where].mean, lf_moments_error(&a->moments[where]),
                 b->moments[where].mean, lf_moments_error(&b->moments[where]), p);
}

static void pictures_agree_with_those_without(void **state)
{
    (void)state;
    for (int i = 0; i < N_LIGHTS; i++) {
        const char *text = lf_test_scene_patched("glossy-corner", "%s", lights[i]);
        lf_blocks without, with, alone;
        pictures(text, "vpt", 0, 0, 12, 1, &without);
        pictures(text, "mvpt", PATHS, 0, 3, 2, &with);
        pictures(text, "vpt", PATHS, 0, 6, 3, &alone);
        assert_alike(&with, &without, "mvpt", i);
        assert_alike(&alone, &without, "vpt", i);
        lf_blocks_finish(&without);
        lf_blocks_finish(&with);
        lf_blocks_finish(&alone);
    }
}

/* Posts in front hide half of the floor, which is rough metal, from each of the views. */
static const char *behind_posts(void)
{
    char posts[5][160];
    for (int i = 0; i < 5; i++)
        snprintf(posts[i], sizeof posts[i],
                 "{'shape': 'cube', 'material': 'post', 'transform': {'scale': [0.07, 1, 0.02],"
                 " 'translate': [%.1f, 0.6, 1.6]}}",
                 0.3 * (i - 2));
    return lf_test_scene_patched(
        "glossy-corner",
        "{'materials': {'floor': {'type': 'conductor', 'albedo': 0.9, 'roughness': 0.5},"
        " 'post': {'albedo': 0}}, 'meshes': {'p0': %s, 'p1': %s, 'p2': %s, 'p3': %s, 'p4': %s}}",
        posts[0], posts[1], posts[2], posts[3], posts[4]);
}

static double p_of_fault(unsigned fault, const lf_blocks *truth)
{
    lf_blocks blocks;
    pictures(behind_posts(), "mvpt", PATHS, fault, 12, 5, &blocks);
    const double p = lf_blocks_welch(&blocks, truth, NULL);
    lf_blocks_finish(&blocks);
    return p;
}

static void mistakes_in_the_balance_are_caught(void **state)
{
    (void)state;
    lf_blocks truth;
    pictures(behind_posts(), "mvpt", PATHS, 0, 24, 4, &truth);
    assert_true(p_of_fault(0, &truth) > LEVEL);
    assert_true(p_of_fault(LF_FAULT_NO_REVERSE_PDF, &truth) < CERTAIN);
    assert_true(p_of_fault(LF_FAULT_NO_CELL_PDF, &truth) < CERTAIN);
    assert_true(p_of_fault(LF_FAULT_NO_DIRECTIONS, &truth) < CERTAIN);
    assert_true(p_of_fault(LF_FAULT_NO_LIGHT_VISIBILITY, &truth) < CERTAIN);
    lf_blocks_finish(&truth);
}

static void cycles(lf_renderer *r)
{
    lf_test_cycles(r, 4);
}

/* Light paths change neither W nor W'. */
static void weights_are_as_expected(void **state)
{
    (void)state;
    lf_test_light_paths(PATHS);
    lf_test_assert_weights(lf_test_scene_text("glossy-corner"), width, height, cycles, 12, block,
                           LEVEL);
}

/* ---------------------------------------------------------------------------- the same bytes -- */

static lf_renderer *by(const char *integrator, int threads, lf_pool **out_pool)
{
    lf_test_light_paths(PATHS);
    lf_scene *scene = lf_test_scene(lf_test_scene_text("glossy-corner"));
    lf_assert_ok(lf_pool_create(threads, out_pool), NULL);
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, *out_pool);
    lf_scene_unref(scene);
    return r;
}

static void drop(lf_renderer *r, lf_pool *pool)
{
    lf_renderer_destroy(r);
    lf_pool_destroy(pool);
}

static void threads_do_not_matter(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        lf_pool *pools[3];
        lf_renderer *r[3];
        const int threads[3] = {1, 2, 7};
        for (int k = 0; k < 3; k++) {
            r[k] = by(i ? "vpt" : "mvpt", threads[k], &pools[k]);
            assert_true(lf_test_rows(r[k])->light.plan.per_pass == PATHS);
            lf_test_passes(r[k], 12);
        }
        lf_test_same_films(r[0], r[1]);
        lf_test_same_films(r[0], r[2]);
        for (int k = 0; k < 3; k++)
            drop(r[k], pools[k]);
    }
}

/* Passes over every second row and then the others, and in two steps, are the passes over all. */
static void parts_and_steps_are_the_whole(void **state)
{
    (void)state;
    lf_pool *pools[2];
    lf_renderer *whole = by("mvpt", 2, &pools[0]), *parts = by("mvpt", 2, &pools[1]);
    lf_test_passes(whole, 10);
    lf_test_passes(whole, 6);
    for (int step = 0; step < 2; step++)
        for (int first = 1; first >= 0; first--) {
            const lf_part part = {.first_row = first, .row_step = 2};
            assert_int_equal(
                lf_renderer_passes(parts, &part, step ? 6 : 10, true, NULL, NULL, NULL), LF_OK);
        }
    lf_test_same_films(whole, parts);
    drop(whole, pools[0]);
    drop(parts, pools[1]);
}

/* Rows with different numbers of visits have light paths of their own. */
static void rows_may_differ_in_their_visits(void **state)
{
    (void)state;
    lf_pool *pools[2];
    lf_renderer *even = by("mvpt", 2, &pools[0]), *uneven = by("mvpt", 2, &pools[1]);
    const lf_part top = {.end_row = 5}, rest = {.first_row = 5};
    for (int i = 0; i < 3; i++)
        assert_int_equal(lf_renderer_pass(even, NULL, 2, NULL, NULL, NULL), LF_OK);
    assert_int_equal(lf_renderer_pass(uneven, &top, 2, NULL, NULL, NULL), LF_OK);
    for (int i = 0; i < 2; i++)
        assert_int_equal(lf_renderer_pass(uneven, NULL, 2, NULL, NULL, NULL), LF_OK);
    assert_int_equal(lf_renderer_pass(uneven, &rest, 2, NULL, NULL, NULL), LF_OK);
    lf_test_same_films(even, uneven);
    drop(even, pools[0]);
    drop(uneven, pools[1]);
}

/* A pixel in which no path was found counts as dark, with a weight that is a mark. Light of light
 * paths must not be divided by it. */
static void light_is_not_divided_by_marks(void **state)
{
    (void)state;
    lf_test_light_paths(PATHS);
    lf_scene *scene = lf_test_scene(lf_test_scene_patched(
        "glossy-corner", "{'materials': {'floor': {'alpha': 0.05}, 'ball': {'roughness': 0}}}"));
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    lf_render_settings settings = *lf_renderer_settings(r);
    settings.features = true;
    for (int i = 0; i < 40; i++) {
        settings.seed = lf_hash64(lf_test_seed(), (uint64_t)(i / 4));
        if (i % 4 == 0)
            lf_assert_ok(lf_renderer_restart(r, scene, &settings, NULL), NULL);
        lf_assert_ok(lf_renderer_pass(r, NULL, 1, NULL, NULL, NULL), NULL);
        lf_assert_ok(lf_renderer_fill_holes(r, NULL, NULL), NULL);
        double *picture = lf_test_picture(r, LF_ESTIMATOR_MWIS);
        for (int k = 0; k < n_views * width * height; k++)
            if (!(picture[k] < 1e6))
                fail_msg("pass %d: %g in pixel %d", i, picture[k], k);
        free(picture);
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static void a_pass_can_be_cancelled(void **state)
{
    (void)state;
    lf_pool *pool;
    lf_renderer *r = by("mvpt", 2, &pool);
    const lf_cancel cancel = 1;
    assert_int_equal(lf_renderer_pass(r, NULL, 2, NULL, NULL, &cancel), LF_E_CANCELLED);
    for (int row = 0; row < height; row++)
        assert_false(lf_renderer_visited(r, row));
    drop(r, pool);
}

/* --------------------------------------------------------------------------------- the pilot -- */

static int chosen(const char *text, const char *integrator)
{
    lf_test_light_paths(LF_LIGHT_PATHS_AUTO);
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    const int n = lf_test_rows(r)->light.plan.per_pass;
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return n;
}

static void the_pilot_takes_them_where_they_help(void **state)
{
    (void)state;
    const char *corner = lf_test_scene_text("glossy-corner");
    assert_true(chosen(corner, "mvpt") > 0 && chosen(corner, "vpt") > 0);
    assert_true(chosen(lf_test_scene_text("sun-off-mirror"), "mvpt") > 0);
    /* one bounce: nothing but light from the light itself */
    assert_int_equal(
        chosen(lf_test_scene_patched("glossy-corner", "{'render': {'max_depth': 1}}"), "mvpt"), 0);
    /* no light from which paths start */
    assert_int_equal(
        chosen(lf_test_scene_patched("glossy-corner", "{'lights': {'sun': null, 'sky': {'type': "
                                                      "'environment', 'radiance': 1}}}"),
               "mvpt"),
        0);
    /* not served: media, lenses, and an integrator without them */
    assert_int_equal(chosen(lf_test_scene_text("mixed"), "mvpt"), 0);
    assert_int_equal(
        chosen(lf_test_scene_patched("glossy-corner", "{'camera': {'lens_radius': 0.02}}"), "mvpt"),
        0);
    assert_int_equal(chosen(corner, "amvpt"), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_agree_with_those_without),
        cmocka_unit_test(mistakes_in_the_balance_are_caught),
        cmocka_unit_test(weights_are_as_expected),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(parts_and_steps_are_the_whole),
        cmocka_unit_test(rows_may_differ_in_their_visits),
        cmocka_unit_test(light_is_not_divided_by_marks),
        cmocka_unit_test(a_pass_can_be_cancelled),
        cmocka_unit_test(the_pilot_takes_them_where_they_help),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
