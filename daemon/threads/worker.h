/* worker: a thread that does what tasks ask for, one after the other in the order in which they
 * were queued, and posts each back into an inbox when it is done. What the event thread may not
 * wait for is done here: loading scenes, opening and closing devices. */
#ifndef LF_DAEMON_WORKER_H
#define LF_DAEMON_WORKER_H

#include "daemon/threads/inbox.h"

typedef struct lf_worker lf_worker;

/* What is done with a task before it is posted back, and with it those that hang on its `next`, in
 * their order (lf_worker_take). Thread: the worker's; `drop` is called by lf_worker_destroy and
 * lf_worker_drop. */
typedef void (*lf_task_fn)(void *context, lf_task *task);

/* run does what a task asks for; drop marks one that is not done any more. name: the thread's, at
 * most 15 bytes. context and inbox are borrowed. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_worker_create(const char *name, lf_task_fn run, lf_task_fn drop,
                                        void *context, lf_inbox *inbox, lf_worker **out_worker);
/* Ends after the task in progress; those not begun are dropped and posted. Accepts NULL. */
void lf_worker_destroy(lf_worker *worker);
/* Takes the task over until it is posted back. */
void lf_worker_queue(lf_worker *worker, lf_task *task);
/* The task that was queued behind the one in progress, if it is there and suits (under the queue's
 * lock: quickly); else NULL. Whoever runs a task may take others into it, and leaves them on its
 * `next`. Thread: the worker's. */
lf_task *lf_worker_take(lf_worker *worker, bool (*suits)(const lf_task *task, const lf_task *next),
                        const lf_task *task);
/* Drops tasks that wait and suit (under the queue's lock: quickly), and posts them back. Thread:
 * not the worker's. */
void lf_worker_drop(lf_worker *worker, bool (*suits)(const lf_task *task));
/* Tasks queued or in progress. Thread: any. */
int lf_worker_pending(lf_worker *worker);
/* Waits until none is left, or until `end` (lf_time_now); true when none is left. */
bool lf_worker_drain(lf_worker *worker, double end);

#endif
