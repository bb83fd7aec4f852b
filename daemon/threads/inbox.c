#include "daemon/threads/inbox.h"

#include <unistd.h>

#include "base/wakeup.h"

lf_status lf_inbox_init(lf_inbox *inbox)
{
    *inbox = (lf_inbox){.last = &inbox->first};
    inbox->event_fd = lf_wakeup_make();
    pthread_mutex_init(&inbox->lock, NULL);
    return inbox->event_fd >= 0 ? LF_OK : LF_E_IO;
}

void lf_inbox_finish(lf_inbox *inbox, void *reader)
{
    lf_inbox_read(inbox, reader);
    close(inbox->event_fd);
    pthread_mutex_destroy(&inbox->lock);
}

void lf_inbox_post(lf_inbox *inbox, lf_task *task)
{
    task->next = NULL;
    pthread_mutex_lock(&inbox->lock);
    *inbox->last = task;
    inbox->last = &task->next;
    /* Under the lock: whoever reads the task may close the descriptor next. */
    lf_wakeup_signal(inbox->event_fd);
    pthread_mutex_unlock(&inbox->lock);
}

void lf_inbox_read(lf_inbox *inbox, void *reader)
{
    lf_wakeup_clear(inbox->event_fd);
    pthread_mutex_lock(&inbox->lock);
    lf_task *task = inbox->first;
    inbox->first = NULL;
    inbox->last = &inbox->first;
    pthread_mutex_unlock(&inbox->lock);
    while (task) {
        lf_task *next = task->next;
        task->done(reader, task);
        task = next;
    }
}
