/* ws: one WebSocket after its handshake (RFC 6455, by wslay), in the event loop.
 *
 * A text message has at most LF_WS_MAX_MESSAGE bytes; a longer one closes with 1009, a binary one
 * with 1003, and one of more than LF_WS_MAX_FRAMES frames with 1008. Instead of texts, binary
 * messages may be taken in parts as they come, of any number of frames. At most 16 KiB are read in
 * a turn, and nothing while more than 256 messages wait to be sent, or while paused. Of what waits
 * the peer has to take 64 KiB, or all if it is less, in 20 s; otherwise it is dropped. Thread:
 * event. */
#ifndef LF_DAEMON_WEB_WS_H
#define LF_DAEMON_WEB_WS_H

#include <stdint.h>
#include <systemd/sd-event.h>

#include "base/status.h"

#define LF_WS_MAX_MESSAGE ((size_t)1 << 20)
#define LF_WS_MAX_FRAMES 1024

#define LF_WS_READ_AHEAD 4096

/* Codes of a close. */
enum {
    LF_WS_GOING_AWAY = 1001,
    LF_WS_UNSUPPORTED = 1003,
    LF_WS_POLICY = 1008,
    LF_WS_INTERNAL = 1011,
};

typedef struct lf_ws lf_ws;

/* Called from the event loop alone. They may not destroy the WebSocket. */
typedef struct lf_ws_events {
    void (*text)(void *context, const char *text, size_t n);
    /* Not NULL: binary messages come, and a text one closes with 1003. The next data[n] of a
     * message; n 0: it has ended. While paused, bytes that were read before still come, at most
     * LF_WS_READ_AHEAD. */
    void (*part)(void *context, const uint8_t *data, size_t n);
    uint64_t longest;               /* of the messages of `part`; a longer one closes with 1009 */
    void (*flushed)(void *context); /* some of the queue was sent */
    void (*ended)(void *context);   /* the descriptor is not used any more; called once */
    void *context;
} lf_ws_events;

/* fd: a connected socket, which stays the caller's and must be open until `ended` or destroy.
 * early[n]: bytes that came right after the handshake. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_ws_create(sd_event *event, int fd, const void *early, size_t n,
                                    const lf_ws_events *events, lf_ws **out, lf_error *err);
/* Accepts NULL. */
void lf_ws_destroy(lf_ws *ws);

/* Queue a message, which is copied. After a close they do nothing. */
void lf_ws_send_text(lf_ws *ws, const char *text, size_t n);
void lf_ws_send_binary(lf_ws *ws, const uint8_t *data, size_t n);
/* Sends a close with a code and the first 123 bytes of a reason. The end follows when the peer
 * closes, or after 2 s. */
void lf_ws_close(lf_ws *ws, int code, const char *reason);
/* Stops or continues reading; the peer then keeps what it sends. */
void lf_ws_pause(lf_ws *ws, bool paused);
/* Bytes of messages that wait to be sent. */
size_t lf_ws_queued(const lf_ws *ws);

#endif
