/* Playback, saving, watching, waits, loading and quiltweb (daemon/parts), and reactions to their
 * events. */
#include "base/alloc.h"
#include "base/log.h"
#include "daemon/server/server_internal.h"

/* ------------------------------------------------------------------------------------ saving -- */

static bool on_asked(void *context, lf_saved *out_now)
{
    const lf_server *server = context;
    lf_engine_status now;
    if (!server->content || !server->content->scene)
        return false;
    lf_engine_get_status(server->engine, &now);
    *out_now = (lf_saved){.generation = now.generation, .passes = now.passes};
    return true;
}

static lf_status on_save(void *context, lf_error *err)
{
    const lf_server *server = context;
    return lf_engine_keep(server->engine, err);
}

static void on_saved(void *context)
{
    if (lf_server_is_stopping(context))
        lf_server_shutdown(context);
}

lf_status lf_server_make_saver(lf_server *server, lf_error *err)
{
    static const lf_saver_events events = {.asked = on_asked, .save = on_save, .ended = on_saved};
    const lf_saver_home home = {.folder = server->config.state_dir,
                                .usec = LF_SAVE_USEC,
                                .event = server->event,
                                .inbox = &server->inbox};
    return lf_saver_create(&home, &events, server, &server->saver, err);
}

/* ----------------------------------------------------------------------------------- playing -- */

lf_load *lf_server_frame_load(int frame)
{
    lf_load *load = lf_load_create(LF_LOAD_PATCH);
    if (load)
        load->patch = json_pack("{s:i}", "frame", frame);
    if (load && !load->patch) {
        lf_load_destroy(load);
        return NULL;
    }
    return load;
}

static bool on_due(void *context, int frame)
{
    lf_load *load = lf_server_frame_load(frame);
    if (!load)
        return false;
    load->played = true;
    lf_server_load(context, load, NULL);
    return true;
}

lf_status lf_server_make_play(lf_server *server)
{
    static const lf_play_events events = {.due = on_due};
    return lf_play_create(server->event, &events, server, &server->play);
}

/* ---------------------------------------------------------------------------------- watching -- */

static void on_file_changed(void *context)
{
    if (!lf_server_is_stopping(context))
        lf_server_reload(context);
}

lf_status lf_server_make_watch(lf_server *server, lf_error *err)
{
    static const lf_watch_events events = {.changed = on_file_changed};
    lf_status status = lf_watch_create(server->event, &events, server, &server->watch, err);
    if (status == LF_OK)
        lf_server_watch(server);
    return status;
}

/* ----------------------------------------------------------------------------------- waiting -- */

/* A frame may be shown before the loader has reported its scene, and the waiting client would query
 * that scene next. */
static lf_wait_state on_state(void *context, const lf_wait *wait)
{
    const lf_server *server = context;
    const lf_shown *shown = &server->shown;
    if (server->generation < shown->generation || shown->generation < wait->generation ||
        shown->level < wait->level)
        return LF_WAIT_ON;
    return lf_show_keeps(server->show, wait->generation, wait->level) ? LF_WAIT_OVER
                                                                      : LF_WAIT_SHOWN;
}

static bool on_is_vain(void *context, const lf_wait *wait)
{
    (void)context;
    return lf_deferred_is_vain(wait->call);
}

/* Fails if there is no picture and none is being made. */
static const lf_error *on_failed(void *context)
{
    const lf_server *server = context;
    bool failed = server->life.phase != LF_PHASE_LEAVING && !server->content &&
                  server->error.status != LF_OK && !server->life.held &&
                  lf_loader_pending(server->loader) == 0;
    return failed ? &server->error : NULL;
}

static void on_unwritten(void *context)
{
    const lf_server *server = context;
    lf_show_await_files(server->show);
}

static void on_answered(void *context, const lf_wait *wait)
{
    const lf_server *server = context;
    lf_deferred_reply(wait->call,
                      json_pack("{s:I, s:s}", "generation", (json_int_t)server->shown.generation,
                                "level", lf_level_name(server->shown.level)));
}

static void on_late(void *context, const lf_wait *wait)
{
    const lf_server *server = context;
    lf_error err;
    (void)lf_error_set(&err, LF_E_TIMEOUT, "wait", "the image was not %s within %g s%s",
                       lf_level_name(wait->level), wait->seconds,
                       lf_engine_get_controls(server->engine).paused
                           ? ", because rendering is paused; continue with render.set paused=false"
                           : "");
    lf_deferred_fail(wait->call, &err, false);
}

static void on_ended(void *context, const lf_wait *wait, const lf_error *err, bool scene)
{
    (void)context;
    lf_deferred_fail(wait->call, err, scene);
}

lf_status lf_server_make_waits(lf_server *server)
{
    static const lf_waits_events events = {.state = on_state,
                                           .is_vain = on_is_vain,
                                           .failed = on_failed,
                                           .unwritten = on_unwritten,
                                           .answered = on_answered,
                                           .late = on_late,
                                           .ended = on_ended};
    return lf_waits_create(server->event, &events, server, &server->waits);
}

/* ----------------------------------------------------------------------------------- reading -- */

/* A half-closed connection still waits for its answer. */
static bool on_vain_load(void *context, const lf_load *load)
{
    (void)context;
    return load->deferred && lf_deferred_is_vain(load->deferred);
}

static void on_reads(void *context, int64_t id, const lf_load_reading *reading)
{
    const lf_server *server = context;
    json_t *params = lf_reading_json(reading);
    if (params)
        json_object_set_new(params, "job", json_integer((json_int_t)id));
    lf_notify(server->clients, LF_EVENT_SCENE, "scene.load", params);
}

lf_status lf_server_make_loading(lf_server *server)
{
    static const lf_loading_events events = {.is_vain = on_vain_load, .reads = on_reads};
    return lf_loading_create(server->event, server->loader, &events, server, &server->loading);
}

/* ---------------------------------------------------------------------------------- quiltweb -- */

void lf_server_start_web(lf_server *server)
{
    lf_error err;
    const char *socket = server->listener.path;
    if (!server->config.web)
        return;
    lf_status status =
        socket ? lf_web_child_create(server->event, socket, server->config.web_port,
                                     &server->life.web, &err)
               : lf_error_set(&err, LF_E_STATE, "--web",
                              "the socket from systemd has no path; start quiltweb by itself");
    if (status != LF_OK)
        lf_log_error(&err);
}
