#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "daemon/methods.h"

#define SIM "sim:"

void lf_method_device_list(lf_call *call)
{
    lf_ticket *ticket = lf_defer(call);
    if (ticket != NULL) {
        lf_server_list_devices(call->server, ticket);
    }
}

/* Whether it is the simulated panel of the command line, whatever its options. */
static bool is_own(const lf_server *server, const char *spec)
{
    size_t n = strcspn(spec, ",");
    const char *own = server->config.device;
    return strncmp(own, spec, n) == 0 && (own[n] == ',' || own[n] == '\0');
}

static lf_status join_spec(const char *folder, const char *options, char **out_spec, lf_error *err)
{
    size_t size = strlen(SIM) + strlen(folder) + strlen(options) + 1;
    char *spec = lf_calloc(size, 1);
    if (spec == NULL) {
        return lf_error_set(err, LF_E_NOMEM, "device", "out of memory");
    }
    snprintf(spec, size, SIM "%s%s", folder, options);
    *out_spec = spec;
    return LF_OK;
}

/* A simulated device writes into its folder: a client may name the one of the command line, or one beneath --export-dir, which is
 * opened by its canonical path. *out_spec (lf_free) is what may be opened. */
static lf_status check_spec(const lf_server *server, const char *spec, char **out_spec, lf_error *err)
{
    char *folder = NULL, *path = NULL;
    if (strncmp(spec, SIM, strlen(SIM)) != 0 || is_own(server, spec)) {
        *out_spec = lf_strdup(spec);
        return *out_spec != NULL ? LF_OK : lf_error_set(err, LF_E_NOMEM, "device", "out of memory");
    }
    const char *named = spec + strlen(SIM), *options = named + strcspn(named, ",");
    if (named[0] != '/') {
        return lf_error_set(err, LF_E_PATH, spec, "the folder must be an absolute path beneath the --export-dir");
    }
    lf_status status = LF_OK;
    folder = lf_strdup(named);
    if (folder == NULL) {
        return lf_error_set(err, LF_E_NOMEM, "device", "out of memory");
    }
    folder[options - named] = '\0';
    status = lf_server_write_path(server, folder, &path, err);
    if (status == LF_OK && strchr(path, ',') != NULL) { /* what follows would be taken for options, and another folder opened */
        status = lf_error_set(err, LF_E_PATH, path, "a simulated panel's folder may not have a comma in its path");
    } else if (status == LF_OK) {
        status = join_spec(path, options, out_spec, err);
    }
    lf_free(path);
    lf_free(folder);
    return status;
}

void lf_method_device_set(lf_call *call)
{
    char *spec = NULL;
    lf_error err;
    if (check_spec(call->server, json_string_value(json_object_get(call->params, "spec")), &spec, &err) != LF_OK) {
        lf_fail(call, &err, false);
        return;
    }
    lf_ticket *ticket = lf_defer(call);
    if (ticket != NULL && lf_server_open_device(call->server, spec, ticket, &err) != LF_OK) {
        lf_ticket_fail(call->server, ticket, &err, false);
    }
    lf_free(spec);
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
