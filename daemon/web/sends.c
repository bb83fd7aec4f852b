/* Answers that take long: downloads and streams of images. What a client does not take waits for
 * it, a block at a time. */
#include "daemon/web/web_internal.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "daemon/web/reply.h"

#define BLOCK_BYTES LF_PATIENCE_BYTES
#define SLOW_USEC ((uint64_t)LF_WEB_SLOW_S * 1000000)

/* --------------------------------------------------------------------------------- downloads -- */

typedef struct sending {
    struct MHD_Connection *connection;
    lf_download_read read;
} sending;

static ssize_t read_download(void *context, uint64_t at, char *out, size_t n)
{
    const sending *s = context;
    ssize_t got = pread(s->read.fd, out, n, (off_t)at);
    lf_patience_note(lf_request_patience(s->connection), got > 0 ? (size_t)got : 0);
    return got > 0 ? got : MHD_CONTENT_READER_END_WITH_ERROR;
}

static void end_download(void *context)
{
    sending *s = context;
    lf_download_close(&s->read);
    lf_free(s);
}

enum MHD_Result lf_send_download(lf_request *r)
{
    char disposition[LF_DOWNLOADS_MAX_NAME + 32];
    sending *s = lf_calloc(1, sizeof *s);
    if (!s)
        return MHD_NO;
    s->connection = r->connection;
    if (!lf_download_open(r->web->downloads, r->path + strlen(LF_DOWNLOADS_PREFIX), &s->read)) {
        lf_free(s);
        return lf_request_refuse(r, 404, "no such download; it is kept for ten minutes");
    }
    snprintf(disposition, sizeof disposition, "attachment; filename=\"%s\"", s->read.name);
    struct MHD_Response *response = MHD_create_response_from_callback(
        s->read.bytes, BLOCK_BYTES, read_download, s, end_download);
    if (!response) {
        end_download(s);
        return MHD_NO;
    }
    MHD_add_response_header(response, "Content-Disposition", disposition);
    MHD_set_connection_option(r->connection, MHD_CONNECTION_OPTION_TIMEOUT, LF_WEB_SLOW_S);
    lf_patience_pace(lf_request_patience(r->connection), SLOW_USEC);
    return lf_reply_send(r->connection, 200, response, "application/octet-stream");
}

/* ----------------------------------------------------------------------------------- streams -- */

static void on_stream(void *context)
{
    lf_request_resume(context);
}

enum MHD_Result lf_send_stream(lf_request *r)
{
    lf_web *web = r->web;
    if (web->n_streams >= LF_WEB_MAX_STREAMS)
        return lf_request_refuse(r, 503, "too many streams");
    r->status = lf_stream_create(web->event, web->socket, on_stream, r, &r->stream, &r->error);
    if (r->status != LF_OK)
        return lf_request_refuse(r, 503, r->error.what);
    web->n_streams++;
    MHD_suspend_connection(r->connection);
    return MHD_YES;
}

static ssize_t read_stream(void *context, uint64_t at, char *out, size_t n)
{
    (void)at;
    lf_request *r = context;
    lf_patience *patience = lf_request_patience(r->connection);
    const size_t got = lf_stream_read(r->stream, out, n);
    if (got > 0)
        lf_patience_wait(patience, SLOW_USEC);
    else if (lf_stream_status(r->stream, NULL) != LF_E_BUSY)
        return MHD_CONTENT_READER_END_OF_STREAM;
    else if (lf_patience_is_over(patience))
        return MHD_CONTENT_READER_END_WITH_ERROR;
    else
        MHD_suspend_connection(r->connection); /* until the stream is ready */
    return (ssize_t)got;
}

/* The first image is there, or there is none. */
enum MHD_Result lf_send_stream_begun(lf_request *r)
{
    r->status = lf_stream_status(r->stream, &r->error);
    if (r->status != LF_E_BUSY)
        return lf_request_refuse(r, 503, r->error.what);
    MHD_set_connection_option(r->connection, MHD_CONNECTION_OPTION_TIMEOUT, LF_WEB_SLOW_S);
    lf_patience_wait(lf_request_patience(r->connection), SLOW_USEC);
    return lf_reply_send(
        r->connection, 200,
        MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, BLOCK_BYTES, read_stream, r, NULL),
        "multipart/x-mixed-replace; boundary=" LF_STREAM_BOUNDARY);
}
