/* Players of tests: a clock that the test sets, and waits that end at once while a script is
 * stuck. Functions are wrapped (wrap_test_movie_ in tests/module.mk). */
#ifndef LF_TESTS_DAEMON_PLAYERS_H
#define LF_TESTS_DAEMON_PLAYERS_H

#include "tests/daemon/movies.h"

#include <dirent.h>
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdatomic.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>

#include "base/log.h"
#include "base/thread.h"
#include "daemon/media/player.h"

/* A machine under a sanitizer may be slow. */
#define PATIENCE_S 600
#define FRAME_BYTES (3 * MOVIE_WIDTH * MOVIE_HEIGHT)

static const char *folder;
static char *path_before;

/* ------------------------------------------------------------------------- clock and waiting -- */

static _Atomic uint64_t clock_ns = 1000;
static _Atomic int n_waits;

/* A script has got stuck: waits end at once, with nothing. */
static inline bool is_stuck(void)
{
    char path[PATH_MAX]; /* buffers of lf_test_path would be used up */
    snprintf(path, sizeof path, "%s/stuck", folder);
    return access(path, F_OK) == 0;
}

uint64_t __wrap_lf_time_now_ns(void);
uint64_t __wrap_lf_time_now_ns(void)
{
    return atomic_load(&clock_ns);
}

int __real_ppoll(struct pollfd *fds, nfds_t n, const struct timespec *timeout,
                 const sigset_t *mask);
int __wrap_ppoll(struct pollfd *fds, nfds_t n, const struct timespec *timeout,
                 const sigset_t *mask);
int __wrap_ppoll(struct pollfd *fds, nfds_t n, const struct timespec *timeout, const sigset_t *mask)
{
    const struct timespec soon = {.tv_nsec = 20000}, most = {.tv_nsec = 50000000};
    atomic_fetch_add(&n_waits, 1);
    if (timeout && (timeout->tv_sec > 0 || timeout->tv_nsec > most.tv_nsec))
        timeout = &most; /* the test's clock may run faster */
    return __real_ppoll(fds, n, is_stuck() ? &soon : timeout, mask);
}

int __real_poll(struct pollfd *fds, nfds_t n, int timeout);
int __wrap_poll(struct pollfd *fds, nfds_t n, int timeout);
int __wrap_poll(struct pollfd *fds, nfds_t n, int timeout)
{
    return __real_poll(fds, n, is_stuck() ? 0 : timeout);
}

static inline void advance(double seconds)
{
    atomic_fetch_add(&clock_ns, (uint64_t)llround(seconds * 1e9));
}

static inline void nap(void)
{
    nanosleep(&(struct timespec){.tv_nsec = 2000000}, NULL);
}

static inline lf_player_status status_of(lf_player *player)
{
    lf_player_status now;
    lf_player_get_status(player, &now);
    return now;
}

/* Until n frames were due. */
static inline lf_player_status await_due(lf_player *player, uint64_t n)
{
    lf_player_status now = status_of(player);
    for (int i = 0; i < PATIENCE_S * 500 && now.due < n && !now.failed; i++, nap())
        now = status_of(player);
    assert_false(now.failed);
    assert_int_equal(now.due, n);
    return now;
}

static inline lf_player_status await_failure(lf_player *player)
{
    lf_player_status now = status_of(player);
    for (int i = 0; i < PATIENCE_S * 500 && !now.failed; i++, nap())
        now = status_of(player);
    assert_true(now.failed);
    return now;
}

/* ------------------------------------------------------------------------------- the fixture -- */

/* A script takes the place of a program. */
static inline void install(const char *name, const char *script)
{
    assert_int_equal(chmod(lf_test_write(folder, name, script), 0755), 0);
}

static inline void uninstall(const char *name)
{
    (void)unlink(lf_test_path(folder, "stuck"));
    assert_int_equal(unlink(lf_test_path(folder, name)), 0);
}

/* An ffmpeg that counts its starts. */
static inline void install_counter(void)
{
    (void)unlink(lf_test_path(folder, "starts"));
    install("ffmpeg", "#!/bin/sh\necho >> \"${0%/*}/starts\"\n"
                      "PATH=\"${PATH#*:}\" exec ffmpeg \"$@\"\n");
}

static inline int count_starts(void)
{
    struct stat st;
    return stat(lf_test_path(folder, "starts"), &st) == 0 ? (int)st.st_size : 0;
}

static _Atomic int n_news;

static inline void on_news(void *context)
{
    (void)context;
    atomic_fetch_add(&n_news, 1);
}

static inline lf_status open_tiles(const char *path, int columns, int rows, const lf_photo *photo,
                                   lf_player **out, lf_error *err)
{
    const lf_photo plain = {0};
    return lf_player_create(path, NULL, columns, rows, photo ? photo : &plain, NULL, out, err);
}

static inline lf_player *play(const char *path, bool once)
{
    lf_player *player;
    lf_error err;
    lf_assert_ok(open_tiles(path, 3, 2, NULL, &player, &err), &err);
    lf_player_set_once(player, once);
    lf_assert_ok(lf_player_start(player, on_news, NULL), NULL);
    return player;
}

/* Differences of these views from a frame of movies.h. */
static inline int differences(const lf_views8 *views, int frame)
{
    int n = 0;
    for (int v = 0; v < views->n_views; v++) {
        for (int y = 0; y < views->height; y++) {
            const uint8_t *row = lf_views8_row(views, v, y);
            for (int x = 0; x < views->width; x++) {
                uint8_t rgb[3];
                movie_pixel(frame, v % MOVIE_COLUMNS * MOVIE_VIEW_WIDTH + x,
                            (MOVIE_ROWS - 1 - v / MOVIE_COLUMNS) * MOVIE_VIEW_HEIGHT + y, rgb);
                n += memcmp(rgb, row + 3 * x, 3) != 0;
            }
        }
    }
    return n;
}

static inline void assert_takes(lf_player *player, int frame)
{
    lf_views8 views;
    assert_true(lf_player_take(player, &views));
    assert_int_equal(views.n_views, 6);
    assert_int_equal(views.width, MOVIE_VIEW_WIDTH);
    assert_int_equal(views.height, MOVIE_VIEW_HEIGHT);
    assert_int_equal(differences(&views, frame), 0);
    assert_int_not_equal(differences(&views, frame + 1), 0);
}

static inline int count_descriptors(void)
{
    DIR *dir = opendir("/proc/self/fd");
    int n = 0;
    assert_non_null(dir);
    while (readdir(dir))
        n++;
    closedir(dir);
    return n;
}

static inline void assert_no_child(void)
{
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
    assert_int_equal(errno, ECHILD);
}

static inline int set_up(void **state)
{
    char path[PATH_MAX + 8192];
    if (!movie_programs_exist()) {
        print_message("ffmpeg is not installed\n");
        return -1;
    }
    folder = *state = lf_test_folder();
    lf_log_init("test", LF_LOG_ERROR);
    signal(SIGPIPE, SIG_IGN);
    snprintf(path, sizeof path, "%s:%s", folder, getenv("PATH"));
    path_before = strdup(path);
    setenv("PATH", path, 1);
    return 0;
}

static inline int tear_down(void **state)
{
    free(path_before);
    return lf_test_folder_teardown(state);
}

#endif
