/* The daemon with --state, from outside: what it goes on from after another start, and after other
 * pictures. */
#include "tests/daemon/live.h"
#include "tests/scene_file.h"

#include <dirent.h>

static char a_state[NAME_MAX + 1];

/* The states there are; a_state is the name of one. */
static int count_states(const live *l)
{
    DIR *dir = opendir(l->state);
    int n = 0;
    assert_non_null(dir);
    for (const struct dirent *entry; (entry = readdir(dir));)
        if (strstr(entry->d_name, ".lfstate")) {
            n++;
            snprintf(a_state, sizeof a_state, "%s", entry->d_name);
        }
    closedir(dir);
    return n;
}

/* The picture is shown as it was saved, before anything is added to it. */
static void a_saved_picture_is_shown_at_once(void **state)
{
    (void)state;
    live l;
    live_client c;
    char words[64];
    live_prepare(&l);
    live_start(&l, l.scene, "--device", "none", "--state", l.state, NULL);
    live_connect(&l, &c);
    live_wait(&c, "complete");
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:b}", "paused", 1)), 0);
    while (strcmp(live_status_text(&c, "state"), "paused") != 0)
        live_nap(10);
    snprintf(words, sizeof words, "complete after %.1f passes",
             live_number(&c, "status", NULL, "passes"));
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    setenv("QUILTD_DEBUG", "1", 1);
    live_start(&l, l.scene, "--device", "none", "--state", l.state, NULL);
    unsetenv("QUILTD_DEBUG");
    live_connect(&l, &c);
    live_wait(&c, "complete");
    assert_true(live_logged(&l, words));
    live_close(&c);
    live_finish(&l);
}

static void a_state_belongs_to_one_daemon(void **state)
{
    (void)state;
    live l;
    live_client c;
    char other[PATH_MAX];
    live_prepare(&l);
    live_start(&l, l.scene, "--device", "none", "--state", l.state, NULL);
    live_connect(&l, &c);
    snprintf(other, sizeof other, "%s/other", l.folder);
    char *const words[] = {(char *)(uintptr_t)lf_test_built("quiltd"),
                           l.scene,
                           (char *)(uintptr_t) "--device",
                           (char *)(uintptr_t) "none",
                           (char *)(uintptr_t) "--socket",
                           other,
                           (char *)(uintptr_t) "--state",
                           l.state,
                           NULL};
    assert_int_equal(live_reap(live_spawn(&l, words)), 1);
    assert_true(live_logged(&l, "another running quiltd uses"));
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    /* it is free when that has ended, however that was */
    live_start(&l, l.scene, "--device", "none", "--state", l.state, NULL);
    live_connect(&l, &c);
    live_close(&c);
    live_finish(&l);
}

static void a_killed_daemon_goes_on_from_its_state(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, "--state", l.state, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "complete");
    double passes = live_number(&c, "status", NULL, "passes");
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    assert_int_equal(count_states(&l), 1);
    live_start(&l, l.scene, "--device", l.sim, "--state", l.state, NULL);
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    assert_true(live_logged(&l, "continuing from the saved state"));
    assert_true(live_number(&c, "status", NULL, "passes") >= passes);
    live_close(&c);
    kill(l.pid, SIGKILL);
    live_reap(l.pid);
    /* A state of something else, or of nothing, is left aside. */
    assert_int_equal(count_states(&l), 1);
    lf_test_write(l.state, a_state, "no state at all");
    live_start(&l, l.scene, "--device", l.sim, "--state", l.state, NULL);
    live_connect(&l, &c);
    live_wait(&c, "complete");
    assert_true(live_logged(&l, "the saved state is not used"));
    live_close(&c);
    live_finish(&l);
}

/* A batch of it takes longer than what is not saved is waited for; sanitizers make it slower. */
#if defined(__SANITIZE_THREAD__)
#define BATCH_SIZE "300x400"
#elif defined(__SANITIZE_ADDRESS__)
#define BATCH_SIZE "450x600"
#else
#define BATCH_SIZE "900x1200"
#endif

static void the_batch_in_progress_ends_before_its_state_is_saved(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    static const char *const more[] = {"--view-size", BATCH_SIZE, "--threads", "1"};
    live_start(&l, l.scene, "--device", "none", "--state", l.state, more[0], more[1], more[2],
               more[3], NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    double passes = live_number(&c, "status", NULL, "passes");
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    assert_int_equal(count_states(&l), 1);
    assert_false(live_logged(&l, "not saved"));
    live_start(&l, l.scene, "--device", "none", "--state", l.state, more[0], more[1], more[2],
               more[3], NULL);
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    assert_true(live_logged(&l, "continuing from the saved state"));
    assert_true(live_number(&c, "status", NULL, "passes") >= passes);
    live_close(&c);
    live_finish(&l);
}

/* A start with these options (each may be NULL) until the picture has converged; its passes. */
static double converged(live *l, const char *option, const char *value)
{
    live_client c;
    live_start(l, l->scene, "--device", "none", "--state", l->state, "--target-error", "0.04",
               option, value, NULL);
    live_connect(l, &c);
    live_wait(&c, "converged");
    double passes = live_number(&c, "status", NULL, "passes");
    live_close(&c);
    assert_int_equal(live_stop(l), 0);
    return passes;
}

static void a_converged_picture_survives_starts_with_other_options(void **state)
{
    static const char *const others[][2] = {
        {"--view-size", "30x40"}, {"--seed", "7"}, {"--views", "7"}, {"--max-depth", "3"}};
    static const char *const words[] = {"differs in the view size (24x32, now 30x40)",
                                        "the seed (0, now 7)", "the number of views (6, now 7)",
                                        "differs in the render settings"};
    (void)state;
    live l;
    live_prepare(&l);
    double passes = converged(&l, NULL, NULL);
    assert_false(live_logged(&l, "starts from the beginning"));
    for (int i = 0; i < 4; i++) {
        assert_false(live_logged(&l, words[i]));
        (void)converged(&l, others[i][0], others[i][1]);
        assert_true(live_logged(&l, words[i]));
        assert_int_equal(count_states(&l), 2 + i);
        assert_false(live_logged(&l, "continuing from the saved state"));
        assert_true(converged(&l, NULL, NULL) == passes);
        assert_true(live_logged(&l, "continuing from the saved state"));
        assert_int_equal(truncate(l.log, 0), 0);
    }
    live_finish(&l);
}

static void a_scene_that_comes_back_goes_on_from_its_state(void **state)
{
    (void)state;
    live l;
    live_client c;
    live_prepare(&l);
    double passes = converged(&l, NULL, NULL);
    lf_test_write(l.folder, "scene/next.json", lf_test_scene_text("matt-wall"));
    live_start(&l, lf_test_path(l.folder, "scene/next.json"), "--device", "none", "--state",
               l.state, "--target-error", "0.04", NULL);
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    assert_true(live_logged(&l, "differs in the scene, the camera"));
    assert_int_equal(live_code(&c, "scene.load", json_pack("{s:s}", "file", l.scene)), 0);
    live_wait(&c, "converged");
    assert_true(live_number(&c, "status", NULL, "passes") == passes);
    /* and so does a camera */
    assert_int_equal(live_code(&c, "camera.set", json_pack("{s:f}", "fov_y", 20.0)), 0);
    assert_int_equal(live_code(&c, "camera.set", json_pack("{s:f}", "fov_y", 14.0)), 0);
    live_wait(&c, "converged");
    assert_true(live_number(&c, "status", NULL, "passes") == passes);
    live_close(&c);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_saved_picture_is_shown_at_once),
        cmocka_unit_test(a_state_belongs_to_one_daemon),
        cmocka_unit_test(a_killed_daemon_goes_on_from_its_state),
        cmocka_unit_test(the_batch_in_progress_ends_before_its_state_is_saved),
        cmocka_unit_test(a_converged_picture_survives_starts_with_other_options),
        cmocka_unit_test(a_scene_that_comes_back_goes_on_from_its_state),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
