/* log.tail and the notification log, against what the daemon writes to stderr. */
#include "tests/daemon/sender.h"

/* The text of the i-th line of the daemon's stderr, without its name; NULL: there are fewer. */
static const char *line_of_stderr(const live *l, int i)
{
    static char line[4096];
    FILE *file = fopen(l->log, "r");
    const char *text = NULL;
    assert_non_null(file);
    for (; i >= 0 && fgets(line, sizeof line, file); i--) {
        line[strcspn(line, "\n")] = '\0';
        assert_ptr_equal(strstr(line, "quiltd: "), line);
        text = i == 0 ? line + strlen("quiltd: ") : NULL;
    }
    fclose(file);
    return text;
}

static json_t *tail(live_client *c, json_t *params)
{
    json_t *answer = live_call(c, "log.tail", params);
    json_t *lines = json_object_get(json_object_get(answer, "result"), "lines");
    assert_true(json_is_array(lines));
    json_incref(lines);
    json_decref(answer);
    return lines;
}

static const char *text_of(const json_t *line, const char *key)
{
    return json_string_value(json_object_get(line, key));
}

/* A scene that is shown is a line in the log. */
static void log_one(const live *l, live_client *c)
{
    assert_int_equal(live_code(c, "scene.load", json_pack("{s:s}", "file", l->scene)), 0);
}

static void begin_log(live *l, live_client *c)
{
    live_prepare(l);
    live_start(l, l->scene, "--device", "none", NULL);
    live_connect(l, c);
    live_wait(c, "complete");
}

static void the_tail_is_what_stderr_has(void **state)
{
    (void)state;
    live l;
    live_client c;
    begin_log(&l, &c);
    log_one(&l, &c);
    assert_int_equal(live_code(&c, "render.set", json_pack("{s:b}", "paused", 1)), 0);
    json_t *lines = tail(&c, NULL);
    const int n = (int)json_array_size(lines);
    assert_true(n >= 2);
    for (int i = 0; i < n; i++) {
        const json_t *line = json_array_get(lines, (size_t)i);
        assert_int_equal(json_integer_value(json_object_get(line, "number")), i + 1);
        assert_string_equal(text_of(line, "text"), line_of_stderr(&l, i));
        assert_true(json_real_value(json_object_get(line, "time")) > 1e9);
    }
    assert_null(line_of_stderr(&l, n));
    assert_string_equal(text_of(json_array_get(lines, 0), "level"), "info");
    /* fewer: the last ones */
    json_t *two = tail(&c, json_pack("{s:i}", "lines", 2));
    assert_int_equal(json_array_size(two), 2);
    for (size_t i = 0; i < 2; i++)
        assert_true(json_equal(json_array_get(two, i), json_array_get(lines, (size_t)n - 2 + i)));
    json_decref(two);
    json_decref(lines);
    assert_int_equal(live_code(&c, "log.tail", json_pack("{s:i}", "lines", 0)), -32602);
    assert_int_equal(live_code(&c, "log.tail", json_pack("{s:i}", "lines", 201)), -32602);
    live_close(&c);
    live_finish(&l);
}

static void subscribers_get_every_new_line_once_and_in_order(void **state)
{
    (void)state;
    live l;
    live_client c, other;
    begin_log(&l, &c);
    live_connect(&l, &other);
    assert_int_equal(live_code(&c, "subscribe", json_pack("{s:[s]}", "events", "log")), 0);
    enum { LINES = 20 };
    json_t *before = tail(&other, json_pack("{s:i}", "lines", 1));
    json_int_t number = json_integer_value(json_object_get(json_array_get(before, 0), "number"));
    json_decref(before);
    for (int i = 0; i < LINES; i++)
        log_one(&l, &other);
    for (int i = 0; i < LINES; i++) {
        json_t *message = live_receive(&c);
        const json_t *line = json_object_get(message, "params");
        assert_string_equal(text_of(message, "method"), "log");
        assert_int_equal(json_integer_value(json_object_get(line, "number")), ++number);
        assert_non_null(strstr(text_of(line, "text"), "fog.json: generation "));
        json_decref(message);
    }
    live_close(&other);
    live_close(&c);
    live_finish(&l);
}

/* A call fails with this code; its message begins with these words, and the log has one line that
 * says the same after `method`. 0 lines: the log stays as it is. Returns the answer's data. */
static json_t *failure(sender *s, const char *method, json_t *params, const int *fds, int n_fds,
                       int code, const char *words, int n_lines)
{
    json_t *before = tail(&s->c, NULL);
    json_t *answer = call_with(s, method, params, fds, n_fds), *after = tail(&s->c, NULL);
    json_t *error = json_object_get(answer, "error"), *data = json_object_get(error, "data");
    const char *message = text_of(error, "message");
    const size_t n = json_array_size(after);
    char line[2048];
    assert_int_equal(json_integer_value(json_object_get(error, "code")), code);
    if (strstr(message, words) != message)
        fail_msg("%s: %s, not %s", method, message, words);
    assert_int_equal(n - json_array_size(before), n_lines);
    if (n_lines > 0) {
        bool named = strstr(message, method) == message;
        snprintf(line, sizeof line, "%s%s%s", named ? "" : method, named ? "" : ": ", message);
        assert_string_equal(text_of(json_array_get(after, n - 1), "text"), line);
        assert_string_equal(text_of(json_array_get(after, n - 1), "level"), "error");
    }
    json_incref(data);
    json_decref(answer);
    json_decref(before);
    json_decref(after);
    return data;
}

static void expect_failure(sender *s, const char *method, json_t *params, int code,
                           const char *words, int n_lines)
{
    json_decref(failure(s, method, params, NULL, 0, code, words, n_lines));
}

static void a_patch_that_fails_names_the_method_and_the_pointer(void **state)
{
    (void)state;
    sender s;
    begin(&s);
    json_t *patch = json_pack("{s:{s:{s:{s:i}}}}", "patch", "lights", "sky", "radianc", 1);
    json_t *data = failure(&s, "scene.patch", patch, NULL, 0, -32002,
                           "scene.patch: /lights/sky/radianc: unknown key", 1);
    assert_string_equal(text_of(data, "file"), s.l.scene);
    assert_string_equal(text_of(data, "pointer"), "/lights/sky/radianc");
    json_decref(data);
    /* a file of the patch */
    patch = json_pack("{s:{s:{s:{s:s}}}}", "patch", "meshes", "ball", "file", "none.obj");
    expect_failure(&s, "scene.patch", patch, -32002, "scene.patch: /meshes/ball/file: ", 1);
    json_t *at = json_pack("{s:[i,i,i], s:[i,i,i]}", "position", 1, 1, 1, "target", 1, 1, 1);
    expect_failure(&s, "camera.set", at, -32002, "camera.set: /camera", 1);
    end(&s);
}

static void loads_that_fail_are_in_the_log_once(void **state)
{
    (void)state;
    sender s;
    begin(&s);
    char words[PATH_MAX + 32], scenes[PATH_MAX], file[PATH_MAX];
    snprintf(scenes, sizeof scenes, "%s/scene", s.l.folder);
    snprintf(file, sizeof file, "%s", lf_test_write(scenes, "bad.json", "{\"camra\":{}}"));
    snprintf(words, sizeof words, "%s:1: /camra: unknown key", file);
    expect_failure(&s, "scene.load", json_pack("{s:s}", "file", file), -32002, words, 1);
    expect_failure(&s, "scene.load", json_pack("{s:s}", "file", "none.json"), -32002, "", 1);
    expect_failure(&s, "scene.load", json_pack("{s:s}", "file", "/etc/passwd"), -32001,
                   "/etc/passwd: is outside", 1);
    int fd = memory_file("no image", 8, ALL_SEALS);
    json_decref(failure(&s, "quilt.show", json_pack("{s:i,s:i}", "columns", 2, "rows", 1), &fd, 1,
                        -32002, "", 1));
    end(&s);
}

static void wrong_parameters_are_not_in_the_log(void **state)
{
    (void)state;
    sender s;
    begin(&s);
    expect_failure(&s, "scene.load", json_object(), -32602, "scene.load: ", 0);
    expect_failure(&s, "scene.load", json_pack("{s:s}", "fil", "a"), -32602, "scene.load: ", 0);
    expect_failure(&s, "camera.fit", json_pack("{s:s}", "name", "nobody"), -32602, "", 0);
    expect_failure(&s, "quilt.show", json_pack("{s:i,s:i}", "columns", 2, "rows", 1), -32602,
                   "quilt.show: ", 0);
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_tail_is_what_stderr_has),
        cmocka_unit_test(subscribers_get_every_new_line_once_and_in_order),
        cmocka_unit_test(a_patch_that_fails_names_the_method_and_the_pointer),
        cmocka_unit_test(loads_that_fail_are_in_the_log_once),
        cmocka_unit_test(wrong_parameters_are_not_in_the_log),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
