/* The simulated device as a USB device: descriptors, standard and class requests, endpoints that
 * halt. */
#include "tests/testing.h"

#include <errno.h>

#include "device/find/edid.h"
#include "device/model/usb_model.h"
#include "device/usb/gud.h"

enum {
    IN_DEVICE = 0x80,
    IN_INTERFACE = 0x81,
    IN_ENDPOINT = 0x82,
    OUT_ENDPOINT = 0x02,
    OUT_HID = 0x21,
    IN_HID = 0xa1,
    IN_GUD = 0xc1,
    OUT_GUD = 0x41
};
enum { WIDTH = 16, HEIGHT = 8 };

typedef struct panel {
    lf_model_hid *hid;
    lf_model_gud *gud;
    lf_model *model;
} panel;

static panel make_panel(bool hid, bool display, const lf_model_gud_faults *faults)
{
    static const uint8_t rgb888 = LF_GUD_RGB888;
    const lf_model_gud_options options = {.width = WIDTH,
                                          .height = HEIGHT,
                                          .formats = &rgb888,
                                          .n_formats = 1,
                                          .status_on_set = true};
    panel p = {0};
    if (hid)
        lf_assert_ok(lf_model_hid_create("\0\0\0\2{}", 6, NULL, &p.hid), NULL);
    if (display)
        lf_assert_ok(lf_model_gud_create(&options, faults, &p.gud), NULL);
    lf_assert_ok(lf_model_create(p.hid, p.gud, &p.model), NULL);
    return p;
}

static void drop_panel(panel *p)
{
    lf_model_destroy(p->model);
    lf_model_gud_destroy(p->gud);
    lf_model_hid_destroy(p->hid);
}

static int request(panel *p, unsigned type, unsigned code, unsigned value, unsigned index,
                   void *data, size_t n)
{
    const uint8_t setup[8] = {
        (uint8_t)type,  (uint8_t)code,         (uint8_t)value, (uint8_t)(value >> 8),
        (uint8_t)index, (uint8_t)(index >> 8), (uint8_t)n,     (uint8_t)(n >> 8)};
    return lf_model_control(p->model, setup, data, n);
}

static void the_device_says_who_it_is(void **state)
{
    (void)state;
    for (int kind = 1; kind < 4; kind++) {
        panel p = make_panel(kind & 1, kind & 2, NULL);
        uint8_t d[64] = {0};
        assert_int_equal(request(&p, IN_DEVICE, 6, 0x0100, 0, d, sizeof d), 18);
        assert_int_equal(d[8] | d[9] << 8, kind & 1 ? 0x04d8 : 0x1d50);
        assert_int_equal(d[10] | d[11] << 8, kind & 1 ? 0xef7e : 0x614d);
        assert_int_equal(request(&p, IN_DEVICE, 6, 0x0300, 0, d, sizeof d), 4);
        int n = request(&p, IN_DEVICE, 6, 0x0302, 0x0409, d, sizeof d);
        assert_int_equal(n, d[0]);
        assert_int_equal(d[2], kind & 1 ? 'H' : 'L');
        assert_int_equal(request(&p, IN_DEVICE, 6, 0x0304, 0x0409, d, sizeof d), -EPIPE);
        drop_panel(&p);
    }
}

/* Every descriptor lies within the total length, and there are as many interfaces and endpoints as
 * are told. */
static void the_configuration_is_consistent(void **state)
{
    (void)state;
    for (int kind = 1; kind < 4; kind++) {
        panel p = make_panel(kind & 1, kind & 2, NULL);
        uint8_t c[256] = {0};
        int n = request(&p, IN_DEVICE, 6, 0x0200, 0, c, sizeof c), interfaces = 0, endpoints = 0,
            told = 0, at = 0;
        assert_int_equal(n, c[2] | c[3] << 8);
        for (; at < n && c[at] >= 2; at += c[at]) {
            interfaces += c[at + 1] == 4;
            told += c[at + 1] == 4 ? c[at + 4] : 0;
            endpoints += c[at + 1] == 5;
        }
        assert_int_equal(at, n);
        assert_int_equal(interfaces, c[4]);
        assert_int_equal(interfaces, (kind & 1) + (kind >> 1));
        assert_int_equal(endpoints, told);
        drop_panel(&p);
    }
}

static void a_short_question_gets_a_short_answer(void **state)
{
    (void)state;
    panel p = make_panel(true, true, NULL);
    uint8_t d[64];
    memset(d, 0xee, sizeof d);
    assert_int_equal(request(&p, IN_DEVICE, 6, 0x0200, 0, d, 9), 9);
    assert_int_equal(d[9], 0xee);
    assert_int_equal(request(&p, IN_DEVICE, 6, 0x0200, 0, d, 0), 0);
    drop_panel(&p);
}

/* The lengths of the report descriptor: what the kernel makes buffers of. */
static void reports_have_the_lengths_of_the_panel(void **state)
{
    (void)state;
    panel p = make_panel(true, true, NULL);
    uint8_t d[256];
    int n = request(&p, IN_INTERFACE, 6, 0x2200, 0, d, sizeof d), count = 0, input = 0, feature = 0;
    for (int i = 0; i < n; i += 1 + (d[i] & 3)) {
        count = (d[i] & 0xfc) == 0x94 ? d[i + 1] : count;
        input += (d[i] & 0xfc) == 0x80 ? count : 0;
        feature += (d[i] & 0xfc) == 0xb0 ? count : 0;
        assert_int_not_equal(d[i] & 0xfc, 0x84); /* no report numbers */
    }
    assert_int_equal(input, LF_MODEL_INPUT);
    assert_int_equal(feature, LF_MODEL_FEATURE);
    uint8_t h[9];
    assert_int_equal(request(&p, IN_INTERFACE, 6, 0x2100, 0, h, sizeof h), 9);
    assert_int_equal(h[7] | h[8] << 8, n);
    assert_int_equal(request(&p, IN_INTERFACE, 6, 0x2200, 1, d, sizeof d), -EPIPE);
    drop_panel(&p);
}

static void a_page_is_asked_by_feature_and_comes_by_interrupt(void **state)
{
    (void)state;
    panel p = make_panel(true, false, NULL);
    uint8_t page[LF_MODEL_FEATURE] = {0}, report[LF_MODEL_INPUT];
    assert_int_equal(lf_model_transfer(p.model, LF_MODEL_HID_ENDPOINT, report, sizeof report),
                     -EAGAIN);
    assert_int_equal(request(&p, OUT_HID, 9, 0x0300, 0, page, sizeof page), LF_MODEL_FEATURE);
    assert_int_equal(lf_model_transfer(p.model, LF_MODEL_HID_ENDPOINT, report, sizeof report),
                     LF_MODEL_INPUT);
    assert_memory_equal(report + 4, "\0\0\0\2{}", 6);
    assert_int_equal(lf_model_hid_violations(p.hid), 0);
    drop_panel(&p);
}

static void idle_is_kept(void **state)
{
    (void)state;
    panel p = make_panel(true, false, NULL);
    uint8_t idle = 9;
    assert_int_equal(request(&p, OUT_HID, 10, 0x0500, 0, NULL, 0), 0);
    assert_int_equal(request(&p, IN_HID, 2, 0, 0, &idle, 1), 1);
    assert_int_equal(idle, 5);
    drop_panel(&p);
}

static void what_it_does_not_know_is_refused(void **state)
{
    (void)state;
    panel p = make_panel(true, true, NULL);
    uint8_t d[64] = {0};
    assert_int_equal(request(&p, IN_HID, 1, 0x0300, 0, d, sizeof d), -EPIPE); /* GET_REPORT */
    /* an output report */
    assert_int_equal(request(&p, OUT_HID, 9, 0x0200, 0, d, sizeof d), -EPIPE);
    /* of the display's interface */
    assert_int_equal(request(&p, OUT_HID, 9, 0x0300, 1, d, sizeof d), -EPIPE);
    /* of the panel's interface */
    assert_int_equal(request(&p, IN_GUD, 1, 0, 0, d, 30), -EPIPE);
    assert_int_equal(request(&p, IN_DEVICE, 6, 0x0f00, 0, d, sizeof d), -EPIPE);
    assert_int_equal(request(&p, 0, 9, 2, 0, NULL, 0), -EPIPE);
    assert_int_equal(request(&p, IN_INTERFACE, 0, 0, 2, d, 2), -EPIPE);
    assert_int_equal(request(&p, IN_ENDPOINT, 0, 0, 0x83, d, 2), -EPIPE);
    assert_int_equal(request(&p, 0xff, 0, 0, 0, d, 2), -EPIPE);
    assert_int_equal(lf_model_transfer(p.model, 0x83, d, sizeof d), -EPIPE);
    assert_int_equal(lf_model_hid_violations(p.hid), 0);
    drop_panel(&p);
}

static void the_configuration_is_kept(void **state)
{
    (void)state;
    panel p = make_panel(false, true, NULL);
    uint8_t d[2] = {7, 7};
    assert_int_equal(request(&p, 0, 9, 1, 0, NULL, 0), 0);
    assert_int_equal(request(&p, IN_DEVICE, 8, 0, 0, d, 1), 1);
    assert_int_equal(d[0], 1);
    assert_int_equal(request(&p, 0x01, 11, 0, 0, NULL, 0), 0);
    assert_int_equal(request(&p, 0x01, 11, 1, 0, NULL, 0), -EPIPE);
    assert_int_equal(request(&p, IN_INTERFACE, 10, 0, 0, d, 1), 1);
    assert_int_equal(d[0], 0);
    drop_panel(&p);
}

static void the_display_is_asked_on_its_interface(void **state)
{
    (void)state;
    for (unsigned hid = 0; hid < 2; hid++) {
        panel p = make_panel(hid, true, NULL);
        uint8_t d[30];
        assert_int_equal(request(&p, IN_GUD, 1, 0, hid, d, sizeof d), 30);
        assert_int_equal(d[0], 0x4d);
        drop_panel(&p);
    }
}

/* Data that nobody announced is refused, and then everything until the host clears the halt. */
static void a_refused_transfer_halts_its_endpoint(void **state)
{
    (void)state;
    panel p = make_panel(true, true, NULL);
    uint8_t data[4] = {0}, status[2] = {9, 9};
    assert_int_equal(lf_model_transfer(p.model, LF_MODEL_GUD_ENDPOINT, data, sizeof data), -EPIPE);
    assert_int_equal(request(&p, IN_ENDPOINT, 0, 0, LF_MODEL_GUD_ENDPOINT, status, 2), 2);
    assert_int_equal(status[0], 1);
    assert_int_equal(request(&p, IN_ENDPOINT, 0, 0, LF_MODEL_HID_ENDPOINT, status, 2), 2);
    assert_int_equal(status[0], 0);
    lf_model_gud_counters before, after;
    lf_model_gud_counters_get(p.gud, &before);
    assert_int_equal(lf_model_transfer(p.model, LF_MODEL_GUD_ENDPOINT, data, sizeof data), -EPIPE);
    lf_model_gud_counters_get(p.gud, &after);
    assert_int_equal(before.refused, after.refused); /* the display was not asked */
    assert_int_equal(request(&p, OUT_ENDPOINT, 1, 0, LF_MODEL_GUD_ENDPOINT, NULL, 0), 0);
    assert_int_equal(request(&p, IN_ENDPOINT, 0, 0, LF_MODEL_GUD_ENDPOINT, status, 2), 2);
    assert_int_equal(status[0], 0);
    drop_panel(&p);
}

static void its_edid_is_read_as_it_was_made(void **state)
{
    (void)state;
    uint8_t bytes[128];
    lf_edid edid;
    lf_error err;
    lf_model_edid("LKG-P00655", "P00655-and-what-is-cut", 1536, 2048, bytes);
    lf_assert_ok(lf_edid_parse(bytes, sizeof bytes, &edid, &err), &err);
    assert_string_equal(edid.name, "LKG-P00655");
    assert_string_equal(edid.serial, "P00655-and-wh");
    assert_int_equal(edid.width_px, 1536);
    assert_int_equal(edid.height_px, 2048);
    assert_true(lf_edid_is_panel(&edid));
    lf_model_edid("LKG", "1", 7680, 4320, bytes);
    lf_assert_ok(lf_edid_parse(bytes, sizeof bytes, &edid, &err), &err);
    assert_int_equal(edid.width_px, 0);
    bytes[60] ^= 1;
    lf_assert_status(lf_edid_parse(bytes, sizeof bytes, &edid, &err), LF_E_FORMAT, &err);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_device_says_who_it_is),
        cmocka_unit_test(the_configuration_is_consistent),
        cmocka_unit_test(a_short_question_gets_a_short_answer),
        cmocka_unit_test(reports_have_the_lengths_of_the_panel),
        cmocka_unit_test(a_page_is_asked_by_feature_and_comes_by_interrupt),
        cmocka_unit_test(idle_is_kept),
        cmocka_unit_test(what_it_does_not_know_is_refused),
        cmocka_unit_test(the_configuration_is_kept),
        cmocka_unit_test(the_display_is_asked_on_its_interface),
        cmocka_unit_test(a_refused_transfer_halts_its_endpoint),
        cmocka_unit_test(its_edid_is_read_as_it_was_made),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
