/* The daemon's socket, from outside: several clients, garbage, long lines, slow readers, stale
 * sockets, paths, signals. */
#include "tests/daemon/live.h"

static void hello_lists_the_methods_with_their_schemas(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, NULL, "--device", "none", NULL);
    live_client c;
    live_connect(&l, &c);
    json_t *answer = live_call(&c, "hello", NULL);
    const json_t *result = json_object_get(answer, "result");
    assert_string_equal(json_string_value(json_object_get(result, "name")), "quiltd");
    assert_int_equal(json_integer_value(json_object_get(result, "protocol")), 1);
    const json_t *orbit = json_object_get(
        json_object_get(json_object_get(result, "methods"), "camera.orbit"), "params");
    assert_non_null(json_object_get(json_object_get(orbit, "properties"), "yaw"));
    json_decref(answer);
    assert_string_equal(live_status_text(&c, "state"), "idle");
    live_close(&c);
    live_finish(&l);
}

static int code_of_line(live_client *c, const char *line, size_t n)
{
    live_send(c, line, n);
    json_t *answer = live_receive(c);
    assert_non_null(answer);
    int code = (int)json_integer_value(json_object_get(json_object_get(answer, "error"), "code"));
    json_decref(answer);
    return code;
}

#define LINE_CODE(c, text) code_of_line((c), text "\n", sizeof(text))

static void bad_lines_get_the_standard_errors_and_the_connection_lives_on(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, NULL, "--device", "none", NULL);
    live_client c;
    live_connect(&l, &c);
    assert_int_equal(LINE_CODE(&c, "not json"), -32700);
    assert_int_equal(LINE_CODE(&c, "\x00\x01\xff\xfe\x7f"), -32700);
    assert_int_equal(LINE_CODE(&c, "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"\xc3\x28\"}"),
                     -32700);
    assert_int_equal(LINE_CODE(&c, "[{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"hello\"}]"),
                     -32600);
    assert_int_equal(LINE_CODE(&c, "{\"jsonrpc\":\"2.0\",\"id\":1}"), -32600);
    assert_int_equal(LINE_CODE(&c, "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"nothing\"}"),
                     -32601);
    assert_int_equal(
        LINE_CODE(&c, "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"wait\",\"params\":{\"for\":3}}"),
        -32602);
    assert_int_equal(
        LINE_CODE(
            &c,
            "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"wait\",\"params\":{\"fro\":\"coarse\"}}"),
        -32602);
    json_t *answer = live_call(&c, "camera.orbitt", json_object());
    assert_string_equal(
        json_string_value(json_object_get(json_object_get(answer, "error"), "message")),
        "there is no method \"camera.orbitt\"; did you mean \"camera.orbit\"?");
    json_decref(answer);
    /* Empty lines and notifications are not answered; the next answer is the next call's. */
    static const char quiet[] = "\n\n{\"jsonrpc\":\"2.0\",\"method\":\"nothing\"}\n";
    live_send(&c, quiet, sizeof quiet - 1);
    assert_int_equal(live_code(&c, "hello", NULL), 0);
    live_close(&c);
    live_finish(&l);
}

static void a_line_over_1_mib_is_refused_once_and_skipped(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, NULL, "--device", "none", NULL);
    live_client c;
    live_connect(&l, &c);
    size_t n = (size_t)5 << 19;
    char *line = malloc(n);
    assert_non_null(line);
    memset(line, 'a', n);
    live_send(&c, line, n);
    assert_int_equal(code_of_line(&c, "", 0), -32600);
    live_send(&c, "\n", 1);
    assert_int_equal(live_code(&c, "hello", NULL), 0);
    free(line);
    live_close(&c);
    live_finish(&l);
}

static void a_client_that_does_not_read_is_dropped_and_others_are_served(void **state)
{
    (void)state;
    static const char line[] = "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"hello\"}\n";
    live l;
    live_prepare(&l);
    live_start(&l, NULL, "--device", "none", NULL);
    live_client slow, other;
    live_connect(&l, &slow);
    live_connect(&l, &other);
    /* Far more than a socket holds and the daemon queues: at some point it hangs up. */
    bool dropped = false;
    for (int i = 0; i < 20000 && !dropped; i++)
        dropped = send(slow.fd, line, sizeof line - 1, MSG_NOSIGNAL) < 0;
    assert_true(dropped);
    assert_int_equal(live_code(&other, "hello", NULL), 0);
    live_close(&slow);
    live_close(&other);
    live_finish(&l);
}

static void many_clients_are_served_and_too_many_are_told(void **state)
{
    (void)state;
    enum { N = 64 };
    live l;
    live_prepare(&l);
    live_start(&l, NULL, "--device", "none", NULL);
    live_client *c = calloc(N + 1, sizeof *c);
    assert_non_null(c);
    for (int i = 0; i < N; i++) {
        live_connect(&l, &c[i]);
        assert_int_equal(live_code(&c[i], "hello", NULL), 0);
    }
    live_connect(&l, &c[N]);
    json_t *answer = live_receive(&c[N]);
    assert_int_equal(json_integer_value(json_object_get(json_object_get(answer, "error"), "code")),
                     -32000);
    json_decref(answer);
    assert_null(live_receive(&c[N]));
    for (int i = 0; i < N; i++)
        assert_int_equal(live_code(&c[N - 1 - i], "status", NULL), 0);
    for (int i = 0; i <= N; i++)
        live_close(&c[i]);
    free(c);
    live_finish(&l);
}

static void a_half_closed_connection_still_gets_its_answers(void **state)
{
    (void)state;
    static const char line[] =
        "{\"jsonrpc\":\"2.0\",\"id\":7,\"method\":\"wait\",\"params\":{\"for\":\"coarse\"}}\n";
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", "none", NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    live_send(&c, line, sizeof line - 1);
    shutdown(c.fd, SHUT_WR);
    json_t *answer = live_receive(&c);
    assert_non_null(json_object_get(answer, "result"));
    json_decref(answer);
    assert_null(live_receive(&c));
    live_close(&c);
    live_finish(&l);
}

static void a_stale_socket_is_replaced_and_a_living_one_refused(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, NULL, "--device", "none", NULL);
    assert_int_equal(live_run(&l, "quiltd", "--device", "none", "--socket", l.socket, NULL), 1);
    assert_true(live_logged(&l, "another quiltd uses this socket"));
    kill(l.pid, SIGKILL);
    assert_int_equal(live_reap(l.pid), 128 + SIGKILL);
    assert_int_equal(access(l.socket, F_OK), 0);
    live_start(&l, NULL, "--device", "none", NULL);
    struct stat st;
    assert_int_equal(stat(l.socket, &st), 0);
    assert_int_equal(st.st_mode & 0777, 0600);
    assert_int_equal(live_stop(&l), 0);
    assert_int_not_equal(access(l.socket, F_OK), 0);
    /* What is no socket is not touched. */
    lf_test_write(l.folder, "s", "precious");
    assert_int_equal(live_run(&l, "quiltd", "--device", "none", "--socket", l.socket, NULL), 1);
    assert_int_equal(stat(l.socket, &st), 0);
    assert_int_equal(st.st_size, 8);
    live_finish(&l);
}

static void signals_shutdown_and_run_for_end_it_with_0(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    assert_int_equal(live_stop(&l), 0);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    kill(l.pid, SIGINT);
    assert_int_equal(live_reap(l.pid), 0);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    assert_int_equal(live_code(&c, "shutdown", NULL), 0);
    assert_int_equal(live_reap(l.pid), 0);
    live_close(&c);
    l.pid = 0;
    assert_int_equal(live_run(&l, "quiltd", l.scene, "--device", "none", "--socket", l.socket,
                              "--run-for", "0.3", NULL),
                     0);
    live_finish(&l);
}

static void wrong_usage_is_2(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    assert_int_equal(live_run(&l, "quiltd", "--nonsense", NULL), 2);
    assert_int_equal(live_run(&l, "quiltd", "a.json", "b.json", NULL), 2);
    assert_int_equal(live_run(&l, "quiltd", "--run-for", "soon", NULL), 2);
    assert_int_equal(live_run(&l, "quiltd", "--integrator", "mvpt2022", NULL), 2);
    assert_int_equal(live_run(&l, "quiltd", "--shift", "raw-copy", NULL), 2);
    assert_int_equal(live_run(&l, "quiltd", "--device", "toaster", "--socket", l.socket, NULL), 2);
    assert_int_equal(
        live_run(&l, "quiltd", "--views", "45", "--quilt", "4x4", "--socket", l.socket, NULL), 2);
    const char *absent = lf_test_path(l.folder, "absent.json");
    assert_int_equal(live_run(&l, "quiltd", "--device", "none", "--calibration", absent, "--socket",
                              l.socket, NULL),
                     1);
    assert_int_equal(live_run(&l, "quiltd", "--version", NULL), 0);
    assert_int_equal(live_run(&l, "quiltctl", "--help", NULL), 0);
    assert_int_equal(live_run(&l, "quiltctl", NULL), 2);
    assert_int_equal(live_run(&l, "quiltctl", "--socket", l.socket, "status", NULL), 3);
    live_finish(&l);
}

static void quiltctl_calls_and_prints(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", "none", NULL);
    assert_int_equal(live_run(&l, "quiltctl", "--socket", l.socket, "wait", "for=coarse", NULL), 0);
    assert_int_equal(live_run(&l, "quiltctl", "--socket", l.socket, "status", NULL), 0);
    assert_true(live_logged(&l, "Problems and warnings"));
    assert_false(live_logged(&l, "shown.generation"));
    assert_int_equal(live_run(&l, "quiltctl", "--socket", l.socket, "status", "--all", NULL), 0);
    assert_true(live_logged(&l, "shown.generation"));
    assert_int_equal(
        live_run(&l, "quiltctl", "--socket", l.socket, "--json", "camera.orbit", "yaw=5", NULL), 0);
    assert_true(live_logged(&l, "\"generation\": 2"));
    assert_int_equal(
        live_run(&l, "quiltctl", "--socket", l.socket, "camera.orbit", "yaw=five", NULL), 2);
    assert_int_equal(live_run(&l, "quiltctl", "--socket", l.socket, "camera.orbit", "yam=5", NULL),
                     2);
    assert_true(live_logged(&l, "unknown key \"yam\"; did you mean \"yaw\"?"));
    assert_int_equal(live_run(&l, "quiltctl", "--socket", l.socket, "no.method", NULL), 2);
    assert_true(live_logged(&l, "no.method: is not a method of this daemon; quiltctl hello lists"));
    assert_int_equal(live_run(&l, "quiltctl", "--socket", l.socket, "statsu", NULL), 2);
    assert_true(live_logged(&l, "is not a method of this daemon; did you mean \"status\"?"));
    assert_int_equal(live_run(&l, "quiltctl", "--socket", l.socket, "scene.patch",
                              "patch:={\"camera\":{\"viewz\":3}}", NULL),
                     1);
    assert_true(live_logged(&l, "/camera/viewz"));
    live_finish(&l);
}

static void reads_stay_beneath_the_scene_and_the_allowed_paths(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    char *elsewhere = lf_test_folder();
    char other[PATH_MAX], inside[PATH_MAX];
    snprintf(other, sizeof other, "%s", lf_test_write(elsewhere, "other.json", LIVE_SCENE));
    live_start(&l, l.scene, "--device", "none", NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    assert_int_equal(live_code(&c, "scene.load", json_pack("{s:s}", "file", other)), -32001);
    assert_int_equal(
        live_code(&c, "scene.load", json_pack("{s:s}", "file", "../../../../../../etc/passwd")),
        -32001);
    /* Whether it exists is not told. */
    assert_int_equal(live_code(&c, "scene.load", json_pack("{s:s}", "file", "/etc/no-such-file")),
                     -32001);
    assert_int_equal(live_code(&c, "scene.load", json_pack("{s:s}", "file", "/etc/no-folder/file")),
                     -32001);
    snprintf(inside, sizeof inside, "%s/scene/link.json", l.folder);
    assert_int_equal(symlink(other, inside), 0);
    assert_int_equal(live_code(&c, "scene.load", json_pack("{s:s}", "file", inside)), -32001);
    assert_int_equal(live_code(&c, "scene.load", json_pack("{s:s}", "file", "none.json")), -32002);
    /* no name is no folder either */
    assert_int_equal(live_code(&c, "scene.load", json_pack("{s:s}", "file", "")), -32602);
    /* Through the scene too: a file it names. */
    snprintf(inside, sizeof inside, "%s/scene/sky.exr", l.folder);
    assert_int_equal(symlink("/etc/passwd", inside), 0);
    json_t *patch =
        json_loads("{\"lights\":{\"sky\":{\"radiance\":null,\"file\":\"sky.exr\"}}}", 0, NULL);
    assert_int_equal(live_code(&c, "scene.patch", json_pack("{s:o}", "patch", patch)), -32001);
    patch = json_pack("{s:{s:{s:n, s:s}}}", "lights", "sky", "radiance", "file",
                      lf_test_write(elsewhere, "sky.exr", "no picture"));
    assert_int_equal(live_code(&c, "scene.patch", json_pack("{s:o}", "patch", patch)), -32001);
    assert_int_equal(live_code(&c, "scene.load", json_pack("{s:s}", "file", l.scene)), 0);
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    live_start(&l, l.scene, "--device", "none", "--allow-path", elsewhere, NULL);
    live_connect(&l, &c);
    assert_int_equal(live_code(&c, "scene.load", json_pack("{s:s}", "file", other)), 0);
    live_close(&c);
    live_finish(&l);
    lf_test_folder_remove(elsewhere);
}

/* Lines in the daemon's log that hold the words. */
static int lines_logged(const live *l, const char *words)
{
    char line[4096];
    int n = 0;
    FILE *file = fopen(l->log, "r");
    assert_non_null(file);
    while (fgets(line, sizeof line, file))
        n += !!strstr(line, words);
    fclose(file);
    return n;
}

static size_t warnings_of(live_client *c, const char *method, json_t *params, const char *words)
{
    json_t *answer = live_call(c, method, params);
    const json_t *warnings = json_object_get(json_object_get(answer, "result"), "warnings");
    size_t n = json_array_size(warnings);
    bool told = !words;
    assert_true(json_is_array(warnings));
    for (size_t i = 0; i < n; i++)
        told |= words && strstr(json_string_value(json_array_get(warnings, i)), words);
    assert_true(told);
    json_decref(answer);
    return n;
}

static void what_a_scene_lacks_is_told_with_the_answer_and_logged_once(void **state)
{
    (void)state;
    static const char twice[] =
        "{\"meshes\":{\"a\":{\"shape\":\"quad\"},\"b\":{\"shape\":\"quad\"}}}";
    static const char dark[] = "{\"lights\":null}", moved[] = "{\"camera\":{\"fov_y\":21}}";
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", "none", NULL);
    live_client c;
    live_connect(&l, &c);
    assert_int_equal(warnings_of(&c, "scene.load", json_pack("{s:s}", "file", l.scene), NULL), 0);
    assert_int_equal(warnings_of(&c, "scene.patch",
                                 json_pack("{s:o}", "patch", json_loads(twice, 0, NULL)),
                                 "\"a\" has the same"),
                     1);
    assert_int_equal(warnings_of(&c, "scene.patch",
                                 json_pack("{s:o}", "patch", json_loads(dark, 0, NULL)),
                                 "the scene has no light"),
                     2);
    assert_int_equal(warnings_of(&c, "scene.patch",
                                 json_pack("{s:o}", "patch", json_loads(moved, 0, NULL)),
                                 "the scene has no light"),
                     2);
    assert_int_equal(lines_logged(&l, "has the same"), 1);
    assert_int_equal(lines_logged(&l, "the scene has no light"), 1);
    assert_int_equal(warnings_of(&c, "scene.load", json_pack("{s:s}", "file", l.scene), NULL), 0);
    live_close(&c);
    live_finish(&l);
}

static void what_a_quilt_says_in_vain_is_told_and_logged(void **state)
{
    (void)state;
    static const char quilt[] = "#?RADIANCE\nGAMMA=2\n\n-Y 1 +X 2\nabcdabcd";
    live l;
    live_prepare(&l);
    const char *path = lf_test_write(l.folder, "scene/said_qs2x1a1.hdr", quilt);
    live_start(&l, l.scene, "--device", "none", NULL);
    live_client c;
    live_connect(&l, &c);
    assert_int_equal(warnings_of(&c, "scene.load", json_pack("{s:s}", "file", path),
                                 "said_qs2x1a1.hdr: ignored GAMMA=2"),
                     1);
    assert_int_equal(lines_logged(&l, "said_qs2x1a1.hdr: ignored GAMMA=2"), 1);
    live_close(&c);
    live_finish(&l);
}

/* Onto the panel of the simulated device, which is upright. */
static void a_picture_is_laid_onto_the_panel_as_it_is_said(void **state)
{
    (void)state;
    char spec[PATH_MAX + 8];
    live l;
    live_prepare(&l);
    const char *path =
        lf_test_write(l.folder, "scene/wide_qs1x1a3.hdr", "#?RADIANCE\n\n-Y 1 +X 3\nabcdabcdabcd");
    snprintf(spec, sizeof spec, "sim:%s/p", l.exports);
    live_start(&l, l.scene, "--device", spec, NULL);
    live_client c;
    live_connect(&l, &c);
    assert_int_equal(warnings_of(&c, "scene.load", json_pack("{s:s}", "file", path), NULL), 0);
    assert_int_equal(warnings_of(&c, "scene.load",
                                 json_pack("{s:s, s:s}", "file", path, "photo", "fill"),
                                 "75 % of the image (aspect 3) is cropped"),
                     1);
    assert_int_equal(warnings_of(&c, "scene.load",
                                 json_pack("{s:s, s:s, s:s, s:f}", "file", path, "photo", "fill",
                                           "photo_rotate", "auto", "aspect", 4 / 3.0),
                                 NULL),
                     0);
    assert_int_equal(
        live_code(&c, "scene.load", json_pack("{s:s, s:s}", "file", path, "photo", "crop")),
        -32602);
    live_close(&c);
    live_finish(&l);
}

static void without_a_scene_nothing_may_be_read(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, NULL, "--device", "none", NULL);
    live_client c;
    live_connect(&l, &c);
    assert_int_equal(live_code(&c, "scene.load", json_pack("{s:s}", "file", l.scene)), -32001);
    live_close(&c);
    assert_int_equal(live_stop(&l), 0);
    /* An empty name is no scene, and not the root folder. */
    live_start(&l, "", "--device", "none", NULL);
    live_connect(&l, &c);
    assert_int_equal(live_code(&c, "scene.load", json_pack("{s:s}", "file", l.scene)), -32001);
    live_close(&c);
    live_finish(&l);
}

static void a_client_waits_only_so_often(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", "none", NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:b}", "paused", 1)), 0);
    for (int round = 0; round < 2; round++) {
        static const char wait[] = "{\"jsonrpc\":\"2.0\",\"id\":99,\"method\":\"wait\",\"params\":{"
                                   "\"for\":\"converged\"}}\n";
        for (int i = 0; i < 64; i++)
            live_send(&c, wait, sizeof wait - 1);
        assert_int_equal(live_code(&c, "wait", json_pack("{s:s}", "for", "converged")), -32000);
        live_close(&c);
        live_connect(&l, &c);
    }
    live_close(&c);
    live_finish(&l);
}

static void a_client_opens_simulated_panels_only_where_it_may_write(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    char spec[PATH_MAX];
    snprintf(spec, sizeof spec, "sim:%s/away", l.folder);
    assert_int_equal(live_code(&c, "device.set", json_pack("{s:s}", "spec", spec)), -32001);
    assert_int_not_equal(access(spec + 4, F_OK), 0);
    snprintf(spec, sizeof spec, "sim:%s/p", l.exports);
    assert_int_equal(live_code(&c, "device.set", json_pack("{s:s}", "spec", spec)), 0);
    assert_int_equal(live_code(&c, "device.set", json_pack("{s:s}", "spec", "none")), 0);
    assert_int_equal(live_code(&c, "device.calibration", NULL), -32003);
    assert_int_equal(live_code(&c, "device.set", json_pack("{s:s}", "spec", l.sim)), 0);
    /* What is refused leaves the panel and what it shows alone. */
    live_wait(&c, "coarse");
    double updates = live_number(&c, "status", NULL, "updates");
    assert_int_equal(live_code(&c, "device.set", json_pack("{s:s}", "spec", "toaster")), -32602);
    snprintf(spec, sizeof spec, "sim:%s/p,latensy=5", l.exports);
    assert_int_equal(live_code(&c, "device.set", json_pack("{s:s}", "spec", spec)), -32602);
    assert_true(live_number(&c, "status", NULL, "updates") >= updates);
    assert_false(live_logged(&l, "latensy"));
    assert_true(live_number(&c, "device.calibration", NULL, "screenW") == 96);
    assert_int_equal(live_code(&c, "device.set", json_pack("{s:s}", "spec", "none")), 0);
    assert_int_equal(live_code(&c, "device.set", json_pack("{s:s}", "spec", l.sim)), 0);
    assert_true(live_number(&c, "device.calibration", NULL, "screenW") == 96);
    assert_int_equal(live_code(&c, "device.list", NULL), 0);
    live_close(&c);
    live_finish(&l);
}

static void what_is_checked_of_a_spec_is_what_is_opened(void **state)
{
    enum { LIMIT = 511 };
    static const char back[] = "/../expo", rest[] = "rts/a"; /* of the folder "exports" */
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    char spec[PATH_MAX];
    /* what is beneath the export directory as a whole, and beside it when it is cut */
    size_t used = (size_t)snprintf(spec, sizeof spec, "sim:%s", l.exports);
    memset(spec + used, '/', LIMIT);
    snprintf(spec + LIMIT - strlen(back), sizeof spec - LIMIT + strlen(back), "%s%s", back, rest);
    assert_int_equal(live_code(&c, "device.set", json_pack("{s:s}", "spec", spec)), 0);
    assert_int_not_equal(access(lf_test_path(l.folder, "expo"), F_OK), 0);
    assert_int_equal(access(lf_test_path(l.exports, "a"), F_OK), 0);
    /* what is too long when everything is resolved */
    used = (size_t)snprintf(spec, sizeof spec, "sim:%s/p,latency=", l.exports);
    memset(spec + used, '0', LIMIT);
    spec[used + LIMIT] = '\0';
    assert_int_equal(live_code(&c, "device.set", json_pack("{s:s}", "spec", spec)), -32602);
    /* a path that would be taken for options */
    assert_int_equal(mkdir(lf_test_path(l.exports, "b,latency=1"), 0700), 0);
    assert_int_equal(symlink("b,latency=1", lf_test_path(l.exports, "link")), 0);
    snprintf(spec, sizeof spec, "sim:%s/link/p", l.exports);
    assert_int_equal(live_code(&c, "device.set", json_pack("{s:s}", "spec", spec)), -32001);
    assert_int_not_equal(access(lf_test_path(l.exports, "b"), F_OK), 0);
    live_close(&c);
    live_finish(&l);
}

/* A daemon under a service manager: told through a datagram socket, with a listening socket handed
 * over. */
static void systemd_hears_of_readiness_and_hands_over_a_socket(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    struct sockaddr_un ear = {.sun_family = AF_UNIX}, address = {.sun_family = AF_UNIX};
    snprintf(ear.sun_path, sizeof ear.sun_path, "%.90s/notify", l.folder);
    snprintf(address.sun_path, sizeof address.sun_path, "%.100s", l.socket);
    int notify = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0),
        listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(bind(notify, (struct sockaddr *)&ear, sizeof ear), 0);
    assert_int_equal(bind(listener, (struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(listener, 8), 0);
    pid_t pid = fork();
    if (pid == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        char number[16];
        dup2(listener, 3);
        snprintf(number, sizeof number, "%d", (int)getpid());
        setenv("LISTEN_PID", number, 1);
        setenv("LISTEN_FDS", "1", 1);
        setenv("NOTIFY_SOCKET", ear.sun_path, 1);
        execl(lf_test_built("quiltd"), "quiltd", "/nowhere/none.json", "--device", "none",
              (char *)NULL);
        _exit(127);
    }
    close(listener);
    struct timeval patience = {.tv_sec = LIVE_PATIENCE_S};
    setsockopt(notify, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    bool ready = false, said_error = false;
    while (!ready || !said_error) {
        char text[4096];
        ssize_t n = recv(notify, text, sizeof text - 1, 0);
        assert_true(n > 0);
        text[n] = '\0';
        ready = ready || strstr(text, "READY=1");
        said_error = said_error || (strstr(text, "STATUS=error") && strstr(text, "none.json"));
    }
    live_client c;
    live_connect(&l, &c);
    assert_string_equal(live_status_text(&c, "state"), "error");
    live_close(&c);
    l.pid = pid;
    assert_int_equal(live_stop(&l), 0);
    close(notify);
    /* The socket is systemd's, not the daemon's to remove. */
    assert_int_equal(access(l.socket, F_OK), 0);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hello_lists_the_methods_with_their_schemas),
        cmocka_unit_test(bad_lines_get_the_standard_errors_and_the_connection_lives_on),
        cmocka_unit_test(a_line_over_1_mib_is_refused_once_and_skipped),
        cmocka_unit_test(a_client_that_does_not_read_is_dropped_and_others_are_served),
        cmocka_unit_test(many_clients_are_served_and_too_many_are_told),
        cmocka_unit_test(a_half_closed_connection_still_gets_its_answers),
        cmocka_unit_test(a_stale_socket_is_replaced_and_a_living_one_refused),
        cmocka_unit_test(signals_shutdown_and_run_for_end_it_with_0),
        cmocka_unit_test(wrong_usage_is_2),
        cmocka_unit_test(quiltctl_calls_and_prints),
        cmocka_unit_test(reads_stay_beneath_the_scene_and_the_allowed_paths),
        cmocka_unit_test(what_a_scene_lacks_is_told_with_the_answer_and_logged_once),
        cmocka_unit_test(what_a_quilt_says_in_vain_is_told_and_logged),
        cmocka_unit_test(a_picture_is_laid_onto_the_panel_as_it_is_said),
        cmocka_unit_test(without_a_scene_nothing_may_be_read),
        cmocka_unit_test(a_client_waits_only_so_often),
        cmocka_unit_test(a_client_opens_simulated_panels_only_where_it_may_write),
        cmocka_unit_test(what_is_checked_of_a_spec_is_what_is_opened),
        cmocka_unit_test(systemd_hears_of_readiness_and_hands_over_a_socket),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
