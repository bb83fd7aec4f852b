/* A quiltd of the test's own, and a client that passes descriptors. */
#ifndef LF_TESTS_DAEMON_SENDER_H
#define LF_TESTS_DAEMON_SENDER_H

#include "tests/daemon/live.h"

#include <sys/mman.h>

typedef struct sender {
    live l;
    live_client c;
} sender;

static inline void begin(sender *s)
{
    live_prepare(&s->l);
    live_start(&s->l, s->l.scene, "--device", "none", "--state", s->l.state, NULL);
    live_connect(&s->l, &s->c);
    json_decref(live_call(&s->c, "wait", NULL));
}

static inline void end(sender *s)
{
    live_close(&s->c);
    live_finish(&s->l);
}

/* A call with descriptors, which are closed: its answer. */
static inline json_t *call_with(sender *s, const char *method, json_t *params, const int *fds,
                                int n)
{
    union {
        struct cmsghdr align;
        char bytes[CMSG_SPACE(8 * sizeof(int))];
    } control = {.bytes = {0}};
    json_t *request = json_pack("{s:s, s:I, s:s, s:o}", "jsonrpc", "2.0", "id", ++s->c.ids,
                                "method", method, "params", params);
    char *text = json_dumps(request, JSON_COMPACT);
    json_decref(request);
    struct iovec vector = {.iov_base = text, .iov_len = 1};
    struct msghdr message = {.msg_iov = &vector, .msg_iovlen = 1};
    if (n > 0) {
        message.msg_control = &control;
        message.msg_controllen = CMSG_SPACE((size_t)n * sizeof(int));
        struct cmsghdr *c = CMSG_FIRSTHDR(&message);
        c->cmsg_level = SOL_SOCKET;
        c->cmsg_type = SCM_RIGHTS;
        c->cmsg_len = CMSG_LEN((size_t)n * sizeof(int));
        memcpy(CMSG_DATA(c), fds, (size_t)n * sizeof(int));
    }
    assert_int_equal(sendmsg(s->c.fd, &message, MSG_NOSIGNAL), 1);
    live_send(&s->c, text + 1, strlen(text) - 1);
    live_send(&s->c, "\n", 1);
    free(text);
    for (int i = 0; i < n; i++)
        close(fds[i]);
    return live_answer(&s->c);
}

/* Fails unless a call is answered with this code (0: a result) in one line that holds these words.
 */
static inline void assert_code(sender *s, const char *method, json_t *params, const int *fds, int n,
                               int code, const char *words)
{
    json_t *answer = call_with(s, method, params, fds, n);
    const json_t *error = json_object_get(answer, "error");
    const char *said = json_string_value(json_object_get(error, "message"));
    if (json_integer_value(json_object_get(error, "code")) != code ||
        (code != 0 && (!strstr(said, words) || strchr(said, '\n'))))
        fail_msg("%d \"%s\": %s", code, words, said ? said : "a result");
    json_decref(answer);
}

static inline int memory_file(const void *bytes, size_t n, int seals)
{
    int fd = memfd_create("sent", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    assert_true(fd >= 0);
    for (size_t done = 0; done < n;) {
        const ssize_t written = write(fd, (const char *)bytes + done, n - done);
        assert_true(written > 0);
        done += (size_t)written;
    }
    if (seals)
        assert_int_equal(fcntl(fd, F_ADD_SEALS, seals), 0);
    return fd;
}

#define ALL_SEALS (F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW)

#endif
