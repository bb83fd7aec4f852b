#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>

#include "base/alloc.h"
#include "base/escape.h"
#include "base/log.h"
#include "daemon/server.h"

/* Between attempts to open a panel that is away, the first and, after ever longer ones, the last; from plugging in something that may be
 * a part of a panel until the rest is there; between searches for a panel that was never there, where nobody tells. */
#define REOPEN_USEC 500000
#define REOPEN_LAST_USEC 8000000
#define PLUGGED_USEC 300000
#define SEARCH_USEC 30000000

static bool shows_nothing(const lf_device *device)
{
    return device == NULL || strcmp(device->ops->kind, "none") == 0;
}

static void tell_device(lf_server *server)
{
    lf_server_notify(server, LF_EVENT_DEVICE, "device", lf_server_device_json(server));
    lf_server_tell_status(server);
}

/* ------------------------------------------------------------------------------------------------------- letting go -- */

/* Destroying a device may wait for its panel, which the event thread must not. */
static void close_device(lf_server *server, lf_device *device)
{
    lf_errand *errand = lf_errand_create(LF_ERRAND_CLOSE);
    if (errand == NULL) {
        lf_device_destroy(device);
        return;
    }
    errand->device = device;
    errand->letter.open = lf_errand_forget;
    lf_opener_queue(server->opener, errand);
}

/* Lets go of the device; its counters are kept. */
static void let_go(lf_server *server)
{
    lf_panel *panel = &server->panel;
    panel->in_flight = false;
    lf_server_drop_buttons(server);
    if (panel->device == NULL) {
        return;
    }
    sd_event_source_disable_unref(panel->io);
    panel->io = NULL;
    lf_device_counters now;
    panel->device->ops->counters(panel->device, &now);
    panel->before.updates += now.updates;
    panel->before.bytes += now.bytes;
    panel->before.errors += now.errors;
    close_device(server, panel->device);
    panel->device = NULL;
}

void lf_server_gone(lf_server *server)
{
    lf_panel *panel = &server->panel;
    lf_log(LF_LOG_INFO, "%s: unplugged", panel->spec);
    let_go(server);
    panel->has_problem = true;
    (void)lf_error_set(&panel->problem, LF_E_NODEV, panel->spec, "unplugged");
    tell_device(server);
    panel->patience_usec = REOPEN_USEC;
    lf_server_retry(server, REOPEN_USEC);
}

void lf_server_close_device(lf_server *server, int timeout_ms)
{
    lf_panel *panel = &server->panel;
    double end = lf_time_now() + timeout_ms * 1e-3;
    /* The push in flight, then the last frame. */
    for (int i = 0; i < 2 && panel->device != NULL; i++) {
        int left = (int)((end - lf_time_now()) * 1e3);
        if (panel->in_flight && panel->device->ops->flush(panel->device, left > 0 ? left : 0) != LF_OK) {
            break;
        }
        if (panel->in_flight) {
            lf_server_dispatch(server);
        }
        lf_server_pump(server);
    }
    sd_event_source_disable_unref(panel->retry);
    panel->retry = NULL;
    let_go(server);
}

/* ----------------------------------------------------------------------------------------------------------- taking -- */

static int on_device(sd_event_source *source, int fd, uint32_t events, void *context)
{
    lf_server *server = context;
    (void)source;
    (void)fd;
    (void)events;
    lf_server_dispatch(server);
    if (!server->panel.whole) {
        lf_server_pump(server);
    }
    return 0;
}

/* The panel that frames are made for from now on. The frame there is fits a panel that comes back: it need not wait for the engine. */
static void take_calibration(lf_server *server, const lf_calibration *calibration)
{
    lf_panel *panel = &server->panel;
    bool views = panel->device->ops->views != NULL;
    bool same = panel->has_calibration == (calibration != NULL) &&
                (calibration == NULL || memcmp(calibration, &panel->calibration, sizeof *calibration) == 0);
    if (same && panel->number > 0 && panel->has_views == views) {
        return;
    }
    panel->has_calibration = calibration != NULL;
    panel->has_views = views;
    if (calibration != NULL) {
        panel->calibration = *calibration;
    }
    panel->number++;
    lf_engine_set_panel(server->engine, calibration, panel->number, views);
    if (!same) { /* also with nothing on stage: the first scene may be under way */
        lf_load *load = lf_load_create(LF_LOAD_APPLY);
        if (load != NULL) {
            lf_server_load(server, load, NULL);
        }
    }
}

/* The panel is this device from now on (taken over whatever comes of it). */
static lf_status take_device(lf_server *server, lf_device *device, lf_error *err)
{
    lf_panel *panel = &server->panel;
    lf_device_info info;
    let_go(server);
    panel->device = device;
    device->ops->info(device, &info);
    snprintf(panel->spec, sizeof panel->spec, "%s", info.spec);
    if (!shows_nothing(device)) {
        memcpy(panel->last, panel->spec, sizeof panel->last);
    }
    panel->has_problem = false;
    panel->whole = true;
    int fd = device->ops->poll_fd(device);
    if (fd >= 0 && sd_event_add_io(server->event, &panel->io, fd, EPOLLIN, on_device, server) < 0) {
        let_go(server);
        return lf_error_set(err, LF_E_NOMEM, panel->spec, "out of memory");
    }
    take_calibration(server, device->ops->calibration(device));
    lf_server_find_buttons(server);
    lf_log(LF_LOG_INFO, "%s: %s%s%s", panel->spec, info.model, info.problem[0] != '\0' ? ": " : "", info.problem);
    return LF_OK;
}

/* ---------------------------------------------------------------------------------------------------------- opening -- */

/* The folder of a simulated panel's spec, canonical; malloced, NULL = there is none yet. */
static char *folder_of(const char *spec)
{
    char folder[sizeof((lf_panel *)0)->spec];
    snprintf(folder, sizeof folder, "%.*s", (int)strcspn(spec + 4, ","), spec + 4);
    return realpath(folder, NULL);
}

/* Whether spec may name the device that is open now, which must be closed before it can be opened again. */
static bool may_be_same(const char *now, const char *spec)
{
    if (strcmp(spec, "auto") == 0) {
        return true;
    }
    size_t n = strcspn(now, ":");
    if (strcspn(spec, ":") != n || strncmp(now, spec, n) != 0) {
        return false;
    }
    if (strncmp(now, "sim:", 4) != 0) {
        return true;
    }
    char *ours = folder_of(now), *other = folder_of(spec);
    bool same = ours != NULL && other != NULL && strcmp(ours, other) == 0;
    free(ours);
    free(other);
    return same;
}

static void on_opened(void *reader, lf_letter *letter);

static bool is_opening(const lf_panel *panel)
{
    for (int i = 0; i < LF_OPENER_LANES; i++) {
        if (panel->opening[i] != NULL) {
            return true;
        }
    }
    return false;
}

static void begin_errand(lf_server *server, lf_errand *errand)
{
    lf_panel *panel = &server->panel;
    if (!shows_nothing(panel->device) && may_be_same(panel->spec, errand->spec)) {
        memcpy(errand->before, panel->wanted, sizeof errand->before);
        let_go(server);
    }
    panel->opening[lf_lane_of(errand->spec)] = errand;
    panel->plugged = false;
    lf_opener_queue(server->opener, errand);
}

/* Begins what waits and whose lane is free. */
static void begin_queued(lf_server *server)
{
    lf_panel *panel = &server->panel;
    lf_errand **at = &panel->queued;
    while (*at != NULL) {
        lf_errand *errand = *at;
        if (panel->opening[lf_lane_of(errand->spec)] != NULL) {
            at = &errand->next;
        } else {
            *at = errand->next;
            begin_errand(server, errand);
        }
    }
}

/* Opens now, or when those before it in its lane are open. number: of the wish. */
static void open_errand(lf_server *server, const char *spec, uint64_t number, bool again, lf_ticket *ticket)
{
    lf_panel *panel = &server->panel;
    lf_errand *errand = lf_errand_create(LF_ERRAND_OPEN);
    if (errand == NULL) {
        lf_ticket_reply(server, ticket, NULL);
        return;
    }
    errand->number = number;
    errand->letter.open = on_opened;
    snprintf(errand->spec, sizeof errand->spec, "%s", spec);
    errand->calibration = server->config.calibration;
    errand->again = errand->panel_only = again;
    if (again && strcmp(spec, "auto") == 0) {
        memcpy(errand->first, panel->last, sizeof errand->first);
    }
    errand->at_start = number == 1 && !again;
    errand->ticket = ticket;
    lf_errand **at = &panel->queued;
    while (*at != NULL) {
        at = &(*at)->next;
    }
    *at = errand;
    begin_queued(server);
}

lf_status lf_server_open_device(lf_server *server, const char *spec, lf_ticket *ticket, lf_error *err)
{
    lf_panel *panel = &server->panel;
    if (strlen(spec) >= sizeof panel->wanted) {
        return lf_error_set(err, LF_E_ARG, "device", "the spec is longer than %zu bytes", sizeof panel->wanted - 1);
    }
    if (panel->wanted[0] == '\0') { /* the first: wanted whether it is there or not */
        snprintf(panel->wanted, sizeof panel->wanted, "%s", spec);
        panel->patience_usec = REOPEN_USEC;
    }
    open_errand(server, spec, ++panel->wishes, false, ticket);
    return LF_OK;
}

/* While it was being opened, another was asked for, in another lane, and is there. */
static void come_too_late(lf_server *server, lf_errand *errand)
{
    close_device(server, errand->device);
    errand->device = NULL;
    errand->status = lf_error_set(&errand->err, LF_E_CANCELLED, errand->spec, "another device was chosen meanwhile");
}

/* A display that the kernel's driver shows on is shown on through the kernel, whatever was asked for. */
static void tell_detour(const lf_errand *errand, const lf_device *device)
{
    lf_device_info info;
    size_t n = strcspn(errand->spec, ":");
    device->ops->info(device, &info);
    if (strcmp(errand->spec, "auto") != 0 && (strncmp(errand->spec, info.kind, n) != 0 || info.kind[n] != '\0')) {
        lf_log(LF_LOG_INFO, "%s: the kernel's driver shows on it: shown on through that, as %s", errand->spec, info.spec);
    }
}

static void opened(lf_server *server, lf_errand *errand)
{
    lf_device *device = errand->device;
    if (errand->number < server->panel.taken) {
        come_too_late(server, errand);
        return;
    }
    errand->device = NULL;
    errand->status = take_device(server, device, &errand->err);
    if (errand->status == LF_OK) {
        server->panel.taken = errand->number;
        tell_detour(errand, device);
        memcpy(server->panel.wanted, errand->spec, sizeof server->panel.wanted);
        server->panel.patience_usec = REOPEN_USEC;
        tell_device(server);
        lf_server_pump(server);
        lf_ticket_reply(server, errand->ticket, lf_server_device_json(server));
    }
}

static bool worth_another_try(lf_status status)
{
    return status == LF_E_NODEV || status == LF_E_BUSY || status == LF_E_IO || status == LF_E_TIMEOUT;
}

/* Whether udev tells when the device that is wanted comes back. */
static bool will_be_told(const lf_server *server)
{
    return server->told_of_plugs && strncmp(server->panel.wanted, "sim:", 4) != 0;
}

/* Ever more rarely: finding out can take seconds, in which the panel may come back unseen, and may disturb others. */
static void try_later(lf_server *server, lf_status status)
{
    lf_panel *panel = &server->panel;
    if (status == LF_E_NODEV && will_be_told(server)) {
        panel->patience_usec = REOPEN_LAST_USEC;
    }
    lf_server_retry(server, panel->patience_usec);
    panel->patience_usec = panel->patience_usec < REOPEN_LAST_USEC / 2 ? 2 * panel->patience_usec : REOPEN_LAST_USEC;
}

/* Nothing is open now: what was closed for it comes back, or what was wanted before goes on being wanted. */
static void stays_missing(lf_server *server, const lf_errand *errand)
{
    lf_panel *panel = &server->panel;
    bool wanted = strcmp(errand->spec, panel->wanted) == 0;
    if (wanted) {
        panel->has_problem = true;
        panel->problem = errand->err;
        memcpy(panel->spec, errand->spec, sizeof panel->spec);
    }
    if (errand->before[0] != '\0' && !errand->again) {
        open_errand(server, errand->before, errand->number, false, NULL);
    } else if (!wanted || worth_another_try(errand->status)) {
        try_later(server, errand->status);
    }
    if (!errand->again || errand->before[0] != '\0') {
        tell_device(server);
    }
}

/* Devices that are missing, damaged or refused are all the same to a client: there is none. */
static void not_opened(lf_server *server, lf_errand *errand)
{
    if (server->panel.device == NULL) {
        stays_missing(server, errand);
    }
    if (errand->status == LF_E_IO || errand->status == LF_E_FORMAT) {
        errand->err.status = LF_E_NODEV;
    }
    lf_ticket_fail(server, errand->ticket, &errand->err, false);
}

/* The daemon's own attempt, at its start. */
static void first_opened(lf_server *server, const lf_errand *errand)
{
    if (errand->status != LF_OK && errand->status != LF_E_CANCELLED) {
        lf_log_error(&errand->err);
    }
    if (errand->status == LF_E_ARG) {
        server->exit_code = LF_EXIT_USAGE;
        lf_server_shutdown(server);
        return;
    }
    lf_server_begin(server);
}

static void drop_errand(lf_server *server, lf_errand *errand)
{
    (void)lf_error_set(&errand->err, LF_E_CANCELLED, "", "the daemon is shutting down");
    lf_ticket_fail(server, errand->ticket, &errand->err, false);
    lf_errand_destroy(errand);
}

void lf_server_drop_errands(lf_server *server)
{
    while (server->panel.queued != NULL) {
        lf_errand *errand = server->panel.queued;
        server->panel.queued = errand->next;
        drop_errand(server, errand);
    }
}

/* Whether "none" stands in for a panel. */
static bool is_stand_in(const lf_panel *panel)
{
    return panel->device != NULL && shows_nothing(panel->device) && strcmp(panel->wanted, "auto") == 0;
}

/* While no panel is there. */
static void look_again(lf_server *server)
{
    const lf_panel *panel = &server->panel;
    if (panel->plugged) { /* while it was being looked for */
        lf_server_retry(server, 0);
    } else if (is_stand_in(panel) && panel->found != LF_E_NODEV) { /* nothing need be plugged in for it to be usable */
        try_later(server, panel->found);
    } else if (is_stand_in(panel) && !server->told_of_plugs) {
        lf_server_retry(server, SEARCH_USEC);
    }
}

static void on_opened(void *reader, lf_letter *letter)
{
    lf_server *server = reader;
    lf_panel *panel = &server->panel;
    lf_errand *errand = (lf_errand *)(void *)letter;
    panel->opening[lf_lane_of(errand->spec)] = NULL;
    if (strcmp(errand->spec, "auto") == 0) {
        panel->found = errand->found;
    }
    if (server->stopping) {
        drop_errand(server, errand);
        return;
    }
    if (errand->status == LF_OK) {
        opened(server, errand);
    }
    if (errand->status != LF_OK) {
        not_opened(server, errand);
    }
    if (errand->at_start) {
        first_opened(server, errand);
    }
    lf_errand_destroy(errand);
    begin_queued(server);
    if (shows_nothing(panel->device)) {
        look_again(server);
    }
}

/* --------------------------------------------------------------------------------------------------------- trying again -- */

void lf_server_open_again(lf_server *server)
{
    lf_panel *panel = &server->panel;
    if (!is_opening(panel)) {
        open_errand(server, panel->wanted, panel->wishes, true, NULL);
    }
}

static int on_retry(sd_event_source *source, uint64_t usec, void *context)
{
    lf_server *server = context;
    lf_panel *panel = &server->panel;
    (void)source;
    (void)usec;
    sd_event_source_disable_unref(panel->retry);
    panel->retry = NULL;
    if (panel->device == NULL || is_stand_in(panel)) {
        lf_server_open_again(server);
    }
    lf_server_pump(server);
    return 0;
}

void lf_server_retry(lf_server *server, uint64_t usec)
{
    lf_panel *panel = &server->panel;
    double at = lf_time_now() + (double)usec * 1e-6;
    /* Never later than what is due already: what is plugged in may go on for ever. */
    if (!server->stopping && (panel->retry == NULL || at < panel->retry_at)) {
        sd_event_source_disable_unref(panel->retry);
        panel->retry = NULL;
        panel->retry_at = at;
        (void)sd_event_add_time_relative(server->event, &panel->retry, CLOCK_MONOTONIC, usec, 0, on_retry, server);
    }
}

void lf_server_plugged(lf_server *server, bool whole)
{
    if (shows_nothing(server->panel.device)) {
        server->panel.plugged = true;
        server->panel.patience_usec = REOPEN_USEC;
        lf_server_retry(server, whole ? 0 : PLUGGED_USEC);
    } else {
        lf_server_find_buttons(server);
        lf_server_check_calibration(server);
    }
}

/* ------------------------------------------------------------------------------------------------------------ told -- */

lf_device_counters lf_server_device_counters(const lf_server *server)
{
    const lf_panel *panel = &server->panel;
    lf_device_counters sum = {0};
    if (panel->device != NULL) {
        panel->device->ops->counters(panel->device, &sum);
    }
    sum.updates += panel->before.updates;
    sum.bytes += panel->before.bytes;
    sum.errors += panel->before.errors;
    return sum;
}

static json_t *info_json(const lf_device_info *info)
{
    return json_pack("{s:s, s:s, s:s, s:s, s:s, s:s, s:s}", "spec", info->spec, "kind", info->kind, "model", info->model, "serial",
                     info->serial, "calibration_from", info->calibration_from, "output", info->output, "problem", info->problem);
}

json_t *lf_server_device_json(const lf_server *server)
{
    const lf_panel *panel = &server->panel;
    lf_device_info info = {0};
    if (panel->device != NULL) {
        panel->device->ops->info(panel->device, &info);
    } else {
        (void)lf_escape(info.spec, sizeof info.spec, panel->spec);
        (void)lf_escape(info.problem, sizeof info.problem, panel->has_problem ? panel->problem.what : "not open");
    }
    json_t *told = info_json(&info);
    json_object_set_new(told, "present", json_boolean(panel->device != NULL));
    return told;
}

/* ----------------------------------------------------------------------------------------------------------- listing -- */

static void on_listed(void *reader, lf_letter *letter)
{
    lf_server *server = reader;
    lf_errand *errand = (lf_errand *)(void *)letter;
    json_t *list = json_array();
    for (int i = 0; i < errand->n_devices; i++) {
        if (server->panel.device != NULL && strcmp(errand->devices[i].spec, server->panel.spec) == 0) {
            server->panel.device->ops->info(server->panel.device, &errand->devices[i]); /* it is in use: by this daemon */
        }
        json_array_append_new(list, info_json(&errand->devices[i]));
    }
    lf_ticket_reply(server, errand->ticket, json_pack("{s:o, s:o}", "devices", list, "present", lf_server_device_json(server)));
    lf_errand_destroy(errand);
}

void lf_server_list_devices(lf_server *server, lf_ticket *ticket)
{
    lf_errand *errand = lf_errand_create(LF_ERRAND_LIST);
    if (errand == NULL) {
        lf_ticket_reply(server, ticket, NULL);
        return;
    }
    errand->letter.open = on_listed;
    errand->ticket = ticket;
    lf_opener_queue(server->opener, errand);
}
