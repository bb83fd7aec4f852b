#include "daemon/web/session.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/web/allow.h"
#include "daemon/web/exports.h"
#include "daemon/web/image.h"
#include "daemon/web/link.h"
#include "daemon/web/memory.h"
#include "daemon/web/rights.h"
#include "daemon/web/ws.h"
#include "daemon/wire/rpc.h"

/* Ids of our own requests begin so, and those of clients may not. */
#define OWN "quiltweb:"
#define OWN_IMAGE OWN "image"
/* Longer lines are none of ours, and are passed on unread. */
#define MAX_OWN_LINE ((size_t)16384)
/* Above this quiltd is not read. */
#define MAX_QUEUED_OUT ((size_t)262144)
/* Above this a client sends faster than quiltd reads. */
#define MAX_QUEUED_IN ((size_t)4 << 20)
#define PREVIEW_PACE_USEC ((uint64_t)250000)

struct lf_session {
    lf_ws *ws;
    lf_link *link;
    lf_uploads *uploads;
    lf_session_passed_fn passed;
    void *passed_context;
    lf_exports *exports;
    json_t *rights;        /* methods that the connection to quiltd is limited to */
    sd_event_source *reap; /* on once the session has ended */
    lf_session_ended_fn on_end;
    void *context;
    struct {
        bool on;
        bool wanted;           /* quiltd shows an image that the client has not got */
        bool asked;            /* frame.get is on its way */
        bool unacked;          /* the client has not acknowledged the last image */
        int level;             /* of the image that quiltd shows */
        int width_px;          /* asked for; 0: as rendered */
        int fd;                /* of the image asked for; -1: none */
        lf_web_image rendered; /* the last image at full size; width 0: unknown */
        sd_event_source *pace; /* on: the next image has to wait */
    } preview;
};

/* ----------------------------------------------------------------------------- to both sides -- */

static void say(void *context, json_t *message)
{
    lf_session *s = context;
    char *text = message ? json_dumps(message, JSON_COMPACT) : NULL;
    if (text)
        lf_ws_send_text(s->ws, text, strlen(text));
    else
        lf_ws_close(s->ws, LF_WS_INTERNAL, "out of memory");
    free(text);
    json_decref(message);
}

static void refuse(lf_session *s, const lf_rpc_request *request, int code, const lf_error *err)
{
    char text[sizeof *err + 32];
    if (request->id)
        say(s, lf_rpc_error(request->id, code, lf_error_format(err, text, sizeof text), NULL));
}

/* Sends a request to quiltd, and frees it. NULL: out of memory. */
static void ask_daemon(void *context, char *text, const int *fds, int n_fds)
{
    lf_session *s = context;
    if (!text || lf_link_send_fds(s->link, text, strlen(text), fds, n_fds) != LF_OK)
        lf_ws_close(s->ws, LF_WS_INTERNAL, "out of memory");
    else if (lf_link_queued(s->link) > MAX_QUEUED_IN)
        lf_ws_close(s->ws, LF_WS_POLICY, "requests come faster than quiltd reads them");
    free(text);
}

/* A line that is too long, because of 1e9 as 1000000000.0 for example, would be answered without
 * its id. Closes the descriptors. */
static void pass_on(lf_session *s, const lf_rpc_request *request, const int *fds, int n_fds)
{
    lf_error err = {0};
    char *text = json_dumps(request->message, JSON_COMPACT);
    if (!text || strlen(text) <= LF_RPC_MAX_LINE) {
        ask_daemon(s, text, fds, n_fds);
    } else {
        free(text);
        (void)lf_error_set(&err, LF_E_ARG, request->method, "the request is longer than 1 MiB");
        refuse(s, request, LF_RPC_INVALID_REQUEST, &err);
    }
    for (int i = 0; i < n_fds; i++)
        close(fds[i]);
}

/* Uploads go as descriptors; files of another name do not. */
static void pass_files(lf_session *s, const lf_rpc_request *request)
{
    int fds[LF_UPLOADS_A_CALL], n = 0;
    lf_error err = {0};
    const json_t *files = json_object_get(request->params, "files");
    lf_uploads_passed passed = {0};
    if (files)
        passed = s->passed(s->passed_context);
    if (files && lf_uploads_take(s->uploads, files, &passed, fds, &n, &err) != LF_OK)
        refuse(s, request, err.status == LF_E_ARG ? LF_RPC_INVALID_PARAMS : LF_RPC_BUSY, &err);
    else
        pass_on(s, request, fds, n);
}

/* ------------------------------------------------------------------------------------ images -- */

static bool is_pacing(const lf_session *s)
{
    int enabled = SD_EVENT_OFF;
    return sd_event_source_get_enabled(s->preview.pace, &enabled) >= 0 && enabled != SD_EVENT_OFF;
}

static void forget_image(lf_session *s)
{
    if (s->preview.fd >= 0)
        close(s->preview.fd);
    s->preview.fd = -1;
    s->preview.asked = false;
}

/* Asks for the image that quiltd shows, if the client wants it and may get it now. */
static void ask_image(lf_session *s)
{
    lf_error err = {0};
    if (!s->preview.on || !s->preview.wanted || s->preview.asked || s->preview.unacked ||
        is_pacing(s) || lf_ws_queued(s->ws) > MAX_QUEUED_OUT)
        return;
    if (lf_memory_create(&s->preview.fd, &err) != LF_OK) {
        lf_log_error(&err);
        return;
    }
    const int width = lf_web_image_width(&s->preview.rendered, s->preview.level);
    json_t *message = json_pack("{s:s, s:s, s:s, s:{s:s}}", "jsonrpc", "2.0", "id", OWN_IMAGE,
                                "method", "frame.get", "params", "format", "jpeg");
    if (message && width > 0)
        json_object_set_new(json_object_get(message, "params"), "width", json_integer(width));
    s->preview.width_px = width;
    s->preview.wanted = false;
    s->preview.asked = true;
    ask_daemon(s, json_dumps(message, JSON_COMPACT), &s->preview.fd, 1);
    json_decref(message);
    sd_event_source_set_time_relative(s->preview.pace, PREVIEW_PACE_USEC);
    sd_event_source_set_enabled(s->preview.pace, SD_EVENT_ONESHOT);
}

static int on_pace(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    ask_image(context);
    return 0;
}

static void pass_image(lf_session *s, const lf_web_image *image)
{
    lf_error err = {0};
    uint8_t *data = NULL;
    size_t n = 0;
    if (lf_web_image_message(image, s->preview.fd, &data, &n, &err) != LF_OK) {
        lf_log_error(&err);
        return;
    }
    lf_ws_send_binary(s->ws, data, n);
    s->preview.unacked = true;
    lf_free(data);
}

/* The answer to frame.get. */
static void take_image(lf_session *s, const json_t *message)
{
    lf_web_image image;
    lf_error err = {0};
    const json_t *result = json_object_get(message, "result");
    const json_t *code = json_object_get(json_object_get(message, "error"), "code");
    const int width = s->preview.width_px;
    if (!s->preview.asked)
        return;
    const bool refused = !result && json_integer_value(code) == LF_RPC_INVALID_PARAMS && width > 0;
    const bool is_read = result && lf_web_image_read(result, s->preview.fd, &image, &err) == LF_OK;
    if (result && !is_read)
        lf_log_error(&err);
    /* views of another scene, which may be smaller: ask for them as they are rendered */
    if (refused || (is_read && width > 0 && !lf_web_image_is_like(&image, &s->preview.rendered))) {
        s->preview.rendered.width_px = 0;
        s->preview.wanted = true;
    } else if (is_read && s->preview.on) {
        s->preview.level = image.level;
        if (width == 0)
            s->preview.rendered = image;
        const int best = lf_web_image_width(&s->preview.rendered, lf_web_image_level("complete"));
        if (width > 0 || best == 0)
            pass_image(s, &image);
        /* too large for a browser, or half of what has become complete meanwhile */
        if ((width == 0 && best > 0) ||
            (image.level >= lf_web_image_level("complete") && width != best))
            s->preview.wanted = true;
    }
    forget_image(s);
    ask_image(s);
}

static void note_frame(lf_session *s, const json_t *params)
{
    s->preview.level = lf_web_image_level(json_string_value(json_object_get(params, "level")));
    s->preview.wanted = !json_object_get(params, "card");
    ask_image(s);
}

static void on_preview(lf_session *s, const lf_rpc_request *request)
{
    const char *verb = strchr(request->method, '.') + 1;
    if (strcmp(verb, "start") == 0)
        s->preview.on = s->preview.wanted = true;
    else if (strcmp(verb, "stop") == 0)
        s->preview.on = s->preview.unacked = false;
    else
        s->preview.unacked = false;
    if (request->id)
        say(s, lf_rpc_result(request->id, json_object()));
    ask_image(s);
}

/* ----------------------------------------------------------------------- messages of clients -- */

static bool is_own_method(const char *method)
{
    return strcmp(method, "preview.start") == 0 || strcmp(method, "preview.stop") == 0 ||
           strcmp(method, "preview.ack") == 0;
}

/* Images follow `frame`, whatever the client subscribes to. */
static void keep_frames(json_t *events)
{
    size_t i;
    json_t *event;
    json_array_foreach(events, i, event) if (json_is_string(event) &&
                                             strcmp(json_string_value(event), "frame") == 0) return;
    json_array_append_new(events, json_string("frame"));
}

static void on_request(lf_session *s, const lf_rpc_request *request)
{
    lf_error err = {0};
    const char *id = json_string_value(request->id);
    if (id && strncmp(id, OWN, strlen(OWN)) == 0) {
        (void)lf_error_set(&err, LF_E_ARG, "id", "must not begin with %s", OWN);
        refuse(s, request, LF_RPC_INVALID_REQUEST, &err);
        return;
    }
    if (is_own_method(request->method)) {
        if (json_object_size(request->params) == 0) {
            on_preview(s, request);
            return;
        }
        (void)lf_error_set(&err, LF_E_ARG, request->method, "takes no parameters");
        refuse(s, request, LF_RPC_INVALID_PARAMS, &err);
        return;
    }
    lf_status status = lf_allow_check(request->method, request->params, &err);
    if (status != LF_OK) {
        refuse(s, request, status == LF_E_ARG ? LF_RPC_INVALID_PARAMS : LF_RPC_METHOD_NOT_FOUND,
               &err);
        return;
    }
    if (strcmp(request->method, "export") == 0) {
        status = lf_exports_begin(s->exports, request, &err);
        if (status != LF_OK)
            refuse(s, request, status == LF_E_ARG ? LF_RPC_INVALID_PARAMS : LF_RPC_BUSY, &err);
        return;
    }
    if (strcmp(request->method, "subscribe") == 0)
        keep_frames(json_object_get(request->params, "events"));
    pass_files(s, request);
}

static void on_text(void *context, const char *text, size_t n)
{
    lf_session *s = context;
    lf_rpc_request request;
    json_t *answer = NULL;
    if (!lf_rpc_parse(text, n, &request, &answer)) {
        say(s, answer);
        return;
    }
    on_request(s, &request);
    lf_rpc_request_finish(&request);
}

/* --------------------------------------------------------------------------- lines of quiltd -- */

static void limit_rights(lf_session *s)
{
    if (lf_rights_limit(s->link, s->rights) != LF_OK)
        lf_ws_close(s->ws, LF_WS_INTERNAL, "out of memory");
}

/* True: the message is an answer to us. */
static bool take_own(lf_session *s, json_t *message)
{
    const char *id = json_string_value(json_object_get(message, "id"));
    lf_error err = {0};
    if (!id || strncmp(id, OWN, strlen(OWN)) != 0)
        return false;
    const lf_rights_answer rights = lf_rights_read(message, s->rights, &err);
    if (rights == LF_RIGHTS_AGAIN)
        limit_rights(s);
    else if (rights == LF_RIGHTS_REFUSED)
        lf_ws_close(s->ws, LF_WS_INTERNAL, err.what);
    else if (rights == LF_RIGHTS_DONE)
        lf_link_go_on(s->link);
    else if (strcmp(id, OWN_IMAGE) == 0)
        take_image(s, message);
    else
        (void)lf_exports_answer(s->exports, message);
    return true;
}

static void note(lf_session *s, const json_t *message)
{
    const char *method = json_string_value(json_object_get(message, "method"));
    const json_t *params = json_object_get(message, "params");
    if (method && strcmp(method, "frame") == 0)
        note_frame(s, params);
    else if (method && strcmp(method, "export") == 0)
        lf_exports_note(s->exports, params);
}

static void on_line(void *context, const char *line, size_t n)
{
    lf_session *s = context;
    json_t *message = n <= MAX_OWN_LINE ? json_loadb(line, n, 0, NULL) : NULL;
    if (!take_own(s, message)) {
        lf_ws_send_text(s->ws, line, n);
        note(s, message);
    }
    json_decref(message);
    if (lf_ws_queued(s->ws) > MAX_QUEUED_OUT)
        lf_link_pause(s->link, true);
}

static void on_flushed(void *context)
{
    lf_session *s = context;
    if (!s->link || lf_ws_queued(s->ws) > MAX_QUEUED_OUT)
        return;
    lf_link_pause(s->link, false);
    ask_image(s);
}

static void on_link_end(void *context)
{
    lf_session *s = context;
    lf_ws_close(s->ws, LF_WS_GOING_AWAY, "quiltd has closed the connection");
}

/* ---------------------------------------------------------------------------------- its life -- */

static void on_ws_end(void *context)
{
    lf_session *s = context;
    lf_link_close(s->link);
    sd_event_source_set_enabled(s->reap, SD_EVENT_ONESHOT);
}

static int on_reap(sd_event_source *source, void *context)
{
    (void)source;
    lf_session *s = context;
    if (s->on_end)
        s->on_end(s->context, s);
    return 0;
}

/* All that clients may call, and what the session calls for them. */
static json_t *all_rights(void)
{
    json_t *rights = json_pack("[s]", "frame.get");
    for (int i = 0; lf_allow_at(i); i++)
        json_array_append_new(rights, json_string(lf_allow_at(i)));
    return rights;
}

static void connect_daemon(lf_session *s, const lf_session_home *home)
{
    static const char subscribe[] = "{\"jsonrpc\":\"2.0\",\"id\":\"" OWN
                                    "subscribe\",\"method\":\"subscribe\",\"params\":{\"events\":"
                                    "[\"frame\"]}}";
    const lf_link_events events = {.line = on_line, .ended = on_link_end, .context = s};
    lf_error err = {0};
    if (lf_link_create(home->event, home->socket, &events, &s->link, &err) != LF_OK) {
        lf_log_error(&err);
        lf_ws_close(s->ws, LF_WS_INTERNAL, err.what);
        return;
    }
    limit_rights(s);
    if (lf_link_send(s->link, subscribe, strlen(subscribe), -1) != LF_OK)
        lf_ws_close(s->ws, LF_WS_INTERNAL, "out of memory");
}

static lf_status set_up(lf_session *s, const lf_session_home *home, int fd, const void *early,
                        size_t n, lf_error *err)
{
    const lf_ws_events events = {
        .text = on_text, .flushed = on_flushed, .ended = on_ws_end, .context = s};
    const lf_exports_events exports = {.say = say, .ask = ask_daemon, .context = s};
    s->uploads = home->uploads;
    s->passed = home->passed;
    s->passed_context = home->context;
    s->preview.fd = -1;
    s->rights = all_rights();
    if (sd_event_add_defer(home->event, &s->reap, on_reap, s) < 0 ||
        sd_event_source_set_enabled(s->reap, SD_EVENT_OFF) < 0 ||
        sd_event_add_time_relative(home->event, &s->preview.pace, CLOCK_MONOTONIC, 0, 1, on_pace,
                                   s) < 0 ||
        sd_event_source_set_enabled(s->preview.pace, SD_EVENT_OFF) < 0)
        return lf_error_set(err, LF_E_NOMEM, "session", "out of memory");
    lf_status status = lf_exports_create(home->downloads, &exports, &s->exports, err);
    return status == LF_OK ? lf_ws_create(home->event, fd, early, n, &events, &s->ws, err) : status;
}

lf_status lf_session_create(const lf_session_home *home, int fd, const void *early, size_t n,
                            lf_session **out, lf_error *err)
{
    lf_session *s = lf_calloc(1, sizeof *s);
    if (!s)
        return lf_error_set(err, LF_E_NOMEM, "session", "out of memory");
    lf_status status = set_up(s, home, fd, early, n, err);
    if (status != LF_OK) {
        lf_session_destroy(s);
        return status;
    }
    connect_daemon(s, home);
    *out = s;
    return LF_OK;
}

void lf_session_add_passed(const lf_session *session, lf_uploads_passed *passed)
{
    if (session->link)
        lf_link_waiting(session->link, &passed->files, &passed->bytes);
}

void lf_session_on_end(lf_session *session, lf_session_ended_fn fn, void *context)
{
    session->on_end = fn;
    session->context = context;
}

void lf_session_destroy(lf_session *session)
{
    if (!session)
        return;
    lf_ws_destroy(session->ws);
    lf_link_destroy(session->link);
    lf_exports_destroy(session->exports);
    json_decref(session->rights);
    forget_image(session);
    sd_event_source_disable_unref(session->reap);
    sd_event_source_disable_unref(session->preview.pace);
    lf_free(session);
}
