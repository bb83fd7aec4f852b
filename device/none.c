/* The device that shows nothing: for rendering without a panel, and the fallback of "auto". */
#include <assert.h>
#include <string.h>

#include "base/alloc.h"
#include "device/device_table.h"

typedef struct none_device {
    lf_device base;
    lf_device_counters counters;
    char problem[256];
} none_device;

static none_device *none_of(lf_device *device)
{
    return (none_device *)(void *)device;
}

static const none_device *const_none_of(const lf_device *device)
{
    return (const none_device *)(const void *)device;
}

lf_status lf_none_create(const char *problem, lf_device **out_device, lf_error *err)
{
    none_device *none = lf_calloc(1, sizeof *none);
    if (!none)
        return lf_error_set(err, LF_E_NOMEM, "none", "out of memory");
    none->base.ops = &lf_none_ops;
    lf_device_text(none->problem, sizeof none->problem, problem);
    *out_device = &none->base;
    return LF_OK;
}

/* A calibration is not used: without a panel nothing is interlaced. */
static lf_status none_open(const char *argument, const lf_calibration *calibration,
                           lf_device **out_device, lf_error *err)
{
    (void)calibration;
    if (argument[0] != 0)
        return lf_error_set(err, LF_E_ARG, "none", "takes no argument, got \"%s\"", argument);
    return lf_none_create("", out_device, err);
}

static void none_destroy(lf_device *device)
{
    lf_free(device);
}

static void none_info(const lf_device *device, lf_device_info *out)
{
    *out = (lf_device_info){.spec = "none", .kind = "none", .model = "no panel"};
    memcpy(out->problem, const_none_of(device)->problem, sizeof out->problem);
}

static const lf_calibration *none_calibration(const lf_device *device)
{
    (void)device;
    return NULL;
}

static lf_status none_push(lf_device *device, const lf_image8 *frame, const lf_rect *rects, int n,
                           uint64_t generation)
{
    (void)frame;
    (void)generation;
    lf_device_counters *counters = &none_of(device)->counters;
    for (int i = 0; i < n; i++)
        counters->bytes += (uint64_t)rects[i].width * (uint64_t)rects[i].height * 3;
    counters->updates += (uint64_t)n;
    return LF_OK;
}

static int none_poll_fd(const lf_device *device)
{
    (void)device;
    return -1;
}

static lf_device_event none_dispatch(lf_device *device)
{
    (void)device;
    return LF_DEVICE_READY;
}

static void none_counters(const lf_device *device, lf_device_counters *out)
{
    *out = const_none_of(device)->counters;
}

static lf_status none_flush(lf_device *device, int timeout_ms)
{
    (void)device;
    (void)timeout_ms;
    return LF_OK;
}

const lf_device_ops lf_none_ops = {
    .kind = "none",
    .open = none_open,
    .destroy = none_destroy,
    .info = none_info,
    .calibration = none_calibration,
    .push = none_push,
    .poll_fd = none_poll_fd,
    .dispatch = none_dispatch,
    .counters = none_counters,
    .flush = none_flush,
};
