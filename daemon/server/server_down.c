/* Shutdown: which parts are waited for, and how long. */
#include <math.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include "base/log.h"
#include "base/sandbox/import.h"
#include "base/thread.h"
#include "daemon/server/server_internal.h"

/* Waiting times at shutdown: for loads, jobs and the cancelled batch, and for the panel's last
 * frames. Together less than the promised 2 s. */
#define LEAVE_USEC 500000
#define FLUSH_MS 400
/* From the signal to the end, and after a save; a device that has not finished by then is
 * abandoned. */
#define LAST_SECONDS 1.7
#define CLOSE_SECONDS 0.8
/* With --state the batch in progress must end, because its accumulation is saved, and so must a
 * save before it. systemd is asked once a second for more time; after MOST_SECONDS both are
 * cancelled. */
#define BATCH_USEC 1000000
#define BATCH_MORE_USEC 10000000
#define MOST_SECONDS 60

static void leave(lf_server *server)
{
    server->life.phase = LF_PHASE_LEAVING;
    sd_event_exit(server->event, server->life.exit_code);
}

static int on_leave_timer(sd_event_source *source, uint64_t usec, void *context)
{
    lf_server *server = context;
    (void)source;
    (void)usec;
    lf_log(LF_LOG_DEBUG, "exiting without waiting for the remaining loads and exports");
    leave(server);
    return 0;
}

static void leave_soon(lf_server *server)
{
    sd_event_source_disable_unref(server->life.stop_timer);
    server->life.stop_timer = NULL;
    (void)sd_event_add_time_relative(server->event, &server->life.stop_timer, CLOCK_MONOTONIC,
                                     LEAVE_USEC, 0, on_leave_timer, server);
}

/* True if rendering and saving have ended. */
static bool is_settled(lf_server *server)
{
    return lf_engine_stopped(server->engine) && !lf_saver_is_busy(server->saver);
}

/* The batch in progress or a save has not ended: extends its time or cancels it. */
static int on_batch_timer(sd_event_source *source, uint64_t usec, void *context)
{
    lf_server *server = context;
    if (is_settled(server)) {
        leave_soon(server);
        return 0;
    }
    if (lf_time_now() - server->life.stopped_at > MOST_SECONDS) {
        lf_log(LF_LOG_WARNING, "%s has taken %d s and is cancelled",
               lf_saver_is_busy(server->saver) ? "saving" : "the current batch", MOST_SECONDS);
        lf_engine_stop(server->engine, true);
        leave_soon(server);
        return 0;
    }
    sd_notifyf(0, "EXTEND_TIMEOUT_USEC=%d", BATCH_MORE_USEC);
    (void)sd_event_source_set_time(source, usec + BATCH_USEC);
    return sd_event_source_set_enabled(source, SD_EVENT_ONESHOT);
}

static void begin_way_down(lf_server *server)
{
    bool saves = server->config.state_dir;
    server->life.phase = LF_PHASE_STOPPING;
    lf_import_stop();
    lf_show_stop(server->show);
    server->life.stopped_at = lf_time_now();
    sd_notify(0, "STOPPING=1");
    lf_clients_close_listener(server->clients);
    lf_unlisten(&server->listener);
    lf_web_child_stop(server->life.web);
    lf_play_stop(server->play);
    lf_playlist_stop(server->gallery.playlist);
    lf_saver_stop(server->saver);
    lf_jobs_end(server->jobs);
    lf_farmed_leave(server->gallery.farmed);
    lf_previews_end(server->gallery.previews);
    lf_library_end(server->gallery.library);
    lf_errands_end(server->gallery.checks);
    lf_engine_stop(server->engine, !saves);
    if (saves) {
        sd_notifyf(0, "EXTEND_TIMEOUT_USEC=%d", BATCH_MORE_USEC);
        (void)sd_event_add_time_relative(server->event, &server->life.stop_timer, CLOCK_MONOTONIC,
                                         BATCH_USEC, 0, on_batch_timer, server);
    } else {
        leave_soon(server);
    }
}

/* True if exports, threads of farm jobs, previews, library calls or a save are in progress. */
static bool has_jobs(const lf_server *server)
{
    lf_job_told job;
    lf_farmed_told farmed;
    return lf_saver_is_busy(server->saver) || lf_previews_busy(server->gallery.previews) ||
           lf_library_busy(server->gallery.library) ||
           lf_errands_count(server->gallery.checks) > 0 || lf_jobs_at(server->jobs, 0, &job) ||
           lf_farmed_at(server->gallery.farmed, 0, &farmed);
}

bool lf_server_is_stopping(const lf_server *server)
{
    return server->life.phase >= LF_PHASE_STOPPING;
}

/* Called again whenever a part that is waited for may have ended. */
void lf_server_shutdown(lf_server *server)
{
    if (server->life.phase == LF_PHASE_LEAVING)
        return;
    if (!lf_server_is_stopping(server))
        begin_way_down(server);
    if (lf_engine_stopped(server->engine) && !has_jobs(server) &&
        lf_loader_pending(server->loader) == 0)
        leave(server);
}

/* Saves after the save in progress; two at once could keep the older one. */
static void save_last(lf_server *server)
{
    if (is_settled(server))
        lf_saver_save_now(server->saver);
    else if (server->config.state_dir)
        lf_log(LF_LOG_WARNING, "the rendering state was not saved, because %s did not end in time",
               lf_saver_is_busy(server->saver) ? "an earlier save" : "rendering");
}

void lf_server_finish(lf_server *server)
{
    lf_show_close(server->show, FLUSH_MS);
    lf_inbox_read(&server->inbox, server); /* jobs that have ended since the loop */
    save_last(server);
    double end = server->life.stopped_at + LAST_SECONDS;
    if (server->config.state_dir)
        end = fmax(end, lf_time_now() + CLOSE_SECONDS);
    bool closed = lf_show_drain(server->show, end);
    lf_inbox_read(&server->inbox, server); /* and tasks since then */
    if (closed && lf_engine_stopped(server->engine) && !has_jobs(server) &&
        lf_loader_pending(server->loader) == 0)
        return;
    lf_engine_abandon(server->engine);
    lf_web_child_destroy(server->life.web);
    _exit(server->life.exit_code);
}
