/* What quiltctl says to people: help of methods, the line of watch. */
#include "tests/daemon/live.h"

#include "daemon/server/methods.h"
#include "daemon/tools/ctl.h"

static const char *line_of(json_t *status)
{
    char *line = lf_test_buffer();
    lf_ctl_watch_line(status, line);
    json_decref(status);
    return line;
}

static json_t *rendering(const char *state, json_t *error, double target, json_t *left)
{
    return json_pack(
        "{s:s, s:s, s:b, s:f, s:f, s:o, s:f, s:o, s:n, s:{s:s, s:s}, s:{s:i, s:s}, s:i}", "state",
        state, "scene", "/a/fog.json", "is_quilt", 0, "seconds", 12.0, "passes", 34.0,
        "error_estimate", error, "target_error", target, "seconds_left", left, "load", "device",
        "kind", "sim", "problem", "", "shown", "generation", 3, "level", "complete", "generation",
        3);
}

static void the_line_of_watch_says_what_a_person_wants_to_know(void **state)
{
    (void)state;
    assert_string_equal(line_of(rendering("rendering", json_real(0.02), 0.01, json_real(11.7))),
                        "fog.json: rendering, 12 s, 34 passes, error 0.02, about 12 s left to "
                        "0.01; on the panel: complete");
    assert_string_equal(line_of(rendering("rendering", json_null(), 0.01, json_null())),
                        "fog.json: rendering, 12 s, 34 passes; on the panel: complete");
    assert_string_equal(line_of(rendering("paused", json_real(0.02), 0.01, json_null())),
                        "fog.json: paused, 12 s, 34 passes, error 0.02; on the panel: complete");
    assert_string_equal(line_of(rendering("converged", json_real(0.009), 0.01, json_integer(0))),
                        "fog.json: finished, 12 s, 34 passes, error 0.009; on the panel: complete");
    json_t *status = rendering("rendering", json_real(1), 1e-4, json_real(119880));
    json_object_set_new(status, "generation", json_integer(4));
    assert_string_equal(line_of(status), "fog.json: rendering, 12 s, 34 passes, error 1, about "
                                         "33.3 h left to 0.0001; not on the panel yet");
    assert_string_equal(line_of(json_pack("{s:s, s:n}", "state", "idle", "scene")), "no scene");
    assert_string_equal(line_of(json_pack("{s:s, s:{s:s}}", "state", "error", "error", "message",
                                          "fog.json:3: bad")),
                        "error: fog.json:3: bad");
    assert_string_equal(line_of(json_pack("{s:s, s:{s:s}, s:{s:s, s:i, s:f}}", "state", "idle",
                                          "load", "file", "/a/fog.json", "reading", "file",
                                          "/a/fog.vdb", "bytes", 2500000, "seconds", 120.0)),
                        "loading: reading fog.vdb (2.5 MB) for 2 min");
}

/* stdout of quiltctl with these words. */
static const char *said(const char *words, int *out_code)
{
    char command[2 * PATH_MAX];
    char *text = lf_test_buffer();
    snprintf(command, sizeof command, "%s %s 2>&1", lf_test_built("quiltctl"), words);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    text[fread(text, 1, PATH_MAX - 1, pipe)] = '\0';
    while (fgetc(pipe) != EOF)
        continue;
    *out_code = WEXITSTATUS(pclose(pipe));
    return text;
}

static void a_method_has_help_without_a_daemon(void **state)
{
    (void)state;
    static const char *const words[] = {"Example: quiltctl wait ",
                                        "for=coarse|complete|converged",
                                        "(default coarse)",
                                        "timeout=NUMBER",
                                        "0.001 to 1e+09 seconds",
                                        "Answer:",
                                        "level",
                                        NULL};
    int code;
    const char *text = said("--socket /nowhere wait --help", &code);
    assert_int_equal(code, 0);
    for (int i = 0; words[i]; i++)
        if (!strstr(text, words[i]))
            fail_msg("\"%s\" is not in: %s", words[i], text);
    for (int i = 0; lf_method_at(i); i++) {
        char line[128];
        snprintf(line, sizeof line, "%s --help", lf_method_at(i)->name);
        text = said(line, &code);
        assert_int_equal(code, 0);
        if (!strstr(text, lf_method_at(i)->summary))
            fail_msg("%s: %s", line, text);
    }
    text = said("--help", &code);
    assert_non_null(strstr(text, "Usage:"));
    assert_non_null(strstr(text, "|pictures|"));
    assert_non_null(strstr(text, "--completion SHELL"));
}

static void hello_prints_the_words_that_are_allowed(void **state)
{
    (void)state;
    live l;
    char words[PATH_MAX];
    int code;
    live_prepare(&l);
    live_start(&l, NULL, "--device", "none", NULL);
    snprintf(words, sizeof words, "--socket %s hello", l.socket);
    const char *text = said(words, &code);
    assert_int_equal(code, 0);
    assert_non_null(strstr(text, "for=coarse|complete|converged"));
    assert_non_null(strstr(text, "yaw=NUMBER  degrees"));
    assert_non_null(strstr(text, "target=X,Y,Z"));
    assert_null(strstr(text, "=..."));
    live_finish(&l);
}

static void watch_writes_a_line_where_stdout_is_no_terminal(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", "none", NULL);
    char *args[] = {(char *)(uintptr_t)lf_test_built("quiltctl"), (char *)(uintptr_t) "--socket",
                    l.socket, (char *)(uintptr_t) "watch", NULL};
    const pid_t pid = live_spawn(&l, args);
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && !live_logged(&l, "fog.json: rendering"); i++)
        live_nap(20);
    assert_true(live_logged(&l, "fog.json: rendering"));
    kill(pid, SIGINT);
    assert_int_equal(live_reap(pid), 0);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_line_of_watch_says_what_a_person_wants_to_know),
        cmocka_unit_test(a_method_has_help_without_a_daemon),
        cmocka_unit_test(hello_prints_the_words_that_are_allowed),
        cmocka_unit_test(watch_writes_a_line_where_stdout_is_no_terminal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
