/* WebSockets: their handshakes, and who sits behind them. */
#include "daemon/web/web_internal.h"

#include <string.h>
#include <strings.h>

#include "base/alloc.h"
#include "daemon/web/reply.h"

void lf_seat_leave(lf_seat *gone)
{
    lf_web *web = gone->web;
    for (lf_seat **at = &web->seats; *at; at = &(*at)->next) {
        if (*at != gone)
            continue;
        *at = gone->next;
        break;
    }
    web->services[gone->service].n_seats--;
    gone->kind->destroy(gone->guest);
    MHD_upgrade_action(gone->handle, MHD_UPGRADE_ACTION_CLOSE);
    lf_free(gone);
    lf_web_wake(web);
}

void lf_seats_leave(lf_web *web)
{
    while (web->seats)
        lf_seat_leave(web->seats);
}

int lf_seats_count(const lf_web *web)
{
    int n = 0;
    for (int i = 0; i < LF_SERVICES; i++)
        n += web->services[i].n_seats;
    return n;
}

/* The seat was offered; NULL: there is none, or nobody sits down on it. */
static lf_seat *take_seat(lf_web *web, const lf_peer *peer, int fd, const char *early, size_t n,
                          struct MHD_UpgradeResponseHandle *handle)
{
    lf_error err = {0};
    const bool room = !web->ending && web->services[peer->service].n_seats < LF_WEB_MAX_SESSIONS;
    lf_seat *new = room ? lf_calloc(1, sizeof *new) : NULL;
    if (!new)
        return NULL;
    *new = (lf_seat){.web = web, .service = peer->service, .kind = peer->offered, .handle = handle};
    if (new->kind->create(new, fd, early, n, &new->guest, &err) != LF_OK) {
        lf_free(new);
        return NULL;
    }
    return new;
}

static void on_upgrade(void *context, struct MHD_Connection *connection, void *req,
                       const char *early, size_t n, MHD_socket fd,
                       struct MHD_UpgradeResponseHandle *handle)
{
    (void)req;
    lf_web *web = context;
    lf_patience_stop(lf_request_patience(connection));
    lf_seat *new = take_seat(web, lf_peer_of(connection), fd, early, n, handle);
    if (!new) {
        MHD_upgrade_action(handle, MHD_UPGRADE_ACTION_CLOSE);
        lf_web_wake(web);
        return;
    }
    new->next = web->seats;
    web->seats = new;
    web->services[new->service].n_seats++;
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

enum MHD_Result lf_seats_answer(lf_request *r, const lf_seat_kind *kind)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *value[5];
    static const char *const names[] = {"Upgrade", "Connection", "Sec-WebSocket-Version",
                                        "Sec-WebSocket-Key", "Sec-WebSocket-Protocol"};
    for (int i = 0; i < 5; i++)
        value[i] = MHD_lookup_connection_value(r->connection, MHD_HEADER_KIND, names[i]);
    if (!has_word(value[0], "websocket") || !has_word(value[1], "upgrade") || !value[2] ||
        strcmp(value[2], "13") != 0)
        return lf_request_refuse(r, 426, "expects a WebSocket of version 13");
    if (!value[3] || strlen(value[3]) != 24 || strspn(value[3], digits) != 22 ||
        strcmp(value[3] + 22, "==") != 0)
        return lf_request_refuse(r, 400, "Sec-WebSocket-Key is not 16 bytes in base64");
    if (kind->protocol && !has_word(value[4], kind->protocol))
        return lf_request_refuse(r, 400, "expects another Sec-WebSocket-Protocol");
    if (r->web->services[r->service].n_seats >= LF_WEB_MAX_SESSIONS)
        return lf_request_refuse(r, 503, "too many clients");
    lf_peer_of(r->connection)->offered = kind;
    return lf_reply_upgrade(r->connection, value[3], kind->protocol, on_upgrade, r->web);
}
