/* The link over libusb 1.0. Everything goes through asynchronous transfers and one loop of events
 * in the caller's thread, so that all can be cancelled. Bulk data go in pieces, several in flight:
 * a single large transfer would be slower than the bus, or refused, because all programs share
 * usbcore.usbfs_memory_mb (16 MiB when nobody has changed it). */
#include <assert.h>
#include <dirent.h>
#include <libusb.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/thread.h"
#include "device/device_table.h"
#include "device/usb/usb_link.h"

enum {
    PIECE_BYTES = 512 * 1024,
    MAX_IN_FLIGHT = 8, /* 4 MiB */
    MAX_CONTROL = 4096,
    MAX_PORTS = 7,
    CLASS_VENDOR = 0xff,
    TYPE_SET = 0x41, /* bmRequestType: vendor, interface */
    TYPE_GET = 0xc1,
    ENDPOINT_HALT = 0, /* a feature of endpoints (USB 2.0, table 9-6) */
    CLEAR_MS = 1000,
    EVENT_MS = 100,
};

typedef struct usb_link {
    lf_usb_link base;
    libusb_context *context;
    libusb_device_handle *handle;
    uint8_t interface, endpoint;
    bool claimed;
    atomic_bool cancelled;
    /* what is under way: one control transfer, or bulk pieces */
    struct libusb_transfer *control, *bulk[MAX_IN_FLIGHT];
    uint8_t control_buffer[LIBUSB_CONTROL_SETUP_SIZE + MAX_CONTROL];
    int in_flight;
    lf_usb_result result; /* the first thing that went wrong */
    const uint8_t *data;  /* … and of bulk: what has not been submitted yet */
    size_t left;
    uint64_t moved; /* bytes, or ends of transfers: that something goes on */
} usb_link;

static usb_link *usb_of(lf_usb_link *link)
{
    return (usb_link *)(void *)link;
}

/* --------------------------------------------------------------------------------- transfers -- */

static lf_usb_result result_of_error(int error)
{
    switch (error) {
    case LIBUSB_SUCCESS:
        return LF_USB_OK;
    case LIBUSB_ERROR_NO_DEVICE:
        return LF_USB_GONE;
    case LIBUSB_ERROR_PIPE:
        return LF_USB_STALL;
    case LIBUSB_ERROR_TIMEOUT:
        return LF_USB_TIMEOUT;
    case LIBUSB_ERROR_NO_MEM:
        return LF_USB_NOMEM;
    default:
        return LF_USB_IO;
    }
}

static lf_usb_result result_of_transfer(const struct libusb_transfer *t)
{
    switch (t->status) {
    case LIBUSB_TRANSFER_COMPLETED:
        return LF_USB_OK;
    case LIBUSB_TRANSFER_STALL:
        return LF_USB_STALL;
    case LIBUSB_TRANSFER_NO_DEVICE:
        return LF_USB_GONE;
    case LIBUSB_TRANSFER_TIMED_OUT:
        return LF_USB_TIMEOUT;
    case LIBUSB_TRANSFER_CANCELLED:
        return LF_USB_CANCELLED;
    default:
        return LF_USB_IO;
    }
}

/* Writes down the first failure and takes back all that is in flight; their callbacks still come.
 */
static void give_up(usb_link *usb, lf_usb_result why)
{
    if (usb->result != LF_USB_OK)
        return;
    usb->result = why;
    usb->left = 0;
    (void)libusb_cancel_transfer(usb->control);
    for (int i = 0; i < MAX_IN_FLIGHT; i++)
        (void)libusb_cancel_transfer(usb->bulk[i]); /* refused for those that are not in flight */
}

/* Sends the next piece of data in this transfer. */
static void submit_piece(usb_link *usb, struct libusb_transfer *t)
{
    size_t piece = usb->left < PIECE_BYTES ? usb->left : PIECE_BYTES;
    t->buffer = (unsigned char *)(uintptr_t)usb->data; /* OUT: only read */
    t->length = (int)piece;
    int error = libusb_submit_transfer(t);
    if (error == LIBUSB_SUCCESS) {
        usb->data += piece;
        usb->left -= piece;
        usb->in_flight++;
    } else if (error != LIBUSB_ERROR_NO_MEM || usb->in_flight == 0) {
        give_up(usb, result_of_error(error));
    }
    /* else memory is short: the pieces in flight carry on alone */
}

static void LIBUSB_CALL piece_ended(struct libusb_transfer *t)
{
    usb_link *usb = t->user_data;
    usb->in_flight--;
    usb->moved += (uint64_t)t->actual_length + 1;
    lf_usb_result result = result_of_transfer(t);
    if (result == LF_USB_OK && t->actual_length != t->length)
        result = LF_USB_IO;
    if (result != LF_USB_OK)
        give_up(usb, result);
    else if (usb->left > 0)
        submit_piece(usb, t);
}

static void LIBUSB_CALL control_ended(struct libusb_transfer *t)
{
    usb_link *usb = t->user_data;
    usb->in_flight--;
    usb->moved++;
    lf_usb_result result = result_of_transfer(t);
    if (result != LF_USB_OK)
        give_up(usb, result);
}

/* Runs callbacks until nothing is in flight; gives up when nothing moves for timeout_ms or somebody
 * cancels. */
static lf_usb_result wait_for_end(usb_link *usb, int timeout_ms)
{
    double limit = timeout_ms / 1000.0, until = lf_time_now() + limit;
    uint64_t moved = usb->moved;
    while (usb->in_flight > 0) {
        struct timeval step = {.tv_usec = EVENT_MS * 1000};
        int error = libusb_handle_events_timeout_completed(usb->context, &step, NULL);
        if (atomic_load(&usb->cancelled))
            give_up(usb, LF_USB_CANCELLED);
        else if (error != LIBUSB_SUCCESS && error != LIBUSB_ERROR_INTERRUPTED &&
                 error != LIBUSB_ERROR_TIMEOUT)
            give_up(usb, result_of_error(error));
        else if (usb->moved != moved)
            until = lf_time_now() + limit;
        else if (lf_time_now() > until)
            give_up(usb, LF_USB_TIMEOUT);
        moved = usb->moved;
    }
    return usb->result;
}

/* What stands in the control buffer. */
static lf_usb_result run_control(usb_link *usb, int timeout_ms)
{
    if (atomic_load(&usb->cancelled))
        return LF_USB_CANCELLED;
    libusb_fill_control_transfer(usb->control, usb->handle, usb->control_buffer, control_ended, usb,
                                 0);
    usb->result = LF_USB_OK;
    int error = libusb_submit_transfer(usb->control);
    if (error != LIBUSB_SUCCESS)
        return result_of_error(error);
    usb->in_flight++;
    return wait_for_end(usb, timeout_ms);
}

static lf_usb_result usb_control(lf_usb_link *link, bool in, uint8_t request, uint16_t value,
                                 uint8_t *data, size_t n, size_t *out_n, int timeout_ms)
{
    usb_link *usb = usb_of(link);
    assert(n <= MAX_CONTROL && usb->in_flight == 0);
    uint8_t *payload = usb->control_buffer + LIBUSB_CONTROL_SETUP_SIZE;
    if (out_n)
        *out_n = 0;
    libusb_fill_control_setup(usb->control_buffer, in ? TYPE_GET : TYPE_SET, request, value,
                              usb->interface, (uint16_t)n);
    if (!in && n > 0)
        memcpy(payload, data, n);
    lf_usb_result result = run_control(usb, timeout_ms);
    size_t got = (size_t)usb->control->actual_length;
    if (result != LF_USB_OK)
        return result;
    if (!in && got != n)
        return LF_USB_IO;
    if (in && got > 0)
        memcpy(data, payload, got < n ? got : n);
    if (out_n)
        *out_n = got < n ? got : n;
    return LF_USB_OK;
}

static void usb_bulk_begin(lf_usb_link *link, const uint8_t *data, size_t n)
{
    usb_link *usb = usb_of(link);
    assert(n > 0 && usb->in_flight == 0);
    usb->data = data;
    usb->left = n;
    usb->result = LF_USB_OK;
    if (atomic_load(&usb->cancelled))
        give_up(usb, LF_USB_CANCELLED);
    for (int i = 0; i < MAX_IN_FLIGHT && usb->left > 0; i++)
        submit_piece(usb, usb->bulk[i]);
}

/* The system's own call for it waits up to 5 s for a display that does not answer, and nothing ends
 * it early: the display is asked before, by a request that has an end, and the system only when it
 * has answered. It takes the system's call too, without which the host would go on counting packets
 * where it was (USB 2.0, 9.4.5: the display begins anew). */
static lf_usb_result clear_halt(usb_link *usb)
{
    libusb_fill_control_setup(usb->control_buffer, LIBUSB_RECIPIENT_ENDPOINT,
                              LIBUSB_REQUEST_CLEAR_FEATURE, ENDPOINT_HALT, usb->endpoint, 0);
    lf_usb_result result = run_control(usb, CLEAR_MS);
    return result == LF_USB_OK ? result_of_error(libusb_clear_halt(usb->handle, usb->endpoint))
                               : result;
}

static lf_usb_result usb_bulk_end(lf_usb_link *link, int timeout_ms)
{
    usb_link *usb = usb_of(link);
    lf_usb_result result = wait_for_end(usb, timeout_ms);
    if (result != LF_USB_STALL)
        return result;
    lf_usb_result cleared = clear_halt(usb);
    return cleared == LF_USB_GONE || cleared == LF_USB_CANCELLED ? cleared : result;
}

static void usb_cancel(lf_usb_link *link)
{
    usb_link *usb = usb_of(link);
    atomic_store(&usb->cancelled, true);
    libusb_interrupt_event_handler(usb->context);
}

/* Takes half-made links. */
static void usb_close(lf_usb_link *link)
{
    usb_link *usb = usb_of(link);
    libusb_free_transfer(usb->control);
    for (int i = 0; i < MAX_IN_FLIGHT; i++)
        libusb_free_transfer(usb->bulk[i]);
    if (usb->claimed)
        /* fails when it is unplugged */
        (void)libusb_release_interface(usb->handle, usb->interface);
    if (usb->handle)
        libusb_close(usb->handle);
    if (usb->context)
        libusb_exit(usb->context);
    lf_free(usb);
}

static const lf_usb_link_ops usb_ops = {
    .control = usb_control,
    .bulk_begin = usb_bulk_begin,
    .bulk_end = usb_bulk_end,
    .cancel = usb_cancel,
    .close = usb_close,
};

/* ----------------------------------------------------------------------------------- finding -- */

static bool known_ids(const struct libusb_device_descriptor *d)
{
    return (d->idVendor == 0x1d50 && d->idProduct == 0x614d) ||
           (d->idVendor == 0x16d0 && d->idProduct == 0x10a9) ||
           (d->idVendor == 0x04d8 && d->idProduct == 0xef7e);
}

/* The first interface that can be a display's. */
static bool find_interface(const struct libusb_config_descriptor *config, lf_usb_place *place)
{
    for (int i = 0; i < config->bNumInterfaces; i++) {
        if (config->interface[i].num_altsetting < 1)
            continue;
        const struct libusb_interface_descriptor *d = &config->interface[i].altsetting[0];
        if (d->bInterfaceClass != CLASS_VENDOR)
            continue;
        for (int k = 0; k < d->bNumEndpoints; k++) {
            const struct libusb_endpoint_descriptor *e = &d->endpoint[k];
            if ((e->bmAttributes & LIBUSB_TRANSFER_TYPE_MASK) != LIBUSB_TRANSFER_TYPE_BULK ||
                (e->bEndpointAddress & LIBUSB_ENDPOINT_IN) != 0)
                continue;
            place->interface = d->bInterfaceNumber;
            place->endpoint = e->bEndpointAddress;
            return true;
        }
    }
    return false;
}

/* "1-4.2", as the kernel names it. False for the host controllers themselves. */
static bool find_address(libusb_device *device, char out[40])
{
    uint8_t ports[MAX_PORTS];
    int n = libusb_get_port_numbers(device, ports, MAX_PORTS);
    int used = snprintf(out, 40, "%d", libusb_get_bus_number(device));
    for (int i = 0; i < n; i++)
        used += snprintf(out + used, 40 - (size_t)used, "%c%d", i == 0 ? '-' : '.', ports[i]);
    return n > 0;
}

/* A string of the device as the kernel has read it: asking the device itself could take long. */
static void read_string(const char *address, const char *name, char *out, size_t size)
{
    char path[128], text[256];
    snprintf(path, sizeof path, "/sys/bus/usb/devices/%s/%s", address, name);
    FILE *file = fopen(path, "re");
    if (!file || !fgets(text, sizeof text, file))
        text[0] = 0;
    if (file)
        fclose(file);
    text[strcspn(text, "\n")] = 0;
    lf_device_text(out, size, text);
}

/* Name of the driver that has the interface, empty when none. */
static void find_driver(const lf_usb_place *place, int configuration, char *out, size_t size)
{
    char path[128], target[PATH_MAX];
    snprintf(path, sizeof path, "/sys/bus/usb/devices/%s:%d.%d/driver", place->address,
             configuration, place->interface);
    ssize_t n = readlink(path, target, sizeof target - 1);
    target[n > 0 ? n : 0] = 0;
    const char *slash = strrchr(target, '/');
    lf_device_text(out, size, slash ? slash + 1 : target);
}

/* The name of an entry of a folder that begins so; the first of several. */
static bool find_entry(const char *folder, const char *prefix, char out[NAME_MAX + 1])
{
    bool found = false;
    DIR *dir = opendir(folder);
    for (struct dirent *e = dir ? readdir(dir) : NULL; e; e = readdir(dir)) {
        if (strncmp(e->d_name, prefix, strlen(prefix)) != 0 ||
            (found && strcmp(e->d_name, out) > 0))
            continue;
        snprintf(out, NAME_MAX + 1, "%s", e->d_name);
        found = true;
    }
    if (dir)
        closedir(dir);
    return found;
}

/* The display output that the kernel's driver has made of the interface: the first connector of its
 * card. */
static void find_output(int configuration, lf_usb_place *place)
{
    char folder[128], card[NAME_MAX + 1], below[sizeof folder + sizeof card], prefix[NAME_MAX + 2],
        connector[NAME_MAX + 1];
    snprintf(folder, sizeof folder, "/sys/bus/usb/devices/%s:%d.%d/drm", place->address,
             configuration, place->interface);
    if (!find_entry(folder, "card", card))
        return;
    snprintf(below, sizeof below, "%s/%s", folder, card);
    snprintf(prefix, sizeof prefix, "%s-", card);
    if (find_entry(below, prefix, connector))
        snprintf(place->output, sizeof place->output, "%.16s/%.40s", card,
                 connector + strlen(prefix));
}

static void say_bound(const char *driver, lf_usb_place *place)
{
    if (strcmp(driver, "usbfs") == 0)
        snprintf(place->problem, sizeof place->problem, "another program uses this display");
    else if (driver[0] != 0)
        snprintf(place->problem, sizeof place->problem,
                 "the kernel driver \"%.32s\" uses this display; use --device drm once it has a "
                 "display output",
                 driver);
}

static void say_forbidden(lf_usb_place *place)
{
    snprintf(place->problem, sizeof place->problem,
             "no permission; install quiltd's udev rule (70-quiltd.rules, SUBSYSTEM==\"usb\" for "
             "%04x:%04x) and plug the panel in again",
             place->vendor_id, place->product_id);
}

static void find_problem(libusb_device *device, int configuration, lf_usb_place *place)
{
    char driver[64], node[64];
    find_driver(place, configuration, driver, sizeof driver);
    say_bound(driver, place);
    find_output(configuration, place);
    snprintf(node, sizeof node, "/dev/bus/usb/%03d/%03d", libusb_get_bus_number(device),
             libusb_get_device_address(device));
    if (place->problem[0] == 0 && access(node, R_OK | W_OK) != 0)
        say_forbidden(place);
}

/* False when the device is no display. */
static bool describe(libusb_device *device, lf_usb_place *out)
{
    struct libusb_device_descriptor d;
    struct libusb_config_descriptor *config = NULL;
    lf_usb_place place = {0};
    if (libusb_get_device_descriptor(device, &d) != LIBUSB_SUCCESS || !known_ids(&d) ||
        !find_address(device, place.address))
        return false;
    if (libusb_get_active_config_descriptor(device, &config) != LIBUSB_SUCCESS)
        return false;
    bool found = find_interface(config, &place);
    int configuration = config->bConfigurationValue;
    libusb_free_config_descriptor(config);
    if (!found)
        return false;
    place.vendor_id = d.idVendor;
    place.product_id = d.idProduct;
    read_string(place.address, "product", place.product, sizeof place.product);
    read_string(place.address, "serial", place.serial, sizeof place.serial);
    find_problem(device, configuration, &place);
    *out = place;
    return true;
}

int lf_usb_list(lf_usb_place *out, int max)
{
    libusb_context *context = NULL;
    libusb_device **devices = NULL;
    int n = 0;
    if (libusb_init(&context) != LIBUSB_SUCCESS)
        return 0;
    ssize_t count = libusb_get_device_list(context, &devices);
    for (ssize_t i = 0; i < count && n < max; i++)
        n += describe(devices[i], &out[n]);
    if (count >= 0)
        libusb_free_device_list(devices, 1);
    libusb_exit(context);
    return n;
}

/* -------------------------------------------------------------------------------------- open -- */

/* "1-4.2". */
static bool is_address(const char *text)
{
    const char *p = text;
    for (int part = 0;; part++) {
        size_t digits = strspn(p, "0123456789");
        if (digits < 1 || digits > 3 || part > MAX_PORTS)
            return false;
        p += digits;
        if (*p == 0)
            return part > 0;
        if (*p++ != (part == 0 ? '-' : '.'))
            return false;
    }
}

/* The device at this address, with a reference; "" = the first without a problem, else the first.
 * NULL = none. */
static libusb_device *find_device(libusb_context *context, const char *address,
                                  lf_usb_place *out_place)
{
    libusb_device **devices = NULL, *found = NULL;
    ssize_t count = libusb_get_device_list(context, &devices);
    for (ssize_t i = 0; i < count; i++) {
        lf_usb_place place;
        if (!describe(devices[i], &place) ||
            (address[0] != 0 && strcmp(address, place.address) != 0))
            continue;
        if (found && (out_place->problem[0] == 0 || place.problem[0] != 0))
            continue;
        found = devices[i];
        *out_place = place;
    }
    if (found)
        libusb_ref_device(found);
    if (count >= 0)
        libusb_free_device_list(devices, 1);
    return found;
}

static lf_status open_error(int error, lf_usb_place *place, lf_error *err)
{
    switch (error) {
    case LIBUSB_ERROR_ACCESS:
        say_forbidden(place);
        return lf_error_set(err, LF_E_IO, place->address, "%s", place->problem);
    case LIBUSB_ERROR_BUSY:
        return lf_error_set(err, LF_E_BUSY, place->address, "another program uses this display");
    case LIBUSB_ERROR_NO_DEVICE:
    case LIBUSB_ERROR_NOT_FOUND:
        return lf_error_set(err, LF_E_NODEV, place->address, "the display was unplugged");
    default:
        return lf_error_set(err, error == LIBUSB_ERROR_NO_MEM ? LF_E_NOMEM : LF_E_IO,
                            place->address, "cannot open: %s", libusb_error_name(error));
    }
}

static lf_status claim(usb_link *usb, lf_usb_place *place, lf_error *err)
{
    if (libusb_kernel_driver_active(usb->handle, usb->interface) == 1) {
        if (place->problem[0] == 0)
            say_bound("gud", place);
        return lf_error_set(err, LF_E_BUSY, place->address, "%s", place->problem);
    }
    int error = libusb_claim_interface(usb->handle, usb->interface);
    if (error != LIBUSB_SUCCESS)
        return open_error(error, place, err);
    usb->claimed = true;
    return LF_OK;
}

static bool make_transfers(usb_link *usb)
{
    bool ok = (usb->control = libusb_alloc_transfer(0));
    for (int i = 0; i < MAX_IN_FLIGHT && ok; i++) {
        usb->bulk[i] = libusb_alloc_transfer(0);
        ok = usb->bulk[i];
        if (ok)
            libusb_fill_bulk_transfer(usb->bulk[i], usb->handle, usb->endpoint, NULL, 0,
                                      piece_ended, usb, 0);
    }
    return ok;
}

static lf_status open_device(usb_link *usb, const char *address, lf_usb_place *place, lf_error *err)
{
    libusb_device *device = find_device(usb->context, address, place);
    if (!device)
        return lf_error_set(err, LF_E_NODEV, address[0] != 0 ? address : "usb",
                            "no GUD display is plugged in%s", address[0] != 0 ? " there" : "");
    int error = libusb_open(device, &usb->handle);
    libusb_unref_device(device);
    if (error != LIBUSB_SUCCESS)
        return open_error(error, place, err);
    usb->interface = place->interface;
    usb->endpoint = place->endpoint;
    lf_status status = claim(usb, place, err);
    if (status != LF_OK)
        return status;
    return make_transfers(usb) ? LF_OK
                               : lf_error_set(err, LF_E_NOMEM, place->address, "out of memory");
}

lf_status lf_usb_open(const char *address, lf_usb_place *out_place, lf_usb_link **out_link,
                      lf_error *err)
{
    lf_usb_place place = {0};
    if (address[0] != 0 && !is_address(address))
        return lf_error_set(
            err, LF_E_ARG, address,
            "is not the address of a USB device; expected BUS-PORT[.PORT…], for example 1-4.2");
    usb_link *usb = lf_calloc(1, sizeof *usb);
    if (!usb)
        return lf_error_set(err, LF_E_NOMEM, "usb", "out of memory");
    usb->base.ops = &usb_ops;
    int error = libusb_init(&usb->context);
    lf_status status = error == LIBUSB_SUCCESS
                           ? open_device(usb, address, &place, err)
                           : lf_error_set(err, LF_E_NODEV, "usb", "USB is not available: %s",
                                          libusb_error_name(error));
    *out_place = place;
    if (status != LF_OK) {
        usb_close(&usb->base);
        return status;
    }
    *out_link = &usb->base;
    return LF_OK;
}
