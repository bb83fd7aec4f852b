/* For targets: a gateway (daemon/web/web.h) in an event loop, and a quiltd behind it that does not
 * exist. That quiltd requires every line that it gets to be one request, and none that a page must
 * never make. It answers each. */
#ifndef LF_TESTS_FUZZ_GATEWAY_H
#define LF_TESTS_FUZZ_GATEWAY_H

#include "tests/fuzz/fuzz.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <systemd/sd-event.h>

#include <jansson.h>

#include "base/log.h"
#include "daemon/web/listen.h"
#include "daemon/web/web.h"

/* Steps of the event loop that one input may take. Without a bound, a loop that never rests would
 * look like a slow input. */
#define FUZZ_MAX_STEPS 100000

typedef struct fuzz_gateway {
    sd_event *event;
    lf_web *web;
    char token[33];
    int n_reached; /* connections that the false quiltd has accepted … */
    int n_lines;   /* … and lines that it has read */
} fuzz_gateway;

static fuzz_gateway fuzz_home;

/* A line is a request, and not one that a page must never make. */
static inline void fuzz_check_line(const char *line, size_t n)
{
    static const char *const never[] = {"shutdown", "device.set", "button"};
    json_t *message = json_loadb(line, n, JSON_REJECT_DUPLICATES, NULL);
    const char *method = json_string_value(json_object_get(message, "method"));
    const json_t *params = json_object_get(message, "params");
    lf_fuzz_require(method);
    for (size_t i = 0; i < sizeof never / sizeof never[0]; i++)
        lf_fuzz_require(strcmp(method, never[i]) != 0);
    lf_fuzz_require(!json_object_get(params, "scene_fd") && !json_object_get(params, "threads"));
    json_decref(message);
}

static inline int fuzz_on_lines(sd_event_source *source, int fd, uint32_t what, void *context)
{
    /* the first line limits rights, and others come after its answer */
    static const char answer[] = "{\"jsonrpc\":\"2.0\",\"id\":\"quiltweb:rights\",\"result\":{}}\n"
                                 "{\"jsonrpc\":\"2.0\",\"id\":1,\"result\":{}}\n";
    static char line[2 << 20];
    fuzz_gateway *g = context;
    (void)what;
    size_t used = 0;
    ssize_t n;
    while (used < sizeof line && (n = recv(fd, line + used, sizeof line - used, 0)) > 0)
        used += (size_t)n;
    for (char *at = line, *end; (end = memchr(at, '\n', used - (size_t)(at - line)));) {
        fuzz_check_line(at, (size_t)(end - at));
        g->n_lines++;
        (void)!send(fd, answer, sizeof answer - 1, MSG_NOSIGNAL);
        at = end + 1;
    }
    if (used == 0) {
        sd_event_source_disable_unref(source);
        close(fd);
    }
    return 0;
}

static inline int fuzz_on_client(sd_event_source *source, int fd, uint32_t what, void *context)
{
    fuzz_gateway *g = context;
    (void)source;
    (void)what;
    sd_event_source *client = NULL;
    int accepted = accept4(fd, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
    lf_fuzz_require(accepted >= 0 &&
                    sd_event_add_io(g->event, &client, accepted, EPOLLIN, fuzz_on_lines, g) >= 0);
    g->n_reached++;
    return 0;
}

static inline void fuzz_begin_web(fuzz_gateway *g, const char *socket)
{
    lf_error err = {0};
    lf_web_config config = {
        .services[LF_SERVICE_PAGE].n = 1, .socket = socket, .upload_limit = 1 << 20};
    lf_fuzz_require(lf_web_listen("127.0.0.1:0", &config.services[LF_SERVICE_PAGE].fd[0], &err) ==
                    LF_OK);
    lf_fuzz_require(lf_web_create(g->event, &config, &g->web, &err) == LF_OK);
}

static char fuzz_folder[] = "/tmp/quiltd-fuzz-XXXXXX";

static inline void fuzz_remove_folder(void)
{
    char path[64];
    snprintf(path, sizeof path, "%s/s", fuzz_folder);
    unlink(path);
    rmdir(fuzz_folder);
}

/* The gateway, which stays for all inputs. */
static inline fuzz_gateway *fuzz_gateway_begin(void)
{
    fuzz_gateway *g = &fuzz_home;
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (g->web)
        return g;
    lf_log_init("fuzz", (lf_log_level)0);
    signal(SIGPIPE, SIG_IGN);
    lf_fuzz_require(mkdtemp(fuzz_folder) && sd_event_new(&g->event) >= 0);
    snprintf(address.sun_path, sizeof address.sun_path, "%s/s", fuzz_folder);
    atexit(fuzz_remove_folder);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    lf_fuzz_require(bind(fd, (struct sockaddr *)&address, sizeof address) == 0 &&
                    listen(fd, 64) == 0);
    lf_fuzz_require(sd_event_add_io(g->event, NULL, fd, EPOLLIN, fuzz_on_client, g) >= 0);
    fuzz_begin_web(g, address.sun_path);
    snprintf(g->token, sizeof g->token, "%s", strchr(lf_web_url(g->web), '#') + 1);
    return g;
}

/* Runs the loop until nothing is due. */
static inline void fuzz_run(fuzz_gateway *g)
{
    int steps = 0;
    while (sd_event_run(g->event, 0) > 0)
        lf_fuzz_require(++steps < FUZZ_MAX_STEPS);
}

/* A connection of a client, which does not block. */
static inline int fuzz_connect(const fuzz_gateway *g)
{
    struct sockaddr_in address = {.sin_family = AF_INET,
                                  .sin_port = htons((uint16_t)lf_web_port(g->web, LF_SERVICE_PAGE)),
                                  .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    lf_fuzz_require(fd >= 0 && connect(fd, (struct sockaddr *)&address, sizeof address) == 0);
    lf_fuzz_require(fcntl(fd, F_SETFL, O_NONBLOCK) == 0);
    return fd;
}

/* Runs the loop once the gateway has what was sent: loopback delivers late on busy machines. */
static inline void fuzz_deliver(fuzz_gateway *g)
{
    (void)sd_event_run(g->event, 2000);
    fuzz_run(g);
}

/* Sends data[n] while the gateway runs; what it does not take is left out. */
static inline void fuzz_send(fuzz_gateway *g, int fd, const void *data, size_t n)
{
    const char *at = data;
    while (n > 0) {
        ssize_t done = send(fd, at, n, MSG_NOSIGNAL);
        if (done <= 0)
            return;
        at += done;
        n -= (size_t)done;
        fuzz_deliver(g);
    }
}

/* Appends what is answered until the gateway has closed, or says nothing for 0.2 s, to
 * out[size]; terminated. *used is the number of bytes. */
static inline void fuzz_receive(fuzz_gateway *g, int fd, char *out, size_t size, size_t *used)
{
    struct pollfd ready = {fd, POLLIN, 0};
    for (int idle = 0; idle < 20 && *used < size - 1; idle++) {
        fuzz_run(g);
        if (poll(&ready, 1, 10) <= 0)
            continue;
        ssize_t n = recv(fd, out + *used, size - 1 - *used, 0);
        if (n <= 0)
            break;
        *used += (size_t)n;
        idle = 0;
    }
    out[*used] = '\0';
}

/* Says no more, takes the whole answer, and leaves: nothing of the client may stay. */
static inline size_t fuzz_end(fuzz_gateway *g, int fd, char *out, size_t size)
{
    size_t used = 0;
    shutdown(fd, SHUT_WR);
    fuzz_deliver(g);
    fuzz_receive(g, fd, out, size, &used);
    close(fd);
    fuzz_run(g);
    lf_fuzz_require(lf_web_sessions(g->web) == 0);
    return used;
}

#endif
