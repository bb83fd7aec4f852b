/* Checks a panel that was opened with a cached calibration because its own was not available yet: a
 * drive takes seconds to appear, and the USB cable may be plugged in last. Once it is available it
 * is read; if it differs from the cached one, the panel is opened again. */
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "daemon/show/show_internal.h"

static bool is_from_cache(const lf_show *show)
{
    lf_device_info info;
    if (!show->device || !show->has_calibration)
        return false;
    show->device->ops->info(show->device, &info);
    return info.calibration_cached;
}

/* The display's own name and serial, and its native mode, which is the calibration's. */
static void describe_display(const lf_show *show, lf_edid *out)
{
    lf_device_info info;
    show->device->ops->info(show->device, &info);
    *out = (lf_edid){.width_px = show->calibration.screen_width_px,
                     .height_px = show->calibration.screen_height_px};
    snprintf(out->name, sizeof out->name, "%.*s", (int)sizeof out->name - 1, info.model);
}

static void on_checked(void *reader, lf_task *task)
{
    lf_opener_request *request = (lf_opener_request *)(void *)task;
    lf_show *show = request->owner;
    bool again = show->checking == LF_SEARCH_AGAIN;
    (void)reader;
    show->checking = LF_SEARCH_REST;
    if (!show->stopping && is_from_cache(show) && request->denied &&
        memcmp(&request->used, &show->calibration, sizeof request->used) == 0) {
        lf_log(LF_LOG_INFO,
               "%s: the calibration on the panel differs from the cached one; reopening",
               show->spec);
        lf_show_open_again(show);
    } else if (!show->stopping && again) {
        lf_show_check_calibration(show);
    }
    lf_opener_request_destroy(request);
}

void lf_show_check_calibration(lf_show *show)
{
    if (!is_from_cache(show))
        return;
    if (show->checking != LF_SEARCH_REST) {
        show->checking = LF_SEARCH_AGAIN;
        return;
    }
    lf_opener_request *request = lf_opener_request_create(LF_OPENER_CHECK);
    if (request) {
        request->used = show->calibration;
        describe_display(show, &request->display);
        request->task.done = on_checked;
        request->owner = show;
        show->checking = LF_SEARCH_BUSY;
        lf_opener_submit(show->opener, request);
    }
}
