/* A daemon whose readers crash, hang or refuse: the picture stays, every wait ends. The readers are
 * scripts in a folder that QUILTIMPORT names. */
#include "tests/testing.h"

#include "tests/daemon/live.h"

static const char mesh_scene_text[] =
    "{ \"quiltd\": 1, \"camera\": { \"target\": [0,0,0], \"position\": [0,0,5], \"views\": 4 },\n"
    "  \"meshes\": { \"m\": { \"file\": \"a.obj\" } },\n"
    "  \"lights\": { \"sky\": { \"type\": \"environment\", \"radiance\": 1 } } }\n";

/* A folder of scenes, with a reader that does what script says. */
static void prepare(live *l, const char *script)
{
    char folder[PATH_MAX];
    live_prepare(l);
    snprintf(folder, sizeof folder, "%s/readers", l->folder);
    assert_int_equal(mkdir(folder, 0700), 0);
    assert_int_equal(chmod(lf_test_write(folder, "quiltimport", script), 0700), 0);
    lf_test_write(l->folder, "scene/mesh.json", mesh_scene_text);
    lf_test_write(l->folder, "scene/a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    setenv("QUILTIMPORT", folder, 1);
}

static json_t *failure_of(live_client *c, const char *method, json_t *params, int expected)
{
    json_t *answer = live_call(c, method, params), *error = json_object_get(answer, "error");
    if (json_integer_value(json_object_get(error, "code")) != expected)
        fail_msg("%s: not %d: %s", method, expected, json_dumps(answer, JSON_COMPACT));
    return answer;
}

static void assert_message(json_t *answer, const char *text)
{
    const char *message =
        json_string_value(json_object_get(json_object_get(answer, "error"), "message"));
    if (!message || !strstr(message, text))
        fail_msg("\"%s\" does not say \"%s\"", message ? message : "", text);
    json_decref(answer);
}

/* By the real reader; what the kernel has test_import_shares.c knows. */
static void status_tells_whether_landlock_holds_readers(void **state)
{
    (void)state;
    live l;
    live_client c;
    live_prepare(&l);
    lf_test_write(l.folder, "scene/mesh.json", mesh_scene_text);
    lf_test_write(l.folder, "scene/a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    live_start(&l, l.scene, "--device", "none", NULL);
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    assert_string_equal(live_status_text(&c, "landlock"), "unknown");
    assert_int_equal(live_code(&c, "scene.load", json_pack("{s:s}", "file", "mesh.json")), 0);
    const char *told = live_status_text(&c, "landlock");
    const bool refused = strcmp(told, "refused") == 0;
    assert_true(refused || strcmp(told, "on") == 0 || strcmp(told, "off") == 0);
    assert_int_equal(live_logged(&l, "without Landlock"), refused);
    live_close(&c);
    live_finish(&l);
}

static void a_reader_that_crashes_leaves_the_picture(void **state)
{
    (void)state;
    live l;
    live_client c;
    prepare(&l, "#!/bin/sh\nkill -SEGV $$\n");
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    json_t *answer = failure_of(&c, "scene.load", json_pack("{s:s}", "file", "mesh.json"), -32002);
    assert_message(answer, "mesh.json:2: /meshes/m/file: ");
    answer = failure_of(&c, "scene.load", json_pack("{s:s}", "file", "mesh.json"), -32002);
    assert_message(answer, "a.obj: the reader ended by signal 11; the file is damaged or not what "
                           "it claims");
    assert_true(live_number(&c, "status", NULL, "generation") == 1);
    live_wait(&c, "complete");
    live_close(&c);
    live_finish(&l);
}

static void a_reader_that_hangs_delays_neither_commands_nor_the_end(void **state)
{
    (void)state;
    live l;
    live_client c, other;
    prepare(&l, "#!/bin/sh\nexec sleep 1000\n");
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_connect(&l, &c);
    live_connect(&l, &other);
    live_wait(&c, "coarse");
    static const char load[] =
        "{\"jsonrpc\":\"2.0\",\"id\":7,\"method\":\"scene.load\",\"params\":{"
        "\"file\":\"mesh.json\"}}\n";
    live_send(&other, load, sizeof load - 1);
    while (live_number(&c, "status", NULL, "loading") < 1)
        live_nap(10);
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:b}", "paused", 1)), 0);
    assert_true(live_number(&c, "status", NULL, "loading") == 1); /* it hangs still */
    assert_int_equal(live_stop(&l), 0);
    live_close(&c);
    live_close(&other);
    live_finish(&l);
}

static void whoever_listens_hears_how_far_reading_is(void **state)
{
    (void)state;
    live l;
    live_client c, other;
    prepare(&l, "#!/bin/sh\nexec sleep 1000\n");
    live_start(&l, l.scene, "--device", "none", NULL);
    live_connect(&l, &c);
    live_connect(&l, &other);
    live_wait(&c, "coarse");
    json_t *answer = live_call(&other, "status", NULL);
    assert_true(json_is_null(json_object_get(json_object_get(answer, "result"), "reading")));
    json_decref(answer);
    assert_int_equal(live_code(&c, "subscribe", json_pack("{s:[s]}", "events", "scene")), 0);
    static const char load[] =
        "{\"jsonrpc\":\"2.0\",\"id\":7,\"method\":\"scene.load\",\"params\":{"
        "\"file\":\"mesh.json\"}}\n";
    live_send(&other, load, sizeof load - 1);
    json_t *told = live_receive(&c), *p = json_object_get(told, "params");
    assert_string_equal(json_string_value(json_object_get(told, "method")), "scene.load");
    assert_string_equal(strrchr(json_string_value(json_object_get(p, "file")), '/'), "/a.obj");
    assert_int_equal(json_integer_value(json_object_get(p, "bytes")), 32);
    assert_true(json_number_value(json_object_get(p, "seconds")) > 0.0);
    assert_int_equal(json_integer_value(json_object_get(p, "files_read")), 0);
    json_decref(told);
    answer = live_call(&other, "status", NULL); /* behind the load of the same client */
    p = json_object_get(json_object_get(answer, "result"), "reading");
    assert_string_equal(strrchr(json_string_value(json_object_get(p, "file")), '/'), "/a.obj");
    json_decref(answer);
    assert_int_equal(live_stop(&l), 0);
    live_close(&c);
    live_close(&other);
    live_finish(&l);
}

static void a_reader_has_the_time_that_the_daemon_was_told(void **state)
{
    (void)state;
    live l;
    live_client c;
    prepare(&l, "#!/bin/sh\nexec sleep 1000\n");
    live_start(&l, lf_test_path(l.folder, "scene/mesh.json"), "--device", "none", "--import-time",
               "1", NULL);
    live_connect(&l, &c);
    /* whoever waits for the picture of a scene that is refused hears why, before or after */
    for (int i = 0; i < 2; i++)
        assert_message(failure_of(&c, "wait", json_pack("{s:s}", "for", "coarse"), -32002),
                       "a.obj: reading takes longer than 1 s (--import-time");
    assert_string_equal(live_status_text(&c, "state"), "error");
    live_close(&c);
    live_finish(&l);
}

static void a_wait_ends_when_its_time_is_over(void **state)
{
    (void)state;
    live l;
    live_client c;
    prepare(&l, "");
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_connect(&l, &c);
    live_wait(&c, "complete");
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:b}", "paused", 1)), 0);
    json_t *answer = failure_of(
        &c, "wait", json_pack("{s:s, s:f}", "for", "converged", "timeout", 0.05), -32004);
    assert_message(answer,
                   "wait: the image was not converged within 0.05 s, because rendering is paused");
    /* what is there already is answered, whatever the time */
    assert_int_equal(
        live_code(&c, "wait", json_pack("{s:s, s:f}", "for", "coarse", "timeout", 1e-3)), 0);
    assert_int_equal(live_code(&c, "wait", json_pack("{s:f}", "timeout", 0.0)), -32602);
    char *const words[] = {(char *)(uintptr_t)lf_test_built("quiltctl"),
                           (char *)(uintptr_t) "--socket",
                           l.socket,
                           (char *)(uintptr_t) "--timeout",
                           (char *)(uintptr_t) "0.2",
                           (char *)(uintptr_t) "wait",
                           (char *)(uintptr_t) "for=converged",
                           NULL};
    assert_int_equal(live_reap(live_spawn(&l, words)), 1);
    assert_true(live_logged(&l, "no answer arrived within 0.2 s; use a longer --timeout"));
    live_close(&c);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(status_tells_whether_landlock_holds_readers),
        cmocka_unit_test(a_reader_that_crashes_leaves_the_picture),
        cmocka_unit_test(a_reader_that_hangs_delays_neither_commands_nor_the_end),
        cmocka_unit_test(whoever_listens_hears_how_far_reading_is),
        cmocka_unit_test(a_reader_has_the_time_that_the_daemon_was_told),
        cmocka_unit_test(a_wait_ends_when_its_time_is_over),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
