/* Layers beside the colours of view pixels. */
#include "tests/testing.h"

#include "tests/scene_file.h"
#include "tests/stat/fixture.h"

/* A wall across the view axis at a distance of 6.25 in the left half, a thin slab from 3.5 to 4.5
 * before all of it. */

enum { SIDE = 16, VIEWS = 3, PIXELS = SIDE * SIDE * VIEWS };

static lf_renderer *render(lf_scene *scene, bool features, lf_pool *pool, uint64_t seed)
{
    lf_renderer *r = lf_test_renderer(scene, "mvpt", SIDE, SIDE, pool);
    lf_render_settings settings = *lf_renderer_settings(r);
    settings.features = features;
    settings.seed = seed;
    lf_assert_ok(lf_renderer_restart(r, scene, &settings, NULL), NULL);
    lf_test_passes(r, 16 * VIEWS);
    return r;
}

/* Caller frees. */
static float *layers_of(const lf_renderer *r, unsigned layers)
{
    size_t n = (size_t)lf_layer_channels(layers, NULL);
    float *out = malloc(PIXELS * n * sizeof *out);
    lf_assert_ok(lf_renderer_layers(r, LF_ESTIMATOR_MWIS, layers, out, NULL), NULL);
    return out;
}

static void pixels_know_how_far_and_what_they_see(void **state)
{
    (void)state;
    const unsigned wanted =
        LF_LAYER_DEPTH | LF_LAYER_COVERAGE | LF_LAYER_NORMAL | LF_LAYER_ALBEDO | LF_LAYER_SAMPLES;
    static const float wall[] = {6.25f, 1.0f, 0.0f, 0.0f, 1.0f, 0.5f, 0.25f, 0.75f};
    lf_scene *scene = lf_test_scene(lf_test_scene_text("wall-behind-slab"));
    lf_renderer *r = render(scene, true, NULL, 1);
    float *out = layers_of(r, wanted);
    for (int row = 0; row < SIDE; row++)
        for (int view = 0; view < VIEWS; view++)
            for (int column = 0; column < SIDE; column++) {
                const float *p = out + 9 * ((row * VIEWS + view) * SIDE + column);
                if (column < SIDE / 2 - 2)
                    for (int c = 0; c < 8; c++)
                        lf_assert_close((double)p[c], (double)wall[c], 2e-3, 2e-3);
                if (column < SIDE / 2 + 2)
                    continue;
                lf_assert_close((double)p[0], 4.0, 1e-2, 0.0);
                lf_assert_close((double)p[1], 1e-3, 2e-2, 0.0);
                for (int c = 2; c < 8; c++)
                    assert_true(p[c] == 0.0f);
            }
    double samples = 0.0;
    for (int i = 0; i < PIXELS; i++)
        samples += (double)out[9 * i + 8] / PIXELS;
    lf_assert_close(samples, 16.0, 0.15, 0.0);
    free(out);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* Nothing is scattered by a mirror or a lamp: where they are is known all the same, also behind a
 * thin slab. */
static void mirrors_and_lamps_are_where_they_are(void **state)
{
    (void)state;
    static const char *const walls[] = {
        "{ 'type': 'conductor', 'albedo': 0.9, 'roughness': 0 }",
        "{ 'type': 'diffuse', 'albedo': 0, 'roughness': null, 'emission': 1 }"};
    for (int i = 0; i < 4; i++) {
        lf_scene *scene =
            lf_test_scene(lf_test_scene_patched("mirror-behind-slab", "{'materials': {'m': %s}%s}",
                                                walls[i % 2], i < 2 ? ", 'volumes': null" : ""));
        lf_renderer *r = render(scene, true, NULL, 1);
        float *out = layers_of(r, LF_LAYER_DEPTH | LF_LAYER_COVERAGE);
        for (int k = 0; k < PIXELS; k++) {
            /* of the slab's thousandth, at 4 */
            lf_assert_close((double)out[2 * k], 6.25, 2e-3, 0.0);
            lf_assert_close((double)out[2 * k + 1], 1.0, 1e-6, 0.0);
        }
        free(out);
        lf_renderer_destroy(r);
        lf_scene_unref(scene);
    }
}

/* Where all film points of a pixel have met the mirror and the ray through its middle has not, what
 * that has met stands in: a mirror with a slanting edge before a wall has no hole at its rim. */
static void rims_of_mirrors_are_no_holes(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_text("mirror-rim"));
    lf_renderer *r = lf_test_renderer(scene, "mvpt", SIDE, SIDE, NULL);
    lf_render_settings settings = *lf_renderer_settings(r);
    settings.features = true;
    lf_assert_ok(lf_renderer_restart(r, scene, &settings, NULL), NULL);
    lf_test_passes(r, 2);
    float *out = layers_of(r, LF_LAYER_DEPTH | LF_LAYER_COVERAGE);
    for (int k = 0; k < PIXELS; k++) {
        assert_true(out[2 * k] > 4.9f && out[2 * k] < 6.3f);
        assert_true(out[2 * k + 1] > 0.0f);
    }
    free(out);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static void where_nothing_is_met_everything_is_0(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_patched("wall-behind-slab", "{'volumes': null}"));
    lf_renderer *r = render(scene, true, NULL, 1);
    float *out = layers_of(r, 127);
    int n = lf_layer_channels(127, NULL);
    for (int i = SIDE / 2 + 2; i < SIDE; i++)
        for (int c = 0; c < n; c++)
            assert_true(c == n - 2 || out[n * i + c] == 0.0f); /* samples */
    free(out);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* Against the squared distance of two pictures of independent seeds, which is twice the variance.
 */
static void variance_is_what_pictures_are_apart(void **state)
{
    (void)state;
    double said = 0.0, apart = 0.0;
    lf_scene *scene = lf_test_scene(lf_test_scene_views("fogs", 3));
    for (uint64_t seed = 0; seed < 24; seed++) {
        static float colours[2][3 * PIXELS];
        lf_renderer *r[2];
        for (uint64_t i = 0; i < 2; i++) {
            r[i] = render(scene, false, NULL, 2 * seed + i);
            lf_assert_ok(lf_renderer_resolve(r[i], LF_ESTIMATOR_MWIS, colours[i], NULL), NULL);
            float *out = layers_of(r[i], LF_LAYER_VARIANCE);
            for (int k = 0; k < 3 * PIXELS; k++)
                said += (double)out[k];
            free(out);
            lf_renderer_destroy(r[i]);
        }
        for (int k = 0; k < 3 * PIXELS; k++)
            apart += pow((double)colours[0][k] - (double)colours[1][k], 2.0);
    }
    print_message("variance: %.4g said, %.4g there\n", said, apart);
    lf_assert_close(said, apart, 0.15, 0.0);
    lf_scene_unref(scene);
}

static void layers_do_not_depend_on_threads_and_need_what_they_are_made_of(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_views("mixed", 3));
    float *out[2], none[1];
    for (int i = 0; i < 2; i++) {
        lf_pool *pool = NULL;
        lf_assert_ok(lf_pool_create(1 + 2 * i, &pool), NULL);
        lf_renderer *r = render(scene, true, pool, 5);
        out[i] = layers_of(r, 127);
        lf_renderer_destroy(r);
        lf_pool_destroy(pool);
    }
    assert_memory_equal(out[0], out[1],
                        PIXELS * (size_t)lf_layer_channels(127, NULL) * sizeof(float));
    lf_renderer *r = render(scene, false, NULL, 5);
    assert_int_equal(lf_renderer_layers(r, LF_ESTIMATOR_MWIS, LF_LAYER_DEPTH, none, NULL),
                     LF_E_STATE);
    for (int i = 0; i < 2; i++)
        free(out[i]);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

/* A live picture has every fourth row in its first second. */
static void rows_without_visits_are_as_far_as_the_nearest_one_with(void **state)
{
    (void)state;
    const lf_part fourth = {.first_row = 2, .row_step = 4};
    const unsigned wanted = LF_LAYER_DEPTH | LF_LAYER_NORMAL | LF_LAYER_VARIANCE | LF_LAYER_SAMPLES;
    const int n = 8, row_length = n * SIDE * VIEWS;
    double samples = 0.0;
    lf_scene *scene = lf_test_scene(lf_test_scene_text("wall-behind-slab"));
    lf_renderer *r = render(scene, true, NULL, 1);
    float *whole = layers_of(r, wanted);
    lf_assert_ok(lf_renderer_restart(r, scene, lf_renderer_settings(r), NULL), NULL);
    float *none = layers_of(r, wanted);
    lf_assert_ok(lf_renderer_passes(r, &fourth, 4 * VIEWS, true, NULL, NULL, NULL), NULL);
    float *out = layers_of(r, wanted);
    for (int row = 0; row < SIDE; row++) {
        const int nearest = 2 + 4 * (row > 4) + 4 * (row > 8) + 4 * (row > 12);
        for (int i = 0; i < row_length; i += n) {
            const float *p = out + row * row_length + i, *q = out + nearest * row_length + i;
            for (int c = 0; c < n; c++)
                assert_true(none[row * row_length + i + c] == 0.0f);
            assert_true(p[0] == q[0] && p[0] > 3.0f);
            for (int c = 1; c < 4; c++)
                assert_true(p[c] == whole[row * row_length + i + c]);
            for (int c = 4; c < n && row != nearest; c++)
                assert_true(p[c] == 0.0f);
            samples += (double)p[n - 1];
        }
    }
    assert_true(samples > 0.0);
    free(none);
    free(whole);
    free(out);
    lf_renderer_destroy(r);
    lf_scene_unref(scene);
}

static void layers_have_a_name_a_bit_and_room(void **state)
{
    (void)state;
    const char *names[LF_MAX_LAYER_CHANNELS];
    int n = 0;
    for (; lf_layer_at(n); n++)
        assert_int_equal(lf_layer_at(n)->bit, 1u << n);
    assert_int_equal(n, 8);
    n = lf_layer_channels(255, names);
    assert_true(n <= LF_MAX_LAYER_CHANNELS);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < i; k++)
            assert_string_not_equal(names[i], names[k]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_know_how_far_and_what_they_see),
        cmocka_unit_test(mirrors_and_lamps_are_where_they_are),
        cmocka_unit_test(rims_of_mirrors_are_no_holes),
        cmocka_unit_test(where_nothing_is_met_everything_is_0),
        cmocka_unit_test(variance_is_what_pictures_are_apart),
        cmocka_unit_test(layers_do_not_depend_on_threads_and_need_what_they_are_made_of),
        cmocka_unit_test(rows_without_visits_are_as_far_as_the_nearest_one_with),
        cmocka_unit_test(layers_have_a_name_a_bit_and_room),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
