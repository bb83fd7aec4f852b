#include "daemon/show/show_internal.h"

#include <string.h>

#include "base/log.h"
#include "quilt/quilt.h"

/* Between a push that failed and the next. */
#define REPUSH_USEC 20000

void lf_show_dispatch(lf_show *show)
{
    lf_push *push = &show->push;
    switch (show->device->ops->dispatch(show->device)) {
    case LF_DEVICE_READY:
        if (push->state == LF_PUSH_BUSY) {
            push->state = LF_PUSH_CHANGES;
            show->events.shown(show->context, push->generation, push->level, push->passes,
                               push->reconstructed);
        }
        break;
    case LF_DEVICE_BUSY:
        break;
    case LF_DEVICE_RETRY:
        push->state = LF_PUSH_WHOLE;
        lf_show_retry(show, REPUSH_USEC);
        break;
    case LF_DEVICE_GONE:
        lf_show_gone(show);
        break;
    }
}

static void give_views(lf_show *show, const lf_frame *frame)
{
    lf_device *device = show->device;
    lf_mailbox *mailbox = show->home.mailbox;
    if (!device->ops->views)
        return;
    const lf_views8 *views = lf_mailbox_views(mailbox, frame);
    if (views)
        device->ops->views(device, views, frame->columns, frame->rows);
    lf_mailbox_views_done(mailbox);
}

/* What of frame differs from what the panel shows. */
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

static void tell_shown(lf_show *show, const lf_frame *frame)
{
    lf_mailbox_shown(show->home.mailbox);
    show->events.shown(show->context, frame->generation, frame->level, frame->passes,
                       frame->reconstructed);
}

static void push(lf_show *show, const lf_frame *frame)
{
    lf_rect rects[LF_FRAME_MAX_RECTS];
    int n = rects_for(show, frame, rects);
    give_views(show, frame);
    if (n == 0) {
        tell_shown(show, frame);
        return;
    }
    lf_status status =
        show->device->ops->push(show->device, &frame->image, rects, n, (uint64_t)frame->generation);
    lf_mailbox_shown(show->home.mailbox);
    if (status == LF_E_NODEV) {
        lf_show_gone(show);
        return;
    }
    if (status != LF_OK) {
        show->push.state = LF_PUSH_WHOLE;
        lf_log(LF_LOG_DEBUG, "%s: a push failed: %s", show->spec, lf_status_name(status));
        lf_show_retry(show, REPUSH_USEC);
        return;
    }
    show->push = (lf_push){.state = LF_PUSH_BUSY,
                           .generation = frame->generation,
                           .level = frame->level,
                           .passes = frame->passes,
                           .reconstructed = frame->reconstructed};
    lf_show_dispatch(show);
}

/* The frame to push next: the newest, or after a failure the one that did not get there. */
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
    give_views(show, frame);
    show->push.state = LF_PUSH_CHANGES;
    tell_shown(show, frame);
}
