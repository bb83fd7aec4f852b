/* PUT: uploads that scenes use, quilts for quiltd, and what is refused before a body is read. */
#include "tests/web/gateway.h"

#include <sys/socket.h>

#include <jansson.h>

enum { BIG = 1 << 20 };

static const char *bearer(const gateway *g)
{
    char *text = lf_test_buffer();
    snprintf(text, 128, "Authorization: Bearer %s\r\n", lf_gateway_token(g));
    return text;
}

/* The value of a text in an answer, in a static buffer. */
static const char *text_in(const char *answer, const char *key)
{
    char *out = lf_test_buffer();
    const char *body = strstr(answer, "\r\n\r\n{");
    json_t *json = json_loads(body ? body + 4 : "", 0, NULL);
    const char *text = json_string_value(json_object_get(json, key));
    if (!text)
        fail_msg("no %s in %s", key, answer);
    snprintf(out, PATH_MAX, "%s", text);
    json_decref(json);
    return out;
}

/* The path of an upload. */
static const char *upload(gateway *g, const char *query, const char *body, size_t n)
{
    char target[512];
    snprintf(target, sizeof target, "/api/upload?%s", query);
    const char *answer = lf_caller_put(g, target, body, n);
    if (lf_caller_status(answer) != 201)
        fail_msg("%s: %s", query, answer);
    return text_in(answer, "path");
}

static void check_put(gateway *g, const char *target, const char *body, int expected)
{
    const char *answer = lf_caller_put(g, target, body, strlen(body));
    if (lf_caller_status(answer) != expected)
        fail_msg("%s: %d, expected %d", target, lf_caller_status(answer), expected);
}

/* Says a call with this method and parameters (of printf) and returns the answer. */
static const char *call(int fd, const char *method, const char *params)
{
    char text[1024];
    snprintf(text, sizeof text, "{\"jsonrpc\":\"2.0\",\"id\":7,\"method\":\"%s\",\"params\":%s}",
             method, params);
    lf_talk_say(fd, text);
    return lf_talk_until(fd, "\"id\":7", NULL);
}

static void an_upload_is_passed_once_and_for_reading_only(void **state)
{
    gateway *g = *state;
    char params[512];
    const char *path = upload(g, "name=a.glb", "a model", 7);
    assert_memory_equal(path, "/upload/", 8);
    snprintf(params, sizeof params, "{\"file\":\"%s\",\"files\":[\"%s\"]}", path, path);
    int fd = lf_talk_open(g);
    const char *answer = call(fd, "scene.load", params);
    assert_non_null(strstr(answer, "\"seen\":[{\"text\":\"a model\",\"reads\":true,\"bytes\":7}]"));
    assert_non_null(strstr(call(fd, "scene.load", params), "-32602"));
    assert_int_equal(lf_gateway_calls(g, "scene.load"), 1);
    close(fd);
}

static void files_of_a_folder_go_together(void **state)
{
    gateway *g = *state;
    char query[256], params[1024];
    const char *first = upload(g, "name=a.gltf", "one", 3);
    snprintf(query, sizeof query, "folder=%.16s&name=textures/b%%20c.png",
             first + strlen("/upload/"));
    const char *second = upload(g, query, "two", 3);
    assert_memory_equal(first, second, strlen("/upload/") + 17);
    assert_string_equal(second + strlen("/upload/") + 16, "/textures/b c.png");
    int fd = lf_talk_open(g);
    /* one that is not there: none of them is used up */
    snprintf(params, sizeof params, "{\"patch\":{},\"files\":[\"%s\",\"%s\",\"/upload/x\"]}", first,
             second);
    assert_non_null(strstr(call(fd, "scene.patch", params), "-32602"));
    snprintf(params, sizeof params, "{\"patch\":{},\"files\":[\"%s\",\"%s\"]}", first, first);
    assert_non_null(strstr(call(fd, "scene.patch", params), "-32602"));
    snprintf(params, sizeof params, "{\"patch\":{},\"files\":[\"%s\",\"%s\"]}", second, first);
    const char *answer = call(fd, "scene.patch", params);
    const char *one = strstr(answer, "\"text\":\"one\""), *two = strstr(answer, "\"text\":\"two\"");
    assert_true(one && two && two < one); /* in the order of the names */
    close(fd);
}

static void names_of_uploads_stay_in_their_folder(void **state)
{
    gateway *g = *state;
    static const char *const wrong[] = {"name=",
                                        "name=..",
                                        "name=../a",
                                        "name=a/../b",
                                        "name=/a",
                                        "name=a//b",
                                        "name=a/",
                                        "name=./a",
                                        "name=a%0Ab",
                                        "name=a%00b",
                                        "name=%ff",
                                        "",
                                        "name%00x=a",
                                        "name=a&name=b",
                                        "name=a&x=1",
                                        "name=a&folder=..",
                                        "name=a&folder=0123456789abcde",
                                        "folder=0",
                                        "name=%2e%2e%2fa",
                                        "name=a%7f",
                                        "name=a&folder=0123456789ABCDEF"};
    char target[256], name[300];
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        snprintf(target, sizeof target, "/api/upload?%s", wrong[i]);
        check_put(g, target, "x", 400);
    }
    for (int n = 255; n <= 256; n++) {
        char query[320];
        memset(name, 'a', sizeof name);
        snprintf(query, sizeof query, "/api/upload?name=%.*s", n, name);
        check_put(g, query, "x", n == 255 ? 201 : 400);
    }
    check_put(g, "/api/upload?name=a&folder=0123456789abcdef", "x", 201);
    check_put(g, "/api/upload?name=a&folder=0123456789abcdef", "x", 409);
}

/* A body that is announced; the gateway has made room for it. */
static int begin_body(gateway *g, size_t n)
{
    char headers[96], go[32];
    snprintf(headers, sizeof headers, "Content-Length: %zu\r\nExpect: 100-continue\r\n", n);
    int fd = lf_caller_begin(g, "PUT /api/upload?name=begun HTTP/1.1", headers);
    assert_true(recv(fd, go, sizeof go - 1, 0) > 12);
    assert_memory_equal(go, "HTTP/1.1 100", 12);
    return fd;
}

static void a_body_of_many_parts_arrives_whole(void **state)
{
    gateway *g = *state;
    char *body = malloc(BIG), params[512];
    assert_non_null(body);
    for (int i = 0; i < BIG; i++)
        body[i] = (char)('a' + i % 23);
    const char *path = upload(g, "name=a.vdb", body, BIG);
    snprintf(params, sizeof params, "{\"file\":\"%s\",\"files\":[\"%s\"]}", path, path);
    int fd = lf_talk_open(g);
    const char *answer = call(fd, "scene.load", params);
    assert_non_null(strstr(answer, "\"bytes\":1048576"));
    assert_non_null(strstr(answer, "\"text\":\"abcdefghijklmnopqrstuvwabc"));
    close(fd);
    assert_non_null(upload(g, "name=empty", "", 0));
    free(body);
}

/* All that is received and all that waits has a common limit. */
static void uploads_have_a_limit_together(void **state)
{
    gateway *g = *state;
    char *body = calloc(BIG, 1), params[512];
    assert_non_null(body);
    const char *path = upload(g, "name=a", body, BIG);
    (void)upload(g, "name=b", body, BIG);
    /* one on its way counts with its whole length */
    int half = begin_body(g, 1000000);
    assert_int_equal(lf_caller_status(lf_caller_put(g, "/api/upload?name=d", body, 60000)), 503);
    snprintf(params, sizeof params, "{\"file\":\"%s\",\"files\":[\"%s\"]}", path, path);
    int fd = lf_talk_open(g);
    assert_non_null(strstr(call(fd, "scene.load", params), "\"result\""));
    (void)upload(g, "name=d", body, 60000);
    close(half);
    close(fd);
    free(body);
}

/* Passes n of these files; what the gateway says before quiltd answers, or that it says nothing. */
static const char *pass(int fd, const char *const paths[], int n)
{
    char text[8192];
    int used = sprintf(text, "{\"jsonrpc\":\"2.0\",\"id\":7,\"method\":\"scene.load\",\"params\":"
                             "{\"file\":\"a\",\"files\":[");
    for (int i = 0; i < n; i++)
        used += sprintf(text + used, "%s\"%s\"", i > 0 ? "," : "", paths[i]);
    strcpy(text + used, "]}}");
    lf_talk_say(fd, text);
    lf_talk_say(fd, "{\"jsonrpc\":\"2.0\",\"id\":7,\"method\":\"shutdown\"}"); /* refused at once */
    return lf_talk_until(fd, "\"id\":7", NULL);
}

/* What was passed but not taken by quiltd is still memory of the gateway. */
static void files_that_quiltd_does_not_take_have_a_limit(void **state)
{
    gateway *g = *state;
    enum { SIZE = 2 * BIG };
    char *body = calloc(SIZE, 1);
    assert_non_null(body);
    lf_gateway_set_rights(g, LF_RIGHTS_SILENT); /* nothing is sent to it */
    int one = lf_talk_open(g), two = lf_talk_open(g);
    const char *path = upload(g, "name=a", body, SIZE);
    assert_non_null(strstr(pass(one, &path, 1), "-32601"));
    path = upload(g, "name=b", body, SIZE);
    assert_non_null(strstr(pass(two, &path, 1), "-32000"));
    close(one);
    const char *answer = "";
    for (int i = 0; i < 1000 && !strstr(answer, "-32601"); i++) { /* it still waits */
        close(two);
        two = lf_talk_open(g);
        answer = pass(two, &path, 1);
    }
    assert_non_null(strstr(answer, "-32601"));
    assert_int_equal(lf_gateway_calls(g, "scene.load"), 0);
    close(two);
    free(body);
}

static void few_files_wait_for_quiltd(void **state)
{
    gateway *g = *state;
    enum { A_CALL = 64, CALLS = 2 };
    const char *paths[A_CALL];
    char query[32], kept[A_CALL][64];
    int fds[CALLS + 1];
    lf_gateway_set_rights(g, LF_RIGHTS_SILENT);
    for (int k = 0; k <= CALLS; k++) {
        for (int i = 0; i < (k < CALLS ? A_CALL : 1); i++) {
            snprintf(query, sizeof query, "name=%d", i);
            snprintf(kept[i], sizeof kept[i], "%s", upload(g, query, "x", 1));
            paths[i] = kept[i];
        }
        fds[k] = lf_talk_open(g);
        const char *answer = pass(fds[k], paths, k < CALLS ? A_CALL : 1);
        assert_non_null(strstr(answer, k < CALLS ? "-32601" : "-32000"));
    }
    for (int k = 0; k <= CALLS; k++)
        close(fds[k]);
}

static void a_few_bodies_come_at_once(void **state)
{
    gateway *g = *state;
    enum { AT_ONCE = 4 };
    int fds[AT_ONCE];
    for (int i = 0; i < AT_ONCE; i++)
        fds[i] = begin_body(g, 2);
    check_put(g, "/api/upload?name=b", "x", 503);
    assert_true(lf_caller_send(fds[0], "xy", 2));
    assert_int_equal(lf_caller_status(lf_caller_rest(fds[0])), 201);
    check_put(g, "/api/upload?name=b", "x", 201);
    for (int i = 1; i < AT_ONCE; i++)
        close(fds[i]);
}

static void many_uploads_wait_and_no_more(void **state)
{
    gateway *g = *state;
    char query[32];
    for (int i = 0; i < 128; i++) {
        snprintf(query, sizeof query, "name=%d", i);
        (void)upload(g, query, "x", 1);
    }
    check_put(g, "/api/upload?name=more", "x", 503);
}

/* The headers decide, before the body comes: none is sent here. */
static void check_headers(gateway *g, const char *method, const char *target, const char *headers,
                          int expected)
{
    char line[256];
    snprintf(line, sizeof line, "%s %s HTTP/1.1", method, target);
    const char *answer = lf_caller_get(g, line, headers);
    if (lf_caller_status(answer) != expected)
        fail_msg("%s, %s: %d, expected %d", line, headers, lf_caller_status(answer), expected);
}

static void wrong_requests_are_refused_before_their_body(void **state)
{
    gateway *g = *state;
    static const char *const targets[] = {"/api/upload?name=a", "/api/quilt?cols=2&rows=1"};
    char headers[512], cookie[200], mine[64];
    snprintf(cookie, sizeof cookie, "Cookie: %s\r\n", lf_gateway_cookie(g));
    snprintf(mine, sizeof mine, "Origin: http://127.0.0.1:%d\r\n", lf_gateway_port(g));
    for (int i = 0; i < 2; i++) {
        const struct {
            const char *method, *first, *second;
            int status;
        } rows[] = {
            {"PUT", "", "Content-Length: 1\r\n", 401},
            {"PUT", cookie, "Content-Length: 1\r\n", 401}, /* any page may cause this */
            {"PUT", cookie, "Content-Length: 1\r\nOrigin: http://evil.test\r\n", 403},
            {"PUT", bearer(g), "Content-Length: 1\r\nOrigin: http://evil.test\r\n", 403},
            {"PUT", bearer(g), "Content-Length: 1\r\nOrigin: null\r\n", 403},
            {"PUT", bearer(g), "Content-Length: 1\r\nHost: evil.test\r\n", 421},
            {"PUT", bearer(g), "", 411},
            {"PUT", bearer(g), "Content-Length: 3145729\r\n", 413},
            {"PUT", bearer(g), "Content-Length: 1\r\nContent-Length: 1\r\n", 400},
            {"PUT", bearer(g), "Transfer-Encoding: chunked\r\n", 400},
            {"PUT", bearer(g), "Content-Length: 1\r\nTransfer-Encoding: chunked\r\n", 400},
            {"POST", bearer(g), "Content-Length: 1\r\n", 413},
            {"POST", bearer(g), "", 405},
            {"GET", bearer(g), "", 405},
            {"OPTIONS", mine, "Access-Control-Request-Method: PUT\r\n", 405},
            {"OPTIONS", "Origin: http://evil.test\r\n", "Access-Control-Request-Method: PUT\r\n",
             403},
        };
        for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
            snprintf(headers, sizeof headers, "%s%s", rows[k].first, rows[k].second);
            check_headers(g, rows[k].method, targets[i], headers, rows[k].status);
        }
        snprintf(headers, sizeof headers, "%s%sContent-Length: 0\r\n", cookie, mine);
        check_headers(g, "PUT", targets[i], headers, i == 0 ? 201 : 200);
    }
    snprintf(headers, sizeof headers, "%sContent-Length: 1\r\n", bearer(g));
    check_headers(g, "PUT", "/", headers, 413);
    check_headers(g, "PUT", "/api/status", headers, 413);
}

/* A rebound name is refused on every path before anything else. */
static void another_host_is_misdirected_everywhere(void **state)
{
    gateway *g = *state;
    static const char *const targets[] = {
        "PUT /api/upload?name=a",     "PUT /api/quilt?cols=2&rows=1",
        "GET /api/thumbnail?file=/a", "GET /api/download/0/a",
        "GET /preview.mjpg",          "GET /metrics",
        "GET /scene.schema.json"};
    char request[512];
    for (size_t i = 0; i < sizeof targets / sizeof targets[0]; i++)
        for (int k = 0; k < 2; k++) {
            snprintf(request, sizeof request, "%s HTTP/1.1\r\nHost: %s:%d\r\n%s%s\r\n", targets[i],
                     k == 0 ? "evil.test" : "127.0.0.1", lf_gateway_port(g), bearer(g),
                     k == 0 ? "" : "Origin: http://evil.test\r\n");
            assert_int_equal(lf_caller_status(lf_caller_ask(g, request)),
                             k == 0                           ? 421
                             : targets[i][0] == 'P' && k == 1 ? 411
                                                              : 403);
        }
}

static void a_quilt_is_shown(void **state)
{
    gateway *g = *state;
    const char *answer = lf_caller_put(g, "/api/quilt?cols=8&rows=6&views=47&aspect=0.75",
                                       "a picture", strlen("a picture"));
    assert_int_equal(lf_caller_status(answer), 200);
    assert_non_null(strstr(answer, "\"generation\":9"));
    assert_non_null(
        strstr(answer, "\"params\":{\"columns\":8,\"rows\":6,\"views\":47,\"aspect\":0.75}"));
    assert_non_null(strstr(answer, "\"text\":\"a picture\",\"reads\":true,\"bytes\":9"));
    assert_int_equal(lf_gateway_unlimited(g), 0);
}

static void a_refused_quilt_has_the_words_of_quiltd(void **state)
{
    gateway *g = *state;
    static const char *const wrong[] = {
        "cols=8",         "rows=6", "cols=a&rows=6", "cols=8&rows=6&x=1", "cols=8&rows=6&aspect=b",
        "cols=1e1&rows=1"};
    char target[128];
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        snprintf(target, sizeof target, "/api/quilt?%s", wrong[i]);
        const char *answer = lf_caller_put(g, target, "x", 1);
        assert_int_equal(lf_caller_status(answer), 400);
        assert_non_null(strstr(answer, "\r\n\r\n{\"error\":{\"code\":-32602,\"message\":\""));
    }
    assert_int_equal(lf_gateway_calls(g, "quilt.show"), 0);
    const char *answer = lf_caller_put(g, "/api/quilt?cols=99&rows=1", "x", 1);
    assert_int_equal(lf_caller_status(answer), 422);
    assert_non_null(strstr(answer, "\r\n\r\n{\"error\":{\"code\":-32602,"
                                   "\"message\":\"the false quiltd refuses\"}}"));
}

/* A client that dies in the middle leaves nothing behind. */
static void a_body_that_breaks_off_is_forgotten(void **state)
{
    gateway *g = *state;
    const struct linger at_once = {.l_onoff = 1};
    char *body = calloc(3 * BIG, 1);
    assert_non_null(body);
    int fd = begin_body(g, 3 * BIG);
    assert_true(lf_caller_send(fd, body, BIG));
    setsockopt(fd, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    close(fd);
    int status = 503;
    for (int i = 0; i < 1000 && status == 503; i++) {
        usleep(10000);
        status = lf_caller_status(lf_caller_put(g, "/api/upload?name=b", body, 3 * BIG));
    }
    assert_int_equal(status, 201);
    free(body);
}

/* The gateway ends with bodies on their way and uploads that wait. */
static void an_end_with_uploads_is_clean(void **state)
{
    gateway *g = *state;
    (void)upload(g, "name=a", "x", 1);
    int fd = lf_caller_begin(g, "PUT /api/upload?name=b HTTP/1.1", "Content-Length: 100\r\n");
    assert_true(lf_caller_send(fd, "x", 1));
    int other = lf_talk_open(g); /* the body has been read before this */
    close(other);
    close(fd);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_gateway_test(an_upload_is_passed_once_and_for_reading_only),
        lf_gateway_test(files_of_a_folder_go_together),
        lf_gateway_test(names_of_uploads_stay_in_their_folder),
        lf_gateway_test(a_body_of_many_parts_arrives_whole),
        lf_gateway_test(uploads_have_a_limit_together),
        lf_gateway_test(files_that_quiltd_does_not_take_have_a_limit),
        lf_gateway_test(few_files_wait_for_quiltd),
        lf_gateway_test(a_few_bodies_come_at_once),
        lf_gateway_test(many_uploads_wait_and_no_more),
        lf_gateway_test(wrong_requests_are_refused_before_their_body),
        lf_gateway_test(another_host_is_misdirected_everywhere),
        lf_gateway_test(a_quilt_is_shown),
        lf_gateway_test(a_refused_quilt_has_the_words_of_quiltd),
        lf_gateway_test(a_body_that_breaks_off_is_forgotten),
        lf_gateway_test(an_end_with_uploads_is_clean),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
