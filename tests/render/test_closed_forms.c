/* Pictures that are known: furnaces, an absorbing slab, a point light on a plane, single scattering
 * in a slab, two cameras in one place. Replicates are seeds; blocks are compared by Student's t,
 * false alarms as stat.h says. */
#include "tests/testing.h"

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

enum { width = 32, height = 24, n_views = 5 };

/* as in lf_blocks blocks[3] */
static const lf_estimator estimators[] = {LF_ESTIMATOR_MWIS, LF_ESTIMATOR_MIS, LF_ESTIMATOR_CV};
static const char *const integrators[] = {"mvpt", "vpt"};

/* Comparisons of this program that may fail by chance: 3 estimators x 2 integrators x 61 blocks x
 * 10 scenes. */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 3 * 2 * 61 * 10)

/* Truth of one pixel: mean of a function of the pinhole ray's slopes over it. */
typedef double (*truth_fn)(const lf_renderer *renderer, int view, double mx, double my);

static double *truth_picture(const lf_renderer *r, truth_fn truth)
{
    const double place[2] = {0.5 - sqrt(1.0 / 12.0), 0.5 + sqrt(1.0 / 12.0)};
    double *out = malloc(sizeof *out * n_views * width * height), *p = out;
    for (int row = 0; row < height; row++) {
        for (int view = 0; view < n_views; view++) {
            for (int column = 0; column < width; column++, p++) {
                *p = 0.0;
                for (int i = 0; i < 4; i++) {
                    double mx, my;
                    lf_test_slopes(r, view, column + place[i & 1], row + place[i >> 1], &mx, &my);
                    *p += 0.25 * truth(r, view, mx, my);
                }
            }
        }
    }
    return out;
}

static double one(const lf_renderer *renderer, int view, double mx, double my)
{
    (void)renderer, (void)view, (void)mx, (void)my;
    return 1.0;
}

/* The mean over seeds of every estimate by both integrators against the truth. mis and cv are
 * unbiased after `passes`; mwis is consistent only, its bias being that of pixels where nothing has
 * arrived yet, and answers after mwis_passes more (0 = not asked). */
static void assert_blocks(const char *text, truth_fn truth, int passes, int mwis_passes,
                          int replicates, double rounding)
{
    lf_scene *scene = lf_test_scene(text);
    for (int i = 0; i < 2; i++) {
        lf_renderer *r = lf_test_renderer(scene, integrators[i], width, height, NULL);
        double *expected = truth_picture(r, truth);
        lf_blocks blocks[3];
        for (int e = 0; e < 3; e++)
            lf_blocks_init(&blocks[e], n_views, width, height, 8);
        for (int k = 0; k < replicates; k++) {
            lf_test_reseed(r, lf_hash64(lf_test_seed(), (uint64_t)k));
            lf_test_passes(r, passes);
            lf_blocks_add_picture(&blocks[1], r, LF_ESTIMATOR_MIS);
            lf_blocks_add_picture(&blocks[2], r, LF_ESTIMATOR_CV);
            if (mwis_passes > 0) {
                lf_test_passes(r, mwis_passes);
                lf_blocks_add_picture(&blocks[0], r, LF_ESTIMATOR_MWIS);
            }
        }
        for (int e = mwis_passes > 0 ? 0 : 1; e < 3; e++) {
            int where = 0;
            double p = lf_blocks_p(&blocks[e], expected, rounding, &where);
            if (!(p > LEVEL))
                fail_msg("%s %s: block %d is %.6g +- %.2g, p %.2g", integrators[i],
                         lf_estimator_name(estimators[e]), where, blocks[e].moments[where].mean,
                         lf_moments_error(&blocks[e].moments[where]), p);
        }
        for (int e = 0; e < 3; e++)
            lf_blocks_finish(&blocks[e]);
        free(expected);
        lf_renderer_destroy(r);
    }
    lf_scene_unref(scene);
}

/* True where the known part has not seen any pivot yet: at silhouettes. */
static bool is_unsettled(const lf_renderer *r, int row, int pixel)
{
    float q = 0.0f;
    for (int h = 0; h < 2; h++)
        q += lf_film_at(&r->film, row, h).q[pixel];
    return q == 0.0f;
}

/* By mwis, after a few whole cycles, every pixel where W and q both know of pivots or nothing does,
 * against the truth. */
static void assert_pixels(const char *text, const char *integrator, truth_fn truth,
                          double tolerance)
{
    enum { pixels = n_views * width * height };
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    double *expected = truth_picture(r, truth);
    float *rgb = malloc(3 * pixels * sizeof *rgb);
    uint8_t *flags = malloc(pixels);
    int compared = 0;
    lf_test_passes(r, 8 * n_views);
    assert_int_equal(lf_renderer_resolve(r, LF_ESTIMATOR_MWIS, rgb, flags), LF_OK);
    for (int i = 0; i < pixels; i++) {
        if (flags[i] & LF_PIXEL_HOLE ||
            (!(flags[i] & LF_PIXEL_SETTLED) &&
             is_unsettled(r, i / (n_views * width), i % (n_views * width))))
            continue;
        compared++;
        for (int c = 0; c < 3; c++) {
            if (!(fabs((double)rgb[3 * i + c] - expected[i]) <= tolerance * expected[i]))
                fail_msg("%s: pixel %d is %.7g, not %.7g", integrator, i, (double)rgb[3 * i + c],
                         expected[i]);
        }
    }
    assert_true(compared > 0.95 * pixels);
    free(flags);
    free(rgb);
    free(expected);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* ---------------------------------------------------------------------------------- furnaces -- */

#define FOG(g) lf_test_scene_patched("furnace-fog", "{'volumes': {'fog': {'g': " g "}}}")
#define WHITE_SLAB(g) lf_test_scene_patched("furnace-slab", "{'volumes': {'fog': {'g': " g "}}}")
#define WHITE_SURFACES lf_test_scene_text("furnace-surfaces")
#define BALL(material) lf_test_scene_patched("furnace-ball", "{'materials': {'m': " material "}}")

static void case_01_a_white_fog_in_a_white_furnace_is_white_in_every_pixel(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        assert_pixels(FOG("0"), integrators[i], one, 1e-4);
        /* At silhouettes of anisotropic fog a tile may prefer N/W, which is 1 in the mean only: no
         * silhouettes here. */
        assert_pixels(WHITE_SLAB("0.7"), integrators[i], one, 1e-4);
        assert_pixels(WHITE_SLAB("-0.5"), integrators[i], one, 1e-4);
    }
}

static void case_01_a_white_fog_in_a_white_furnace_is_white_in_the_mean(void **state)
{
    (void)state;
    assert_blocks(FOG("0"), one, 10, 0, 24, 1e-4);
    assert_blocks(FOG("0.7"), one, 7, 0, 24, 1e-4);
}

static void case_01_white_surfaces_in_a_white_furnace_are_white(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++)
        assert_pixels(WHITE_SURFACES, integrators[i], one, 1e-4);
    assert_blocks(BALL("{ 'type': 'conductor', 'albedo': 1, 'roughness': 0 }"), one, 10, 0, 24,
                  1e-4);
    assert_blocks(WHITE_SURFACES, one, 10, 0, 16, 1e-4);
    assert_blocks(BALL("{ 'type': 'plastic', 'albedo': 1, 'roughness': 0 }"), one, 10, 0, 24, 6e-4);
}

/* To what the fit of lost energy is good for (surface_energy.c). */
static void case_01_white_metals_in_a_white_furnace_are_white(void **state)
{
    (void)state;
    assert_blocks(BALL("{ 'type': 'conductor', 'albedo': 1, 'roughness': 0.3 }"), one, 10, 0, 24,
                  2.5e-3);
    assert_blocks(BALL("{ 'type': 'conductor', 'albedo': 1, 'roughness': 1 }"), one, 10, 0, 24,
                  2.5e-3);
}

static void case_01_a_furnace_of_lamps_is_white(void **state)
{
    (void)state;
    assert_blocks(lf_test_scene_text("furnace-of-light"), one, 10, 0, 24, 1e-4);
}

/* Negative control: an albedo of 0.99 is not white. */
static void case_01_a_grey_furnace_is_rejected(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(
        lf_test_scene_patched("furnace-fog", "{'volumes': {'fog': {'albedo': 0.99, 'g': null}}}"));
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    double *expected = truth_picture(r, one);
    lf_blocks blocks;
    lf_blocks_init(&blocks, n_views, width, height, 8);
    for (int k = 0; k < 24; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed(), (uint64_t)k));
        lf_test_passes(r, 10);
        lf_blocks_add_picture(&blocks, r, LF_ESTIMATOR_MIS);
    }
    assert_true(lf_blocks_p(&blocks, expected, 1e-4, NULL) < LEVEL);
    lf_blocks_finish(&blocks);
    free(expected);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* ------------------------------------------------------------------------------------- slabs -- */

#define SLAB(albedo, g, lights, depth)                                                             \
    lf_test_scene_patched("facing-slab", "{'volumes': {'slab': {'albedo': " albedo ", 'g': " g     \
                                         "}}, 'render': {'max_depth': " depth "}, " lights "}")
#define IN_FRONT_OF_A_SKY "'lights': {'sun': null, 'sky': {'type': 'environment', 'radiance': 1}}"
#define SUN "'lights': {}"

/* The slab is 1 thick and faces the cameras. */
static double absorbed(const lf_renderer *renderer, int view, double mx, double my)
{
    (void)renderer, (void)view;
    return exp(-1.5 * sqrt(1.0 + mx * mx + my * my));
}

static void case_03_a_black_slab_lets_exp_of_minus_its_depth_through(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++)
        assert_pixels(SLAB("0", "0", IN_FRONT_OF_A_SKY, "8"), integrators[i], absorbed, 1e-3);
    assert_blocks(SLAB("0", "0.5", IN_FRONT_OF_A_SKY, "8"), absorbed, 5, 5, 8, 1e-3);
}

static double single_scattering(double g, double mx, double my)
{
    /* Camera space looks along -z: the sun travels along (0.3, -0.2, 1) in it. */
    const double sun[3] = {0.3, -0.2, 1.0}, norm = sqrt(0.3 * 0.3 + 0.2 * 0.2 + 1.0);
    double length = sqrt(1.0 + mx * mx + my * my), mu_v = 1.0 / length, mu_0 = 1.0 / norm;
    double cosine = -(mx * sun[0] + my * sun[1] + sun[2]) / (length * norm);
    double phase = (1.0 - g * g) / (4.0 * M_PI * pow(1.0 + g * g - 2.0 * g * cosine, 1.5));
    double k = 1.0 / mu_v + 1.0 / mu_0;
    return 0.8 * 3.0 * phase / mu_v * (1.0 - exp(-1.5 * k)) / k;
}

static double single_isotropic(const lf_renderer *renderer, int view, double mx, double my)
{
    (void)renderer, (void)view;
    return single_scattering(0.0, mx, my);
}

static double single_backward(const lf_renderer *renderer, int view, double mx, double my)
{
    (void)renderer, (void)view;
    return single_scattering(-0.6, mx, my);
}

static void case_08_a_slab_scatters_the_sun_once(void **state)
{
    (void)state;
    assert_blocks(SLAB("0.8", "0", SUN, "1"), single_isotropic, 10, 90, 24, 2e-3);
    assert_blocks(SLAB("0.8", "-0.6", SUN, "1"), single_backward, 7, 90, 24, 2e-3);
}

/* --------------------------------------------------------------------------- a lamp, a plane -- */

static double lamp_on_a_plane(const lf_renderer *renderer, int view, double mx, double my)
{
    double x = (double)lf_test_rows(renderer)->rig.b[view] + 5.0 * mx - 0.3, y = 5.0 * my - 0.2,
           r2 = x * x + y * y + 1.0;
    return 0.6 / M_PI * 4.0 / (r2 * sqrt(r2));
}

static void case_06_a_lamp_lights_a_plane_by_cosine_and_distance(void **state)
{
    (void)state;
    assert_blocks(lf_test_scene_text("light-on-plane"), lamp_on_a_plane, 10, 10, 16, 1e-3);
}

/* --------------------------------------------------------------------------- one place twice -- */

static void case_05_cameras_in_one_place_see_one_picture(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_text("one-place"));
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    lf_test_passes(r, 5);
    size_t pixels = (size_t)width;
    for (int row = 0; row < height; row++) {
        for (int h = 0; h < 2; h++) {
            lf_film_half half = lf_film_at(&r->film, row, h);
            for (int view = 1; view < 3; view++) {
                assert_memory_equal(half.scattered, half.scattered + (size_t)view * pixels,
                                    pixels * sizeof *half.scattered);
                assert_memory_equal(half.q, half.q + (size_t)view * pixels,
                                    pixels * sizeof *half.q);
                assert_memory_equal(half.w2, half.w2 + (size_t)view * pixels,
                                    pixels * sizeof *half.w2);
            }
        }
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* A mirror in the window's own plane covers the same part of every view, and shows the sky in 0.9
 * of its light: however passes are cut into visits, in the middle of the mirror as in pixels that
 * it covers in part. */
static void mean_of_a_mirror(const char *integrator, int subsets, lf_moments *out)
{
    lf_scene *scene = lf_test_scene(lf_test_scene_text("mirror-in-window"));
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    *out = (lf_moments){0};
    for (int k = 0; k < 32; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + 77, (uint64_t)k));
        for (int done = 0; subsets > 0 && done < 20; done += subsets)
            assert_int_equal(lf_renderer_pass(r, NULL, subsets, NULL, NULL, NULL), LF_OK);
        if (subsets == 0)
            lf_test_passes(r, 40);
        double *picture = lf_test_picture(r, LF_ESTIMATOR_MIS), sum = 0.0;
        for (int i = 0; i < n_views * width * height; i++)
            sum += picture[i];
        lf_moments_add(out, sum / (n_views * width * height));
        free(picture);
    }
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* Thirty views of a mirror that fills them. */
#define ALL_MIRROR                                                                                 \
    lf_test_scene_patched("mirror-in-window",                                                      \
                          "{'camera': {'views': 30, 'cone': 20}, "                                 \
                          "'meshes': {'mirror': {'transform': {'scale': 20}}}}")

/* One pass gives each mirrored pixel a sample, and none of them more than another: wherever the
 * picture is mirror, it is what converged ones are, 0.9 of the sky. */
static void the_shortest_visit_sees_all_of_a_mirror(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(ALL_MIRROR);
    const int subsets[] = {1, 7, 8, 25, 30};
    for (size_t s = 0; s < sizeof subsets / sizeof *subsets; s++) {
        lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
        assert_int_equal(lf_renderer_pass(r, NULL, subsets[s], NULL, NULL, NULL), LF_OK);
        double *picture = lf_test_picture(r, LF_ESTIMATOR_MWIS);
        double low = picture[0], high = low;
        for (int i = 0; i < 30 * width * height; i++) {
            low = fmin(low, picture[i]);
            high = fmax(high, picture[i]);
        }
        print_message("%d passes: %.7f to %.7f\n", subsets[s], low, high);
        assert_true(low > 0.9 - 1e-5 && high < 0.9 + 1e-5);
        free(picture);
        lf_renderer_destroy(r);
    }
    lf_scene_unref(scene);
}

/* A pass that is split between the halves has every other column of base samples each, and no
 * others: M is there in one pixel of 30, and in the mean what it is. */
static void a_split_pass_has_mirrors(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(ALL_MIRROR);
    static const char *const names[] = {"mvpt", "vpt"};
    for (int i = 0; i < 2; i++) {
        lf_renderer *r = lf_test_renderer(scene, names[i], width, height, NULL);
        assert_int_equal(lf_renderer_passes(r, NULL, 1, true, NULL, NULL, NULL), LF_OK);
        double *picture = lf_test_picture(r, LF_ESTIMATOR_MIS), sum = 0.0;
        for (int k = 0; k < 30 * width * height; k++)
            sum += picture[k] / (30 * width * height);
        print_message("%s: %.6f, should be 0.9\n", names[i], sum);
        lf_assert_close(sum, 0.9, 1e-4, 0.0);
        free(picture);
        lf_renderer_destroy(r);
    }
    lf_scene_unref(scene);
}

static void a_mirror_shows_its_share_of_the_sky_however_visits_are_cut(void **state)
{
    (void)state;
    static const struct {
        const char *integrator;
        int subsets; /* of 5; 0: the offline schedule */
    } cuts[] = {{"vpt", 0}, {"mvpt", 0}, {"mvpt", 1}, {"mvpt", 2}, {"amvpt", 0}};
    const double half = 5.0 * tan(12.0 * (double)LF_PI / 180.0),
                 share = 0.25 / (half * half * 1.3333333333);
    for (size_t i = 0; i < sizeof cuts / sizeof cuts[0]; i++) {
        lf_moments m;
        mean_of_a_mirror(cuts[i].integrator, cuts[i].subsets, &m);
        double error = lf_moments_error(&m);
        print_message("%s %d: %.6f +- %.1e, should be %.6f\n", cuts[i].integrator, cuts[i].subsets,
                      m.mean, error, 1.0 - 0.1 * share);
        assert_true(fabs(m.mean - (1.0 - 0.1 * share)) < 5.0 * error);
        assert_true(error < 1e-3 * share); /* half a per cent of M would be seen */
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(case_01_a_white_fog_in_a_white_furnace_is_white_in_every_pixel),
        cmocka_unit_test(case_01_a_white_fog_in_a_white_furnace_is_white_in_the_mean),
        cmocka_unit_test(case_01_white_surfaces_in_a_white_furnace_are_white),
        cmocka_unit_test(case_01_white_metals_in_a_white_furnace_are_white),
        cmocka_unit_test(case_01_a_furnace_of_lamps_is_white),
        cmocka_unit_test(case_01_a_grey_furnace_is_rejected),
        cmocka_unit_test(case_03_a_black_slab_lets_exp_of_minus_its_depth_through),
        cmocka_unit_test(case_08_a_slab_scatters_the_sun_once),
        cmocka_unit_test(case_06_a_lamp_lights_a_plane_by_cosine_and_distance),
        cmocka_unit_test(case_05_cameras_in_one_place_see_one_picture),
        cmocka_unit_test(the_shortest_visit_sees_all_of_a_mirror),
        cmocka_unit_test(a_split_pass_has_mirrors),
        cmocka_unit_test(a_mirror_shows_its_share_of_the_sky_however_visits_are_cut),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
