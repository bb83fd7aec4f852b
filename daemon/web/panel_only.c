#include "daemon/web/panel_only.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/web/link.h"
#include "daemon/web/rights.h"

#define AGAIN_USEC ((uint64_t)2000000)
#define ID "quiltweb:panel:"

static const char where[] = "panel-only";

/* Calls of quiltd, in their order. */
enum { STATUS, CALIBRATION, LEND, STEPS };
static const char *const methods[STEPS] = {"status", "device.calibration", "device.set"};

struct lf_panel_only {
    sd_event *event;
    char *socket;
    lf_link *link; /* NULL: not connected */
    json_t *rights;
    sd_event_source *again;               /* on: quiltd is asked once more */
    int step;                             /* whose answer is awaited; STEPS: the panel is lent */
    json_t *device, *calibration, *found; /* found: the device, until it is lent */
    bool told;                            /* that there is no quiltd or panel */
};

static void try_again(lf_panel_only *lent, const char *why)
{
    if (!lent->told)
        lf_log(LF_LOG_INFO, "%s: quiltd has not lent its panel yet: %s", where, why);
    lent->told = true;
    sd_event_source_set_time_relative(lent->again, AGAIN_USEC);
    sd_event_source_set_enabled(lent->again, SD_EVENT_ONESHOT);
}

static void ask(lf_panel_only *lent, int step)
{
    json_t *params =
        step == LEND ? json_pack("{s:s, s:b}", "spec", "none", "lend", 1) : json_object();
    char id[sizeof ID + 2];
    snprintf(id, sizeof id, ID "%d", step);
    json_t *message = json_pack("{s:s, s:s, s:s, s:o}", "jsonrpc", "2.0", "id", id, "method",
                                methods[step], "params", params);
    char *line = message ? json_dumps(message, JSON_COMPACT) : NULL;
    lent->step = step;
    if (!line || lf_link_send(lent->link, line, strlen(line), -1) != LF_OK)
        try_again(lent, "out of memory");
    free(line);
    json_decref(message);
}

static void keep(json_t **kept, json_t *value)
{
    json_decref(*kept);
    *kept = json_deep_copy(value);
}

/* The result of the step came. */
static void go_on(lf_panel_only *lent, json_t *result)
{
    if (lent->step == STATUS &&
        !json_is_true(json_object_get(json_object_get(result, "device"), "present"))) {
        try_again(lent, "none is connected");
    } else if (lent->step == STATUS) {
        keep(&lent->found, json_object_get(result, "device"));
        ask(lent, CALIBRATION);
    } else if (lent->step == CALIBRATION) {
        keep(&lent->calibration, result);
        keep(&lent->device, lent->found);
        ask(lent, LEND);
    } else {
        lent->step = STEPS;
        lent->told = false;
        lf_log(LF_LOG_INFO, "%s: quiltd has lent its panel", where);
    }
}

static void on_answer(lf_panel_only *lent, json_t *message)
{
    const char *id = json_string_value(json_object_get(message, "id"));
    json_t *result = json_object_get(message, "result");
    const char *why =
        json_string_value(json_object_get(json_object_get(message, "error"), "message"));
    char expected[sizeof ID + 2];
    snprintf(expected, sizeof expected, ID "%d", lent->step);
    if (!id || strcmp(id, expected) != 0)
        return;
    if (result)
        go_on(lent, result);
    else
        try_again(lent, why ? why : "it says no reason");
}

static void on_line(void *context, const char *line, size_t n)
{
    lf_panel_only *lent = context;
    lf_error err = {0};
    json_t *message = json_loadb(line, n, 0, NULL);
    const lf_rights_answer rights = lf_rights_read(message, lent->rights, &err);
    if (rights == LF_RIGHTS_DONE) {
        lf_link_go_on(lent->link);
        ask(lent, STATUS);
    } else if (rights == LF_RIGHTS_NONE) {
        on_answer(lent, message);
    } else {
        try_again(lent, "it is too old for this");
    }
    json_decref(message);
}

static void on_end(void *context)
{
    try_again(context, "the connection has ended");
}

static int on_again(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    lf_panel_only *lent = context;
    const lf_link_events events = {.line = on_line, .ended = on_end, .context = lent};
    lf_error err = {0};
    lf_link_destroy(lent->link);
    lent->link = NULL;
    lent->step = STATUS;
    json_decref(lent->rights);
    lent->rights = json_pack("[s, s, s]", methods[0], methods[1], methods[2]);
    if (lf_link_create(lent->event, lent->socket, &events, &lent->link, &err) != LF_OK)
        try_again(lent, err.what);
    else if (lf_rights_limit(lent->link, lent->rights) != LF_OK)
        try_again(lent, "out of memory");
    return 0;
}

lf_status lf_panel_only_create(sd_event *event, const char *socket, lf_panel_only **out,
                               lf_error *err)
{
    lf_panel_only *lent = lf_calloc(1, sizeof *lent);
    if (lent)
        *lent = (lf_panel_only){.event = event, .socket = lf_strdup(socket)};
    if (!lent || !lent->socket ||
        sd_event_add_time_relative(event, &lent->again, CLOCK_MONOTONIC, 0, 1, on_again, lent) <
            0) {
        lf_panel_only_destroy(lent);
        return lf_error_set(err, LF_E_NOMEM, where, "out of memory");
    }
    *out = lent;
    return LF_OK;
}

void lf_panel_only_destroy(lf_panel_only *lent)
{
    if (!lent)
        return;
    sd_event_source_disable_unref(lent->again);
    lf_link_destroy(lent->link);
    json_decref(lent->rights);
    json_decref(lent->device);
    json_decref(lent->calibration);
    json_decref(lent->found);
    lf_free(lent->socket);
    lf_free(lent);
}

bool lf_panel_only_is_on(const lf_panel_only *lent)
{
    return lent;
}

const json_t *lf_panel_only_calibration(const lf_panel_only *lent)
{
    return lent ? lent->calibration : NULL;
}

const json_t *lf_panel_only_device(const lf_panel_only *lent)
{
    return lent ? lent->device : NULL;
}
