/* rights.limit: what a connection may call after it, and that nothing gives rights back. */
#include "tests/daemon/live.h"

typedef struct limited {
    live l;
    live_client c;
} limited;

static void begin(limited *t)
{
    live_prepare(&t->l);
    live_start(&t->l, t->l.scene, "--device", "none", NULL);
    live_connect(&t->l, &t->c);
    live_wait(&t->c, "coarse");
}

static void end(limited *t)
{
    live_close(&t->c);
    live_finish(&t->l);
}

/* {"methods": [the words of names]} */
static json_t *only(const char *names)
{
    json_t *list = json_array();
    char text[256], *rest = text;
    snprintf(text, sizeof text, "%s", names);
    for (const char *name; names[0] != '\0' && (name = strsep(&rest, " "));)
        json_array_append_new(list, json_string(name));
    return json_pack("{s:o}", "methods", list);
}

/* The next answer has this code and is one line with these words. */
static void assert_refused(live_client *c, int code, const char *words)
{
    json_t *answer = live_receive(c);
    const json_t *error = json_object_get(answer, "error");
    const char *said = json_string_value(json_object_get(error, "message"));
    if (json_integer_value(json_object_get(error, "code")) != code || !said ||
        !strstr(said, words) || strchr(said, '\n'))
        fail_msg("%d \"%s\": %s", code, words, said ? said : "a result");
    json_decref(answer);
}

static void refuse(limited *t, const char *method, json_t *params, int code, const char *words)
{
    live_ask(&t->c, method, params);
    assert_refused(&t->c, code, words);
}

static int count(const json_t *result, const char *key)
{
    return (int)json_object_size(json_object_get(result, key));
}

static json_t *result_of(json_t *answer)
{
    json_t *result = json_incref(json_object_get(answer, "result"));
    assert_non_null(result);
    json_decref(answer);
    return result;
}

static void a_limited_connection_calls_only_the_listed_methods(void **state)
{
    (void)state;
    limited t;
    live_client other;
    begin(&t);
    live_connect(&t.l, &other);
    json_t *all = result_of(live_call(&t.c, "hello", NULL));
    assert_true(json_is_false(json_object_get(all, "limited")));
    json_t *now = result_of(live_call(&t.c, "rights.limit", only("wait hello hello camera.orbit")));
    json_t *names = json_pack("[s, s, s]", "hello", "camera.orbit", "wait");
    assert_true(json_equal(json_object_get(now, "methods"), names));
    json_decref(now);
    now = result_of(live_call(&t.c, "hello", NULL));
    assert_true(json_is_true(json_object_get(now, "limited")));
    assert_int_equal(count(now, "methods"), 3);
    for (size_t i = 0; i < 3; i++) {
        const char *name = json_string_value(json_array_get(names, i));
        assert_true(json_equal(json_object_get(json_object_get(now, "methods"), name),
                               json_object_get(json_object_get(all, "methods"), name)));
    }
    assert_int_equal(count(now, "events"), 0);
    assert_int_equal(live_code(&t.c, "camera.orbit", json_pack("{s:i}", "yaw", 5)), 0);
    refuse(&t, "status", NULL, -32601, "may not call \"status\"");
    refuse(&t, "shutdown", NULL, -32601, "may not call \"shutdown\"");
    /* no hint at what it may not call */
    refuse(&t, "statu", NULL, -32601, "there is no method \"statu\"; hello");
    refuse(&t, "hallo", NULL, -32601, "did you mean \"hello\"");
    /* it is the connection that is limited */
    json_t *whole = result_of(live_call(&other, "hello", NULL));
    assert_true(json_equal(whole, all));
    json_decref(whole);
    json_decref(all);
    json_decref(now);
    json_decref(names);
    live_close(&other);
    end(&t);
}

static void a_call_in_the_same_packet_is_limited(void **state)
{
    (void)state;
    static const char lines[] =
        "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"status\"}\n"
        "{\"jsonrpc\":\"2.0\",\"method\":\"rights.limit\",\"params\":{\"methods\":[\"wait\"]}}\n"
        "{\"jsonrpc\":\"2.0\",\"method\":\"shutdown\"}\n"
        "{\"jsonrpc\":\"2.0\",\"id\":2,\"method\":\"status\"}\n"
        "{\"jsonrpc\":\"2.0\",\"id\":3,\"method\":\"wait\"}\n";
    limited t;
    begin(&t);
    live_send(&t.c, lines, sizeof lines - 1);
    json_decref(result_of(live_receive(&t.c)));
    assert_refused(&t.c, -32601, "may not call \"status\"");
    json_decref(result_of(live_receive(&t.c)));
    end(&t);
}

/* A line that another thread parses keeps its place among the short ones. */
static void a_long_line_after_it_is_limited(void **state)
{
    (void)state;
    enum { LONG = 20000 };
    limited t;
    begin(&t);
    char *name = malloc(LONG + 1);
    memset(name, 'x', LONG);
    name[LONG] = '\0';
    live_ask(&t.c, "rights.limit", only("hello"));
    live_ask(&t.c, "scene.load", json_pack("{s:s}", "file", name));
    live_ask(&t.c, "hello", NULL);
    json_decref(result_of(live_receive(&t.c)));
    assert_refused(&t.c, -32601, "may not call \"scene.load\"");
    json_decref(result_of(live_receive(&t.c)));
    free(name);
    end(&t);
}

static void a_wrong_list_changes_nothing(void **state)
{
    (void)state;
    limited t;
    begin(&t);
    refuse(&t, "rights.limit", only("hello statu"), -32602,
           "rights.limit: /methods/1: there is no method \"statu\"; did you mean \"status\"?");
    refuse(&t, "rights.limit", only("hello frobnicate.everything"), -32602,
           "rights.limit: /methods/1: there is no method");
    refuse(&t, "rights.limit", json_pack("{s:[i]}", "methods", 1), -32602, "/methods/0");
    refuse(&t, "rights.limit", NULL, -32602, "methods");
    assert_int_equal(live_code(&t.c, "status", NULL), 0);
    end(&t);
}

static void rights_only_shrink(void **state)
{
    (void)state;
    limited t;
    begin(&t);
    assert_int_equal(live_code(&t.c, "rights.limit", only("rights.limit hello wait")), 0);
    refuse(&t, "rights.limit", only("hello status"), -32602,
           "rights.limit: /methods/1: this connection may not call \"status\"");
    refuse(&t, "status", NULL, -32601, "may not call \"status\"");
    assert_int_equal(live_code(&t.c, "rights.limit", only("hello")), 0);
    refuse(&t, "wait", NULL, -32601, "may not call \"wait\"");
    refuse(&t, "rights.limit", only("hello"), -32601, "may not call \"rights.limit\"");
    assert_int_equal(live_code(&t.c, "hello", NULL), 0);
    end(&t);
}

static void nothing_may_be_left(void **state)
{
    (void)state;
    limited t;
    begin(&t);
    assert_int_equal(live_code(&t.c, "rights.limit", only("")), 0);
    refuse(&t, "hello", NULL, -32601, "may not call \"hello\"");
    end(&t);
}

/* The first message after a scene was loaded: the notification "scene", or the answer of hello. */
static bool hears_of_a_scene(limited *t)
{
    live_client other;
    live_connect(&t->l, &other);
    assert_int_equal(live_code(&other, "scene.load", json_pack("{s:s}", "file", t->l.scene)), 0);
    live_close(&other);
    live_ask(&t->c, "hello", NULL);
    json_t *message = live_receive(&t->c);
    const bool heard = json_object_get(message, "method");
    json_decref(heard ? live_answer(&t->c) : NULL);
    json_decref(message);
    return heard;
}

static void notifications_end_without_subscribe(void **state)
{
    (void)state;
    limited t;
    begin(&t);
    assert_int_equal(live_code(&t.c, "subscribe", json_pack("{s:[s]}", "events", "scene")), 0);
    assert_int_equal(live_code(&t.c, "rights.limit", only("hello subscribe rights.limit export")),
                     0);
    assert_true(hears_of_a_scene(&t));
    json_t *now = result_of(live_call(&t.c, "hello", NULL));
    assert_true(count(now, "events") > 5);
    json_decref(now);
    assert_int_equal(live_code(&t.c, "rights.limit", only("hello export")), 0);
    assert_false(hears_of_a_scene(&t));
    /* the progress of its own exports still comes */
    now = result_of(live_call(&t.c, "hello", NULL));
    assert_int_equal(count(now, "events"), 1);
    assert_non_null(json_object_get(json_object_get(now, "events"), "export"));
    json_decref(now);
    end(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_limited_connection_calls_only_the_listed_methods),
        cmocka_unit_test(a_call_in_the_same_packet_is_limited),
        cmocka_unit_test(a_long_line_after_it_is_limited),
        cmocka_unit_test(a_wrong_list_changes_nothing),
        cmocka_unit_test(rights_only_shrink),
        cmocka_unit_test(nothing_may_be_left),
        cmocka_unit_test(notifications_end_without_subscribe),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
