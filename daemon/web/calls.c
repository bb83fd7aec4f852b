#include "daemon/web/calls.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/alloc.h"
#include "daemon/web/link.h"
#include "daemon/web/rights.h"

#define SUBSCRIBE "quiltweb:subscribe"

typedef struct open_call {
    struct open_call *next; /* newer */
    uint64_t number;
    lf_calls_done_fn done;
    void *context; /* NULL: forgotten */
} open_call;

struct lf_calls {
    sd_event *event;
    const char *socket;
    json_t *methods, *subscriptions;
    json_t *rights; /* methods that this connection asks for; some may be unknown to quiltd */
    lf_calls_events events;
    lf_link *link;
    sd_event_source *patience, *broken; /* broken: on once the link has ended */
    open_call *first, *last;
    uint64_t number; /* of the last call */
};

/* -------------------------------------------------------------------------------------- ends -- */

static open_call *take_first(lf_calls *calls)
{
    open_call *call = calls->first;
    calls->first = call->next;
    if (!calls->first)
        calls->last = NULL;
    return call;
}

static void fail_all(lf_calls *calls, const char *why)
{
    open_call *end = calls->last; /* callers may ask again */
    for (bool more = end; more;) {
        open_call *call = take_first(calls);
        more = call != end;
        if (call->context)
            call->done(call->context, NULL, why);
        lf_free(call);
    }
}

static int on_broken(sd_event_source *source, void *context)
{
    (void)source;
    lf_calls *calls = context;
    lf_link_destroy(calls->link);
    calls->link = NULL;
    sd_event_source_set_enabled(calls->patience, SD_EVENT_OFF);
    calls->events.ended(calls->events.context);
    fail_all(calls, "quiltd has closed the connection, or does not answer");
    return 0;
}

static void on_end(void *context)
{
    lf_calls *calls = context;
    sd_event_source_set_enabled(calls->broken, SD_EVENT_ONESHOT);
}

static void give_up(lf_calls *calls)
{
    lf_link_close(calls->link);
    on_end(calls);
}

static int on_patience(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    give_up(context);
    return 0;
}

static void watch(lf_calls *calls)
{
    sd_event_source_set_time_relative(calls->patience, LF_CALLS_PATIENCE_S * (uint64_t)1000000);
    sd_event_source_set_enabled(calls->patience, calls->first ? SD_EVENT_ONESHOT : SD_EVENT_OFF);
}

/* ------------------------------------------------------------------------------------- lines -- */

/* quiltd may answer in another order. NULL: nobody has asked. */
static open_call *take_call(lf_calls *calls, uint64_t number)
{
    open_call *before = NULL, *call = calls->first;
    while (call && call->number != number) {
        before = call;
        call = call->next;
    }
    if (!call)
        return NULL;
    *(before ? &before->next : &calls->first) = call->next;
    if (calls->last == call)
        calls->last = before;
    watch(calls);
    return call;
}

static void answer(lf_calls *calls, const json_t *message)
{
    const json_t *id = json_object_get(message, "id");
    const json_t *result = json_object_get(message, "result");
    const char *why =
        json_string_value(json_object_get(json_object_get(message, "error"), "message"));
    open_call *call =
        json_is_integer(id) ? take_call(calls, (uint64_t)json_integer_value(id)) : NULL;
    if (call && call->context)
        call->done(call->context, result, result ? NULL : why ? why : "the answer is not JSON-RPC");
    lf_free(call);
}

static void on_line(void *context, const char *line, size_t n)
{
    lf_calls *calls = context;
    json_t *message = json_loadb(line, n, 0, NULL);
    const char *method = json_string_value(json_object_get(message, "method"));
    switch (lf_rights_read(message, calls->rights, NULL)) {
    case LF_RIGHTS_DONE:
        lf_link_go_on(calls->link);
        break;
    case LF_RIGHTS_AGAIN:
        if (lf_rights_limit(calls->link, calls->rights) != LF_OK)
            give_up(calls);
        break;
    case LF_RIGHTS_REFUSED:
        give_up(calls);
        break;
    case LF_RIGHTS_NONE:
        if (method)
            calls->events.note(calls->events.context, method, json_object_get(message, "params"));
        else
            answer(calls, message);
    }
    json_decref(message);
}

/* ---------------------------------------------------------------------------------- its life -- */

/* Takes message. */
static lf_status send_message(lf_calls *calls, json_t *message)
{
    char *line = message ? json_dumps(message, JSON_COMPACT) : NULL;
    lf_status status = line ? lf_link_send(calls->link, line, strlen(line), -1) : LF_E_NOMEM;
    free(line);
    json_decref(message);
    return status;
}

lf_status lf_calls_connect(lf_calls *calls, lf_error *err)
{
    const lf_link_events events = {.line = on_line, .ended = on_end, .context = calls};
    if (calls->link)
        return LF_OK;
    lf_status status = lf_link_create(calls->event, calls->socket, &events, &calls->link, err);
    if (status != LF_OK)
        return status;
    json_decref(calls->rights);
    calls->rights = json_copy(calls->methods);
    status = lf_rights_limit(calls->link, calls->rights);
    if (status == LF_OK)
        status = send_message(calls, json_pack("{s:s, s:s, s:s, s:{s:O}}", "jsonrpc", "2.0", "id",
                                               SUBSCRIBE, "method", "subscribe", "params", "events",
                                               calls->subscriptions));
    if (status == LF_OK)
        return LF_OK;
    lf_link_destroy(calls->link);
    calls->link = NULL;
    return lf_error_set(err, status, "quiltd", "out of memory");
}

lf_status lf_calls_ask(lf_calls *calls, const char *method, json_t *params, lf_calls_done_fn done,
                       void *context, lf_error *err)
{
    lf_status status = lf_calls_connect(calls, err);
    open_call *call = status == LF_OK ? lf_calloc(1, sizeof *call) : NULL;
    if (!call) {
        json_decref(params);
        return status != LF_OK ? status : lf_error_set(err, LF_E_NOMEM, "quiltd", "out of memory");
    }
    *call = (open_call){.number = ++calls->number, .done = done, .context = context};
    status = send_message(calls,
                          json_pack("{s:s, s:I, s:s, s:o*}", "jsonrpc", "2.0", "id",
                                    (json_int_t)call->number, "method", method, "params", params));
    if (status != LF_OK) {
        lf_free(call);
        return lf_error_set(err, status, "quiltd", "out of memory");
    }
    *(calls->last ? &calls->last->next : &calls->first) = call;
    calls->last = call;
    if (calls->first == call)
        watch(calls);
    return LF_OK;
}

void lf_calls_forget(lf_calls *calls, const void *context)
{
    for (open_call *call = calls->first; call; call = call->next)
        if (call->context == context)
            call->context = NULL;
}

lf_status lf_calls_create(sd_event *event, const char *socket, json_t *methods,
                          json_t *subscriptions, const lf_calls_events *events, lf_calls **out,
                          lf_error *err)
{
    lf_calls *calls = lf_calloc(1, sizeof *calls);
    if (!calls) {
        json_decref(methods);
        json_decref(subscriptions);
        return lf_error_set(err, LF_E_NOMEM, "quiltd", "out of memory");
    }
    *calls = (lf_calls){.event = event,
                        .socket = socket,
                        .methods = methods,
                        .subscriptions = subscriptions,
                        .events = *events};
    if (!methods || !subscriptions ||
        sd_event_add_defer(event, &calls->broken, on_broken, calls) < 0 ||
        sd_event_source_set_enabled(calls->broken, SD_EVENT_OFF) < 0 ||
        sd_event_add_time_relative(event, &calls->patience, CLOCK_MONOTONIC, 0, 0, on_patience,
                                   calls) < 0 ||
        sd_event_source_set_enabled(calls->patience, SD_EVENT_OFF) < 0) {
        lf_calls_destroy(calls);
        return lf_error_set(err, LF_E_NOMEM, "quiltd", "out of memory");
    }
    *out = calls;
    return LF_OK;
}

void lf_calls_destroy(lf_calls *calls)
{
    if (!calls)
        return;
    while (calls->first)
        lf_free(take_first(calls));
    lf_link_destroy(calls->link);
    sd_event_source_disable_unref(calls->patience);
    sd_event_source_disable_unref(calls->broken);
    json_decref(calls->methods);
    json_decref(calls->subscriptions);
    json_decref(calls->rights);
    lf_free(calls);
}
