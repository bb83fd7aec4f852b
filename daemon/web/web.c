#include "daemon/web/web.h"

#include <arpa/inet.h>
#include <errno.h>
#include <microhttpd.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <systemd/sd-daemon.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/log.h"
#include "base/number.h"
#include "daemon/web/fetch.h"
#include "daemon/web/guard.h"
#include "daemon/web/reply.h"
#include "daemon/web/session.h"

#define MAX_FETCHES 8
#define HEADER_BYTES ((size_t)32768)
#define IDLE_S 10u
#define DEADLINE_USEC ((uint64_t)10000000)

/* A WebSocket: a session and the socket that libmicrohttpd lends. */
typedef struct seat {
    struct seat *next;
    lf_web *web;
    lf_session *session;
    struct MHD_UpgradeResponseHandle *handle;
} seat;

/* A request that passed the guard. */
typedef struct request {
    struct request *next;
    lf_web *web;
    struct MHD_Connection *connection;
    lf_fetch *fetch; /* NULL: none was asked for */
} request;

struct lf_web {
    sd_event *event;
    char *socket;
    lf_guard guard;
    int port;
    char url[96];
    struct MHD_Daemon *http;
    sd_event_source *io, *timer; /* timer: libmicrohttpd wants to run */
    seat *seats;
    int n_seats;
    request *requests;
    int n_fetches;
    bool ending; /* nobody is let in any more */
};

/* --------------------------------------------------------------------------------- listening -- */

static lf_status address_of(const char *text, struct sockaddr_storage *out, socklen_t *out_size,
                            lf_error *err)
{
    struct sockaddr_in v4 = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    struct sockaddr_in6 v6 = {.sin6_family = AF_INET6, .sin6_addr = IN6ADDR_LOOPBACK_INIT};
    static const char v4_name[] = "127.0.0.1:", v6_name[] = "[::1]:";
    const bool is_v4 = strncmp(text, v4_name, strlen(v4_name)) == 0;
    const bool is_v6 = strncmp(text, v6_name, strlen(v6_name)) == 0;
    const char *port_text = text + (is_v6 ? strlen(v6_name) : strlen(v4_name));
    uint64_t port = 0;
    if ((!is_v4 && !is_v6) || !lf_whole_is(port_text, &port) || port > 65535)
        return lf_error_set(err, LF_E_ARG, "--listen",
                            "expects 127.0.0.1:PORT or [::1]:PORT, got \"%s\"", text);
    v4.sin_port = v6.sin6_port = htons((uint16_t)port);
    memset(out, 0, sizeof *out);
    *out_size = is_v6 ? sizeof v6 : sizeof v4;
    memcpy(out, is_v6 ? (const void *)&v6 : (const void *)&v4, *out_size);
    return LF_OK;
}

lf_status lf_web_listen(const char *address, int *out_fd, lf_error *err)
{
    struct sockaddr_storage storage;
    socklen_t size = 0;
    lf_status status = address_of(address, &storage, &size, err);
    if (status != LF_OK)
        return status;
    int fd = socket(storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const int on = 1;
    if (fd >= 0 && setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) == 0 &&
        bind(fd, (const struct sockaddr *)&storage, size) == 0 && listen(fd, 32) == 0) {
        *out_fd = fd;
        return LF_OK;
    }
    const int why = errno;
    if (fd >= 0)
        close(fd);
    return lf_error_set(err, why == EADDRINUSE ? LF_E_BUSY : LF_E_IO, address, "cannot listen: %s",
                        lf_errno_text(why));
}

/* Finds port and name of a listening socket, which must be on a loopback address. */
static lf_status look_at_socket(lf_web *web, int fd, bool *out_v6, lf_error *err)
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
    web->port = ntohs(v6 ? address.v6.sin6_port : address.v4.sin_port);
    *out_v6 = v6;
    return LF_OK;
}

/* --------------------------------------------------------------------- libmicrohttpd's turns -- */

static int on_turn(lf_web *web)
{
    MHD_UNSIGNED_LONG_LONG ms = 0;
    MHD_run(web->http);
    const bool timed = MHD_get_timeout(web->http, &ms) == MHD_YES;
    if (timed)
        sd_event_source_set_time_relative(web->timer, ms * 1000);
    sd_event_source_set_enabled(web->timer, timed ? SD_EVENT_ONESHOT : SD_EVENT_OFF);
    return 0;
}

static int on_io(sd_event_source *source, int fd, uint32_t what, void *context)
{
    (void)source;
    (void)fd;
    (void)what;
    return on_turn(context);
}

static int on_time(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    return on_turn(context);
}

/* libmicrohttpd has something to do. */
static void wake(lf_web *web)
{
    sd_event_source_set_time_relative(web->timer, 0);
    sd_event_source_set_enabled(web->timer, SD_EVENT_ONESHOT);
}

static int on_deadline(sd_event_source *source, uint64_t usec, void *context)
{
    (void)usec;
    struct MHD_Connection *connection = context;
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    if (info)
        shutdown(info->connect_fd, SHUT_RDWR); /* libmicrohttpd sees the end */
    sd_event_source_set_enabled(source, SD_EVENT_OFF);
    return 0;
}

/* The context of a connection is its deadline. */
static void on_connection(void *context, struct MHD_Connection *connection, void **deadline,
                          enum MHD_ConnectionNotificationCode what)
{
    lf_web *web = context;
    sd_event_source *timer = NULL;
    if (what == MHD_CONNECTION_NOTIFY_STARTED) {
        if (sd_event_add_time_relative(web->event, &timer, CLOCK_MONOTONIC, DEADLINE_USEC, 0,
                                       on_deadline, connection) >= 0)
            *deadline = timer;
        return;
    }
    sd_event_source_disable_unref(*deadline);
    *deadline = NULL;
}

/* -------------------------------------------------------------------------------- WebSockets -- */

static void leave_seat(seat *gone)
{
    lf_web *web = gone->web;
    for (seat **at = &web->seats; *at; at = &(*at)->next) {
        if (*at != gone)
            continue;
        *at = gone->next;
        break;
    }
    web->n_seats--;
    lf_session_destroy(gone->session);
    MHD_upgrade_action(gone->handle, MHD_UPGRADE_ACTION_CLOSE);
    lf_free(gone);
    wake(web);
}

static void on_session_end(void *context, lf_session *session)
{
    (void)session;
    leave_seat(context);
}

static void on_upgrade(void *context, struct MHD_Connection *connection, void *req,
                       const char *early, size_t n, MHD_socket fd,
                       struct MHD_UpgradeResponseHandle *handle)
{
    (void)req;
    lf_web *web = context;
    lf_error err = {0};
    const bool room = !web->ending && web->n_seats < LF_WEB_MAX_SESSIONS;
    seat *new = room ? lf_calloc(1, sizeof *new) : NULL;
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    if (info && info->socket_context)
        sd_event_source_set_enabled(info->socket_context, SD_EVENT_OFF);
    if (!new ||
        lf_session_create(web->event, web->socket, fd, early, n, &new->session, &err) != LF_OK) {
        lf_free(new);
        MHD_upgrade_action(handle, MHD_UPGRADE_ACTION_CLOSE);
        wake(web);
        return;
    }
    new->web = web;
    new->handle = handle;
    new->next = web->seats;
    web->seats = new;
    web->n_seats++;
    lf_session_on_end(new->session, on_session_end, new);
}

static bool has_word(const char *list, const char *word)
{
    const size_t length = strlen(word);
    for (const char *at = list; at && *at;) {
        at += strspn(at, ", \t");
        const size_t n = strcspn(at, ", \t");
        if (n == length && strncasecmp(at, word, n) == 0)
            return true;
        at += n;
    }
    return false;
}

static enum MHD_Result answer_handshake(lf_web *web, struct MHD_Connection *connection,
                                        const lf_guard_request *headers)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *value[4];
    static const char *const names[] = {"Upgrade", "Connection", "Sec-WebSocket-Version",
                                        "Sec-WebSocket-Key"};
    for (int i = 0; i < 4; i++)
        value[i] = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, names[i]);
    if (!lf_guard_may_connect(&web->guard, headers))
        return lf_reply_text(connection, 401, "the token is missing or wrong");
    if (!has_word(value[0], "websocket") || !has_word(value[1], "upgrade") || !value[2] ||
        strcmp(value[2], "13") != 0)
        return lf_reply_text(connection, 426, "expects a WebSocket of version 13");
    if (!value[3] || strlen(value[3]) != 24 || strspn(value[3], digits) != 22 ||
        strcmp(value[3] + 22, "==") != 0)
        return lf_reply_text(connection, 400, "Sec-WebSocket-Key is not 16 bytes in base64");
    if (web->n_seats >= LF_WEB_MAX_SESSIONS)
        return lf_reply_text(connection, 503, "too many clients");
    return lf_reply_upgrade(connection, value[3], on_upgrade, web);
}

/* ---------------------------------------------------------------------------------- requests -- */

static void on_fetched(void *context)
{
    request *r = context;
    MHD_resume_connection(r->connection);
    wake(r->web);
}

static enum MHD_Result begin_fetch(request *r, lf_fetch_kind kind)
{
    lf_web *web = r->web;
    lf_error err = {0};
    if (web->n_fetches >= MAX_FETCHES)
        return lf_reply_text(r->connection, 503, "too many requests");
    if (lf_fetch_create(web->event, web->socket, kind, on_fetched, r, &r->fetch, &err) != LF_OK)
        return lf_reply_text(r->connection, 503, err.what);
    web->n_fetches++;
    MHD_suspend_connection(r->connection);
    return MHD_YES;
}

static enum MHD_Result answer_fetch(request *r)
{
    const char *text = NULL;
    int fd = -1;
    size_t size = 0;
    lf_error err = {0};
    lf_status status = lf_fetch_result(r->fetch, &text, &fd, &size, &err);
    if (status != LF_OK)
        return lf_reply_text(r->connection, 503, err.what);
    return text ? lf_reply_json(r->connection, text) : lf_reply_jpeg(r->connection, fd, size);
}

static enum MHD_Result answer(request *r, const char *path, const char *method,
                              const lf_guard_request *headers)
{
    static const char no_token[] = "the token is missing or wrong";
    const lf_guard *guard = &r->web->guard;
    const bool get = strcmp(method, "GET") == 0;
    const lf_page *page = lf_page_find(path);
    const bool status = strcmp(path, "/api/status") == 0;
    const bool login = strcmp(path, "/api/login") == 0, rpc = strcmp(path, "/rpc") == 0;
    if (!page && !status && !login && !rpc && strcmp(path, "/preview.jpg") != 0)
        return lf_reply_text(r->connection, 404, "no such page");
    if (login ? strcmp(method, "POST") != 0 : !get && !(page && strcmp(method, "HEAD") == 0))
        return lf_reply_text(r->connection, 405, "the method is not allowed here");
    if (page)
        return lf_reply_page(r->connection, page);
    if (rpc)
        return answer_handshake(r->web, r->connection, headers);
    if (login)
        return lf_guard_has_token(guard, headers) ? lf_reply_cookie(r->connection, guard)
                                                  : lf_reply_text(r->connection, 401, no_token);
    if (!lf_guard_has_token(guard, headers) && !lf_guard_has_cookie(guard, headers))
        return lf_reply_text(r->connection, 401, no_token);
    return begin_fetch(r, status ? LF_FETCH_STATUS : LF_FETCH_STILL);
}

/* libmicrohttpd calls this once the headers are there, and again when an answer may be made. */
static enum MHD_Result on_request(void *context, struct MHD_Connection *connection,
                                  const char *path, const char *method, const char *version,
                                  const char *body, size_t *n_body, void **out_request)
{
    (void)version;
    (void)body;
    lf_web *web = context;
    request *r = *out_request;
    lf_guard_request headers;
    const char *why = NULL;
    if (web->ending)
        return MHD_NO;
    lf_reply_read(connection, path, &headers);
    const int refused = r ? 0 : lf_guard_check(&web->guard, &headers, &why);
    if (refused)
        return lf_reply_text(connection, (unsigned)refused, why);
    if (*n_body > 0) {
        *n_body = 0; /* the guard has refused every request that announces a body */
        return MHD_YES;
    }
    if (r)
        return r->fetch ? answer_fetch(r) : answer(r, path, method, &headers);
    r = lf_calloc(1, sizeof *r);
    if (!r)
        return MHD_NO;
    *r = (request){.next = web->requests, .web = web, .connection = connection};
    web->requests = r;
    *out_request = r;
    return MHD_YES;
}

static void on_completed(void *context, struct MHD_Connection *connection, void **out_request,
                         enum MHD_RequestTerminationCode why)
{
    (void)connection;
    (void)why;
    lf_web *web = context;
    request *gone = *out_request;
    if (!gone)
        return;
    for (request **at = &web->requests; *at; at = &(*at)->next) {
        if (*at != gone)
            continue;
        *at = gone->next;
        break;
    }
    web->n_fetches -= gone->fetch ? 1 : 0;
    lf_fetch_destroy(gone->fetch);
    lf_free(gone);
    *out_request = NULL;
}

/* ---------------------------------------------------------------------------------- its life -- */

static void on_log(void *context, const char *format, va_list arguments) LF_PRINTF(2, 0);
static void on_log(void *context, const char *format, va_list arguments)
{
    (void)context;
    char text[256];
    vsnprintf(text, sizeof text, format, arguments);
    text[strcspn(text, "\n")] = '\0';
    lf_log(LF_LOG_DEBUG, "http: %s", text);
}

static lf_status start(lf_web *web, int listen_fd, bool v6, lf_error *err)
{
    const unsigned flags = MHD_USE_EPOLL | MHD_ALLOW_UPGRADE | MHD_ALLOW_SUSPEND_RESUME |
                           MHD_USE_ERROR_LOG | (v6 ? MHD_USE_IPv6 : 0u);
    web->http = MHD_start_daemon(
        flags, 0, NULL, NULL, on_request, web, MHD_OPTION_EXTERNAL_LOGGER, on_log, web,
        MHD_OPTION_LISTEN_SOCKET, listen_fd, MHD_OPTION_CONNECTION_LIMIT,
        (unsigned)LF_WEB_MAX_CONNECTIONS, MHD_OPTION_CONNECTION_TIMEOUT, IDLE_S,
        MHD_OPTION_CONNECTION_MEMORY_LIMIT, HEADER_BYTES, MHD_OPTION_STRICT_FOR_CLIENT, 1,
        MHD_OPTION_NOTIFY_CONNECTION, on_connection, web, MHD_OPTION_NOTIFY_COMPLETED, on_completed,
        web, MHD_OPTION_END);
    const union MHD_DaemonInfo *info =
        web->http ? MHD_get_daemon_info(web->http, MHD_DAEMON_INFO_EPOLL_FD) : NULL;
    if (!info)
        return lf_error_set(err, LF_E_IO, "http", "cannot start the server");
    if (sd_event_add_io(web->event, &web->io, info->epoll_fd, EPOLLIN, on_io, web) < 0 ||
        /* accuracy 1: 0 stands for a quarter of a second */
        sd_event_add_time_relative(web->event, &web->timer, CLOCK_MONOTONIC, 0, 1, on_time, web) <
            0)
        return lf_error_set(err, LF_E_NOMEM, "http", "out of memory");
    return LF_OK;
}

lf_status lf_web_create(sd_event *event, int listen_fd, const char *socket, lf_web **out,
                        lf_error *err)
{
    bool v6 = false;
    lf_web *web = lf_calloc(1, sizeof *web);
    char *path = lf_strdup(socket);
    if (!web || !path) {
        lf_free(web);
        lf_free(path);
        close(listen_fd);
        return lf_error_set(err, LF_E_NOMEM, "http", "out of memory");
    }
    *web = (lf_web){.event = event, .socket = path};
    lf_status status = look_at_socket(web, listen_fd, &v6, err);
    if (status == LF_OK)
        status = lf_guard_init(&web->guard, web->port, err);
    if (status != LF_OK)
        close(listen_fd);
    else
        status = start(web, listen_fd, v6, err);
    if (status != LF_OK) {
        lf_web_destroy(web);
        return status;
    }
    snprintf(web->url, sizeof web->url, "http://%s:%d/#%s", v6 ? "[::1]" : "127.0.0.1", web->port,
             web->guard.token.text);
    *out = web;
    return LF_OK;
}

void lf_web_destroy(lf_web *web)
{
    if (!web)
        return;
    web->ending = true;
    while (web->seats)
        leave_seat(web->seats);
    for (request *r = web->requests; r; r = r->next)
        if (r->fetch)
            lf_fetch_cancel(r->fetch);
    if (web->http) {
        MHD_run(web->http); /* what was resumed must run before the end */
        MHD_stop_daemon(web->http);
    }
    sd_event_source_disable_unref(web->io);
    sd_event_source_disable_unref(web->timer);
    lf_free(web->socket);
    lf_free(web);
}

const char *lf_web_url(const lf_web *web)
{
    return web->url;
}

int lf_web_port(const lf_web *web)
{
    return web->port;
}

int lf_web_sessions(const lf_web *web)
{
    return web->n_seats;
}
