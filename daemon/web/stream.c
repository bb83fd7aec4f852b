#include "daemon/web/stream.h"

#include <jansson.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "daemon/web/image.h"
#include "daemon/web/link.h"
#include "daemon/web/memory.h"
#include "daemon/web/rights.h"
#include "daemon/wire/rpc.h"

#define ID "quiltweb:stream"
#define PACE_USEC ((uint64_t)250000)
#define REPEAT_USEC ((uint64_t)LF_STREAM_REPEAT_S * 1000000)
#define FIRST_USEC ((uint64_t)8000000)

static const char where[] = "quiltd";

struct lf_stream {
    lf_stream_ready_fn ready;
    void *context;
    lf_link *link;
    lf_status status; /* LF_E_BUSY until the end */
    lf_error error;
    bool waiting;           /* `ready` is due */
    bool wanted;            /* quiltd shows an image that is not here */
    int fd;                 /* of the image that was asked for; -1: none */
    char *part;             /* [n] headers, image and the boundary behind it; NULL: none */
    size_t n, at;           /* at n the client has taken all of it */
    sd_event_source *pace;  /* on: the next image has to wait */
    sd_event_source *again; /* the part is due again; before the first part: the end is */
};

static void tell(lf_stream *stream)
{
    if (!stream->waiting)
        return;
    stream->waiting = false;
    stream->ready(stream->context);
}

static void end(lf_stream *stream, lf_status status)
{
    if (stream->status != LF_E_BUSY)
        return;
    stream->status = status;
    lf_link_close(stream->link);
    sd_event_source_set_enabled(stream->pace, SD_EVENT_OFF);
    sd_event_source_set_enabled(stream->again, SD_EVENT_OFF);
    tell(stream);
}

void lf_stream_end(lf_stream *stream)
{
    end(stream, lf_error_set(&stream->error, LF_E_CANCELLED, where, "quiltweb is ending"));
}

static void turn_on(sd_event_source *timer, uint64_t usec)
{
    sd_event_source_set_time_relative(timer, usec);
    sd_event_source_set_enabled(timer, SD_EVENT_ONESHOT);
}

static bool is_on(sd_event_source *timer)
{
    int enabled = SD_EVENT_OFF;
    return sd_event_source_get_enabled(timer, &enabled) >= 0 && enabled != SD_EVENT_OFF;
}

/* ------------------------------------------------------------------------------------ images -- */

/* Asks for the image that quiltd shows, if the client has taken the last one. */
static void ask(lf_stream *stream)
{
    static const char call[] = "{\"jsonrpc\":\"2.0\",\"id\":\"" ID "\",\"method\":\"frame.get\","
                               "\"params\":{\"views\":1,\"format\":\"jpeg\"}}";
    if (stream->status != LF_E_BUSY || !stream->wanted || stream->fd >= 0 ||
        stream->at < stream->n || is_on(stream->pace))
        return;
    lf_status status = lf_memory_create(&stream->fd, &stream->error);
    if (status == LF_OK)
        status = lf_link_send(stream->link, call, strlen(call), stream->fd);
    if (status != LF_OK) {
        end(stream, lf_error_set(&stream->error, LF_E_NOMEM, where, "out of memory"));
        return;
    }
    stream->wanted = false;
    turn_on(stream->pace, PACE_USEC);
}

static int on_pace(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    ask(context);
    return 0;
}

static int on_again(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    lf_stream *stream = context;
    if (!stream->part) {
        end(stream, lf_error_set(&stream->error, LF_E_TIMEOUT, where, "no answer in time"));
        return 0;
    }
    if (stream->at == stream->n && stream->fd < 0) /* what was asked for would come in between */
        stream->at = 0;
    turn_on(stream->again, REPEAT_USEC);
    tell(stream);
    return 0;
}

/* The boundary behind an image shows a browser that the image is complete. */
static bool make_part(lf_stream *stream, const lf_web_image *image)
{
    static const char boundary[] = "\r\n--" LF_STREAM_BOUNDARY "\r\n";
    char head[128];
    const int n_head =
        snprintf(head, sizeof head, "%sContent-Type: image/jpeg\r\nContent-Length: %zu\r\n\r\n",
                 stream->part ? "" : boundary + 2, image->bytes);
    const size_t n = (size_t)n_head + image->bytes + strlen(boundary);
    char *part = image->bytes <= LF_WEB_IMAGE_MAX_BYTES ? lf_calloc(n, 1) : NULL;
    if (!part)
        return false;
    if (pread(stream->fd, part + n_head, image->bytes, 0) != (ssize_t)image->bytes) {
        lf_free(part);
        return false;
    }
    memcpy(part, head, (size_t)n_head);
    memcpy(part + n - strlen(boundary), boundary, strlen(boundary));
    lf_free(stream->part);
    stream->part = part;
    stream->n = n;
    stream->at = 0;
    return true;
}

/* The answer to frame.get. An error, for example that a card is shown, is no end after the first
 * image. */
static void take_image(lf_stream *stream, const json_t *message)
{
    lf_web_image image;
    const json_t *result = json_object_get(message, "result");
    const char *why =
        json_string_value(json_object_get(json_object_get(message, "error"), "message"));
    if (stream->fd < 0)
        return;
    lf_status status = LF_OK;
    if (!result)
        status = lf_error_set(&stream->error, LF_E_STATE, where, "%s", why ? why : "no image");
    else
        status = lf_web_image_read(result, stream->fd, &image, &stream->error);
    if (status == LF_OK && !make_part(stream, &image))
        status = lf_error_set(&stream->error, LF_E_NOMEM, where, "the image is too large");
    close(stream->fd);
    stream->fd = -1;
    if (status == LF_OK) {
        turn_on(stream->again, REPEAT_USEC);
        tell(stream);
    } else if (!stream->part) {
        end(stream, status);
    }
    ask(stream);
}

/* --------------------------------------------------------------------------- lines of quiltd -- */

static void on_line(void *context, const char *line, size_t n)
{
    lf_stream *stream = context;
    json_t *message = json_loadb(line, n, 0, NULL);
    const char *id = json_string_value(json_object_get(message, "id"));
    const char *method = json_string_value(json_object_get(message, "method"));
    const lf_rights_answer rights = lf_rights_read(message, NULL, &stream->error);
    if (rights == LF_RIGHTS_REFUSED) {
        end(stream, LF_E_STATE);
    } else if (rights == LF_RIGHTS_DONE) {
        lf_link_go_on(stream->link);
    } else if (id && strcmp(id, ID) == 0) {
        take_image(stream, message);
    } else if (method && strcmp(method, "frame") == 0) {
        stream->wanted = !json_object_get(json_object_get(message, "params"), "card");
        ask(stream);
    }
    json_decref(message);
}

static void on_end(void *context)
{
    lf_stream *stream = context;
    end(stream, lf_error_set(&stream->error, LF_E_NODEV, where, "the connection broke"));
}

/* ---------------------------------------------------------------------------------- its life -- */

static lf_status begin(lf_stream *stream, sd_event *event, const char *socket, lf_error *err)
{
    static const char subscribe[] = "{\"jsonrpc\":\"2.0\",\"method\":\"subscribe\","
                                    "\"params\":{\"events\":[\"frame\"]}}";
    const lf_link_events events = {.line = on_line, .ended = on_end, .context = stream};
    lf_status status = lf_link_create(event, socket, &events, &stream->link, err);
    if (status != LF_OK)
        return status;
    json_t *methods = json_pack("[s, s]", "subscribe", "frame.get");
    const bool sent = lf_rights_limit(stream->link, methods) == LF_OK &&
                      lf_link_send(stream->link, subscribe, strlen(subscribe), -1) == LF_OK &&
                      sd_event_add_time_relative(event, &stream->again, CLOCK_MONOTONIC, FIRST_USEC,
                                                 0, on_again, stream) >= 0 &&
                      sd_event_add_time_relative(event, &stream->pace, CLOCK_MONOTONIC, 0, 1,
                                                 on_pace, stream) >= 0;
    json_decref(methods);
    return sent ? LF_OK : lf_error_set(err, LF_E_NOMEM, where, "out of memory");
}

lf_status lf_stream_create(sd_event *event, const char *socket, lf_stream_ready_fn ready,
                           void *context, lf_stream **out, lf_error *err)
{
    lf_stream *stream = lf_calloc(1, sizeof *stream);
    if (!stream)
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    *stream = (lf_stream){.ready = ready,
                          .context = context,
                          .status = LF_E_BUSY,
                          .waiting = true,
                          .wanted = true,
                          .fd = -1};
    lf_status status = begin(stream, event, socket, err);
    if (status == LF_OK)
        *out = stream; /* on_pace asks for the first image */
    else
        lf_stream_destroy(stream);
    return status;
}

void lf_stream_destroy(lf_stream *stream)
{
    if (!stream)
        return;
    lf_link_destroy(stream->link);
    sd_event_source_disable_unref(stream->pace);
    sd_event_source_disable_unref(stream->again);
    if (stream->fd >= 0)
        close(stream->fd);
    lf_free(stream->part);
    lf_free(stream);
}

lf_status lf_stream_status(const lf_stream *stream, lf_error *err)
{
    if (stream->status != LF_E_BUSY && err)
        *err = stream->error;
    return stream->status;
}

size_t lf_stream_read(lf_stream *stream, char *out, size_t n)
{
    const size_t left = stream->n - stream->at;
    const size_t most = stream->status == LF_E_BUSY ? left : 0;
    n = n < most ? n : most;
    if (n > 0)
        memcpy(out, stream->part + stream->at, n);
    stream->at += n;
    if (n == 0)
        stream->waiting = stream->status == LF_E_BUSY;
    else if (stream->at == stream->n)
        ask(stream);
    return n;
}
