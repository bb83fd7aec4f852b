#include "daemon/tools/ctl.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/escape.h"
#include "base/thread.h"
#include "daemon/wire/client.h"
#include "daemon/wire/listen.h"

/* A line of the daemon is at most 1 MiB. */
#define MAX_ANSWER (LF_RPC_MAX_LINE + 4096)

struct lf_ctl {
    int fd;
    char path[512];
    char *buffer; /* [MAX_ANSWER] */
    size_t used, taken;
    double timeout, deadline; /* 0: none */
    json_int_t ids;
    json_t *notifications; /* array of notifications that came while waiting for an answer */
};

/* -------------------------------------------------------------------------------- connection -- */

static int try_connect(const char *path)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (strlen(path) >= sizeof address.sun_path) {
        errno = ENAMETOOLONG;
        return -1;
    }
    memcpy(address.sun_path, path, strlen(path) + 1);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd >= 0 && connect(fd, (const struct sockaddr *)&address, sizeof address) != 0) {
        int why = errno;
        close(fd);
        errno = why;
        return -1;
    }
    return fd;
}

lf_status lf_ctl_connect(const char *path, lf_ctl **out, lf_error *err)
{
    lf_ctl *ctl = lf_calloc(1, sizeof *ctl);
    char *buffer = lf_calloc(MAX_ANSWER, 1);
    json_t *list = json_array();
    if (!ctl || !buffer || !list) {
        lf_free(ctl);
        lf_free(buffer);
        json_decref(list);
        return lf_error_set(err, LF_E_NOMEM, "", "out of memory");
    }
    *ctl = (lf_ctl){.fd = -1, .buffer = buffer, .notifications = list};
    if (path) {
        snprintf(ctl->path, sizeof ctl->path, "%s", path);
        ctl->fd = try_connect(path);
    }
    char first[sizeof ctl->path];
    snprintf(first, sizeof first, "%s", ctl->path);
    int why = errno;
    for (int i = 0; !path && ctl->fd < 0 && lf_default_socket(i, ctl->path, sizeof ctl->path);
         i++) {
        ctl->fd = try_connect(ctl->path);
        if (i == 0) { /* the default with the highest priority */
            snprintf(first, sizeof first, "%s", ctl->path);
            why = errno;
        }
    }
    if (ctl->fd < 0) {
        lf_status status =
            lf_error_set(err, LF_E_NODEV, first,
                         "no quiltd answers: %s; start quiltd or pass another socket with --socket",
                         lf_errno_text(why));
        lf_ctl_close(ctl);
        return status;
    }
    *out = ctl;
    return LF_OK;
}

void lf_ctl_close(lf_ctl *ctl)
{
    if (!ctl)
        return;
    if (ctl->fd >= 0)
        close(ctl->fd);
    json_decref(ctl->notifications);
    lf_free(ctl->buffer);
    lf_free(ctl);
}

/* Sends text[n], with the descriptors at its first byte. */
static lf_status send_all(lf_ctl *ctl, const char *text, size_t n, const int *fds, int n_fds,
                          lf_error *err)
{
    union {
        struct cmsghdr align;
        char bytes[CMSG_SPACE(LF_MAX_CLIENT_FDS * sizeof(int))];
    } control = {.bytes = {0}};
    for (size_t sent = 0; sent < n;) {
        struct iovec vector = {.iov_len = n - sent};
        memcpy(&vector.iov_base, &(const char *){text + sent}, sizeof vector.iov_base);
        struct msghdr message = {.msg_iov = &vector, .msg_iovlen = 1};
        if (sent == 0 && n_fds > 0) {
            message.msg_control = &control;
            message.msg_controllen = CMSG_SPACE((size_t)n_fds * sizeof(int));
            struct cmsghdr *c = CMSG_FIRSTHDR(&message);
            c->cmsg_level = SOL_SOCKET;
            c->cmsg_type = SCM_RIGHTS;
            c->cmsg_len = CMSG_LEN((size_t)n_fds * sizeof(int));
            memcpy(CMSG_DATA(c), fds, (size_t)n_fds * sizeof(int));
        }
        ssize_t done = sendmsg(ctl->fd, &message, MSG_NOSIGNAL);
        if (done < 0 && errno != EINTR) {
            return lf_error_set(err, LF_E_NODEV, ctl->path, "the connection broke: %s",
                                lf_errno_text(errno));
        }
        sent += done > 0 ? (size_t)done : 0;
    }
    return LF_OK;
}

void lf_ctl_set_timeout(lf_ctl *ctl, double seconds)
{
    ctl->timeout = seconds;
    ctl->deadline = seconds > 0 ? lf_time_now() + seconds : 0;
}

/* Waits for data. LF_E_TIMEOUT. */
static lf_status await_some(const lf_ctl *ctl, lf_error *err)
{
    struct pollfd ready = {ctl->fd, POLLIN, 0};
    for (;;) {
        double left = ctl->deadline - lf_time_now();
        if (ctl->deadline > 0 && left <= 0)
            return lf_error_set(err, LF_E_TIMEOUT, ctl->path,
                                "no answer arrived within %g s; use a longer --timeout",
                                ctl->timeout);
        int ms = ctl->deadline > 0 ? (int)fmin(ceil(left * 1e3), 1e6) : -1;
        if (poll(&ready, 1, ms) > 0)
            return LF_OK;
    }
}

/* Receives the next line as JSON. */
static lf_status receive(lf_ctl *ctl, json_t **out, lf_error *err)
{
    for (;;) {
        char *begin = ctl->buffer + ctl->taken;
        char *end = memchr(begin, '\n', ctl->used - ctl->taken);
        if (end) {
            *out = json_loadb(begin, (size_t)(end - begin), 0, NULL);
            ctl->taken = (size_t)(end - ctl->buffer) + 1;
            return *out ? LF_OK
                        : lf_error_set(err, LF_E_FORMAT, ctl->path,
                                       "the daemon's answer is not JSON");
        }
        memmove(ctl->buffer, begin, ctl->used - ctl->taken);
        ctl->used -= ctl->taken;
        ctl->taken = 0;
        if (ctl->used == MAX_ANSWER) {
            return lf_error_set(err, LF_E_FORMAT, ctl->path,
                                "the daemon's answer is longer than 1 MiB");
        }
        lf_status status = await_some(ctl, err);
        if (status != LF_OK)
            return status;
        ssize_t n = recv(ctl->fd, ctl->buffer + ctl->used, MAX_ANSWER - ctl->used, 0);
        if (n == 0 || (n < 0 && errno != EINTR))
            return lf_error_set(err, LF_E_NODEV, ctl->path, "the daemon closed the connection");
        ctl->used += n > 0 ? (size_t)n : 0;
    }
}

static lf_status take_answer(json_t *message, json_t **out_result, int *out_code, lf_error *err)
{
    json_t *error = json_object_get(message, "error");
    lf_status status = LF_OK;
    if (error) {
        const char *text = json_string_value(json_object_get(error, "message"));
        if (out_code)
            *out_code = (int)json_integer_value(json_object_get(error, "code"));
        status = lf_error_set(err, LF_E_STATE, "", "%s",
                              text ? text : "the daemon returned an error without a message");
    } else {
        *out_result = json_incref(json_object_get(message, "result"));
    }
    json_decref(message);
    return status;
}

lf_status lf_ctl_call(lf_ctl *ctl, const char *method, json_t *params, const int *fds, int n,
                      json_t **out_result, int *out_code, lf_error *err)
{
    json_int_t id = ++ctl->ids;
    json_t *request = json_pack("{s:s, s:I, s:s, s:o}", "jsonrpc", "2.0", "id", id, "method",
                                method, "params", params);
    char *text = request ? json_dumps(request, JSON_COMPACT) : NULL;
    json_decref(request);
    if (!text)
        return lf_error_set(err, LF_E_NOMEM, method, "out of memory, or not UTF-8");
    size_t length = strlen(text);
    text[length] = '\n'; /* in place of the terminating 0 */
    lf_status status = send_all(ctl, text, length + 1, fds, n, err);
    free(text);
    while (status == LF_OK) {
        json_t *message = NULL;
        status = receive(ctl, &message, err);
        if (status != LF_OK)
            break;
        const json_t *answered = json_object_get(message, "id");
        if (answered && (json_is_null(answered) || json_integer_value(answered) == id))
            return take_answer(message, out_result, out_code, err);
        json_array_append_new(ctl->notifications, message);
    }
    return status;
}

lf_status lf_ctl_next(lf_ctl *ctl, json_t **out_message, lf_error *err)
{
    if (json_array_size(ctl->notifications) > 0) {
        *out_message = json_incref(json_array_get(ctl->notifications, 0));
        json_array_remove(ctl->notifications, 0);
        return LF_OK;
    }
    return receive(ctl, out_message, err);
}

/* ------------------------------------------------------------------------------------ tables -- */

static void print_value(const char *name, const json_t *value)
{
    char text[1024];
    if (json_is_string(value)) {
        lf_escape(text, sizeof text, json_string_value(value));
    } else if (json_is_real(value)) {
        snprintf(text, sizeof text, "%.6g", json_real_value(value));
    } else {
        char *dump = json_dumps(value, JSON_ENCODE_ANY | JSON_COMPACT);
        lf_escape(text, sizeof text, dump ? dump : "");
        free(dump);
    }
    printf("%-24s %s\n", name, text);
}

static void print_members(const char *prefix, json_t *value);

static void print_member(const char *prefix, const char *key, json_t *value)
{
    char name[256], escaped[128];
    lf_escape(escaped, sizeof escaped, key);
    snprintf(name, sizeof name, "%.127s%s%s", prefix, prefix[0] != '\0' ? "." : "", escaped);
    if (json_is_object(value)) {
        print_members(name, value);
    } else if (json_is_object(json_array_get(value, 0)) ||
               json_is_string(json_array_get(value, 0))) {
        size_t i;
        json_t *element;
        json_array_foreach(value, i, element)
        {
            char numbered[300];
            snprintf(numbered, sizeof numbered, "%s.%zu", name, i);
            if (json_is_object(element))
                print_members(numbered, element);
            else
                print_value(numbered, element);
        }
    } else {
        print_value(name, value);
    }
}

static void print_members(const char *prefix, json_t *value)
{
    const char *key;
    json_t *member;
    json_object_foreach(value, key, member)
    {
        print_member(prefix, key, member);
    }
}

void lf_ctl_print(const json_t *result)
{
    json_t *copy = json_deep_copy(result);
    if (json_is_object(copy))
        print_members("", copy);
    else
        print_value("result", copy);
    json_decref(copy);
}
