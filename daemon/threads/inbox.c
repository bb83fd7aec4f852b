#include "daemon/threads/inbox.h"

#include <limits.h>
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
    /* Under the lock: the reader of the task may close the descriptor next. */
    lf_wakeup_signal(inbox->event_fd);
    pthread_mutex_unlock(&inbox->lock);
}

/* Takes the first tasks, at most `most`, out of the inbox. */
static lf_task *take_first(lf_inbox *inbox, int most)
{
    lf_task *first = inbox->first, *last = first;
    for (int n = 1; n < most && last && last->next; n++)
        last = last->next;
    if (!last)
        return NULL;
    inbox->first = last->next;
    if (!inbox->first)
        inbox->last = &inbox->first;
    last->next = NULL;
    return first;
}

void lf_inbox_read_some(lf_inbox *inbox, void *reader, int most)
{
    lf_wakeup_clear(inbox->event_fd);
    pthread_mutex_lock(&inbox->lock);
    lf_task *task = take_first(inbox, most);
    if (inbox->first)
        lf_wakeup_signal(inbox->event_fd);
    pthread_mutex_unlock(&inbox->lock);
    while (task) {
        lf_task *next = task->next;
        task->done(reader, task);
        task = next;
    }
}

void lf_inbox_read(lf_inbox *inbox, void *reader)
{
    lf_inbox_read_some(inbox, reader, INT_MAX);
}
