/* One rendering from start to end: budgets that end, progress that rises, and the film of a single
 * lf_renderer_passes. */
#include "tests/testing.h"

#include "base/alloc.h"
#include "daemon/output/render_job.h"

#define VIEWS 4
#define WIDTH 6
#define HEIGHT 8
#define FLOATS (VIEWS * WIDTH * HEIGHT * 3)

static const char fog[] =
    "{\"quiltd\": 1, \"camera\": {\"position\": [0,0.5,6], \"fov_y\": 26, \"aspect\": 0.75, "
    "\"cone\": 35},"
    " \"volumes\": {\"fog\": {\"shape\": \"sphere\", \"density\": 3, \"albedo\": 0.9}},"
    " \"lights\": {\"sky\": {\"type\": \"environment\", \"radiance\": 0.5}}}";

typedef struct fixture {
    lf_scene *scene;
    lf_pool *pool;
    lf_renderer *renderer;
    lf_render_settings settings;
    float film[FLOATS];
} fixture;

static int set_up(void **state)
{
    static fixture f;
    lf_error err = {0};
    json_t *doc = json_loads(fog, 0, NULL);
    f = (fixture){0};
    assert_non_null(doc);
    lf_assert_ok(lf_scene_from_json(doc, ".", "fog", NULL, NULL, &f.scene, &err), &err);
    json_decref(doc);
    f.settings = (lf_render_settings){
        .camera = *lf_scene_camera(f.scene), .width = WIDTH, .height = HEIGHT, .seed = 3};
    f.settings.camera.n_views = VIEWS;
    lf_assert_ok(lf_pool_create(2, &f.pool), NULL);
    lf_assert_ok(lf_renderer_create(f.scene, &f.settings, f.pool, &f.renderer, &err), &err);
    *state = &f;
    return 0;
}

static int tear_down(void **state)
{
    fixture *f = *state;
    lf_renderer_destroy(f->renderer);
    lf_pool_destroy(f->pool);
    lf_scene_unref(f->scene);
    return 0;
}

static void restart(fixture *f)
{
    lf_error err = {0};
    lf_assert_ok(lf_renderer_restart(f->renderer, f->scene, &f->settings, &err), &err);
}

static void a_job_gives_the_film_of_so_many_passes(void **state)
{
    static const int64_t passes[] = {
        1, 2, 3, VIEWS, 2 * VIEWS, 2 * VIEWS + 1, 3 * VIEWS, 5 * VIEWS - 1, 6 * VIEWS};
    fixture *f = *state;
    float expected[FLOATS];
    for (size_t i = 0; i < sizeof passes / sizeof passes[0]; i++) {
        for (int cv = 0; cv < 2; cv++) {
            lf_estimator estimator = cv ? LF_ESTIMATOR_CV : LF_ESTIMATOR_MIS;
            const lf_budget budget = {.passes = passes[i]};
            lf_render_times times;
            restart(f);
            lf_assert_ok(lf_renderer_passes(f->renderer, NULL, passes[i], cv && passes[i] == 1,
                                            NULL, NULL, NULL),
                         NULL);
            lf_assert_ok(lf_renderer_resolve(f->renderer, estimator, expected, NULL), NULL);
            restart(f);
            lf_assert_ok(
                lf_render_run(f->renderer, &budget, estimator, f->film, NULL, NULL, NULL, &times),
                NULL);
            assert_memory_equal(f->film, expected, sizeof expected);
            assert_int_equal(times.passes, passes[i]);
            /* negative control: one pass more is another picture */
            lf_assert_ok(lf_renderer_passes(f->renderer, NULL, 1, false, NULL, NULL, NULL), NULL);
            lf_assert_ok(lf_renderer_resolve(f->renderer, estimator, f->film, NULL), NULL);
            assert_memory_not_equal(f->film, expected, sizeof expected);
        }
    }
}

/* A film that keeps features answers as it is asked to. */
static void the_reconstructed_picture_is_given_to_who_asks_for_it(void **state)
{
    fixture *f = *state;
    float expected[2][FLOATS];
    f->settings.features = true;
    restart(f);
    lf_assert_ok(lf_renderer_passes(f->renderer, NULL, 4, false, NULL, NULL, NULL), NULL);
    lf_assert_ok(lf_renderer_show(f->renderer, expected[1], NULL), NULL);
    lf_assert_ok(lf_renderer_fill_holes(f->renderer, NULL, NULL), NULL);
    lf_assert_ok(lf_renderer_resolve(f->renderer, LF_ESTIMATOR_MWIS, expected[0], NULL), NULL);
    assert_memory_not_equal(expected[0], expected[1], sizeof expected[0]);
    for (int on = 0; on < 2; on++) {
        const lf_budget budget = {.passes = 4, .reconstructed = on};
        lf_render_times times;
        restart(f);
        lf_assert_ok(lf_render_run(f->renderer, &budget, LF_ESTIMATOR_MWIS, f->film, NULL, NULL,
                                   NULL, &times),
                     NULL);
        assert_memory_equal(f->film, expected[on], sizeof expected[on]);
    }
}

static void note(void *context, const lf_render_progress *progress)
{
    lf_render_progress *last = context;
    assert_true(progress->fraction >= last->fraction && progress->fraction <= 1);
    assert_true(progress->passes >= last->passes);
    assert_true(progress->seconds >= last->seconds);
    assert_int_equal(progress->n_views, VIEWS);
    *last = *progress;
}

static void progress_rises_to_the_end(void **state)
{
    fixture *f = *state;
    const lf_budget budgets[] = {
        {.passes = 4 * VIEWS + 3}, {.seconds = 0.05}, {.cpu_seconds = 0.05}};
    for (size_t i = 0; i < sizeof budgets / sizeof budgets[0]; i++) {
        lf_render_progress last = {0};
        lf_render_times times;
        restart(f);
        lf_assert_ok(lf_render_run(f->renderer, &budgets[i], LF_ESTIMATOR_MWIS, f->film, note,
                                   &last, NULL, &times),
                     NULL);
        assert_true(times.passes >= 2);
        lf_assert_close(last.passes, (double)times.passes, 0, 1e-9);
        if (budgets[i].passes > 0)
            lf_assert_close(last.fraction, 1, 0, 0);
    }
}

static void a_target_is_met_by_the_estimate(void **state)
{
    fixture *f = *state;
    const lf_budget budget = {.target_error = 0.01};
    lf_render_stats stats;
    lf_render_times times;
    lf_assert_ok(
        lf_render_run(f->renderer, &budget, LF_ESTIMATOR_MIS, f->film, NULL, NULL, NULL, &times),
        NULL);
    lf_renderer_stats(f->renderer, &stats);
    assert_true(stats.rel_mse_estimate > 0 && stats.rel_mse_estimate <= 0.01);
    assert_true(times.passes > 2 * VIEWS); /* it was not met at once */
}

static void a_cancelled_job_says_so(void **state)
{
    fixture *f = *state;
    const lf_budget budgets[] = {{.passes = 100}, {.seconds = 100}, {.target_error = 1e-9}};
    lf_cancel cancel = 1;
    lf_render_times times;
    for (size_t i = 0; i < sizeof budgets / sizeof budgets[0]; i++) {
        restart(f);
        assert_int_equal(lf_render_run(f->renderer, &budgets[i], LF_ESTIMATOR_MIS, f->film, NULL,
                                       NULL, &cancel, &times),
                         LF_E_CANCELLED);
        assert_int_equal(times.passes, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_job_gives_the_film_of_so_many_passes, set_up, tear_down),
        cmocka_unit_test_setup_teardown(the_reconstructed_picture_is_given_to_who_asks_for_it,
                                        set_up, tear_down),
        cmocka_unit_test_setup_teardown(progress_rises_to_the_end, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_target_is_met_by_the_estimate, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_cancelled_job_says_so, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
