#include "daemon/show/show_internal.h"

#include <stdio.h>
#include <string.h>
#include <sys/epoll.h>

#include "base/alloc.h"
#include "base/escape.h"
#include "base/log.h"
#include "base/thread.h"

lf_status lf_show_create(const lf_show_home *home, const lf_show_events *events, void *context,
                         lf_show **out_show)
{
    lf_show *show = lf_calloc(1, sizeof *show);
    if (!show)
        return LF_E_NOMEM;
    *show = (lf_show){.home = *home, .events = *events, .context = context};
    if (lf_opener_create(home->inbox, &show->opener) != LF_OK) {
        lf_free(show);
        return LF_E_NOMEM;
    }
    *out_show = show;
    return LF_OK;
}

bool lf_show_is_empty(const lf_show *show)
{
    return !show->device || !show->device->ops->is_panel;
}

/* -------------------------------------------------------------------------------- letting go -- */

void lf_show_discard(lf_show *show, lf_device *device, lf_buttons *buttons)
{
    if (!device && !buttons)
        return;
    lf_opener_request *request = lf_opener_request_create(LF_OPENER_CLOSE);
    if (!request) {
        lf_device_destroy(device);
        lf_buttons_destroy(buttons);
        return;
    }
    request->device = device;
    request->buttons = buttons;
    request->task.done = lf_opener_request_forget;
    lf_opener_submit(show->opener, request);
}

void lf_show_let_go(lf_show *show)
{
    show->push.state = LF_PUSH_WHOLE;
    lf_show_drop_buttons(show);
    if (!show->device)
        return;
    sd_event_source_disable_unref(show->device_io);
    show->device_io = NULL;
    show->before = lf_show_counters(show);
    lf_show_discard(show, show->device, NULL);
    show->device = NULL;
}

void lf_show_gone(lf_show *show, const char *why)
{
    lf_log(show->kept.lost ? LF_LOG_WARNING : LF_LOG_INFO, "%s: %s", show->spec, why);
    lf_show_let_go(show);
    (void)lf_error_set(&show->problem, LF_E_NODEV, show->spec, "%s", why);
    show->events.changed(show->context);
    lf_show_reopen_soon(show);
}

/* ------------------------------------------------------------------------------------ taking -- */

static int on_device(sd_event_source *source, int fd, uint32_t events, void *context)
{
    lf_show *show = context;
    (void)source;
    (void)fd;
    (void)events;
    lf_show_dispatch(show);
    if (show->push.state != LF_PUSH_WHOLE)
        lf_show_pump(show);
    return 0;
}

/* Sets the panel that frames are made for. The current frame still fits a panel that comes back,
 * which need not wait for a new one. */
static void take_calibration(lf_show *show, const lf_calibration *calibration)
{
    bool views = show->device->ops->views;
    bool same = show->has_calibration == !!calibration &&
                (!calibration || memcmp(calibration, &show->calibration, sizeof *calibration) == 0);
    if (same && show->number > 0 && show->has_views == views)
        return;
    show->has_calibration = calibration;
    show->has_views = views;
    if (calibration)
        show->calibration = *calibration;
    show->number++;
    show->events.lens(show->context, calibration, show->number, views, !same);
}

lf_status lf_show_take(lf_show *show, lf_device *device, lf_error *err)
{
    lf_device_info info;
    lf_show_let_go(show);
    show->device = device;
    lf_show_forget_kept(show);
    device->ops->info(device, &info);
    snprintf(show->spec, sizeof show->spec, "%s", info.spec);
    if (!lf_show_is_empty(show))
        memcpy(show->opening.last, show->spec, sizeof show->opening.last);
    show->problem.status = LF_OK;
    int fd = device->ops->poll_fd(device);
    if (fd >= 0 &&
        sd_event_add_io(show->home.event, &show->device_io, fd, EPOLLIN, on_device, show) < 0) {
        lf_show_let_go(show);
        return lf_error_set(err, LF_E_NOMEM, show->spec, "out of memory");
    }
    take_calibration(show, device->ops->calibration(device));
    lf_show_find_buttons(show);
    lf_log(LF_LOG_INFO, "%s: %s%s%s", show->spec, info.model, info.problem[0] != '\0' ? ": " : "",
           info.problem);
    return LF_OK;
}

/* -------------------------------------------------------------------------------------- told -- */

bool lf_show_info(const lf_show *show, lf_device_info *out)
{
    *out = (lf_device_info){0};
    if (show->device) {
        show->device->ops->info(show->device, out);
        return true;
    }
    const char *problem = lf_show_problem(show);
    (void)lf_escape(out->spec, sizeof out->spec, show->spec);
    (void)lf_escape(out->problem, sizeof out->problem, problem ? problem : "not open");
    return false;
}

const char *lf_show_spec(const lf_show *show)
{
    return show->spec;
}

const char *lf_show_wanted(const lf_show *show)
{
    return show->opening.wanted;
}

const char *lf_show_problem(const lf_show *show)
{
    return !show->device && show->problem.status != LF_OK ? show->problem.what : NULL;
}

const lf_calibration *lf_show_calibration(const lf_show *show)
{
    return show->has_calibration ? &show->calibration : NULL;
}

lf_device_counters lf_show_counters(const lf_show *show)
{
    lf_device_counters sum = {0};
    if (show->device)
        show->device->ops->counters(show->device, &sum);
    sum.updates += show->before.updates;
    sum.bytes += show->before.bytes;
    sum.errors += show->before.errors;
    return sum;
}

/* ----------------------------------------------------------------------------------- listing -- */

static void on_listed(void *reader, lf_task *task)
{
    lf_opener_request *request = (lf_opener_request *)(void *)task;
    lf_show *show = request->owner;
    (void)reader;
    for (int i = 0; i < request->n_devices && show->device; i++)
        if (strcmp(request->devices[i].spec, show->spec) == 0) /* this show uses it */
            show->device->ops->info(show->device, &request->devices[i]);
    show->events.listed(show->context, request->answer, request->devices, request->n_devices,
                        request->status != LF_OK ? &request->err : NULL);
    lf_opener_request_destroy(request);
}

lf_status lf_show_list(lf_show *show, void *answer)
{
    lf_opener_request *request = lf_opener_request_create(LF_OPENER_LIST);
    if (!request)
        return LF_E_NOMEM;
    request->task.done = on_listed;
    request->owner = show;
    request->answer = answer;
    lf_opener_submit(show->opener, request);
    return LF_OK;
}

static void on_examined(void *reader, lf_task *task)
{
    lf_opener_request *request = (lf_opener_request *)(void *)task;
    const lf_show *show = request->owner;
    const lf_error *err = request->status == LF_OK ? NULL : &request->err;
    (void)reader;
    show->events.examined(show->context, request->answer, err);
    lf_opener_request_destroy(request);
}

lf_status lf_show_examine(lf_show *show, lf_look_fn look, void *answer)
{
    lf_opener_request *request = lf_opener_request_create(LF_OPENER_EXAMINE);
    if (!request)
        return LF_E_NOMEM;
    request->task.done = on_examined;
    request->owner = show;
    request->look = look;
    request->answer = answer;
    lf_opener_submit(show->opener, request);
    return LF_OK;
}

/* ----------------------------------------------------------------------------------- the end -- */

void lf_show_stop(lf_show *show)
{
    show->stopping = true;
}

void lf_show_close(lf_show *show, int timeout_ms)
{
    double end = lf_time_now() + timeout_ms * 1e-3;
    /* The push in progress, then the last frame. */
    for (int i = 0; i < 2 && show->device; i++) {
        int left = (int)((end - lf_time_now()) * 1e3);
        bool busy = show->push.state == LF_PUSH_BUSY;
        if (busy && show->device->ops->flush(show->device, left > 0 ? left : 0) != LF_OK)
            break;
        if (busy)
            lf_show_dispatch(show);
        lf_show_pump(show);
    }
    lf_show_cancel_retry(show);
    lf_show_let_go(show);
}

bool lf_show_drain(lf_show *show, double end)
{
    return lf_opener_drain(show->opener, end);
}

void lf_show_end(lf_show *show)
{
    if (!show)
        return;
    lf_show_stop(show);
    lf_show_unwatch_plugs(show);
    lf_show_cancel_retry(show);
    lf_show_drop_requests(show);
    lf_show_let_go(show);
    lf_opener_destroy(show->opener);
    show->opener = NULL;
}

void lf_show_destroy(lf_show *show)
{
    lf_free(show);
}
