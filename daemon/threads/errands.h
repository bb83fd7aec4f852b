/* errands: work for clients on threads of its own, for example reading a folder that may hang. Each
 * errand has its own thread, and only a few run at once; the others wait for their turn. An errand
 * is the first member of its owner's struct. It knows its client only as a number. Thread: event,
 * except `run`.
 *
 * Work that hangs in a file system does not see `cancel`. Until it ends, it keeps its thread and
 * the errand with all that the owner put there, for example a deferred call. Once it is cancelled,
 * it takes no turn from the others. Of at most 4 * at_once threads, these are the rest. */
#ifndef LF_DAEMON_ERRANDS_H
#define LF_DAEMON_ERRANDS_H

#include "base/thread.h"
#include "daemon/threads/inbox.h"

typedef struct lf_errands lf_errands;

typedef struct lf_errand {
    /* set by the owner */
    uint64_t client;
    /* The work, on a thread of its own. It ends soon after `cancel` is nonzero. */
    lf_status (*run)(struct lf_errand *errand, lf_error *err);
    /* Called when `cancel` was set, for work that does not look at it; may be NULL. */
    void (*stop)(struct lf_errand *errand);
    /* The work has ended, or was cancelled before it began (LF_E_CANCELLED). Frees the errand. It
     * may add no errand. */
    void (*done)(void *context, struct lf_errand *errand);
    /* the outcome */
    lf_status status;
    lf_error err; /* valid if status is not LF_OK */
    lf_cancel cancel;
    /* private to errands.c */
    lf_task task;
    struct lf_errand *next;
    lf_errands *errands;
    pthread_t thread;
    bool started, posted;
} lf_errand;

/* name: of the threads, at most 15 bytes, borrowed. context: for `done`. at_once: errands that run
 * at the same time. inbox is borrowed and must outlive the errands. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_errands_create(const char *name, int at_once, void *context,
                                         lf_inbox *inbox, lf_errands **out_errands);
/* To be called when no errand is left. Accepts NULL. */
void lf_errands_destroy(lf_errands *errands);
/* Starts an errand, or lets it wait. On LF_OK it belongs to errands until `done`, which may get
 * LF_E_BUSY or LF_E_NOMEM if its turn comes too late for a thread. On failure `done` is not called,
 * and the errand stays the caller's. LF_E_BUSY: cancelled errands that do not end have all threads;
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_errands_add(lf_errands *errands, lf_errand *errand, lf_error *err);
/* Errands that wait or run; those of one client. */
int lf_errands_count(const lf_errands *errands);
int lf_errands_count_of(const lf_errands *errands, uint64_t client);
/* Cancels the errands of a client that has left, or all; `done` is still called, later. */
void lf_errands_end_of(lf_errands *errands, uint64_t client);
void lf_errands_end(lf_errands *errands);

#endif
