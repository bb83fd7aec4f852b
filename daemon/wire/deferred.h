/* deferred: a call that is answered later, possibly after its client has left. Thread: event. */
#ifndef LF_DAEMON_DEFERRED_H
#define LF_DAEMON_DEFERRED_H

#include "daemon/wire/client.h"

typedef struct lf_deferred lf_deferred;

/* Defers the call with this id, which the client has just made. id NULL: a notification, which gets
 * no answer. clients must outlive the deferred call. NULL: the client has too many open calls, or
 * out of memory. */
lf_deferred *lf_deferred_create(lf_clients *clients, lf_client *client, const json_t *id);
/* The serial number of the client that made the call. */
uint64_t lf_deferred_client(const lf_deferred *deferred);
/* True if that client has left. */
bool lf_deferred_is_vain(const lf_deferred *deferred);
/* Length of the line that held the call, in bytes. */
size_t lf_deferred_bytes(const lf_deferred *deferred);
/* Sends the answer and frees the call; accepts NULL. Takes ownership of result (NULL = out of
 * memory). */
void lf_deferred_reply(lf_deferred *deferred, json_t *result);
void lf_deferred_fail(lf_deferred *deferred, const lf_error *err, bool scene);
/* The same with this message (lf_rpc_error_saying). */
void lf_deferred_fail_saying(lf_deferred *deferred, const lf_error *err, bool scene,
                             const char *message);

#endif
