/* Services of programs: whom they let in, each beside whom they refuse. */
#include "tests/web/gateway.h"

#include "daemon/web/origins.h"
#include "daemon/web/service.h"

static const char allowed[] = "https://allowed.test";

/* The answer of a service to "METHOD PATH", with a Host that is right, and more headers. */
static const char *ask(gateway *g, lf_service service, const char *line, const char *headers)
{
    char request[1024];
    snprintf(request, sizeof request, "%s HTTP/1.1\r\nHost: localhost:%d\r\n%s\r\n", line,
             lf_gateway_service_port(g, service), headers);
    return lf_caller_ask_service(g, service, request);
}

static void check(gateway *g, lf_service service, const char *line, const char *headers,
                  int expected)
{
    const int status = lf_caller_status(ask(g, service, line, headers));
    if (status != expected)
        fail_msg("service %d, %s, %s: %d, expected %d", service, line, headers, status, expected);
}

static void each_service_says_that_it_is_there(void **state)
{
    for (lf_service service = LF_SERVICE_BRIDGE; service < LF_SERVICES; service++) {
        const int nothing = service == LF_SERVICE_BRIDGE ? 405 : 404; /* all its paths take a PUT */
        check(*state, service, "GET /", "", 200);
        check(*state, service, "GET /", "Origin: https://allowed.test\r\n", 200);
        check(*state, service, "POST /", "Content-Length: 0\r\n", 405);
        check(*state, service, "HEAD /", "", 405);
        check(*state, service, "GET /main.js", "", nothing);
        check(*state, service, "GET /api/status", "", nothing);
        check(*state, service, "GET /rpc", "", nothing);
    }
}

/* And the page's service has nothing of theirs. */
static void the_page_is_served_as_before(void **state)
{
    check(*state, LF_SERVICE_PAGE, "GET /main.js", "", 200);
    check(*state, LF_SERVICE_PAGE, "OPTIONS /", "", 405);
    check(*state, LF_SERVICE_PAGE, "GET /", "Origin: https://allowed.test\r\n", 403);
    check(*state, LF_SERVICE_PAGE, "PUT /bridge_version", "Content-Length: 0\r\n", 404);
    assert_null(strstr(ask(*state, LF_SERVICE_PAGE, "GET /", ""), "Vary"));
}

static void another_page_is_refused(void **state)
{
    static const char *const others[] = {"Origin: https://evil.test\r\n",
                                         "Origin: null\r\n",
                                         "Origin: \r\n",
                                         "Origin: https://allowed.test:8443\r\n",
                                         "Origin: http://allowed.test\r\n",
                                         "Origin: https://allowed.test/\r\n",
                                         "Origin: https://allowed.test.evil.test\r\n",
                                         "Origin: http://localhost:8033\r\n",
                                         "Origin: https://allowed.test\r\nOrigin: null\r\n"};
    for (lf_service service = LF_SERVICE_BRIDGE; service < LF_SERVICES; service++)
        for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
            check(*state, service, "GET /", others[i], 403);
            check(*state, service, "OPTIONS /", others[i], 403);
            assert_null(strstr(ask(*state, service, "GET /", others[i]), "Access-Control"));
        }
}

static void an_allowed_page_may_read_every_answer(void **state)
{
    static const char *const lines[] = {"GET /", "OPTIONS /", "GET /nothing", "POST /"};
    char header[64], expected[128];
    snprintf(header, sizeof header, "Origin: %s\r\n", allowed);
    snprintf(expected, sizeof expected, "Access-Control-Allow-Origin: %s\r\n", allowed);
    for (lf_service service = LF_SERVICE_BRIDGE; service < LF_SERVICES; service++)
        for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
            const char *answer = ask(*state, service, lines[i], header);
            assert_non_null(strstr(answer, expected));
            assert_non_null(strstr(answer, "Vary: Origin\r\n"));
            assert_null(strstr(answer, "Access-Control-Allow-Credentials"));
            assert_null(strstr(ask(*state, service, lines[i], ""), "Access-Control-Allow-Origin"));
        }
}

/* What a browser asks before a PUT. */
static void options_say_what_is_allowed(void **state)
{
    const char *answer =
        ask(*state, LF_SERVICE_BRIDGE, "OPTIONS /",
            "Origin: https://allowed.test\r\nAccess-Control-Request-Method: PUT\r\n"
            "Access-Control-Request-Headers: content-type\r\n");
    assert_int_equal(lf_caller_status(answer), 204);
    assert_non_null(strstr(answer, "Access-Control-Allow-Methods: GET, PUT\r\n"));
    assert_non_null(strstr(answer, "Access-Control-Allow-Headers: Content-Type\r\n"));
}

/* The status that a service answers to a request in which @ stands for its port. */
static int status_of(gateway *g, lf_service service, const char *text, int port)
{
    char request[512];
    size_t n = 0;
    for (; *text; text++)
        n += (size_t)(*text == '@' ? snprintf(request + n, sizeof request - n, "%d", port)
                                   : snprintf(request + n, sizeof request - n, "%c", *text));
    return lf_caller_status(lf_caller_ask_service(g, service, request));
}

static void a_service_has_the_names_of_its_port_alone(void **state)
{
    gateway *g = *state;
    static const struct {
        const char *text;
        int status;
    } rows[] = {{"GET / HTTP/1.1\r\nHost: localhost:@\r\n\r\n", 200},
                {"GET / HTTP/1.1\r\nHost: 127.0.0.1:@\r\n\r\n", 200},
                {"GET / HTTP/1.1\r\nHost: [::1]:@\r\n\r\n", 200},
                {"GET / HTTP/1.1\r\nHost: evil.test:@\r\n\r\n", 421},
                {"GET / HTTP/1.1\r\nHost: localhost.:@\r\n\r\n", 421},
                {"GET / HTTP/1.1\r\nHost: localhost:@\r\nHost: evil.test\r\n\r\n", 421},
                {"GET / HTTP/1.0\r\n\r\n", 421},
                {"GET http://localhost:@/ HTTP/1.1\r\nHost: localhost:@\r\n\r\n", 400},
                {"GET /%00 HTTP/1.1\r\nHost: localhost:@\r\n\r\n", 400},
                {"GET / HTTP/1.1\r\nHost: localhost:@\r\nContent-Length: 1\r\n\r\n", 413}};
    for (lf_service service = LF_SERVICE_BRIDGE; service < LF_SERVICES; service++) {
        for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
            const int status =
                status_of(g, service, rows[i].text, lf_gateway_service_port(g, service));
            if (status != rows[i].status)
                fail_msg("%s: %d, expected %d", rows[i].text, status, rows[i].status);
        }
        assert_int_equal(status_of(g, service, rows[0].text, lf_gateway_port(g)), 421);
    }
}

static void an_origin_is_a_name_and_a_port(void **state)
{
    (void)state;
    static const char *const good[] = {
        "http://a",         "https://a.test",    "https://a.test:8443",
        "http://localhost", "http://[::1]:3000", "http://127.0.0.1:3000"};
    static const char *const bad[] = {"",
                                      "null",
                                      "*",
                                      "a.test",
                                      "https://",
                                      "https://A.test",
                                      "https://a.test/",
                                      "https://a.test:",
                                      "https://a.test:0",
                                      "https://a.test:080",
                                      "https://a.test:65536",
                                      "https://a.test:*",
                                      "https://localhost:*",
                                      "https://a.test:443", /* browsers leave these out */
                                      "http://a.test:80",
                                      "file://a",
                                      "http://[::1]x"};
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++) {
        lf_origins origins = {0};
        lf_error err = {0};
        lf_assert_ok(lf_origins_add(&origins, good[i], &err), &err);
        for (size_t k = 0; k < sizeof good / sizeof good[0]; k++)
            assert_int_equal(lf_origins_have(&origins, good[k]), i == k);
    }
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        lf_origins origins = {0};
        lf_error err = {0};
        lf_assert_status(lf_origins_add(&origins, bad[i], &err), LF_E_ARG, &err);
        assert_false(lf_origins_have(&origins, bad[i]));
    }
}

static void all_ports_of_this_machine_are_one_word(void **state)
{
    (void)state;
    static const char *const local[] = {"http://localhost", "http://localhost:1",
                                        "http://127.0.0.1:3000", "http://[::1]:65535"};
    static const char *const others[] = {"https://localhost",     "http://localhost:0",
                                         "http://localhost:",     "http://localhost.evil.test",
                                         "http://localhost:1/",   "http://localhost:*",
                                         "http://127.0.0.2:3000", "null"};
    lf_origins origins = {0};
    lf_error err = {0};
    assert_false(lf_origins_have(&origins, local[0]));
    lf_assert_ok(lf_origins_add(&origins, LF_ORIGINS_LOCAL, &err), &err);
    for (size_t i = 0; i < sizeof local / sizeof local[0]; i++)
        assert_true(lf_origins_have(&origins, local[i]));
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
        assert_false(lf_origins_have(&origins, others[i]));
}

/* Once for each service, in words that say what to do. */
static void strangers_are_told_of_once(void **state)
{
    (void)state;
    lf_strangers met = {0};
    lf_error err = {0};
    char name[32];
    for (int service = 1; service < 3; service++)
        for (int again = 0; again < 2; again++)
            assert_int_equal(lf_strangers_meet(&met, service, "http://localhost:5174"), !again);
    assert_true(lf_strangers_meet(&met, 1, "http://localhost:5175"));
    for (int i = 3; i < LF_STRANGERS_MOST; i++) {
        snprintf(name, sizeof name, "http://a%d", i);
        assert_true(lf_strangers_meet(&met, 1, name));
    }
    assert_false(lf_strangers_meet(&met, 1, "http://b")); /* the log is not filled */
    lf_origins_refusal("http://localhost:5174", &err);
    assert_non_null(strstr(err.what, "--allow-origin http://localhost:5174"));
    lf_origins_refusal("null", &err); /* cannot be allowed */
    assert_null(strstr(err.what, "--allow-origin"));
    lf_origins_refusal("http://\n\033[31m", &err);
    assert_null(strpbrk(err.what, "\n\033"));
}

static void origins_are_bounded(void **state)
{
    (void)state;
    lf_origins origins = {0};
    lf_error err = {0};
    char text[400] = "http://";
    for (int i = 0; i < LF_ORIGINS_MOST; i++)
        lf_assert_ok(lf_origins_add(&origins, "http://a", &err), &err);
    lf_assert_status(lf_origins_add(&origins, "http://b", &err), LF_E_ARG, &err);
    lf_assert_ok(lf_origins_add(&origins, LF_ORIGINS_LOCAL, &err), &err);
    origins.n = 0;
    memset(text + 7, 'a', sizeof text - 8);
    lf_assert_status(lf_origins_add(&origins, text, &err), LF_E_ARG, &err);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_gateway_programs_test(each_service_says_that_it_is_there),
        lf_gateway_programs_test(the_page_is_served_as_before),
        lf_gateway_programs_test(another_page_is_refused),
        lf_gateway_programs_test(an_allowed_page_may_read_every_answer),
        lf_gateway_programs_test(options_say_what_is_allowed),
        lf_gateway_programs_test(a_service_has_the_names_of_its_port_alone),
        cmocka_unit_test(an_origin_is_a_name_and_a_port),
        cmocka_unit_test(all_ports_of_this_machine_are_one_word),
        cmocka_unit_test(strangers_are_told_of_once),
        cmocka_unit_test(origins_are_bounded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
