/* vpt and mvpt against a tracer that shares no code with them (tests/stat/brute.h): small scenes,
 * each with what one against the other cannot show, in blocks of every view and in the whole
 * picture, by Welch's test over replicates. False alarms as stat.h says; the tests show their
 * power: 0.8 % of the whole picture would be seen, and a scene of which one albedo is 2 % off is.
 * With QUILTD_LONG=1 sixteen times the paths see 0.2 %. */
#include "tests/testing.h"

#include "render/transport/lanes/lane_scene.h"
#include "tests/stat/brute.h"
#include "tests/stat/fixture.h"

enum { width = 16, height = 12, n_views = 3, block = 8, blocks_of_all = n_views * 4 + 1 };
enum { integrators = 2, scenes = 10, replicates = 24 };

static const char *const names[integrators] = {"vpt", "mvpt"};

/* Comparisons that may fail by chance: of the whole picture, and of blocks. */
#define LEVEL lf_sidak(LF_FALSE_ALARM / 2, scenes * integrators)
#define BLOCK_LEVEL lf_sidak(LF_FALSE_ALARM / 2, scenes * integrators * blocks_of_all)

/* clang-format off */

#define CAMERA                                                                                     \
    .position = {0.3, 0.8, 5}, .target = {0, -0.1, 0}, .fov_y = 26, .aspect = 4.0 / 3.0,           \
    .cone = 40, .n_views = n_views
#define FLAT(y, half) .centre = {0, y, 0}, .u = {half, 0, 0}, .v = {0, 0, half}

/* A lamp low over a ground and the walls of a box on it, and a slanted lamp beside it: lamps light,
 * hide and are seen. */
static const lf_brute_scene lamps = {
    CAMERA, .n_quads = 6, .sky = {0.4, 0.5, 0.6},
    .quads = {
        {FLAT(-1, 6), .albedo = {0.6, 0.5, 0.4}},
        {.centre = {0, 1.2, 0}, .u = {1.6, 0, 0}, .v = {0, 0, 1.6}, .albedo = {0.2, 0.2, 0.2},
         .emission = {1.5, 1.3, 1}},
        {.centre = {-1.5, 0, 0.3}, .u = {0.4, 0.7, 0}, .v = {0, 0, 1}, .emission = {0.6, 1, 1.4}},
        {.centre = {0.4, -0.6, 0.6}, .u = {0.4, 0, 0}, .v = {0, 0.4, 0}, .albedo = {0.8, 0.3, 0.2}},
        {.centre = {0.8, -0.6, 0.1}, .u = {0, 0, 0.5}, .v = {0, 0.4, 0}, .albedo = {0.3, 0.3, 0.7}},
        {.centre = {0.4, -0.2, 0.1}, .u = {0.4, 0, 0}, .v = {0, 0, 0.5},
         .albedo = {0.3, 0.7, 0.3}}}};

/* The same in part, through a lens that is in focus in front of it. */
static const lf_brute_scene lens = {
    CAMERA, .lens_radius = 0.35, .focus = 4.2, .n_quads = 4, .sky = {0.2, 0.3, 0.4},
    .quads = {
        {FLAT(-1, 4), .albedo = {0.7, 0.6, 0.5}},
        {.centre = {-0.7, 0.2, 0.9}, .u = {0.5, 0.1, 0}, .v = {0, 0.4, 0.3},
         .albedo = {0.1, 0.2, 0.1}, .emission = {1.5, 1.2, 0.9}},
        {.centre = {0.6, -0.3, 0.2}, .u = {0.3, 0.1, -0.3}, .v = {0, 0.6, 0},
         .albedo = {0.8, 0.7, 0.2}},
        {.centre = {0, 0.3, -1.5}, .u = {2, 0, 0}, .v = {0, 1, 0}, .albedo = {0.4, 0.4, 0.6}}}};

/* Fog that scatters forwards in a room that is open to the cameras, a lamp in it. */
static const lf_brute_scene fog = {
    CAMERA, .n_quads = 4, .n_media = 1, .sky = {0.5, 0.6, 0.7},
    .quads = {
        {FLAT(-1, 1.6), .albedo = {0.7, 0.7, 0.7}},
        {FLAT(1, 1.6), .albedo = {0.7, 0.3, 0.3}},
        {.centre = {0, 0, -1.4}, .u = {1.6, 0, 0}, .v = {0, 1, 0}, .albedo = {0.3, 0.7, 0.3}},
        {.centre = {0.3, 0.7, 0.1}, .u = {0.6, 0.1, 0}, .v = {0, 0.1, 0.6},
         .albedo = {0.5, 0.5, 0.5}, .emission = {1.2, 1.1, 1}}},
    .media = {{.centre = {0, 0, 0}, .half = {1.3, 0.95, 1}, .turn = 10, .density = 0.6,
               .albedo = {0.9, 0.85, 0.8}, .g = 0.7}}};

/* Voxels that change from one to the next, half a mean free path wide, over a ground and behind a
 * wall, whose shadow falls on them, under a sky and a sun: suffixes go side by side in lanes. */
static const lf_brute_scene grid = {
    CAMERA, .n_quads = 2, .n_media = 1, .sky = {0.4, 0.5, 0.6},
    .sun_direction = {0.5, -0.6, -0.4}, .sun_angle = 90, .sun_irradiance = {0.9, 0.8, 0.7},
    .quads = {{FLAT(-1.3, 4), .albedo = {0.6, 0.5, 0.4}},
              {.centre = {-0.6, 0.5, 0.5}, .u = {0.5, 0, 0.3}, .v = {0, 0.6, 0},
               .albedo = {0.8, 0.4, 0.2}}},
    .media = {{.centre = {0, 0, 0}, .half = {0.07, 0.06, 0.1}, .turn = 25, .density = 10,
               .albedo = {0.95, 0.9, 0.8}, .grid = true}}};

/* Nothing else, so that suffixes go side by side in lanes. */
static const lf_brute_scene alone = {
    CAMERA, .n_media = 1, .sky = {0.7, 0.9, 1.2},
    .media = {{.centre = {0, 0, 0}, .half = {0.07, 0.06, 0.1}, .turn = 25, .density = 10,
               .albedo = {0.95, 0.9, 0.8}, .g = 0.5, .grid = true}}};

/* The same voxels as cubes, thin, before the sun's wide disk. */
static const lf_brute_scene cubes = {
    CAMERA, .n_quads = 1, .n_media = 1, .sky = {0.3, 0.4, 0.6},
    .sun_direction = {0.5, -0.6, -0.4}, .sun_angle = 80, .sun_irradiance = {1.2, 1.1, 1},
    .quads = {{FLAT(-1.3, 4), .albedo = {0.6, 0.5, 0.4}}},
    .media = {{.centre = {0, 0, 0}, .half = {0.07, 0.06, 0.1}, .turn = -20, .density = 9,
               .albedo = {0.9, 0.8, 0.7}, .g = -0.4,
               .grid = true, .nearest = true}}};

/* Media of two colours and phases in each other, one of them a grid, the lens before them. */
static const lf_brute_scene mixture = {
    CAMERA, .lens_radius = 0.2, .n_media = 2, .n_quads = 2, .sky = {0.6, 0.7, 0.8},
    .quads = {{FLAT(-1.2, 3), .albedo = {0.3, 0.5, 0.7}},
              {.centre = {0.2, 0, -0.2}, .u = {0.5, 0, 0.3}, .v = {0, 0.6, 0},
               .albedo = {0.8, 0.4, 0.2}}},
    .media = {{.centre = {0.4, -0.1, 0.2}, .half = {0.8, 0.9, 0.5}, .turn = -30, .density = 0.9,
               .albedo = {0.2, 0.4, 0.9}, .g = 0.5},
              {.centre = {-0.3, 0, 0}, .half = {0.06, 0.06, 0.09}, .density = 5,
               .albedo = {0.95, 0.9, 0.8}, .g = -0.3, .grid = true}}};

/* Things before and behind the window, a mist among them, each view the mean of what is seen from
 * one and a half steps between the cameras. */
static const lf_brute_scene blurred = {
    CAMERA, .view_blur = 1.5, .n_quads = 4, .n_media = 1, .sky = {0.2, 0.4, 0.6},
    .quads = {
        {FLAT(-1, 3), .albedo = {0.7, 0.6, 0.5}},
        {.centre = {-0.4, 0.2, 1.2}, .u = {0.25, 0, 0}, .v = {0, 0.5, 0.1},
         .albedo = {0.2, 0.2, 0.2}, .emission = {1.6, 1.2, 0.8}},
        {.centre = {0.5, 0, -1.2}, .u = {0.4, 0, 0.2}, .v = {0, 0.8, 0}, .albedo = {0.8, 0.3, 0.2}},
        {.centre = {0, 0, 0}, .u = {0.2, 0, 0}, .v = {0, 0.6, 0}, .albedo = {0.2, 0.3, 0.8}}},
    .media = {{.centre = {0.5, -0.2, 0.7}, .half = {0.5, 0.6, 0.4}, .turn = 20, .density = 0.9,
               .albedo = {0.9, 0.8, 0.7}, .g = 0.5}}};

/* Cameras in a row past things near and far and voxels, each looking straight ahead. */
#define PASSED                                                                                     \
    CAMERA, .track = 1.4, .n_quads = 4, .n_media = 2, .sky = {0.2, 0.4, 0.6},                      \
    .quads = {                                                                                     \
        {FLAT(-1, 4), .albedo = {0.7, 0.6, 0.5}},                                                  \
        {.centre = {-0.4, 0.2, 1.2}, .u = {0.25, 0, 0}, .v = {0, 0.5, 0.1},                        \
         .albedo = {0.2, 0.2, 0.2}, .emission = {1.6, 1.2, 0.8}},                                  \
        {.centre = {1, 0, -1.2}, .u = {0.4, 0, 0.2}, .v = {0, 0.8, 0}, .albedo = {0.8, 0.3, 0.2}}, \
        {.centre = {0, 0, 0}, .u = {0.2, 0, 0}, .v = {0, 0.6, 0}, .albedo = {0.2, 0.3, 0.8}}},     \
    .media = {{.centre = {0.8, -0.2, 0.7}, .half = {0.5, 0.6, 0.4}, .turn = 20, .density = 0.9,    \
               .albedo = {0.9, 0.8, 0.7}, .g = 0.5},                                               \
              {.centre = {-0.9, 0, 0}, .half = {0.06, 0.06, 0.09}, .turn = -30, .density = 4,      \
               .albedo = {0.9, 0.9, 0.8}, .g = 0.3, .grid = true}}
static const lf_brute_scene passed = {PASSED};
static const lf_brute_scene passed_by_lens = {PASSED, .lens_radius = 0.3, .focus = 4.2};

/* clang-format on */

static const char *vdb(void)
{
    static char path[PATH_MAX];
    assert_non_null(realpath(lf_test_built("testdata/patterns.vdb"), path));
    return path;
}

static void oracle(const lf_brute_scene *scene, int strata, lf_blocks *out)
{
    double *picture = malloc(sizeof *picture * n_views * width * height);
    lf_blocks_init(out, n_views, width, height, block);
    for (int k = 0; k < replicates; k++) {
        lf_brute_picture(scene, lf_hash64(lf_test_seed() + 1, (uint64_t)k), width, height, strata,
                         picture);
        lf_blocks_add(out, picture);
    }
    free(picture);
}

static void rendered(const lf_brute_scene *scene, const char *integrator, int cycles,
                     lf_blocks *out)
{
    char *text = lf_brute_text(scene, vdb());
    lf_scene *loaded = lf_test_scene(text);
    assert_true(lf_lane_scene_serves(loaded) == (scene == &alone || scene == &grid));
    lf_renderer *r = lf_test_renderer(loaded, integrator, width, height, NULL);
    lf_blocks_init(out, n_views, width, height, block);
    for (int k = 0; k < replicates; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + 2, (uint64_t)k));
        lf_test_cycles(r, cycles);
        lf_blocks_add_picture(out, r, LF_ESTIMATOR_MIS);
    }
    lf_renderer_destroy(r);
    lf_scene_unref(loaded);
    free(text);
}

/* What a difference of the whole picture has to be, so that it is seen for certain when the noise
 * happens to be 0. */
static void assert_power(const lf_moments *m, const lf_moments *truth)
{
    lf_moments off = *m;
    off.mean = truth->mean * (lf_test_long() ? 1.002 : 1.008);
    double p = lf_p_welch(&off, truth);
    if (!(p < LEVEL))
        fail_msg("another mean would have p %.2g", p);
}

static void assert_agreement(const char *name, const lf_blocks *a, const lf_blocks *truth)
{
    int where = 0, all = truth->n - 1;
    double p = lf_blocks_welch(a, truth, &where);
    const lf_moments *m = &a->moments[all], *t = &truth->moments[all];
    print_message("%s: %.5f +- %.5f, brute force %.5f +- %.5f\n", name, m->mean,
                  lf_moments_error(m), t->mean, lf_moments_error(t));
    if (!(p > BLOCK_LEVEL && lf_p_welch(m, t) > LEVEL))
        fail_msg("%s: block %d is %.5g +- %.2g, by brute force %.5g +- %.2g, p %.2g", name, where,
                 a->moments[where].mean, lf_moments_error(&a->moments[where]),
                 truth->moments[where].mean, lf_moments_error(&truth->moments[where]), p);
    assert_power(m, t);
}

/* Negative control: what the first medium scatters is 2 % off. */
static void assert_other_is_rejected(const lf_brute_scene *scene, int strata, const lf_moments *m)
{
    lf_brute_scene other = *scene;
    lf_blocks truth;
    for (int c = 0; c < 3; c++)
        other.media[0].albedo[c] *= 0.98;
    oracle(&other, strata, &truth);
    assert_true(lf_p_welch(m, &truth.moments[truth.n - 1]) < LEVEL);
    lf_blocks_finish(&truth);
}

/* Negative control: cameras that are points. */
static void assert_points_are_rejected(int strata, const lf_blocks *picture)
{
    lf_brute_scene sharp = blurred;
    sharp.view_blur = 0;
    lf_blocks truth;
    oracle(&sharp, strata, &truth);
    assert_true(lf_blocks_welch(picture, &truth, NULL) < BLOCK_LEVEL);
    lf_blocks_finish(&truth);
}

/* Negative control: a track that is a tenth longer. */
static void assert_longer_is_rejected(int strata, const lf_blocks *picture)
{
    lf_brute_scene longer = passed;
    longer.track *= 1.1;
    lf_blocks truth;
    oracle(&longer, strata, &truth);
    assert_true(lf_blocks_welch(picture, &truth, NULL) < BLOCK_LEVEL);
    lf_blocks_finish(&truth);
}

/* strata and cycles: what the power takes. */
static void compare(const lf_brute_scene *scene, int strata, int cycles)
{
    int more = lf_test_long() ? 4 : 1;
    lf_blocks truth, picture;
    oracle(scene, strata * more, &truth);
    for (int i = 0; i < integrators; i++) {
        rendered(scene, names[i], cycles * more * more, &picture);
        assert_agreement(names[i], &picture, &truth);
        if (scene == &grid)
            assert_other_is_rejected(scene, strata * more, &picture.moments[picture.n - 1]);
        if (scene == &blurred)
            assert_points_are_rejected(strata * more, &picture);
        if (scene == &passed)
            assert_longer_is_rejected(strata * more, &picture);
        lf_blocks_finish(&picture);
    }
    lf_blocks_finish(&truth);
}

/* What other tests hold too, by other means. */
static void compare_long(const lf_brute_scene *scene, int strata, int cycles)
{
    if (!lf_test_long()) {
        print_message("make verify alone\n");
        skip();
    }
    compare(scene, strata, cycles);
}

static void lamps_over_a_box_are_as_found_by_chance(void **state)
{
    (void)state;
    compare(&lamps, 4, 8);
}

static void a_lens_is_as_found_by_chance(void **state)
{
    (void)state;
    compare_long(&lens, 6, 16);
}

static void a_lamp_in_fog_is_as_found_by_chance(void **state)
{
    (void)state;
    compare(&fog, 6, 16);
}

static void voxels_under_a_sky_are_as_found_by_chance_and_darker_ones_are_rejected(void **state)
{
    (void)state;
    compare(&grid, 5, 16);
}

static void a_grid_alone(void **state)
{
    (void)state;
    compare(&alone, 3, 16);
}

static void cubes_before_a_wide_sun_are_as_found_by_chance(void **state)
{
    (void)state;
    compare_long(&cubes, 6, 16);
}

static void media_in_each_other_are_as_found_by_chance(void **state)
{
    (void)state;
    compare(&mixture, 5, 16);
}

static void blurred_views_are_means_of_views_between_and_others_are_rejected(void **state)
{
    (void)state;
    compare(&blurred, 5, 12);
}

static void views_along_a_track_are_as_found_by_chance_and_of_a_longer_one_rejected(void **state)
{
    (void)state;
    compare(&passed, 5, 12);
}

static void a_lens_on_a_track_is_as_found_by_chance(void **state)
{
    (void)state;
    compare_long(&passed_by_lens, 6, 24);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_grid_alone),
        cmocka_unit_test(lamps_over_a_box_are_as_found_by_chance),
        cmocka_unit_test(a_lens_is_as_found_by_chance),
        cmocka_unit_test(a_lamp_in_fog_is_as_found_by_chance),
        cmocka_unit_test(voxels_under_a_sky_are_as_found_by_chance_and_darker_ones_are_rejected),
        cmocka_unit_test(cubes_before_a_wide_sun_are_as_found_by_chance),
        cmocka_unit_test(media_in_each_other_are_as_found_by_chance),
        cmocka_unit_test(blurred_views_are_means_of_views_between_and_others_are_rejected),
        cmocka_unit_test(views_along_a_track_are_as_found_by_chance_and_of_a_longer_one_rejected),
        cmocka_unit_test(a_lens_on_a_track_is_as_found_by_chance),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
