#include "daemon/server/server_internal.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/frame_name.h"
#include "base/import/import.h"
#include "base/log.h"
#include "base/wakeup.h"
#include "daemon/threads/turns.h"

/* On the way down: how long loads, jobs and the cancelled batch are waited for, and how long the
 * panel may take for the last frames. Together less than the 2 s promised. */
#define LEAVE_USEC 500000
#define FLUSH_MS 400
/* From the signal to the end, and after a save: what a device has not done by then is left out. */
#define LAST_SECONDS 1.7
#define CLOSE_SECONDS 0.8
/* With --state the batch in progress must end for its accumulation to be worth anything, and a save
 * before it. systemd is told once a second how much longer it may take; after MOST_SECONDS it is
 * cancelled all the same. */
#define BATCH_USEC 1000000
#define BATCH_MORE_USEC 10000000
#define MOST_SECONDS 60
#define DEFAULT_TARGET_ERROR 1e-4
/* Answers to a storm come by the thousand: whoever asks meanwhile does not wait for all of them. */
#define TASKS_A_TURN 16
/* The scene does not wait for a panel longer than this. */
#define BEGIN_USEC 10000000

/* ------------------------------------------------------------------------------ the way down -- */

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
    lf_log(LF_LOG_DEBUG, "loads or exports that are still under way are not waited for");
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

/* Rendering and saving have come to their ends. */
static bool is_settled(lf_server *server)
{
    return lf_engine_stopped(server->engine) && !lf_saver_is_busy(server->saver);
}

/* The batch in progress, or a save, is still not over: it gets more time, or none. */
static int on_batch_timer(sd_event_source *source, uint64_t usec, void *context)
{
    lf_server *server = context;
    if (is_settled(server)) {
        leave_soon(server);
        return 0;
    }
    if (lf_time_now() - server->life.stopped_at > MOST_SECONDS) {
        lf_log(LF_LOG_WARNING, "%s has taken %d s: it is cancelled",
               lf_saver_is_busy(server->saver) ? "saving" : "the batch in progress", MOST_SECONDS);
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
    lf_server_unlisten(server);
    lf_play_stop(server->play);
    lf_saver_stop(server->saver);
    lf_jobs_end(server->jobs);
    lf_engine_stop(server->engine, !saves);
    if (saves) {
        sd_notifyf(0, "EXTEND_TIMEOUT_USEC=%d", BATCH_MORE_USEC);
        (void)sd_event_add_time_relative(server->event, &server->life.stop_timer, CLOCK_MONOTONIC,
                                         BATCH_USEC, 0, on_batch_timer, server);
    } else {
        leave_soon(server);
    }
}

/* Exports, or a save, are under way. */
static bool has_jobs(const lf_server *server)
{
    lf_job_told job;
    return lf_saver_is_busy(server->saver) || lf_jobs_at(server->jobs, 0, &job);
}

bool lf_server_is_stopping(const lf_server *server)
{
    return server->life.phase >= LF_PHASE_STOPPING;
}

/* Called again whenever something that is waited for may have ended. */
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

/* Two saves at once could leave the older one behind. */
static void save_last(lf_server *server)
{
    if (is_settled(server))
        lf_saver_save_now(server->saver);
    else if (server->config.state_dir)
        lf_log(LF_LOG_WARNING, "the accumulation is not saved: %s did not come to an end",
               lf_saver_is_busy(server->saver) ? "an earlier save" : "rendering");
}

/* Ends what is left; threads that cannot be joined in time are left to the kernel. */
static void finish(lf_server *server)
{
    lf_show_close(server->show, FLUSH_MS);
    lf_inbox_read(&server->inbox, server); /* jobs that ended since the loop did */
    save_last(server);
    double end = server->life.stopped_at + LAST_SECONDS;
    if (server->config.state_dir)
        end = fmax(end, lf_time_now() + CLOSE_SECONDS);
    bool closed = lf_show_drain(server->show, end);
    lf_inbox_read(&server->inbox, server); /* and since then */
    if (closed && lf_engine_stopped(server->engine) && !has_jobs(server) &&
        lf_loader_pending(server->loader) == 0)
        return;
    lf_engine_abandon(server->engine);
    _exit(server->life.exit_code);
}

static void destroy(lf_server *server)
{
    lf_error over;
    (void)lf_error_set(&over, LF_E_CANCELLED, "", "the daemon is shutting down");
    server->life.phase = LF_PHASE_LEAVING;
    lf_show_end(server->show);
    lf_server_release_loads(server);
    lf_loader_destroy(server->loader);
    lf_engine_destroy(server->engine);
    lf_server_end_work(server);
    lf_server_fail_waits(server, &over, false);
    if (server->inbox.event_fd >= 0)
        lf_inbox_finish(&server->inbox, server);
    lf_server_drop_loading(server);
    lf_clients_destroy(server->clients);
    lf_server_unlisten(server);
    lf_show_destroy(server->show);
    lf_watch_destroy(server->watch);
    lf_server_drop_button_work(server);
    lf_play_destroy(server->play);
    lf_jobs_destroy(server->jobs);
    lf_saver_destroy(server->saver);
    sd_event_source_disable_unref(server->life.stop_timer);
    sd_event_source_disable_unref(server->life.begin_timer);
    sd_event_source_disable_unref(server->life.card.timer);
    sd_event_source_disable_unref(server->waits.more);
    sd_event_unref(server->event);
    lf_content_unref(server->content);
    lf_roots_finish(&server->roots);
    lf_free(server->export_root);
    if (server->engine_fd >= 0)
        close(server->engine_fd);
}

/* -------------------------------------------------------------------------- putting together -- */

/* A folder for the daemon's files, made when it is missing; canonical. */
static lf_status make_folder(const char *option, const char *folder, char **out, lf_error *err)
{
    if (mkdir(folder, 0777) != 0 && errno != EEXIST)
        return lf_error_set(err, LF_E_IO, option, "%s: cannot be made: %s", folder,
                            lf_errno_text(errno));
    char *real = realpath(folder, NULL);
    struct stat st;
    if (!real || stat(real, &st) != 0 || !S_ISDIR(st.st_mode)) {
        free(real);
        return lf_error_set(err, LF_E_IO, option, "%s: is not a folder", folder);
    }
    *out = lf_strdup(real);
    free(real);
    return *out ? LF_OK : lf_error_set(err, LF_E_NOMEM, option, "out of memory");
}

/* The folder of the scene given on the command line, and that of the file behind it when it is a
 * link. */
static void add_scene_roots(lf_server *server)
{
    const char *scene = server->config.scene;
    char *real = scene ? realpath(scene, NULL) : NULL;
    const char *names[] = {scene, real};
    for (int i = 0; i < 2 && names[i]; i++) {
        char *folder = lf_path_folder(names[i]);
        if (folder && lf_roots_add(&server->roots, folder, NULL) != LF_OK)
            lf_log(LF_LOG_DEBUG, "%s: is no folder to read from", folder);
        lf_free(folder);
    }
    free(real);
}

static lf_status make_roots(lf_server *server, lf_error *err)
{
    server->roots.closed = true;
    for (int i = 0; i < server->config.n_allow; i++) {
        lf_status status = lf_roots_add(&server->roots, server->config.allow[i], err);
        if (status != LF_OK)
            return status;
    }
    add_scene_roots(server);
    if (server->roots.n_roots == 0) {
        /* No roots at all would mean anywhere: this one is a root that nothing lies beneath. */
        server->roots.root[0] = lf_strdup("/dev/null");
        server->roots.n_roots = server->roots.root[0] ? 1 : 0;
        return server->roots.n_roots == 1
                   ? LF_OK
                   : lf_error_set(err, LF_E_NOMEM, "--allow-path", "out of memory");
    }
    return LF_OK;
}

static lf_status make_folders(lf_server *server, lf_error *err)
{
    lf_status status = make_roots(server, err);
    if (status == LF_OK && server->config.export_dir)
        status = make_folder("--export-dir", server->config.export_dir, &server->export_root, err);
    if (status == LF_OK && server->config.state_dir) {
        char *folder = NULL;
        status = make_folder("--state", server->config.state_dir, &folder, err);
        lf_free(folder);
    }
    return status == LF_OK ? lf_server_make_saver(server, err) : status;
}

static int on_inbox(sd_event_source *source, int fd, uint32_t events, void *context)
{
    lf_server *server = context;
    (void)source;
    (void)fd;
    (void)events;
    lf_inbox_read_some(&server->inbox, server, TASKS_A_TURN);
    return 0;
}

static lf_status make_loop(lf_server *server, lf_error *err)
{
    server->engine_fd = lf_wakeup_make();
    return sd_event_new(&server->event) >= 0 && server->engine_fd >= 0 &&
                   lf_inbox_init(&server->inbox) == LF_OK
               ? LF_OK
               : lf_error_set(err, LF_E_IO, "event loop", "cannot be made");
}

static lf_status make_threads(lf_server *server, lf_error *err)
{
    const lf_options *options = &server->options;
    lf_engine_controls controls = {
        .estimator = options->estimator,
        .target_error = options->target_error > 0 ? options->target_error : DEFAULT_TARGET_ERROR,
        .threads = options->threads,
        .has_exposure = options->has_exposure,
        .exposure = options->exposure,
        .guides = options->guides,
        .reconstruct = options->reconstruct,
    };
    lf_status status = lf_response_codes(&server->response, &controls.codes, err);
    controls.has_codes = true;
    if (status == LF_OK)
        status = lf_engine_create(&controls, server->engine_fd, &server->engine, err);
    if (status != LF_OK)
        return status;
    lf_engine_keep_states(server->engine, lf_saver_states(server->saver));
    status = lf_loader_create(server->engine, &server->roots, &server->inbox, &server->loader);
    status = status == LF_OK ? lf_server_make_waits(server) : status;
    status = status == LF_OK ? lf_server_make_work(server) : status;
    status = status == LF_OK ? lf_server_make_loading(server) : status;
    status = status == LF_OK ? lf_server_make_play(server) : status;
    status = status == LF_OK ? lf_server_make_jobs(server) : status;
    status = status == LF_OK ? lf_server_make_show(server) : status;
    status = status == LF_OK ? lf_server_make_card(server) : status;
    status = status == LF_OK ? lf_server_make_button_work(server) : status;
    if (status != LF_OK ||
        sd_event_add_io(server->event, NULL, server->inbox.event_fd, EPOLLIN, on_inbox, server) <
            0 ||
        sd_event_add_io(server->event, NULL, server->engine_fd, EPOLLIN, lf_server_on_engine,
                        server) < 0)
        return lf_error_set(err, LF_E_NOMEM, "event loop", "cannot be set up");
    return LF_OK;
}

static void on_client_gone(void *context, uint64_t client)
{
    lf_server *server = context;
    if (server->life.phase == LF_PHASE_LEAVING)
        return;
    lf_jobs_end_of(server->jobs, client);
    lf_server_end_loads_of_gone(server);
}

static lf_status open_socket(lf_server *server, lf_error *err)
{
    int fd = -1;
    lf_status status = lf_server_listen(server, &fd, err);
    if (status == LF_OK &&
        lf_clients_create(server->event, fd, lf_server_line, server, &server->clients) != LF_OK)
        status = lf_error_set(err, LF_E_NOMEM, "socket", "out of memory");
    if (status == LF_OK) {
        lf_clients_on_gone(server->clients, on_client_gone);
        lf_log(LF_LOG_INFO, "listening on %s",
               server->socket_path ? server->socket_path : "the socket from systemd");
    }
    return status;
}

static int on_begin_timer(sd_event_source *source, uint64_t usec, void *context)
{
    (void)source;
    (void)usec;
    lf_server_begin(context);
    return 0;
}

/* The device's first attempt; what comes of it ends nothing but a wrong --device or --calibration.
 */
static lf_status open_first(lf_server *server, lf_error *err)
{
    lf_calibration calibration;
    const char *given = server->config.calibration;
    lf_status status = given ? lf_calibration_load(given, &calibration, err) : LF_OK;
    if (status == LF_OK) {
        lf_show_watch_plugs(server->show);
        (void)sd_event_add_time_relative(server->event, &server->life.begin_timer, CLOCK_MONOTONIC,
                                         BEGIN_USEC, 0, on_begin_timer, server);
        status = lf_show_open(server->show, server->config.device, NULL, err);
    }
    return status;
}

static void load_first(lf_server *server, const char *scene)
{
    bool there = access(scene, R_OK) == 0 || lf_frame_name_varies(scene);
    int why = errno;
    lf_load *load = there ? lf_load_create(LF_LOAD_FILE) : NULL;
    if (!load) {
        /* Said here: a folder that is not there is no root either, and "outside" would be no help.
         */
        (void)lf_error_set(&server->error, LF_E_IO, scene, "cannot open: %s",
                           there ? "out of memory" : lf_errno_text(why));
        lf_log_error(&server->error);
        lf_server_tell_card(server);
        lf_server_ready(server);
        return;
    }
    load->file = lf_strdup(scene);
    lf_server_load(server, load, NULL);
}

/* Best with the panel's calibration, which says how to render. */
void lf_server_begin(lf_server *server)
{
    if (server->life.phase != LF_PHASE_OPENING)
        return;
    server->life.phase = LF_PHASE_RUNNING;
    if (server->config.scene)
        load_first(server, server->config.scene);
    else
        lf_server_ready(server);
    lf_server_release_loads(server);
    lf_server_tell_card(server);
}

static void prepare_process(void)
{
    sigset_t ours;
    sigemptyset(&ours);
    sigaddset(&ours, SIGTERM);
    sigaddset(&ours, SIGINT);
    sigaddset(&ours, SIGHUP);
    pthread_sigmask(SIG_BLOCK, &ours, NULL);
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN); /* a file too large is an error of write */
    /* Clients may pass many descriptors. */
    struct rlimit limit;
    if (getrlimit(RLIMIT_NOFILE, &limit) == 0) {
        limit.rlim_cur = limit.rlim_max < 16384 ? limit.rlim_max : 16384;
        (void)setrlimit(RLIMIT_NOFILE, &limit);
    }
}

int lf_server_run(const lf_server_config *config)
{
    lf_server *server = lf_calloc(1, sizeof *server);
    if (!server)
        return LF_EXIT_FAILED;
    *server = (lf_server){
        .config = *config, .engine_fd = -1, .lock_fd = -1, .inbox.event_fd = -1};
    server->options = config->options;
    server->response = config->response;
    server->life.started = lf_time_now();
    lf_error err;
    prepare_process();
    lf_status status = make_loop(server, &err);
    status = status == LF_OK ? make_folders(server, &err) : status;
    status = status == LF_OK ? make_threads(server, &err) : status;
    status = status == LF_OK ? lf_server_install(server, &err) : status;
    status = status == LF_OK ? open_socket(server, &err) : status;
    status = status == LF_OK ? open_first(server, &err) : status;
    int code = LF_EXIT_FAILED;
    if (status == LF_OK) {
        code = lf_turns_run(server->event, &server->life.longest_turn);
        code = code < 0 ? LF_EXIT_FAILED : code;
        server->life.exit_code = code;
        finish(server);
    } else {
        lf_log_error(&err);
        code = status == LF_E_ARG ? LF_EXIT_USAGE : LF_EXIT_FAILED;
    }
    destroy(server);
    lf_free(server);
    return code;
}
