/* Exports that wait, and the clients that asked for them: who leaves, who stays, how many. */
#include "tests/daemon/live.h"

/* A paused picture, which is never converged: what waits for that waits for ever. */
static void begin(live *l, live_client *watcher)
{
    live_prepare(l);
    live_start(l, l->scene, "--device", l->sim, "--target-error", "1e-12", NULL);
    live_connect(l, watcher);
    live_wait(watcher, "coarse");
    assert_int_equal(live_code(watcher, "render.set", json_pack("{s:b}", "paused", 1)), 0);
}

static void end(live *l, live_client *watcher)
{
    live_close(watcher);
    live_finish(l);
}

/* Whatever waits may start. */
static void let_go(live_client *watcher)
{
    assert_int_equal(live_code(watcher, "render.set",
                               json_pack("{s:b, s:f}", "paused", 0, "target_error", 10.0)),
                     0);
}

static json_t *waiting_export(const char *file, bool detach)
{
    json_t *params =
        json_pack("{s:s, s:s, s:s}", "kind", "panel", "file", file, "wait", "converged");
    if (detach)
        json_object_set_new(params, "detach", json_true());
    return params;
}

static json_int_t ask(live_client *c, const char *file, bool detach)
{
    return (json_int_t)live_number(c, "export", waiting_export(file, detach), "job");
}

static size_t count_jobs(live_client *watcher)
{
    json_t *answer = live_call(watcher, "status", NULL);
    size_t n = json_array_size(json_object_get(json_object_get(answer, "result"), "jobs"));
    json_decref(answer);
    return n;
}

static void wait_for_jobs(live_client *watcher, size_t n)
{
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++, live_nap(20))
        if (count_jobs(watcher) == n)
            return;
    fail_msg("%zu jobs, not %zu", count_jobs(watcher), n);
}

/* How many clients there are says that one has gone; its jobs went with it. */
static void wait_for_clients(live_client *watcher, int n)
{
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++, live_nap(20))
        if ((int)live_number(watcher, "status", NULL, "clients") == n)
            return;
    fail_msg("there are not %d clients", n);
}

static void assert_busy(live_client *c, const char *file, bool detach, const char *why)
{
    json_t *answer = live_call(c, "export", waiting_export(file, detach));
    const json_t *error = json_object_get(answer, "error");
    assert_int_equal(json_integer_value(json_object_get(error, "code")), -32000);
    const char *message = json_string_value(json_object_get(error, "message"));
    if (!strstr(message, why))
        fail_msg("\"%s\" does not say \"%s\"", message, why);
    json_decref(answer);
}

static void exports_that_wait_end_with_their_client(void **state)
{
    (void)state;
    live l;
    live_client watcher, gone, stays;
    begin(&l, &watcher);
    live_connect(&l, &gone);
    live_connect(&l, &stays);
    (void)ask(&gone, "g1.png", false);
    (void)ask(&gone, "g2.png", false);
    json_int_t kept = ask(&stays, "s.png", false);
    assert_int_equal(count_jobs(&watcher), 3);
    live_close(&gone);
    wait_for_jobs(&watcher, 1);
    let_go(&watcher);
    assert_string_equal(live_job_end(&stays, kept), "done");
    assert_int_equal(access(lf_test_path(l.exports, "s.png"), F_OK), 0);
    assert_int_not_equal(access(lf_test_path(l.exports, "g1.png"), F_OK), 0);
    live_close(&stays);
    end(&l, &watcher);
}

static void a_detached_export_outlives_its_client(void **state)
{
    (void)state;
    live l;
    live_client watcher, gone;
    begin(&l, &watcher);
    live_connect(&l, &gone);
    json_int_t first = ask(&gone, "d1.png", true), second = ask(&gone, "d2.png", true);
    live_close(&gone);
    wait_for_clients(&watcher, 1);
    assert_int_equal(count_jobs(&watcher), 2);
    assert_int_equal(live_code(&watcher, "job.cancel", json_pack("{s:I}", "job", first)), 0);
    assert_int_equal(live_code(&watcher, "subscribe", json_pack("{s:[s]}", "events", "export")), 0);
    let_go(&watcher);
    assert_string_equal(live_job_end(&watcher, second), "done");
    assert_int_equal(access(lf_test_path(l.exports, "d2.png"), F_OK), 0);
    assert_int_not_equal(access(lf_test_path(l.exports, "d1.png"), F_OK), 0);
    end(&l, &watcher);
}

static void a_client_that_only_listens_is_not_gone(void **state)
{
    (void)state;
    live l;
    live_client watcher, half;
    begin(&l, &watcher);
    live_connect(&l, &half);
    json_int_t job = ask(&half, "h.png", false);
    assert_int_equal(shutdown(half.fd, SHUT_WR), 0);
    /* each turn of the daemon's loop hears everybody: by then it knows of the end */
    for (int i = 0; i < 5; i++)
        assert_int_equal(count_jobs(&watcher), 1);
    let_go(&watcher);
    assert_string_equal(live_job_end(&half, job), "done");
    assert_null(live_receive(&half)); /* and then it is closed */
    live_close(&half);
    end(&l, &watcher);
}

static void two_exports_of_a_client_wait_and_others_are_served(void **state)
{
    (void)state;
    live l;
    live_client watcher, many[4];
    begin(&l, &watcher);
    for (int i = 0; i < 4; i++)
        live_connect(&l, &many[i]);
    for (int i = 0; i < 3; i++) {
        (void)ask(&many[i], "a.png", false);
        (void)ask(&many[i], "b.png", false);
        assert_busy(&many[i], "c.png", false, "2 exports of this client are waiting already");
    }
    assert_busy(&many[3], "d.png", false, "6 exports are waiting already");
    /* what waits for nothing is not kept out by those that do, not even for the same client */
    for (int i = 0; i < 4; i++) {
        char file[8];
        snprintf(file, sizeof file, "n%d.png", i);
        json_t *params = json_pack("{s:s, s:s}", "kind", "panel", "file", file);
        json_int_t job = (json_int_t)live_number(&many[i], "export", params, "job");
        assert_string_equal(live_job_end(&many[i], job), "done");
    }
    live_close(&many[0]);
    wait_for_jobs(&watcher, 4);
    (void)ask(&many[3], "d.png", false);
    for (int i = 1; i < 4; i++)
        live_close(&many[i]);
    wait_for_jobs(&watcher, 0);
    end(&l, &watcher);
}

static void detached_exports_leave_room_for_others(void **state)
{
    (void)state;
    live l;
    live_client watcher, next;
    begin(&l, &watcher);
    for (int i = 0; i < 2; i++) {
        live_connect(&l, &next);
        (void)ask(&next, "a.png", true);
        (void)ask(&next, "b.png", true);
        assert_busy(&next, "c.png", true, "2 exports of this client are waiting already");
        live_close(&next);
    }
    live_connect(&l, &next);
    assert_busy(&next, "c.png", true, "4 detached exports are waiting already");
    (void)ask(&next, "c.png", false);
    live_close(&next);
    wait_for_jobs(&watcher, 4);
    end(&l, &watcher);
}

static void quiltctls_export_ends_with_it_and_a_detached_one_goes_on(void **state)
{
    (void)state;
    live l;
    live_client watcher;
    begin(&l, &watcher);
    char program[PATH_MAX], out[PATH_MAX];
    snprintf(program, sizeof program, "%s", lf_test_built("quiltctl"));
    snprintf(out, sizeof out, "%s/mine.png", l.folder);
    char *args[] = {program,
                    (char *)(uintptr_t) "--socket",
                    l.socket,
                    (char *)(uintptr_t) "export",
                    (char *)(uintptr_t) "panel",
                    out,
                    (char *)(uintptr_t) "wait=converged",
                    NULL};
    pid_t pid = live_spawn(&l, args);
    wait_for_jobs(&watcher, 1);
    assert_int_equal(kill(pid, SIGINT), 0);
    assert_int_equal(live_reap(pid), 128 + SIGINT);
    wait_for_jobs(&watcher, 0);
    assert_int_not_equal(access(out, F_OK), 0);
    /* relative: the daemon's folder */
    assert_int_equal(live_run(&l, "quiltctl", "--socket", l.socket, "export", "panel", "later.png",
                              "wait=converged", "detach=true", NULL),
                     0);
    wait_for_clients(&watcher, 1);
    assert_int_equal(count_jobs(&watcher), 1);
    let_go(&watcher);
    live_wait_for_file(lf_test_path(l.exports, "later.png"));
    end(&l, &watcher);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exports_that_wait_end_with_their_client),
        cmocka_unit_test(a_detached_export_outlives_its_client),
        cmocka_unit_test(a_client_that_only_listens_is_not_gone),
        cmocka_unit_test(two_exports_of_a_client_wait_and_others_are_served),
        cmocka_unit_test(detached_exports_leave_room_for_others),
        cmocka_unit_test(quiltctls_export_ends_with_it_and_a_detached_one_goes_on),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
