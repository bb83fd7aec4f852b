#include "daemon/inbox.h"

#include <unistd.h>

#include "base/bell.h"

lf_status lf_inbox_init(lf_inbox *inbox)
{
    *inbox = (lf_inbox){.last = &inbox->first};
    inbox->event_fd = lf_bell_make();
    pthread_mutex_init(&inbox->lock, NULL);
    return inbox->event_fd >= 0 ? LF_OK : LF_E_IO;
}

void lf_inbox_finish(lf_inbox *inbox, void *reader)
{
    lf_inbox_read(inbox, reader);
    close(inbox->event_fd);
    pthread_mutex_destroy(&inbox->lock);
}

void lf_inbox_post(lf_inbox *inbox, lf_letter *letter)
{
    letter->next = NULL;
    pthread_mutex_lock(&inbox->lock);
    *inbox->last = letter;
    inbox->last = &letter->next;
    /* Under the lock: whoever reads the letter may close the descriptor next. */
    lf_bell_ring(inbox->event_fd);
    pthread_mutex_unlock(&inbox->lock);
}

void lf_inbox_read(lf_inbox *inbox, void *reader)
{
    lf_bell_silence(inbox->event_fd);
    pthread_mutex_lock(&inbox->lock);
    lf_letter *letter = inbox->first;
    inbox->first = NULL;
    inbox->last = &inbox->first;
    pthread_mutex_unlock(&inbox->lock);
    while (letter != NULL) {
        lf_letter *next = letter->next;
        letter->open(reader, letter);
        letter = next;
    }
}
