/* What is plugged in, as udev tells it. Without udev (a container) nothing is told: a panel that was there and went is still tried again
 * from time to time, but one that was never there is not looked for. */
#include <systemd/sd-device.h>

#include "base/errno_text.h"
#include "base/log.h"
#include "daemon/server.h"

/* Where a panel, its calibration or its buttons may appear. */
static const struct {
    const char *subsystem, *type;
} watched[] = {{"usb", "usb_device"}, {"hidraw", NULL}, {"drm", NULL}, {"block", NULL}};

static int on_plug(sd_device_monitor *monitor, sd_device *device, void *context)
{
    sd_device_action_t action;
    (void)monitor;
    if (sd_device_get_action(device, &action) >= 0 && action != SD_DEVICE_REMOVE && action != SD_DEVICE_UNBIND) {
        lf_server_plugged(context);
    }
    return 0;
}

static int start(lf_server *server, sd_device_monitor *monitor)
{
    int r = 0;
    for (size_t i = 0; i < sizeof watched / sizeof *watched && r >= 0; i++) {
        r = sd_device_monitor_filter_add_match_subsystem_devtype(monitor, watched[i].subsystem, watched[i].type);
    }
    if (r >= 0) {
        r = sd_device_monitor_attach_event(monitor, server->event);
    }
    return r >= 0 ? sd_device_monitor_start(monitor, on_plug, server) : r;
}

void lf_server_watch_plugs(lf_server *server)
{
    int r = sd_device_monitor_new(&server->plugs);
    if (r >= 0) {
        r = start(server, server->plugs);
    }
    if (r < 0) {
        lf_log(LF_LOG_DEBUG, "plugging in is not seen: %s", lf_errno_text(-r));
        server->plugs = sd_device_monitor_unref(server->plugs);
    }
}

void lf_server_unwatch_plugs(lf_server *server)
{
    server->plugs = sd_device_monitor_unref(server->plugs);
}
