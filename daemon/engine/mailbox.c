#include "daemon/engine/mailbox.h"

#include <pthread.h>
#include <string.h>

#include "base/alloc.h"
#include "base/wakeup.h"
#include "quilt/quilt.h"

struct lf_mailbox {
    pthread_mutex_t lock;
    int event_fd; /* readable after a post */
    /* under lock */
    int ready, held, shown; /* slots; -1 = none */
    uint64_t n_posted;
    int64_t counted; /* generation */
    lf_mailbox_counts counts;
    bool views_taken; /* the consumer is reading the views buffer */
    /* producer only */
    int back, last; /* slots; -1 = none */
    /* ready, held and shown name slots; the producer owns the others */
    lf_frame slot[4];
    /* owned by the producer while !views_taken */
    lf_views8 views;
    uint8_t *views_data;
    size_t views_size;
};

const char *lf_level_name(lf_level level)
{
    static const char *const names[] = {"none", "coarse", "complete", "converged"};
    return names[level];
}

lf_status lf_mailbox_create(int event_fd, lf_mailbox **out_mailbox)
{
    lf_mailbox *mailbox = lf_calloc(1, sizeof *mailbox);
    if (!mailbox)
        return LF_E_NOMEM;
    *mailbox = (lf_mailbox){
        .event_fd = event_fd, .ready = -1, .held = -1, .shown = -1, .back = -1, .last = -1};
    if (pthread_mutex_init(&mailbox->lock, NULL) != 0) {
        lf_free(mailbox);
        return LF_E_NOMEM;
    }
    *out_mailbox = mailbox;
    return LF_OK;
}

void lf_mailbox_destroy(lf_mailbox *mailbox)
{
    if (!mailbox)
        return;
    for (int i = 0; i < 4; i++)
        lf_image8_finish(&mailbox->slot[i].image);
    lf_free(mailbox->views_data);
    pthread_mutex_destroy(&mailbox->lock);
    lf_free(mailbox);
}

static int free_slot(lf_mailbox *mailbox)
{
    int slot = 0;
    pthread_mutex_lock(&mailbox->lock);
    while (slot == mailbox->ready || slot == mailbox->held || slot == mailbox->shown)
        slot++;
    pthread_mutex_unlock(&mailbox->lock);
    return slot;
}

lf_frame *lf_mailbox_begin(lf_mailbox *mailbox, int width, int height)
{
    mailbox->back = free_slot(mailbox);
    lf_frame *frame = &mailbox->slot[mailbox->back];
    if (frame->image.width != width || frame->image.height != height) {
        lf_image8_finish(&frame->image);
        if (width > 0 && lf_image8_init(&frame->image, width, height, 3) != LF_OK)
            return NULL;
    }
    frame->n_rects = 0;
    frame->against = 0;
    frame->has_views = frame->sent_views = frame->lacks_views = false;
    frame->fades = frame->moves = frame->counts = false;
    frame->card[0] = '\0';
    return frame;
}

void lf_mailbox_compare(lf_mailbox *mailbox, lf_frame *frame)
{
    pthread_mutex_lock(&mailbox->lock);
    const lf_frame *shown = mailbox->shown >= 0 ? &mailbox->slot[mailbox->shown] : NULL;
    pthread_mutex_unlock(&mailbox->lock);
    /* Only this thread writes slots, so the frame stays readable even if it is replaced on the
     * panel meanwhile. */
    if (!shown || !frame->image.data || shown->panel != frame->panel ||
        shown->image.width != frame->image.width || shown->image.height != frame->image.height)
        return;
    frame->n_rects =
        lf_changed_rects(&shown->image, &frame->image, frame->rects, LF_FRAME_MAX_RECTS);
    frame->against = shown->number;
}

static bool room_for_views(lf_mailbox *mailbox, size_t size)
{
    if (mailbox->views_size < size) {
        lf_free(mailbox->views_data);
        mailbox->views_data = lf_calloc(size, 1);
        mailbox->views_size = mailbox->views_data ? size : 0;
    }
    return mailbox->views_size >= size;
}

bool lf_mailbox_attach(lf_mailbox *mailbox, lf_frame *frame, const lf_views8 *views)
{
    pthread_mutex_lock(&mailbox->lock);
    bool taken = mailbox->views_taken;
    for (int i = 0; i < 4 && !taken; i++)
        mailbox->slot[i].has_views = false;
    pthread_mutex_unlock(&mailbox->lock);
    size_t row = (size_t)views->width * 3;
    size_t n_views = (size_t)views->n_views;
    if (taken || !room_for_views(mailbox, row * n_views * (size_t)views->height))
        return !taken;
    for (int y = 0; y < views->height; y++) {
        for (int v = 0; v < views->n_views; v++) {
            memcpy(mailbox->views_data + ((size_t)y * n_views + (size_t)v) * row,
                   lf_views8_row(views, v, y), row);
        }
    }
    mailbox->views = *views;
    mailbox->views.view_stride = row;
    mailbox->views.row_stride = row * n_views;
    mailbox->views.data = mailbox->views_data;
    frame->has_views = frame->sent_views = true;
    return true;
}

const lf_frame *lf_mailbox_waiting(lf_mailbox *mailbox)
{
    pthread_mutex_lock(&mailbox->lock);
    const lf_frame *frame = mailbox->ready >= 0 ? &mailbox->slot[mailbox->ready] : NULL;
    pthread_mutex_unlock(&mailbox->lock);
    return frame;
}

/* Slots are free only after another one took their place, so the last one is never free. */
const lf_frame *lf_mailbox_last(lf_mailbox *mailbox)
{
    return mailbox->last >= 0 ? &mailbox->slot[mailbox->last] : NULL;
}

/* A frame that shows the same picture again takes the place of the one it replaces. */
static void note_replaced(lf_mailbox *mailbox, lf_frame *frame)
{
    const lf_frame *before = mailbox->ready >= 0 ? &mailbox->slot[mailbox->ready] : NULL;
    if (!before || !before->counts || before->generation != mailbox->counted)
        return;
    if (frame->counts || frame->generation != before->generation)
        mailbox->counts.replaced++;
    else
        frame->counts = true;
}

void lf_mailbox_count(lf_mailbox *mailbox, int64_t generation)
{
    pthread_mutex_lock(&mailbox->lock);
    mailbox->counted = generation;
    mailbox->counts = (lf_mailbox_counts){0};
    pthread_mutex_unlock(&mailbox->lock);
}

lf_mailbox_counts lf_mailbox_counted(lf_mailbox *mailbox)
{
    pthread_mutex_lock(&mailbox->lock);
    const lf_mailbox_counts counts = mailbox->counts;
    pthread_mutex_unlock(&mailbox->lock);
    return counts;
}

void lf_mailbox_post(lf_mailbox *mailbox, lf_frame *frame)
{
    pthread_mutex_lock(&mailbox->lock);
    frame->number = ++mailbox->n_posted;
    note_replaced(mailbox, frame);
    mailbox->ready = mailbox->back;
    mailbox->last = mailbox->back;
    mailbox->back = -1;
    pthread_mutex_unlock(&mailbox->lock);
    lf_wakeup_signal(mailbox->event_fd);
}

const lf_frame *lf_mailbox_take(lf_mailbox *mailbox)
{
    pthread_mutex_lock(&mailbox->lock);
    const lf_frame *frame = NULL;
    if (mailbox->ready >= 0) {
        mailbox->held = mailbox->ready;
        mailbox->ready = -1;
        frame = &mailbox->slot[mailbox->held];
        if (frame->counts && frame->generation == mailbox->counted)
            mailbox->counts.taken++;
    }
    pthread_mutex_unlock(&mailbox->lock);
    return frame;
}

void lf_mailbox_shown(lf_mailbox *mailbox)
{
    pthread_mutex_lock(&mailbox->lock);
    if (mailbox->held >= 0) {
        mailbox->shown = mailbox->held;
        mailbox->held = -1;
    }
    pthread_mutex_unlock(&mailbox->lock);
}

const lf_frame *lf_mailbox_current(lf_mailbox *mailbox)
{
    pthread_mutex_lock(&mailbox->lock);
    const lf_frame *frame = mailbox->shown >= 0 ? &mailbox->slot[mailbox->shown] : NULL;
    pthread_mutex_unlock(&mailbox->lock);
    return frame;
}

const lf_views8 *lf_mailbox_views(lf_mailbox *mailbox, const lf_frame *frame)
{
    pthread_mutex_lock(&mailbox->lock);
    bool has = frame->has_views;
    mailbox->views_taken = has;
    pthread_mutex_unlock(&mailbox->lock);
    return has ? &mailbox->views : NULL;
}

void lf_mailbox_views_done(lf_mailbox *mailbox)
{
    pthread_mutex_lock(&mailbox->lock);
    mailbox->views_taken = false;
    pthread_mutex_unlock(&mailbox->lock);
}
