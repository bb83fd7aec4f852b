/* Plug events from udev, sent after its rules have run, so that devices have their nodes and
 * rights. Without udev (a container) there are no events, and panels are searched for at
 * intervals. */
#include <string.h>
#include <unistd.h>

#include "base/errno_text.h"
#include "base/log.h"
#include "daemon/show/show_internal.h"
#include "device/find/find.h"

/* Subsystems in which a panel, its calibration or its buttons may appear. */
static const struct {
    const char *subsystem, *type;
} watched[] = {{"usb", "usb_device"}, {"hidraw", NULL}, {"drm", NULL}, {"block", NULL}};

/* udisks2 makes the kernel report a drive again after mounting it. quiltd's searches mount drives;
 * if these events counted as news, each search would start the next. Mounts by others, possibly
 * requested from the user, are news. */
static bool is_echo(sd_device *device, const char *subsystem, sd_device_action_t action)
{
    const char *text;
    dev_t number;
    return action == SD_DEVICE_CHANGE && strcmp(subsystem, "block") == 0 &&
           sd_device_get_property_value(device, "SYNTH_UUID", &text) >= 0 &&
           sd_device_get_devnum(device, &number) >= 0 && lf_find_touches(number);
}

/* The kernel's form of the USB IDs of panels and of displays with an open protocol, as in
 * systemd/70-quiltd.rules. */
static const char *const products[] = {"4d8/ef7e/", "1d50/614d/", "16d0/10a9/"};

static const char *property(sd_device *device, const char *name)
{
    const char *value;
    return sd_device_get_property_value(device, name, &value) >= 0 ? value : "";
}

static bool is_panel_product(const char *product)
{
    for (size_t i = 0; i < sizeof products / sizeof *products; i++)
        if (strncmp(product, products[i], strlen(products[i])) == 0)
            return true;
    return false;
}

/* True if the new device belongs to a panel and is complete. A USB device is bound when all of its
 * interfaces have drivers; udev reports this after the interfaces. The event that it was added is
 * too early. */
static bool is_panel(sd_device *device, const char *subsystem, sd_device_action_t action)
{
    if (strcmp(subsystem, "usb") == 0)
        return action == SD_DEVICE_BIND && is_panel_product(property(device, "PRODUCT"));
    return strcmp(subsystem, "block") == 0 &&
           strncmp(property(device, "ID_FS_LABEL"), "LKG-", 4) == 0;
}

static int on_plug(sd_device_monitor *monitor, sd_device *device, void *context)
{
    const char *subsystem;
    sd_device_action_t action;
    (void)monitor;
    if (sd_device_get_action(device, &action) < 0 || action == SD_DEVICE_REMOVE ||
        action == SD_DEVICE_UNBIND || sd_device_get_subsystem(device, &subsystem) < 0 ||
        is_echo(device, subsystem, action))
        return 0;
    if (is_panel(device, subsystem, action))
        lf_show_plugged(context, true);
    else if (strcmp(subsystem, "usb") != 0)
        lf_show_plugged(context, false);
    return 0;
}

static int start(lf_show *show, sd_device_monitor *monitor)
{
    int r = 0;
    for (size_t i = 0; i < sizeof watched / sizeof *watched && r >= 0; i++)
        r = sd_device_monitor_filter_add_match_subsystem_devtype(monitor, watched[i].subsystem,
                                                                 watched[i].type);
    if (r >= 0)
        r = sd_device_monitor_attach_event(monitor, show->home.event);
    return r >= 0 ? sd_device_monitor_start(monitor, on_plug, show) : r;
}

void lf_show_watch_plugs(lf_show *show)
{
    int r = sd_device_monitor_new(&show->plugs);
    if (r >= 0)
        r = start(show, show->plugs);
    if (r < 0) {
        lf_log(LF_LOG_DEBUG, "cannot watch for devices being plugged in: %s", lf_errno_text(-r));
        show->plugs = sd_device_monitor_unref(show->plugs);
    }
    /* A monitor exists also without udev, but it is silent. */
    show->told_of_plugs = r >= 0 && access("/run/udev/control", F_OK) == 0;
}

void lf_show_unwatch_plugs(lf_show *show)
{
    show->plugs = sd_device_monitor_unref(show->plugs);
}
