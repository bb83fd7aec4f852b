#include "daemon/web/web_internal.h"

#include <errno.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/web/reply.h"
#include "daemon/wire/rpc.h"

#define HEADER_BYTES ((size_t)32768)
#define IDLE_S 10u

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

void lf_web_wake(lf_web *web)
{
    sd_event_source_set_time_relative(web->timer, 0);
    sd_event_source_set_enabled(web->timer, SD_EVENT_ONESHOT);
}

/* ------------------------------------------------------------------------------- connections -- */

/* The service whose port a socket has; LF_SERVICES: none. */
static lf_service service_of(const lf_web *web, int fd)
{
    union {
        struct sockaddr any;
        struct sockaddr_in v4;
        struct sockaddr_in6 v6;
    } local = {.any.sa_family = AF_UNSPEC};
    socklen_t size = sizeof local;
    lf_service service = 0;
    if (getsockname(fd, &local.any, &size) != 0)
        return LF_SERVICES;
    const int port =
        ntohs(local.any.sa_family == AF_INET6 ? local.v6.sin6_port : local.v4.sin_port);
    while (service < LF_SERVICES && web->services[service].port != port)
        service++;
    return service;
}

static void accept_more(lf_web *web, lf_service service, bool more)
{
    for (int k = 0; k < web->services[service].sockets.n; k++)
        sd_event_source_set_enabled(web->services[service].accept[k],
                                    more ? SD_EVENT_ON : SD_EVENT_OFF);
}

/* Somebody waits for a place at this service, or for a file (LF_SERVICES): the oldest connection
 * that has not asked for anything makes room. */
static void make_room(lf_web *web, lf_service service)
{
    lf_peer *oldest = NULL;
    for (lf_peer *v = web->peers; v; v = v->next)
        if (!v->asked && (v->service == service || service == LF_SERVICES))
            oldest = v;
    if (oldest)
        lf_patience_end(oldest->patience);
    for (lf_service i = 0; i < LF_SERVICES; i++)
        if (i == service || service == LF_SERVICES)
            accept_more(web, i, false); /* until a connection has ended */
}

/* Each service has places of its own: programs do not keep out the page, nor each other. */
static bool is_full(const lf_web *web, lf_service service)
{
    return web->services[service].n_connections >=
           (service == LF_SERVICE_PAGE ? LF_WEB_MAX_CONNECTIONS : LF_WEB_MAX_PROGRAMS);
}

/* One a turn. Above the limit, connections wait in the kernel. */
static int on_accept(sd_event_source *source, int fd, uint32_t what, void *context)
{
    (void)source;
    (void)what;
    lf_web *web = context;
    struct sockaddr_storage address = {0};
    socklen_t size = sizeof address;
    const lf_service service = service_of(web, fd);
    if (service < LF_SERVICES && is_full(web, service)) {
        make_room(web, service);
        return on_turn(web);
    }
    int peer = accept4(fd, (struct sockaddr *)&address, &size, SOCK_CLOEXEC | SOCK_NONBLOCK);
    const bool full = peer < 0 && (errno == EMFILE || errno == ENFILE || errno == ENOMEM);
    if (peer >= 0) /* on failure it is closed */
        (void)MHD_add_connection(web->http, peer, (const struct sockaddr *)&address, size);
    if (full && web->counts.connections > 0)
        make_room(web, LF_SERVICES);
    return on_turn(web);
}

/* NULL: out of memory. */
static lf_peer *begin_peer(lf_web *web, struct MHD_Connection *connection)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    const lf_service service = info ? service_of(web, info->connect_fd) : LF_SERVICES;
    lf_peer *new = service < LF_SERVICES ? lf_calloc(1, sizeof *new) : NULL;
    if (!new)
        return NULL;
    new->service = service;
    if (lf_patience_create(web->event, info->connect_fd, LF_WEB_DEADLINE_USEC, &new->patience) !=
        LF_OK) {
        lf_free(new);
        return NULL;
    }
    new->next = web->peers;
    web->peers = new;
    web->services[service].n_connections++;
    return new;
}

static void end_peer(lf_web *web, lf_peer *gone)
{
    for (lf_peer **at = &web->peers; *at; at = &(*at)->next) {
        if (*at != gone)
            continue;
        *at = gone->next;
        break;
    }
    web->services[gone->service].n_connections--;
    lf_patience_destroy(gone->patience);
    lf_free(gone);
}

/* The context of a connection is its peer. */
static void on_connection(void *context, struct MHD_Connection *connection, void **peer,
                          enum MHD_ConnectionNotificationCode what)
{
    lf_web *web = context;
    if (what == MHD_CONNECTION_NOTIFY_STARTED) {
        web->counts.connections++;
        *peer = begin_peer(web, connection);
        return;
    }
    web->counts.connections--;
    if (*peer)
        end_peer(web, *peer);
    *peer = NULL;
    for (lf_service service = 0; service < LF_SERVICES && !web->ending; service++)
        accept_more(web, service, true);
}

lf_peer *lf_peer_of(struct MHD_Connection *connection)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    return info ? info->socket_context : NULL;
}

lf_patience *lf_request_patience(struct MHD_Connection *connection)
{
    const lf_peer *peer = lf_peer_of(connection);
    return peer ? peer->patience : NULL;
}

/* ---------------------------------------------------------------------------------- requests -- */

void lf_request_resume(lf_request *r)
{
    MHD_resume_connection(r->connection);
    lf_web_wake(r->web);
}

enum MHD_Result lf_request_refuse(lf_request *r, unsigned status, const char *why)
{
    r->route = NULL;
    return lf_reply_text(r->connection, status, why);
}

enum MHD_Result lf_request_refuse_json(lf_request *r, unsigned status, int code,
                                       const lf_error *err)
{
    char text[sizeof *err + 32];
    json_t *answer = json_pack("{s:{s:i, s:o}}", "error", "code", code, "message",
                               lf_rpc_text(lf_error_format(err, text, sizeof text)));
    r->route = NULL;
    enum MHD_Result sent = lf_reply_json(r->connection, status, answer);
    json_decref(answer);
    return sent;
}

static bool may_ask(const lf_guard *guard, lf_route_needs needs, const lf_guard_request *headers)
{
    if (needs == LF_NEEDS_TO_WRITE)
        return lf_guard_may_write(guard, headers);
    if (needs == LF_NEEDS_TOKEN_OR_COOKIE)
        return lf_guard_may_read(guard, headers);
    return needs == LF_NEEDS_NOTHING || lf_guard_has_token(guard, headers);
}

/* A page that is not allowed at a service of programs. Its browser hides the answer from it. */
static enum MHD_Result refuse_stranger(lf_web *web, struct MHD_Connection *connection,
                                       lf_service service, const char *origin)
{
    static const char *const names[LF_SERVICES] = {"page", "bridge", "events", "webxr"};
    lf_error err = {0};
    lf_origins_refusal(origin, &err);
    if (lf_strangers_meet(&web->strangers, (int)service, origin))
        lf_log(LF_LOG_WARNING, "%s: %s", names[service], err.what);
    return lf_reply_text(connection, 403, err.what);
}

/* The headers are there: refuses the request, or makes *out of it. */
static enum MHD_Result begin_request(lf_web *web, struct MHD_Connection *connection, lf_peer *peer,
                                     const char *path, const char *method, lf_request **out)
{
    lf_guard_request headers;
    const char *why = NULL;
    unsigned status = 0;
    const lf_guard *guard = &web->services[peer->service].guard;
    const lf_route *route = lf_route_find(peer->service, path, method, &status);
    web->counts.requests++;
    lf_reply_read(connection, path, &headers);
    headers.zero = peer->zero;
    headers.takes_body = route && route->take;
    headers.body_limit = route && route->body_limit ? route->body_limit : web->upload_limit;
    headers.too_long = route && route->body_limit ? "the body is too long; send the path of a file"
                                                  : "the body is longer than --upload-limit";
    const int refused = lf_guard_check(guard, &headers, &why);
    web->counts.refused += refused != 0;
    if (refused == 403 && guard->allowed && headers.origins == 1)
        return refuse_stranger(web, connection, peer->service, headers.origin);
    if (refused)
        return lf_reply_text(connection, (unsigned)refused, why);
    peer->origin = guard->allowed ? headers.origin : NULL;
    if (!route)
        return lf_reply_text(connection, status,
                             status == 404 ? "no such page" : "the method is not allowed here");
    if (!may_ask(guard, route->needs, &headers)) {
        web->counts.refused++;
        return lf_reply_text(connection, 401, "the token is missing or wrong");
    }
    lf_request *r = lf_calloc(1, sizeof *r);
    if (!r)
        return MHD_NO;
    *r = (lf_request){.web = web,
                      .connection = connection,
                      .service = peer->service,
                      .path = path,
                      .route = route,
                      .secure = lf_guard_is_public(guard, &headers),
                      .fd = -1,
                      .next = web->requests};
    web->requests = r;
    *out = r;
    return route->check ? route->check(r) : MHD_YES;
}

/* Before libmicrohttpd decodes the target. */
static void *on_target(void *context, const char *target, struct MHD_Connection *connection)
{
    (void)context;
    lf_peer *peer = lf_peer_of(connection);
    if (peer)
        peer->zero = memmem(target, strcspn(target, "?"), "%00", 3);
    return NULL; /* no request yet */
}

/* libmicrohttpd calls this once the headers are there, for the parts of a body, and again when an
 * answer may be made. */
static enum MHD_Result on_request(void *context, struct MHD_Connection *connection,
                                  const char *path, const char *method, const char *version,
                                  const char *body, size_t *n_body, void **out_request)
{
    (void)version;
    lf_web *web = context;
    lf_request *r = *out_request;
    lf_peer *peer = lf_peer_of(connection);
    if (web->ending || !peer)
        return MHD_NO;
    peer->asked = true;
    if (!r) {
        enum MHD_Result result = begin_request(web, connection, peer, path, method, &r);
        *out_request = r;
        return result;
    }
    const size_t n = *n_body;
    *n_body = 0;
    if (!r->route)
        return MHD_YES; /* it is answered; what still comes is lost */
    if (n > 0)
        return r->route->take(r, body, n);
    const bool first = !r->acted;
    r->acted = true;
    return first ? r->route->act(r) : r->route->finish(r);
}

static void on_completed(void *context, struct MHD_Connection *connection, void **out_request,
                         enum MHD_RequestTerminationCode why)
{
    (void)connection;
    (void)why;
    lf_web *web = context;
    lf_request *gone = *out_request;
    if (!gone)
        return;
    for (lf_request **at = &web->requests; *at; at = &(*at)->next) {
        if (*at != gone)
            continue;
        *at = gone->next;
        break;
    }
    lf_route_leave_lane(gone);
    web->n_streams -= gone->stream ? 1 : 0;
    lf_fetch_destroy(gone->fetch);
    lf_stream_destroy(gone->stream);
    lf_upload_drop(gone->upload);
    lf_bridge_leave(gone->bridge_call);
    lf_free(gone->body);
    json_decref(gone->query);
    if (gone->fd >= 0)
        close(gone->fd);
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

static lf_status start(lf_web *web, lf_error *err)
{
    const unsigned flags = MHD_USE_EPOLL | MHD_USE_NO_LISTEN_SOCKET | MHD_ALLOW_UPGRADE |
                           MHD_ALLOW_SUSPEND_RESUME | MHD_USE_ERROR_LOG;
    web->http = MHD_start_daemon(
        flags, 0, NULL, NULL, on_request, web, MHD_OPTION_EXTERNAL_LOGGER, on_log, web,
        MHD_OPTION_URI_LOG_CALLBACK, on_target, NULL, MHD_OPTION_CONNECTION_LIMIT,
        (unsigned)(LF_WEB_MAX_CONNECTIONS + (LF_SERVICES - 1) * LF_WEB_MAX_PROGRAMS),
        MHD_OPTION_CONNECTION_TIMEOUT, IDLE_S, MHD_OPTION_CONNECTION_MEMORY_LIMIT, HEADER_BYTES,
        MHD_OPTION_STRICT_FOR_CLIENT, 1, MHD_OPTION_NOTIFY_CONNECTION, on_connection, web,
        MHD_OPTION_NOTIFY_COMPLETED, on_completed, web, MHD_OPTION_END);
    const union MHD_DaemonInfo *info =
        web->http ? MHD_get_daemon_info(web->http, MHD_DAEMON_INFO_EPOLL_FD) : NULL;
    if (!info)
        return lf_error_set(err, LF_E_IO, "http", "cannot start the server");
    bool made = sd_event_add_io(web->event, &web->io, info->epoll_fd, EPOLLIN, on_io, web) >= 0 &&
                /* accuracy 1: 0 stands for a quarter of a second */
                sd_event_add_time_relative(web->event, &web->timer, CLOCK_MONOTONIC, 0, 1, on_time,
                                           web) >= 0;
    for (int i = 0; i < LF_SERVICES; i++)
        for (int k = 0; k < web->services[i].sockets.n && made; k++)
            made = sd_event_add_io(web->event, &web->services[i].accept[k],
                                   web->services[i].sockets.fd[k], EPOLLIN, on_accept, web) >= 0;
    return made ? LF_OK : lf_error_set(err, LF_E_NOMEM, "http", "out of memory");
}

/* Finds the port of a service, and whether its first address is one of IPv6. */
static lf_status look_at_service(lf_web *web, lf_service service, bool *out_v6, lf_error *err)
{
    lf_entrance *at = &web->services[service];
    lf_status status = LF_OK;
    for (int i = 0; i < at->sockets.n && status == LF_OK; i++) {
        int port = 0;
        bool v6 = false;
        status = lf_web_listener_look(at->sockets.fd[i], &port, &v6, err);
        if (status == LF_OK && i > 0 && port != at->port)
            status = lf_error_set(err, LF_E_ARG, "socket", "all sockets need the same port");
        at->port = i == 0 ? port : at->port;
        *out_v6 = i == 0 ? v6 : *out_v6;
    }
    for (int i = 0; i < (int)service && status == LF_OK && at->port > 0; i++)
        if (web->services[i].port == at->port)
            status = lf_error_set(err, LF_E_ARG, "socket",
                                  "port %d is given twice; choose another one", at->port);
    return status;
}

/* Looks at all sockets, and writes the URL of the page. */
static lf_status look_at_services(lf_web *web, const char *public_origin, lf_error *err)
{
    lf_entrance *page = &web->services[LF_SERVICE_PAGE];
    bool v6 = false, ignored;
    lf_status status = look_at_service(web, LF_SERVICE_PAGE, &v6, err);
    for (lf_service service = LF_SERVICE_PAGE + 1; service < LF_SERVICES && status == LF_OK;
         service++) {
        status = look_at_service(web, service, &ignored, err);
        lf_guard_init_programs(&web->services[service].guard, web->services[service].port,
                               &web->allowed);
    }
    if (status == LF_OK)
        status = lf_guard_init(&page->guard, page->port, err);
    if (status == LF_OK && public_origin)
        status = lf_guard_set_public(&page->guard, public_origin, err);
    if (status != LF_OK)
        return status;
    if (public_origin)
        snprintf(web->url, sizeof web->url, "%s/#%s", page->guard.public_origin,
                 page->guard.token.text);
    else
        snprintf(web->url, sizeof web->url, "http://%s:%d/#%s", v6 ? "[::1]" : "127.0.0.1",
                 page->port, page->guard.token.text);
    return LF_OK;
}

static void close_services(const lf_web_config *config)
{
    for (int i = 0; i < LF_SERVICES; i++) {
        lf_web_sockets sockets = config->services[i];
        lf_web_sockets_close(&sockets);
    }
}

/* If somebody can ask it, or listen to it. */
static lf_status begin_bridge(lf_web *web, const char *version, lf_error *err)
{
    if (web->services[LF_SERVICE_BRIDGE].port == 0 && web->services[LF_SERVICE_EVENTS].port == 0)
        return LF_OK;
    web->bridge_version = lf_strdup(version ? version : LF_BRIDGE_VERSION);
    const lf_bridge_config config = {.event = web->event,
                                     .socket = web->socket,
                                     .version = web->bridge_version,
                                     .panel_only = web->panel_only,
                                     .tell = lf_bridge_events_tell,
                                     .context = web};
    return web->bridge_version ? lf_bridge_create(&config, &web->bridge, err)
                               : lf_error_set(err, LF_E_NOMEM, "bridge", "out of memory");
}

lf_status lf_web_create(sd_event *event, const lf_web_config *config, lf_web **out, lf_error *err)
{
    lf_web *web = lf_calloc(1, sizeof *web);
    char *path = lf_strdup(config->socket);
    if (!web || !path) {
        lf_free(web);
        lf_free(path);
        close_services(config);
        return lf_error_set(err, LF_E_NOMEM, "http", "out of memory");
    }
    *web = (lf_web){.event = event,
                    .socket = path,
                    .upload_limit = config->upload_limit,
                    .driver = config->driver,
                    .panel_only = config->panel_only};
    if (config->allowed)
        web->allowed = *config->allowed;
    for (int i = 0; i < LF_SERVICES; i++)
        web->services[i].sockets = config->services[i];
    lf_status status = look_at_services(web, config->public_origin, err);
    if (status == LF_OK)
        status = begin_bridge(web, config->bridge_version, err);
    if (status == LF_OK)
        status = lf_uploads_create(event, config->upload_limit, &web->uploads, err);
    if (status == LF_OK)
        status = lf_downloads_create(event, LF_DOWNLOADS_LIMIT, &web->downloads, err);
    if (status == LF_OK)
        status = start(web, err);
    if (status == LF_OK)
        *out = web;
    else
        lf_web_destroy(web);
    return status;
}

void lf_web_destroy(lf_web *web)
{
    if (!web)
        return;
    web->ending = true;
    for (int i = 0; i < LF_SERVICES; i++) {
        for (int k = 0; k < web->services[i].sockets.n; k++)
            sd_event_source_disable_unref(web->services[i].accept[k]);
        lf_web_sockets_close(&web->services[i].sockets);
    }
    lf_seats_leave(web);
    for (lf_request *r = web->requests; r; r = r->next) {
        if (r->fetch)
            lf_fetch_cancel(r->fetch);
        if (r->waiting || (r->bridge_call && !lf_bridge_reply(r->bridge_call)))
            lf_request_resume(r);
        if (r->stream)
            lf_stream_end(r->stream);
    }
    if (web->http) {
        MHD_run(web->http); /* what was resumed must run before the end */
        MHD_stop_daemon(web->http);
    }
    lf_uploads_destroy(web->uploads);
    lf_downloads_destroy(web->downloads);
    lf_bridge_destroy(web->bridge);
    lf_free(web->bridge_version);
    sd_event_source_disable_unref(web->io);
    sd_event_source_disable_unref(web->timer);
    lf_free(web->socket);
    lf_free(web);
}

const char *lf_web_url(const lf_web *web)
{
    return web->url;
}

int lf_web_port(const lf_web *web, lf_service service)
{
    return web->services[service].port;
}

int lf_web_sessions(const lf_web *web)
{
    return lf_seats_count(web);
}
