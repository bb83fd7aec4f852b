/* deferred: a call that is answered later, perhaps when its client has gone. Thread: event. */
#ifndef LF_DAEMON_DEFERRED_H
#define LF_DAEMON_DEFERRED_H

#include "daemon/wire/client.h"

typedef struct lf_deferred lf_deferred;

/* Puts off the call of that id (NULL: a notification, nobody waits for an answer), which the client
 * has just made. NULL: it has too many calls open, or memory is out. clients must be there until it
 * is answered. */
lf_deferred *lf_deferred_create(lf_clients *clients, lf_client *client, const json_t *id);
/* The serial number of the client whose call it is. */
uint64_t lf_deferred_client(const lf_deferred *deferred);
/* Whether that has gone. */
bool lf_deferred_is_vain(const lf_deferred *deferred);
/* Bytes of the line that it came in. */
size_t lf_deferred_bytes(const lf_deferred *deferred);
/* Answers now, and frees the call; accepts NULL. result is taken over (NULL = out of memory). */
void lf_deferred_reply(lf_deferred *deferred, json_t *result);
void lf_deferred_fail(lf_deferred *deferred, const lf_error *err, bool scene);

#endif
