/* The panel as clients see it: events of the show, and reports on the socket. */
#include "base/alloc.h"
#include "base/log.h"
#include "daemon/server/server_internal.h"

/* -------------------------------------------------------------------------------------- told -- */

static json_t *info_json(const lf_device_info *info)
{
    return json_pack("{s:s, s:s, s:s, s:s, s:s, s:s, s:s}", "spec", info->spec, "kind", info->kind,
                     "model", info->model, "serial", info->serial, "calibration_from",
                     info->calibration_from, "output", info->output, "problem", info->problem);
}

json_t *lf_server_device_json(const lf_server *server)
{
    lf_device_info info;
    bool present = lf_show_info(server->show, &info);
    lf_server_loan_tell(server, &info);
    json_t *told = info_json(&info);
    json_object_set_new(told, "present", json_boolean(present));
    json_object_set_new(told, "response", lf_param_json(lf_response_params, &server->response));
    return told;
}

/* ------------------------------------------------------------------------------------ events -- */

/* The daemon's own attempt at its start has ended. */
static void first_opened(lf_server *server, const lf_error *err)
{
    if (err && err->status != LF_E_CANCELLED)
        lf_log_error(err);
    if (err && err->status == LF_E_ARG) {
        server->life.exit_code = LF_EXIT_USAGE;
        lf_server_shutdown(server);
        return;
    }
    lf_server_begin(server);
}

/* The device of the command line has no client to answer. */
static void on_opened(void *context, void *answer, const lf_error *err)
{
    lf_server *server = context;
    if (!answer)
        first_opened(server, err);
    else if (answer == &server->life.loan)
        lf_server_loan_opened(server, err);
    else if (err)
        lf_deferred_fail(answer, err, false);
    else
        lf_deferred_reply(answer, lf_server_device_json(server));
}

static void on_listed(void *context, void *answer, const lf_device_info *devices, int n,
                      const lf_error *err)
{
    lf_server *server = context;
    if (err) {
        lf_deferred_fail(answer, err, false);
        return;
    }
    json_t *list = json_array();
    for (int i = 0; i < n; i++)
        json_array_append_new(list, info_json(&devices[i]));
    lf_deferred_reply(
        answer, json_pack("{s:o, s:o}", "devices", list, "present", lf_server_device_json(server)));
}

static void on_changed(void *context)
{
    lf_server *server = context;
    lf_notify(server->clients, LF_EVENT_DEVICE, "device", lf_server_device_json(server));
    lf_server_tell_status(server);
}

static void on_lens(void *context, const lf_calibration *calibration, uint64_t panel, bool views,
                    bool is_new)
{
    lf_server *server = context;
    char words[256];
    if (is_new && lf_options_preset_differs(&server->options, calibration, words, sizeof words))
        lf_log(LF_LOG_WARNING, "%s: %s", calibration->serial, words);
    lf_engine_set_panel(server->engine, calibration, panel, views);
    /* Also without content, because the first scene may be loading. */
    lf_load *load = is_new ? lf_load_create(LF_LOAD_APPLY) : NULL;
    if (load)
        lf_server_load(server, load, NULL);
}

static void on_shown(void *context, const lf_shown *shown)
{
    lf_server_shown(context, shown);
}

static void on_kept(void *context, const lf_error *err)
{
    const lf_server *server = context;
    if (err)
        lf_waits_fail_files(server->waits, err);
    lf_waits_look(server->waits);
}

static void on_pressed(void *context, lf_button button)
{
    lf_server_press(context, button);
}

lf_status lf_server_make_show(lf_server *server)
{
    static const lf_show_events events = {.opened = on_opened,
                                          .listed = on_listed,
                                          .examined = lf_server_examined,
                                          .changed = on_changed,
                                          .lens = on_lens,
                                          .shown = on_shown,
                                          .kept = on_kept,
                                          .pressed = on_pressed};
    const lf_show_home home = {.event = server->event,
                               .inbox = &server->inbox,
                               .mailbox = lf_engine_mailbox(server->engine),
                               .calibration = server->config.calibration};
    return lf_show_create(&home, &events, server, &server->show);
}
