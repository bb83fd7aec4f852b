/* The service of WebXR pages: the older protocol (driver.h) at /driver, and the calibration at /.
 */
#include "daemon/web/web_internal.h"

#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "daemon/web/panel_info.h"
#include "daemon/web/reply.h"
#include "daemon/web/ws.h"

#define PACE_USEC ((uint64_t)20000000)
#define ASK_S 8u
/* Answers that wait; more are dropped: their client does not read. */
#define MAX_QUEUED ((size_t)65536)

typedef struct guest {
    lf_seat *seat;
    lf_ws *ws;
    sd_event_source *reap; /* on once it has ended */
    /* at /driver */
    lf_driver_client *client;
    lf_patience *patience;
    bool inside; /* a message */
    /* at / */
    lf_fetch *fetch[2]; /* the calibration, then the status */
} guest;

static void destroy_guest(void *context)
{
    guest *gone = context;
    if (!gone)
        return;
    sd_event_source_disable_unref(gone->reap);
    lf_driver_leave(gone->client);
    lf_patience_destroy(gone->patience);
    lf_fetch_destroy(gone->fetch[0]);
    lf_fetch_destroy(gone->fetch[1]);
    lf_ws_destroy(gone->ws);
    lf_free(gone);
}

static int on_reap(sd_event_source *source, void *context)
{
    (void)source;
    const guest *gone = context;
    lf_seat_leave(gone->seat);
    return 0;
}

static void on_ended(void *context)
{
    const guest *g = context;
    sd_event_source_set_enabled(g->reap, SD_EVENT_ONESHOT);
}

static void on_flushed(void *context)
{
    (void)context;
}

/* A WebSocket with these events, besides the common ones. */
static lf_status begin(guest *g, int fd, const void *early, size_t n, lf_ws_events events,
                       lf_error *err)
{
    sd_event *event = g->seat->web->event;
    events.flushed = on_flushed;
    events.ended = on_ended;
    events.context = g;
    if (sd_event_add_defer(event, &g->reap, on_reap, g) < 0)
        return lf_error_set(err, LF_E_NOMEM, "WebSocket", "out of memory");
    sd_event_source_set_enabled(g->reap, SD_EVENT_OFF);
    return lf_ws_create(event, fd, early, n, &events, &g->ws, err);
}

static lf_status finish(lf_status status, guest *g, void **out)
{
    if (status == LF_OK)
        *out = g;
    else
        destroy_guest(g);
    return status;
}

/* ------------------------------------------------------------------------------------ driver -- */

static void on_part(void *context, const uint8_t *data, size_t n)
{
    guest *g = context;
    if (n > 0 && !g->inside)
        lf_patience_pace(g->patience, PACE_USEC);
    g->inside = n > 0;
    lf_patience_note(g->patience, n);
    if (n == 0)
        lf_patience_stop(g->patience);
    const lf_status status = n > 0 ? lf_driver_take(g->client, data, n) : lf_driver_end(g->client);
    if (status != LF_OK)
        lf_ws_close(g->ws, LF_WS_POLICY, "messages come faster than they are answered");
    else if (lf_driver_is_busy(g->client)) {
        lf_patience_stop(g->patience); /* it waits for us */
        lf_ws_pause(g->ws, true);
    }
}

static void on_reply(void *context, const uint8_t *data, size_t n)
{
    const guest *g = context;
    if (lf_ws_queued(g->ws) + n <= MAX_QUEUED)
        lf_ws_send_binary(g->ws, data, n);
}

static void on_ready(void *context)
{
    const guest *g = context;
    if (g->inside)
        lf_patience_pace(g->patience, PACE_USEC);
    lf_ws_pause(g->ws, false);
}

static lf_status create_driver(lf_seat *seat, int fd, const void *early, size_t n, void **out,
                               lf_error *err)
{
    const lf_web *web = seat->web;
    guest *g = lf_calloc(1, sizeof *g);
    if (!g)
        return lf_error_set(err, LF_E_NOMEM, "WebSocket", "out of memory");
    g->seat = seat;
    const lf_driver_events events = {.reply = on_reply, .ready = on_ready, .context = g};
    const lf_ws_events parts = {.part = on_part, .longest = lf_driver_longest(web->driver)};
    lf_status status = lf_driver_join(web->driver, &events, &g->client);
    if (status == LF_OK)
        status = lf_patience_create(web->event, fd, PACE_USEC, &g->patience);
    lf_patience_stop(g->patience);
    if (status == LF_OK)
        status = begin(g, fd, early, n, parts, err);
    return finish(status, g, out);
}

enum MHD_Result lf_webxr_driver(lf_request *r)
{
    static const lf_seat_kind kind = {
        .protocol = "rep.sp.nanomsg.org", .create = create_driver, .destroy = destroy_guest};
    if (!r->web->driver)
        return lf_request_refuse(r, 503, "there is no driver");
    return lf_seats_answer(r, &kind);
}

/* ------------------------------------------------------------------------------- calibration -- */

static void on_text(void *context, const char *text, size_t n)
{
    (void)context; /* nothing is asked here */
    (void)text;
    (void)n;
}

/* Sends the calibration as the panel's own file has it. */
static void send_calibration(const guest *g, const json_t *calibration, const json_t *device)
{
    json_t *panel = lf_panel_info(calibration, device);
    char *text = panel ? json_dumps(json_object_get(panel, "calibration"), JSON_COMPACT) : NULL;
    if (text)
        lf_ws_send_text(g->ws, text, strlen(text));
    else
        lf_ws_close(g->ws, LF_WS_INTERNAL, "there is no panel");
    free(text);
    json_decref(panel);
}

static void on_fetched(void *context);

static void ask(guest *g, int step)
{
    const lf_web *web = g->seat->web;
    const lf_fetch_call call = {
        .method = step == 0 ? "device.calibration" : "status", .fd = -1, .patience_s = ASK_S};
    lf_error err = {0};
    if (lf_fetch_create(web->event, web->socket, &call, on_fetched, g, &g->fetch[step], &err) !=
        LF_OK)
        lf_ws_close(g->ws, LF_WS_INTERNAL, err.what);
}

static void on_fetched(void *context)
{
    guest *g = context;
    const json_t *calibration = NULL, *status = NULL;
    lf_error err = {0};
    int code = 0;
    if (lf_fetch_result(g->fetch[0], &calibration, &code, &err) != LF_OK ||
        (g->fetch[1] && lf_fetch_result(g->fetch[1], &status, &code, &err) != LF_OK))
        lf_ws_close(g->ws, LF_WS_INTERNAL, err.what);
    else if (status)
        send_calibration(g, calibration, json_object_get(status, "device"));
    else
        ask(g, 1);
}

static lf_status create_plain(lf_seat *seat, int fd, const void *early, size_t n, void **out,
                              lf_error *err)
{
    const lf_web *web = seat->web;
    const json_t *known = lf_panel_only_calibration(web->panel_only);
    guest *g = lf_calloc(1, sizeof *g);
    if (!g)
        return lf_error_set(err, LF_E_NOMEM, "WebSocket", "out of memory");
    g->seat = seat;
    lf_status status = begin(g, fd, early, n, (lf_ws_events){.text = on_text}, err);
    if (status == LF_OK && known)
        send_calibration(g, known, lf_panel_only_device(web->panel_only));
    else if (status == LF_OK)
        ask(g, 0);
    return finish(status, g, out);
}

enum MHD_Result lf_webxr_root(lf_request *r)
{
    static const lf_seat_kind kind = {.create = create_plain, .destroy = destroy_guest};
    if (MHD_lookup_connection_value(r->connection, MHD_HEADER_KIND, "Upgrade"))
        return lf_seats_answer(r, &kind);
    return lf_reply_text(r->connection, 200, "quiltweb");
}
