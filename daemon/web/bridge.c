#include "daemon/web/bridge_internal.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "base/alloc.h"
#include "base/log.h"

#define PANEL "quiltd always shows its panel"
#define SYNC "quiltd copies nothing into the storage of a panel"
#define AUTOSTART "use quiltd --playlist FOLDER to play something from the start"
#define SOURCE "quiltd does not take over windows of other programs"
#define UNKNOWN "the reply to this request is not known"

/* --------------------------------------------------------------------------------- endpoints -- */

static void run_version(lf_bridge_call *call)
{
    lf_bridge_complete(call, lf_bridge_text(call->endpoint->name, call->bridge->config.version));
}

static const lf_bridge_endpoint endpoints[] = {
    {.name = "bridge_version", .run = run_version, .alone = true, .at_once = true},
    {.name = "api_version", .run = run_version, .alone = true, .at_once = true},
    {.name = "enter_orchestration", .run = lf_bridge_run_enter, .alone = true},
    {.name = "exit_orchestration", .run = lf_bridge_run_exit},
    {.name = "available_output_devices", .run = lf_bridge_run_devices, .alone = true},
    {.name = "show_window", .run = lf_bridge_run_window, .alone = true, .shows = true},
    {.name = "instance_playlist", .run = lf_bridge_run_instance, .event = "Playlist Instance"},
    {.name = "delete_playlist", .run = lf_bridge_run_delete, .event = "Playlist Delete"},
    {.name = "insert_playlist_entry", .run = lf_bridge_run_insert, .event = "Playlist Insert"},
    {.name = "play_playlist", .run = lf_bridge_run_play, .shows = true},
    {.name = "update_current_entry", .run = lf_bridge_run_update_current, .shows = true},
    {.name = "update_playlist_entry", .run = lf_bridge_run_update},
    {.name = "transport_control_play",
     .run = lf_bridge_run_resume,
     .event = "Transport Control Play",
     .shows = true},
    {.name = "transport_control_pause",
     .run = lf_bridge_run_pause,
     .event = "Transport Control Pause",
     .shows = true},
    {.name = "transport_control_next",
     .run = lf_bridge_run_transport,
     .method = "playlist.next",
     .event = "Transport Control Next",
     .shows = true},
    {.name = "transport_control_previous",
     .run = lf_bridge_run_transport,
     .method = "playlist.previous",
     .event = "Transport Control Previous",
     .shows = true},
    {.name = "transport_control_seek_to_index", .run = lf_bridge_run_seek, .shows = true},
    {.name = "all_supported_lkg_hardware", .why = UNKNOWN},
    {.name = "get_camera_parameters", .why = UNKNOWN},
    {.name = "sync_overwrite_playlist", .why = SYNC},
    {.name = "cancel_pending", .why = SYNC},
    {.name = "synced_file_hash", .why = SYNC},
    {.name = "instance_studio_playlist", .why = "quiltd reads no playlists of Studio"},
    {.name = "get_autostart_playlist", .why = AUTOSTART},
    {.name = "set_autostart_playlist", .why = AUTOSTART},
    {.name = "set_named_autostart_playlist", .why = AUTOSTART},
    {.name = "source_saveout", .why = SOURCE},
    {.name = "source_readback", .why = SOURCE},
};

enum { N_ENDPOINTS = sizeof endpoints / sizeof endpoints[0] };

static const lf_bridge_endpoint *find_endpoint(const char *name)
{
    for (int i = 0; i < N_ENDPOINTS; i++)
        if (strcmp(endpoints[i].name, name) == 0)
            return &endpoints[i];
    return NULL;
}

bool lf_bridge_knows(const char *endpoint)
{
    return find_endpoint(endpoint);
}

/* ------------------------------------------------------------------------------------ values -- */

json_t *lf_bridge_value(const char *name, const char *type, json_t *value)
{
    return json_pack("{s:s, s:s, s:o}", "name", name, "type", type, "value", value);
}

json_t *lf_bridge_text(const char *name, const char *text)
{
    return lf_bridge_value(name, "WSTRING", json_string(text));
}

json_t *lf_bridge_number_value(const char *name, json_int_t number)
{
    return lf_bridge_value(name, "UNSIGNED_INT", json_integer(number));
}

/* payload: taken; NULL: none. */
static json_t *make_message(const char *name, const char *token, json_t *payload,
                            const char *status)
{
    return json_pack("{s:s, s:o, s:o*, s:o}", "name", name, "orchestration",
                     lf_bridge_text("orchestration", token), "payload", payload, "status",
                     lf_bridge_text("status", status));
}

json_t *lf_bridge_event(const char *token, json_t *event)
{
    json_t *copy = json_copy(event);
    return make_message("event", token, lf_bridge_value("payload", "VARIANT_MAP", copy),
                        "Completion");
}

/* bridge.js takes each member of the payload of available_output_devices for a panel. */
static json_t *make_failure(const char *endpoint, const char *token, const char *why)
{
    const bool lists = strcmp(endpoint, "available_output_devices") == 0;
    json_t *message = lf_bridge_text("message", why), *payload = json_object();
    if (!lists)
        json_object_set(payload, "message", message);
    json_t *reply = make_message(endpoint, token,
                                 lf_bridge_value("payload", "VARIANT_MAP", payload), "Failure");
    if (lists)
        json_object_set(reply, "message", message);
    json_decref(message);
    return reply;
}

const char *lf_bridge_param(const lf_bridge_call *call, const char *name)
{
    const char *text = json_string_value(json_object_get(call->body, name));
    return text ? text : "";
}

bool lf_bridge_find_list(lf_bridge_call *call)
{
    const char *name = lf_bridge_param(call, "name");
    call->list = lf_orchestration_list(call->orchestration, name);
    if (!call->list)
        lf_bridge_fail(call, "there is no playlist \"%s\"; call instance_playlist first", name);
    return call->list;
}

/* ------------------------------------------------------------------------------------- calls -- */

static void free_call(lf_bridge_call *call)
{
    json_decref(call->body);
    json_decref(call->reply);
    json_decref(call->kept);
    json_decref(call->said);
    json_decref(call->entry);
    lf_free(call);
}

static void run(lf_bridge_call *call)
{
    lf_bridge *bridge = call->bridge;
    const char *token = lf_bridge_param(call, "orchestration");
    call->orchestration = lf_bridge_lists_find(bridge->lists, token);
    if (!call->endpoint->run)
        lf_bridge_fail(call, "%s", call->endpoint->why);
    else if (call->endpoint->shows && lf_panel_only_is_on(bridge->config.panel_only))
        lf_bridge_fail(call, "%s", LF_PANEL_ONLY_WORDS);
    else if (!call->endpoint->alone && !call->orchestration)
        lf_bridge_fail(call, "there is no such orchestration; call enter_orchestration first");
    else
        call->endpoint->run(call);
}

static void run_next(lf_bridge *bridge)
{
    while (!bridge->running && bridge->queue) {
        lf_bridge_call *call = bridge->queue;
        bridge->queue = call->next;
        call->next = NULL;
        bridge->running = call;
        run(call);
    }
}

static void end(lf_bridge_call *call, json_t *reply)
{
    lf_bridge *bridge = call->bridge;
    if (bridge->running == call)
        bridge->running = NULL;
    call->reply = reply;
    if (!call->done)
        free_call(call);
    else if (!call->beginning)
        call->done(call->context);
    run_next(bridge);
}

void lf_bridge_step_aside(lf_bridge_call *call)
{
    lf_bridge *bridge = call->bridge;
    call->orchestration = NULL; /* others may end it meanwhile */
    call->list = NULL;
    bridge->running = NULL;
    run_next(bridge);
}

static const char *token_of(const lf_bridge_call *call)
{
    return lf_bridge_param(call, "orchestration");
}

void lf_bridge_complete(lf_bridge_call *call, json_t *payload)
{
    if (call->endpoint->event)
        lf_bridge_show_tell(call, call->endpoint->event);
    const char *token =
        call->orchestration ? lf_orchestration_token(call->orchestration) : token_of(call);
    end(call, make_message(call->endpoint->name, token, payload, "Completion"));
}

void lf_bridge_pend(lf_bridge_call *call)
{
    end(call, make_message(call->endpoint->name, token_of(call), NULL, "Pending"));
}

static void be_quiet(const lf_bridge *bridge)
{
    sd_event_source_set_time_relative(bridge->last_failure.quiet,
                                      LF_BRIDGE_QUIET_S * (uint64_t)1000000);
    sd_event_source_set_enabled(bridge->last_failure.quiet, SD_EVENT_ONESHOT);
}

static void log_more(lf_bridge *bridge)
{
    const int more = bridge->last_failure.more;
    if (more > 0)
        lf_log(LF_LOG_WARNING, "%s (%d more time%s)", bridge->last_failure.text, more,
               more > 1 ? "s" : "");
    bridge->last_failure.more = 0;
}

static int on_quiet(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    lf_bridge *bridge = context;
    if (bridge->last_failure.more > 0)
        be_quiet(bridge);
    else
        bridge->last_failure.text[0] = '\0';
    log_more(bridge);
    return 0;
}

void lf_bridge_log_failure(lf_bridge *bridge, const char *endpoint, const char *why)
{
    char text[sizeof bridge->last_failure.text];
    bridge->failures++;
    snprintf(text, sizeof text, "bridge: %s: %s", endpoint, why);
    if (strcmp(text, bridge->last_failure.text) == 0) {
        bridge->last_failure.more++;
        return;
    }
    log_more(bridge);
    lf_log(LF_LOG_WARNING, "%s", text);
    memcpy(bridge->last_failure.text, text, sizeof text);
    be_quiet(bridge);
}

json_t *lf_bridge_failure(lf_bridge *bridge, const char *endpoint, const char *why)
{
    bridge->requests++;
    lf_bridge_log_failure(bridge, endpoint, why);
    return make_failure(endpoint, "", why);
}

void lf_bridge_fail(lf_bridge_call *call, const char *fmt, ...)
{
    lf_error said;
    va_list arguments;
    va_start(arguments, fmt);
    char text[sizeof said.what];
    vsnprintf(text, sizeof text, fmt, arguments);
    va_end(arguments);
    (void)lf_error_set(&said, LF_E_STATE, "", "%s", text); /* escaped */
    lf_bridge_log_failure(call->bridge, call->endpoint->name, said.what);
    end(call, make_failure(call->endpoint->name, token_of(call), said.what));
}

static void on_answer(void *context, const json_t *result, const char *why)
{
    lf_bridge_call *call = context;
    call->then(call, result, why);
}

void lf_bridge_ask(lf_bridge_call *call, const char *method, json_t *params, lf_bridge_then_fn then)
{
    lf_error err = {0};
    call->then = then;
    if (lf_calls_ask(call->bridge->calls, method, params, on_answer, call, &err) != LF_OK)
        lf_bridge_fail(call, "%s", err.what);
}

lf_status lf_bridge_begin(lf_bridge *bridge, const char *endpoint, json_t *body,
                          lf_bridge_done_fn done, void *context, lf_bridge_call **out,
                          lf_error *err)
{
    lf_bridge_call *call = lf_calloc(1, sizeof *call);
    lf_bridge_call **at = &bridge->queue;
    if (!call) {
        json_decref(body);
        return lf_error_set(err, LF_E_NOMEM, endpoint, "out of memory");
    }
    *call = (lf_bridge_call){.bridge = bridge,
                             .endpoint = find_endpoint(endpoint),
                             .body = body,
                             .done = done,
                             .context = context,
                             .beginning = true};
    bridge->requests++;
    while (*at)
        at = &(*at)->next;
    if (call->endpoint->at_once || !call->endpoint->run) {
        run(call);
    } else {
        *at = call;
        run_next(bridge);
    }
    call->beginning = false;
    *out = call;
    return LF_OK;
}

const json_t *lf_bridge_reply(const lf_bridge_call *call)
{
    return call->reply;
}

void lf_bridge_leave(lf_bridge_call *call)
{
    if (call && call->reply)
        free_call(call);
    else if (call)
        call->done = NULL;
}

/* ---------------------------------------------------------------------------------- its life -- */

static void on_note(void *context, const char *method, const json_t *params)
{
    lf_bridge *bridge = context;
    if (strcmp(method, "device") == 0)
        lf_bridge_panel_note(bridge, params);
    else
        lf_bridge_show_note(bridge, method, params);
}

/* Otherwise each call of the queue would wait for a quiltd that hangs. */
static void fail_queue(lf_bridge *bridge)
{
    lf_bridge_call *queue = bridge->queue;
    bridge->queue = NULL;
    while (queue) {
        lf_bridge_call *call = queue;
        queue = call->next;
        call->next = NULL;
        lf_bridge_fail(call, "quiltd does not answer; the request was not begun");
    }
}

static void on_ended(void *context)
{
    lf_bridge *bridge = context;
    bridge->knows_panel = bridge->measures_panel = false;
    fail_queue(bridge);
    lf_bridge_show_ended(bridge);
}

bool lf_bridge_listen(lf_bridge *bridge, const char *token)
{
    lf_error err = {0};
    if (!lf_bridge_lists_find(bridge->lists, token))
        return false;
    if (lf_calls_connect(bridge->calls, &err) != LF_OK)
        lf_log_error(&err);
    return true;
}

lf_status lf_bridge_create(const lf_bridge_config *config, lf_bridge **out, lf_error *err)
{
    lf_bridge *bridge = lf_calloc(1, sizeof *bridge);
    const lf_calls_events events = {.note = on_note, .ended = on_ended, .context = bridge};
    if (!bridge)
        return lf_error_set(err, LF_E_NOMEM, "bridge", "out of memory");
    bridge->config = *config;
    lf_status status = lf_bridge_lists_create(&bridge->lists, err);
    if (status == LF_OK)
        status = lf_calls_create(config->event, config->socket,
                                 json_pack("[s,s,s,s,s,s,s,s,s,s]", "status", "device.calibration",
                                           "playlist.set", "playlist.play", "playlist.stop",
                                           "playlist.next", "playlist.previous", "playlist.pause",
                                           "playlist.change", "subscribe"),
                                 json_pack("[s,s,s,s]", "playlist", "scene", "log", "device"),
                                 &events, &bridge->calls, err);
    if (status == LF_OK &&
        (sd_event_add_time_relative(config->event, &bridge->patience, CLOCK_MONOTONIC, 0, 0,
                                    lf_bridge_show_patience, bridge) < 0 ||
         sd_event_source_set_enabled(bridge->patience, SD_EVENT_OFF) < 0 ||
         sd_event_add_time_relative(config->event, &bridge->last_failure.quiet, CLOCK_MONOTONIC, 0,
                                    0, on_quiet, bridge) < 0 ||
         sd_event_source_set_enabled(bridge->last_failure.quiet, SD_EVENT_OFF) < 0))
        status = lf_error_set(err, LF_E_NOMEM, "bridge", "out of memory");
    if (status == LF_OK)
        *out = bridge;
    else
        lf_bridge_destroy(bridge);
    return status;
}

void lf_bridge_destroy(lf_bridge *bridge)
{
    if (!bridge)
        return;
    lf_calls_destroy(bridge->calls);
    if (bridge->running)
        free_call(bridge->running);
    if (bridge->waiting)
        free_call(bridge->waiting);
    while (bridge->queue) {
        lf_bridge_call *call = bridge->queue;
        bridge->queue = call->next;
        free_call(call);
    }
    sd_event_source_disable_unref(bridge->patience);
    sd_event_source_disable_unref(bridge->last_failure.quiet);
    json_decref(bridge->shown.files);
    json_decref(bridge->shown.tags);
    lf_bridge_lists_destroy(bridge->lists);
    lf_free(bridge);
}

uint64_t lf_bridge_requests(const lf_bridge *bridge)
{
    return bridge->requests;
}

uint64_t lf_bridge_failures(const lf_bridge *bridge)
{
    return bridge->failures;
}
