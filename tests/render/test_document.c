/* Documents of scenes: how large they may be, and what they share with what they were made of. */
#include "tests/testing.h"

#include "render/import/scene/json_size.h"
#include "render/import/scene/scene_include.h"
#include "render/render.h"

static json_t *parsed(const char *text)
{
    json_t *value = json_loads(text, JSON_DECODE_ANY, NULL);
    assert_non_null(value);
    return value;
}

static size_t least_of(const char *text)
{
    json_t *value = parsed(text);
    size_t n = lf_json_least_bytes(value);
    json_decref(value);
    return n;
}

/* Texts that cannot be shorter are counted as they are, longer ones as the shortest. */
static void the_least_bytes_are_those_of_the_shortest_text(void **state)
{
    (void)state;
    static const char *const shortest[] = {"{}",          "[]",
                                           "0",           "-1",
                                           "10",          "-9223372036854775808",
                                           "true",        "false",
                                           "null",        "\"\"",
                                           "\"abc\"",     "0.5",
                                           "1e9",         "[1,2,[]]",
                                           "{\"a\":1}",   "{\"a\":[1,22],\"bc\":{\"d\":null}}",
                                           "\"\xc3\xa4\""};
    for (size_t i = 0; i < sizeof shortest / sizeof *shortest; i++)
        assert_int_equal(least_of(shortest[i]), strlen(shortest[i]));
    assert_int_equal(least_of(" { \"a\" : [ 1 , 2 ] } "), strlen("{\"a\":[1,2]}"));
    assert_int_equal(least_of("\"\\u0041\""), strlen("\"A\""));
    assert_int_equal(least_of("0.1234567890123"), 3);
    assert_int_equal(lf_json_least_bytes(NULL), 0);
}

/* A scene of so many bytes: keys of its camera, the last value of which has as many digits as are
 * missing. */
static json_t *document_of(size_t bytes)
{
    json_t *doc =
               parsed("{\"quiltd\":1,\"camera\":{\"position\":{\"keys\":[]}},\"lights\":{\"sky\":{"
                      "\"type\":\"environment\",\"radiance\":1}}}"),
           *keys =
               json_object_get(json_object_get(json_object_get(doc, "camera"), "position"), "keys");
    size_t n = lf_json_least_bytes(doc);
    for (int i = 0; n + 64 < bytes; i++) {
        json_t *key = json_pack("[i, [i, i, i]]", i, 0, 0, 9);
        n += lf_json_least_bytes(key) + (i > 0 ? 1 : 0);
        json_array_append_new(keys, key);
    }
    json_t *last = json_pack("[i, [i, i, i]]", 999999, 0, 0, 9);
    json_array_append_new(keys, last);
    json_t *values = json_array_get(last, 1);
    for (size_t i = 0; i < 3; i++) {
        size_t missing = bytes - lf_json_least_bytes(doc);
        json_int_t value = i == 2 ? 9 : 1;
        for (size_t k = 0; k < missing && k < 17; k++)
            value *= 10;
        json_array_set_new(values, i, json_integer(value));
    }
    assert_int_equal(lf_json_least_bytes(doc), bytes);
    return doc;
}

static lf_status load(json_t *doc, lf_error *err)
{
    lf_scene *scene = NULL;
    lf_status status = lf_scene_from_json(doc, "/", "test", NULL, NULL, &scene, err);
    if (status == LF_OK)
        assert_int_equal(lf_scene_json_bytes(scene), lf_json_least_bytes(doc));
    lf_scene_unref(scene);
    json_decref(doc);
    return status;
}

static void a_document_may_have_16_mib_and_no_byte_more(void **state)
{
    (void)state;
    lf_error err;
    lf_assert_ok(load(document_of(LF_SCENE_MAX_BYTES), &err), &err);
    assert_int_equal(load(document_of(LF_SCENE_MAX_BYTES + 1), &err), LF_E_NOMEM);
    assert_non_null(strstr(err.what, "at most 16 MiB"));
}

static void a_patch_shares_what_it_leaves_alone(void **state)
{
    (void)state;
    static const char text[] = "{\"a\":{\"x\":[1,2],\"y\":{\"z\":3}},\"b\":{\"c\":[4]},\"d\":5}",
                      change[] = "{\"a\":{\"y\":{\"w\":[6]}},\"d\":null}";
    json_t *doc = parsed(text), *same = parsed(text), *patch = parsed(change),
           *result = lf_json_merge_patch(doc, patch),
           *expected = parsed("{\"a\":{\"x\":[1,2],\"y\":{\"z\":3,\"w\":[6]}},\"b\":{\"c\":[4]}}"),
           *unchanged = parsed(change);
    assert_true(json_equal(result, expected));
    assert_true(json_equal(doc, same));
    assert_ptr_equal(json_object_get(result, "b"), json_object_get(doc, "b"));
    assert_ptr_equal(json_object_get(json_object_get(result, "a"), "x"),
                     json_object_get(json_object_get(doc, "a"), "x"));
    /* in place, what others hold stays as it was */
    json_t *more = parsed("{\"b\":{\"e\":7},\"a\":{\"y\":{\"w\":null}}}");
    assert_true(lf_json_merge_into(result, more));
    assert_true(json_equal(doc, same));
    assert_true(json_equal(patch, unchanged));
    assert_int_equal(json_integer_value(json_object_get(json_object_get(result, "b"), "e")), 7);
    assert_null(json_object_get(json_object_get(json_object_get(result, "a"), "y"), "w"));
    json_decref(more);
    json_decref(unchanged);
    json_decref(expected);
    json_decref(result);
    json_decref(patch);
    json_decref(same);
    json_decref(doc);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_least_bytes_are_those_of_the_shortest_text),
        cmocka_unit_test(a_document_may_have_16_mib_and_no_byte_more),
        cmocka_unit_test(a_patch_shares_what_it_leaves_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
