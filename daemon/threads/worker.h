/* worker: a thread that runs queued tasks one at a time in order, and posts each into an inbox when
 * it is done. It does work that may block, which the event thread must not: loading scenes, opening
 * and closing devices. */
#ifndef LF_DAEMON_WORKER_H
#define LF_DAEMON_WORKER_H

#include "daemon/threads/inbox.h"

typedef struct lf_worker lf_worker;

/* Runs a task, and the tasks that it took with lf_worker_take and appended to its `next`, before
 * they are posted back in order. Thread: the worker's. `drop` is also called by lf_worker_destroy
 * and lf_worker_drop. */
typedef void (*lf_task_fn)(void *context, lf_task *task);

/* run executes a task; drop marks a task that will not be run. name: of the thread, at most 15
 * bytes. context and inbox are borrowed. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_worker_create(const char *name, lf_task_fn run, lf_task_fn drop,
                                        void *context, lf_inbox *inbox, lf_worker **out_worker);
/* Waits for the task in progress; drops and posts the tasks that have not begun. Accepts NULL. */
void lf_worker_destroy(lf_worker *worker);
/* Takes ownership of the task until it is posted back. */
void lf_worker_queue(lf_worker *worker, lf_task *task);
/* The task queued after the one in progress, if there is one and suits() accepts it; otherwise
 * NULL. suits runs under the queue's lock and must be quick. `run` may merge such tasks into its
 * own, and leaves them on its `next`. Thread: the worker's. */
lf_task *lf_worker_take(lf_worker *worker, bool (*suits)(const lf_task *task, const lf_task *next),
                        const lf_task *task);
/* Drops the waiting tasks that suits() accepts, and posts them back. suits runs under the queue's
 * lock and must be quick. Thread: any but the worker's. */
void lf_worker_drop(lf_worker *worker, bool (*suits)(const lf_task *task));
/* Tasks queued or in progress. Thread: any. */
int lf_worker_pending(lf_worker *worker);
/* Waits until no task is queued or in progress, or until `end` (lf_time_now). True: none is
 * left. */
bool lf_worker_drain(lf_worker *worker, double end);

#endif
