#include "daemon/web/fetch.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "daemon/web/image.h"
#include "daemon/web/link.h"

#define PATIENCE_USEC ((uint64_t)8000000)

static const char where[] = "quiltd";

struct lf_fetch {
    lf_fetch_kind kind;
    lf_fetch_done_fn done;
    void *context;
    lf_link *link;
    sd_event_source *patience;
    lf_status status; /* LF_E_BUSY until the end */
    lf_error error;
    char *text;  /* by jansson */
    int fd;      /* -1: none */
    size_t size; /* of its file */
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

static lf_status take_result(lf_fetch *fetch, const json_t *result)
{
    lf_web_image image;
    if (fetch->kind == LF_FETCH_STATUS) {
        fetch->text = json_dumps(result, JSON_COMPACT);
        return fetch->text ? LF_OK
                           : lf_error_set(&fetch->error, LF_E_NOMEM, where, "out of memory");
    }
    lf_status status = lf_web_image_read(result, fetch->fd, &image, &fetch->error);
    if (status == LF_OK)
        fetch->size = image.bytes;
    return status;
}

static void on_line(void *context, const char *line, size_t n)
{
    lf_fetch *fetch = context;
    json_t *message = json_loadb(line, n, 0, NULL);
    const json_t *result = json_object_get(message, "result");
    const char *why =
        json_string_value(json_object_get(json_object_get(message, "error"), "message"));
    lf_status status;
    if (result)
        status = take_result(fetch, result);
    else
        status = lf_error_set(&fetch->error, LF_E_STATE, where, "%s",
                              why ? why : "the answer is not JSON-RPC");
    json_decref(message);
    finish(fetch, status);
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

static lf_status begin(lf_fetch *fetch, sd_event *event, const char *socket, lf_error *err)
{
    static const char status_line[] = "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"status\"}";
    static const char still_line[] = "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"frame.get\","
                                     "\"params\":{\"views\":1,\"format\":\"jpeg\"}}";
    const lf_link_events events = {.line = on_line, .ended = on_end, .context = fetch};
    const char *line = fetch->kind == LF_FETCH_STATUS ? status_line : still_line;
    lf_status status = LF_OK;
    if (fetch->kind == LF_FETCH_STILL)
        status = lf_web_image_file(&fetch->fd, err);
    if (status == LF_OK)
        status = lf_link_create(event, socket, &events, &fetch->link, err);
    if (status != LF_OK)
        return status;
    if (lf_link_send(fetch->link, line, strlen(line), fetch->fd) != LF_OK ||
        sd_event_add_time_relative(event, &fetch->patience, CLOCK_MONOTONIC, PATIENCE_USEC, 0,
                                   on_patience, fetch) < 0)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    return LF_OK;
}

lf_status lf_fetch_create(sd_event *event, const char *socket, lf_fetch_kind kind,
                          lf_fetch_done_fn done, void *context, lf_fetch **out, lf_error *err)
{
    lf_fetch *fetch = lf_calloc(1, sizeof *fetch);
    if (!fetch)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    *fetch =
        (lf_fetch){.kind = kind, .done = done, .context = context, .status = LF_E_BUSY, .fd = -1};
    lf_status status = begin(fetch, event, socket, err);
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
    if (fetch->fd >= 0)
        close(fetch->fd);
    free(fetch->text);
    lf_free(fetch);
}

lf_status lf_fetch_result(lf_fetch *fetch, const char **out_text, int *out_fd, size_t *out_size,
                          lf_error *err)
{
    if (fetch->status != LF_OK) {
        if (err)
            *err = fetch->error;
        return fetch->status;
    }
    *out_text = fetch->text;
    *out_size = fetch->size;
    *out_fd = fetch->fd;
    fetch->fd = -1;
    return LF_OK;
}
