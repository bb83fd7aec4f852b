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
    live_ask_with(&s->c, method, params, fds, n);
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
