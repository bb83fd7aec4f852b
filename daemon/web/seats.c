/* WebSockets: their handshakes, and the sessions behind them. */
#include "daemon/web/web_internal.h"

#include <string.h>
#include <strings.h>

#include "base/alloc.h"
#include "daemon/web/reply.h"
#include "daemon/web/session.h"

/* A session and the socket that libmicrohttpd lends. */
struct lf_seat {
    lf_seat *next;
    lf_web *web;
    lf_session *session;
    struct MHD_UpgradeResponseHandle *handle;
};

static void leave(lf_seat *gone)
{
    lf_web *web = gone->web;
    for (lf_seat **at = &web->seats; *at; at = &(*at)->next) {
        if (*at != gone)
            continue;
        *at = gone->next;
        break;
    }
    web->n_seats--;
    lf_session_destroy(gone->session);
    MHD_upgrade_action(gone->handle, MHD_UPGRADE_ACTION_CLOSE);
    lf_free(gone);
    lf_web_wake(web);
}

void lf_seats_leave(lf_web *web)
{
    while (web->seats)
        leave(web->seats);
}

static void on_session_end(void *context, lf_session *session)
{
    (void)session;
    leave(context);
}

static lf_uploads_passed sum_passed(void *context)
{
    const lf_web *web = context;
    lf_uploads_passed sum = {0};
    for (const lf_seat *seat = web->seats; seat; seat = seat->next)
        lf_session_add_passed(seat->session, &sum);
    return sum;
}

static void on_upgrade(void *context, struct MHD_Connection *connection, void *req,
                       const char *early, size_t n, MHD_socket fd,
                       struct MHD_UpgradeResponseHandle *handle)
{
    (void)req;
    lf_web *web = context;
    const lf_session_home home = {.event = web->event,
                                  .socket = web->socket,
                                  .uploads = web->uploads,
                                  .downloads = web->downloads,
                                  .passed = sum_passed,
                                  .context = web};
    lf_error err = {0};
    const bool room = !web->ending && web->n_seats < LF_WEB_MAX_SESSIONS;
    lf_seat *new = room ? lf_calloc(1, sizeof *new) : NULL;
    lf_patience_stop(lf_request_patience(connection));
    if (!new || lf_session_create(&home, fd, early, n, &new->session, &err) != LF_OK) {
        lf_free(new);
        MHD_upgrade_action(handle, MHD_UPGRADE_ACTION_CLOSE);
        lf_web_wake(web);
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

enum MHD_Result lf_seats_answer(lf_request *r)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *value[4];
    static const char *const names[] = {"Upgrade", "Connection", "Sec-WebSocket-Version",
                                        "Sec-WebSocket-Key"};
    lf_guard_request headers;
    lf_reply_read(r->connection, r->path, &headers);
    for (int i = 0; i < 4; i++)
        value[i] = MHD_lookup_connection_value(r->connection, MHD_HEADER_KIND, names[i]);
    if (!lf_guard_may_connect(&r->web->guard, &headers)) {
        r->web->counts.refused++;
        return lf_request_refuse(r, 401, "the token is missing or wrong");
    }
    if (!has_word(value[0], "websocket") || !has_word(value[1], "upgrade") || !value[2] ||
        strcmp(value[2], "13") != 0)
        return lf_request_refuse(r, 426, "expects a WebSocket of version 13");
    if (!value[3] || strlen(value[3]) != 24 || strspn(value[3], digits) != 22 ||
        strcmp(value[3] + 22, "==") != 0)
        return lf_request_refuse(r, 400, "Sec-WebSocket-Key is not 16 bytes in base64");
    if (r->web->n_seats >= LF_WEB_MAX_SESSIONS)
        return lf_request_refuse(r, 503, "too many clients");
    return lf_reply_upgrade(r->connection, value[3], on_upgrade, r->web);
}
