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
static inline lf_device_event device_push(lf_device *device, const lf_image8 *frame, const lf_rect *rects, int n)
{
    lf_assert_ok(device->ops->push(device, frame, rects, n, 1), NULL);
    return device_outcome(device);
}

static inline lf_device_counters device_counters_of(const lf_device *device)
{
    lf_device_counters counters;
    device->ops->counters(device, &counters);
    return counters;
}

static inline lf_device_info device_info_of(const lf_device *device)
{
    lf_device_info info;
    device->ops->info(device, &info);
    return info;
}

#endif
