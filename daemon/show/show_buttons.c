/* The buttons of the panel: finds and reads them. */
#include <stdio.h>
#include <string.h>
#include <sys/epoll.h>

#include "base/log.h"
#include "daemon/show/show_internal.h"

void lf_show_drop_buttons(lf_show *show)
{
    sd_event_source_disable_unref(show->buttons_io);
    show->buttons_io = NULL;
    lf_show_discard(show, NULL, show->buttons);
    show->buttons = NULL;
}

/* Presses handled in a row; the rest come after other events. */
#define PRESSES_AT_ONCE 32

static int on_buttons(sd_event_source *source, int fd, uint32_t events, void *context)
{
    lf_show *show = context;
    lf_button button;
    (void)source;
    (void)fd;
    (void)events;
    for (int i = 0; i < PRESSES_AT_ONCE && show->buttons; i++) {
        switch (lf_buttons_next(show->buttons, &button)) {
        case LF_BUTTONS_PRESSED:
            show->events.pressed(show->context, button);
            break;
        case LF_BUTTONS_GONE:
            lf_show_drop_buttons(show);
            return 0;
        case LF_BUTTONS_NOTHING:
            return 0;
        }
    }
    return 0;
}

/* True if they belong to the current panel. */
static bool are_wanted(const lf_show *show, const lf_opener_request *request)
{
    return !show->stopping && show->device && show->has_calibration &&
           strcmp(request->spec, show->calibration.serial) == 0;
}

static void watch_buttons(lf_show *show, lf_opener_request *request)
{
    int fd = lf_buttons_poll_fd(request->buttons);
    if (sd_event_add_io(show->home.event, &show->buttons_io, fd, EPOLLIN, on_buttons, show) >= 0) {
        show->buttons = request->buttons;
        request->buttons = NULL;
    }
}

static void on_buttons_found(void *reader, lf_task *task)
{
    lf_opener_request *request = (lf_opener_request *)(void *)task;
    lf_show *show = request->owner;
    bool wanted = are_wanted(show, request), again = show->seeking == LF_SEARCH_AGAIN || !wanted;
    (void)reader;
    show->seeking = LF_SEARCH_REST;
    if (request->status == LF_OK && wanted)
        watch_buttons(show, request);
    else if (request->status != LF_OK && request->status != LF_E_NODEV &&
             request->status != LF_E_CANCELLED)
        lf_log_error(&request->err);
    if (show->opener) { /* closing may wait */
        lf_show_discard(show, NULL, request->buttons);
        request->buttons = NULL;
    }
    lf_opener_request_destroy(request);
    if (again && !show->stopping)
        lf_show_find_buttons(show);
}

void lf_show_find_buttons(lf_show *show)
{
    bool may_have = show->device && show->has_calibration && show->device->ops->is_hardware;
    if (show->buttons || !may_have)
        return;
    if (show->seeking != LF_SEARCH_REST) {
        show->seeking = LF_SEARCH_AGAIN;
        return;
    }
    lf_opener_request *request = lf_opener_request_create(LF_OPENER_BUTTONS);
    if (request) {
        snprintf(request->spec, sizeof request->spec, "%s", show->calibration.serial);
        request->task.done = on_buttons_found;
        request->owner = show;
        show->seeking = LF_SEARCH_BUSY;
        lf_opener_submit(show->opener, request);
    }
}
