/* When to open which device: requests and retries. */
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/log.h"
#include "base/thread.h"
#include "daemon/show/show_internal.h"

/* Delays before: the first retry for a missing panel, and, growing, the last; a retry after a
 * possible part of a panel was plugged in, until the rest appears; the next search for a panel that
 * was never connected, if no events report it. */
#define REOPEN_USEC 500000
#define REOPEN_LAST_USEC 8000000
#define PLUGGED_USEC 300000
#define SEARCH_USEC 30000000

/* ---------------------------------------------------------------------------------- requests -- */

static bool is_opening(const lf_opening *opening)
{
    for (int i = 0; i < LF_OPENER_QUEUES; i++)
        if (opening->busy[i])
            return true;
    return false;
}

static void begin_request(lf_show *show, lf_opener_request *request)
{
    lf_opening *opening = &show->opening;
    if (!lf_show_is_empty(show) && lf_device_same(show->spec, request->spec)) {
        memcpy(request->before, opening->wanted, sizeof request->before);
        lf_show_let_go(show);
    }
    opening->busy[lf_opener_queue_of(request->spec)] = request;
    opening->plugged = false;
    lf_opener_submit(show->opener, request);
}

/* Starts waiting requests whose queue is free. */
static void begin_waiting(lf_show *show)
{
    if (show->stopping)
        return; /* lf_show_drop_requests answers them */
    lf_opener_request **at = &show->opening.waiting;
    while (*at) {
        lf_opener_request *request = *at;
        if (show->opening.busy[lf_opener_queue_of(request->spec)]) {
            at = &request->next;
        } else {
            *at = request->next;
            begin_request(show, request);
        }
    }
}

static void on_opened(void *reader, lf_task *task);

static lf_opener_request *make_request(lf_show *show, const char *spec, uint64_t number)
{
    lf_opener_request *request = lf_opener_request_create(LF_OPENER_OPEN);
    if (request) {
        request->task.done = on_opened;
        request->owner = show;
        request->number = number;
        request->calibration = show->home.calibration;
        snprintf(request->spec, sizeof request->spec, "%s", spec);
    }
    return request;
}

/* Opens now, or after the earlier requests of its queue. */
static void submit(lf_show *show, lf_opener_request *request)
{
    lf_opener_request **at = &show->opening.waiting;
    while (*at)
        at = &(*at)->next;
    *at = request;
    begin_waiting(show);
}

lf_status lf_show_open(lf_show *show, const char *spec, void *answer, lf_error *err)
{
    lf_opening *opening = &show->opening;
    if (strlen(spec) >= sizeof opening->wanted)
        return lf_error_set(err, LF_E_ARG, "device", "the spec is longer than %zu bytes",
                            sizeof opening->wanted - 1);
    lf_opener_request *request = make_request(show, spec, opening->requests + 1);
    if (!request)
        return lf_error_set(err, LF_E_NOMEM, "device", "out of memory");
    if (opening->wanted[0] == '\0') { /* the first spec stays wanted whether or not it is
                                       * connected */
        snprintf(opening->wanted, sizeof opening->wanted, "%s", spec);
        opening->backoff_usec = REOPEN_USEC;
    }
    opening->requests++;
    request->asked_for = true;
    request->answer = answer;
    submit(show, request);
    return LF_OK;
}

/* Opens again the device that was closed for one that could not be opened. */
static void open_what_was(lf_show *show, const lf_opener_request *failed)
{
    lf_opener_request *request = make_request(show, failed->before, failed->number);
    if (request)
        submit(show, request);
}

/* ---------------------------------------------------------------------------------- outcomes -- */

static void answer(lf_show *show, const lf_opener_request *request, const lf_error *err)
{
    if (request->asked_for)
        show->events.opened(show->context, request->answer, err);
}

/* Another device was requested meanwhile through another queue, and is open. */
static void come_too_late(lf_show *show, lf_opener_request *request)
{
    lf_show_discard(show, request->device, NULL);
    request->device = NULL;
    request->status = lf_error_set(&request->err, LF_E_CANCELLED, request->spec,
                                   "another device was chosen in the meantime");
}

/* Reports that a display used by the kernel's driver is shown through the kernel, whatever was
 * requested. */
static void tell_detour(const lf_opener_request *request, const lf_device *device)
{
    lf_device_info info;
    device->ops->info(device, &info);
    if (!lf_device_is_auto(request->spec) && !lf_device_has_kind(request->spec, info.kind)) {
        lf_log(LF_LOG_INFO,
               "%s: the kernel driver uses this display; quiltd opens it as %s instead",
               request->spec, info.spec);
    }
}

static void opened(lf_show *show, lf_opener_request *request)
{
    lf_opening *opening = &show->opening;
    lf_device *device = request->device;
    if (request->number < opening->taken) {
        come_too_late(show, request);
        return;
    }
    request->device = NULL;
    request->status = lf_show_take(show, device, &request->err);
    if (request->status == LF_OK) {
        opening->taken = request->number;
        tell_detour(request, device);
        memcpy(opening->wanted, request->spec, sizeof opening->wanted);
        opening->backoff_usec = REOPEN_USEC;
        show->events.changed(show->context);
        answer(show, request, NULL);
        lf_show_pump(show); /* may find that it is gone again */
    }
}

static bool worth_another_try(lf_status status)
{
    return status == LF_E_NODEV || status == LF_E_BUSY || status == LF_E_IO ||
           status == LF_E_TIMEOUT;
}

/* True if udev will report when the wanted device comes back. */
static bool will_be_told(const lf_show *show)
{
    return show->told_of_plugs && lf_device_is_hardware(show->opening.wanted);
}

/* Retries with growing delays: a search can take seconds, in which the panel may return unnoticed,
 * and may disturb other programs. */
static void try_later(lf_show *show, lf_status status)
{
    lf_opening *opening = &show->opening;
    if (status == LF_E_NODEV && will_be_told(show))
        opening->backoff_usec = REOPEN_LAST_USEC;
    lf_show_retry(show, opening->backoff_usec);
    opening->backoff_usec =
        opening->backoff_usec < REOPEN_LAST_USEC / 2 ? 2 * opening->backoff_usec : REOPEN_LAST_USEC;
}

/* No device is open now: the one that was closed comes back, or the previous spec stays wanted. */
static void stays_missing(lf_show *show, const lf_opener_request *request)
{
    bool wanted = strcmp(request->spec, show->opening.wanted) == 0;
    if (show->kept.lost) { /* its folder could not be created again */
        show->kept.lost = false;
        show->events.kept(show->context, &request->err);
    }
    if (wanted) {
        show->problem = request->err;
        memcpy(show->spec, request->spec, sizeof show->spec);
    }
    if (request->before[0] != '\0' && !request->again)
        open_what_was(show, request);
    else if (!wanted || worth_another_try(request->status))
        try_later(show, request->status);
    if (!request->again || request->before[0] != '\0')
        show->events.changed(show->context);
}

/* To a client, missing, damaged and refused devices are the same: there is none. */
static void not_opened(lf_show *show, lf_opener_request *request)
{
    if (!show->device)
        stays_missing(show, request);
    if (request->status == LF_E_IO || request->status == LF_E_FORMAT)
        request->err.status = LF_E_NODEV;
    answer(show, request, &request->err);
}

static void drop_request(lf_show *show, lf_opener_request *request)
{
    (void)lf_error_set(&request->err, LF_E_CANCELLED, "", "the daemon is shutting down");
    answer(show, request, &request->err);
    if (show->opener) { /* closing may wait */
        lf_show_discard(show, request->device, NULL);
        request->device = NULL;
    }
    lf_opener_request_destroy(request);
}

void lf_show_drop_requests(lf_show *show)
{
    while (show->opening.waiting) {
        lf_opener_request *request = show->opening.waiting;
        show->opening.waiting = request->next;
        drop_request(show, request);
    }
}

/* True if a stand-in is open while a panel is searched for. */
static bool is_stand_in(const lf_show *show)
{
    return show->device && lf_show_is_empty(show) && lf_device_is_auto(show->opening.wanted);
}

/* To be called while there is no panel. */
static void look_again(lf_show *show)
{
    const lf_opening *opening = &show->opening;
    if (opening->plugged) /* during the search */
        lf_show_retry(show, 0);
    else if (is_stand_in(show) &&
             opening->found != LF_E_NODEV) /* it may become usable without being plugged in */
        try_later(show, opening->found);
    else if (is_stand_in(show) && !show->told_of_plugs)
        lf_show_retry(show, SEARCH_USEC);
}

static void on_opened(void *reader, lf_task *task)
{
    lf_opener_request *request = (lf_opener_request *)(void *)task;
    lf_show *show = request->owner;
    (void)reader;
    show->opening.busy[lf_opener_queue_of(request->spec)] = NULL;
    if (lf_device_is_auto(request->spec))
        show->opening.found = request->found;
    if (show->stopping) {
        drop_request(show, request);
        return;
    }
    if (request->status == LF_OK)
        opened(show, request);
    if (request->status != LF_OK)
        not_opened(show, request);
    lf_opener_request_destroy(request);
    begin_waiting(show);
    if (lf_show_is_empty(show))
        look_again(show);
}

/* ------------------------------------------------------------------------------ trying again -- */

void lf_show_open_again(lf_show *show)
{
    lf_opening *opening = &show->opening;
    lf_opener_request *request =
        is_opening(opening) ? NULL : make_request(show, opening->wanted, opening->requests);
    if (!request)
        return;
    request->again = request->panel_only = true;
    if (lf_device_is_auto(opening->wanted))
        memcpy(request->first, opening->last, sizeof request->first);
    submit(show, request);
}

void lf_show_cancel_retry(lf_show *show)
{
    sd_event_source_disable_unref(show->opening.retry);
    show->opening.retry = NULL;
}

static int on_retry(sd_event_source *source, uint64_t usec, void *context)
{
    lf_show *show = context;
    (void)source;
    (void)usec;
    lf_show_cancel_retry(show);
    if (!show->device || is_stand_in(show))
        lf_show_open_again(show);
    lf_show_pump(show);
    return 0;
}

void lf_show_retry(lf_show *show, uint64_t usec)
{
    lf_opening *opening = &show->opening;
    double at = lf_time_now() + (double)usec * 1e-6;
    /* Never later than a retry that is already due, since plug events may continue for ever. */
    if (!show->stopping && (!opening->retry || at < opening->retry_at)) {
        lf_show_cancel_retry(show);
        opening->retry_at = at;
        (void)sd_event_add_time_relative(show->home.event, &opening->retry, CLOCK_MONOTONIC, usec,
                                         0, on_retry, show);
    }
}

void lf_show_reopen_soon(lf_show *show)
{
    show->opening.backoff_usec = REOPEN_USEC;
    lf_show_retry(show, REOPEN_USEC);
}

void lf_show_plugged(lf_show *show, bool whole)
{
    if (lf_show_is_empty(show)) {
        show->opening.plugged = true;
        show->opening.backoff_usec = REOPEN_USEC;
        lf_show_retry(show, whole ? 0 : PLUGGED_USEC);
    } else {
        lf_show_find_buttons(show);
        lf_show_check_calibration(show);
    }
}
