/* The service of events: a WebSocket says which orchestration it listens to, and is told its
 * events. Events for a client that does not take them are dropped. */
#include "daemon/web/web_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "daemon/web/bridge_lists.h"
#include "daemon/web/ws.h"

/* Above this an event is dropped. */
#define MAX_QUEUED ((size_t)65536)

typedef struct listener {
    lf_seat *seat;
    lf_ws *ws;
    sd_event_source *reap;           /* on once the WebSocket has ended */
    char token[LF_BRIDGE_TOKEN + 1]; /* "": it has not said which */
} listener;

/* ------------------------------------------------------------------------------------ events -- */

static void on_text(void *context, const char *text, size_t n)
{
    listener *l = context;
    json_t *message = json_loadb(text, n, 0, NULL);
    const char *token =
        json_string_value(json_object_get(message, "subscribe_orchestration_events"));
    if (!token)
        lf_ws_close(l->ws, LF_WS_POLICY, "expects {\"subscribe_orchestration_events\": TOKEN}");
    else if (!lf_bridge_listen(l->seat->web->bridge, token))
        lf_ws_close(l->ws, LF_WS_POLICY, "there is no such orchestration");
    else
        snprintf(l->token, sizeof l->token, "%s", token);
    json_decref(message);
}

static void on_flushed(void *context)
{
    (void)context;
}

static void on_ended(void *context)
{
    const listener *l = context;
    sd_event_source_set_enabled(l->reap, SD_EVENT_ONESHOT);
}

static int on_reap(sd_event_source *source, void *context)
{
    (void)source;
    const listener *l = context;
    lf_seat_leave(l->seat);
    return 0;
}

/* ---------------------------------------------------------------------------------- its life -- */

static void destroy(void *guest)
{
    listener *l = guest;
    if (!l)
        return;
    lf_ws_destroy(l->ws);
    sd_event_source_disable_unref(l->reap);
    lf_free(l);
}

static lf_status create(lf_seat *seat, int fd, const void *early, size_t n, void **out_guest,
                        lf_error *err)
{
    listener *l = lf_calloc(1, sizeof *l);
    const lf_ws_events events = {
        .text = on_text, .flushed = on_flushed, .ended = on_ended, .context = l};
    lf_status status = l ? LF_OK : LF_E_NOMEM;
    if (l)
        l->seat = seat;
    if (status == LF_OK && (sd_event_add_defer(seat->web->event, &l->reap, on_reap, l) < 0 ||
                            sd_event_source_set_enabled(l->reap, SD_EVENT_OFF) < 0))
        status = LF_E_NOMEM;
    if (status == LF_OK)
        status = lf_ws_create(seat->web->event, fd, early, n, &events, &l->ws, err);
    if (status == LF_OK)
        *out_guest = l;
    else
        destroy(l);
    return status;
}

static const lf_seat_kind listener_kind = {.create = create, .destroy = destroy};

enum MHD_Result lf_bridge_events_answer(lf_request *r)
{
    return lf_seats_answer(r, &listener_kind);
}

static void send_event(const listener *l, json_t *event)
{
    json_t *message = lf_ws_queued(l->ws) <= MAX_QUEUED ? lf_bridge_event(l->token, event) : NULL;
    char *text = message ? json_dumps(message, JSON_COMPACT) : NULL;
    if (text)
        lf_ws_send_text(l->ws, text, strlen(text));
    free(text);
    json_decref(message);
}

void lf_bridge_events_tell(void *context, const char *token, json_t *event)
{
    const lf_web *web = context;
    for (const lf_seat *seat = web->seats; seat; seat = seat->next) {
        const listener *l = seat->kind == &listener_kind ? seat->guest : NULL;
        if (l && l->token[0] && (!token || strcmp(token, l->token) == 0))
            send_event(l, event);
    }
}
