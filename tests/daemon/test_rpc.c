/* JSON-RPC messages, schemas, and arguments typed by them: without a socket. */
#include "tests/testing.h"

#include "daemon/server/methods.h"
#include "daemon/wire/rpc.h"

static int code_for(const char *line, size_t n)
{
    lf_rpc_request request;
    json_t *answer = NULL;
    if (lf_rpc_parse(line, n, &request, &answer)) {
        lf_rpc_request_finish(&request);
        return 0;
    }
    int code = (int)json_integer_value(json_object_get(json_object_get(answer, "error"), "code"));
    json_decref(answer);
    return code;
}

#define CODE(text) code_for(text, sizeof(text) - 1)

static void a_request_is_taken_apart(void **state)
{
    (void)state;
    static const char line[] =
        "{\"jsonrpc\":\"2.0\",\"id\":\"x\",\"method\":\"wait\",\"params\":{\"generation\":3}}";
    lf_rpc_request request;
    json_t *answer;
    assert_true(lf_rpc_parse(line, sizeof line - 1, &request, &answer));
    assert_string_equal(request.method, "wait");
    assert_string_equal(json_string_value(request.id), "x");
    assert_int_equal(json_integer_value(json_object_get(request.params, "generation")), 3);
    lf_rpc_request_finish(&request);
}

static void params_may_be_left_out_and_ids_too(void **state)
{
    (void)state;
    static const char line[] = "{\"jsonrpc\":\"2.0\",\"method\":\"hello\"}";
    lf_rpc_request request;
    json_t *answer;
    assert_true(lf_rpc_parse(line, sizeof line - 1, &request, &answer));
    assert_null(request.id);
    assert_int_equal(json_object_size(request.params), 0);
    lf_rpc_request_finish(&request);
}

static void what_is_not_json_is_a_parse_error(void **state)
{
    (void)state;
    assert_int_equal(CODE("{\"jsonrpc\":"), LF_RPC_PARSE_ERROR);
    assert_int_equal(CODE("hello"), LF_RPC_PARSE_ERROR);
    assert_int_equal(CODE("{\"jsonrpc\":\"2.0\",\"method\":\"\xff\xfe\"}"), LF_RPC_PARSE_ERROR);
    assert_int_equal(CODE("{\"method\":\"a\0b\"}"), LF_RPC_PARSE_ERROR);
    assert_int_equal(CODE("{\"method\":\"a\",\"method\":\"b\"}"), LF_RPC_PARSE_ERROR);
}

static void what_is_no_request_is_invalid(void **state)
{
    (void)state;
    assert_int_equal(CODE("1"), LF_RPC_INVALID_REQUEST);
    assert_int_equal(CODE("[]"), LF_RPC_INVALID_REQUEST);
    assert_int_equal(CODE("[{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"hello\"}]"),
                     LF_RPC_INVALID_REQUEST);
    assert_int_equal(CODE("{\"id\":1,\"method\":\"hello\"}"), LF_RPC_INVALID_REQUEST);
    assert_int_equal(CODE("{\"jsonrpc\":\"1.0\",\"id\":1,\"method\":\"hello\"}"),
                     LF_RPC_INVALID_REQUEST);
    assert_int_equal(CODE("{\"jsonrpc\":\"2.0\",\"id\":[1],\"method\":\"hello\"}"),
                     LF_RPC_INVALID_REQUEST);
    assert_int_equal(CODE("{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":7}"), LF_RPC_INVALID_REQUEST);
    assert_int_equal(CODE("{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"hello\",\"extra\":1}"),
                     LF_RPC_INVALID_REQUEST);
    assert_int_equal(CODE("{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"hello\",\"params\":[1]}"),
                     LF_RPC_INVALID_PARAMS);
    assert_int_equal(CODE("{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"hello\",\"params\":{}}"), 0);
}

static json_t *schema_of(const char *method)
{
    for (int i = 0; lf_method_at(i); i++)
        if (strcmp(lf_method_at(i)->name, method) == 0)
            return lf_method_schema(i);
    fail_msg("no method %s", method);
    return NULL;
}

static lf_status check(const char *method, const char *params, lf_error *err)
{
    json_t *value = json_loads(params, 0, NULL);
    assert_non_null(value);
    lf_status status = lf_schema_check(schema_of(method), value, method, err);
    json_decref(value);
    return status;
}

static void every_method_has_a_schema_that_parses(void **state)
{
    (void)state;
    static const char *const promised[] = {
        "hello",      "status",       "scene.load", "scene.get",          "scene.patch",
        "camera.set", "camera.orbit", "wait",       "render.set",         "export",
        "job.cancel", "device.list",  "device.set", "device.calibration", "subscribe",
        "shutdown"};
    for (size_t i = 0; i < sizeof promised / sizeof *promised; i++)
        assert_true(json_is_object(schema_of(promised[i])));
}

static void parameters_are_held_to_the_schema(void **state)
{
    (void)state;
    lf_error err;
    lf_assert_ok(check("camera.orbit", "{\"yaw\":5,\"pitch\":1.5}", &err), &err);
    assert_int_equal(check("camera.orbit", "{\"yaw\":\"5\"}", &err), LF_E_ARG);
    assert_string_equal(err.pointer, "/yaw");
    assert_int_equal(check("camera.orbit", "{\"yow\":5}", &err), LF_E_ARG);
    assert_non_null(strstr(err.what, "yow"));
    assert_non_null(strstr(err.what, "yaw"));
    assert_int_equal(check("camera.orbit", "{\"zoom\":0}", &err), LF_E_ARG);
    lf_assert_ok(check("camera.orbit", "{\"zoom\":1000}", &err), &err);
    assert_int_equal(check("camera.orbit", "{\"zoom\":1000.5}", &err), LF_E_ARG);
    assert_int_equal(check("camera.set", "{\"target\":[0,0]}", &err), LF_E_ARG);
    assert_string_equal(err.what, "expected 3 elements, got 2");
    assert_int_equal(check("camera.set", "{\"target\":[0,0,null]}", &err), LF_E_ARG);
    assert_string_equal(err.pointer, "/target/2");
    lf_assert_ok(check("camera.set", "{\"target\":[0,0,1]}", &err), &err);
    assert_int_equal(check("scene.patch", "{}", &err), LF_E_ARG);
    assert_non_null(strstr(err.what, "\"patch\""));
    assert_int_equal(check("wait", "{\"for\":\"ever\"}", &err), LF_E_ARG);
    assert_int_equal(check("wait", "{\"generation\":1.5}", &err), LF_E_ARG);
    lf_assert_ok(check("wait", "{\"generation\":2.0}", &err), &err);
    assert_int_equal(check("hello", "{\"x\":1}", &err), LF_E_ARG);
    lf_assert_ok(check("scene.patch", "{\"patch\":{\"anything\":{\"at\":\"all\"}}}", &err), &err);
    assert_int_equal(check("subscribe", "{\"events\":[\"frame\",\"fame\"]}", &err), LF_E_ARG);
    assert_string_equal(err.pointer, "/events/1");
}

static void words_are_typed_by_the_schema(void **state)
{
    (void)state;
    json_t *params = json_object();
    lf_error err;
    lf_assert_ok(lf_schema_argument(schema_of("camera.orbit"), "yaw=-5.5", params, &err), &err);
    lf_assert_ok(lf_schema_argument(schema_of("render.set"), "paused=true", params, &err), &err);
    lf_assert_ok(lf_schema_argument(schema_of("render.set"), "threads=2", params, &err), &err);
    lf_assert_ok(lf_schema_argument(schema_of("render.set"), "guides=on", params, &err), &err);
    for (int i = 0; i < 4; i++) {
        static const char *const none[] = {"guides=o", "guides=", "guides=yes on", "guides=ye"};
        assert_int_equal(lf_schema_argument(schema_of("render.set"), none[i], params, &err),
                         LF_E_ARG);
    }
    assert_int_equal(lf_schema_argument(schema_of("scene.load"), "a.glb", params, &err), LF_E_ARG);
    assert_non_null(strstr(err.what, "pass file=a.glb"));
    lf_assert_ok(lf_schema_argument(schema_of("render.set"), "estimator=1", params, &err), &err);
    lf_assert_ok(lf_schema_argument(schema_of("subscribe"), "events=frame,scene", params, &err),
                 &err);
    lf_assert_ok(lf_schema_argument(schema_of("camera.set"), "target=1,2,3", params, &err), &err);
    lf_assert_ok(lf_schema_argument(schema_of("scene.patch"), "patch:={\"a\":[1]}", params, &err),
                 &err);
    json_t *expected = json_loads(
        "{\"yaw\":-5.5,\"paused\":true,\"guides\":true,\"threads\":2,\"estimator\":\"1\","
        "\"events\":[\"frame\",\"scene\"],"
        "\"target\":[1.0,2.0,3.0],\"patch\":{\"a\":[1]}}",
        0, NULL);
    assert_true(json_equal(params, expected));
    assert_int_equal(lf_schema_argument(schema_of("camera.orbit"), "yaw=x", params, &err),
                     LF_E_ARG);
    assert_int_equal(lf_schema_argument(schema_of("camera.orbit"), "yaw=nan", params, &err),
                     LF_E_ARG);
    assert_int_equal(lf_schema_argument(schema_of("camera.orbit"), "yaw", params, &err), LF_E_ARG);
    assert_int_equal(lf_schema_argument(schema_of("camera.orbit"), "=5", params, &err), LF_E_ARG);
    assert_int_equal(lf_schema_argument(schema_of("scene.patch"), "patch:={", params, &err),
                     LF_E_ARG);
    json_decref(expected);
    json_decref(params);
}

/* Whole, in decimal digits; the words say which was wrong and what was expected. */
static void numbers_are_read_whole_or_refused(void **state)
{
    (void)state;
    static const struct {
        const char *method, *argument, *words;
    } wrong[] = {
        {"camera.set", "position=0x10,0,0", "\"0x10,0,0\" is not a list of decimal numbers"},
        {"camera.set", "position=0,,0", "\"0,,0\" is not a list of decimal numbers"},
        {"camera.set", "position=0,0,0,", "is not a list of decimal numbers"},
        {"camera.set", "position=1 2 3", "is not a list of decimal numbers"},
        {"camera.set", "position=inf,0,0", "is not a list of decimal numbers"},
        {"render.set", "threads=1e9",
         "\"1e9\" is not a whole number in decimal digits, such as 12"},
        {"render.set", "threads= 4", "\" 4\" is not a whole number"},
        {"render.set", "threads=0x4", "\"0x4\" is not a whole number"},
        {"render.set", "threads=99999999999999999999", "is not a whole number"},
        {"camera.orbit", "yaw=3.1+e2", "\"3.1+e2\" is not a decimal number, such as 0.5 or 1e-3"},
        {"camera.orbit", "yaw=1,5", "\"1,5\" is not a decimal number"},
        {"camera.orbit", "yaw=5deg", "\"5deg\" is not a decimal number"},
        {"camera.orbit", "yaw=0x1p3", "is not a decimal number"},
        {"camera.orbit", "yaw=infinity", "is not a decimal number"},
    };
    json_t *params = json_object();
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        lf_error err = {0};
        lf_status status =
            lf_schema_argument(schema_of(wrong[i].method), wrong[i].argument, params, &err);
        if (status != LF_E_ARG || !strstr(err.what, wrong[i].words))
            fail_msg("%s: %s \"%s\"", wrong[i].argument, lf_status_name(status), err.what);
    }
    assert_int_equal(json_object_size(params), 0);
    json_decref(params);
}

static void failures_have_the_codes_promised(void **state)
{
    (void)state;
    static const struct {
        lf_status status;
        bool scene;
        int code;
    } cases[] = {{LF_E_PATH, true, -32001},   {LF_E_PATH, false, -32001},
                 {LF_E_FORMAT, true, -32002}, {LF_E_IO, true, -32002},
                 {LF_E_NODEV, false, -32003}, {LF_E_BUSY, false, -32000},
                 {LF_E_ARG, false, -32602},   {LF_E_NOMEM, false, -32603}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lf_error err;
        (void)lf_error_set_at(&err, cases[i].status, "a.json", 3, "/camera", "bad");
        json_t *answer = lf_rpc_error_of(NULL, &err, cases[i].scene);
        const json_t *error = json_object_get(answer, "error");
        assert_int_equal(json_integer_value(json_object_get(error, "code")), cases[i].code);
        const json_t *data = json_object_get(error, "data");
        assert_string_equal(json_string_value(json_object_get(data, "file")), "a.json");
        assert_string_equal(json_string_value(json_object_get(data, "pointer")), "/camera");
        assert_int_equal(json_integer_value(json_object_get(data, "line")), 3);
        json_decref(answer);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_request_is_taken_apart),
        cmocka_unit_test(params_may_be_left_out_and_ids_too),
        cmocka_unit_test(what_is_not_json_is_a_parse_error),
        cmocka_unit_test(what_is_no_request_is_invalid),
        cmocka_unit_test(every_method_has_a_schema_that_parses),
        cmocka_unit_test(parameters_are_held_to_the_schema),
        cmocka_unit_test(words_are_typed_by_the_schema),
        cmocka_unit_test(numbers_are_read_whole_or_refused),
        cmocka_unit_test(failures_have_the_codes_promised),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
