/* A load that takes too long: job.cancel ends it, and so does a later load when nobody waits for it
 * any more. The picture stays, and what waits goes on. Readers are scripts in a folder that
 * QUILTIMPORT names; none of those that stay ever ends by itself. */
#include "tests/testing.h"

#include "tests/daemon/live.h"

#define FOR_EVER "80000" /* seconds of --import-time */

/* Scenes whose mesh is read until the file "go" is there, and then cannot be. */
static void prepare(live *l)
{
    char readers[PATH_MAX], script[2 * PATH_MAX];
    static const char scene[] =
        "{ \"quiltd\": 1, \"camera\": { \"target\": [0,0,0], \"position\": [0,0,5], \"views\": 4 },"
        " \"meshes\": { \"m\": { \"file\": \"a.obj\" } } }";
    live_prepare(l);
    snprintf(readers, sizeof readers, "%s/readers", l->folder);
    assert_int_equal(mkdir(readers, 0700), 0);
    /* until it is let go, or the daemon has gone */
    snprintf(script, sizeof script,
             "#!/bin/sh\necho $$ >>%s/starts\n"
             "while [ ! -e %s/go ] && kill -0 $PPID; do sleep 0.05; done\n",
             l->folder, l->folder);
    assert_int_equal(chmod(lf_test_write(readers, "quiltimport", script), 0700), 0);
    lf_test_write(l->folder, "scene/slow.json", scene);
    lf_test_write(l->folder, "scene/slower.json", scene);
    lf_test_write(l->folder, "scene/other.json", LIVE_SCENE);
    lf_test_write(l->folder, "scene/a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    setenv("QUILTIMPORT", readers, 1);
}

static int count_starts(const live *l)
{
    return lf_test_count_lines(lf_test_path(l->folder, "starts"));
}

static void await_starts(const live *l, int n)
{
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++, live_nap(20))
        if (count_starts(l) >= n)
            return;
    fail_msg("reader %d does not begin", n);
}

/* A daemon that shows something, and clients of it, NULL behind the last. */
static void begin(live *l, live_client *const clients[])
{
    prepare(l);
    live_start(l, l->scene, "--device", "none", "--import-time", FOR_EVER, NULL);
    for (int i = 0; clients[i]; i++)
        live_connect(l, clients[i]);
    live_wait(clients[0], "coarse");
}
#define BEGIN(l, ...) begin(l, (live_client *[]){__VA_ARGS__, NULL})

static void end(live *l, live_client *const clients[])
{
    for (int i = 0; clients[i]; i++)
        live_close(clients[i]);
    live_finish(l);
}
#define END(l, ...) end(l, (live_client *[]){__VA_ARGS__, NULL})

/* Until so many loads wait or are under way. */
static void await_loading(live_client *c, int n)
{
    while (live_number(c, "status", NULL, "loading") < n)
        live_nap(10);
}

static json_t *mesh_patch(const char *name)
{
    return json_pack("{s:{s:{s:{s:s}}}}", "patch", "meshes", name, "file", "a.obj");
}

static void ask_for_file(live_client *c, const char *file)
{
    live_ask(c, "scene.load", json_pack("{s:s}", "file", file));
}

static void assert_fails(json_t *answer, const char *text)
{
    const char *message =
        json_string_value(json_object_get(json_object_get(answer, "error"), "message"));
    if (!message || !strstr(message, text))
        fail_msg("\"%s\" does not say \"%s\"", message ? message : "", text);
    json_decref(answer);
}

static void assert_succeeds(json_t *answer)
{
    if (!json_object_get(answer, "result"))
        fail_msg("%s", json_dumps(answer, JSON_COMPACT));
    json_decref(answer);
}

/* A number of what is being loaded; 0: nothing is. */
static json_int_t loading_job(live_client *c)
{
    json_t *answer = live_call(c, "status", NULL);
    json_t *load = json_object_get(json_object_get(answer, "result"), "load");
    json_int_t job = json_integer_value(json_object_get(load, "job"));
    json_decref(answer);
    return job;
}

static void cancel_loading(live_client *c)
{
    json_int_t job = loading_job(c);
    assert_true(job > 0);
    assert_int_equal(live_code(c, "job.cancel", json_pack("{s:I}", "job", job)), 0);
}

static void job_cancel_ends_a_load(void **state)
{
    (void)state;
    live l;
    live_client asker, other;
    BEGIN(&l, &asker, &other);
    assert_int_equal(loading_job(&other), 0);
    ask_for_file(&asker, "slow.json");
    await_starts(&l, 1);
    json_t *answer = live_call(&other, "status", NULL),
           *load = json_object_get(json_object_get(answer, "result"), "load");
    assert_true(json_is_object(load));
    assert_string_equal(json_string_value(json_object_get(load, "kind")), "file");
    assert_string_equal(strrchr(json_string_value(json_object_get(load, "file")), '/'),
                        "/slow.json");
    json_decref(answer);
    cancel_loading(&other);
    assert_fails(live_answer(&asker), "cancelled");
    assert_true(live_number(&other, "status", NULL, "generation") == 1);
    assert_string_equal(strrchr(live_status_text(&other, "scene"), '/'), "/fog.json");
    assert_int_equal(loading_job(&other), 0);
    /* the next one goes well */
    assert_succeeds(live_call(&asker, "scene.load", json_pack("{s:s}", "file", "other.json")));
    assert_true(live_number(&other, "status", NULL, "generation") == 2);
    END(&l, &asker, &other);
}

/* Exports and loads: a number is that of one thing. */
static void a_number_is_that_of_one_job(void **state)
{
    (void)state;
    live l;
    live_client asker, other;
    BEGIN(&l, &asker, &other);
    assert_int_equal(live_code(&other, "render.set", json_pack("{s:b}", "paused", 1)), 0);
    ask_for_file(&asker, "slow.json");
    await_starts(&l, 1);
    json_int_t job = loading_job(&other),
               waits = (json_int_t)live_number(&other, "export",
                                               json_pack("{s:s, s:s, s:s}", "kind", "quilt", "file",
                                                         "x.png", "wait", "converged"),
                                               "job");
    assert_true(job > 0 && waits > 0 && waits != job);
    assert_int_equal(live_code(&other, "job.cancel", json_pack("{s:I}", "job", waits)), 0);
    assert_true(loading_job(&other) == job);
    cancel_loading(&other);
    assert_fails(live_answer(&asker), "cancelled");
    assert_int_equal(live_code(&other, "job.cancel", json_pack("{s:I}", "job", job)), -32602);
    END(&l, &asker, &other);
}

/* Of changes that are made together, only the one that was cancelled is not made. */
static void changes_beside_a_cancelled_one_are_made(void **state)
{
    (void)state;
    live l;
    live_client first, slow, quick, other;
    BEGIN(&l, &first, &slow, &quick, &other);
    ask_for_file(&first, "slow.json");
    await_starts(&l, 1);
    live_ask(&slow, "scene.patch", mesh_patch("m"));
    await_loading(&other, 2);
    live_ask(&quick, "camera.set", json_pack("{s:i}", "views", 3));
    await_loading(&other, 3);
    cancel_loading(&other);
    assert_fails(live_answer(&first), "cancelled");
    await_starts(&l, 2);
    cancel_loading(&other);
    assert_fails(live_answer(&slow), "cancelled");
    assert_succeeds(live_answer(&quick));
    assert_true(live_number(&other, "status", NULL, "views") == 3);
    END(&l, &first, &slow, &quick, &other);
}

/* One that is made already, or was to be, is not ended a second time: another one would be. */
static void a_second_cancel_ends_nothing(void **state)
{
    (void)state;
    live l;
    live_client first, slow, slower, other;
    BEGIN(&l, &first, &slow, &slower, &other);
    ask_for_file(&first, "slow.json");
    await_starts(&l, 1);
    live_ask(&slow, "scene.patch", mesh_patch("m"));
    await_loading(&other, 2);
    live_ask(&slower, "scene.patch", mesh_patch("n"));
    await_loading(&other, 3);
    json_int_t job = loading_job(&other);
    cancel_loading(&other);
    await_starts(&l, 2); /* both changes at once */
    assert_int_equal(live_code(&other, "job.cancel", json_pack("{s:I}", "job", job + 1)), 0);
    await_starts(&l, 3); /* the second one alone */
    assert_int_equal(live_code(&other, "subscribe", json_pack("{s:[s]}", "events", "scene")), 0);
    assert_int_equal(live_code(&other, "job.cancel", json_pack("{s:I}", "job", job + 1)), 0);
    for (int i = 0; i < 4; i++)
        json_decref(live_receive(&other));
    assert_int_equal(count_starts(&l), 3);
    assert_int_equal(live_code(&other, "job.cancel", json_pack("{s:I}", "job", job + 2)), 0);
    assert_fails(live_answer(&first), "cancelled");
    assert_fails(live_answer(&slow), "cancelled");
    assert_fails(live_answer(&slower), "cancelled");
    END(&l, &first, &slow, &slower, &other);
}

static void a_load_that_waits_is_cancelled_at_once(void **state)
{
    (void)state;
    live l;
    live_client first, second, other;
    BEGIN(&l, &first, &second, &other);
    ask_for_file(&first, "slow.json");
    await_starts(&l, 1);
    live_ask(&second, "camera.set", json_pack("{s:i}", "views", 3));
    await_loading(&other, 2);
    json_int_t job = loading_job(&other);
    assert_int_equal(live_code(&other, "job.cancel", json_pack("{s:I}", "job", job + 1)), 0);
    assert_fails(live_answer(&second), "cancelled");
    assert_true(loading_job(&other) == job);
    cancel_loading(&other);
    assert_fails(live_answer(&first), "cancelled");
    END(&l, &first, &second, &other);
}

/* A change that is asked for by somebody who then leaves. The line is n bytes longer than it
 * needs to be. */
static void change_and_leave(const live *l, const char *change, int n)
{
    live_client c;
    live_connect(l, &c);
    char *line = NULL;
    assert_true(asprintf(&line,
                         "{\"method\":\"scene.patch\",\"jsonrpc\":\"2.0\",\"params\":%s%*s}\n",
                         change, n, "") > 0);
    for (size_t at = 0, all = strlen(line); at < all;) {
        ssize_t done = send(c.fd, line + at, all - at, MSG_NOSIGNAL);
        assert_true(done > 0);
        at += (size_t)done;
    }
    free(line);
    live_close(&c);
}

/* What waits for its turn has a limit, also of those who have left: little of theirs waits. */
static void nobody_fills_the_queue_by_coming_and_going(void **state)
{
    (void)state;
    enum { COMERS = 20 };
    live l;
    live_client slow, other;
    BEGIN(&l, &slow, &other);
    ask_for_file(&slow, "slow.json");
    await_starts(&l, 1);
    for (int i = 0; i < COMERS; i++)
        change_and_leave(&l, "{\"patch\":{\"camera\":{\"views\":5}}}", 300000);
    while (live_number(&other, "status", NULL, "clients") > 2)
        live_nap(10);
    while (live_number(&other, "status", NULL, "loading") > 1) /* they come back one by one */
        live_nap(10);
    change_and_leave(&l, "{\"patch\":{\"camera\":{\"views\":3}}}", 0);
    await_loading(&other, 2);
    cancel_loading(&other);
    assert_fails(live_answer(&slow), "cancelled");
    while (live_number(&other, "status", NULL, "loading") > 0)
        live_nap(10);
    assert_true(live_number(&other, "status", NULL, "generation") == 2);
    assert_true(live_number(&other, "status", NULL, "views") == 3);
    END(&l, &slow, &other);
}

static void a_load_that_nobody_waits_for_is_replaced_by_any_later_one(void **state)
{
    (void)state;
    live l;
    live_client gone, other;
    BEGIN(&l, &gone, &other);
    /* one under way, one behind it */
    ask_for_file(&gone, "slow.json");
    ask_for_file(&gone, "slower.json");
    await_starts(&l, 1);
    live_close(&gone);
    assert_succeeds(live_call(&other, "camera.orbit", json_pack("{s:i}", "yaw", 3)));
    assert_true(live_number(&other, "status", NULL, "generation") == 2);
    assert_true(
        live_logged(&l, "slow.json: the load was cancelled, because a later one replaces it"));
    assert_true(
        live_logged(&l, "slower.json: the load was cancelled, because a later one replaces it"));
    END(&l, &other);
}

/* ... also when who asked goes only then. */
static void a_load_is_replaced_when_who_asked_goes(void **state)
{
    (void)state;
    live l;
    live_client gone, other, third;
    BEGIN(&l, &gone, &other, &third);
    ask_for_file(&gone, "slow.json");
    await_starts(&l, 1);
    live_ask(&other, "camera.orbit", json_pack("{s:i}", "yaw", 3));
    await_loading(&third, 2);
    live_close(&gone);
    assert_succeeds(live_answer(&other));
    END(&l, &other, &third);
}

/* A connection whose other side only has nothing more to say still waits for its answer. */
static void a_half_closed_asker_gets_its_answer(void **state)
{
    (void)state;
    live l;
    live_client half, other, third;
    BEGIN(&l, &half, &other, &third);
    assert_int_equal(live_code(&third, "subscribe", json_pack("{s:[s]}", "events", "scene")), 0);
    ask_for_file(&half, "slow.json");
    assert_int_equal(shutdown(half.fd, SHUT_WR), 0);
    await_starts(&l, 1);
    live_ask(&other, "camera.orbit", json_pack("{s:i}", "yaw", 3));
    /* each time that this is told it is also looked for who waits no more */
    for (int i = 0; i < 6; i++) {
        json_t *told = live_receive(&third);
        assert_string_equal(json_string_value(json_object_get(told, "method")), "scene.load");
        assert_true(json_integer_value(json_object_get(json_object_get(told, "params"), "job")) >
                    0);
        json_decref(told);
    }
    lf_test_write(l.folder, "go", "");
    assert_fails(live_answer(&half), "the file reader ended without a message");
    assert_succeeds(live_answer(&other));
    END(&l, &half, &other, &third);
}

/* What nobody asked for makes room for a file, but not for a move of what is shown before it. */
static void the_first_scene_is_replaced_by_another_file_alone(void **state)
{
    (void)state;
    live l;
    live_client moves, other, third;
    prepare(&l);
    live_start(&l, lf_test_path(l.folder, "scene/slow.json"), "--device", "none", "--import-time",
               FOR_EVER, NULL);
    live_connect(&l, &moves);
    live_connect(&l, &other);
    live_connect(&l, &third);
    assert_int_equal(live_code(&third, "subscribe", json_pack("{s:[s]}", "events", "scene")), 0);
    await_starts(&l, 1);
    live_ask(&moves, "camera.orbit", json_pack("{s:i}", "yaw", 3));
    for (int i = 0; i < 6; i++)
        json_decref(live_receive(&third));
    assert_int_equal(count_starts(&l), 1);
    assert_true(live_number(&other, "status", NULL, "loading") == 2);
    assert_succeeds(live_call(&other, "scene.load", json_pack("{s:s}", "file", "other.json")));
    assert_fails(live_answer(&moves), "no scene is loaded");
    END(&l, &moves, &other, &third);
}

/* The entry would be replaced by the file before it. */
static void no_file_is_read_again_while_an_entry_of_the_playlist_loads(void **state)
{
    (void)state;
    live l;
    live_client c;
    BEGIN(&l, &c);
    json_t *entries =
        json_pack("{s:[{s:s, s:i}]}", "entries", "file", "slow.json", "seconds", 86400);
    assert_int_equal(live_code(&c, "playlist.set", entries), 0);
    assert_int_equal(live_code(&c, "playlist.play", NULL), 0);
    await_starts(&l, 1);
    kill(l.pid, SIGHUP);
    for (int i = 0; i < 3; i++) /* turns of the event loop, for the signal */
        (void)live_status_text(&c, "state");
    assert_true(live_number(&c, "status", NULL, "loading") == 1);
    assert_int_equal(live_code(&c, "playlist.stop", NULL), 0); /* nothing is on its way any more */
    const double before = live_number(&c, "status", NULL, "generation");
    kill(l.pid, SIGHUP);
    while (live_number(&c, "status", NULL, "generation") == before)
        live_nap(20);
    END(&l, &c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(job_cancel_ends_a_load),
        cmocka_unit_test(a_number_is_that_of_one_job),
        cmocka_unit_test(changes_beside_a_cancelled_one_are_made),
        cmocka_unit_test(a_second_cancel_ends_nothing),
        cmocka_unit_test(a_load_that_waits_is_cancelled_at_once),
        cmocka_unit_test(nobody_fills_the_queue_by_coming_and_going),
        cmocka_unit_test(a_load_that_nobody_waits_for_is_replaced_by_any_later_one),
        cmocka_unit_test(a_load_is_replaced_when_who_asked_goes),
        cmocka_unit_test(a_half_closed_asker_gets_its_answer),
        cmocka_unit_test(the_first_scene_is_replaced_by_another_file_alone),
        cmocka_unit_test(no_file_is_read_again_while_an_entry_of_the_playlist_loads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
