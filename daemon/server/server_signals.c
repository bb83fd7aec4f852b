#include <inttypes.h>
#include <signal.h>
#include <stdlib.h>
#include <systemd/sd-daemon.h>

#include "base/errno_text.h"
#include "base/thread.h"
#include "daemon/server/server_internal.h"

#define USEC_PER_S UINT64_C(1000000)
/* How much more time systemd is asked for while the first scene loads, every STATUS_USEC. */
#define START_MORE_USEC (60 * USEC_PER_S)
#define STATUS_USEC (5 * USEC_PER_S)

/* ----------------------------------------------------------------------------------- systemd -- */

static int on_status_timer(sd_event_source *source, uint64_t usec, void *context)
{
    const lf_server *server = context;
    if (!server->life.ready_sent && !lf_server_is_stopping(server)) {
        /* a large scene is being loaded */
        sd_notifyf(0, "EXTEND_TIMEOUT_USEC=%" PRIu64, START_MORE_USEC);
    }
    lf_server_tell_status(context);
    (void)sd_event_source_set_time(source, usec + STATUS_USEC);
    return sd_event_source_set_enabled(source, SD_EVENT_ONESHOT);
}

/* ----------------------------------------------------------------------------------- signals -- */

static int on_stop(sd_event_source *source, const struct signalfd_siginfo *info, void *context)
{
    (void)source;
    (void)info;
    lf_server_shutdown(context);
    return 0;
}

static int on_hangup(sd_event_source *source, const struct signalfd_siginfo *info, void *context)
{
    lf_server *server = context;
    (void)source;
    (void)info;
    if (!lf_server_is_stopping(server)) {
        sd_notifyf(0, "RELOADING=1\nMONOTONIC_USEC=%" PRIu64, (uint64_t)(lf_time_now() * 1e6));
        server->life.reloads++;
        if (!lf_server_reread_playlist(server))
            lf_server_reload(server);
    }
    return 0;
}

/* ------------------------------------------------------------------------------------ timers -- */

static int on_run_over(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    lf_server_shutdown(context);
    return 0;
}

lf_status lf_server_install(lf_server *server, lf_error *err)
{
    sd_event *event = server->event;
    int r = sd_event_add_signal(event, NULL, SIGTERM, on_stop, server);
    r = r < 0 ? r : sd_event_add_signal(event, NULL, SIGINT, on_stop, server);
    r = r < 0 ? r : sd_event_add_signal(event, NULL, SIGHUP, on_hangup, server);
    r = r < 0 ? r : sd_event_set_watchdog(event, true);
    if (r >= 0 && server->config.run_for > 0) {
        uint64_t usec = (uint64_t)(server->config.run_for * 1e6);
        r = sd_event_add_time_relative(event, NULL, CLOCK_MONOTONIC, usec, 0, on_run_over, server);
    }
    if (r >= 0 && getenv("NOTIFY_SOCKET"))
        r = sd_event_add_time_relative(event, NULL, CLOCK_MONOTONIC, STATUS_USEC, 0,
                                       on_status_timer, server);
    if (r < 0)
        return lf_error_set(err, LF_E_IO, "event loop", "cannot be set up: %s", lf_errno_text(-r));
    return server->config.watch ? lf_server_make_watch(server, err) : LF_OK;
}
