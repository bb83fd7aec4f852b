#include "daemon/show/opener.h"

#include <string.h>

#include "base/alloc.h"

enum { MAX_FOUND = 16 };

lf_opener_request *lf_opener_request_create(lf_opener_kind kind)
{
    lf_opener_request *request = lf_calloc(1, sizeof *request);
    if (request)
        request->kind = kind;
    return request;
}

void lf_opener_request_destroy(lf_opener_request *request)
{
    lf_device_destroy(request->device);
    lf_buttons_destroy(request->buttons);
    lf_free(request->devices);
    lf_free(request);
}

void lf_opener_request_forget(void *reader, lf_task *task)
{
    (void)reader;
    lf_opener_request_destroy((lf_opener_request *)(void *)task);
}

static void close_all(lf_opener_request *request)
{
    lf_device_destroy(request->device);
    lf_buttons_destroy(request->buttons);
    request->device = NULL;
    request->buttons = NULL;
}

/* The HID interface of the panel whose EEPROM has this serial number; otherwise the only one, if it
 * reports no serial. */
static const lf_found *panel_of(const lf_found *found, int n, const char *serial)
{
    for (int i = 0; i < n; i++)
        if (found[i].problem[0] == '\0' && strcmp(found[i].calibration.serial, serial) == 0)
            return &found[i];
    return n == 1 && found->problem[0] != '\0' ? found : NULL;
}

static lf_status open_buttons(lf_opener_request *request)
{
    lf_found *found = lf_calloc(MAX_FOUND, sizeof *found);
    int n = found ? lf_find_hid(found, MAX_FOUND) : 0;
    const lf_found *panel = panel_of(found, n, request->spec);
    lf_status status =
        panel ? lf_buttons_open(panel->path, &request->buttons, &request->err) : LF_E_NODEV;
    lf_free(found);
    return status;
}

static lf_status find_panel(lf_opener_request *request, const lf_calibration *calibration)
{
    request->found = lf_device_find(request->first, calibration, &request->device, &request->err);
    if (request->found == LF_OK || request->panel_only)
        return request->found;
    const lf_error why = request->err;
    return lf_none_create(why.what, &request->device, &request->err);
}

static lf_status open_device(lf_opener_request *request)
{
    lf_calibration calibration;
    const lf_calibration *given = NULL;
    if (request->calibration) {
        lf_status status = lf_calibration_load(request->calibration, &calibration, &request->err);
        if (status != LF_OK)
            return status;
        given = &calibration;
    }
    return lf_device_is_auto(request->spec)
               ? find_panel(request, given)
               : lf_device_open(request->spec, given, &request->device, &request->err);
}

/* Allocated only now, because thousands of requests may wait. */
static lf_status list_devices(lf_opener_request *request)
{
    request->devices = lf_calloc(LF_LISTED_DEVICES, sizeof *request->devices);
    if (!request->devices)
        return lf_error_set(&request->err, LF_E_NOMEM, "device.list", "out of memory");
    request->n_devices = lf_device_list(request->devices, LF_LISTED_DEVICES);
    return LF_OK;
}

static lf_status examine(lf_opener_request *request)
{
    lf_status status = list_devices(request);
    lf_found *found = status == LF_OK ? lf_calloc(MAX_FOUND, sizeof *found) : NULL;
    if (found)
        request->look(request->answer, request->devices, request->n_devices, found,
                      lf_find_all(found, MAX_FOUND));
    else if (status == LF_OK)
        status = lf_error_set(&request->err, LF_E_NOMEM, "doctor", "out of memory");
    lf_free(found);
    return status;
}

static void run_task(void *context, lf_task *task)
{
    lf_opener_request *request = (lf_opener_request *)(void *)task;
    (void)context;
    switch (request->kind) {
    case LF_OPENER_OPEN:
        request->status = open_device(request);
        break;
    case LF_OPENER_CLOSE:
        close_all(request);
        break;
    case LF_OPENER_BUTTONS:
        request->status = open_buttons(request);
        break;
    case LF_OPENER_CHECK:
        request->denied = lf_find_denies(&request->display, &request->used);
        break;
    case LF_OPENER_LIST:
        request->status = list_devices(request);
        break;
    case LF_OPENER_EXAMINE:
        request->status = examine(request);
        break;
    }
}

static void drop_task(void *context, lf_task *task)
{
    lf_opener_request *request = (lf_opener_request *)(void *)task;
    if (request->kind == LF_OPENER_CLOSE) {
        run_task(context, task);
    } else {
        request->status =
            lf_error_set(&request->err, LF_E_CANCELLED, "", "the daemon is shutting down");
    }
}

/* ------------------------------------------------------------------------------------ queues -- */

struct lf_opener {
    lf_worker *queues[LF_OPENER_QUEUES];
};

static lf_opener_queue queue_of(bool is_hardware)
{
    return is_hardware ? LF_QUEUE_PANELS : LF_QUEUE_FILES;
}

lf_opener_queue lf_opener_queue_of(const char *spec)
{
    return queue_of(lf_device_is_hardware(spec));
}

static lf_opener_queue queue_of_request(const lf_opener_request *request)
{
    switch (request->kind) {
    case LF_OPENER_OPEN:
        return lf_opener_queue_of(request->spec);
    case LF_OPENER_CLOSE:
        return request->device ? queue_of(request->device->ops->is_hardware) : LF_QUEUE_BUTTONS;
    case LF_OPENER_LIST:
        return LF_QUEUE_LIST;
    case LF_OPENER_BUTTONS:
    case LF_OPENER_CHECK:
    case LF_OPENER_EXAMINE:
        break;
    }
    return LF_QUEUE_BUTTONS;
}

lf_status lf_opener_create(lf_inbox *inbox, lf_opener **out_opener)
{
    static const char *const names[LF_OPENER_QUEUES] = {"lf-opener", "lf-opener-files",
                                                        "lf-opener-keys", "lf-opener-list"};
    lf_opener *opener = lf_calloc(1, sizeof *opener);
    lf_status status = opener ? LF_OK : LF_E_NOMEM;
    for (int i = 0; i < LF_OPENER_QUEUES && status == LF_OK; i++)
        status = lf_worker_create(names[i], run_task, drop_task, NULL, inbox, &opener->queues[i]);
    if (status != LF_OK) {
        lf_opener_destroy(opener);
        return status;
    }
    *out_opener = opener;
    return LF_OK;
}

void lf_opener_destroy(lf_opener *opener)
{
    for (int i = 0; opener && i < LF_OPENER_QUEUES; i++)
        lf_worker_destroy(opener->queues[i]);
    lf_free(opener);
}

void lf_opener_submit(lf_opener *opener, lf_opener_request *request)
{
    lf_worker_queue(opener->queues[queue_of_request(request)], &request->task);
}

bool lf_opener_drain(lf_opener *opener, double end)
{
    bool done = true;
    for (int i = 0; i < LF_OPENER_QUEUES; i++)
        done = lf_worker_drain(opener->queues[i], end) && done;
    return done;
}
