/* Displays with an open protocol over USB: usb = the first GUD display found, usb:BUS-PORT = the
 * one plugged in there (usb:1-4.2). One that the kernel's own driver shows on is left to it: the
 * display output that it has made is opened instead, as drm does, and the device says so by being
 * one of drm's.
 *
 * The display's mode is set by the first push, in the device's own thread, which also asks an idle
 * display every now and then whether it is still there. A display that keeps failing is given time
 * before the failure is told, and gets its mode anew. */
#include "device/usb/usb.h"

#include <inttypes.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "device/device_table.h"
#include "device/find/find.h"
#include "device/handover.h"
#include "device/usb/gud_host.h"

enum {
    IDLE_MS = 1000,
    DESTROY_MS = 900,
    MAX_PLACES = 16,
    FIRST_PAUSE_MS = 10, /* after a failure; then twice as long each time … */
    MAX_PAUSE_MS = 300,  /* … up to this */
    PATIENCE = 3,        /* failures in a row until the mode is set anew */
};

typedef struct usb_device {
    lf_handover handover; /* first */

    /* immutable after open */
    lf_usb_place place;
    lf_calibration calibration;
    lf_origin origin; /* of the calibration */
    lf_edid edid;
    lf_usb_link *link;
    /* the device's thread */
    lf_gud_host *host;
    bool started;
    int failures;   /* in a row, without a band shown */
    uint64_t bytes; /* told so far */
    uint64_t bands; /* shown when the last push ended */
} usb_device;

static usb_device *usb_of(lf_device *device)
{
    return (usb_device *)(void *)device;
}

static const usb_device *const_usb_of(const lf_device *device)
{
    return (const usb_device *)(const void *)device;
}

/* -------------------------------------------------------------------------------- the thread -- */

static lf_status show(usb_device *usb, lf_error *err)
{
    const lf_handover *h = &usb->handover;
    if (!usb->started) {
        lf_status status = lf_gud_host_start(usb->host, err);
        if (status != LF_OK)
            return status;
        usb->started = true;
    }
    return lf_gud_host_update(usb->host, &h->picture, h->rects, h->n_rects, err);
}

static void pause_after_failure(usb_device *usb, bool progress)
{
    if (progress)
        usb->failures = 0;
    int ms = MAX_PAUSE_MS;
    if (usb->failures < 5)
        ms = FIRST_PAUSE_MS << usb->failures;
    poll(NULL, 0, ms);
    if (++usb->failures % PATIENCE == 0)
        usb->started = false;
}

static void take_push(usb_device *usb)
{
    lf_error err = {0};
    lf_gud_host_counters counters;
    lf_status status = show(usb, &err);
    if (status == LF_E_NODEV) {
        lf_handover_problem_set(&usb->handover, "unplugged");
        lf_handover_gone(&usb->handover);
        return;
    }
    lf_handover_problem_set(&usb->handover, status == LF_OK ? "" : err.what);
    lf_gud_host_counters_get(usb->host, &counters);
    if (status == LF_OK)
        usb->failures = 0;
    else if (status != LF_E_CANCELLED)
        pause_after_failure(usb, counters.bands != usb->bands);
    usb->bands = counters.bands;
    lf_handover_end(&usb->handover, status == LF_OK, counters.bytes - usb->bytes);
    if (status == LF_OK)
        usb->bytes = counters.bytes;
}

/* A display that nobody talks to does not tell that it was pulled out. */
static bool look_after(usb_device *usb)
{
    if (lf_gud_host_alive(usb->host) != LF_E_NODEV)
        return true;
    lf_handover_problem_set(&usb->handover, "unplugged");
    lf_handover_gone(&usb->handover);
    return false;
}

static void *usb_main(void *context)
{
    usb_device *usb = context;
    bool there = true;
    for (;;) {
        struct pollfd wake = {.fd = usb->handover.wake_fd, .events = POLLIN};
        int rings = poll(&wake, 1, there ? IDLE_MS : -1);
        lf_handover_word word = lf_handover_take(&usb->handover);
        if (word == LF_HANDOVER_STOP)
            break;
        if (word == LF_HANDOVER_PUSH)
            take_push(usb);
        else if (rings == 0)
            there = look_after(usb);
    }
    if (usb->started)
        lf_gud_host_stop(usb->host);
    return NULL;
}

/* -------------------------------------------------------------------------------------- open -- */

/* What the display says of itself, as far as it does. */
static void read_edid(usb_device *usb)
{
    size_t n = 0;
    lf_gud_mode mode;
    const uint8_t *edid = lf_gud_host_edid(usb->host, &n);
    if (lf_edid_parse(edid, n, &usb->edid, NULL) != LF_OK)
        usb->edid = (lf_edid){0};
    /* an EDID has no room for more than 4095 pixels */
    if (lf_gud_host_preferred(usb->host, &mode)) {
        usb->edid.width_px = mode.hdisplay;
        usb->edid.height_px = mode.vdisplay;
    }
}

static lf_status find_calibration(usb_device *usb, const lf_calibration *given, lf_error *err)
{
    if (!given)
        return lf_find_for_display(&usb->edid, &usb->calibration, &usb->origin, err);
    usb->calibration = *given;
    usb->origin = (lf_origin){.words = "given by the caller"};
    return LF_OK;
}

/* What open promises of a display that answers nonsense or not at all: LF_E_FORMAT is for
 * calibrations. */
static lf_status status_of_display(lf_status status)
{
    return status == LF_E_FORMAT || status == LF_E_TIMEOUT || status == LF_E_CANCELLED ? LF_E_IO
                                                                                       : status;
}

static lf_status set_up(usb_device *usb, const lf_calibration *given, lf_error *err)
{
    lf_status status = status_of_display(lf_gud_host_open(usb->link, &usb->host, err));
    if (status != LF_OK)
        return status;
    read_edid(usb);
    status = find_calibration(usb, given, err);
    if (status != LF_OK)
        return status;
    const lf_calibration *c = &usb->calibration;
    status = status_of_display(
        lf_gud_host_choose(usb->host, c->screen_width_px, c->screen_height_px, err));
    if (status == LF_OK)
        status = lf_handover_init(&usb->handover, c->screen_width_px, c->screen_height_px, err);
    if (status == LF_OK)
        status = lf_handover_start(&usb->handover, usb_main, usb, "lf-usb", err);
    return status;
}

lf_status lf_usb_create(lf_usb_link *link, const lf_usb_place *place,
                        const lf_calibration *calibration, lf_device **out_device, lf_error *err)
{
    usb_device *usb = lf_calloc(1, sizeof *usb);
    if (!usb) {
        link->ops->close(link);
        return lf_error_set(err, LF_E_NOMEM, "usb", "out of memory");
    }
    usb->handover.base.ops = &lf_usb_ops;
    usb->link = link;
    usb->place = *place;
    lf_status status = set_up(usb, calibration, err);
    if (status != LF_OK) {
        lf_device_destroy(&usb->handover.base);
        return status;
    }
    *out_device = &usb->handover.base;
    return LF_OK;
}

static lf_status usb_open(const char *argument, const lf_calibration *calibration,
                          lf_device **out_device, lf_error *err)
{
    lf_usb_place place = {0};
    lf_usb_link *link = NULL;
    lf_status status = lf_usb_open(argument, &place, &link, err);
    if (status == LF_OK)
        return lf_usb_create(link, &place, calibration, out_device, err);
    return status == LF_E_BUSY && place.output[0] != 0
               ? lf_drm_ops.open(place.output, calibration, out_device, err)
               : status;
}

static void describe_place(const lf_usb_place *place, lf_device_info *out)
{
    *out = (lf_device_info){.kind = "usb"};
    snprintf(out->spec, sizeof out->spec, "usb:%s", place->address);
    snprintf(out->output, sizeof out->output, "USB %s", place->address);
    snprintf(out->model, sizeof out->model, "%s",
             place->product[0] != 0 ? place->product : "GUD display");
    memcpy(out->serial, place->serial, sizeof out->serial);
    memcpy(out->problem, place->problem, sizeof out->problem);
    if (place->output[0] != 0)
        snprintf(out->problem, sizeof out->problem,
                 "the kernel driver uses this display; quiltd opens it as drm:%s", place->output);
}

static int usb_probe(lf_device_info *out, int max)
{
    lf_usb_place places[MAX_PLACES];
    int n = lf_usb_list(places, max < MAX_PLACES ? max : MAX_PLACES);
    for (int i = 0; i < n; i++)
        describe_place(&places[i], &out[i]);
    return n;
}

/* ----------------------------------------------------------------------------- the other ops -- */

static void usb_destroy(lf_device *device)
{
    usb_device *usb = usb_of(device);
    if (usb->handover.has_thread && lf_handover_flush(device, DESTROY_MS) == LF_E_TIMEOUT)
        usb->link->ops->cancel(usb->link);
    lf_handover_stop(&usb->handover);
    lf_handover_finish(&usb->handover);
    lf_gud_host_destroy(usb->host);
    usb->link->ops->close(usb->link);
    lf_free(usb);
}

static void usb_info(const lf_device *device, lf_device_info *out)
{
    const usb_device *usb = const_usb_of(device);
    describe_place(&usb->place, out);
    if (usb->edid.name[0] != 0)
        snprintf(out->model, sizeof out->model, "%s", usb->edid.name);
    if (usb->calibration.serial[0] != 0)
        lf_device_text(out->serial, sizeof out->serial, usb->calibration.serial);
    memcpy(out->calibration_from, usb->origin.words, sizeof out->calibration_from);
    out->calibration_cached = usb->origin.cached;
    snprintf(out->output, sizeof out->output, "USB %s, %s", usb->place.address,
             lf_gud_format_name(lf_gud_host_format(usb->host)));
    lf_handover_problem(&usb->handover, out->problem);
}

static const lf_calibration *usb_calibration(const lf_device *device)
{
    return &const_usb_of(device)->calibration;
}

const lf_device_ops lf_usb_ops = {
    .kind = "usb",
    .is_panel = true,
    .is_hardware = true,
    .probe = usb_probe,
    .open = usb_open,
    .destroy = usb_destroy,
    .info = usb_info,
    .calibration = usb_calibration,
    .push = lf_handover_push,
    .poll_fd = lf_handover_poll_fd,
    .dispatch = lf_handover_dispatch,
    .counters = lf_handover_counters,
    .flush = lf_handover_flush,
};
