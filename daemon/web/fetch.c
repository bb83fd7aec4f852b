#include "daemon/web/fetch.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/alloc.h"
#include "daemon/web/link.h"
#include "daemon/web/rights.h"

#define ID "quiltweb:fetch"

static const char where[] = "quiltd";

struct lf_fetch {
    lf_fetch_done_fn done;
    void *context;
    lf_link *link;
    sd_event_source *patience;
    lf_status status; /* LF_E_BUSY until the end */
    lf_error error;
    int code;        /* of quiltd's error */
    json_t *message; /* the answer */
};

static void finish(lf_fetch *fetch, lf_status status)
{
    if (fetch->status != LF_E_BUSY)
        return;
    fetch->status = status;
    lf_link_close(fetch->link);
    fetch->patience = sd_event_source_disable_unref(fetch->patience);
    fetch->done(fetch->context);
}

static lf_status take_answer(lf_fetch *fetch, const json_t *message)
{
    const json_t *error = json_object_get(message, "error");
    const char *why = json_string_value(json_object_get(error, "message"));
    if (json_object_get(message, "result"))
        return LF_OK;
    fetch->code = (int)json_integer_value(json_object_get(error, "code"));
    return lf_error_set(&fetch->error, LF_E_STATE, where, "%s",
                        why ? why : "the answer is not JSON-RPC");
}

static void on_line(void *context, const char *line, size_t n)
{
    lf_fetch *fetch = context;
    json_t *message = json_loadb(line, n, 0, NULL);
    const char *id = json_string_value(json_object_get(message, "id"));
    const lf_rights_answer rights = lf_rights_read(message, NULL, &fetch->error);
    if (rights == LF_RIGHTS_REFUSED)
        finish(fetch, LF_E_STATE);
    else if (rights == LF_RIGHTS_DONE)
        lf_link_go_on(fetch->link);
    else if (id && strcmp(id, ID) == 0 && fetch->status == LF_E_BUSY) {
        fetch->message = json_incref(message);
        finish(fetch, take_answer(fetch, message));
    }
    json_decref(message);
}

static void on_end(void *context)
{
    lf_fetch *fetch = context;
    finish(fetch, lf_error_set(&fetch->error, LF_E_NODEV, where, "the connection broke"));
}

static int on_patience(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    lf_fetch *fetch = context;
    finish(fetch, lf_error_set(&fetch->error, LF_E_TIMEOUT, where, "no answer in time"));
    return 0;
}

void lf_fetch_cancel(lf_fetch *fetch)
{
    finish(fetch, lf_error_set(&fetch->error, LF_E_CANCELLED, where, "quiltweb is ending"));
}

static lf_status begin(lf_fetch *fetch, sd_event *event, const char *socket,
                       const lf_fetch_call *call, lf_error *err)
{
    const lf_link_events events = {.line = on_line, .ended = on_end, .context = fetch};
    lf_status status = lf_link_create(event, socket, &events, &fetch->link, err);
    if (status != LF_OK)
        return status;
    json_t *message = json_pack("{s:s, s:s, s:s, s:O*}", "jsonrpc", "2.0", "id", ID, "method",
                                call->method, "params", call->params);
    json_t *methods = json_pack("[s]", call->method);
    char *line = message ? json_dumps(message, JSON_COMPACT) : NULL;
    status = lf_rights_limit(fetch->link, methods);
    if (status == LF_OK)
        status = line ? lf_link_send(fetch->link, line, strlen(line), call->fd) : LF_E_NOMEM;
    free(line);
    json_decref(methods);
    json_decref(message);
    if (status != LF_OK ||
        sd_event_add_time_relative(event, &fetch->patience, CLOCK_MONOTONIC,
                                   (uint64_t)call->patience_s * 1000000, 0, on_patience, fetch) < 0)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    return LF_OK;
}

lf_status lf_fetch_create(sd_event *event, const char *socket, const lf_fetch_call *call,
                          lf_fetch_done_fn done, void *context, lf_fetch **out, lf_error *err)
{
    lf_fetch *fetch = lf_calloc(1, sizeof *fetch);
    if (!fetch)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    *fetch = (lf_fetch){.done = done, .context = context, .status = LF_E_BUSY};
    lf_status status = begin(fetch, event, socket, call, err);
    if (status == LF_OK)
        *out = fetch;
    else
        lf_fetch_destroy(fetch);
    return status;
}

void lf_fetch_destroy(lf_fetch *fetch)
{
    if (!fetch)
        return;
    lf_link_destroy(fetch->link);
    sd_event_source_disable_unref(fetch->patience);
    json_decref(fetch->message);
    lf_free(fetch);
}

lf_status lf_fetch_result(const lf_fetch *fetch, const json_t **out_result, int *out_code,
                          lf_error *err)
{
    if (fetch->status != LF_OK) {
        *out_code = fetch->code;
        if (err)
            *err = fetch->error;
        return fetch->status;
    }
    *out_result = json_object_get(fetch->message, "result");
    return LF_OK;
}
