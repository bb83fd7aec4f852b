/* stream: the middle view as a sequence of JPEGs (multipart/x-mixed-replace) for one client.
 *
 * It has a connection to quiltd of its own, and asks for an image when another one is shown, at
 * most four times a second, and never before the client has taken the last one whole. Without
 * another image it repeats the last one after LF_STREAM_REPEAT_S, so that a client that has left is
 * noticed. It holds one image of at most LF_WEB_IMAGE_MAX_BYTES. Thread: event. */
#ifndef LF_DAEMON_WEB_STREAM_H
#define LF_DAEMON_WEB_STREAM_H

#include <systemd/sd-event.h>

#include "base/status.h"

#define LF_STREAM_BOUNDARY "quiltweb-image"
#define LF_STREAM_REPEAT_S 5

typedef struct lf_stream lf_stream;

/* There is something to read, or the stream has ended. Called from the event loop, once after each
 * lf_stream_read that had nothing, and once after lf_stream_create. It may not destroy the stream.
 */
typedef void (*lf_stream_ready_fn)(void *context);

/* Begins. If there is no first image in 8 s, the stream ends. LF_E_NODEV: nobody listens at the
 * path `socket`; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_stream_create(sd_event *event, const char *socket,
                                        lf_stream_ready_fn ready, void *context, lf_stream **out,
                                        lf_error *err);
/* Accepts NULL. */
void lf_stream_destroy(lf_stream *stream);
/* Ends the stream, and calls `ready` if somebody waits. */
void lf_stream_end(lf_stream *stream);

/* LF_E_BUSY: it goes on; else why it ended. */
LF_NODISCARD lf_status lf_stream_status(const lf_stream *stream, lf_error *err);
/* Copies up to n bytes; 0: none yet, `ready` follows, or the stream has ended. */
size_t lf_stream_read(lf_stream *stream, char *out, size_t n);

#endif
