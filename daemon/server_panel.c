#include <string.h>

#include "base/log.h"
#include "daemon/server.h"

/* Between a push that failed and the next. */
#define REPUSH_USEC 20000

void lf_server_dispatch(lf_server *server)
{
    lf_panel *panel = &server->panel;
    switch (panel->device->ops->dispatch(panel->device)) {
    case LF_DEVICE_READY:
        if (panel->in_flight) {
            panel->in_flight = false;
            lf_server_shown(server, panel->flying_generation, panel->flying_level, panel->flying_passes);
        }
        break;
    case LF_DEVICE_BUSY:
        break;
    case LF_DEVICE_RETRY:
        panel->in_flight = false;
        panel->whole = true;
        lf_server_retry(server, REPUSH_USEC);
        break;
    case LF_DEVICE_GONE:
        lf_server_gone(server);
        break;
    }
}

static void give_views(lf_server *server, const lf_frame *frame)
{
    lf_device *device = server->panel.device;
    lf_mailbox *mailbox = lf_engine_mailbox(server->engine);
    if (device->ops->views == NULL) {
        return;
    }
    const lf_views8 *views = lf_mailbox_views(mailbox, frame);
    if (views != NULL) {
        device->ops->views(device, views, frame->columns, frame->rows);
    }
    lf_mailbox_views_done(mailbox);
}

/* What of frame differs from what the panel shows. */
static int rects_for(lf_server *server, const lf_frame *frame, lf_rect *rects)
{
    const lf_frame *current = lf_mailbox_current(lf_engine_mailbox(server->engine));
    bool comparable = current != NULL && current->panel == frame->panel && current->image.width == frame->image.width &&
                      current->image.height == frame->image.height;
    if (server->panel.whole || !comparable) {
        rects[0] = (lf_rect){.width = frame->image.width, .height = frame->image.height};
        return 1;
    }
    if (frame->against == current->number) {
        memcpy(rects, frame->rects, (size_t)frame->n_rects * sizeof *rects);
        return frame->n_rects;
    }
    return lf_changed_rects(&current->image, &frame->image, rects, LF_FRAME_MAX_RECTS);
}

static void push(lf_server *server, const lf_frame *frame)
{
    lf_panel *panel = &server->panel;
    lf_rect rects[LF_FRAME_MAX_RECTS];
    int n = rects_for(server, frame, rects);
    give_views(server, frame);
    if (n == 0) {
        lf_mailbox_shown(lf_engine_mailbox(server->engine));
        lf_server_shown(server, frame->generation, frame->level, frame->passes);
        return;
    }
    lf_status status = panel->device->ops->push(panel->device, &frame->image, rects, n, (uint64_t)frame->generation);
    lf_mailbox_shown(lf_engine_mailbox(server->engine));
    panel->whole = status != LF_OK;
    if (status == LF_E_NODEV) {
        lf_server_gone(server);
        return;
    }
    if (status != LF_OK) {
        lf_log(LF_LOG_DEBUG, "%s: a push failed: %s", panel->spec, lf_status_name(status));
        lf_server_retry(server, REPUSH_USEC);
        return;
    }
    panel->in_flight = true;
    panel->flying_generation = frame->generation;
    panel->flying_level = frame->level;
    panel->flying_passes = frame->passes;
    lf_server_dispatch(server);
}

/* The frame to push next: the newest, or after a failure the one that did not get there. */
static const lf_frame *next_frame(lf_server *server)
{
    lf_mailbox *mailbox = lf_engine_mailbox(server->engine);
    const lf_frame *frame = lf_mailbox_take(mailbox);
    if (frame == NULL && server->panel.whole) {
        frame = lf_mailbox_current(mailbox);
    }
    return frame != NULL && frame->panel == server->panel.number ? frame : NULL;
}

void lf_server_pump(lf_server *server)
{
    lf_panel *panel = &server->panel;
    if (panel->device == NULL || panel->in_flight) {
        return;
    }
    const lf_frame *frame = next_frame(server);
    if (frame == NULL) {
        return;
    }
    if (panel->has_calibration && frame->image.data != NULL) {
        push(server, frame);
        return;
    }
    give_views(server, frame);
    panel->whole = false;
    lf_mailbox_shown(lf_engine_mailbox(server->engine));
    lf_server_shown(server, frame->generation, frame->level, frame->passes);
}
