#include "daemon/show/show_internal.h"

#include <string.h>

#include "base/log.h"
#include "quilt/quilt.h"

/* Delay between a failed push and the next. */
#define REPUSH_USEC 20000

void lf_show_dispatch(lf_show *show)
{
    lf_push *push = &show->push;
    switch (show->device->ops->dispatch(show->device)) {
    case LF_DEVICE_READY:
        if (push->state == LF_PUSH_BUSY) {
            push->state = LF_PUSH_CHANGES;
            lf_show_count_push(show);
            show->events.shown(show->context, &push->frame);
        }
        lf_show_look_at_files(show);
        break;
    case LF_DEVICE_BUSY:
        lf_show_look_at_files(show);
        break;
    case LF_DEVICE_RETRY:
        push->state = LF_PUSH_WHOLE;
        lf_show_retry(show, REPUSH_USEC);
        break;
    case LF_DEVICE_GONE:
        lf_show_gone(show, "unplugged");
        break;
    case LF_DEVICE_LOST:
        show->kept.lost = true;
        lf_show_gone(show, "its folder was removed; creating a new one");
        break;
    }
}

/* False: this frame's views come with a later frame. */
static bool give_views(lf_show *show, const lf_frame *frame)
{
    lf_device *device = show->device;
    lf_mailbox *mailbox = show->home.mailbox;
    if (!device->ops->views)
        return true;
    const lf_views8 *views = lf_mailbox_views(mailbox, frame);
    if (views)
        device->ops->views(device, views, frame->columns, frame->rows);
    lf_mailbox_views_done(mailbox);
    return views || (!frame->sent_views && !frame->lacks_views);
}

/* The rectangles of frame that differ from the panel's contents. */
static int rects_for(lf_show *show, const lf_frame *frame, lf_rect *rects)
{
    const lf_frame *current = lf_mailbox_current(show->home.mailbox);
    bool comparable = current && current->panel == frame->panel &&
                      current->image.width == frame->image.width &&
                      current->image.height == frame->image.height;
    if (show->push.state == LF_PUSH_WHOLE || !comparable) {
        rects[0] = (lf_rect){.width = frame->image.width, .height = frame->image.height};
        return 1;
    }
    if (frame->against == current->number) {
        memcpy(rects, frame->rects, (size_t)frame->n_rects * sizeof *rects);
        return frame->n_rects;
    }
    return lf_changed_rects(&current->image, &frame->image, rects, LF_FRAME_MAX_RECTS);
}

static lf_shown shown_of(const lf_frame *frame)
{
    lf_shown shown = {.generation = frame->generation,
                      .level = frame->level,
                      .passes = frame->passes,
                      .reconstructed = frame->reconstructed,
                      .fades = frame->fades,
                      .moves = frame->moves};
    memcpy(shown.card, frame->card, sizeof shown.card);
    return shown;
}

/* Reports a frame that needs no push. */
static void tell_shown(lf_show *show, const lf_frame *frame)
{
    show->push.frame = shown_of(frame);
    lf_mailbox_shown(show->home.mailbox);
    show->events.shown(show->context, &show->push.frame);
}

static void push(lf_show *show, const lf_frame *frame)
{
    lf_rect rects[LF_FRAME_MAX_RECTS];
    int n = rects_for(show, frame, rects);
    bool with_views = give_views(show, frame);
    if (n == 0 && !show->device->ops->kept) {
        tell_shown(show, frame);
        return;
    }
    lf_status status =
        show->device->ops->push(show->device, &frame->image, rects, n, (uint64_t)frame->generation);
    lf_mailbox_shown(show->home.mailbox);
    if (status == LF_E_NODEV) {
        lf_show_gone(show, "unplugged");
        return;
    }
    if (status != LF_OK) {
        show->push.state = LF_PUSH_WHOLE;
        lf_log(LF_LOG_DEBUG, "%s: an update failed: %s", show->spec, lf_status_name(status));
        lf_show_retry(show, REPUSH_USEC);
        return;
    }
    show->push =
        (lf_push){.state = LF_PUSH_BUSY, .frame = shown_of(frame), .lacks_views = !with_views};
    lf_show_dispatch(show);
}

/* The frame to push next: the newest, or after a failure the one that was not shown. */
static const lf_frame *next_frame(lf_show *show)
{
    const lf_frame *frame = lf_mailbox_take(show->home.mailbox);
    if (!frame && show->push.state == LF_PUSH_WHOLE)
        frame = lf_mailbox_current(show->home.mailbox);
    return frame && frame->panel == show->number ? frame : NULL;
}

void lf_show_pump(lf_show *show)
{
    if (!show->device || show->push.state == LF_PUSH_BUSY)
        return;
    const lf_frame *frame = next_frame(show);
    if (!frame)
        return;
    if (show->has_calibration && frame->image.data) {
        push(show, frame);
        return;
    }
    (void)give_views(show, frame);
    show->push.state = LF_PUSH_CHANGES;
    tell_shown(show, frame);
}
