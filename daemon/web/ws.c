#include "daemon/web/ws.h"

#include <errno.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <time.h>
#include <wslay/wslay.h>

#include "base/alloc.h"

#define MAX_REASON 123 /* bytes of a control frame, without the code */
#define BYTES_A_TURN ((size_t)16384)
/* Above this nothing is read: most messages are answered. */
#define MAX_WAITING ((size_t)256)
/* In STALL_USEC a peer has to take so much, or what waits if it is less. */
#define STALL_USEC ((uint64_t)20000000)
#define STALL_BYTES ((size_t)65536)
#define LINGER_USEC ((uint64_t)2000000)

struct lf_ws {
    int fd;
    wslay_event_context_ptr wslay;
    sd_event_source *io, *timer; /* timer: the peer takes nothing, or does not close */
    lf_ws_events events;
    char *early; /* bytes read by somebody else, of which `taken` are used */
    size_t n_early, taken;
    size_t budget;         /* bytes that may still be read in this turn */
    int frames;            /* of the message that is received */
    bool sent;             /* something was sent in this turn */
    size_t delivered, due; /* since the timer began: bytes sent; bytes to send before it ends */
    bool control; /* the frame that is received is one of control, perhaps between two of a message
                   */
    bool streams; /* the message that is received is binary, and comes in parts */
    bool paused, lingering, ended;
};

static int on_io(sd_event_source *source, int fd, uint32_t what, void *context);
static int on_time(sd_event_source *source, uint64_t usec, void *context);

/* --------------------------------------------------------------------------------- for wslay -- */

static bool is_full(const lf_ws *ws)
{
    return ws->paused || wslay_event_get_queued_msg_count(ws->wslay) > MAX_WAITING;
}

static ssize_t receive(wslay_event_context_ptr wslay, uint8_t *to, size_t n, int flags,
                       void *context)
{
    (void)flags;
    lf_ws *ws = context;
    if (n > ws->budget)
        n = ws->budget;
    ssize_t got = 0;
    if (n == 0 || is_full(ws)) {
        wslay_event_set_error(wslay, WSLAY_ERR_WOULDBLOCK);
        return -1;
    }
    if (ws->taken < ws->n_early) {
        got = (ssize_t)(n < ws->n_early - ws->taken ? n : ws->n_early - ws->taken);
        memcpy(to, ws->early + ws->taken, (size_t)got);
        ws->taken += (size_t)got;
    } else {
        got = recv(ws->fd, to, n, MSG_DONTWAIT);
    }
    if (got <= 0) {
        const bool later = got < 0 && (errno == EAGAIN || errno == EINTR);
        wslay_event_set_error(wslay, later ? WSLAY_ERR_WOULDBLOCK : WSLAY_ERR_CALLBACK_FAILURE);
        return -1;
    }
    ws->budget -= (size_t)got;
    return got;
}

static ssize_t transmit(wslay_event_context_ptr wslay, const uint8_t *data, size_t n, int flags,
                        void *context)
{
    lf_ws *ws = context;
    const int more = flags & WSLAY_MSG_MORE ? MSG_MORE : 0;
    ssize_t done = send(ws->fd, data, n, MSG_DONTWAIT | MSG_NOSIGNAL | more);
    if (done < 0) {
        const bool later = errno == EAGAIN || errno == EINTR;
        wslay_event_set_error(wslay, later ? WSLAY_ERR_WOULDBLOCK : WSLAY_ERR_CALLBACK_FAILURE);
        return -1;
    }
    ws->sent = true;
    ws->delivered += (size_t)done;
    return done;
}

/* wslay allocates memory for each. */
static void on_frame(wslay_event_context_ptr wslay,
                     const struct wslay_event_on_frame_recv_start_arg *frame, void *context)
{
    (void)wslay;
    lf_ws *ws = context;
    ws->control = wslay_is_ctrl_frame(frame->opcode);
    if (ws->control)
        return;
    if (ws->events.part) {
        ws->streams = frame->opcode == WSLAY_CONTINUATION_FRAME
                          ? ws->streams
                          : frame->opcode == WSLAY_BINARY_FRAME;
        if (!ws->streams)
            lf_ws_close(ws, LF_WS_UNSUPPORTED, "expects binary messages");
        return;
    }
    ws->frames = frame->opcode == WSLAY_CONTINUATION_FRAME ? ws->frames + 1 : 1;
    if (ws->frames > LF_WS_MAX_FRAMES)
        lf_ws_close(ws, LF_WS_POLICY, "a message has too many frames");
}

/* Of a frame that is not kept by wslay: those of control are. */
static void on_chunk(wslay_event_context_ptr wslay,
                     const struct wslay_event_on_frame_recv_chunk_arg *chunk, void *context)
{
    (void)wslay;
    lf_ws *ws = context;
    if (ws->streams && !ws->control && chunk->data_length > 0)
        ws->events.part(ws->events.context, chunk->data, chunk->data_length);
}

static void on_message(wslay_event_context_ptr wslay,
                       const struct wslay_event_on_msg_recv_arg *message, void *context)
{
    (void)wslay;
    lf_ws *ws = context;
    if (ws->events.part) {
        if (message->opcode == WSLAY_BINARY_FRAME)
            ws->events.part(ws->events.context, NULL, 0);
        return;
    }
    if (message->opcode == WSLAY_TEXT_FRAME)
        ws->events.text(ws->events.context, message->msg ? (const char *)message->msg : "",
                        message->msg_length);
    else if (message->opcode == WSLAY_BINARY_FRAME)
        lf_ws_close(ws, LF_WS_UNSUPPORTED, "expects text messages");
}

/* ---------------------------------------------------------------------------------- its life -- */

static lf_status set_up(lf_ws *ws, sd_event *event, const void *early, size_t n)
{
    static const struct wslay_event_callbacks callbacks = {.recv_callback = receive,
                                                           .send_callback = transmit,
                                                           .on_frame_recv_start_callback = on_frame,
                                                           .on_frame_recv_chunk_callback = on_chunk,
                                                           .on_msg_recv_callback = on_message};
    ws->early = lf_calloc(n, 1);
    if (!ws->early || wslay_event_context_server_init(&ws->wslay, &callbacks, ws) != 0)
        return LF_E_NOMEM;
    if (n > 0)
        memcpy(ws->early, early, n);
    wslay_event_config_set_no_buffering(ws->wslay, ws->events.part ? 1 : 0);
    wslay_event_config_set_max_recv_msg_length(ws->wslay, ws->events.part ? ws->events.longest
                                                                          : LF_WS_MAX_MESSAGE);
    /* EPOLLOUT: the first turn comes at once, for what came early */
    if (sd_event_add_io(event, &ws->io, ws->fd, EPOLLIN | EPOLLOUT, on_io, ws) < 0 ||
        sd_event_add_time_relative(event, &ws->timer, CLOCK_MONOTONIC, STALL_USEC, 0, on_time, ws) <
            0)
        return LF_E_NOMEM;
    sd_event_source_set_enabled(ws->timer, SD_EVENT_OFF);
    return LF_OK;
}

lf_status lf_ws_create(sd_event *event, int fd, const void *early, size_t n,
                       const lf_ws_events *events, lf_ws **out, lf_error *err)
{
    lf_ws *ws = lf_calloc(1, sizeof *ws);
    if (ws)
        *ws = (lf_ws){.fd = fd, .events = *events, .n_early = n};
    if (!ws || set_up(ws, event, early, n) != LF_OK) {
        lf_ws_destroy(ws);
        return lf_error_set(err, LF_E_NOMEM, "WebSocket", "out of memory");
    }
    *out = ws;
    return LF_OK;
}

void lf_ws_destroy(lf_ws *ws)
{
    if (!ws)
        return;
    sd_event_source_disable_unref(ws->io);
    sd_event_source_disable_unref(ws->timer);
    if (ws->wslay)
        wslay_event_context_free(ws->wslay);
    lf_free(ws->early);
    lf_free(ws);
}

static void end(lf_ws *ws)
{
    if (ws->ended)
        return;
    ws->ended = true;
    ws->io = sd_event_source_disable_unref(ws->io);
    sd_event_source_set_enabled(ws->timer, SD_EVENT_OFF);
    ws->events.ended(ws->events.context);
}

static int on_time(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    end(context);
    return 0;
}

static void wait_at_most(lf_ws *ws, uint64_t usec)
{
    sd_event_source_set_time_relative(ws->timer, usec);
    sd_event_source_set_enabled(ws->timer, SD_EVENT_ONESHOT);
}

static bool is_waiting(const lf_ws *ws)
{
    int enabled = SD_EVENT_OFF;
    return sd_event_source_get_enabled(ws->timer, &enabled) >= 0 && enabled != SD_EVENT_OFF;
}

/* ------------------------------------------------------------------------------------- turns -- */

/* The last word was said. What the peer still sends is read and forgotten: closing a socket with
 * unread data would take our last word from it. */
static void linger(lf_ws *ws)
{
    char forgotten[BYTES_A_TURN];
    if (!ws->lingering) {
        ws->lingering = true;
        shutdown(ws->fd, SHUT_WR);
        wait_at_most(ws, LINGER_USEC);
    }
    ssize_t n = recv(ws->fd, forgotten, sizeof forgotten, MSG_DONTWAIT);
    if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR))
        end(ws);
}

/* Gives the peer STALL_USEC for its next part of the queue. A message has a head of 2 bytes or
 * more. */
static void expect_progress(lf_ws *ws)
{
    const size_t waiting =
        lf_ws_queued(ws) + 2 * (size_t)wslay_event_get_queued_msg_count(ws->wslay);
    ws->due = waiting < STALL_BYTES ? waiting : STALL_BYTES;
    ws->delivered = 0;
    wait_at_most(ws, STALL_USEC);
}

static void look_for_more(lf_ws *ws)
{
    const bool in = !ws->lingering && wslay_event_want_read(ws->wslay) && !is_full(ws);
    const bool out = !ws->lingering && wslay_event_want_write(ws->wslay);
    const bool early = in && ws->taken < ws->n_early;
    if (!ws->ended)
        sd_event_source_set_io_events(ws->io, (in || ws->lingering ? EPOLLIN : 0u) |
                                                  (out || early ? EPOLLOUT : 0u));
    if (ws->ended || ws->lingering)
        return;
    if (!out)
        sd_event_source_set_enabled(ws->timer, SD_EVENT_OFF);
    else if (ws->delivered >= ws->due || !is_waiting(ws))
        expect_progress(ws);
}

static int on_io(sd_event_source *source, int fd, uint32_t what, void *context)
{
    (void)source;
    (void)fd;
    lf_ws *ws = context;
    ws->budget = BYTES_A_TURN;
    ws->sent = false;
    /* while paused nothing is read that would tell */
    bool broken = ws->paused && (what & (EPOLLHUP | EPOLLERR));
    if (!ws->lingering && !broken)
        broken = wslay_event_recv(ws->wslay) != 0 || wslay_event_send(ws->wslay) != 0;
    if (broken)
        end(ws);
    else if (!wslay_event_want_read(ws->wslay) && !wslay_event_want_write(ws->wslay))
        linger(ws);
    if (ws->sent && !ws->ended)
        ws->events.flushed(ws->events.context);
    look_for_more(ws);
    return 0;
}

/* ---------------------------------------------------------------------------------- messages -- */

static void queue(lf_ws *ws, uint8_t opcode, const uint8_t *data, size_t n)
{
    const struct wslay_event_msg message = {.opcode = opcode, .msg = data, .msg_length = n};
    if (!ws->ended && wslay_event_queue_msg(ws->wslay, &message) == 0)
        look_for_more(ws);
}

void lf_ws_send_text(lf_ws *ws, const char *text, size_t n)
{
    queue(ws, WSLAY_TEXT_FRAME, (const uint8_t *)text, n);
}

void lf_ws_send_binary(lf_ws *ws, const uint8_t *data, size_t n)
{
    queue(ws, WSLAY_BINARY_FRAME, data, n);
}

void lf_ws_close(lf_ws *ws, int code, const char *reason)
{
    if (ws->ended)
        return;
    wslay_event_queue_close(ws->wslay, (uint16_t)code, (const uint8_t *)reason,
                            strnlen(reason, MAX_REASON));
    wslay_event_shutdown_read(ws->wslay);
    look_for_more(ws);
}

void lf_ws_pause(lf_ws *ws, bool paused)
{
    ws->paused = paused;
    if (!ws->ended)
        look_for_more(ws);
}

size_t lf_ws_queued(const lf_ws *ws)
{
    return wslay_event_get_queued_msg_length(ws->wslay);
}
