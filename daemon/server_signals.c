#include <errno.h>
#include <inttypes.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/inotify.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/log.h"
#include "daemon/server.h"

#define USEC_PER_S UINT64_C(1000000)
/* At most 60 s are to be lost, with what saving itself takes. */
#define SAVE_USEC (45 * USEC_PER_S)
/* How much longer systemd is asked to wait for the first scene, every STATUS_USEC. */
#define START_MORE_USEC (60 * USEC_PER_S)
#define STATUS_USEC (5 * USEC_PER_S)
/* Editors write a file in several steps; it is read when it has been quiet for so long. */
#define QUIET_USEC 100000

/* --------------------------------------------------------------------------------------------------------- systemd -- */

void lf_server_tell_status(lf_server *server)
{
    lf_engine_status now;
    lf_engine_get_status(server->engine, &now);
    char error[sizeof server->error + 32];
    bool failed = server->stage == NULL && server->has_error;
    sd_notifyf(0, "STATUS=%s%s%s, generation %" PRId64 ", %.1f passes; panel %s%s%s", lf_server_state_name(server),
               failed ? ": " : "", failed ? lf_error_format(&server->error, error, sizeof error) : "", now.generation, now.passes,
               server->panel.spec, server->panel.device == NULL && server->panel.has_problem ? ": " : "",
               server->panel.device == NULL && server->panel.has_problem ? server->panel.problem.what : "");
}

void lf_server_ready(lf_server *server)
{
    if (!server->ready_sent) {
        server->ready_sent = true;
        sd_notify(0, "READY=1");
    }
    lf_server_tell_status(server);
}

void lf_server_reloaded(lf_server *server)
{
    if (server->reloads > 0 && --server->reloads == 0) {
        sd_notify(0, "READY=1");
    }
}

static int on_status_timer(sd_event_source *source, uint64_t usec, void *context)
{
    const lf_server *server = context;
    if (!server->ready_sent && !server->stopping) {
        sd_notifyf(0, "EXTEND_TIMEOUT_USEC=%" PRIu64, START_MORE_USEC); /* a large scene is being loaded */
    }
    lf_server_tell_status(context);
    (void)sd_event_source_set_time(source, usec + STATUS_USEC);
    return sd_event_source_set_enabled(source, SD_EVENT_ONESHOT);
}

/* --------------------------------------------------------------------------------------------------------- signals -- */

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
    if (!server->stopping) {
        sd_notifyf(0, "RELOADING=1\nMONOTONIC_USEC=%" PRIu64, (uint64_t)(lf_time_now() * 1e6));
        server->reloads++;
        lf_server_reload(server);
    }
    return 0;
}

/* ----------------------------------------------------------------------------------------------------------- timers -- */

static int on_run_over(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    lf_server_shutdown(context);
    return 0;
}

static int on_save_timer(sd_event_source *source, uint64_t usec, void *context)
{
    lf_server_save_state(context);
    (void)sd_event_source_set_time(source, usec + SAVE_USEC);
    return sd_event_source_set_enabled(source, SD_EVENT_ONESHOT);
}

/* ------------------------------------------------------------------------------------------------------------ watch -- */

static int on_quiet(sd_event_source *source, uint64_t usec, void *context)
{
    lf_server *server = context;
    (void)source;
    (void)usec;
    if (!server->stopping) {
        lf_server_reload(server);
    }
    return 0;
}

/* True when an event of this buffer names the watched file. */
static bool names_file(const char *bytes, size_t n, const char *name)
{
    for (size_t at = 0; at + sizeof(struct inotify_event) <= n;) {
        struct inotify_event event;
        memcpy(&event, bytes + at, sizeof event);
        if (event.len > 0 && strcmp(bytes + at + sizeof event, name) == 0) {
            return true;
        }
        at += sizeof event + event.len;
    }
    return false;
}

static int on_watch(sd_event_source *source, int fd, uint32_t events, void *context)
{
    lf_server *server = context;
    char bytes[4096];
    ssize_t n = read(fd, bytes, sizeof bytes);
    (void)source;
    (void)events;
    if (n > 0 && server->watch_name != NULL && names_file(bytes, (size_t)n, server->watch_name)) {
        sd_event_source_disable_unref(server->watch_timer);
        server->watch_timer = NULL;
        (void)sd_event_add_time_relative(server->event, &server->watch_timer, CLOCK_MONOTONIC, QUIET_USEC, 0, on_quiet, server);
    }
    return 0;
}

void lf_server_watch(lf_server *server)
{
    const char *file = server->stage != NULL ? server->stage->file : server->config.scene;
    char *folder = file != NULL && server->watch_fd >= 0 ? lf_path_folder(file) : NULL;
    if (folder == NULL) {
        return;
    }
    if (server->watch_id >= 0) {
        inotify_rm_watch(server->watch_fd, server->watch_id);
    }
    lf_free(server->watch_name);
    const char *slash = strrchr(file, '/');
    server->watch_name = lf_strdup(slash != NULL ? slash + 1 : file);
    server->watch_id = inotify_add_watch(server->watch_fd, folder, IN_CLOSE_WRITE | IN_MOVED_TO | IN_CREATE);
    if (server->watch_id < 0) {
        lf_log(LF_LOG_WARNING, "%s: cannot be watched: %s", folder, lf_errno_text(errno));
    }
    lf_free(folder);
}

static int begin_watch(lf_server *server)
{
    server->watch_fd = inotify_init1(IN_CLOEXEC | IN_NONBLOCK);
    if (server->watch_fd < 0) {
        return -errno;
    }
    int r = sd_event_add_io(server->event, &server->watch_io, server->watch_fd, EPOLLIN, on_watch, server);
    lf_server_watch(server);
    return r;
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
        r = sd_event_add_time_relative(event, &server->run_timer, CLOCK_MONOTONIC, usec, 0, on_run_over, server);
    }
    if (r >= 0 && server->config.state_dir != NULL) {
        r = sd_event_add_time_relative(event, &server->state_timer, CLOCK_MONOTONIC, SAVE_USEC, 0, on_save_timer, server);
    }
    if (r >= 0 && getenv("NOTIFY_SOCKET") != NULL) {
        r = sd_event_add_time_relative(event, &server->status_timer, CLOCK_MONOTONIC, STATUS_USEC, 0, on_status_timer, server);
    }
    if (r >= 0 && server->config.watch) {
        r = begin_watch(server);
    }
    return r >= 0 ? LF_OK : lf_error_set(err, LF_E_IO, "event loop", "cannot be set up: %s", lf_errno_text(-r));
}
