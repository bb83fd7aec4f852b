/* What the daemon makes of plugging in: "auto" that finds a panel which cannot be opened yet,
 * udev's news and echoes of its own doing, a cached calibration when a panel's own turns up. The
 * daemon is this program again, with a display, an EEPROM and a udev of the test's own in place of
 * libusb's, hidapi's and the machine's (see wrap_test_auto): files in a folder say what there is, a
 * pipe in it is the udev. */
#include "tests/daemon/live.h"

#include <limits.h>
#include <sys/stat.h>
#include <systemd/sd-device.h>
#include <systemd/sd-event.h>

#include "base/alloc.h"
#include "base/file.h"
#include "base/log.h"
#include "base/thread.h"
#include "daemon/server/server.h"
#include "device/find/find.h"
#include "device/hid/hid.h"
#include "device/model/usb_model.h"
#include "device/usb/gud.h"

#define NAME "LKG-DISPLAY-1"
#define UDEV "udev"
/* What the world's folder may hold. */
#define DISPLAY "display" /* the display is plugged in … */
#define BUSY "busy"       /* … and another program has it */
#define EEPROM "eeprom"   /* the HID side is plugged in; its text */
#define OPENED "opened"   /* a byte for every time that the display was opened or refused */
#define TOUCHED "touched" /* block devices are told to be mounted by the daemon itself */

enum { WIDTH = 96, HEIGHT = 128 };

/* --------------------------------------------------------------------------------- the world -- */

/* its folder, in the daemon; set before the server's first thread starts */
static char world[PATH_MAX / 2];

static bool has(const char *name)
{
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s/%s", world, name);
    return access(path, F_OK) == 0;
}

static void count(const char *name)
{
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s/%s", world, name);
    int fd = open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    if (fd < 0 || write(fd, "x", 1) != 1)
        abort();
    close(fd);
}

typedef struct display {
    lf_usb_link base;
    lf_model_gud *gud;
    lf_usb_link *inner;
} display;

static display *display_of(lf_usb_link *link)
{
    return (display *)(void *)link;
}

static lf_usb_result display_control(lf_usb_link *link, bool in, uint8_t request, uint16_t value,
                                     uint8_t *data, size_t n, size_t *out_n, int timeout_ms)
{
    lf_usb_link *inner = display_of(link)->inner;
    return inner->ops->control(inner, in, request, value, data, n, out_n, timeout_ms);
}

static void display_bulk_begin(lf_usb_link *link, const uint8_t *data, size_t n)
{
    lf_usb_link *inner = display_of(link)->inner;
    inner->ops->bulk_begin(inner, data, n);
}

static lf_usb_result display_bulk_end(lf_usb_link *link, int timeout_ms)
{
    lf_usb_link *inner = display_of(link)->inner;
    lf_usb_result result = inner->ops->bulk_end(inner, timeout_ms);
    return has(DISPLAY) ? result : LF_USB_GONE;
}

static void display_cancel(lf_usb_link *link)
{
    lf_usb_link *inner = display_of(link)->inner;
    inner->ops->cancel(inner);
}

static void display_close(lf_usb_link *link)
{
    display *d = display_of(link);
    d->inner->ops->close(d->inner);
    lf_model_gud_destroy(d->gud);
    lf_free(d);
}

static void fill_place(lf_usb_place *out)
{
    *out = (lf_usb_place){.address = "1-1",
                          .product = "A panel",
                          .vendor_id = 0x1d50,
                          .product_id = 0x614d,
                          .endpoint = 2};
}

int __wrap_lf_usb_list(lf_usb_place *out, int max);
int __wrap_lf_usb_list(lf_usb_place *out, int max)
{
    if (max < 1 || !has(DISPLAY))
        return 0;
    fill_place(out);
    return 1;
}

lf_status __wrap_lf_usb_open(const char *address, lf_usb_place *out_place, lf_usb_link **out_link,
                             lf_error *err);
lf_status __wrap_lf_usb_open(const char *address, lf_usb_place *out_place, lf_usb_link **out_link,
                             lf_error *err)
{
    static const lf_usb_link_ops ops = {display_control, display_bulk_begin, display_bulk_end,
                                        display_cancel, display_close};
    static const uint8_t rgb888 = LF_GUD_RGB888;
    (void)address;
    if (!has(DISPLAY))
        return lf_error_set(err, LF_E_NODEV, "display", "is not plugged in");
    count(OPENED);
    if (has(BUSY))
        return lf_error_set(err, LF_E_BUSY, "display", "another program has it");
    uint8_t edid[128];
    lf_model_edid(NAME, "1", WIDTH, HEIGHT, edid);
    const lf_model_gud_options options = {.width = WIDTH,
                                          .height = HEIGHT,
                                          .formats = &rgb888,
                                          .n_formats = 1,
                                          .edid = edid,
                                          .n_edid = sizeof edid};
    display *d = lf_calloc(1, sizeof *d);
    if (!d || lf_model_gud_create(&options, NULL, &d->gud) != LF_OK ||
        !(d->inner = lf_usb_model_open(d->gud)))
        abort();
    d->base.ops = &ops;
    fill_place(out_place);
    *out_link = &d->base;
    return LF_OK;
}

static int side_send(void *context, const uint8_t *report, size_t n)
{
    return lf_model_hid_feature(context, report + 1, n - 1) < 0 ? -1 : (int)n;
}

static int side_read(void *context, uint8_t *out, size_t max, int timeout_ms)
{
    int n = lf_model_hid_input(context, out, max);
    if (n <= 0)
        live_nap(timeout_ms);
    return n > 0 ? n : 0;
}

static uint64_t side_now(void *context)
{
    (void)context;
    return lf_time_now_ns() / 1000000;
}

static void side_close(void *context)
{
    lf_model_hid_destroy(context);
}

int __wrap_lf_hid_list(lf_hid_place *out, int max);
int __wrap_lf_hid_list(lf_hid_place *out, int max)
{
    if (max < 1 || !has(EEPROM))
        return 0;
    *out = (lf_hid_place){.path = "/dev/hidraw-test", .product = "HoloPlay"};
    return 1;
}

lf_status __wrap_lf_hid_open(const char *path, lf_hid_link *out, lf_error *err);
lf_status __wrap_lf_hid_open(const char *path, lf_hid_link *out, lf_error *err)
{
    char file[PATH_MAX], *text = NULL;
    size_t n = 0;
    uint8_t eeprom[LF_MODEL_EEPROM_MAX];
    lf_model_hid *model = NULL;
    snprintf(file, sizeof file, "%s/" EEPROM, world);
    if (lf_file_read(file, NULL, sizeof eeprom, &text, &n, NULL) != LF_OK)
        return lf_error_set(err, LF_E_NODEV, path, "is not there (any more)");
    n = lf_model_hid_eeprom(text, n, eeprom, sizeof eeprom);
    lf_free(text);
    if (lf_model_hid_create(eeprom, n, NULL, &model) != LF_OK)
        abort();
    *out = (lf_hid_link){side_send, side_read, side_now, side_close, model};
    return LF_OK;
}

bool __wrap_lf_find_touches(dev_t device);
bool __wrap_lf_find_touches(dev_t device)
{
    (void)device;
    return has(TOUCHED);
}

/* ---------------------------------------------------------------------------------- its udev -- */

/* What is told of a device; texts that are empty are not told. */
typedef struct news {
    sd_device_action_t action;
    char subsystem[16], product[32], label[32], synth[8];
} news;

static struct {
    sd_event *event;
    sd_device_monitor_handler_t handler;
    void *context;
    news now;
} udev;

int __real_access(const char *path, int mode);
int __wrap_access(const char *path, int mode);
int __wrap_access(const char *path, int mode)
{
    return strcmp(path, "/run/udev/control") == 0 ? 0 : __real_access(path, mode);
}

int __wrap_sd_device_monitor_attach_event(sd_device_monitor *monitor, sd_event *event);
int __wrap_sd_device_monitor_attach_event(sd_device_monitor *monitor, sd_event *event)
{
    (void)monitor;
    udev.event = event;
    return 0;
}

static int on_news(sd_event_source *source, int fd, uint32_t events, void *context)
{
    (void)source;
    (void)events;
    (void)context;
    if (read(fd, &udev.now, sizeof udev.now) != (ssize_t)sizeof udev.now)
        abort();
    return udev.handler(NULL, NULL, udev.context);
}

int __wrap_sd_device_monitor_start(sd_device_monitor *monitor, sd_device_monitor_handler_t handler,
                                   void *context);
int __wrap_sd_device_monitor_start(sd_device_monitor *monitor, sd_device_monitor_handler_t handler,
                                   void *context)
{
    char path[PATH_MAX];
    (void)monitor;
    udev.handler = handler;
    udev.context = context;
    snprintf(path, sizeof path, "%s/" UDEV, world);
    int fd = open(path, O_RDWR | O_CLOEXEC); /* closed with the process */
    return sd_event_add_io(udev.event, NULL, fd, EPOLLIN, on_news, NULL);
}

int __wrap_sd_device_get_action(sd_device *device, sd_device_action_t *out);
int __wrap_sd_device_get_action(sd_device *device, sd_device_action_t *out)
{
    (void)device;
    *out = udev.now.action;
    return 0;
}

int __wrap_sd_device_get_subsystem(sd_device *device, const char **out);
int __wrap_sd_device_get_subsystem(sd_device *device, const char **out)
{
    (void)device;
    *out = udev.now.subsystem;
    return 0;
}

int __wrap_sd_device_get_devnum(sd_device *device, dev_t *out);
int __wrap_sd_device_get_devnum(sd_device *device, dev_t *out)
{
    (void)device;
    *out = 1;
    return 0;
}

int __wrap_sd_device_get_property_value(sd_device *device, const char *key, const char **out);
int __wrap_sd_device_get_property_value(sd_device *device, const char *key, const char **out)
{
    (void)device;
    *out = strcmp(key, "PRODUCT") == 0       ? udev.now.product
           : strcmp(key, "ID_FS_LABEL") == 0 ? udev.now.label
           : strcmp(key, "SYNTH_UUID") == 0  ? udev.now.synth
                                             : "";
    return (*out)[0] != '\0' ? 0 : -ENOENT;
}

/* -------------------------------------------------------------------------------- the daemon -- */

/* args: what start gives. */
static int run_server(char *args[])
{
    lf_server_config config = {
        .scene = args[2], .socket = args[3], .device = "auto", .export_dir = args[4]};
    snprintf(world, sizeof world, "%s", args[1]);
    setenv("CACHE_DIRECTORY", world, 1);
    unsetenv("DISPLAY");
    unsetenv("WAYLAND_DISPLAY");
    lf_log_init("quiltd", LF_LOG_INFO);
    lf_button_actions_default(&config.buttons);
    config.options.view_width = 24;
    config.options.view_height = 32;
    config.options.threads = 2;
    return lf_server_run(&config);
}

typedef struct bench {
    live l;
    live_client c;
} bench;

static const char *in_world(const bench *b, const char *name)
{
    char relative[64];
    snprintf(relative, sizeof relative, "sim/%s", name);
    return lf_test_path(b->l.folder, relative);
}

static void put(const bench *b, const char *name, const char *text)
{
    char relative[64];
    snprintf(relative, sizeof relative, "sim/%s", name);
    lf_test_write(b->l.folder, relative, text);
}

static void prepare(bench *b)
{
    live_prepare(&b->l);
    assert_int_equal(mkfifo(in_world(b, UDEV), 0600), 0);
}

/* A calibration for the display, of this serial number. */
static const char *lens(const char *serial, double center)
{
    static char text[512];
    snprintf(text, sizeof text,
             "{\"serial\":\"%s\",\"pitch\":52.5,\"slope\":-7.25,\"center\":%g,\"viewCone\":40,"
             "\"DPI\":324,\"screenW\":%d,"
             "\"screenH\":%d}",
             serial, center, WIDTH, HEIGHT);
    return text;
}

/* Puts it into the cache, as found for this display (NULL = for none that tells its name). */
static void remember(const bench *b, const char *serial, double center, const char *display_name)
{
    lf_found found = {.source = LF_SOURCE_HID, .label = "HoloPlay"};
    const char *text = lens(serial, center);
    setenv("CACHE_DIRECTORY", lf_test_path(b->l.folder, "sim"), 1);
    lf_assert_ok(lf_calibration_parse(text, strlen(text), "test", &found.calibration, NULL), NULL);
    if (display_name) {
        snprintf(found.display.name, sizeof found.display.name, "%s", display_name);
        snprintf(found.display.serial, sizeof found.display.serial, "1");
    }
    lf_cache_store(&found);
    unsetenv("CACHE_DIRECTORY");
}

static void start(bench *b)
{
    char folder[PATH_MAX];
    snprintf(folder, sizeof folder, "%s", lf_test_path(b->l.folder, "sim"));
    char *args[] = {
        (char *)(uintptr_t) "/proc/self/exe", folder, b->l.scene, b->l.socket, b->l.exports, NULL};
    b->l.pid = live_spawn(&b->l, args);
    live_connect(&b->l, &b->c);
}

static void finish(bench *b)
{
    live_close(&b->c);
    live_finish(&b->l);
}

static void tell(const bench *b, const news *n)
{
    int fd = open(in_world(b, UDEV), O_RDWR | O_CLOEXEC);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, n, sizeof *n), sizeof *n);
    close(fd);
}

/* Waits until the device's problem, kind … is this, or for "" anything. */
static void await_device(bench *b, const char *key, const char *expected)
{
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++) {
        json_t *answer = live_call(&b->c, "status", NULL);
        const json_t *device = json_object_get(json_object_get(answer, "result"), "device");
        const char *value = json_string_value(json_object_get(device, key));
        bool there = value && strstr(value, expected);
        json_decref(answer);
        if (there)
            return;
        live_nap(20);
    }
    live_show_log(&b->l);
    fail_msg("the device's %s never was \"%s\"", key, expected);
}

static void await_center(bench *b, double expected)
{
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++) {
        json_t *answer = live_call(&b->c, "device.calibration", NULL);
        const json_t *center = json_object_get(json_object_get(answer, "result"), "center");
        double value =
            json_number_value(json_is_object(center) ? json_object_get(center, "value") : center);
        json_decref(answer);
        if (value == expected)
            return;
        live_nap(20);
    }
    live_show_log(&b->l);
    fail_msg("the panel's calibration never was the one with center %g", expected);
}

static long opened(const bench *b)
{
    struct stat st;
    return stat(in_world(b, OPENED), &st) == 0 ? (long)st.st_size : 0;
}

/* ------------------------------------------------------------------------------------- tests -- */

/* udev has nothing to tell then: nothing is plugged in. */
static void a_panel_that_is_busy_at_the_start_is_taken_when_it_is_free(void **state)
{
    (void)state;
    bench b;
    prepare(&b);
    remember(&b, "LKG-A", 0.125, NAME);
    put(&b, DISPLAY, "");
    put(&b, BUSY, "");
    start(&b);
    await_device(&b, "problem", "another program has it");
    await_device(&b, "kind", "none");
    assert_int_equal(unlink(in_world(&b, BUSY)), 0);
    await_device(&b, "kind", "usb");
    await_center(&b, 0.125);
    finish(&b);
}

static const news plugged = {
    .action = SD_DEVICE_BIND, .subsystem = "usb", .product = "4d8/ef7e/100"};

/* And not looked for before: each time a panel's drive would be mounted anew. */
static void a_panel_without_a_calibration_is_taken_when_one_is_plugged_in(void **state)
{
    (void)state;
    bench b;
    prepare(&b);
    put(&b, DISPLAY, "");
    start(&b);
    await_device(&b, "problem", "no calibration was found");
    remember(&b, "LKG-A", 0.125, NAME);
    live_nap(1500); /* the first attempts of what is tried again come every 0.5 and 1 s */
    await_device(&b, "kind", "none");
    tell(&b, &plugged);
    await_device(&b, "kind", "usb");
    finish(&b);
}

static void what_udev_tells_of_a_panel_is_looked_for(void **state)
{
    static const news told[] = {
        {.action = SD_DEVICE_BIND, .subsystem = "usb", .product = "1d50/614d/100"},
        {.action = SD_DEVICE_CHANGE, .subsystem = "drm"},
        {.action = SD_DEVICE_ADD, .subsystem = "block", .label = "LKG-A"},
        /* mounted by the desktop, or by hand: what the user was asked to do */
        {.action = SD_DEVICE_CHANGE, .subsystem = "block", .label = "LKG-A", .synth = "0"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof told / sizeof *told; i++) {
        bench b;
        prepare(&b);
        remember(&b, "LKG-A", 0.125, NAME);
        start(&b);
        await_device(&b, "problem", "no panel was found");
        put(&b, DISPLAY, "");
        tell(&b, &told[i]);
        await_device(&b, "kind", "usb");
        finish(&b);
    }
}

/* After the last of them there is a display, which any search would find. */
static void what_is_no_news_leads_to_no_search(void **state)
{
    static const news told[] = {
        {.action = SD_DEVICE_REMOVE, .subsystem = "hidraw"},
        {.action = SD_DEVICE_BIND, .subsystem = "usb", .product = "46d/c52b/1201"},
        {.action = SD_DEVICE_ADD, .subsystem = "usb", .product = "1d50/614d/100"},
        /* the daemon's own mount */
        {.action = SD_DEVICE_CHANGE, .subsystem = "block", .label = "LKG-A", .synth = "0"},
    };
    (void)state;
    bench b;
    prepare(&b);
    remember(&b, "LKG-A", 0.125, NAME);
    put(&b, TOUCHED, "");
    start(&b);
    await_device(&b, "problem", "no panel was found");
    put(&b, DISPLAY, "");
    for (size_t i = 0; i < sizeof told / sizeof *told; i++)
        tell(&b, &told[i]);
    live_nap(1000); /* three times what a search waits for */
    assert_int_equal(opened(&b), 0);
    tell(&b, &(news){.action = SD_DEVICE_CHANGE, .subsystem = "block", .label = "LKG-A"});
    await_device(&b, "kind", "usb");
    finish(&b);
}

static void a_panel_gets_its_own_calibration_when_that_is_plugged_in(void **state)
{
    (void)state;
    bench b;
    prepare(&b);
    remember(&b, "LKG-A", 0.125, NAME);
    put(&b, DISPLAY, "");
    start(&b);
    await_center(&b, 0.125);
    put(&b, EEPROM, lens("LKG-A", 0.375));
    tell(&b, &plugged);
    await_center(&b, 0.375);
    await_device(&b, "calibration_from", "EEPROM");
    assert_int_equal(opened(&b), 2);
    finish(&b);
}

static void another_panels_calibration_does_not_interrupt_a_panel(void **state)
{
    (void)state;
    bench b;
    prepare(&b);
    remember(&b, "LKG-A", 0.125, NAME);
    put(&b, DISPLAY, "");
    start(&b);
    await_center(&b, 0.125);
    put(&b, EEPROM, lens("LKG-B", 0.5));
    for (int i = 0; i < 3; i++)
        tell(&b, &plugged);
    live_nap(1000);
    /* its own: that the others were looked at is seen by the one time that it is opened anew */
    put(&b, EEPROM, lens("LKG-A", 0.375));
    tell(&b, &plugged);
    await_center(&b, 0.375);
    assert_int_equal(opened(&b), 2);
    finish(&b);
}

/* The panel is opened anew for its own calibration, and cannot be: it is not given up. */
static void a_panel_that_cannot_be_opened_anew_is_tried_again(void **state)
{
    (void)state;
    bench b;
    prepare(&b);
    remember(&b, "LKG-A", 0.125, NAME);
    put(&b, DISPLAY, "");
    start(&b);
    await_center(&b, 0.125);
    put(&b, BUSY, "");
    put(&b, EEPROM, lens("LKG-A", 0.375));
    tell(&b, &plugged);
    await_device(&b, "problem", "another program has it");
    assert_int_equal(unlink(in_world(&b, BUSY)), 0);
    await_device(&b, "kind", "usb");
    await_center(&b, 0.375);
    finish(&b);
}

int main(int argc, char *argv[])
{
    if (argc > 1)
        return run_server(argv);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_panel_that_is_busy_at_the_start_is_taken_when_it_is_free),
        cmocka_unit_test(a_panel_without_a_calibration_is_taken_when_one_is_plugged_in),
        cmocka_unit_test(what_udev_tells_of_a_panel_is_looked_for),
        cmocka_unit_test(what_is_no_news_leads_to_no_search),
        cmocka_unit_test(a_panel_gets_its_own_calibration_when_that_is_plugged_in),
        cmocka_unit_test(another_panels_calibration_does_not_interrupt_a_panel),
        cmocka_unit_test(a_panel_that_cannot_be_opened_anew_is_tried_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
