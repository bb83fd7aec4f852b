/* What hello says of methods, answers and notifications: whole, and true of a running daemon. */
#include "tests/daemon/live.h"

#include "daemon/server/methods.h"
#include "daemon/wire/rpc.h"

static int count_words(const char *text)
{
    int n = 0;
    for (bool inside = false; text && *text; text++) {
        n += *text != ' ' && !inside;
        inside = *text != ' ';
    }
    return n;
}

static bool is_number(const json_t *schema)
{
    const json_t *type = json_object_get(schema, "type");
    size_t i;
    json_t *word;
    json_array_foreach((json_t *)(uintptr_t)type, i, word)
    {
        if (strstr("integer number", json_string_value(word)))
            return true;
    }
    return json_is_string(type) && strstr("integer number", json_string_value(type));
}

/* Two words at least, and of a number a unit, a range or the numbers that it may be. */
static void check_described(const char *of, json_t *properties)
{
    const char *key;
    json_t *schema;
    json_object_foreach(properties, key, schema)
    {
        const char *text = json_string_value(json_object_get(schema, "description"));
        if (count_words(text) < 2)
            fail_msg("%s: %s is described as \"%s\"", of, key, text ? text : "");
        if (is_number(schema) && !json_object_get(schema, "unit") &&
            !json_object_get(schema, "minimum") && !json_object_get(schema, "enum"))
            fail_msg("%s: %s has neither a unit nor a range", of, key);
        check_described(of, json_object_get(schema, "properties"));
        check_described(of, json_object_get(json_object_get(schema, "items"), "properties"));
    }
}

static void every_parameter_and_field_is_described(void **state)
{
    (void)state;
    const char *name;
    json_t *entry;
    json_object_foreach(lf_methods_json(), name, entry)
    {
        const json_t *params = json_object_get(entry, "params");
        const json_t *result = json_object_get(entry, "result");
        if (!result)
            fail_msg("%s: nothing is said of its answer", name);
        check_described(name, json_object_get(params, "properties"));
        check_described(name, json_object_get(result, "properties"));
    }
    json_object_foreach(lf_events_json(), name, entry)
    {
        const json_t *params = json_object_get(entry, "params");
        if (!params)
            fail_msg("%s: nothing is said of its fields", name);
        check_described(name, json_object_get(params, "properties"));
    }
}

static json_t *schema_of(const char *method)
{
    json_t *entry = json_object_get(lf_methods_json(), method);
    assert_non_null(entry);
    return json_object_get(entry, "params");
}

static void every_event_of_subscribe_is_a_notification(void **state)
{
    (void)state;
    const json_t *words = json_object_get(
        json_object_get(
            json_object_get(json_object_get(schema_of("subscribe"), "properties"), "events"),
            "items"),
        "enum");
    size_t i;
    json_t *word, *entry;
    const char *name;
    assert_true(json_array_size(words) > 0);
    json_array_foreach((json_t *)(uintptr_t)words, i, word)
    {
        if (!json_object_get(lf_events_json(), json_string_value(word)))
            fail_msg("%s is no notification", json_string_value(word));
    }
    json_object_foreach(lf_events_json(), name, entry)
    {
        const char *event = json_string_value(json_object_get(entry, "event"));
        bool found = false;
        json_array_foreach((json_t *)(uintptr_t)words, i, word)
        {
            found = found || strcmp(json_string_value(word), event) == 0;
        }
        if (!found)
            fail_msg("%s: nobody can subscribe to %s", name, event);
    }
}

static void every_example_is_a_call_that_its_schema_takes(void **state)
{
    (void)state;
    for (int i = 0; lf_method_at(i); i++) {
        const lf_method *method = lf_method_at(i);
        char text[256], *rest = text;
        json_t *params = json_object();
        lf_error err;
        snprintf(text, sizeof text, "%s", method->example);
        assert_string_equal(strsep(&rest, " "), method->name);
        if (strcmp(method->name, "frame.get") == 0 || strcmp(method->name, "quilt.show") == 0 ||
            strcmp(method->name, "library.thumbnail") == 0)
            assert_null(strchr(strsep(&rest, " "), '=')); /* quiltctl's file */
        for (const char *word; (word = strsep(&rest, " "));)
            lf_assert_ok(lf_schema_argument(lf_method_schema(i), word, params, &err), &err);
        lf_assert_ok(lf_schema_check(lf_method_schema(i), params, method->name, &err), &err);
        json_decref(params);
    }
}

/* Defaults, too, are values that the schema allows. */
static void every_default_is_allowed(void **state)
{
    (void)state;
    int n = 0;
    for (int i = 0; lf_method_at(i); i++) {
        const char *key;
        json_t *property;
        json_object_foreach(json_object_get(lf_method_schema(i), "properties"), key, property)
        {
            json_t *value = json_object_get(property, "default");
            lf_error err;
            if (value)
                lf_assert_ok(lf_schema_check(property, value, key, &err), &err);
            n += value ? 1 : 0;
        }
    }
    assert_true(n > 10);
}

/* -------------------------------------------------------------------------- a running daemon -- */

/* What is said has only keys that the schema lists, of types that it allows. */
static void check_said(const char *of, const json_t *schema, json_t *value)
{
    json_t *properties = json_object_get(schema, "properties"), *member;
    const char *key;
    size_t i;
    json_array_foreach(value, i, member)
    {
        check_said(of, json_object_get(schema, "items"), member);
    }
    if (!properties)
        return;
    json_object_foreach(value, key, member)
    {
        json_t *property = json_object_get(properties, key);
        lf_error err;
        if (!property)
            fail_msg("%s: hello does not list %s", of, key);
        json_t *plain = json_pack("{s:O}", "type", json_object_get(property, "type"));
        if (lf_schema_check(plain, member, key, &err) != LF_OK && json_is_object(member) == 0)
            fail_msg("%s: %s: %s", of, key, err.what);
        json_decref(plain);
        check_said(of, property, member);
    }
}

typedef struct listener {
    live l;
    live_client c;
    const char *seen[16]; /* notifications */
    int n;
} listener;

static void take_notification(listener *t, const json_t *message)
{
    const char *name = json_string_value(json_object_get(message, "method"));
    const json_t *entry = json_object_get(lf_events_json(), name);
    if (!entry)
        fail_msg("hello lists no notification %s", name);
    check_said(name, json_object_get(entry, "params"), json_object_get(message, "params"));
    for (int i = 0; i < t->n; i++)
        if (strcmp(t->seen[i], name) == 0)
            return;
    for (int i = 0; lf_notification_at(i); i++)
        if (strcmp(lf_notification_at(i)->name, name) == 0)
            t->seen[t->n++] = lf_notification_at(i)->name;
}

/* The answer (a new reference), which must be as hello says. */
static json_t *ask(listener *t, const char *method, json_t *params)
{
    live_ask(&t->c, method, params);
    for (;;) {
        json_t *message = live_receive(&t->c);
        assert_non_null(message);
        if (!json_object_get(message, "id")) {
            take_notification(t, message);
            json_decref(message);
            continue;
        }
        json_t *result = json_object_get(message, "result");
        if (!result)
            fail_msg(
                "%s: %s", method,
                json_string_value(json_object_get(json_object_get(message, "error"), "message")));
        check_said(method, json_object_get(json_object_get(lf_methods_json(), method), "result"),
                   result);
        json_incref(result);
        json_decref(message);
        return result;
    }
}

static void do_ask(listener *t, const char *method, json_t *params)
{
    json_decref(ask(t, method, params));
}

static bool has_seen(const listener *t, const char *name)
{
    for (int i = 0; i < t->n; i++)
        if (strcmp(t->seen[i], name) == 0)
            return true;
    return false;
}

static void a_running_daemon_says_what_hello_lists(void **state)
{
    (void)state;
    listener t = {0};
    live_prepare(&t.l);
    assert_int_equal(mkdir(t.l.exports, 0700), 0);
    live_start(&t.l, t.l.scene, "--device", t.l.sim, NULL);
    live_connect(&t.l, &t.c);
    json_t *hello = ask(&t, "hello", NULL);
    assert_true(json_equal(json_object_get(hello, "methods"), lf_methods_json()));
    assert_true(json_equal(json_object_get(hello, "events"), lf_events_json()));
    json_decref(hello);
    do_ask(&t, "subscribe",
           json_pack("{s:[s,s,s,s,s,s,s,s]}", "events", "frame", "converged", "device", "scene",
                     "export", "button", "log", "playlist"));
    do_ask(&t, "wait", json_pack("{s:s}", "for", "coarse"));
    do_ask(&t, "status", NULL);
    do_ask(&t, "scene.get", NULL);
    do_ask(&t, "scene.load", json_pack("{s:s}", "file", t.l.scene));
    do_ask(&t, "scene.patch", json_pack("{s:{s:{s:f}}}", "patch", "film", "exposure", 0.5));
    do_ask(&t, "camera.set", json_pack("{s:i}", "fov_y", 15));
    do_ask(&t, "camera.orbit", json_pack("{s:i}", "yaw", 1));
    do_ask(&t, "camera.fit", NULL);
    do_ask(&t, "time.stop", NULL);
    do_ask(&t, "render.set", json_pack("{s:f}", "target_error", 0.5));
    do_ask(&t, "device.list", NULL);
    do_ask(&t, "device.calibration", NULL);
    do_ask(&t, "log.tail", NULL);
    do_ask(&t, "library.list", NULL);
    do_ask(&t, "library.list", json_pack("{s:s}", "folder", lf_test_path(t.l.folder, "scene")));
    do_ask(&t, "playlist.set",
           json_pack("{s:[{s:s, s:i}]}", "entries", "file", t.l.scene, "seconds", 9));
    do_ask(&t, "playlist.get", NULL);
    do_ask(&t, "status", NULL);
    do_ask(&t, "doctor", NULL);
    do_ask(&t, "button", json_pack("{s:s}", "name", "square"));
    do_ask(&t, "button", json_pack("{s:s}", "name", "square"));
    do_ask(&t, "export", json_pack("{s:s, s:s}", "kind", "panel", "file", "panel.png"));
    do_ask(&t, "status", NULL);
    do_ask(&t, "wait", json_pack("{s:s}", "for", "converged"));
    do_ask(&t, "device.set", json_pack("{s:s, s:f}", "spec", "none", "gamma", 2.2));
    do_ask(&t, "status", NULL);
    for (int i = 0; lf_notification_at(i); i++)
        if (!has_seen(&t, lf_notification_at(i)->name) &&
            strcmp(lf_notification_at(i)->name, "scene.load") != 0)
            fail_msg("there was no notification %s", lf_notification_at(i)->name);
    do_ask(&t, "rights.limit", json_pack("{s:[s, s]}", "methods", "hello", "shutdown"));
    do_ask(&t, "hello", NULL);
    do_ask(&t, "shutdown", NULL);
    assert_int_equal(live_reap(t.l.pid), 0);
    t.l.pid = 0;
    live_close(&t.c);
    live_finish(&t.l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_parameter_and_field_is_described),
        cmocka_unit_test(every_event_of_subscribe_is_a_notification),
        cmocka_unit_test(every_example_is_a_call_that_its_schema_takes),
        cmocka_unit_test(every_default_is_allowed),
        cmocka_unit_test(a_running_daemon_says_what_hello_lists),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
