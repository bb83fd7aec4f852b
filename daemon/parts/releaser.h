/* releaser: a thread that frees what takes its time to be freed, and gives the memory of large
 * values back to the system. Thread: event, but for the freeing. */
#ifndef LF_DAEMON_RELEASER_H
#define LF_DAEMON_RELEASER_H

#include <jansson.h>

#include "daemon/output/content.h"
#include "daemon/threads/inbox.h"

typedef struct lf_releaser lf_releaser;

/* inbox, read by the event thread, is borrowed. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_releaser_create(lf_inbox *inbox, lf_releaser **out_releaser);
/* Frees what waits. Accepts NULL. */
void lf_releaser_destroy(lf_releaser *releaser);
/* Frees a thing (NULL: nothing); releaser NULL: at once. */
void lf_release(lf_releaser *releaser, void (*destroy)(void *thing), void *thing);
void lf_release_content(lf_releaser *releaser, lf_content *content);
/* A value that may be large. */
void lf_release_json(lf_releaser *releaser, json_t *value);

#endif
