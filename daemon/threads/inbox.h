/* inbox: how other threads hand something to the event thread. A task is the first member of
 * whatever is handed over; the event thread calls their `done` in the order in which they were
 * posted. Posting never fails and never blocks. */
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
    int event_fd;           /* readable when there are tasks; owned */
} lf_inbox;

LF_NODISCARD lf_status lf_inbox_init(lf_inbox *inbox);
/* Tasks that were not read are done now, with reader. */
void lf_inbox_finish(lf_inbox *inbox, void *reader);
/* Thread: any. */
void lf_inbox_post(lf_inbox *inbox, lf_task *task);
/* Calls `done` of what is there. Thread: event. */
void lf_inbox_read(lf_inbox *inbox, void *reader);
/* Of at most so many (1 or more); event_fd stays readable while there are others, so that whoever
 * waits beside them has its turn between. Thread: event. */
void lf_inbox_read_some(lf_inbox *inbox, void *reader, int most);

#endif
