/* What tests with a clock of their own need: an event loop, and a quiltd that says what the test
 * says. */
#ifndef LF_TESTS_WEB_TOLD_QUILTD_H
#define LF_TESTS_WEB_TOLD_QUILTD_H

#include "tests/web/clock.h"

#include <errno.h>
#include <sys/socket.h>
#include <sys/un.h>

static sd_event *event;

static inline int setup(void **state)
{
    (void)state;
    assert_true(sd_event_new(&event) >= 0);
    return 0;
}

static inline int teardown(void **state)
{
    (void)state;
    lf_clock_finish();
    event = sd_event_unref(event);
    return 0;
}

/* Nothing came, and the other side is there. */
static inline bool is_open(int fd)
{
    char byte;
    return recv(fd, &byte, 1, MSG_DONTWAIT | MSG_PEEK) < 0 && errno == EAGAIN;
}

/* Takes all that is there. */
static inline size_t drain(int fd)
{
    static char taken[1 << 16];
    size_t all = 0;
    for (ssize_t n; (n = recv(fd, taken, sizeof taken, MSG_DONTWAIT)) > 0;)
        all += (size_t)n;
    return all;
}

/* A quiltd that says what the test says: its listening socket, at a path in a folder. */
static inline int listen_as_quiltd(const char *folder, char path[108])
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    assert_true(snprintf(path, 108, "%s/sock", folder) < 108);
    memcpy(address.sun_path, path, sizeof address.sun_path);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    assert_int_equal(bind(fd, (const struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(fd, 16), 0);
    return fd;
}

/* What came of the gateway since the last call, terminated, in a static buffer; a descriptor that
 * came with it in *out_fd, if it is wanted. */
static inline const char *hear(int fd, int *out_fd)
{
    static char text[4096];
    union {
        struct cmsghdr align;
        char bytes[CMSG_SPACE(sizeof(int))];
    } control;
    size_t used = 0;
    lf_clock_settle(event);
    for (ssize_t n = 1; n > 0; used += n > 0 ? (size_t)n : 0) {
        struct iovec vector = {text + used, sizeof text - 1 - used};
        struct msghdr message = {.msg_iov = &vector,
                                 .msg_iovlen = 1,
                                 .msg_control = &control,
                                 .msg_controllen = sizeof control};
        n = recvmsg(fd, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
        const struct cmsghdr *c = n > 0 ? CMSG_FIRSTHDR(&message) : NULL;
        int passed = -1;
        if (!c)
            continue;
        memcpy(&passed, CMSG_DATA(c), sizeof passed);
        if (out_fd)
            *out_fd = passed;
        else
            close(passed);
    }
    text[used] = '\0';
    return text;
}

static inline void say(int fd, const char *text)
{
    for (size_t n = strlen(text); n > 0;) {
        ssize_t sent = send(fd, text, n, MSG_DONTWAIT | MSG_NOSIGNAL);
        text += sent > 0 ? sent : 0;
        n -= sent > 0 ? (size_t)sent : 0;
        lf_clock_settle(event);
    }
}

/* Answers the call that limits rights; all other calls wait for it. */
static inline void limit_rights(int quiltd)
{
    const char *call = hear(quiltd, NULL);
    assert_non_null(strstr(call, "rights.limit"));
    assert_ptr_equal(strchr(call, '\n') + 1, call + strlen(call));
    say(quiltd, "{\"jsonrpc\":\"2.0\",\"id\":\"quiltweb:rights\",\"result\":{}}\n");
}

#define timed(test) cmocka_unit_test_setup_teardown(test, setup, teardown)

#endif
