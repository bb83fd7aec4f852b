/* client: the listening socket and its connections. Reads lines and sends messages; the owner
 * interprets the lines.
 *
 * Clients take turns. In one turn a client has at most 16 lines handled, and 64 KiB of lines and
 * answers together; the last line may exceed this. Its next lines wait until all other ready
 * clients have had a turn, and nothing more is read from it meanwhile. A line longer than
 * LF_RPC_MAX_LINE gets one error and is skipped to its end. At most 1 MiB is queued for a slow
 * client. A new `frame` notification replaces the one still waiting. A client whose queue exceeds
 * the limit is dropped. Descriptors that come with a line are kept until the line was handled; what
 * it does not take is closed. Thread: event. */
#ifndef LF_DAEMON_CLIENT_H
#define LF_DAEMON_CLIENT_H

#include <jansson.h>
#include <systemd/sd-event.h>

#include "daemon/wire/rpc.h"

#define LF_MAX_CLIENTS 64
#define LF_MAX_CLIENT_FDS 253 /* SCM_MAX_FD of Linux */
/* Bytes of the lines of one client's open calls; a single call may exceed it. */
#define LF_MAX_HELD_BYTES ((size_t)4 << 20)
#define LF_MAX_CLIENT_CALLS 4096 /* calls without an answer yet */

typedef struct lf_clients lf_clients;
typedef struct lf_client lf_client;

/* A line arrived: no newline, not terminated. The callback may drop the client, but the client is
 * not freed before it returns. */
typedef void (*lf_line_fn)(void *context, lf_client *client, const char *line, size_t n);

/* The client with this serial number is gone: nothing can be sent to it any more. */
typedef void (*lf_gone_fn)(void *context, uint64_t serial);

/* Takes ownership of listen_fd. */
LF_NODISCARD lf_status lf_clients_create(sd_event *event, int listen_fd, lf_line_fn on_line,
                                         void *context, lf_clients **out);
/* From now on, calls fn with the context of on_line for each client that leaves. */
void lf_clients_on_gone(lf_clients *clients, lf_gone_fn fn);
/* Closes everything, after trying once more to send what is queued. Accepts NULL. */
void lf_clients_destroy(lf_clients *clients);
/* Accepts no new clients. */
void lf_clients_close_listener(lf_clients *clients);
int lf_clients_count(const lf_clients *clients);
/* Number of lines handed to on_line so far. */
uint64_t lf_clients_lines(const lf_clients *clients);

/* The client with this serial number; NULL when it is gone. */
lf_client *lf_clients_find(lf_clients *clients, uint64_t serial);
uint64_t lf_client_serial(const lf_client *client);

/* Sends a message and takes ownership of it. message NULL: it could not be built for lack of
 * memory; the client is dropped. */
void lf_client_send(lf_client *client, json_t *message);
/* Sends text[n], one line of JSON without its newline, shorter than 1 MiB. */
void lf_client_send_text(lf_client *client, const char *text, size_t n);
/* Sends line[n] (no newline) as a frame notification: replaces one that is still waiting. */
void lf_client_send_frame(lf_client *client, const char *line, size_t n);

/* pause: to be called from within lf_line_fn. No further line of the client is handed over until
 * resume, which is called from outside lf_line_fn. Until then the line counts as being handled. */
void lf_client_pause(lf_client *client);
void lf_client_resume(lf_client *client);

/* Counts a call that will be answered later; a half-closed connection stays open for it.
 * *out_bytes: the length of the line being handled, to be passed to lf_clients_release. False: too
 * many calls, or their lines are too large together; the limits also count calls of other clients
 * and of clients that have left. Release each call exactly once, whether or not its client is still
 * there. */
bool lf_client_hold(lf_client *client, size_t *out_bytes);
void lf_clients_release(lf_clients *clients, uint64_t serial, size_t bytes);
/* True if clients that have left hold more than one client is always allowed. */
bool lf_clients_left_much(const lf_clients *clients);

/* Moves the first n descriptors that came with the line being handled to out_fds, which the caller
 * then owns. If none came with it, takes those that came with bytes behind it. False: there are
 * fewer, and nothing was taken. */
bool lf_client_take_fds(lf_client *client, int *out_fds, int n);
/* Number of these descriptors that are not taken yet. */
int lf_client_count_fds(const lf_client *client);

/* Bits for the owner's use (subscriptions). */
unsigned *lf_client_flags(lf_client *client);
/* Likewise (methods that the client may not call); at first 0. */
uint64_t *lf_client_denied(lf_client *client);
/* Calls fn for every client. */
void lf_clients_each(lf_clients *clients, void (*fn)(void *context, lf_client *client),
                     void *context);

#endif
