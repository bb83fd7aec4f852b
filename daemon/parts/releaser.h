/* releaser: a thread that frees objects whose destruction takes long, and returns the memory of
 * large values to the system. Thread: event, except the freeing. */
#ifndef LF_DAEMON_RELEASER_H
#define LF_DAEMON_RELEASER_H

#include <jansson.h>

#include "daemon/output/content.h"
#include "daemon/threads/inbox.h"

typedef struct lf_releaser lf_releaser;

/* inbox, read by the event thread, is borrowed. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_releaser_create(lf_inbox *inbox, lf_releaser **out_releaser);
/* Frees all queued objects first. Accepts NULL. */
void lf_releaser_destroy(lf_releaser *releaser);
/* Queues an object to be freed (NULL: nothing). releaser NULL: frees it at once. */
void lf_release(lf_releaser *releaser, void (*destroy)(void *thing), void *thing);
void lf_release_content(lf_releaser *releaser, lf_content *content);
/* For a value that may be large. */
void lf_release_json(lf_releaser *releaser, json_t *value);

#endif
