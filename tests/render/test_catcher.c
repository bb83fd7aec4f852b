/* Catchers of shadows: what they tell against closed forms, that the camera sees through them and
 * everything else does not. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { SIDE = 8, VIEWS = 3, PIXELS = SIDE * SIDE * VIEWS };

#define UNDER_DISK "catcher-under-disk"
/* A patch of it. */
#define CATCHER(what, lights)                                                                      \
    "{'meshes': {'ground': {'catcher': " what "}}, 'lights': {" lights "}}"

static lf_renderer *render(lf_scene *scene, int cycles, lf_pool *pool)
{
    lf_renderer *r = lf_test_renderer(scene, "mvpt", SIDE, SIDE, pool);
    lf_test_cycles(r, cycles);
    return r;
}

/* The mean shadow of a scene of a file and a patch. */
static double mean_shadow(const char *name, const char *patch, int cycles)
{
    static float shadow[PIXELS];
    double sum = 0.0;
    lf_scene *scene = lf_test_scene(lf_test_scene_patched(name, "%s", patch));
    lf_renderer *r = render(scene, cycles, NULL);
    lf_assert_ok(lf_renderer_layers(r, LF_ESTIMATOR_MWIS, LF_LAYER_SHADOW, shadow, NULL), NULL);
    for (int i = 0; i < PIXELS; i++)
        sum += (double)shadow[i] / PIXELS;
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    return sum;
}

/* A polygon of 128 corners, of a disk's area but for 0.04 %; seen from the middle it covers
 * R^2/(R^2
 * + h^2) of what the cosine weighs. */
#define COVERED (1.0 / (1.0 + 1.0))

static void a_disk_takes_its_form_factor_of_an_even_sky(void **state)
{
    (void)state;
    double shadow = mean_shadow(
        UNDER_DISK, CATCHER("true", "'sky': { 'type': 'environment', 'radiance': 3 }"), 64);
    lf_assert_close(shadow, COVERED, 0.005, 0);
    /* A negative control: what is no catcher catches nothing. */
    assert_true(mean_shadow(UNDER_DISK,
                            CATCHER("false", "'sky': { 'type': 'environment', 'radiance': 3 }"),
                            4) == 0.0);
}

/* Each light by what it would give: a sun straight above (behind the disk) 2, the sky pi, half of
 * it behind the disk; a lamp of 1 W sr^-1 half as high as the disk, before it, 4. */
static void lights_count_by_what_they_would_give(void **state)
{
    (void)state;
    static const double angles[] = {0, 3, 40};
    for (int i = 0; i < 3; i++) {
        char patch[1024];
        snprintf(patch, sizeof patch,
                 CATCHER("true", "'sun': { 'type': 'distant', 'irradiance': 2, 'angle': %g }, 'e': "
                                 "{ 'type': 'environment', 'radiance': 1 }, 'p': { 'type': "
                                 "'point', 'position': [0, 0.5, 0] }"),
                 angles[i]);
        lf_assert_close(mean_shadow(UNDER_DISK, patch, 64),
                        (2.0 + COVERED * M_PI) / (2.0 + M_PI + 4.0), 0.01, 0);
    }
    lf_assert_close(mean_shadow(UNDER_DISK, CATCHER("true", "'s': { 'type': 'distant' }"), 1), 1.0,
                    1e-6, 0);
    assert_true(mean_shadow(UNDER_DISK,
                            CATCHER("true", "'s': { 'type': 'distant', 'direction': [1, -0.2, 0] "
                                            "}"),
                            1) == 0.0);
    assert_true(mean_shadow(UNDER_DISK, CATCHER("true", ""), 1) == 0.0); /* no light at all */
    /* Above the disk all is dark; a rectangle before it lights what it lights. */
    lf_assert_close(mean_shadow(UNDER_DISK,
                                CATCHER("true", "'r': { 'type': 'rectangle', 'radiance': 1, "
                                                "'position': [0, 3, 0] }"),
                                1),
                    1.0, 1e-6, 0);
    assert_true(mean_shadow(UNDER_DISK,
                            CATCHER("true", "'r': { 'type': 'rectangle', 'radiance': 1, 'width': "
                                            "0.1, 'height': 0.1, 'position': [0.3, 0.7, 0] }"),
                            1) == 0.0);
}

/* Fog between: what is missing of the light of a sun straight above behind 1 of fog, seen through
 * as much. */
static void media_cast_shadows_as_well(void **state)
{
    (void)state;
    double shadow = mean_shadow("catcher-under-fog", "{}", 32);
    lf_assert_close(shadow, (1.0 - exp(-1.0)) * exp(-1.0), 0.02, 0);
}

/* Aslant, from views that stand 20 degrees to each side, more of the fog lies before the ground. */
static void media_before_a_catcher_are_as_thick_as_a_view_sees_them(void **state)
{
    (void)state;
    static float shadow[PIXELS];
    double mean[VIEWS] = {0.0};
    lf_scene *scene = lf_test_scene(lf_test_scene_patched(
        "catcher-under-fog", "{'camera': {'cone': 60}, "
                             "'volumes': {'fog': {'transform': {'scale': [20, 1, 20]}}}}"));
    lf_renderer *r = render(scene, 1, NULL);
    lf_assert_ok(lf_renderer_layers(r, LF_ESTIMATOR_MWIS, LF_LAYER_SHADOW, shadow, NULL), NULL);
    for (int i = 0; i < PIXELS; i++)
        mean[i / SIDE % VIEWS] += (double)shadow[i] / (SIDE * SIDE);
    for (int view = 0; view < VIEWS; view++)
        lf_assert_close(mean[view],
                        (1.0 - exp(-1.0)) * exp(view == 1 ? -1.0 : -1.0 / cos(M_PI / 9)), 0.002, 0);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* A ball on a catcher, seen from above. */
#define ON_IT(what, behind)                                                                        \
    lf_test_scene_patched("ball-on-catcher",                                                       \
                          "{'backdrop': " behind ", 'meshes': {'ground': {'catcher': " what "}}}")

/* The colour of the backdrop where the ball is not; of the ball's underside the light that the
 * ground sends back; and shadows nowhere but beside the ball. */
static void the_camera_looks_through_and_all_else_does_not(void **state)
{
    (void)state;
    static float picture[2][3 * PIXELS], layers[2][2 * PIXELS];
    double ball[2] = {0};
    int shaded = 0;
    for (int i = 0; i < 2; i++) {
        lf_scene *scene = lf_test_scene(i == 0 ? ON_IT("true", "[1, 2, 3]") : ON_IT("false", "0"));
        lf_renderer *r = render(scene, 32, NULL);
        lf_assert_ok(lf_renderer_resolve(r, LF_ESTIMATOR_MWIS, picture[i], NULL), NULL);
        lf_assert_ok(lf_renderer_layers(r, LF_ESTIMATOR_MWIS, LF_LAYER_COVERAGE | LF_LAYER_SHADOW,
                                        layers[i], NULL),
                     NULL);
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
    for (int k = 0; k < PIXELS; k++) {
        double covered = (double)layers[0][2 * k], shadow = (double)layers[0][2 * k + 1];
        assert_true(covered + shadow < 1.00001);
        assert_true(layers[1][2 * k + 1] == 0.0f);
        shaded += shadow > 0.9;
        for (int c = 0; c < 3 && covered == 0.0; c++)
            lf_assert_close(picture[0][3 * k + c], c + 1.0, 1e-5, 0);
        for (int i = 0; i < 2 && covered > 0.999; i++)
            ball[i] += (double)picture[i][3 * k];
    }
    assert_true(shaded > 3 && ball[0] > 1.0);
    lf_assert_close(ball[0], ball[1], 0.05, 0); /* lit from below by a ground that nobody sees */
}

/* Over the backdrop: it is black in the umbra, whole beside it, and the ball as it was. */
static void shadows_are_taken_from_the_backdrop(void **state)
{
    (void)state;
    static float before[3 * PIXELS], after[3 * PIXELS], layers[2 * PIXELS];
    lf_scene *scene = lf_test_scene(ON_IT("true", "{ 'top': [1, 2, 3], 'bottom': [3, 2, 0] }"));
    lf_renderer *r = render(scene, 16, NULL);
    lf_assert_ok(lf_renderer_resolve(r, LF_ESTIMATOR_MWIS, before, NULL), NULL);
    memcpy(after, before, sizeof after);
    lf_assert_ok(lf_renderer_catch(r, after, NULL), NULL);
    lf_assert_ok(
        lf_renderer_layers(r, LF_ESTIMATOR_MWIS, LF_LAYER_COVERAGE | LF_LAYER_SHADOW, layers, NULL),
        NULL);
    int dark = 0;
    for (int k = 0; k < PIXELS; k++) {
        double height = (k / (VIEWS * SIDE) + 0.5) / SIDE, shadow = (double)layers[2 * k + 1];
        const double behind[3] = {1 + 2 * height, 2, 3 - 3 * height};
        for (int c = 0; c < 3; c++)
            lf_assert_close((double)before[3 * k + c] - (double)after[3 * k + c],
                            shadow * behind[c], 0, 1e-5);
        dark += shadow == 1.0 && fabsf(after[3 * k + 1]) < 1e-4f;
    }
    assert_true(dark > 3);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
    scene = lf_test_scene(ON_IT("false", "1")); /* a negative control */
    r = render(scene, 1, NULL);
    lf_assert_ok(lf_renderer_resolve(r, LF_ESTIMATOR_MWIS, before, NULL), NULL);
    memcpy(after, before, sizeof after);
    lf_assert_ok(lf_renderer_catch(r, after, NULL), NULL);
    assert_memory_equal(before, after, sizeof after);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static void schedule(lf_renderer *r)
{
    lf_test_cycles(r, 2);
}

static void mvpt_agrees_with_vpt_before_a_catcher(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(ON_IT("true", "0"));
    lf_blocks blocks[2];
    for (int k = 0; k < 2; k++) {
        lf_renderer *r = lf_test_renderer(scene, k ? "vpt" : "mvpt", 16, 16, NULL);
        lf_test_pictures(r, schedule, LF_ESTIMATOR_MIS, 48, (uint64_t)(40 + k), 8, &blocks[k]);
        lf_renderer_destroy(r);
    }
    int where = 0;
    double level = lf_sidak(LF_FALSE_ALARM, blocks[0].n),
           p = lf_blocks_welch(&blocks[0], &blocks[1], &where);
    if (!(p > level))
        fail_msg("block %d differs, p %.2g", where, p);
    assert_true(lf_blocks_welch_injected(&blocks[0], &blocks[1], blocks[0].n - 1, 1.03) < level);
    for (int k = 0; k < 2; k++)
        lf_blocks_finish(&blocks[k]);
    lf_scene_unref(scene);
}

static void shadows_do_not_depend_on_threads(void **state)
{
    (void)state;
    static float shadow[2][PIXELS];
    lf_scene *scene = lf_test_scene(ON_IT("true", "0"));
    for (int i = 0; i < 2; i++) {
        lf_pool *pool = NULL;
        lf_assert_ok(lf_pool_create(1 + 2 * i, &pool), NULL);
        lf_renderer *r = render(scene, 2, pool);
        lf_assert_ok(lf_renderer_layers(r, LF_ESTIMATOR_MWIS, LF_LAYER_SHADOW, shadow[i], NULL),
                     NULL);
        lf_renderer_destroy(r);
        lf_pool_destroy(pool);
    }
    assert_memory_equal(shadow[0], shadow[1], sizeof shadow[0]);
    lf_scene_unref(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_disk_takes_its_form_factor_of_an_even_sky),
        cmocka_unit_test(lights_count_by_what_they_would_give),
        cmocka_unit_test(media_cast_shadows_as_well),
        cmocka_unit_test(media_before_a_catcher_are_as_thick_as_a_view_sees_them),
        cmocka_unit_test(the_camera_looks_through_and_all_else_does_not),
        cmocka_unit_test(shadows_are_taken_from_the_backdrop),
        cmocka_unit_test(mvpt_agrees_with_vpt_before_a_catcher),
        cmocka_unit_test(shadows_do_not_depend_on_threads),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
