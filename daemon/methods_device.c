#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "daemon/methods.h"

void lf_method_device_list(lf_call *call)
{
    lf_ticket *ticket = lf_defer(call);
    if (ticket != NULL) {
        lf_server_list_devices(call->server, ticket);
    }
}

/* A simulated device writes into its folder: a client may name the one of the command line, or one beneath --export-dir. */
static lf_status check_spec(const lf_server *server, const char *spec, lf_error *err)
{
    if (strncmp(spec, "sim:", 4) != 0) {
        return LF_OK;
    }
    size_t n = strcspn(spec, ",");
    const char *own = server->config.device;
    if (strncmp(own, spec, n) == 0 && (own[n] == ',' || own[n] == '\0')) {
        return LF_OK;
    }
    char folder[512];
    snprintf(folder, sizeof folder, "%.*s", n < sizeof folder ? (int)n - 4 : (int)sizeof folder - 1, spec + 4);
    if (folder[0] != '/') {
        return lf_error_set(err, LF_E_PATH, spec, "the folder must be an absolute path beneath the --export-dir");
    }
    char *path = NULL;
    lf_status status = lf_server_write_path(server, folder, &path, err);
    lf_free(path);
    return status;
}

void lf_method_device_set(lf_call *call)
{
    const char *spec = json_string_value(json_object_get(call->params, "spec"));
    lf_error err;
    if (check_spec(call->server, spec, &err) != LF_OK) {
        lf_fail(call, &err, false);
        return;
    }
    lf_ticket *ticket = lf_defer(call);
    if (ticket != NULL) {
        lf_server_open_device(call->server, spec, ticket);
    }
}

void lf_method_device_calibration(lf_call *call)
{
    const lf_panel *panel = &call->server->panel;
    if (!panel->has_calibration) {
        lf_error err;
        (void)lf_error_set(&err, LF_E_NODEV, panel->spec, "there is no panel whose calibration is known");
        lf_fail(call, &err, false);
        return;
    }
    lf_reply(call, lf_calibration_json(&panel->calibration));
}

void lf_method_button(lf_call *call)
{
    lf_button button = lf_button_of_name(json_string_value(json_object_get(call->params, "name")));
    lf_server_press(call->server, button);
    lf_reply(call, json_pack("{s:s}", "action", lf_action_name(call->server->config.buttons.of[button])));
}
