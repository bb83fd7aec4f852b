/* Addresses to listen on, and connections that never end their request. */
#include "tests/web/gateway.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "daemon/web/web.h"
#include "tests/daemon/soon.h"

static void only_loopback_is_listened_on(void **state)
{
    (void)state;
    static const char *const wrong[] = {
        "0.0.0.0:80",      "127.0.0.1",      "[::]:0", "localhost:1",
        "127.0.0.1:65536", "127.0.0.1:-1",   "",       "8033",
        "127.0.0.1:80x",   "192.168.1.1:80", "[::1]"};
    lf_error err = {0};
    int fd = -1;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        lf_assert_status(lf_web_listen(wrong[i], &fd, &err), LF_E_ARG, &err);
    assert_int_equal(fd, -1);
    lf_assert_ok(lf_web_listen("127.0.0.1:0", &fd, &err), &err);
    struct sockaddr_in address;
    socklen_t size = sizeof address;
    char again[32];
    int second = -1;
    assert_int_equal(getsockname(fd, (struct sockaddr *)&address, &size), 0);
    snprintf(again, sizeof again, "127.0.0.1:%d", ntohs(address.sin_port));
    lf_assert_status(lf_web_listen(again, &second, &err), LF_E_BUSY, &err);
    close(fd);
}

/* What systemd passes may be anything. */
static void a_socket_for_everybody_is_refused(void **state)
{
    (void)state;
    struct sockaddr_in address = {.sin_family = AF_INET};
    lf_error err = {0};
    sd_event *event = NULL;
    lf_web *web = NULL;
    int fd = socket(AF_INET, SOCK_STREAM, 0);
    assert_true(sd_event_new(&event) >= 0);
    assert_int_equal(bind(fd, (struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(fd, 1), 0);
    lf_assert_status(lf_web_create(event, fd, "/nowhere", &web, &err), LF_E_ARG, &err);
    fd = socket(AF_UNIX, SOCK_STREAM, 0);
    lf_assert_status(lf_web_create(event, fd, "/nowhere", &web, &err), LF_E_ARG, &err);
    lf_assert_ok(lf_web_listen("127.0.0.1:0", &fd, &err), &err);
    lf_assert_ok(lf_web_create(event, fd, "/nowhere", &web, &err), &err);
    assert_memory_equal(lf_web_url(web), "http://127.0.0.1:", 17);
    assert_int_equal(strlen(strchr(lf_web_url(web), '#') + 1), 32);
    lf_web_destroy(web);
    sd_event_unref(event);
}

/* Timers of this program are due at once. */
static void a_request_that_does_not_end_is_dropped(void **state)
{
    gateway *g = *state;
    enum { MOST = 20000 };
    char answer[64];
    int fd = lf_caller_connect(g);
    int n = 0; /* a byte now and then, so that it is never idle */
    assert_true(lf_caller_send(fd, "GET / HTTP/1.1\r\nX: ", 19));
    while (n < MOST && lf_caller_send(fd, "x", 1) &&
           recv(fd, answer, sizeof answer, MSG_DONTWAIT) < 0 && errno == EAGAIN) {
        usleep(1000);
        n++;
    }
    assert_true(n < MOST);
    close(fd);
    fd = lf_caller_connect(g); /* and one that says nothing */
    assert_true(recv(fd, answer, sizeof answer, 0) <= 0);
    close(fd);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_loopback_is_listened_on),
        cmocka_unit_test(a_socket_for_everybody_is_refused),
        lf_gateway_test(a_request_that_does_not_end_is_dropped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
