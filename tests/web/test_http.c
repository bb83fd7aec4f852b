/* The rules of HTTP, over sockets: what is refused, each beside what passes. */
#include "tests/web/gateway.h"

#include <sys/socket.h>

static void check_status(gateway *g, const char *line, const char *headers, int expected)
{
    const char *answer = lf_caller_get(g, line, headers);
    if (lf_caller_status(answer) != expected)
        fail_msg("%s, %s: %d, expected %d", line, headers, lf_caller_status(answer), expected);
}

static void check_raw(gateway *g, const char *request, int expected)
{
    const char *answer = lf_caller_ask(g, request);
    if (lf_caller_status(answer) != expected)
        fail_msg("%s: %d, expected %d", request, lf_caller_status(answer), expected);
}

static const char *bearer(const gateway *g)
{
    char *text = lf_test_buffer();
    snprintf(text, 128, "Authorization: Bearer %s\r\n", lf_gateway_token(g));
    return text;
}

static void every_answer_keeps_other_pages_out(void **state)
{
    gateway *g = *state;
    static const char *const lines[] = {"GET / HTTP/1.1", "GET /main.js HTTP/1.1",
                                        "GET /nothing HTTP/1.1", "GET /api/status HTTP/1.1",
                                        "DELETE / HTTP/1.1"};
    static const char *const headers[] = {
        "Content-Security-Policy: default-src 'self'; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'\r\n",
        "Cross-Origin-Resource-Policy: same-origin\r\n",
        "X-Content-Type-Options: nosniff\r\n",
        "Referrer-Policy: no-referrer\r\n",
        "Cache-Control: no-store\r\n",
    };
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        const char *answer = lf_caller_get(g, lines[i], "");
        for (size_t k = 0; k < sizeof headers / sizeof headers[0]; k++)
            if (!strstr(answer, headers[k]))
                fail_msg("%s: no %s", lines[i], headers[k]);
        assert_null(strstr(answer, "Access-Control"));
    }
}

static void only_pages_are_served(void **state)
{
    gateway *g = *state;
    static const char *const paths[] = {"/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/page",
                                        "//", "/main.js/"};
    check_status(g, "GET / HTTP/1.1", "", 200);
    check_status(g, "HEAD / HTTP/1.1", "", 200);
    check_status(g, "GET /main.js HTTP/1.1", "", 200);
    for (size_t i = 0; i < sizeof paths / sizeof paths[0]; i++) {
        char line[128];
        snprintf(line, sizeof line, "GET %s HTTP/1.1", paths[i]);
        check_status(g, line, "", 404);
    }
    check_status(g, "GET /main.js%00.x HTTP/1.1", "", 400);
    check_status(g, "GET /main.js?%00 HTTP/1.1", "", 200);
    check_status(g, "POST / HTTP/1.1", "", 405);
    check_status(g, "OPTIONS / HTTP/1.1", "Origin: http://evil.test\r\n", 403);
    check_status(g, "OPTIONS / HTTP/1.1", "", 405);
    check_status(g, "GET /api/login HTTP/1.1", bearer(g), 405);
}

static void another_host_is_misdirected(void **state)
{
    gateway *g = *state;
    char request[256];
    static const char *const formats[][2] = {{"localhost", "200"},
                                             {"127.0.0.1", "200"},
                                             {"[::1]", "200"},
                                             {"evil.test", "421"},
                                             {"localhost.", "421"}};
    for (size_t i = 0; i < sizeof formats / sizeof formats[0]; i++) {
        snprintf(request, sizeof request, "GET / HTTP/1.1\r\nHost: %s:%d\r\n\r\n", formats[i][0],
                 lf_gateway_port(g));
        check_raw(g, request, atoi(formats[i][1]));
    }
    check_raw(g, "GET / HTTP/1.0\r\n\r\n", 421);
    snprintf(request, sizeof request, "Host: 127.0.0.1:%d\r\n", lf_gateway_port(g));
    check_status(g, "GET / HTTP/1.1", request, 421); /* a second one */
    check_status(g, "GET / HTTP/1.1", "Host: evil.test\r\n", 421);
    snprintf(request, sizeof request, "GET http://127.0.0.1:%d/ HTTP/1.1", lf_gateway_port(g));
    check_status(g, request, "", 400);
}

static void another_origin_is_refused(void **state)
{
    gateway *g = *state;
    char origin[128];
    snprintf(origin, sizeof origin, "%sOrigin: http://127.0.0.1:%d\r\n", bearer(g),
             lf_gateway_port(g));
    check_status(g, "POST /api/login HTTP/1.1", origin, 204);
    snprintf(origin, sizeof origin, "%sOrigin: http://evil.test:%d\r\n", bearer(g),
             lf_gateway_port(g));
    check_status(g, "POST /api/login HTTP/1.1", origin, 403);
    snprintf(origin, sizeof origin, "%sOrigin: null\r\n", bearer(g));
    check_status(g, "POST /api/login HTTP/1.1", origin, 403);
}

static void bodies_are_refused_before_they_come(void **state)
{
    gateway *g = *state;
    char headers[256];
    snprintf(headers, sizeof headers, "%sContent-Length: 0\r\n", bearer(g));
    check_status(g, "POST /api/login HTTP/1.1", headers, 204);
    snprintf(headers, sizeof headers, "%sContent-Length: 1073741824\r\n", bearer(g));
    check_status(g, "POST /api/login HTTP/1.1", headers, 413);
    snprintf(headers, sizeof headers, "%sContent-Length: 0\r\nContent-Length: 0\r\n", bearer(g));
    check_status(g, "POST /api/login HTTP/1.1", headers, 400);
    snprintf(headers, sizeof headers, "%sTransfer-Encoding: chunked\r\n", bearer(g));
    check_status(g, "POST /api/login HTTP/1.1", headers, 400);
    snprintf(headers, sizeof headers, "%sContent-Length: 0\r\nTransfer-Encoding: chunked\r\n",
             bearer(g));
    check_status(g, "POST /api/login HTTP/1.1", headers, 400);
    snprintf(headers, sizeof headers, "%sContent-Length: -1\r\n", bearer(g));
    check_status(g, "POST /api/login HTTP/1.1", headers, 400);
}

static void headers_are_bounded(void **state)
{
    gateway *g = *state;
    enum { MANY = 40000 };
    char *request = malloc(MANY + 256);
    assert_non_null(request);
    for (int n = 1000; n <= MANY; n += MANY - 1000) {
        int at =
            sprintf(request, "GET / HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nX: ", lf_gateway_port(g));
        memset(request + at, 'x', (size_t)n);
        strcpy(request + at + n, "\r\n\r\n");
        check_raw(g, request, n == 1000 ? 200 : 431);
    }
    free(request);
}

static void the_token_becomes_a_cookie(void **state)
{
    gateway *g = *state;
    char cookie[160], wrong[128];
    const char *answer = lf_caller_get(g, "POST /api/login HTTP/1.1", bearer(g));
    assert_int_equal(lf_caller_status(answer), 204);
    assert_non_null(strstr(answer, "; SameSite=Strict; HttpOnly; Path=/\r\n"));
    assert_null(strstr(answer, lf_gateway_token(g)));
    snprintf(cookie, sizeof cookie, "Cookie: %s\r\n", lf_gateway_cookie(g));
    check_status(g, "GET /api/status HTTP/1.1", cookie, 200);
    check_status(g, "GET /api/status HTTP/1.1", bearer(g), 200);
    check_status(g, "GET /api/status HTTP/1.1", "", 401);
    check_status(g, "GET /preview.jpg HTTP/1.1", "", 401);
    check_status(g, "POST /api/login HTTP/1.1", "", 401);
    snprintf(wrong, sizeof wrong, "Authorization: Bearer %.31s%c\r\n", lf_gateway_token(g),
             lf_gateway_token(g)[31] == '0' ? '1' : '0');
    check_status(g, "POST /api/login HTTP/1.1", wrong, 401);
    check_status(g, "GET /api/status HTTP/1.1", wrong, 401);
}

/* An <img> of a page on another port of this machine brings the cookie along. */
static void a_cookie_reads_for_its_own_page_alone(void **state)
{
    gateway *g = *state;
    static const struct {
        const char *site;
        int status;
    } rows[] = {{"", 200},
                {"Sec-Fetch-Site: same-origin\r\n", 200},
                {"Sec-Fetch-Site: none\r\n", 200}, /* the address bar */
                {"Sec-Fetch-Site: same-site\r\n", 401},
                {"Sec-Fetch-Site: cross-site\r\n", 401},
                {"Sec-Fetch-Site: cross-site\r\nSec-Fetch-Site: none\r\n", 401}};
    static const char *const lines[] = {"GET /api/status HTTP/1.1", "GET /preview.jpg HTTP/1.1",
                                        "GET /api/thumbnail?file=/a HTTP/1.1"};
    char headers[256], cookie[160];
    snprintf(cookie, sizeof cookie, "%s", lf_gateway_cookie(g));
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        for (size_t k = 0; k < sizeof lines / sizeof lines[0]; k++) {
            snprintf(headers, sizeof headers, "Cookie: %s\r\n%s", cookie, rows[i].site);
            check_status(g, lines[k], headers, rows[i].status);
            snprintf(headers, sizeof headers, "%s%s", bearer(g), rows[i].site);
            check_status(g, lines[k], headers, 200);
        }
}

static void status_and_preview_come_from_quiltd(void **state)
{
    gateway *g = *state;
    const char *answer = lf_caller_get(g, "GET /api/status HTTP/1.1", bearer(g));
    assert_non_null(strstr(answer, "\r\n\r\n{\"state\":\"rendering\",\"generation\":7}"));
    answer = lf_caller_get(g, "GET /preview.jpg HTTP/1.1", bearer(g));
    assert_int_equal(lf_caller_status(answer), 200);
    assert_non_null(strstr(answer, "Content-Type: image/jpeg\r\n"));
    assert_non_null(strstr(answer, "\r\n\r\n\xff\xd8 an image"));
    assert_int_equal(lf_gateway_calls(g, "frame.get"), 1);
}

/* A quiltd that leaves while it is asked is an answer, too. */
static void a_quiltd_that_leaves_is_told(void **state)
{
    gateway *g = *state;
    char request[256], answer[512] = "";
    lf_gateway_answer_images(g, false);
    int fd = lf_caller_connect(g);
    snprintf(request, sizeof request, "GET /preview.jpg HTTP/1.1\r\nHost: localhost:%d\r\n%s\r\n",
             lf_gateway_port(g), bearer(g));
    assert_true(lf_caller_send(fd, request, strlen(request)));
    while (lf_gateway_calls(g, "frame.get") == 0)
        usleep(1000);
    lf_gateway_hang_up(g);
    assert_true(recv(fd, answer, sizeof answer - 1, MSG_WAITALL) > 0);
    assert_int_equal(lf_caller_status(answer), 503);
    close(fd);
}

/* A gateway that ends while a browser waits for an image leaves nothing behind. */
static void an_end_while_an_image_is_awaited_is_clean(void **state)
{
    gateway *g = *state;
    char request[256];
    lf_gateway_answer_images(g, false);
    int fd = lf_caller_connect(g);
    snprintf(request, sizeof request, "GET /preview.jpg HTTP/1.1\r\nHost: localhost:%d\r\n%s\r\n",
             lf_gateway_port(g), bearer(g));
    assert_true(lf_caller_send(fd, request, strlen(request)));
    while (lf_gateway_calls(g, "frame.get") == 0)
        usleep(1000);
    close(fd);
}

/* The server with TLS keeps the Host; the browser then sends the cookie over https alone. */
static void the_public_page_has_a_secure_cookie(void **state)
{
    gateway *g = *state;
    char request[512], cookie[160];
    snprintf(request, sizeof request, "https://panel.test/#%s", lf_gateway_token(g));
    assert_string_equal(lf_gateway_url(g), request);
    snprintf(request, sizeof request,
             "POST /api/login HTTP/1.1\r\nHost: panel.test\r\nOrigin: https://panel.test\r\n%s\r\n",
             bearer(g));
    const char *answer = lf_caller_ask(g, request);
    assert_int_equal(lf_caller_status(answer), 204);
    assert_non_null(strstr(answer, "; SameSite=Strict; HttpOnly; Path=/; Secure\r\n"));
    snprintf(cookie, sizeof cookie, "%s", lf_gateway_cookie(g)); /* of the plain page */
    answer = lf_caller_get(g, "POST /api/login HTTP/1.1", bearer(g));
    assert_non_null(strstr(answer, "; SameSite=Strict; HttpOnly; Path=/\r\n"));
    static const struct {
        const char *line, *origin, *more;
        int status;
    } rows[] = {
        {"GET /api/status", "https://panel.test", "", 200},
        {"PUT /api/upload?name=a", "https://panel.test", "Content-Length: 0\r\n", 201},
        {"PUT /api/upload?name=a", "http://panel.test", "Content-Length: 0\r\n", 403},
        {"PUT /api/upload?name=a", "https://evil.test", "Content-Length: 0\r\n", 403},
        {"GET /rpc", "https://panel.test", "", 426},
        {"GET /rpc", "http://panel.test", "", 403},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        snprintf(request, sizeof request,
                 "%s HTTP/1.1\r\nHost: panel.test\r\nOrigin: %s\r\nCookie: %s\r\n%s\r\n",
                 rows[i].line, rows[i].origin, cookie, rows[i].more);
        check_raw(g, request, rows[i].status);
    }
}

/* Eight short calls of quiltd at once. */
static void the_ninth_call_is_refused(void **state)
{
    gateway *g = *state;
    enum { MOST = 8 };
    int fds[MOST];
    lf_gateway_answer_images(g, false);
    for (int i = 0; i < MOST; i++)
        fds[i] = lf_caller_begin(g, "GET /preview.jpg HTTP/1.1", "");
    while (lf_gateway_calls(g, "frame.get") < MOST)
        usleep(1000);
    check_status(g, "GET /api/status HTTP/1.1", bearer(g), 503);
    lf_gateway_hang_up(g);
    for (int i = 0; i < MOST; i++)
        assert_int_equal(lf_caller_status(lf_caller_rest(fds[i])), 503);
    check_status(g, "GET /api/status HTTP/1.1", bearer(g), 200);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_gateway_test(every_answer_keeps_other_pages_out),
        lf_gateway_test(only_pages_are_served),
        lf_gateway_test(another_host_is_misdirected),
        lf_gateway_test(another_origin_is_refused),
        lf_gateway_test(bodies_are_refused_before_they_come),
        lf_gateway_test(headers_are_bounded),
        lf_gateway_test(the_token_becomes_a_cookie),
        lf_gateway_test(a_cookie_reads_for_its_own_page_alone),
        lf_gateway_test(status_and_preview_come_from_quiltd),
        lf_gateway_public_test(the_public_page_has_a_secure_cookie),
        lf_gateway_test(the_ninth_call_is_refused),
        lf_gateway_test(a_quiltd_that_leaves_is_told),
        lf_gateway_test(an_end_while_an_image_is_awaited_is_clean),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
