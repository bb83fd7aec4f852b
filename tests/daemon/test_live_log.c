/* log.tail and the notification log, against what the daemon writes to stderr. */
#include "tests/daemon/live.h"

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

static void begin(live *l, live_client *c)
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
    begin(&l, &c);
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
    begin(&l, &c);
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_tail_is_what_stderr_has),
        cmocka_unit_test(subscribers_get_every_new_line_once_and_in_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
