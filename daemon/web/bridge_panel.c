/* Endpoints of the panel, and what is told of it. */
#include "daemon/web/bridge_internal.h"

#include <stdlib.h>

#include "daemon/web/bridge_entry.h"
#include "daemon/web/panel_info.h"

/* -------------------------------------------------------------------------------------- look -- */

static void on_calibration(lf_bridge_call *call, const json_t *result, const char *why)
{
    (void)why; /* without a panel there is no calibration */
    json_t *info = lf_panel_info(result, call->kept);
    lf_bridge *bridge = call->bridge;
    bridge->has_panel = info;
    bridge->knows_panel = true;
    json_decref(call->kept);
    call->kept = NULL;
    call->looked(call, info, "no panel is connected");
    json_decref(info);
}

static void on_status(lf_bridge_call *call, const json_t *result, const char *why)
{
    if (!result) {
        lf_bridge_fail(call, "%s", why);
        return;
    }
    call->kept = json_incref(json_object_get(result, "device"));
    lf_bridge_ask(call, "device.calibration", NULL, on_calibration);
}

void lf_bridge_look(lf_bridge_call *call, lf_bridge_then_fn then)
{
    const lf_panel_only *lent = call->bridge->config.panel_only;
    call->looked = then;
    if (lf_panel_only_is_on(lent)) {
        json_t *info = lf_panel_info(lf_panel_only_calibration(lent), lf_panel_only_device(lent));
        then(call, info, "no panel is connected");
        json_decref(info);
        return;
    }
    lf_bridge_ask(call, "status", NULL, on_status);
}

/* --------------------------------------------------------------------------------- endpoints -- */

/* A text that holds JSON: bridge.js parses it. */
static json_t *json_in_text(const char *name, const json_t *json)
{
    char *text = json_dumps(json, JSON_COMPACT);
    json_t *value = lf_bridge_text(name, text ? text : "");
    free(text);
    return value;
}

static json_t *make_device(const json_t *info)
{
    const json_t *at = json_object_get(info, "windowCoords");
    const char *hwid = json_string_value(json_object_get(info, "hwid"));
    const char *version = json_string_value(json_object_get(info, "hardwareVersion"));
    json_t *place = json_pack("{s:O, s:O}", "x", json_array_get(at, 0), "y", json_array_get(at, 1));
    return json_pack(
        "{s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "calibration",
        json_in_text("calibration", json_object_get(info, "calibration")), "defaultQuilt",
        json_in_text("defaultQuilt", json_object_get(info, "defaultQuilt")), "hardwareVersion",
        lf_bridge_text("hardwareVersion", version), "hwid", lf_bridge_text("hwid", hwid), "index",
        lf_bridge_number_value("index", 0), "state", lf_bridge_text("state", "ok"), "windowCoords",
        lf_bridge_value("windowCoords", "INT2", place));
}

static void on_devices(lf_bridge_call *call, const json_t *info, const char *why)
{
    (void)why;
    json_t *devices = json_object();
    if (info)
        json_object_set_new(devices, "0", lf_bridge_value("0", "VARIANT_MAP", make_device(info)));
    lf_bridge_complete(call, lf_bridge_value("devices", "VARIANT_MAP", devices));
}

void lf_bridge_run_devices(lf_bridge_call *call)
{
    lf_bridge_look(call, on_devices);
}

static void on_window(lf_bridge_call *call, const json_t *info, const char *why)
{
    if (info)
        lf_bridge_complete(call, NULL);
    else
        lf_bridge_fail(call, "%s", why);
}

void lf_bridge_run_window(lf_bridge_call *call)
{
    double shown = 1;
    if (lf_bridge_number(json_object_get(call->body, "show_window"), &shown) && shown == 0)
        lf_bridge_fail(call, "quiltd does not hide its image; show another one instead");
    else
        lf_bridge_look(call, on_window);
}

/* ------------------------------------------------------------------------------------ events -- */

static void tell(lf_bridge *bridge, const char *event, const json_t *calibration)
{
    const json_t *width = json_object_get(calibration, "screenW"),
                 *height = json_object_get(calibration, "screenH");
    const char *serial = json_string_value(json_object_get(calibration, "serial"));
    json_t *told =
        json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "event", lf_bridge_text("event", event),
                  "head_index", lf_bridge_number_value("head_index", 0), "x",
                  lf_bridge_number_value("x", 0), "y", lf_bridge_number_value("y", 0), "width",
                  lf_bridge_number_value("width", json_integer_value(width)), "height",
                  lf_bridge_number_value("height", json_integer_value(height)), "hwid",
                  lf_bridge_text("hwid", serial ? serial : ""));
    if (told)
        bridge->config.tell(bridge->config.context, NULL, told);
    json_decref(told);
}

static void on_connected(void *context, const json_t *result, const char *why)
{
    (void)why;
    lf_bridge *bridge = context;
    bridge->measures_panel = false;
    tell(bridge, "Monitor Connect", result);
}

void lf_bridge_panel_note(lf_bridge *bridge, const json_t *params)
{
    const bool is_there = json_is_true(json_object_get(params, "present"));
    lf_error err = {0};
    if (bridge->knows_panel && bridge->has_panel == is_there)
        return;
    if (!is_there)
        tell(bridge, "Monitor Disconnect", NULL);
    else if (bridge->knows_panel && !bridge->measures_panel)
        bridge->measures_panel = lf_calls_ask(bridge->calls, "device.calibration", NULL,
                                              on_connected, bridge, &err) == LF_OK;
    bridge->has_panel = is_there;
    bridge->knows_panel = true;
}
