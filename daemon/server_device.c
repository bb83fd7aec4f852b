#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <time.h>

#include "base/alloc.h"
#include "base/escape.h"
#include "base/log.h"
#include "daemon/server.h"

/* Between attempts to open a panel that is away, and after a push that failed. */
#define REOPEN_USEC 500000
#define REPUSH_USEC 20000
/* A device that is to be opened again is waited for so long; a simulated one with a push that stalls takes about as much. */
#define FAREWELL_SECONDS 3.0

static const lf_calibration *calibration_of(const lf_device *device)
{
    return device->ops->calibration(device);
}

static int on_retry(sd_event_source *source, uint64_t usec, void *context);

static void retry_later(lf_server *server, uint64_t usec)
{
    lf_panel *panel = &server->panel;
    if (!server->stopping) {
        sd_event_source_disable_unref(panel->retry);
        panel->retry = NULL;
        (void)sd_event_add_time_relative(server->event, &panel->retry, CLOCK_MONOTONIC, usec, 0, on_retry, server);
    }
}

/* ------------------------------------------------------------------------------------------------------- letting go -- */

/* Destroying a device may wait for its panel, which the event thread must not: every device gets a thread for that. */
struct lf_farewell {
    lf_farewell *next;
    pthread_t thread;
    lf_device *device;
    atomic_bool over;
};

static void *farewell_main(void *context)
{
    lf_farewell *farewell = context;
    pthread_setname_np(pthread_self(), "lf-farewell");
    lf_device_destroy(farewell->device);
    atomic_store_explicit(&farewell->over, true, memory_order_release);
    return NULL;
}

bool lf_server_end_farewells(lf_server *server, double end)
{
    for (lf_farewell **at = &server->panel.farewells; *at != NULL;) {
        lf_farewell *farewell = *at;
        while (!atomic_load_explicit(&farewell->over, memory_order_acquire) && lf_time_now() < end) {
            nanosleep(&(struct timespec){.tv_nsec = 2000000}, NULL);
        }
        if (!atomic_load_explicit(&farewell->over, memory_order_acquire)) {
            at = &farewell->next;
            continue;
        }
        pthread_join(farewell->thread, NULL);
        *at = farewell->next;
        lf_free(farewell);
    }
    return server->panel.farewells == NULL;
}

static void say_farewell(lf_server *server, lf_device *device)
{
    (void)lf_server_end_farewells(server, 0);
    lf_farewell *farewell = lf_calloc(1, sizeof *farewell);
    bool started = false;
    if (farewell != NULL) {
        sigset_t all, before;
        sigfillset(&all);
        farewell->device = device;
        pthread_sigmask(SIG_BLOCK, &all, &before);
        started = pthread_create(&farewell->thread, NULL, farewell_main, farewell) == 0;
        pthread_sigmask(SIG_SETMASK, &before, NULL);
    }
    if (!started) {
        lf_free(farewell);
        lf_device_destroy(device);
        return;
    }
    farewell->next = server->panel.farewells;
    server->panel.farewells = farewell;
}

/* Lets go of the device; its counters are kept. */
static void let_go(lf_server *server)
{
    lf_panel *panel = &server->panel;
    panel->in_flight = false;
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
    say_farewell(server, panel->device);
    panel->device = NULL;
}

static void tell_device(lf_server *server)
{
    lf_server_notify(server, LF_EVENT_DEVICE, "device", lf_server_device_json(server));
    lf_server_tell_status(server);
}

static void gone(lf_server *server)
{
    lf_panel *panel = &server->panel;
    lf_log(LF_LOG_INFO, "%s: unplugged", panel->spec);
    let_go(server);
    panel->has_problem = true;
    (void)lf_error_set(&panel->problem, LF_E_NODEV, panel->spec, "unplugged");
    tell_device(server);
    retry_later(server, REOPEN_USEC);
}

static void dispatch(lf_server *server)
{
    lf_panel *panel = &server->panel;
    switch (panel->device->ops->dispatch(panel->device)) {
    case LF_DEVICE_READY:
        if (panel->in_flight) {
            panel->in_flight = false;
            lf_server_shown(server, panel->flying_generation, panel->flying_level, panel->flying_passes);
        }
        break;
    case LF_DEVICE_BUSY:
        break;
    case LF_DEVICE_RETRY:
        panel->in_flight = false;
        panel->whole = true;
        retry_later(server, REPUSH_USEC);
        break;
    case LF_DEVICE_GONE:
        gone(server);
        break;
    }
}

static int on_device(sd_event_source *source, int fd, uint32_t events, void *context)
{
    lf_server *server = context;
    (void)source;
    (void)fd;
    (void)events;
    dispatch(server);
    if (!server->panel.whole) {
        lf_server_pump(server);
    }
    return 0;
}

/* The panel that frames are made for from now on. */
static void take_calibration(lf_server *server, const lf_calibration *calibration)
{
    lf_panel *panel = &server->panel;
    bool same = panel->has_calibration == (calibration != NULL) &&
                (calibration == NULL || memcmp(calibration, &panel->calibration, sizeof *calibration) == 0);
    panel->has_calibration = calibration != NULL;
    if (calibration != NULL) {
        panel->calibration = *calibration;
    }
    panel->number++;
    lf_engine_set_panel(server->engine, calibration, panel->number, panel->device->ops->views != NULL);
    if (!same) { /* also with nothing on stage: the first scene may be under way */
        lf_load *load = lf_load_create(LF_LOAD_APPLY);
        if (load != NULL) {
            lf_server_load(server, load, NULL);
        }
    }
}

static lf_status make_device(const lf_server *server, const char *spec, lf_device **out_device, lf_error *err)
{
    lf_calibration calibration;
    bool given = server->config.calibration != NULL;
    lf_status status = given ? lf_calibration_load(server->config.calibration, &calibration, err) : LF_OK;
    return status == LF_OK ? lf_device_open(spec, given ? &calibration : NULL, out_device, err) : status;
}

/* The panel is this device from now on (taken over whatever comes of it). */
static lf_status take_device(lf_server *server, lf_device *device, lf_error *err)
{
    lf_panel *panel = &server->panel;
    lf_device_info info;
    panel->device = device;
    device->ops->info(device, &info);
    snprintf(panel->spec, sizeof panel->spec, "%s", info.spec);
    panel->has_problem = false;
    panel->whole = true;
    int fd = device->ops->poll_fd(device);
    if (fd >= 0 && sd_event_add_io(server->event, &panel->io, fd, EPOLLIN, on_device, server) < 0) {
        let_go(server);
        return lf_error_set(err, LF_E_NOMEM, panel->spec, "out of memory");
    }
    take_calibration(server, calibration_of(device));
    lf_log(LF_LOG_INFO, "%s: %s%s%s", panel->spec, info.model, info.problem[0] != '\0' ? ": " : "", info.problem);
    return LF_OK;
}

static lf_status open_device(lf_server *server, const char *spec, lf_error *err)
{
    lf_device *device = NULL;
    lf_status status = make_device(server, spec, &device, err);
    return status == LF_OK ? take_device(server, device, err) : status;
}

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
    size_t n = strcspn(now, ":");
    if (strcmp(spec, "auto") == 0) {
        return true;
    }
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

/* The next device while the old one goes on; what is refused changes nothing. */
static lf_status change_device(lf_server *server, const char *spec, lf_error *err)
{
    lf_device *device = NULL;
    lf_status status = make_device(server, spec, &device, err);
    if (status == LF_E_BUSY && server->panel.farewells != NULL) {
        (void)lf_server_end_farewells(server, lf_time_now() + FAREWELL_SECONDS);
        status = make_device(server, spec, &device, err);
    }
    if (status != LF_OK) {
        return status;
    }
    let_go(server);
    return take_device(server, device, err);
}

lf_status lf_server_open_device(lf_server *server, const char *spec, lf_error *err)
{
    lf_panel *panel = &server->panel;
    lf_status status;
    if (panel->device != NULL && !may_be_same(panel->spec, spec)) {
        status = change_device(server, spec, err);
        if (status != LF_OK && panel->device != NULL) {
            return status;
        }
    } else {
        let_go(server);
        (void)lf_server_end_farewells(server, lf_time_now() + FAREWELL_SECONDS);
        status = open_device(server, spec, err);
    }
    sd_event_source_disable_unref(panel->retry);
    panel->retry = NULL;
    if (status != LF_OK) {
        snprintf(panel->spec, sizeof panel->spec, "%s", spec);
        panel->has_problem = true;
        if (err != NULL) {
            panel->problem = *err;
        }
    }
    if (status == LF_E_NODEV || status == LF_E_BUSY || status == LF_E_IO) {
        retry_later(server, REOPEN_USEC);
    }
    tell_device(server);
    lf_server_pump(server);
    return status;
}

static int on_retry(sd_event_source *source, uint64_t usec, void *context)
{
    lf_server *server = context;
    lf_panel *panel = &server->panel;
    (void)source;
    (void)usec;
    if (panel->device != NULL) {
        lf_server_pump(server);
        return 0;
    }
    char spec[sizeof panel->spec];
    snprintf(spec, sizeof spec, "%s", panel->spec);
    lf_error err;
    if (open_device(server, spec, &err) == LF_OK) {
        tell_device(server);
        lf_server_pump(server);
    } else {
        panel->problem = err;
        retry_later(server, REOPEN_USEC);
    }
    return 0;
}

/* ---------------------------------------------------------------------------------------------------------- frames -- */

static void give_views(lf_server *server, const lf_frame *frame)
{
    lf_device *device = server->panel.device;
    lf_mailbox *mailbox = lf_engine_mailbox(server->engine);
    if (device->ops->views == NULL) {
        return;
    }
    const lf_views8 *views = lf_mailbox_views(mailbox, frame);
    if (views != NULL) {
        device->ops->views(device, views, frame->columns, frame->rows);
    }
    lf_mailbox_views_done(mailbox);
}

/* What of frame differs from what the panel shows. */
static int rects_for(lf_server *server, const lf_frame *frame, lf_rect *rects)
{
    const lf_frame *current = lf_mailbox_current(lf_engine_mailbox(server->engine));
    bool comparable = current != NULL && current->panel == frame->panel && current->image.width == frame->image.width &&
                      current->image.height == frame->image.height;
    if (server->panel.whole || !comparable) {
        rects[0] = (lf_rect){.width = frame->image.width, .height = frame->image.height};
        return 1;
    }
    if (frame->against == current->number) {
        memcpy(rects, frame->rects, (size_t)frame->n_rects * sizeof *rects);
        return frame->n_rects;
    }
    return lf_changed_rects(&current->image, &frame->image, rects, LF_FRAME_MAX_RECTS);
}

static void push(lf_server *server, const lf_frame *frame)
{
    lf_panel *panel = &server->panel;
    lf_rect rects[LF_FRAME_MAX_RECTS];
    int n = rects_for(server, frame, rects);
    give_views(server, frame);
    if (n == 0) {
        lf_mailbox_shown(lf_engine_mailbox(server->engine));
        lf_server_shown(server, frame->generation, frame->level, frame->passes);
        return;
    }
    lf_status status = panel->device->ops->push(panel->device, &frame->image, rects, n, (uint64_t)frame->generation);
    lf_mailbox_shown(lf_engine_mailbox(server->engine));
    panel->whole = status != LF_OK;
    if (status == LF_E_NODEV) {
        gone(server);
        return;
    }
    if (status != LF_OK) {
        lf_log(LF_LOG_DEBUG, "%s: a push failed: %s", panel->spec, lf_status_name(status));
        retry_later(server, REPUSH_USEC);
        return;
    }
    panel->in_flight = true;
    panel->flying_generation = frame->generation;
    panel->flying_level = frame->level;
    panel->flying_passes = frame->passes;
    dispatch(server);
}

/* The frame to push next: the newest, or after a failure the one that did not get there. */
static const lf_frame *next_frame(lf_server *server)
{
    lf_mailbox *mailbox = lf_engine_mailbox(server->engine);
    const lf_frame *frame = lf_mailbox_take(mailbox);
    if (frame == NULL && server->panel.whole) {
        frame = lf_mailbox_current(mailbox);
    }
    return frame != NULL && frame->panel == server->panel.number ? frame : NULL;
}

void lf_server_pump(lf_server *server)
{
    lf_panel *panel = &server->panel;
    if (panel->device == NULL || panel->in_flight) {
        return;
    }
    const lf_frame *frame = next_frame(server);
    if (frame == NULL) {
        return;
    }
    if (panel->has_calibration && frame->image.data != NULL) {
        push(server, frame);
        return;
    }
    give_views(server, frame);
    panel->whole = false;
    lf_mailbox_shown(lf_engine_mailbox(server->engine));
    lf_server_shown(server, frame->generation, frame->level, frame->passes);
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
            dispatch(server);
        }
        lf_server_pump(server);
    }
    sd_event_source_disable_unref(panel->retry);
    panel->retry = NULL;
    let_go(server);
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
    return json_pack("{s:s, s:s, s:s, s:s, s:s, s:s, s:s, s:b}", "spec", info.spec, "kind", info.kind, "model", info.model,
                     "serial", info.serial, "calibration_from", info.calibration_from, "output", info.output, "problem",
                     info.problem, "present", panel->device != NULL);
}
