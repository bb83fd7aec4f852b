/* One rendering from start to end: budgets that end, progress that rises, and the film of a single
 * lf_renderer_passes. */
#include "tests/testing.h"

#include <fcntl.h>

#include "base/alloc.h"
#include "daemon/output/render_job.h"
#include "render/film/film.h"
#include "render/papers/papers.h"
#include "tests/scene_file.h"

#define VIEWS 4
#define WIDTH 6
#define HEIGHT 8
#define FLOATS (VIEWS * WIDTH * HEIGHT * 3)

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
    json_t *doc =
        lf_test_json("fog-ball", lf_test_scene_patched("fog-ball", "{'camera': {'views': null}}"));
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

static void count_visit(void *context, int passes, int worker)
{
    (void)passes;
    (void)worker;
    atomic_fetch_add((atomic_int *)context, 1);
}

/* Plans count the visits of a job; its rows make them. */
static void visits_are_those_that_rows_have(void **state)
{
    static const int64_t passes[] = {1, 2, 5, VIEWS, 2 * VIEWS, 4 * VIEWS + 3, 40 * VIEWS};
    fixture *f = *state;
    for (int features = 0; features < 2; features++)
        for (size_t i = 0; i < sizeof passes / sizeof passes[0]; i++) {
            atomic_int n = 0;
            f->settings.features = features;
            restart(f);
            for (int64_t left = passes[i]; left > 0; left -= 2 * VIEWS)
                lf_assert_ok(lf_renderer_passes(f->renderer, NULL,
                                                left < 2 * VIEWS ? left : 2 * VIEWS, false,
                                                count_visit, &n, NULL),
                             NULL);
            assert_int_equal(lf_renderer_visits(f->renderer, passes[i]) * HEIGHT, n);
        }
}

/* The sizes of visits do not depend on how passes per view are rounded: 12 passes of 48 views are
 * not 11.99, of which a quarter would be two. Jobs that continue count whole passes. */
static void visits_of_any_number_of_views_grow_alike(void **state)
{
    fixture *f = *state;
    f->settings.features = true;
    for (int views = 3; views <= 64; views++) {
        atomic_int n = 0;
        f->settings.camera.n_views = views;
        restart(f);
        lf_assert_ok(lf_renderer_passes(f->renderer, NULL, 2 * views, false, count_visit, &n, NULL),
                     NULL);
        assert_int_equal(lf_renderer_visits(f->renderer, 2 * views) * HEIGHT, n);
    }
    f->settings.camera.n_views = VIEWS;
    f->settings.features = false;
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

/* ---------------------------------------------------------------------------------- going on -- */

/* Cancels once it was called so many times. */
typedef struct stopper {
    lf_cancel cancel;
    int left;
    double passes;
} stopper;

static void stop(void *context, const lf_render_progress *progress)
{
    stopper *s = context;
    assert_true(progress->passes >= s->passes);
    s->passes = progress->passes;
    if (--s->left < 0)
        atomic_store(&s->cancel, 1);
}

/* The renderer anew, with the film that it had, as another process would have it. */
static void take_up(fixture *f)
{
    char path[PATH_MAX], *folder = lf_test_folder();
    lf_error err = {0};
    lf_outfile file;
    snprintf(path, sizeof path, "%s/state", folder);
    lf_assert_ok(lf_outfile_open(&file, path, true, &err), &err);
    lf_assert_ok(lf_renderer_save(f->renderer, &file, NULL, &err), &err);
    lf_assert_ok(lf_outfile_commit(&file, true, &err), &err);
    lf_renderer *old = f->renderer;
    lf_assert_ok(lf_renderer_create(f->scene, &f->settings, f->pool, &f->renderer, &err), &err);
    lf_renderer_destroy(old);
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    assert_true(fd >= 0);
    lf_assert_ok(lf_renderer_restore(f->renderer, fd, &err), &err);
    close(fd);
    lf_test_folder_remove(folder);
}

/* Stopped again and again, each time after so many more rows, by one thread, which hears of each.
 * Returns how often. */
static int run_in_pieces(fixture *f, const lf_budget *budget, lf_estimator estimator, int rows)
{
    lf_render_times times = {0};
    lf_pool *const pool = f->pool;
    int n = 0;
    restart(f);
    lf_assert_ok(lf_pool_create(1, &f->pool), NULL);
    take_up(f);
    for (bool first = true;; first = false, n++) {
        stopper s = {.left = rows * (n + 1)};
        lf_status status = lf_render_gather(f->renderer, budget, estimator, first ? NULL : &times,
                                            f->film, stop, &s, &s.cancel, &times);
        if (status != LF_E_CANCELLED) {
            lf_assert_ok(status, NULL);
            break;
        }
        take_up(f);
    }
    assert_int_equal(times.passes, budget->passes);
    lf_assert_ok(lf_render_fill(f->renderer, budget, estimator, NULL, &times), NULL);
    lf_assert_ok(lf_render_answer(f->renderer, budget, estimator, f->film, NULL, &times), NULL);
    lf_pool *const one = f->pool;
    f->pool = pool;
    take_up(f);
    lf_pool_destroy(one);
    return n;
}

static void a_job_in_pieces_gives_the_bits_of_one_at_once(void **state)
{
    static const struct {
        const char *integrator;
        lf_estimator estimator;
        bool reconstructed;
        int64_t passes;
    } cases[] = {
        {"mvpt", LF_ESTIMATOR_MWIS, false, 5 * VIEWS + 3}, {"mvpt", LF_ESTIMATOR_CV, false, 1},
        {"mvpt", LF_ESTIMATOR_MWIS, true, 6 * VIEWS},      {"vpt", LF_ESTIMATOR_MIS, false, 9},
        {"mvpt2022", LF_ESTIMATOR_MIS, false, 7},          {"mismvpt", LF_ESTIMATOR_MIS, false, 7},
    };
    fixture *f = *state;
    float expected[FLOATS];
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const lf_budget budget = {.passes = cases[i].passes,
                                  .reconstructed = cases[i].reconstructed};
        lf_render_times times;
        f->settings.integrator = cases[i].integrator;
        f->settings.features = cases[i].reconstructed;
        restart(f);
        lf_assert_ok(lf_render_run(f->renderer, &budget, cases[i].estimator, expected, NULL, NULL,
                                   NULL, &times),
                     NULL);
        for (int rows = 1; rows < HEIGHT; rows += 3) {
            assert_true(run_in_pieces(f, &budget, cases[i].estimator, rows) > 0);
            assert_memory_equal(f->film, expected, sizeof expected);
        }
    }
}

/* Cancels once so many rows were merged. */
static stopper *on_merge;

void __real_lf_film_merge(lf_film *film, int stream, int row, int half, const lf_film_sums *sums,
                          double passes, uint64_t key);
void __wrap_lf_film_merge(lf_film *film, int stream, int row, int half, const lf_film_sums *sums,
                          double passes, uint64_t key);
void __wrap_lf_film_merge(lf_film *film, int stream, int row, int half, const lf_film_sums *sums,
                          double passes, uint64_t key)
{
    __real_lf_film_merge(film, stream, row, half, sums, passes, key);
    if (on_merge && --on_merge->left <= 0)
        atomic_store(&on_merge->cancel, 1);
}

/* Cameras listed one by one, of the rig's kind. */
static void list_cameras(fixture *f)
{
    static lf_view_camera list[VIEWS];
    lf_camera *camera = &f->settings.camera;
    for (int i = 0; i < VIEWS; i++) {
        memcpy(list[i].position, camera->position, sizeof list[i].position);
        memcpy(list[i].target, camera->target, sizeof list[i].target);
        memcpy(list[i].up, camera->up, sizeof list[i].up);
        list[i].position[0] += 0.3 * i;
        list[i].fov_y = camera->fov_y;
    }
    camera->list = list;
}

/* Stopped while a pass moves into the film, and while it is on its way. */
static void listed_cameras_go_on_from_any_row(void **state)
{
    fixture *f = *state;
    float expected[FLOATS];
    const lf_budget budget = {.passes = 3 * VIEWS + 1};
    lf_render_times times;
    list_cameras(f);
    for (int alone = 0; alone < 2; alone++) {
        f->settings.integrator = alone ? "vpt" : "mvpt";
        restart(f);
        assert_true(lf_renderer_spreads(f->renderer));
        lf_assert_ok(lf_render_run(f->renderer, &budget, LF_ESTIMATOR_MIS, expected, NULL, NULL,
                                   NULL, &times),
                     NULL);
        for (int rows = 1; rows <= HEIGHT + 2; rows++) {
            int n = 0, n_before = 0;
            lf_status status = LF_E_CANCELLED;
            restart(f);
            for (times = (lf_render_times){0}; status == LF_E_CANCELLED; n++) {
                stopper s = {.left = rows};
                on_merge = &s;
                status =
                    lf_render_gather(f->renderer, &budget, LF_ESTIMATOR_MIS, n > 0 ? &times : NULL,
                                     f->film, NULL, NULL, &s.cancel, &times);
                on_merge = NULL;
                assert_true(times.passes >= n_before && times.passes <= budget.passes);
                n_before = (int)times.passes;
                take_up(f);
            }
            assert_int_equal(status, LF_OK);
            assert_true(n > 1);
            lf_assert_ok(lf_renderer_resolve(f->renderer, LF_ESTIMATOR_MIS, f->film, NULL), NULL);
            assert_memory_equal(f->film, expected, sizeof expected);
        }
    }
}

/* A band of rows in pieces has the bits of its rows in the whole film; rows outside have none. */
static void a_part_in_pieces_gives_its_rows_of_the_whole(void **state)
{
    fixture *f = *state;
    float expected[FLOATS];
    const lf_budget budget = {.passes = 5 * VIEWS + 3};
    const lf_part part = {.first_row = 2, .end_row = 5};
    const lf_budget of_part = {.passes = budget.passes, .part = &part};
    const size_t row_floats = FLOATS / HEIGHT;
    lf_render_times times = {0};
    lf_assert_ok(
        lf_render_run(f->renderer, &budget, LF_ESTIMATOR_MIS, expected, NULL, NULL, NULL, &times),
        NULL);
    restart(f);
    lf_status status = LF_E_CANCELLED;
    int n = 0;
    for (; status == LF_E_CANCELLED; n++) {
        stopper s = {.left = 2 * (n + 1)};
        status = lf_render_gather(f->renderer, &of_part, LF_ESTIMATOR_MIS, n > 0 ? &times : NULL,
                                  f->film, stop, &s, &s.cancel, &times);
        take_up(f);
    }
    lf_assert_ok(status, NULL);
    assert_true(n > 1);
    assert_int_equal(times.passes, budget.passes);
    lf_assert_ok(lf_renderer_resolve(f->renderer, LF_ESTIMATOR_MIS, f->film, NULL), NULL);
    assert_memory_equal(f->film + 2 * row_floats, expected + 2 * row_floats,
                        3 * row_floats * sizeof *expected);
    for (int row = 0; row < HEIGHT; row++)
        assert_int_equal(lf_renderer_visited(f->renderer, row), row >= 2 && row < 5);
    /* negative controls: it is not another part, nor are there rows that do not exist */
    const lf_part others[] = {{0},
                              {.first_row = 2, .end_row = 6},
                              {.first_row = 3, .end_row = 5},
                              {.first_row = 2, .end_row = 5, .stream = 1}};
    lf_asked at = {0};
    lf_assert_ok(
        lf_renderer_passes_after(f->renderer, &part, &at, budget.passes, false, NULL, NULL, NULL),
        NULL);
    assert_true(lf_renderer_is_at(f->renderer, &part, &at));
    for (int i = 0; i < 4; i++)
        assert_false(lf_renderer_is_at(f->renderer, &others[i], &at));
    /* nor does it hold what another stream has added */
    lf_assert_ok(lf_renderer_passes(f->renderer, &others[3], 4, false, NULL, NULL, NULL), NULL);
    assert_false(lf_renderer_is_at(f->renderer, &part, &at));
    const lf_part outside = {.first_row = 0, .end_row = HEIGHT + 1};
    assert_int_equal(
        lf_renderer_passes_after(f->renderer, &outside, &at, 4, false, NULL, NULL, NULL), LF_E_ARG);
}

/* And with another budget, where it has passed through the films of the first. */
static void a_larger_budget_goes_on_where_a_smaller_one_ended(void **state)
{
    fixture *f = *state;
    float expected[FLOATS];
    const lf_budget all = {.passes = 6 * VIEWS};
    lf_render_times times;
    lf_assert_ok(
        lf_render_run(f->renderer, &all, LF_ESTIMATOR_MWIS, expected, NULL, NULL, NULL, &times),
        NULL);
    for (int64_t passes = 1; passes <= 7 * VIEWS; passes++) {
        const lf_budget some = {.passes = passes};
        const bool on_the_way = passes % (2 * (int64_t)VIEWS) == 0 && passes <= all.passes;
        restart(f);
        lf_assert_ok(lf_render_gather(f->renderer, &some, LF_ESTIMATOR_MWIS, NULL, f->film, NULL,
                                      NULL, NULL, &times),
                     NULL);
        lf_status status = lf_render_gather(f->renderer, &all, LF_ESTIMATOR_MWIS, &times, f->film,
                                            NULL, NULL, NULL, &times);
        assert_true(!on_the_way || status == LF_OK);
        if (status != LF_OK) {
            assert_int_equal(status, LF_E_STATE);
            continue;
        }
        lf_assert_ok(lf_render_fill(f->renderer, &all, LF_ESTIMATOR_MWIS, NULL, &times), NULL);
        lf_assert_ok(lf_render_answer(f->renderer, &all, LF_ESTIMATOR_MWIS, f->film, NULL, &times),
                     NULL);
        assert_memory_equal(f->film, expected, sizeof expected);
    }
}

static void a_time_that_was_spent_is_spent(void **state)
{
    fixture *f = *state;
    const lf_budget budget = {.seconds = 100};
    const lf_render_times before = {.passes = 8, .seconds = 99, .cpu_seconds = 99};
    lf_render_times times;
    lf_assert_ok(lf_renderer_passes(f->renderer, NULL, 8, false, NULL, NULL, NULL), NULL);
    lf_assert_ok(lf_render_gather(f->renderer, &budget, LF_ESTIMATOR_MIS, &before, f->film, NULL,
                                  NULL, NULL, &times),
                 NULL);
    assert_int_equal(times.passes, 8);
    assert_true(times.seconds >= 99);
}

static void integrators_that_remember_more_than_their_film_do_not_go_on(void **state)
{
    fixture *f = *state;
    const lf_budget budget = {.passes = 4};
    const lf_render_times before = {.passes = 2};
    lf_render_times times;
    f->settings.integrator = "amvpt";
    restart(f);
    assert_false(lf_renderer_is_its_film(f->renderer));
    assert_int_equal(lf_render_gather(f->renderer, &budget, LF_ESTIMATOR_MIS, &before, f->film,
                                      NULL, NULL, NULL, &times),
                     LF_E_STATE);
}

int main(void)
{
    lf_papers_add();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_job_gives_the_film_of_so_many_passes, set_up, tear_down),
        cmocka_unit_test_setup_teardown(visits_are_those_that_rows_have, set_up, tear_down),
        cmocka_unit_test_setup_teardown(visits_of_any_number_of_views_grow_alike, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(the_reconstructed_picture_is_given_to_who_asks_for_it,
                                        set_up, tear_down),
        cmocka_unit_test_setup_teardown(progress_rises_to_the_end, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_target_is_met_by_the_estimate, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_cancelled_job_says_so, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_job_in_pieces_gives_the_bits_of_one_at_once, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(listed_cameras_go_on_from_any_row, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_part_in_pieces_gives_its_rows_of_the_whole, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(a_larger_budget_goes_on_where_a_smaller_one_ended, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(a_time_that_was_spent_is_spent, set_up, tear_down),
        cmocka_unit_test_setup_teardown(integrators_that_remember_more_than_their_film_do_not_go_on,
                                        set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
