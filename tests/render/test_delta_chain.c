/* Chains of mirrors and smooth glass: both branches, what of them is known, and the light field of
 * what surfaces scatter behind them. */
#include "tests/render/reconstruct_testing.h"
#include "tests/scene_file.h"

#include "render/transport/path/delta_chain.h"

enum { width = 24, height = 32, n_views = 5, pixels = width * height * n_views };

/* Of the ball, and nothing but it. */
static bool is_inside(size_t i)
{
    const double x = (double)(i % width) - 0.5 * (width - 1),
                 y = (double)(i / (width * n_views)) - 0.5 * (height - 1);
    /* radius 0.5 of a window that is 1.47 high */
    return x * x + y * y < 8.0 * 8.0;
}

static lf_renderer *renderer_of(const char *text, const char *integrator, bool features)
{
    lf_scene *scene = lf_test_scene(text);
    lf_renderer *r = lf_test_renderer(scene, integrator, width, height, NULL);
    lf_render_settings settings = *lf_renderer_settings(r);
    settings.features = features;
    lf_assert_ok(lf_renderer_restart(r, scene, &settings, NULL), NULL);
    lf_scene_unref(scene);
    return r;
}

/* [row][view][column][3]; caller frees. */
static float *resolved(lf_renderer *r, lf_estimator estimator)
{
    float *x = malloc(3 * pixels * sizeof *x);
    assert_non_null(x);
    lf_assert_ok(lf_renderer_resolve(r, estimator, x, NULL), NULL);
    return x;
}

/* Glass that loses nothing is as bright as what is about it, in every sample but for the branches
 * that bring next to nothing. Reflections that chance picks leave 0.1 or more. */
static void both_branches_bring_all_there_is(void **state)
{
    (void)state;
    static const char *const integrators[] = {"vpt", "mvpt"};
    for (int i = 0; i < 2; i++) {
        lf_renderer *r =
            renderer_of(lf_test_scene_text("glass-ball-furnace"), integrators[i], false);
        lf_test_cycles(r, 2);
        float *x = resolved(r, LF_ESTIMATOR_MIS);
        double square = 0.0, sum = 0.0, n = 0.0;
        for (size_t k = 0; k < pixels; k++) {
            double d = (double)x[3 * k] - 1.0;
            sum += is_inside(k) ? d : 0.0;
            square += is_inside(k) ? d * d : 0.0;
            n += is_inside(k);
        }
        assert_true(n > 500.0);
        printf("%s: %+.1e, rms %.1e\n", integrators[i], sum / n, sqrt(square / n));
        assert_true(sqrt(square / n) < 0.02);
        assert_true(fabs(sum / n) < 5.0 * sqrt(square) / n + 1e-6); /* p 1e-6 */
        free(x);
        lf_renderer_destroy(r);
    }
}

/* Where a film has features, what surfaces scatter behind glass stands in N instead of M. No random
 * number is another for it. */
static void it_is_the_same_light_wherever_it_stands(void **state)
{
    (void)state;
    float *x[2];
    for (int i = 0; i < 2; i++) {
        lf_renderer *r = renderer_of(lf_test_scene_text("glass-ball-room"), "mvpt", i == 1);
        for (int k = 0; k < 6; k++)
            lf_assert_ok(lf_renderer_pass(r, NULL, 1, NULL, NULL, NULL), NULL);
        x[i] = resolved(r, LF_ESTIMATOR_MIS);
        lf_renderer_destroy(r);
    }
    double sum = 0.0;
    for (size_t k = 0; k < pixels; k++) {
        sum += (double)x[0][3 * k];
        lf_assert_close(x[1][3 * k], x[0][3 * k], 1e-4, 1e-5);
    }
    assert_true(sum / pixels > 0.05);
    free(x[0]);
    free(x[1]);
}

/* W is n q in each pixel whose first surface is smooth, to rounding, and there is some; the three
 * answers are one there. */
static void its_weights_are_known(void **state)
{
    (void)state;
    lf_renderer *r = renderer_of(lf_test_scene_text("glass-ball-room"), "mvpt", true);
    int n = 0;
    reconstruct_visits(r, NULL, 6);
    for (int row = 0; row < height; row++) {
        for (int h = 0; h < 2; h++) {
            const lf_film_half half = lf_film_at(&r->film, row, h);
            for (size_t i = 0; i < n_views * width; i++) {
                if (!is_inside((size_t)row * n_views * width + i))
                    continue;
                assert_true(half.q[i] > 0.1f && half.q[i] < 0.7f); /* albedo 0.6 */
                lf_assert_close(half.scattered[i].w, (float)r->film.rows[row].n[h] * half.q[i],
                                1e-4, 0.0);
                n++;
            }
        }
    }
    assert_true(n > 1000);
    lf_renderer_destroy(r);
}

/* A wall behind the cameras in a mirror before them: at the depth of its image, 3 + 3 + 2 in units
 * of which the window is 3 away. */
static void mirror_images_lie_behind_mirrors(void **state)
{
    (void)state;
    lf_renderer *r = renderer_of(lf_test_scene_text("wall-in-mirror"), "mvpt", true);
    reconstruct_visits(r, NULL, 2);
    for (int row = 0; row < height; row++) {
        const lf_film_half half = lf_film_at(&r->film, row, 0);
        for (size_t i = 0; i < n_views * width; i++) {
            const lf_feature f = lf_feature_unpack(half.feature[i]);
            lf_assert_close(f.nearness, 3.0 / 8.0, 2e-3, 0.0);
            assert_true(f.spread < 2e-3f && f.surface > 0.999f);
        }
    }
    /* which is no matter of the layer of depth: that is of what stands there */
    float *depth = malloc(pixels * sizeof *depth);
    assert_non_null(depth);
    lf_assert_ok(lf_renderer_layers(r, LF_ESTIMATOR_MWIS, LF_LAYER_DEPTH, depth, NULL), NULL);
    for (size_t i = 0; i < pixels; i++)
        lf_assert_close(depth[i], 3.0, 1e-3, 0.0);
    free(depth);
    lf_renderer_destroy(r);
}

/* What a path behind one branch averages of textures says nothing of the next one's. */
static void branches_see_textures_as_the_camera_does(void **state)
{
    (void)state;
    lf_scene *scene = lf_test_scene(lf_test_scene_text("glass-ball-room"));
    lf_tracer tracer = {.scene = scene, .rng = lf_test_seed(), .spread = 1e-3f};
    lf_delta_chain chain = {
        .tracer = &tracer, .max_depth = 16, .apart = true, .distance = 6, .z = 6, .forward = 1};
    lf_event event = {.kind = LF_EVENT_SURFACE, .w = lf_v3(0.0f, 0.0f, -1.0f)};
    lf_shading shading;
    assert_true(lf_trace_seen(&tracer, lf_v3(0.1f, 0.1f, 6.0f), event.w, INFINITY, &event.hit));
    event.p = event.hit.p;
    lf_shade(&event.hit, lf_scale(event.w, -1.0f), &shading);
    assert_int_equal(shading.n_deltas, 2);
    for (int i = 0; i < 2; i++) {
        lf_delta_chain_follow(&chain, &event, &shading.delta[i], 1.0f);
        assert_true(tracer.spread == 1e-3f);
    }
    assert_true(chain.weight > 0.3f && lf_max3(chain.scattered) > 0.0f);
    lf_scene_unref(scene);
}

/* relMSE inside the ball, from two references whose noise is not in it. */
static double error_inside(const float *x, float *const truth[2])
{
    double sum = 0.0, n = 0.0;
    for (size_t k = 0; k < pixels; k++) {
        double a = (double)truth[0][3 * k], b = (double)truth[1][3 * k], y = (double)x[3 * k];
        sum += is_inside(k) ? (y - a) * (y - b) / (0.25 * (a + b) * (a + b) + 0.01) : 0.0;
        n += is_inside(k);
    }
    return sum / n;
}

/* The shown picture of glass is many times nearer to the truth than the unfiltered one from the
 * same paths. */
static void glass_is_fitted_as_surfaces_are(void **state)
{
    (void)state;
    lf_renderer *r = renderer_of(lf_test_scene_text("glass-ball-room"), "mvpt", true);
    reconstruct_visits(r, NULL, 20);
    float *raw = resolved(r, LF_ESTIMATOR_MWIS), *shown = malloc(3 * pixels * sizeof *shown);
    assert_non_null(shown);
    lf_assert_ok(lf_renderer_show(r, shown, NULL), NULL);
    float *truth[2];
    for (int i = 0; i < 2; i++) {
        lf_test_reseed(r, lf_test_seed() + 1 + (uint64_t)i);
        lf_test_cycles(r, 30);
        truth[i] = resolved(r, LF_ESTIMATOR_MWIS);
    }
    double before = error_inside(raw, truth), after = error_inside(shown, truth);
    printf("inside the ball: %.2e unfiltered, %.2e shown\n", before, after);
    assert_true(after < before / 4.0);
    free(raw);
    free(shown);
    free(truth[0]);
    free(truth[1]);
    lf_renderer_destroy(r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(both_branches_bring_all_there_is),
        cmocka_unit_test(it_is_the_same_light_wherever_it_stands),
        cmocka_unit_test(its_weights_are_known),
        cmocka_unit_test(mirror_images_lie_behind_mirrors),
        cmocka_unit_test(branches_see_textures_as_the_camera_does),
        cmocka_unit_test(glass_is_fitted_as_surfaces_are),
    };
    return cmocka_run_group_tests(tests, NULL, lf_test_finish);
}
