/* Media whose extinction differs between channels. What is seen of a channel is what is seen of a
 * scene whose media have that channel's extinction alone: each is lit by one channel's light and
 * compared with such a grey scene, which has none of this in it, in the unbiased answers of both
 * integrators, live pictures included; blocks of 16 x 16 pixels of each view by Welch's test,
 * replicates being seeds. Slabs that absorb alone are compared with their closed form. Negative
 * controls: extinction that is 10 % off, or the mean of the channels in its place, is rejected. */
#include "tests/testing.h"

#include "tests/render/grids.h"
#include "tests/scene_file.h"

enum { width = 32, height = 24, n_views = 3, tile = 16, tiles = n_views * 4 + 1, answers = 3 };

/* Five scenes of three channels by two integrators. */
#define LEVEL lf_sidak(LF_FALSE_ALARM, 5 * 3 * 2 * answers * tiles)

/* In these texts %S stands for the extinction of the channels and %L0.5 for such a light of one. */

static const char *const names[answers] = {"mis", "cv", "mis of a live picture"};
static const double colour[3] = {1.0, 0.4, 0.1};

/* The scene with an extinction of its first volume, and with all its light in one channel. The
 * caller frees it. */
static char *text_of(const char *name, const char *extinction, int channel)
{
    static const char *const words[] = {"radiance", "irradiance", "intensity"};
    json_t *doc = lf_test_scene_document(name), *volumes = json_object_get(doc, "volumes"), *light;
    const char *key;
    json_object_set_new(json_object_iter_value(json_object_iter(volumes)), "sigma_t",
                        lf_test_json("sigma_t", extinction));
    json_object_foreach(json_object_get(doc, "lights"), key, light) for (int i = 0; i < 3; i++)
    {
        double value = json_number_value(json_object_get(light, words[i])), rgb[3] = {0};
        rgb[channel] = value;
        if (value > 0.0)
            json_object_set_new(light, words[i], json_pack("[fff]", rgb[0], rgb[1], rgb[2]));
    }
    char *text = json_dumps(doc, 0);
    assert_non_null(text);
    json_decref(doc);
    return text;
}

typedef enum medium { SHAPES, LINEAR, NEAREST } medium;

/* scale: on the extinction of the channel, in grey; 0: the chromatic scene. */
static lf_scene *scene_of(const char *name, medium kind, int channel, double scale)
{
    char extinction[128];
    if (scale > 0.0)
        snprintf(extinction, sizeof extinction, "%g", scale * colour[channel]);
    else
        snprintf(extinction, sizeof extinction, "[%g, %g, %g]", colour[0], colour[1], colour[2]);
    char *text = text_of(name, extinction, channel);
    float sigma = 1.5f * (float)(scale > 0.0 ? scale * colour[channel] : 1.0);
    lf_scene *scene = kind == SHAPES
                          ? lf_test_scene(text)
                          : lf_test_grid_scene(text, lf_test_grid(lf_test_rough, 12, 12, 12), 0.15,
                                               0.4, 2.0f * sigma, kind == NEAREST);
    assert_int_equal(lf_has(scene, LF_TRAIT_CHROMATIC_MEDIA), !(scale > 0.0));
    free(text);
    return scene;
}

static void passes(lf_renderer *r, int n, bool live)
{
    if (!live)
        lf_test_passes(r, n);
    for (int i = 0; live && i < n; i++)
        assert_int_equal(lf_renderer_pass(r, NULL, 1 + i % 2, NULL, NULL, NULL), LF_OK);
}

/* Answers of an integrator: out[answers], or of one alone where only `mis` is wanted. */
static void pictures(lf_scene *scene, const char *integrator, int replicates, int n, uint64_t salt,
                     bool all, lf_blocks *out)
{
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    for (int i = 0; i < (all ? answers : 1); i++)
        lf_blocks_init(&out[i], n_views, width, height, tile);
    for (int k = 0; k < replicates; k++) {
        lf_test_reseed(r, lf_hash64(lf_test_seed() + salt, (uint64_t)k));
        passes(r, n, false);
        lf_blocks_add_picture(&out[0], r, LF_ESTIMATOR_MIS);
        if (!all)
            continue;
        lf_blocks_add_picture(&out[1], r, LF_ESTIMATOR_CV);
        lf_test_reseed(r, lf_hash64(lf_test_seed() + salt + 1, (uint64_t)k));
        passes(r, n / 2, true);
        lf_blocks_add_picture(&out[2], r, LF_ESTIMATOR_MIS);
    }
    lf_renderer_destroy(r);
}

static void assert_same(const char *integrator, int channel, const lf_blocks *seen,
                        const lf_blocks *grey)
{
    for (int i = 0; i < answers; i++) {
        int where = 0;
        double p = lf_blocks_welch(&seen[i], grey, &where);
        const lf_moments *a = &seen[i].moments[where], *b = &grey->moments[where];
        const lf_moments *whole = &seen[i].moments[tiles - 1], *truth = &grey->moments[tiles - 1];
        print_message("%s, channel %d, %s: %.5f +- %.5f, grey %.5f +- %.5f, p %.2g\n", integrator,
                      channel, names[i], whole->mean, lf_moments_error(whole), truth->mean,
                      lf_moments_error(truth), p);
        if (!(p > LEVEL))
            fail_msg("%s, channel %d, %s: block %d is %.6g +- %.2g, grey %.6g +- %.2g, p %.2g",
                     integrator, channel, names[i], where, a->mean, lf_moments_error(a), b->mean,
                     lf_moments_error(b), p);
    }
}

static void compare(const char *name, medium kind, int replicates, int n)
{
    int more = lf_test_long() ? 4 : 1;
    for (int channel = 0; channel < 3; channel++) {
        lf_scene *chromatic = scene_of(name, kind, channel, 0.0),
                 *grey = scene_of(name, kind, channel, 1.0);
        lf_blocks truth;
        pictures(grey, "vpt", replicates * more, n, 100, false, &truth);
        for (int i = 0; i < 2; i++) {
            const char *integrator = i ? "vpt" : "mvpt";
            lf_blocks seen[answers];
            pictures(chromatic, integrator, replicates * more, n, 200, true, seen);
            assert_same(integrator, channel, seen, &truth);
            for (int j = 0; j < answers; j++)
                lf_blocks_finish(&seen[j]);
        }
        lf_blocks_finish(&truth);
        lf_scene_unref(chromatic);
        lf_scene_unref(grey);
    }
}

static void channels_are_those_of_grey_scenes(void **state)
{
    (void)state;
    compare("chromatic-overlap", SHAPES, 10, 12);
}

static void channels_before_a_mirror(void **state)
{
    (void)state;
    compare("chromatic-mirror", SHAPES, 10, 12);
}

static void channels_about_a_bulb(void **state)
{
    (void)state;
    compare("chromatic-bulb", SHAPES, 10, 12);
}

static void channels_of_a_grid(void **state)
{
    (void)state;
    compare("chromatic-voxels", LINEAR, 10, 12);
    compare("chromatic-voxels", NEAREST, 10, 12);
}

static void another_extinction_is_rejected(void **state)
{
    (void)state;
    static const double wrong[] = {1.1, 0.9, 0.5 / 0.4};
    lf_scene *chromatic = scene_of("chromatic-voxels", LINEAR, 1, 0.0);
    lf_blocks seen[answers], truth[answers];
    pictures(chromatic, "mvpt", 10, 12, 200, true, seen);
    for (int i = 0; i < 3; i++) {
        lf_scene *grey = scene_of("chromatic-voxels", LINEAR, 1, wrong[i]);
        pictures(grey, "mvpt", 10, 12, 100, true, truth);
        assert_true(lf_blocks_welch(&seen[1], &truth[1], NULL) < LEVEL);
        for (int k = 0; k < answers; k++)
            lf_blocks_finish(&truth[k]);
        lf_scene_unref(grey);
    }
    for (int k = 0; k < answers; k++)
        lf_blocks_finish(&seen[k]);
    lf_scene_unref(chromatic);
}

static void whole_cycles(lf_renderer *r)
{
    lf_test_cycles(r, 4);
}

/* What mwis and cv stand on: in the mean W is n times the mean of the channels' q. */
static void weights_are_what_is_known_of_them(void **state)
{
    (void)state;
    lf_scene *scene = scene_of("chromatic-voxels", LINEAR, 0, 0.0);
    lf_renderer *r = lf_test_renderer(scene, "mvpt", width, height, NULL);
    lf_blocks blocks[3];
    lf_test_weight_blocks(r, whole_cycles, 10, tile, blocks);
    assert_true(lf_blocks_p_zero(&blocks[0], NULL) > LEVEL);
    for (int i = 0; i < 3; i++)
        lf_blocks_finish(&blocks[i]);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* A slab 1 thick that faces the cameras, before a sky of 1: every pixel is a mean of exp(-sigma_t
 * length) over it, which its middle is to 1e-4. */
static void a_slab_that_absorbs_is_its_closed_form(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_text("chromatic-slab"));
    for (int i = 0; i < 2; i++) {
        lf_renderer *r = lf_test_renderer(scene, i ? "vpt" : "mvpt", width, height, NULL);
        lf_test_passes(r, 6);
        double *picture = lf_test_picture(r, LF_ESTIMATOR_MWIS), *p = picture;
        for (int row = 0; row < height; row++) {
            for (int view = 0; view < n_views; view++) {
                for (int column = 0; column < width; column++, p++) {
                    double mx, my;
                    lf_test_slopes(r, view, column + 0.5, row + 0.5, &mx, &my);
                    double length = sqrt(1.0 + mx * mx + my * my);
                    lf_assert_close(*p,
                                    0.5 * exp(-0.5 * length) + 0.3 * exp(-length) +
                                        0.2 * exp(-6.0 * length),
                                    0, 1e-3);
                }
            }
        }
        free(picture);
        lf_renderer_destroy(r);
    }
    lf_scene_unref(scene);
}

static void emission_beside_colour_is_refused(void **state)
{
    (void)state;
    lf_test_assert_refused(".",
                           "{'quiltd': 1, 'volumes': {'a': {'shape': 'box', 'sigma_t': [1, 1, 2]}, "
                           "'b': {'shape': 'box', 'emission': 1}}}",
                           "/volumes/b/emission", "sigma_t differs between channels");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_slab_that_absorbs_is_its_closed_form),
        cmocka_unit_test(channels_are_those_of_grey_scenes),
        cmocka_unit_test(channels_before_a_mirror),
        cmocka_unit_test(channels_about_a_bulb),
        cmocka_unit_test(channels_of_a_grid),
        cmocka_unit_test(another_extinction_is_rejected),
        cmocka_unit_test(emission_beside_colour_is_refused),
        cmocka_unit_test(weights_are_what_is_known_of_them),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
