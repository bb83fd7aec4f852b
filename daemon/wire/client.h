/* client: the listening socket and the connections to it. Lines in, messages out; what a line means
 * is not known here.
 *
 * A client has its turn: so many lines, of so many bytes with what they are answered (16 and 64
 * KiB; the last of them may be longer). The next ones wait until all others that are ready have had
 * theirs; nothing more is read meanwhile.
 * A line over LF_RPC_MAX_LINE gets one error and is skipped to its end. At most 1 MiB waits for a
 * slow client: a `frame` notification replaces the one still waiting, and a client that lets the
 * rest pile up is dropped. Descriptors that come with a line wait for the request that takes them.
 * Thread: event. */
#ifndef LF_DAEMON_CLIENT_H
#define LF_DAEMON_CLIENT_H

#include <jansson.h>
#include <systemd/sd-event.h>

#include "daemon/wire/rpc.h"

#define LF_MAX_CLIENTS 64
#define LF_MAX_CLIENT_FDS 253               /* SCM_MAX_FD of Linux */
#define LF_MAX_HELD_BYTES ((size_t)4 << 20) /* of the lines of such calls, but for one */
#define LF_MAX_CLIENT_CALLS 4096            /* calls without an answer yet */

typedef struct lf_clients lf_clients;
typedef struct lf_client lf_client;

/* A line came in (no newline, not terminated). The client may be dropped by what is done, but not
 * freed before it returns. */
typedef void (*lf_line_fn)(void *context, lf_client *client, const char *line, size_t n);

/* The client of this serial number is gone: nothing can be sent to it any more. */
typedef void (*lf_gone_fn)(void *context, uint64_t serial);

/* Takes listen_fd over. */
LF_NODISCARD lf_status lf_clients_create(sd_event *event, int listen_fd, lf_line_fn on_line,
                                         void *context, lf_clients **out);
/* Calls fn, with the context of on_line, for each client that goes from now on. */
void lf_clients_on_gone(lf_clients *clients, lf_gone_fn fn);
/* Closes everything, after trying once more to send what is queued. Accepts NULL. */
void lf_clients_destroy(lf_clients *clients);
/* Accepts nobody new. */
void lf_clients_close_listener(lf_clients *clients);
int lf_clients_count(const lf_clients *clients);
/* Lines that were handed over so far. */
uint64_t lf_clients_lines(const lf_clients *clients);

/* The client that has this serial number, or NULL when it is gone. */
lf_client *lf_clients_find(lf_clients *clients, uint64_t serial);
uint64_t lf_client_serial(const lf_client *client);

/* Sends a message (taken over; NULL: out of memory when it was made, the client is dropped). */
void lf_client_send(lf_client *client, json_t *message);
/* The same of text[n], one line of JSON without its newline, shorter than 1 MiB. */
void lf_client_send_text(lf_client *client, const char *text, size_t n);
/* Sends line[n] (no newline) as a frame notification: replaces one that is still waiting. */
void lf_client_send_frame(lf_client *client, const char *line, size_t n);

/* From within lf_line_fn: no other line of the client is handed over until it is resumed, from
 * outside of it. The line is then still the one being handled. */
void lf_client_pause(lf_client *client);
void lf_client_resume(lf_client *client);

/* Calls that will be answered later: a half-closed connection stays for them. *out_bytes: the
 * line's that is being handled, to be given back. False: too many, or too large together, also with
 * those of other clients and of clients that have left. Each is released once, whether its client
 * is still there or not. */
bool lf_client_hold(lf_client *client, size_t *out_bytes);
void lf_clients_release(lf_clients *clients, uint64_t serial, size_t bytes);
/* Whether clients that have left hold more than one client may always have. */
bool lf_clients_left_much(const lf_clients *clients);

/* Takes the next n descriptors the client has passed; false (nothing taken) when there are fewer.
 */
bool lf_client_take_fds(lf_client *client, int *out_fds, int n);
/* How many it has passed that nobody took. */
int lf_client_count_fds(const lf_client *client);
/* Closes those that nobody took. */
void lf_client_drop_fds(lf_client *client);

/* Bits that the owner uses as it likes (subscriptions). */
unsigned *lf_client_flags(lf_client *client);
/* Calls fn for every client. */
void lf_clients_each(lf_clients *clients, void (*fn)(void *context, lf_client *client),
                     void *context);

#endif
