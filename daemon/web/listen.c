#include "daemon/web/listen.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include "base/errno_text.h"
#include "base/log.h"
#include "base/number.h"

#define MAX_TRIES 16 /* for a port that is free on both addresses */

/* An address in words. */
typedef struct place {
    bool v6;
    uint16_t port;
} place;

static lf_status read_place(const char *text, place *out, lf_error *err)
{
    static const char v4_name[] = "127.0.0.1:", v6_name[] = "[::1]:";
    const bool v4 = strncmp(text, v4_name, strlen(v4_name)) == 0;
    const bool v6 = strncmp(text, v6_name, strlen(v6_name)) == 0;
    uint64_t port = 0;
    if ((!v4 && !v6) || !lf_whole_is(text + strlen(v6 ? v6_name : v4_name), &port) ||
        port > UINT16_MAX)
        return lf_error_set(err, LF_E_ARG, "--listen",
                            "expects 127.0.0.1:PORT or [::1]:PORT, got \"%s\"", text);
    *out = (place){.v6 = v6, .port = (uint16_t)port};
    return LF_OK;
}

static lf_status open_at(const place *at, int *out_fd, lf_error *err)
{
    const struct sockaddr_in v4 = {.sin_family = AF_INET,
                                   .sin_port = htons(at->port),
                                   .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    const struct sockaddr_in6 v6 = {
        .sin6_family = AF_INET6, .sin6_port = htons(at->port), .sin6_addr = IN6ADDR_LOOPBACK_INIT};
    struct sockaddr_storage address = {0};
    const socklen_t size = at->v6 ? sizeof v6 : sizeof v4;
    memcpy(&address, at->v6 ? (const void *)&v6 : (const void *)&v4, size);
    int fd = socket(at->v6 ? AF_INET6 : AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const int on = 1;
    if (fd >= 0 && setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) == 0 &&
        bind(fd, (const struct sockaddr *)&address, size) == 0 && listen(fd, 32) == 0) {
        *out_fd = fd;
        return LF_OK;
    }
    const int why = errno;
    char name[32];
    if (fd >= 0)
        close(fd);
    snprintf(name, sizeof name, "%s:%d", at->v6 ? "[::1]" : "127.0.0.1", at->port);
    const bool none = why == EADDRNOTAVAIL || why == EAFNOSUPPORT;
    return lf_error_set(err,
                        why == EADDRINUSE ? LF_E_BUSY
                        : none            ? LF_E_NODEV
                                          : LF_E_IO,
                        name, "cannot listen: %s%s", lf_errno_text(why),
                        why == EADDRINUSE ? "; another quiltweb may run; choose another port" : "");
}

lf_status lf_web_listen(const char *address, int *out_fd, lf_error *err)
{
    place at;
    lf_status status = read_place(address, &at, err);
    return status == LF_OK ? open_at(&at, out_fd, err) : status;
}

/* Opens all places at the port of the first one that is there. */
static lf_status open_all(const place *places, int n, int *fds, int *out_n, lf_error *err)
{
    lf_status status = LF_OK, missing = LF_OK;
    int port = places[0].port, opened = 0;
    bool v6 = false;
    for (int i = 0; i < n && status == LF_OK; i++) {
        const place at = {.v6 = places[i].v6, .port = (uint16_t)port};
        lf_error why = {0};
        status = open_at(&at, &fds[opened], &why);
        if (status != LF_OK && err)
            *err = why;
        if (status == LF_E_NODEV && n > 1) {
            lf_log(LF_LOG_INFO, "%s: %s; going on without it", why.where, why.what);
            missing = status;
            status = LF_OK;
        } else if (status == LF_OK) {
            status = lf_web_listener_look(fds[opened++], &port, &v6, err);
        }
    }
    if (status == LF_OK && opened == 0)
        status = missing;
    while (status != LF_OK && opened > 0)
        close(fds[--opened]);
    *out_n = opened;
    return status;
}

lf_status lf_web_listen_all(const char *const addresses[], int n, int out_fds[LF_WEB_MAX_LISTENERS],
                            int *out_n, lf_error *err)
{
    place places[LF_WEB_MAX_LISTENERS] = {0};
    lf_status status = LF_OK;
    for (int i = 0; i < n && status == LF_OK; i++)
        status = read_place(addresses[i], &places[i], err);
    if (status != LF_OK)
        return status;
    if (n > 1 && (places[0].port != places[1].port || places[0].v6 == places[1].v6))
        return lf_error_set(err, LF_E_ARG, "--listen",
                            "two addresses must be 127.0.0.1 and [::1] with the same port");
    status = open_all(places, n, out_fds, out_n, err);
    for (int i = 1; i < MAX_TRIES && status == LF_E_BUSY && places[0].port == 0; i++)
        status = open_all(places, n, out_fds, out_n, err);
    return status;
}

lf_status lf_web_listen_port(int port, lf_web_sockets *out, lf_error *err)
{
    char v4[32], v6[32];
    const char *const both[] = {v4, v6};
    snprintf(v4, sizeof v4, "127.0.0.1:%d", port);
    snprintf(v6, sizeof v6, "[::1]:%d", port);
    return lf_web_listen_all(both, 2, out->fd, &out->n, err);
}

void lf_web_sockets_close(lf_web_sockets *sockets)
{
    while (sockets->n > 0)
        close(sockets->fd[--sockets->n]);
}

lf_status lf_web_listener_look(int fd, int *out_port, bool *out_v6, lf_error *err)
{
    union {
        struct sockaddr any;
        struct sockaddr_in v4;
        struct sockaddr_in6 v6;
    } address = {.any.sa_family = AF_UNSPEC};
    socklen_t size = sizeof address;
    const bool listens = sd_is_socket(fd, AF_UNSPEC, SOCK_STREAM, 1) > 0 &&
                         getsockname(fd, &address.any, &size) == 0;
    const bool v4 = listens && address.any.sa_family == AF_INET &&
                    address.v4.sin_addr.s_addr == htonl(INADDR_LOOPBACK);
    const bool v6 =
        listens && address.any.sa_family == AF_INET6 && IN6_IS_ADDR_LOOPBACK(&address.v6.sin6_addr);
    if (!v4 && !v6)
        return lf_error_set(err, LF_E_ARG, "socket",
                            "quiltweb listens on 127.0.0.1 or [::1] alone; put a server with TLS "
                            "in front to reach it from elsewhere");
    *out_port = ntohs(v6 ? address.v6.sin6_port : address.v4.sin_port);
    *out_v6 = v6;
    return LF_OK;
}
