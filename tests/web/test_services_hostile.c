/* Hostile clients at every service: many, slow ones, and such that send much. Time passes when the
 * test says so. */
#include "tests/web/told_quiltd.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include "daemon/web/listen.h"
#include "daemon/web/web.h"

/* What a service answers to a large body. */
static const struct {
    lf_service service;
    const char *line;
    int status;
} rows[] = {
    {LF_SERVICE_PAGE, "PUT /api/upload?name=a", 413},
    {LF_SERVICE_PAGE, "PUT /api/quilt?cols=1&rows=1", 413},
    {LF_SERVICE_PAGE, "POST /api/login", 413},
    {LF_SERVICE_PAGE, "GET /", 413},
    {LF_SERVICE_BRIDGE, "PUT /bridge_version", 413},
    {LF_SERVICE_BRIDGE, "PUT /insert_playlist_entry", 413},
    {LF_SERVICE_BRIDGE, "PUT /no_such_endpoint", 413},
    {LF_SERVICE_BRIDGE, "GET /", 413},
    {LF_SERVICE_EVENTS, "PUT /event_source", 413},
    {LF_SERVICE_EVENTS, "GET /event_source", 413},
    {LF_SERVICE_EVENTS, "GET /", 413},
    {LF_SERVICE_WEBXR, "PUT /driver", 413},
    {LF_SERVICE_WEBXR, "GET /driver", 413},
    {LF_SERVICE_WEBXR, "GET /", 413},
};
enum { N_ROWS = sizeof rows / sizeof rows[0] };

static lf_web *begin_web(void)
{
    lf_error err = {0};
    lf_web *web = NULL;
    lf_web_config config = {.socket = "/nowhere", .upload_limit = 1 << 20};
    for (lf_service service = LF_SERVICE_PAGE; service < LF_SERVICES; service++) {
        config.services[service].n = 1;
        lf_assert_ok(lf_web_listen("127.0.0.1:0", &config.services[service].fd[0], &err), &err);
    }
    lf_assert_ok(lf_web_create(event, &config, &web, &err), &err);
    return web;
}

static int connect_client(const lf_web *web, lf_service service)
{
    const struct sockaddr_in address = {.sin_family = AF_INET,
                                        .sin_port = htons((uint16_t)lf_web_port(web, service)),
                                        .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_true(fd >= 0);
    assert_int_equal(connect(fd, (const struct sockaddr *)&address, sizeof address), 0);
    return fd;
}

/* The status that a service answers to a request with these headers; 0: none. */
static int status_of(const lf_web *web, lf_service service, const char *line, const char *headers)
{
    char request[512], answer[64] = "";
    int fd = connect_client(web, service);
    const int n =
        snprintf(request, sizeof request,
                 "%s HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nAuthorization: Bearer %s\r\n%s\r\n", line,
                 lf_web_port(web, service), strchr(lf_web_url(web), '#') + 1, headers);
    assert_int_equal(send(fd, request, (size_t)n, MSG_NOSIGNAL), n);
    lf_clock_settle(event);
    const ssize_t got = recv(fd, answer, sizeof answer - 1, MSG_DONTWAIT);
    close(fd);
    return got > 9 && strncmp(answer, "HTTP/1.1 ", 9) == 0 ? atoi(answer + 9) : 0;
}

static void every_service_has_a_row(void **state)
{
    (void)state;
    for (lf_service service = LF_SERVICE_PAGE; service < LF_SERVICES; service++) {
        bool found = false;
        for (int i = 0; i < N_ROWS; i++)
            found = found || rows[i].service == service;
        assert_true(found);
    }
}

/* A gigabyte is refused by its length, and a body without one by its coding. */
static void a_large_body_is_refused_before_it_comes(void **state)
{
    (void)state;
    lf_web *web = begin_web();
    for (int i = 0; i < N_ROWS; i++) {
        const int large =
            status_of(web, rows[i].service, rows[i].line, "Content-Length: 1073741824\r\n");
        const int coded =
            status_of(web, rows[i].service, rows[i].line, "Transfer-Encoding: chunked\r\n");
        if (large != rows[i].status || coded != 400)
            fail_msg("service %d, %s: %d and %d, expected %d and 400", rows[i].service,
                     rows[i].line, large, coded, rows[i].status);
    }
    lf_web_destroy(web);
}

/* Nothing, headers that come byte by byte, and a body that does not. */
static void a_slow_client_has_ten_seconds(void **state)
{
    (void)state;
    static const char begin[] = "GET / HTTP/1.1\r\nX: ";
    for (lf_service service = LF_SERVICE_PAGE; service < LF_SERVICES; service++) {
        lf_web *web = begin_web();
        int silent = connect_client(web, service), slow = connect_client(web, service);
        lf_clock_settle(event);
        assert_int_equal(send(slow, begin, strlen(begin), MSG_NOSIGNAL), strlen(begin));
        for (int second = 0; second < 10; second++) {
            lf_clock_settle(event);
            assert_true(is_open(silent) && is_open(slow));
            assert_int_equal(send(slow, "x", 1, MSG_NOSIGNAL), 1);
            lf_clock_pass(event, 1);
        }
        assert_false(is_open(silent) || is_open(slow));
        close(silent);
        close(slow);
        lf_web_destroy(web);
    }
}

/* They come faster than they are given up, at one service, and keep nobody out at any. */
static void ten_thousand_connections_keep_nobody_out(void **state)
{
    (void)state;
    enum { ALL = 10000, HELD = 200, AT_ONCE = 30 };
    for (lf_service service = LF_SERVICE_PAGE; service < LF_SERVICES; service++) {
        lf_web *web = begin_web();
        int held[HELD];
        for (int i = 0; i < HELD; i++)
            held[i] = -1;
        for (int i = 0; i < ALL / LF_SERVICES; i++) {
            if (held[i % HELD] >= 0)
                close(held[i % HELD]);
            held[i % HELD] = connect_client(web, service);
            if (i % AT_ONCE == 0)
                lf_clock_settle(event);
        }
        for (lf_service other = LF_SERVICE_PAGE; other < LF_SERVICES; other++)
            assert_int_equal(status_of(web, other, "GET /", ""), 200);
        for (int i = 0; i < HELD; i++)
            close(held[i]);
        lf_web_destroy(web);
    }
}

/* Requests whose bodies do not come take the places of one service. */
static void the_places_of_a_service_are_its_own(void **state)
{
    (void)state;
    lf_web *web = begin_web();
    int held[LF_WEB_MAX_PROGRAMS];
    char text[128];
    const int n = snprintf(text, sizeof text,
                           "PUT /bridge_version HTTP/1.1\r\nHost: localhost:%d\r\n"
                           "Content-Length: 10\r\n\r\n",
                           lf_web_port(web, LF_SERVICE_BRIDGE));
    for (int i = 0; i < LF_WEB_MAX_PROGRAMS; i++) {
        held[i] = connect_client(web, LF_SERVICE_BRIDGE);
        assert_int_equal(send(held[i], text, (size_t)n, MSG_NOSIGNAL), n);
        lf_clock_settle(event);
    }
    for (lf_service service = LF_SERVICE_PAGE; service < LF_SERVICES; service++)
        assert_int_equal(status_of(web, service, "GET /", ""),
                         service == LF_SERVICE_BRIDGE ? 0 : 200);
    close(held[0]);
    lf_clock_settle(event);
    assert_int_equal(status_of(web, LF_SERVICE_BRIDGE, "GET /", ""), 200);
    for (int i = 1; i < LF_WEB_MAX_PROGRAMS; i++)
        close(held[i]);
    lf_web_destroy(web);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_service_has_a_row),
        cmocka_unit_test_setup_teardown(a_large_body_is_refused_before_it_comes, setup, teardown),
        cmocka_unit_test_setup_teardown(a_slow_client_has_ten_seconds, setup, teardown),
        cmocka_unit_test_setup_teardown(the_places_of_a_service_are_its_own, setup, teardown),
        cmocka_unit_test_setup_teardown(ten_thousand_connections_keep_nobody_out, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
