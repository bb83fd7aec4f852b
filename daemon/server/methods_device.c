#include <string.h>

#include "base/alloc.h"
#include "daemon/server/methods_internal.h"

void lf_method_device_list(lf_call *call)
{
    lf_deferred *deferred = lf_defer(call);
    if (deferred && lf_show_list(call->server->show, deferred) != LF_OK)
        lf_deferred_reply(deferred, NULL);
}

/* True if the device writes into the folder of the command line's device, whatever the options of
 * both. */
static bool is_own(const lf_server *server, const char *folder, size_t n)
{
    size_t n_own;
    const char *own = lf_device_folder(server->config.device, &n_own);
    return own && n_own == n && memcmp(own, folder, n) == 0;
}

/* Checks a device that writes into a folder. A client may name the folder of the command line's
 * device, or one inside --export-dir. The latter is opened later, possibly more than once, by its
 * canonical path and without following links. *out_spec (lf_free) is the allowed spec. */
static lf_status check_spec(const lf_server *server, const char *spec, char **out_spec,
                            lf_error *err)
{
    size_t n;
    const char *named = lf_device_folder(spec, &n);
    char *allowed = NULL;
    if (!named || is_own(server, named, n)) {
        *out_spec = lf_strdup(spec);
        return *out_spec ? LF_OK : lf_error_set(err, LF_E_NOMEM, "device", "out of memory");
    }
    if (named[0] != '/')
        return lf_error_set(err, LF_E_PATH, spec,
                            "the folder must be an absolute path below --export-dir");
    char *folder = lf_strdup(named);
    if (!folder)
        return lf_error_set(err, LF_E_NOMEM, "device", "out of memory");
    while (n > 1 && named[n - 1] == '/')
        n--;
    folder[n] = '\0';
    lf_held_name held = {.folder_fd = -1};
    lf_status status = lf_server_write_path(server, folder, &held, err);
    /* text after a comma would count as options, and another folder would be opened */
    if (status == LF_OK && strchr(held.path, ','))
        status = lf_error_set(err, LF_E_PATH, held.path,
                              "the path of a simulated panel's folder must not contain a comma");
    else if (status == LF_OK)
        allowed = lf_device_allowed_spec(spec, held.path);
    if (status == LF_OK && !allowed)
        status = lf_error_set(err, LF_E_NOMEM, "device", "out of memory");
    else if (status == LF_OK)
        *out_spec = allowed;
    lf_held_name_finish(&held);
    lf_free(folder);
    return status;
}

/* A white given in one form replaces one given in the other. */
static lf_status take_response(lf_server *server, json_t *params, lf_error *err)
{
    lf_response response = server->response;
    lf_engine_controls controls = lf_engine_get_controls(server->engine);
    if (json_object_get(params, "white"))
        response.white_x = response.white_y = 0;
    else if (json_object_get(params, "white_x"))
        response.white = 0;
    lf_status status = lf_param_from_json(lf_response_params, params, &response, "device.set", err);
    if (status == LF_OK)
        status = lf_response_codes(&response, &controls.codes, err);
    if (status != LF_OK)
        return status;
    server->response = response;
    controls.has_codes = true;
    lf_engine_set_controls(server->engine, &controls);
    return LF_OK;
}

/* A panel is lent, or comes back to nobody because another device is chosen. */
static lf_status take_loan(const lf_call *call, const char *spec, lf_error *err)
{
    if (!json_is_true(json_object_get(call->params, "lend"))) {
        lf_server_loan_forget(call->server);
        return LF_OK;
    }
    if (strcmp(spec, "none") != 0)
        return lf_error_set_at(err, LF_E_ARG, call->method, 0, "/lend",
                               "a panel is lent with spec none");
    return lf_server_loan_begin(call->server, lf_client_serial(call->client), err);
}

void lf_method_device_set(lf_call *call)
{
    char *spec = NULL;
    lf_error err;
    lf_status status = take_response(call->server, call->params, &err);
    if (status == LF_OK)
        status = check_spec(call->server, json_string_value(json_object_get(call->params, "spec")),
                            &spec, &err);
    if (status == LF_OK)
        status = take_loan(call, spec, &err);
    if (status != LF_OK) {
        lf_fail(call, &err, false);
        lf_free(spec);
        return;
    }
    lf_deferred *deferred = lf_defer(call);
    if (deferred && lf_show_open(call->server->show, spec, deferred, &err) != LF_OK)
        lf_deferred_fail(deferred, &err, false);
    lf_free(spec);
}

void lf_method_device_calibration(lf_call *call)
{
    const lf_calibration *calibration = lf_show_calibration(call->server->show);
    if (!calibration) {
        lf_error err;
        (void)lf_error_set(&err, LF_E_NODEV, lf_show_spec(call->server->show),
                           "no panel with a known calibration is open; open one with device.set or "
                           "start quiltd with --calibration");
        lf_fail(call, &err, false);
        return;
    }
    lf_reply(call, lf_calibration_json(calibration));
}

void lf_method_button(lf_call *call)
{
    lf_button button = lf_button_of_name(json_string_value(json_object_get(call->params, "name")));
    lf_server_press(call->server, button);
    lf_reply(call,
             json_pack("{s:s}", "action", lf_action_name(call->server->config.buttons.of[button])));
}
