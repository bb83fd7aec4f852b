/* The link to real HID devices over the unmodified hidapi, with devices of umockdev: which ones are
 * taken for panels, and that what is sent reaches the device as the protocol wants it. umockdev
 * does not deliver input reports: the kernel's own path (make check-kernel) has those. */
#include "tests/testing.h"

#include <dlfcn.h>
#include <errno.h>
#include <linux/hidraw.h>
#include <sys/ioctl.h>
#include <umockdev.h>

#include "device/find/find.h"
#include "device/hid/hid.h"
#include "device/model/model.h"

#define PRELOAD "libumockdev-preload.so.0"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { SANITIZED = 1 };
#else
enum { SANITIZED = 0 };
#endif

/* Plugs in a USB device with one HID interface, described as umockdev-record does. */
static void plug_in(UMockdevTestbed *testbed, int number, unsigned vendor, unsigned product,
                    const char *name)
{
    char usb[64], hid[64], text[4096];
    GError *error = NULL;
    snprintf(usb, sizeof usb, "/devices/pci0000:00/usb1/1-%d", number);
    snprintf(hid, sizeof hid, "0003:%04X:%04X.%04X", vendor, product, (unsigned)number);
    snprintf(
        text, sizeof text,
        "P: %s\nN: bus/usb/001/%03d\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nA: "
        "idVendor=%04x\\n\nA: idProduct=%04x\\n\n"
        "A: manufacturer=Looking Glass Factory\\n\nA: product=%s\\n\nA: serial=C\\n\n\n"
        "P: %s/1-%d:1.0\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_interface\nA: bInterfaceNumber=02\\n\n\n"
        "P: %s/1-%d:1.0/%s\nE: SUBSYSTEM=hid\nE: HID_ID=0003:0000%04X:0000%04X\nE: HID_NAME=%s\nE: "
        "HID_UNIQ=C\n\n"
        "P: %s/1-%d:1.0/%s/hidraw/hidraw%d\nN: hidraw%d\nE: SUBSYSTEM=hidraw\nE: "
        "DEVNAME=/dev/hidraw%d\nL: device=../../../%s\n\n",
        usb, number, vendor, product, name, usb, number, usb, number, hid, vendor, product, name,
        usb, number, hid, number, number, number, hid);
    if (!umockdev_testbed_add_from_string(testbed, text, &error))
        fail_msg("umockdev: %s", error->message);
}

static int make_testbed(void **state)
{
    *state = umockdev_testbed_new();
    return 0;
}

static int remove_testbed(void **state)
{
    g_object_unref(*state);
    return 0;
}

static void only_panels_are_taken_for_panels(void **state)
{
    lf_hid_place places[8];
    assert_int_equal(lf_hid_list(places, 8), 0);
    plug_in(*state, 1, 0x04d8, 0xef7e, "HoloPlay");
    plug_in(*state, 2, 0x04d8, 0xef7e, "A thermometer");
    plug_in(*state, 3, 0x04d8, 0x1234, "HoloPlay");
    plug_in(*state, 4, 0x1234, 0xef7e, "HoloPlay");
    plug_in(*state, 5, 0x04d8, 0xef7e, "HoloPlay \x1b[2J");
    assert_int_equal(lf_hid_list(places, 8), 2);
    int second = strcmp(places[0].path, "/dev/hidraw1") == 0;
    assert_string_equal(places[!second].path, "/dev/hidraw1");
    assert_string_equal(places[!second].product, "HoloPlay");
    assert_string_equal(places[second].path, "/dev/hidraw5");
    assert_string_equal(places[second].product, "HoloPlay ?[2J");
    assert_int_equal(lf_hid_list(places, 1), 1);
}

/* Runs in umockdev's thread, one call at a time. */
static gboolean answer(UMockdevIoctlBase *base, UMockdevIoctlClient *client, void *data)
{
    (void)base;
    lf_model_hid *model = data;
    unsigned long request = umockdev_ioctl_client_get_request(client);
    size_t size = _IOC_SIZE(request);
    UMockdevIoctlData *memory =
        umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, size, NULL);
    if (request == HIDIOCGRDESCSIZE) {
        int none = 0;
        umockdev_ioctl_data_update(memory, 0, (guint8 *)&none, sizeof none);
        umockdev_ioctl_client_complete(client, 0, 0);
    } else if (_IOC_NR(request) == _IOC_NR(HIDIOCSFEATURE(0))) {
        guint8 *report = NULL;
        int n = 0;
        umockdev_ioctl_data_retrieve(memory, &report, &n);
        int r = n > 0 && report[0] == 0 ? lf_model_hid_feature(model, report + 1, (size_t)n - 1)
                                        : -EPIPE;
        umockdev_ioctl_client_complete(client, r < 0 ? -1 : n, r < 0 ? -r : 0);
        g_free(report);
    } else {
        umockdev_ioctl_client_complete(client, 0, 0);
    }
    g_object_unref(memory);
    return TRUE;
}

static void a_request_reaches_the_device_and_a_missing_reply_ends(void **state)
{
    static const char json[] = "{}";
    uint8_t eeprom[64], reply[LF_MODEL_INPUT];
    lf_model_hid *model = NULL;
    size_t n = lf_model_hid_eeprom(json, strlen(json), eeprom, sizeof eeprom);
    lf_assert_ok(lf_model_hid_create(eeprom, n, NULL, &model), NULL);
    plug_in(*state, 1, 0x04d8, 0xef7e, "HoloPlay");
    UMockdevIoctlBase *handler = umockdev_ioctl_base_new();
    g_signal_connect(handler, "handle-ioctl", G_CALLBACK(answer), model);
    assert_true(umockdev_testbed_attach_ioctl(*state, "/dev/hidraw1", handler, NULL));
    lf_hid_link link = {0};
    lf_error err = {0};
    lf_assert_ok(lf_hid_open("/dev/hidraw1", &link, &err), &err);
    lf_hid_patience patience = {.reply_ms = 20, .rest_ms = 1, .attempts = 2, .total_ms = 100};
    lf_calibration c;
    lf_assert_status(lf_hid_read_calibration(&link, &patience, "/dev/hidraw1", &c, &err),
                     LF_E_TIMEOUT, &err);
    lf_hid_close(&link);
    for (int i = 0; i < patience.attempts; i++) {
        assert_int_equal(lf_model_hid_input(model, reply, sizeof reply), LF_MODEL_INPUT);
        assert_memory_equal(reply + 4, eeprom, n);
    }
    assert_true(lf_model_hid_input(model, reply, sizeof reply) < 0);
    assert_int_equal(lf_model_hid_violations(model), 0);
    umockdev_testbed_detach_ioctl(*state, "/dev/hidraw1", NULL);
    g_object_unref(handler);
    lf_model_hid_destroy(model);
}

static bool preloaded(void)
{
    return dlopen(PRELOAD, RTLD_LAZY | RTLD_NOLOAD);
}

static void a_panel_that_cannot_be_read_is_told_with_its_problem(void **state)
{
    lf_found found[8];
    setenv("CACHE_DIRECTORY", "/nonexistent", 1);
    int before = lf_find_all(found, 8);
    plug_in(*state, 1, 0x04d8, 0xef7e, "HoloPlay");
    assert_int_equal(lf_find_all(found, 8), before + 1);
    assert_int_equal(found[0].source, LF_SOURCE_HID);
    assert_string_equal(found[0].path, "/dev/hidraw1");
    assert_string_equal(found[0].label, "HoloPlay");
    assert_non_null(strstr(found[0].problem, "cannot be opened"));
    unsetenv("CACHE_DIRECTORY");
}

#define test(name) cmocka_unit_test_setup_teardown(name, make_testbed, remove_testbed)

int main(int argc, char **argv)
{
    (void)argc;
    const struct CMUnitTest tests[] = {
        test(only_panels_are_taken_for_panels),
        test(a_panel_that_cannot_be_read_is_told_with_its_problem),
        test(a_request_reaches_the_device_and_a_missing_reply_ends),
    };
    if (SANITIZED) {
        printf("umockdev's preloaded library and the sanitizers' do not go together\n");
        return 77;
    }
    if (!preloaded() && !getenv("LD_PRELOAD")) {
        setenv("LD_PRELOAD", PRELOAD, 1);
        execv("/proc/self/exe", argv);
    }
    if (!preloaded()) {
        printf("%s cannot be preloaded\n", PRELOAD);
        return 77;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
