/* The device usb over the unmodified libusb: umockdev gives it a bus on which the simulated display
 * hangs (usb.md 2 (b)). The program starts itself again with umockdev's library preloaded; where
 * that cannot be, and under the sanitizers, it is skipped. */
#include "tests/device/device_testing.h"
#include "tests/device/gud_testing.h"

enum { SKIPPED = 77 };

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !__has_include(<umockdev.h>)

int main(void)
{
    print_message("umockdev is absent, or at odds with the sanitizer that this is built with\n");
    return SKIPPED;
}

#else

#include <dlfcn.h>
#include <errno.h>
#include <linux/usbdevice_fs.h>
#include <pthread.h>
#include <stddef.h>
#include <sys/ioctl.h>
#include <umockdev.h>

#include "base/image_io.h"
#include "base/thread.h"
#include "device/device_table.h"
#include "device/model/usb_model.h"

enum { WIDTH = 700, HEIGHT = 900, MAX_URBS = 64, MAX_BULK = 1 << 20 };

#define NODE "/dev/bus/usb/001/002"
#define SYSTEM_PATH "/sys/devices/usb1/1-1"

static const lf_rect whole = {0, 0, WIDTH, HEIGHT};

/* ----------------------------------------------------------------------------------- the bus -- */

typedef struct urb {
    UMockdevIoctlData *data; /* the client's struct usbdevfs_urb */
    int status;
    int moved;
    bool done;
} urb;

typedef struct bus {
    UMockdevTestbed *testbed;
    UMockdevIoctlBase *handler;
    pthread_mutex_t lock; /* the handler runs in a thread of umockdev's */
    lf_model_gud *gud;
    urb urbs[MAX_URBS]; /* in the order of submitting */
    int n_urbs, most_urbs;
    size_t longest;
    int cleared;
    int n_clears; /* asked to clear the endpoint by request */
    bool halted, claimed;
    bool deaf;          /* to those */
    const char *driver; /* of the kernel, on the interface; NULL = none */
} bus;

static struct usbdevfs_urb *client_urb(const urb *u)
{
    return (struct usbdevfs_urb *)(void *)u->data->data;
}

/* What the display does with a transfer. Never answered: neither done nor moved. */
static void execute(bus *b, urb *u)
{
    const struct usbdevfs_urb *c = client_urb(u);
    g_autoptr(UMockdevIoctlData) data = umockdev_ioctl_data_resolve(
        u->data, offsetof(struct usbdevfs_urb, buffer), (gsize)c->buffer_length, NULL);
    int answer;
    if (c->type == USBDEVFS_URB_TYPE_CONTROL) {
        uint8_t *setup = data->data;
        uint8_t payload[4096];
        size_t n = (size_t)(setup[6] | setup[7] << 8);
        bool in = (setup[0] & 0x80) != 0;
        /* CLEAR_FEATURE of the endpoint */
        bool clears = setup[0] == 0x02 && setup[1] == 0x01 && setup[4] == 0x02;
        assert_true(clears || ((setup[0] == 0xc1 || setup[0] == 0x41) && setup[4] == 0));
        assert_true(n <= sizeof payload && n + 8 == (size_t)c->buffer_length);
        memcpy(payload, setup + 8, n);
        b->n_clears += clears;
        if (clears)
            answer = b->deaf ? -EAGAIN : 0;
        else
            answer = lf_model_gud_control(b->gud, in, setup[1],
                                          (uint16_t)(setup[2] | setup[3] << 8), payload, n);
        if (in && answer > 0)
            umockdev_ioctl_data_update(data, 8, payload, answer);
    } else {
        assert_int_equal(c->type, USBDEVFS_URB_TYPE_BULK);
        assert_int_equal(c->endpoint, 0x02);
        answer =
            b->halted ? -EAGAIN : lf_model_gud_bulk(b->gud, data->data, (size_t)c->buffer_length);
        b->halted = b->halted || answer == -EPIPE;
        if ((size_t)c->buffer_length > b->longest)
            b->longest = (size_t)c->buffer_length;
    }
    u->done = answer != -ETIMEDOUT && answer != -EAGAIN;
    u->status = answer == -ENODEV ? -ESHUTDOWN : answer < 0 ? answer : 0;
    u->moved = answer > 0 ? answer : 0;
}

/* Transfers on one endpoint end in their order: what comes behind one that is not answered waits.
 */
static void execute_waiting(bus *b)
{
    for (int i = 0; i < b->n_urbs; i++)
        if (!b->urbs[i].done) {
            execute(b, &b->urbs[i]);
            if (!b->urbs[i].done)
                return;
        }
}

static int submit(bus *b, UMockdevIoctlData *arg)
{
    assert_true(b->n_urbs < MAX_URBS);
    bool waiting = b->n_urbs > 0 && !b->urbs[b->n_urbs - 1].done;
    urb *u = &b->urbs[b->n_urbs++];
    *u = (urb){.data = umockdev_ioctl_data_resolve(arg, 0, sizeof(struct usbdevfs_urb), NULL)};
    if (b->n_urbs > b->most_urbs)
        b->most_urbs = b->n_urbs;
    if (!waiting)
        execute(b, u);
    return 0;
}

static int reap(bus *b, UMockdevIoctlData *arg)
{
    for (int i = 0; i < b->n_urbs; i++) {
        urb u = b->urbs[i];
        if (!u.done)
            continue;
        g_autoptr(UMockdevIoctlData) pointer =
            umockdev_ioctl_data_resolve(arg, 0, sizeof(gpointer), NULL);
        umockdev_ioctl_data_update(u.data, offsetof(struct usbdevfs_urb, status),
                                   (guint8 *)&u.status, sizeof u.status);
        umockdev_ioctl_data_update(u.data, offsetof(struct usbdevfs_urb, actual_length),
                                   (guint8 *)&u.moved, sizeof u.moved);
        umockdev_ioctl_data_set_ptr(pointer, 0, u.data);
        g_object_unref(u.data);
        memmove(&b->urbs[i], &b->urbs[i + 1], (size_t)(b->n_urbs - i - 1) * sizeof *b->urbs);
        b->n_urbs--;
        return 0;
    }
    return EAGAIN;
}

static int discard(bus *b, UMockdevIoctlData *arg)
{
    gulong address;
    memcpy(&address, arg->data, sizeof address);
    for (int i = 0; i < b->n_urbs; i++)
        if (b->urbs[i].data->client_addr == address && !b->urbs[i].done) {
            b->urbs[i].done = true;
            b->urbs[i].status = -ENOENT;
            return 0;
        }
    return EINVAL;
}

static int get_driver(const bus *b, UMockdevIoctlData *arg)
{
    g_autoptr(UMockdevIoctlData) data =
        umockdev_ioctl_data_resolve(arg, 0, sizeof(struct usbdevfs_getdriver), NULL);
    struct usbdevfs_getdriver out = {0};
    if (!b->driver)
        return ENODATA;
    snprintf(out.driver, sizeof out.driver, "%s", b->driver);
    umockdev_ioctl_data_update(data, 0, (guint8 *)&out, sizeof out);
    return 0;
}

static int get_capabilities(UMockdevIoctlData *arg)
{
    guint32 all = USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_NO_PACKET_SIZE_LIM |
                  USBDEVFS_CAP_BULK_SCATTER_GATHER | USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
    g_autoptr(UMockdevIoctlData) data = umockdev_ioctl_data_resolve(arg, 0, sizeof all, NULL);
    umockdev_ioctl_data_update(data, 0, (guint8 *)&all, sizeof all);
    return 0;
}

/* An errno value; -1 = not known here. */
static int answer_ioctl(bus *b, gulong request, UMockdevIoctlData *arg)
{
    switch (request) {
    case USBDEVFS_GET_CAPABILITIES:
        return get_capabilities(arg);
    case USBDEVFS_GETDRIVER:
        return get_driver(b, arg);
    case USBDEVFS_CLAIMINTERFACE:
        if (b->claimed || b->driver)
            return EBUSY;
        b->claimed = true;
        return 0;
    case USBDEVFS_RELEASEINTERFACE:
        b->claimed = false;
        return 0;
    case USBDEVFS_CLEAR_HALT:
        b->halted = false;
        b->cleared++;
        return 0;
    case USBDEVFS_SUBMITURB:
        return submit(b, arg);
    case USBDEVFS_REAPURB:
    case USBDEVFS_REAPURBNDELAY:
        return reap(b, arg);
    case USBDEVFS_DISCARDURB: {
        int e = discard(b, arg);
        execute_waiting(b);
        return e;
    }
    default:
        return -1;
    }
}

static gboolean handle_ioctl(UMockdevIoctlBase *handler, UMockdevIoctlClient *client, gpointer user)
{
    (void)handler;
    bus *b = user;
    pthread_mutex_lock(&b->lock);
    int e = answer_ioctl(b, umockdev_ioctl_client_get_request(client),
                         umockdev_ioctl_client_get_arg(client));
    pthread_mutex_unlock(&b->lock);
    if (e < 0)
        return FALSE;
    umockdev_ioctl_client_complete(client, e == 0 ? 0 : -1, e);
    return TRUE;
}

/* A root hub, the display (one interface, class 0xff, one bulk OUT endpoint of 512 bytes) and its
 * interface. */
static const char devices[] = "P: /devices/usb1\nN: bus/usb/001/001\nE: SUBSYSTEM=usb\nE: "
                              "DEVTYPE=usb_device\nE: DEVNAME=/dev/bus/usb/001/001\n"
                              "E: BUSNUM=001\nE: DEVNUM=001\nA: busnum=1\\n\nA: devnum=1\\n\nA: "
                              "bConfigurationValue=1\\n\nA: speed=480\\n\n"
                              "H: descriptors=1201000209000140"
                              "6B1D020001050302"
                              "0101"
                              "0902190001010000"
                              "00"
                              "0904000001090000"
                              "00"
                              "0705810304000C\n"
                              "\n"
                              "P: /devices/usb1/1-1\nN: bus/usb/001/002\nE: SUBSYSTEM=usb\nE: "
                              "DEVTYPE=usb_device\nE: DEVNAME=/dev/bus/usb/001/002\n"
                              "E: BUSNUM=001\nE: DEVNUM=002\nA: busnum=1\\n\nA: devnum=2\\n\nA: "
                              "bConfigurationValue=1\\n\nA: speed=480\\n\n"
                              "A: product=A \\033[31mdisplay\\n\nA: serial=S-1\\n\n"
                              "H: descriptors=1201000200000040"
                              "501D4D6100010102"
                              "0301"
                              "0902190001010080"
                              "32"
                              "09040000"
                              "01FF000000"
                              "07050202000200\n"
                              "\n"
                              "P: /devices/usb1/1-1/1-1:1.0\nE: SUBSYSTEM=usb\nE: "
                              "DEVTYPE=usb_interface\nA: bInterfaceNumber=00\\n\n";

/* What the kernel's driver makes of the display. */
static const char card[] =
    "P: /devices/usb1/1-1/1-1:1.0/drm/card7\nE: SUBSYSTEM=drm\nE: DEVTYPE=drm_minor\n\n"
    "P: /devices/usb1/1-1/1-1:1.0/drm/card7/card7-USB-1\nE: SUBSYSTEM=drm\nE: "
    "DEVTYPE=drm_connector\n";

static void plug_in_model(bus *b, lf_model_gud *gud)
{
    GError *error = NULL;
    *b = (bus){.gud = gud};
    pthread_mutex_init(&b->lock, NULL);
    b->testbed = umockdev_testbed_new();
    if (!umockdev_testbed_add_from_string(b->testbed, devices, &error))
        fail_msg("%s", error->message);
    b->handler = umockdev_ioctl_base_new();
    g_signal_connect(b->handler, "handle-ioctl", G_CALLBACK(handle_ioctl), b);
    if (!umockdev_testbed_attach_ioctl(b->testbed, NODE, b->handler, &error))
        fail_msg("%s", error->message);
}

static void plug_in(bus *b, const lf_model_gud_faults *faults)
{
    lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
    plug_in_model(b, gud_model(&o, faults));
}

static void pull_out(bus *b)
{
    umockdev_testbed_detach_ioctl(b->testbed, NODE, NULL);
    g_object_unref(b->handler);
    g_object_unref(b->testbed);
    for (int i = 0; i < b->n_urbs; i++)
        g_object_unref(b->urbs[i].data);
    pthread_mutex_destroy(&b->lock);
    lf_model_gud_destroy(b->gud);
}

/* -------------------------------------------------------------------------------- the device -- */

static lf_device *open_usb(const char *spec)
{
    lf_calibration c = device_lens(WIDTH, HEIGHT);
    lf_device *device = NULL;
    lf_error err = {0};
    lf_assert_ok(lf_device_open(spec, &c, &device, &err), &err);
    return device;
}

static int differences(bus *b, const lf_image8 *frame)
{
    pthread_mutex_lock(&b->lock);
    int n = gud_differences(b->gud, frame, whole, LF_GUD_RGB888);
    pthread_mutex_unlock(&b->lock);
    return n;
}

static void the_display_is_found_without_opening_it(void **state)
{
    (void)state;
    bus b;
    lf_usb_place places[4];
    lf_device_info list[8];
    plug_in(&b, NULL);
    assert_int_equal(lf_usb_list(places, 4), 1);
    assert_string_equal(places[0].address, "1-1");
    assert_string_equal(places[0].product, "A ?[31mdisplay");
    assert_string_equal(places[0].serial, "S-1");
    assert_string_equal(places[0].problem, "");
    assert_int_equal(places[0].vendor_id, 0x1d50);
    assert_int_equal(places[0].interface, 0);
    assert_int_equal(places[0].endpoint, 0x02);
    assert_int_equal(lf_usb_list(places, 0), 0);
    assert_true(lf_device_list(list, 8) >= 2);
    assert_int_equal(gud_counters(b.gud).refused, 0);
    pull_out(&b);
}

static void a_display_that_the_kernel_shows_on_is_left_to_drm(void **state)
{
    (void)state;
    bus b;
    lf_calibration c = device_lens(WIDTH, HEIGHT);
    lf_usb_place place;
    lf_device_info info;
    lf_device *device = NULL;
    lf_error err = {0};
    plug_in(&b, NULL);
    b.driver = "gud";
    lf_assert_status(lf_device_open("usb:1-1", &c, &device, &err), LF_E_BUSY, &err);
    assert_non_null(strstr(err.what, "--device drm"));
    umockdev_testbed_set_attribute_link(b.testbed, SYSTEM_PATH "/1-1:1.0", "driver",
                                        "../../../../bus/usb/drivers/gud");
    assert_int_equal(lf_usb_list(&place, 1), 1);
    assert_non_null(strstr(place.problem, "\"gud\""));
    assert_string_equal(place.output, "");
    b.driver = NULL;
    b.claimed = true; /* by another program */
    lf_assert_status(lf_device_open("usb", &c, &device, &err), LF_E_BUSY, &err);
    assert_non_null(strstr(err.what, "another program"));
    lf_assert_status(lf_device_open("usb:1-2", &c, &device, &err), LF_E_NODEV, &err);
    b.driver = "gud";
    assert_true(umockdev_testbed_add_from_string(b.testbed, card, NULL));
    assert_int_equal(lf_usb_list(&place, 1), 1);
    assert_string_equal(place.output, "card7/USB-1");
    assert_int_equal(lf_usb_ops.probe(&info, 1), 1);
    assert_non_null(strstr(info.problem, "drm:card7/USB-1"));
    /* it is opened as that, which fails here: there is no such card */
    lf_assert_status(lf_device_open("usb:1-1", &c, &device, &err), LF_E_NODEV, &err);
    assert_string_equal(err.where, "drm");
    assert_null(device);
    pull_out(&b);
}

static void rectangles_arrive_in_pieces_several_in_flight(void **state)
{
    (void)state;
    bus b;
    uint64_t random = 5;
    lf_image8 frame = gud_frame(WIDTH, HEIGHT);
    plug_in(&b, NULL);
    lf_device *device = open_usb("usb");
    gud_paint(&frame, whole, true, &random);
    assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
    assert_int_equal(differences(&b, &frame), 0);
    assert_true(b.most_urbs > 2 && b.most_urbs <= 16);
    assert_true(b.longest >= 256 * 1024 && b.longest <= MAX_BULK);
    for (int i = 0; i < 200; i++) {
        lf_rect r = gud_random_rect(WIDTH, HEIGHT, &random);
        gud_paint(&frame, r, i % 2 == 0, &random);
        assert_int_equal(device_push(device, &frame, &r, 1), LF_DEVICE_READY);
    }
    assert_int_equal(differences(&b, &frame), 0);
    assert_int_equal(gud_counters(b.gud).refused, 0);
    lf_device_destroy(device);
    assert_false(b.claimed);
    assert_int_equal(b.n_urbs, 0);
    assert_false(lf_model_gud_lit(b.gud));
    lf_image8_finish(&frame);
    pull_out(&b);
}

static void stalls_are_cleared_and_mended(void **state)
{
    (void)state;
    bus b;
    uint64_t random = 6;
    lf_image8 frame = gud_frame(WIDTH, HEIGHT);
    plug_in(&b, &(lf_model_gud_faults){.fail_every = 13, .stall_every = 17});
    lf_device *device = open_usb("usb:1-1");
    int failures = 0;
    for (int i = 0; i < 60; i++) {
        lf_rect r = gud_random_rect(WIDTH, HEIGHT, &random);
        gud_paint(&frame, r, true, &random);
        lf_device_event event = device_push(device, &frame, &r, 1);
        for (; event == LF_DEVICE_RETRY; failures++)
            event = device_push(device, &frame, &whole, 1);
        assert_int_equal(event, LF_DEVICE_READY);
    }
    assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
    assert_int_equal(differences(&b, &frame), 0);
    assert_true(failures >= 3);
    assert_true(b.cleared >= 1);
    lf_device_destroy(device);
    lf_image8_finish(&frame);
    pull_out(&b);
}

static void a_display_that_hangs_does_not_hold_up_the_end(void **state)
{
    (void)state;
    bus b;
    lf_image8 frame = gud_frame(WIDTH, HEIGHT);
    plug_in(&b, &(lf_model_gud_faults){.hang_every = 1});
    lf_device *device = open_usb("usb");
    lf_assert_ok(device->ops->push(device, &frame, &whole, 1, 1), NULL);
    lf_assert_status(device->ops->flush(device, 100), LF_E_TIMEOUT, NULL);
    lf_device_destroy(device);
    assert_int_equal(b.n_urbs, 0); /* all were taken back before they were freed */
    assert_false(b.claimed);
    lf_image8_finish(&frame);
    pull_out(&b);
}

/* The system's own call for clearing an endpoint waits 5 s for such a display. */
static void a_display_that_stalls_and_falls_silent_does_not_hold_up_the_end(void **state)
{
    (void)state;
    bus b;
    lf_image8 frame = gud_frame(WIDTH, HEIGHT);
    plug_in(&b, &(lf_model_gud_faults){.fail_every = 1});
    b.deaf = true;
    lf_device *device = open_usb("usb");
    lf_assert_ok(device->ops->push(device, &frame, &whole, 1, 1), NULL);
    lf_assert_status(device->ops->flush(device, 100), LF_E_TIMEOUT, NULL);
    lf_device_destroy(device);
    assert_true(b.n_clears >= 1);
    assert_int_equal(b.cleared, 0);
    assert_int_equal(b.n_urbs, 0);
    lf_image8_finish(&frame);
    pull_out(&b);
}

static void unplugging_in_a_stream_is_final_and_a_new_one_opens(void **state)
{
    (void)state;
    bus b;
    uint64_t random = 8;
    lf_image8 frame = gud_frame(WIDTH, HEIGHT);
    plug_in(&b, &(lf_model_gud_faults){.unplug_after = 5});
    lf_device *device = open_usb("usb");
    lf_device_event event = LF_DEVICE_READY;
    for (int i = 0; i < 20 && event == LF_DEVICE_READY; i++) {
        gud_paint(&frame, whole, true, &random);
        event = device_push(device, &frame, &whole, 1);
    }
    assert_int_equal(event, LF_DEVICE_GONE);
    lf_assert_status(device->ops->push(device, &frame, &whole, 1, 1), LF_E_NODEV, NULL);
    lf_device_destroy(device);
    pull_out(&b);
    plug_in(&b, NULL);
    device = open_usb("usb");
    assert_int_equal(device_push(device, &frame, &whole, 1), LF_DEVICE_READY);
    assert_int_equal(differences(&b, &frame), 0);
    lf_device_destroy(device);
    lf_image8_finish(&frame);
    pull_out(&b);
}

/* Two frames of nothing that repeats, or of a picture, upside down the second time. */
static void paint_frames(lf_image8 frames[2], const lf_image8 *picture)
{
    uint64_t random = 4;
    for (int i = 0; i < 2; i++) {
        if (!picture)
            gud_paint(&frames[i], whole, true, &random);
        for (int y = 0; picture && y < HEIGHT; y++)
            for (int x = 0; x < WIDTH * 3; x++) {
                int row = (i == 0 ? y : HEIGHT - 1 - y) % picture->height;
                frames[i].data[(size_t)y * frames[i].stride + (size_t)x] =
                    picture
                        ->data[(size_t)row * picture->stride + (size_t)(x % (picture->width * 3))];
            }
    }
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* Medians of pushing two frames in turn. */
static void tell_throughput(uint8_t format, bool lz4, const lf_image8 *picture)
{
    enum { FRAMES = 31 };
    bus b;
    lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
    lf_image8 frames[2] = {gud_frame(WIDTH, HEIGHT), gud_frame(WIDTH, HEIGHT)},
              copy = gud_frame(WIDTH, HEIGHT);
    double usb_s[FRAMES], copy_s[FRAMES];
    o.formats = &format;
    o.lz4 = lz4;
    plug_in_model(&b, gud_model(&o, NULL));
    lf_device *device = open_usb("usb");
    paint_frames(frames, picture);
    size_t bytes = frames[0].stride * HEIGHT;
    for (int i = 0; i < FRAMES; i++) {
        double start = lf_time_now();
        assert_int_equal(device_push(device, &frames[i % 2], &whole, 1), LF_DEVICE_READY);
        double middle = lf_time_now();
        memcpy(copy.data, frames[i % 2].data, bytes);
        copy_s[i] = lf_time_now() - middle;
        usb_s[i] = middle - start;
    }
    qsort(usb_s, FRAMES, sizeof *usb_s, compare_doubles);
    qsort(copy_s, FRAMES, sizeof *copy_s, compare_doubles);
    print_message("umockdev, %s, %s%s: %.0f MB/s, %.1f times as long as memcpy, %.2f MB a frame\n",
                  picture ? "picture" : "noise", lf_gud_format_name(format), lz4 ? ", LZ4" : "",
                  1e-6 * (double)bytes / usb_s[FRAMES / 2], usb_s[FRAMES / 2] / copy_s[FRAMES / 2],
                  1e-6 * (double)gud_counters(b.gud).bytes / FRAMES);
    lf_device_destroy(device);
    for (int i = 0; i < 2; i++)
        lf_image8_finish(&frames[i]);
    lf_image8_finish(&copy);
    pull_out(&b);
}

/* No assertion: numbers for whoever reads the log. */
static void throughput_is_told(void **state)
{
    (void)state;
    static const uint8_t formats[] = {LF_GUD_RGB888, LF_GUD_XRGB8888, LF_GUD_RGB565};
    lf_image8 picture = {0};
    lf_error err = {0};
    lf_assert_ok(lf_image8_read(lf_test_source("docs/first-light.png"), NULL, &picture, &err),
                 &err);
    assert_int_equal(picture.channels, 3);
    for (size_t i = 0; i < sizeof formats; i++) {
        tell_throughput(formats[i], false, NULL);
        tell_throughput(formats[i], false, &picture);
    }
    tell_throughput(LF_GUD_RGB888, true, &picture);
    lf_image8_finish(&picture);
}

#define PRELOADED "libumockdev-preload.so.0"

int main(int argc, char **argv)
{
    (void)argc;
    if (!dlopen(PRELOADED, RTLD_LAZY | RTLD_NOLOAD)) {
        if (!getenv("LF_TEST_AGAIN")) {
            setenv("LF_TEST_AGAIN", "1", 1);
            setenv("LD_PRELOAD", PRELOADED, 1);
            execv("/proc/self/exe", argv);
        }
        print_message(PRELOADED " cannot be preloaded\n");
        return SKIPPED;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_display_is_found_without_opening_it),
        cmocka_unit_test(a_display_that_the_kernel_shows_on_is_left_to_drm),
        cmocka_unit_test(rectangles_arrive_in_pieces_several_in_flight),
        cmocka_unit_test(stalls_are_cleared_and_mended),
        cmocka_unit_test(a_display_that_hangs_does_not_hold_up_the_end),
        cmocka_unit_test(a_display_that_stalls_and_falls_silent_does_not_hold_up_the_end),
        cmocka_unit_test(unplugging_in_a_stream_is_final_and_a_new_one_opens),
        cmocka_unit_test(throughput_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#endif
