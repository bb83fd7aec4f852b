/* A panel that was shown with what the cache knows, because its own calibration was not there yet: a drive takes seconds to appear, and the
 * USB cable may come last. When it comes it is read, and where the panel would get another one now it is opened anew. */
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "daemon/server.h"

static bool is_from_cache(const lf_panel *panel)
{
    lf_device_info info;
    if (panel->device == NULL || !panel->has_calibration) {
        return false;
    }
    panel->device->ops->info(panel->device, &info);
    return info.calibration_cached;
}

/* The display as it calls itself, in its native mode, which is the calibration's. */
static void describe_display(const lf_panel *panel, lf_edid *out)
{
    lf_device_info info;
    panel->device->ops->info(panel->device, &info);
    *out = (lf_edid){.width_px = panel->calibration.screen_width_px, .height_px = panel->calibration.screen_height_px};
    snprintf(out->name, sizeof out->name, "%.*s", (int)sizeof out->name - 1, info.model);
}

static void on_checked(void *reader, lf_letter *letter)
{
    lf_server *server = reader;
    lf_panel *panel = &server->panel;
    lf_errand *errand = (lf_errand *)(void *)letter;
    bool again = server->check_again;
    server->checking = server->check_again = false;
    if (!server->stopping && is_from_cache(panel) && errand->denied &&
        memcmp(&errand->used, &panel->calibration, sizeof errand->used) == 0) {
        lf_log(LF_LOG_INFO, "%s: the panel's own calibration is not the cached one", panel->spec);
        lf_server_open_again(server);
    } else if (!server->stopping && again) {
        lf_server_check_calibration(server);
    }
    lf_errand_destroy(errand);
}

void lf_server_check_calibration(lf_server *server)
{
    if (!is_from_cache(&server->panel)) {
        return;
    }
    if (server->checking) {
        server->check_again = true;
        return;
    }
    lf_errand *errand = lf_errand_create(LF_ERRAND_CHECK);
    if (errand != NULL) {
        errand->used = server->panel.calibration;
        describe_display(&server->panel, &errand->display);
        errand->letter.open = on_checked;
        server->checking = true;
        lf_opener_queue(server->opener, errand);
    }
}
