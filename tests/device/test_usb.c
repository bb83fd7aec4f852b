/* The device usb over a simulated display in this process: the contract of device/device.h,
 * slowness, faults, unplugging. */
#include "tests/device/device_testing.h"
#include "tests/device/gud_testing.h"

#include <stdatomic.h>
#include <time.h>

#include "base/thread.h"
#include "device/device_table.h"
#include "device/model/usb_model.h"
#include "device/usb/usb.h"

enum { WIDTH = 96, HEIGHT = 128 };

static const lf_rect whole = {0, 0, WIDTH, HEIGHT};

static lf_calibration small_panel(void)
{
    lf_calibration c = device_lens(WIDTH, HEIGHT);
    strcpy(c.serial, "TEST\x1b-1");
    return c;
}

static lf_status try_open(lf_model_gud *gud, lf_device **out, lf_error *err)
{
    lf_calibration c = small_panel();
    lf_usb_place place = {.address = "9-1.2", .product = "a display"};
    lf_usb_link *link = lf_usb_model_open(gud);
    assert_non_null(link);
    return lf_usb_create(link, &place, &c, out, err);
}

static lf_device *open_usb(lf_model_gud *gud)
{
    lf_device *device = NULL;
    lf_error err = {0};
    lf_assert_ok(try_open(gud, &device, &err), &err);
    return device;
}

static lf_model_gud *small_model(const lf_model_gud_faults *faults)
{
    lf_model_gud_options o = gud_options(WIDTH, HEIGHT);
    o.max_buffer_size = WIDTH * 3 * 16;
    return gud_model(&o, faults);
}

static lf_image8 frame_of(uint64_t seed)
{
    lf_image8 frame = gud_frame(WIDTH, HEIGHT);
    uint64_t random = seed;
    gud_paint(&frame, whole, true, &random);
    return frame;
}

static lf_status push_seed(lf_device *device, uint64_t seed)
{
    lf_image8 frame = frame_of(seed);
    lf_status status = device->ops->push(device, &frame, &whole, 1, seed);
    lf_image8_finish(&frame);
    return status;
}

static lf_device_event show(lf_device *device, uint64_t seed)
{
    lf_assert_ok(push_seed(device, seed), NULL);
    return device_outcome(device);
}

static void end(lf_device *device, lf_model_gud *gud)
{
    lf_device_destroy(device);
    lf_model_gud_destroy(gud);
}

/* Call only when no push is under way: the model then belongs to this thread. */
static bool shows(const lf_model_gud *gud, uint64_t seed)
{
    lf_image8 frame = frame_of(seed);
    int differences = gud_differences(gud, &frame, whole, LF_GUD_RGB888);
    lf_image8_finish(&frame);
    return differences == 0;
}

static void a_push_shows_and_is_counted(void **state)
{
    (void)state;
    lf_model_gud *gud = small_model(NULL);
    lf_device *device = open_usb(gud);
    assert_int_equal(device->ops->dispatch(device), LF_DEVICE_READY);
    assert_false(device_rings(device, 0));
    assert_false(lf_model_gud_lit(gud));
    assert_int_equal(show(device, 1), LF_DEVICE_READY);
    assert_false(device_rings(device, 0));
    assert_true(lf_model_gud_lit(gud));
    assert_true(shows(gud, 1));
    assert_false(shows(gud, 2));
    assert_int_equal(device_counters_of(device).updates, 1);
    assert_int_equal(device_counters_of(device).bytes, WIDTH * HEIGHT * 3);
    assert_int_equal(show(device, 1), LF_DEVICE_READY); /* nothing new */
    assert_int_equal(device_counters_of(device).updates, 2);
    assert_int_equal(device_counters_of(device).bytes, WIDTH * HEIGHT * 3);
    lf_device_destroy(device);
    assert_false(lf_model_gud_lit(gud)); /* given back dark */
    lf_model_gud_destroy(gud);
}

static void info_says_what_it_is(void **state)
{
    (void)state;
    lf_model_gud *gud = small_model(NULL);
    lf_device *device = open_usb(gud);
    lf_device_info info = device_info_of(device);
    assert_string_equal(info.spec, "usb:9-1.2");
    assert_string_equal(info.kind, "usb");
    assert_string_equal(info.model, "a display");
    assert_string_equal(info.serial, "TEST?-1");
    assert_string_equal(info.output, "USB 9-1.2, RGB888");
    assert_string_equal(info.problem, "");
    assert_true(info.calibration_from[0] != 0);
    assert_int_equal(device->ops->calibration(device)->screen_width_px, WIDTH);
    end(device, gud);
}

static void bad_pushes_are_refused_and_leave_it_ready(void **state)
{
    (void)state;
    lf_model_gud *gud = small_model(NULL);
    lf_device *device = open_usb(gud);
    lf_image8 frame = frame_of(1);
    device_refuses_bad_pushes(device, &frame);
    lf_image8_finish(&frame);
    end(device, gud);
}

/* 36 KB at 50 KB/s: the first push is under way for 0.7 s, those after it are refused at once, and
 * the newest frame is what stays. */
static void a_slow_display_refuses_at_once_and_gets_the_newest(void **state)
{
    (void)state;
    lf_model_gud *gud = small_model(&(lf_model_gud_faults){.bytes_per_s = 50000});
    lf_device *device = open_usb(gud);
    uint64_t seed = 1;
    lf_assert_ok(push_seed(device, seed), NULL);
    while (seed < 4)
        lf_assert_status(push_seed(device, ++seed), LF_E_STATE, NULL);
    assert_int_equal(device_outcome(device), LF_DEVICE_READY);
    assert_true(shows(gud, 1));
    lf_assert_ok(push_seed(device, seed), NULL);
    lf_assert_status(device->ops->flush(device, 1), LF_E_TIMEOUT, NULL);
    lf_assert_ok(device->ops->flush(device, DEVICE_WAIT_MS), NULL);
    assert_int_equal(device_outcome(device), LF_DEVICE_READY);
    assert_true(shows(gud, seed));
    assert_int_equal(device_counters_of(device).updates, 2);
    end(device, gud);
}

static void a_failure_is_told_once_and_the_next_whole_push_mends_it(void **state)
{
    (void)state;
    lf_model_gud *gud = small_model(&(lf_model_gud_faults){.stall_every = 11, .fail_every = 6});
    lf_device *device = open_usb(gud);
    int failures = 0;
    for (uint64_t seed = 1; seed <= 20; seed++) {
        lf_device_event event;
        do {
            event = show(device, seed);
            if (event == LF_DEVICE_RETRY) {
                failures++;
                assert_int_equal(device->ops->dispatch(device), LF_DEVICE_READY);
                assert_non_null(strstr(device_info_of(device).problem, "refused"));
            }
        } while (event == LF_DEVICE_RETRY);
        assert_int_equal(event, LF_DEVICE_READY);
        assert_true(shows(gud, seed));
        assert_string_equal(device_info_of(device).problem, "");
    }
    assert_true(failures > 5);
    assert_int_equal(device_counters_of(device).errors, failures);
    assert_int_equal(device_counters_of(device).updates, 20);
    end(device, gud);
}

static void a_display_that_never_takes_anything_fails_without_spinning(void **state)
{
    (void)state;
    lf_model_gud *gud = small_model(&(lf_model_gud_faults){.stall_every = 1});
    lf_device *device = open_usb(gud);
    for (uint64_t seed = 1; seed <= 5; seed++)
        assert_int_equal(show(device, seed), LF_DEVICE_RETRY);
    assert_int_equal(device_counters_of(device).errors, 5);
    assert_int_equal(device_counters_of(device).bytes, 0);
    end(device, gud);
}

static void unplugging_in_a_stream_ends_it_and_it_can_be_opened_again(void **state)
{
    (void)state;
    lf_model_gud *gud = small_model(&(lf_model_gud_faults){.unplug_after = 20});
    lf_device *device = open_usb(gud);
    lf_device *second = NULL;
    lf_error err = {0};
    uint64_t seed = 1;
    lf_device_event event = LF_DEVICE_READY;
    for (; event == LF_DEVICE_READY && seed < 100; seed++)
        event = show(device, seed);
    assert_int_equal(event, LF_DEVICE_GONE);
    assert_int_equal(seed, 4); /* 8 bands a push */
    assert_int_equal(device->ops->dispatch(device), LF_DEVICE_GONE);
    lf_assert_status(push_seed(device, 1), LF_E_NODEV, NULL);
    lf_assert_status(device->ops->flush(device, 10), LF_E_NODEV, NULL);
    assert_string_equal(device_info_of(device).problem, "unplugged");
    lf_device_destroy(device);
    lf_assert_status(try_open(gud, &second, &err), LF_E_NODEV, &err);
    assert_null(second);
    lf_model_gud_destroy(gud);
    gud = small_model(NULL);
    device = open_usb(gud);
    assert_int_equal(show(device, 7), LF_DEVICE_READY);
    assert_true(shows(gud, 7));
    end(device, gud);
}

static void unplugging_is_seen_without_a_push(void **state)
{
    (void)state;
    lf_model_gud *gud = small_model(&(lf_model_gud_faults){.unplug_after = 8});
    lf_device *device = open_usb(gud);
    assert_int_equal(show(device, 1), LF_DEVICE_READY);
    assert_int_equal(device_outcome(device), LF_DEVICE_GONE);
    end(device, gud);
}

/* A link to a display that answers, but on which a transfer ends by being cancelled and in no other
 * way. */
typedef struct stuck_link {
    lf_usb_link base;
    lf_usb_link *answers;
    atomic_bool cancelled;
} stuck_link;

static stuck_link *stuck_of(lf_usb_link *link)
{
    return (stuck_link *)(void *)link;
}

static lf_usb_result stuck_control(lf_usb_link *link, bool in, uint8_t request, uint16_t value,
                                   uint8_t *data, size_t n, size_t *out_n, int timeout_ms)
{
    lf_usb_link *answers = stuck_of(link)->answers;
    return answers->ops->control(answers, in, request, value, data, n, out_n, timeout_ms);
}

static void stuck_bulk_begin(lf_usb_link *link, const uint8_t *data, size_t n)
{
    (void)link;
    (void)data;
    (void)n;
}

static lf_usb_result stuck_bulk_end(lf_usb_link *link, int timeout_ms)
{
    (void)timeout_ms;
    while (!atomic_load(&stuck_of(link)->cancelled))
        usleep(1000);
    return LF_USB_CANCELLED;
}

static void stuck_cancel(lf_usb_link *link)
{
    lf_usb_link *answers = stuck_of(link)->answers;
    atomic_store(&stuck_of(link)->cancelled, true);
    answers->ops->cancel(answers);
}

static void stuck_close(lf_usb_link *link)
{
    lf_usb_link *answers = stuck_of(link)->answers;
    answers->ops->close(answers);
}

/* Without a cancel this never ends. */
static void destroying_does_not_wait_for_a_display_that_hangs(void **state)
{
    (void)state;
    static const lf_usb_link_ops ops = {stuck_control, stuck_bulk_begin, stuck_bulk_end,
                                        stuck_cancel, stuck_close};
    lf_model_gud *gud = small_model(NULL);
    lf_calibration c = small_panel();
    lf_usb_place place = {.address = "9-1.2", .product = "a display"};
    stuck_link stuck = {.base.ops = &ops, .answers = lf_usb_model_open(gud)};
    assert_non_null(stuck.answers);
    lf_device *device = NULL;
    lf_assert_ok(lf_usb_create(&stuck.base, &place, &c, &device, NULL), NULL);
    lf_assert_ok(push_seed(device, 1), NULL);
    lf_assert_status(device->ops->flush(device, 50), LF_E_TIMEOUT, NULL);
    lf_device_destroy(device);
    assert_true(atomic_load(&stuck.cancelled));
    assert_int_equal(gud_counters(gud).bytes, 0);
    lf_model_gud_destroy(gud);
}

static void opens_that_fail_keep_nothing(void **state)
{
    (void)state;
    for (int fault = LF_GUD_HONEST + 1; fault < LF_GUD_BAD_STATUS; fault++) {
        lf_model_gud *gud = small_model(&(lf_model_gud_faults){.fault = fault});
        lf_device *device = NULL;
        lf_error err = {0};
        lf_assert_status(try_open(gud, &device, &err), LF_E_IO, &err);
        assert_null(device);
        lf_model_gud_destroy(gud);
    }
    lf_model_gud_options o = gud_options(WIDTH + 1, HEIGHT);
    lf_model_gud *other = gud_model(&o, NULL);
    lf_device *device = NULL;
    lf_error err = {0};
    lf_assert_status(try_open(other, &device, &err), LF_E_ARG, &err);
    lf_usb_place place = {.address = "9-1"};
    lf_assert_status(lf_usb_create(lf_usb_model_open(other), &place, NULL, &device, &err),
                     LF_E_NODEV, &err);
    assert_non_null(strstr(err.what, "calibration"));
    lf_model_gud_destroy(other);
}

static void addresses_are_checked_before_anything_is_touched(void **state)
{
    (void)state;
    const char *bad[] = {
        "1",      "1-",  "-1", "1-2.", "1-2-3", "1.2", "x", "1-2,x", "1-1.1.1.1.1.1.1.1.1",
        "1-9999", " 1-2"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char spec[64];
        lf_device *device = NULL;
        lf_error err = {0};
        snprintf(spec, sizeof spec, "usb:%s", bad[i]);
        lf_assert_status(lf_device_open(spec, NULL, &device, &err), LF_E_ARG, &err);
    }
    lf_device *device = NULL;
    lf_error err = {0};
    lf_assert_status(lf_device_open("usb:199-7.7", NULL, &device, &err), LF_E_NODEV, &err);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_push_shows_and_is_counted),
        cmocka_unit_test(info_says_what_it_is),
        cmocka_unit_test(bad_pushes_are_refused_and_leave_it_ready),
        cmocka_unit_test(a_slow_display_refuses_at_once_and_gets_the_newest),
        cmocka_unit_test(a_failure_is_told_once_and_the_next_whole_push_mends_it),
        cmocka_unit_test(a_display_that_never_takes_anything_fails_without_spinning),
        cmocka_unit_test(unplugging_in_a_stream_ends_it_and_it_can_be_opened_again),
        cmocka_unit_test(unplugging_is_seen_without_a_push),
        cmocka_unit_test(destroying_does_not_wait_for_a_display_that_hangs),
        cmocka_unit_test(opens_that_fail_keep_nothing),
        cmocka_unit_test(addresses_are_checked_before_anything_is_touched),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
