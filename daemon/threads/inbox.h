/* inbox: hands tasks from other threads to the event thread. A task is the first member of the
 * struct that is handed over. The event thread calls `done` of the tasks in the order in which they
 * were posted. Posting never fails and never blocks. */
#ifndef LF_DAEMON_INBOX_H
#define LF_DAEMON_INBOX_H

#include <pthread.h>

#include "base/status.h"

typedef struct lf_task {
    struct lf_task *next;
    void (*done)(void *reader, struct lf_task *task); /* on the event thread; owns the task */
} lf_task;

typedef struct lf_inbox {
    pthread_mutex_t lock;
    lf_task *first, **last; /* under lock */
    int event_fd;           /* readable while there are tasks; owned */
} lf_inbox;

LF_NODISCARD lf_status lf_inbox_init(lf_inbox *inbox);
/* Calls `done`, with reader, for tasks that were not read. */
void lf_inbox_finish(lf_inbox *inbox, void *reader);
/* Thread: any. */
void lf_inbox_post(lf_inbox *inbox, lf_task *task);
/* Calls `done` of all waiting tasks. Thread: event. */
void lf_inbox_read(lf_inbox *inbox, void *reader);
/* Like lf_inbox_read, for at most `most` (>= 1) tasks. event_fd stays readable while tasks remain,
 * so other event sources are served in between. Thread: event. */
void lf_inbox_read_some(lf_inbox *inbox, void *reader, int most);

#endif
