#include "daemon/server/server_internal.h"

#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/log.h"
#include "base/wakeup.h"
#include "daemon/threads/turns.h"

#define DEFAULT_TARGET_ERROR 1e-4
/* Under heavy load thousands of tasks arrive at once; other events are handled in between. */
#define TASKS_A_TURN 16
/* Longest time that the scene waits for a panel. */
#define BEGIN_USEC 10000000

static void destroy(lf_server *server)
{
    lf_error over;
    (void)lf_error_set(&over, LF_E_BUSY, "", "the daemon is shutting down");
    server->life.phase = LF_PHASE_LEAVING;
    lf_show_end(server->show);
    lf_server_release_loads(server);
    lf_loader_destroy(server->loader);
    lf_engine_destroy(server->engine);
    lf_parser_end(server->parser);
    if (server->inbox.event_fd >= 0)
        lf_inbox_read(&server->inbox, server); /* lines it had parsed */
    lf_releaser_destroy(server->releaser);
    server->releaser = NULL;
    lf_waits_fail(server->waits, &over, false);
    if (server->inbox.event_fd >= 0)
        lf_inbox_finish(&server->inbox, server);
    lf_loading_destroy(server->loading);
    lf_parser_destroy(server->parser);
    lf_clients_destroy(server->clients);
    lf_unlisten(&server->listener);
    lf_web_child_destroy(server->life.web);
    lf_show_destroy(server->show);
    lf_watch_destroy(server->watch);
    lf_presses_destroy(server->presses);
    lf_waits_destroy(server->waits);
    lf_play_destroy(server->play);
    lf_playlist_destroy(server->gallery.playlist);
    lf_free(server->gallery.folder.path);
    lf_errands_destroy(server->gallery.checks);
    lf_jobs_destroy(server->jobs);
    lf_farmed_destroy(server->gallery.farmed);
    lf_previews_destroy(server->gallery.previews);
    lf_library_destroy(server->gallery.library);
    lf_saver_destroy(server->saver);
    sd_event_source_disable_unref(server->life.stop_timer);
    lf_server_loan_forget(server);
    sd_event_source_disable_unref(server->life.begin_timer);
    sd_event_source_disable_unref(server->life.card.timer);
    sd_event_unref(server->event);
    lf_content_unref(server->content);
    lf_roots_finish(&server->roots);
    lf_free(server->export_root);
    if (server->engine_fd >= 0)
        close(server->engine_fd);
    lf_server_end_log(server);
}

/* -------------------------------------------------------------------------- putting together -- */

/* A folder for the daemon's files, created if missing; canonical. */
static lf_status make_folder(const char *option, const char *folder, char **out, lf_error *err)
{
    if (mkdir(folder, 0777) != 0 && errno != EEXIST)
        return lf_error_set(err, LF_E_IO, option, "cannot create the folder %s: %s", folder,
                            lf_errno_text(errno));
    char *real = realpath(folder, NULL);
    struct stat st;
    if (!real || stat(real, &st) != 0 || !S_ISDIR(st.st_mode)) {
        free(real);
        return lf_error_set(err, LF_E_IO, option, "%s is not a folder", folder);
    }
    *out = lf_strdup(real);
    free(real);
    return *out ? LF_OK : lf_error_set(err, LF_E_NOMEM, option, "out of memory");
}

/* Adds the folder of the command line's scene, and the folder of the target if it is a link. */
static void add_scene_roots(lf_server *server)
{
    const char *scene = server->config.scene;
    char *real = scene ? realpath(scene, NULL) : NULL;
    const char *names[] = {scene, real};
    for (int i = 0; i < 2 && names[i]; i++) {
        char *folder = lf_path_folder(names[i]);
        if (folder && lf_roots_add(&server->roots, folder, NULL) != LF_OK)
            lf_log(LF_LOG_DEBUG, "%s: is not a readable folder", folder);
        lf_free(folder);
    }
    free(real);
}

static lf_status make_roots(lf_server *server, lf_error *err)
{
    const char *played = server->config.playlist.folder;
    server->roots.closed = true;
    lf_status of_played = played ? lf_roots_add(&server->roots, played, err) : LF_OK;
    if (of_played != LF_OK)
        return of_played;
    for (int i = 0; i < server->config.n_allow; i++) {
        lf_status status = lf_roots_add(&server->roots, server->config.allow[i], err);
        if (status != LF_OK)
            return status;
    }
    add_scene_roots(server);
    if (server->roots.n_roots == 0) {
        /* An empty list would allow all paths, so this root has no files in it. */
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
               : lf_error_set(err, LF_E_IO, "event loop", "cannot be created");
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
        .denoise = options->denoise,
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
    status = status == LF_OK ? lf_releaser_create(&server->inbox, &server->releaser) : status;
    status = status == LF_OK ? lf_server_make_loading(server) : status;
    status = status == LF_OK ? lf_server_make_play(server) : status;
    status = status == LF_OK ? lf_server_make_playlist(server) : status;
    status = status == LF_OK ? lf_server_make_jobs(server) : status;
    status = status == LF_OK ? lf_server_make_farmed(server) : status;
    status = status == LF_OK ? lf_server_make_previews(server) : status;
    status = status == LF_OK ? lf_server_make_library(server) : status;
    status = status == LF_OK ? lf_server_make_log(server) : status;
    status = status == LF_OK ? lf_server_make_show(server) : status;
    status = status == LF_OK ? lf_server_make_card(server) : status;
    status = status == LF_OK ? lf_server_make_presses(server) : status;
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
    lf_previews_end_of(server->gallery.previews, client);
    lf_library_end_of(server->gallery.library, client);
    lf_errands_end_of(server->gallery.checks, client);
    lf_server_doctor_end_of(server, client);
    lf_server_loan_end_of(server, client);
    /* Requests of clients that have left are executed, but only if few wait: nobody can fill the
     * queue by connecting and leaving. */
    if (lf_clients_left_much(server->clients))
        lf_loading_end_vain(server->loading);
}

static lf_status open_socket(lf_server *server, lf_error *err)
{
    int fd = -1;
    lf_status status = lf_listen(server->config.socket, &server->listener, &fd, err);
    if (status == LF_OK &&
        lf_clients_create(server->event, fd, lf_server_line, server, &server->clients) != LF_OK)
        status = lf_error_set(err, LF_E_NOMEM, "socket", "out of memory");
    if (status == LF_OK && lf_server_make_parser(server) != LF_OK)
        status = lf_error_set(err, LF_E_NOMEM, "socket", "out of memory");
    if (status == LF_OK) {
        lf_clients_on_gone(server->clients, on_client_gone);
        lf_log(LF_LOG_INFO, "listening on %s",
               server->listener.lock_fd >= 0 ? server->listener.path : "the socket from systemd");
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

/* Opens the first device. Only a wrong --device or --calibration ends the daemon. */
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

static void prepare_process(void)
{
    sigset_t ours;
    sigemptyset(&ours);
    sigaddset(&ours, SIGTERM);
    sigaddset(&ours, SIGINT);
    sigaddset(&ours, SIGHUP);
    sigaddset(&ours, SIGCHLD); /* quiltweb's end */
    pthread_sigmask(SIG_BLOCK, &ours, NULL);
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN); /* writing too large a file is an error of write */
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
    *server = (lf_server){.config = *config,
                          .engine_fd = -1,
                          .life.log.fd = -1,
                          .listener.lock_fd = -1,
                          .inbox.event_fd = -1};
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
        lf_server_start_web(server);
        lf_server_take_up_farmed(server);
        code = lf_turns_run(server->event, &server->life.longest_turn);
        code = code < 0 ? LF_EXIT_FAILED : code;
        server->life.exit_code = code;
        lf_server_finish(server);
    } else {
        lf_log_error(&err);
        code = status == LF_E_ARG ? LF_EXIT_USAGE : LF_EXIT_FAILED;
    }
    destroy(server);
    lf_free(server);
    return code;
}
