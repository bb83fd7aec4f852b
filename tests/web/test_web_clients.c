/* Clients that take too long, and those that wait because of them. Time passes when the test says
 * so. */
#include "tests/web/told_quiltd.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include "daemon/web/downloads.h"
#include "daemon/web/listen.h"
#include "daemon/web/patience.h"
#include "daemon/web/stream.h"
#include "daemon/web/web.h"

static lf_web *begin_web_for(const char *path)
{
    lf_error err = {0};
    lf_web *web = NULL;
    lf_web_config config = {
        .services[LF_SERVICE_PAGE].n = 1, .socket = path, .upload_limit = 1 << 20};
    lf_assert_ok(lf_web_listen("127.0.0.1:0", &config.services[LF_SERVICE_PAGE].fd[0], &err), &err);
    lf_assert_ok(lf_web_create(event, &config, &web, &err), &err);
    return web;
}

static lf_web *begin_web(void)
{
    return begin_web_for("/nowhere");
}

static int connect_client(const lf_web *web)
{
    const struct sockaddr_in address = {.sin_family = AF_INET,
                                        .sin_port =
                                            htons((uint16_t)lf_web_port(web, LF_SERVICE_PAGE)),
                                        .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(connect(fd, (const struct sockaddr *)&address, sizeof address), 0);
    lf_clock_settle(event);
    return fd;
}

/* A client that has sent its headers. */
static int begin_client(const lf_web *web, const char *line, const char *headers)
{
    char request[512];
    int fd = connect_client(web);
    const int n =
        snprintf(request, sizeof request,
                 "%s HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nAuthorization: Bearer %s\r\n%s\r\n", line,
                 lf_web_port(web, LF_SERVICE_PAGE), strchr(lf_web_url(web), '#') + 1, headers);
    assert_int_equal(send(fd, request, (size_t)n, MSG_NOSIGNAL), n);
    return fd;
}

static void a_body_may_take_long_if_it_moves(void **state)
{
    (void)state;
    static char part[LF_PATIENCE_BYTES];
    lf_web *web = begin_web();
    char answer[64] = "";
    int fast = begin_client(web, "PUT /api/upload?name=a", "Content-Length: 196608\r\n");
    int slow = begin_client(web, "PUT /api/upload?name=b", "Content-Length: 196608\r\n");
    for (int i = 0; i < 3; i++) {
        assert_int_equal(send(fast, part, sizeof part, MSG_NOSIGNAL), sizeof part);
        assert_true(i > 0 || send(slow, part, sizeof part - 1, MSG_NOSIGNAL) > 0);
        lf_clock_settle(event);
        if (i < 2) {
            lf_clock_pass(event, 10);
            assert_true(is_open(fast));
            assert_false(is_open(slow));
        }
    }
    assert_true(recv(fast, answer, sizeof answer - 1, MSG_DONTWAIT) > 0);
    assert_memory_equal(answer, "HTTP/1.1 201", 12);
    close(fast);
    close(slow);
    lf_web_destroy(web);
}

/* A client of the web, behind which quiltd does what the test says. */
typedef struct behind {
    char *folder, path[108];
    int listener, quiltd;
    lf_web *web;
} behind;

static behind begin_behind(void)
{
    behind b = {.folder = lf_test_folder(), .quiltd = -1};
    b.listener = listen_as_quiltd(b.folder, b.path);
    b.web = begin_web_for(b.path);
    return b;
}

static void end_behind(const behind *b)
{
    lf_web_destroy(b->web);
    close(b->quiltd);
    close(b->listener);
    lf_test_folder_remove(b->folder);
}

static void check_refused(int fd, int status)
{
    char answer[13] = "", expected[16];
    snprintf(expected, sizeof expected, "HTTP/1.1 %d", status);
    assert_int_equal(recv(fd, answer, 12, MSG_DONTWAIT), 12);
    assert_string_equal(answer, expected);
    close(fd);
}

/* What quiltd has for an answer, by the request. */
static void a_quiltd_that_hangs_is_given_up(void **state)
{
    (void)state;
    static const struct {
        const char *line, *headers;
        int seconds;
    } rows[] = {{"GET /api/status", "", 8},
                {"GET /preview.jpg", "", 8},
                {"GET /preview.mjpg", "", 8},
                {"PUT /api/quilt?cols=1&rows=1", "Content-Length: 0\r\n", 60}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        behind b = begin_behind();
        int fd = begin_client(b.web, rows[i].line, rows[i].headers);
        lf_clock_settle(event);
        b.quiltd = accept(b.listener, NULL, NULL);
        limit_rights(b.quiltd);
        lf_clock_pass(event, rows[i].seconds - 0.1);
        assert_true(is_open(fd));
        lf_clock_pass(event, 0.1);
        check_refused(fd, 503);
        end_behind(&b);
    }
}

/* Nothing, and the beginning of headers. */
static void a_connection_has_ten_seconds_for_its_request(void **state)
{
    (void)state;
    lf_web *web = begin_web();
    int silent = connect_client(web), slow = connect_client(web);
    assert_int_equal(send(slow, "GET / HTTP/1.1\r\nX: ", 19, MSG_NOSIGNAL), 19);
    lf_clock_pass(event, 9.9);
    assert_true(is_open(silent) && is_open(slow));
    lf_clock_pass(event, 0.1);
    assert_false(is_open(silent) || is_open(slow));
    close(silent);
    close(slow);
    lf_web_destroy(web);
}

/* A stream is repeated as long as quiltd answers, and ends if it does not. */
static void a_stream_ends_with_a_quiltd_that_hangs(void **state)
{
    (void)state;
    static const char answer[] =
        "{\"jsonrpc\":\"2.0\",\"id\":\"quiltweb:stream\",\"result\":{\"columns\":1,\"rows\":1,"
        "\"views\":1,\"width\":2,\"height\":2,\"bytes\":5}}\n";
    behind b = begin_behind();
    int file = -1, fd = begin_client(b.web, "GET /preview.mjpg", "");
    lf_clock_settle(event);
    b.quiltd = accept(b.listener, NULL, NULL);
    limit_rights(b.quiltd);
    assert_non_null(strstr(hear(b.quiltd, &file), "frame.get"));
    assert_int_equal(write(file, "image", 5), 5);
    close(file);
    say(b.quiltd, answer);
    for (int s = 0; s <= 70; s += LF_STREAM_REPEAT_S) {
        assert_true(drain(fd) > 0);
        lf_clock_pass(event, LF_STREAM_REPEAT_S);
    }
    say(b.quiltd, "{\"jsonrpc\":\"2.0\",\"method\":\"frame\",\"params\":{}}\n");
    assert_non_null(strstr(hear(b.quiltd, NULL), "frame.get")); /* and no answer */
    (void)drain(fd);
    for (int s = 0; s < 50; s += LF_STREAM_REPEAT_S)
        lf_clock_pass(event, LF_STREAM_REPEAT_S);
    assert_true(is_open(fd));
    for (int s = 50; s < 70; s += LF_STREAM_REPEAT_S)
        lf_clock_pass(event, LF_STREAM_REPEAT_S);
    assert_false(is_open(fd));
    assert_false(is_open(b.quiltd)); /* its place is free */
    close(fd);
    end_behind(&b);
}

static void send_text(int fd, const char *text)
{
    enum { LENGTH = 200 };
    char frame[8 + LENGTH + 1] = {'\x81', (char)(0x80 | 126), 0,
                                  (char)LENGTH}; /* its mask is zero */
    snprintf(frame + 8, LENGTH + 1, "%-*s", LENGTH, text);
    assert_int_equal(send(fd, frame, 8 + LENGTH, MSG_NOSIGNAL), 8 + LENGTH);
    lf_clock_settle(event);
}

/* The path of an export of so many bytes. */
static const char *export_file(behind *b, off_t bytes)
{
    int file = -1, fd = begin_client(b->web, "GET /rpc",
                                     "Upgrade: websocket\r\nConnection: Upgrade\r\n"
                                     "Sec-WebSocket-Version: 13\r\n"
                                     "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n");
    static char text[4096];
    lf_clock_settle(event);
    b->quiltd = accept(b->listener, NULL, NULL);
    limit_rights(b->quiltd);
    send_text(fd,
              "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"export\",\"params\":{\"kind\":\"still\","
              "\"file\":\"a.png\"}}");
    assert_non_null(strstr(hear(b->quiltd, &file), "\"export\""));
    assert_int_equal(ftruncate(file, bytes), 0);
    close(file);
    say(b->quiltd, "{\"jsonrpc\":\"2.0\",\"id\":\"quiltweb:export:1\",\"result\":{\"job\":1}}\n"
                   "{\"jsonrpc\":\"2.0\",\"method\":\"export\",\"params\":{\"job\":1,"
                   "\"state\":\"done\"}}\n");
    char *path = NULL;
    for (size_t used = 0; !path || !strchr(path, '"'); path = strstr(text, LF_DOWNLOADS_PREFIX)) {
        const ssize_t n = recv(fd, text + used, sizeof text - 1 - used, 0);
        assert_true(n > 0);
        for (ssize_t i = 0; i < n; i++) /* heads of frames */
            text[used + (size_t)i] = text[used + (size_t)i] ? text[used + (size_t)i] : ' ';
        used += (size_t)n;
        text[used] = '\0';
    }
    path[strcspn(path, "\"")] = '\0';
    close(fd);
    return path;
}

/* One that takes a part in each minute would hold a large file for days. */
static void a_download_needs_a_mean_rate(void **state)
{
    (void)state;
    enum { SIZE = 1 << 28, PERIODS = 60, PART = 1 << 20 };
    static char part[PART];
    char line[256];
    behind b = begin_behind();
    snprintf(line, sizeof line, "GET %s", export_file(&b, SIZE));
    for (int fast = 1; fast >= 0; fast--) {
        ssize_t n = 1;
        size_t taken = 0;
        int fd = begin_client(b.web, line, ""), periods = 0;
        for (; periods < PERIODS && n > 0; periods++) {
            for (int i = 0; i < (fast ? 16 : 1) && n > 0; i++) {
                lf_clock_settle(event);
                n = recv(fd, part, sizeof part, MSG_DONTWAIT);
                taken += n > 0 ? (size_t)n : 0;
            }
            lf_clock_pass(event, 60);
        }
        assert_true(fast ? taken > SIZE : taken < SIZE / 2);
        close(fd);
    }
    end_behind(&b);
}

/* Clients that only connect do not keep others out. */
static void the_oldest_silent_connection_makes_room(void **state)
{
    (void)state;
    lf_web *web = begin_web();
    int fds[LF_WEB_MAX_CONNECTIONS];
    char answer[64] = "";
    fds[0] = begin_client(web, "PUT /api/upload?name=a", "Content-Length: 10\r\n");
    for (int i = 1; i < LF_WEB_MAX_CONNECTIONS; i++)
        fds[i] = connect_client(web);
    for (int i = 0; i < LF_WEB_MAX_CONNECTIONS; i++)
        assert_true(is_open(fds[i]));
    int fd = begin_client(web, "GET /", "");
    lf_clock_settle(event);
    assert_true(recv(fd, answer, sizeof answer - 1, MSG_DONTWAIT) > 0);
    assert_memory_equal(answer, "HTTP/1.1 200", 12);
    for (int i = 0; i < LF_WEB_MAX_CONNECTIONS; i++) {
        assert_int_equal(is_open(fds[i]), i != 1);
        close(fds[i]);
    }
    close(fd);
    lf_web_destroy(web);
}

/* Nobody waits any more for one whose time is over. */
static void a_late_thumbnail_is_not_asked_for(void **state)
{
    (void)state;
    enum { AT_ONCE = 4, ALL = 2 * AT_ONCE + 1 };
    char *folder = lf_test_folder(), path[108], answer[16] = "";
    int listener = listen_as_quiltd(folder, path), fds[ALL], quiltd, n = 0;
    lf_web *web = begin_web_for(path);
    for (int i = 0; i < ALL; i++) {
        fds[i] = begin_client(web, "GET /api/thumbnail?file=/a", "");
        lf_clock_settle(event);
    }
    lf_clock_pass(event, 8); /* the first ones are given up, and the next ones asked for */
    for (int i = 0; i < AT_ONCE; i++) {
        assert_int_equal(recv(fds[i], answer, 12, 0), 12);
        assert_string_equal(answer, "HTTP/1.1 503");
    }
    lf_clock_pass(event, 8);
    for (int i = AT_ONCE; i < ALL; i++)
        assert_false(is_open(fds[i]));
    while ((quiltd = accept(listener, NULL, NULL)) >= 0) {
        close(quiltd);
        n++;
    }
    assert_int_equal(n, 2 * AT_ONCE);
    for (int i = 0; i < ALL; i++)
        close(fds[i]);
    lf_web_destroy(web);
    close(listener);
    lf_test_folder_remove(folder);
}

/* What has come but was not read at the end is not answered any more. */
static void nobody_is_let_in_at_the_end(void **state)
{
    (void)state;
    lf_web *web = begin_web();
    char byte;
    int fd = begin_client(web, "GET /", "");
    int socket = begin_client(web, "GET /rpc",
                              "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: "
                              "13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n");
    lf_clock_settle(event);
    assert_int_equal(recv(fd, &byte, 1, MSG_DONTWAIT), 1); /* before the end, it is */
    assert_int_equal(recv(socket, &byte, 1, MSG_DONTWAIT), 1);
    close(fd);
    close(socket);
    fd = begin_client(web, "GET /", "");
    lf_web_destroy(web);
    assert_true(recv(fd, &byte, 1, 0) <= 0);
    close(fd);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        timed(a_body_may_take_long_if_it_moves),
        timed(the_oldest_silent_connection_makes_room),
        timed(a_quiltd_that_hangs_is_given_up),
        timed(a_connection_has_ten_seconds_for_its_request),
        timed(a_stream_ends_with_a_quiltd_that_hangs),
        timed(a_download_needs_a_mean_rate),
        timed(a_late_thumbnail_is_not_asked_for),
        timed(nobody_is_let_in_at_the_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
