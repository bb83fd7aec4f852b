/* What the tests of devices share: waiting for them as the daemon does, on their descriptor. */
#ifndef LF_TESTS_DEVICE_TESTING_H
#define LF_TESTS_DEVICE_TESTING_H

#include "tests/testing.h"

#include <poll.h>

#include "device/device.h"

/* Longer than any machine takes: whoever waits as long has found a fault. */
enum { DEVICE_WAIT_MS = 20000 };

static inline bool device_rings(const lf_device *device, int timeout_ms)
{
    struct pollfd p = {.fd = device->ops->poll_fd(device), .events = POLLIN};
    return poll(&p, 1, timeout_ms) == 1;
}

/* Waits until the push under way has ended, and says how: LF_DEVICE_BUSY = it has not. */
static inline lf_device_event device_outcome(lf_device *device)
{
    while (device_rings(device, DEVICE_WAIT_MS)) {
        lf_device_event event = device->ops->dispatch(device);
        if (event != LF_DEVICE_BUSY)
            return event;
    }
    return LF_DEVICE_BUSY;
}

/* One push to its end. */
static inline lf_device_event device_push(lf_device *device, const lf_image8 *frame,
                                          const lf_rect *rects, int n)
{
    lf_assert_ok(device->ops->push(device, frame, rects, n, 1), NULL);
    return device_outcome(device);
}

/* One of that many pixels, else a Portrait's. */
static inline lf_calibration device_lens(int width, int height)
{
    lf_calibration c;
    lf_calibration_portrait(&c);
    c.screen_width_px = width;
    c.screen_height_px = height;
    return c;
}

static inline lf_device_counters device_counters_of(const lf_device *device)
{
    lf_device_counters counters;
    device->ops->counters(device, &counters);
    return counters;
}

/* Every push that cannot be is refused, whatever is wrong with it; afterwards the device takes one
 * of nothing, and has shown nothing. frame is of its shape. */
static inline void device_refuses_bad_pushes(lf_device *device, const lf_image8 *frame)
{
    int w = frame->width, h = frame->height;
    const lf_rect whole = {0, 0, w, h}, bad[] = {{-1, 0, 2, 2},
                                                 {0, -1, 2, 2},
                                                 {0, 0, 0, 2},
                                                 {0, 0, 2, 0},
                                                 {0, 0, w + 1, 1},
                                                 {w - 1, 0, 2, 1},
                                                 {w, 0, 1, 1},
                                                 {0, h, 1, 1},
                                                 {INT_MAX, 0, 1, 1},
                                                 {1, 1, INT_MAX, 1},
                                                 {1, 1, INT_MAX, INT_MAX}};
    uint64_t updates = device_counters_of(device).updates;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        lf_assert_status(device->ops->push(device, frame, &bad[i], 1, 1), LF_E_ARG, NULL);
    for (int more = -1; more <= 1; more += 2) {
        lf_image8 other = {0};
        lf_assert_ok(lf_image8_init(&other, w + more, h, 3), NULL);
        lf_assert_status(device->ops->push(device, &other, &whole, 1, 1), LF_E_ARG, NULL);
        lf_image8_finish(&other);
    }
    lf_assert_status(device->ops->push(device, NULL, &whole, 1, 1), LF_E_ARG, NULL);
    lf_assert_status(device->ops->push(device, frame, &whole, -1, 1), LF_E_ARG, NULL);
    lf_assert_status(device->ops->push(device, frame, &whole, LF_DEVICE_MAX_RECTS + 1, 1), LF_E_ARG,
                     NULL);
    assert_int_equal(device->ops->dispatch(device), LF_DEVICE_READY);
    lf_assert_ok(device->ops->push(device, frame, NULL, 0, 1), NULL);
    assert_int_equal(device_outcome(device), LF_DEVICE_READY);
    assert_int_equal(device_counters_of(device).updates, updates);
}

static inline lf_device_info device_info_of(const lf_device *device)
{
    lf_device_info info;
    device->ops->info(device, &info);
    return info;
}

#endif
