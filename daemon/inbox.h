/* inbox: how other threads hand something to the event thread. A letter is the first member of whatever is handed over; the
 * event thread opens letters in the order in which they were posted. Posting never fails and never blocks. */
#ifndef LF_DAEMON_INBOX_H
#define LF_DAEMON_INBOX_H

#include <pthread.h>

#include "base/status.h"

typedef struct lf_letter {
    struct lf_letter *next;
    void (*open)(void *reader, struct lf_letter *letter); /* on the event thread; owns the letter */
} lf_letter;

typedef struct lf_inbox {
    pthread_mutex_t lock;
    lf_letter *first, **last; /* under lock */
    int event_fd;             /* readable when there are letters; owned */
} lf_inbox;

LF_NODISCARD lf_status lf_inbox_init(lf_inbox *inbox);
/* Letters not opened are opened now, with reader. */
void lf_inbox_finish(lf_inbox *inbox, void *reader);
/* Thread: any. */
void lf_inbox_post(lf_inbox *inbox, lf_letter *letter);
/* Opens what is there. Thread: event. */
void lf_inbox_read(lf_inbox *inbox, void *reader);

#endif
