/* An ffmpeg that a signal has stopped: it is told of, waited for, and given up in the end. A script
 * takes its place, and waiting takes no time. */
#include "tests/testing.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>

#include "base/log.h"
#include "daemon/output/video.h"

/* Looks at the stopped script that pass until it goes on; -1 = it does not. */
static int looks_left;
static const char *folder;

static pid_t read_pid(void)
{
    char text[32] = "";
    FILE *file = fopen(lf_test_path(folder, "pid"), "r");
    bool read = file && fgets(text, sizeof text, file);
    if (file)
        fclose(file);
    return read ? (pid_t)strtol(text, NULL, 10) : 0;
}

static bool is_stopped(pid_t pid)
{
    siginfo_t info = {0};
    return pid > 0 && waitid(P_PID, (id_t)pid, &info, WSTOPPED | WNOHANG | WNOWAIT) == 0 &&
           info.si_pid == pid;
}

static void look(void)
{
    const pid_t pid = looks_left > 0 ? read_pid() : 0;
    if (is_stopped(pid) && --looks_left == 0)
        assert_int_equal(kill(pid, SIGCONT), 0);
}

int __real_nanosleep(const struct timespec *wanted, struct timespec *left);
int __wrap_nanosleep(const struct timespec *wanted, struct timespec *left);
int __real_poll(struct pollfd *fds, nfds_t n, int timeout);
int __wrap_poll(struct pollfd *fds, nfds_t n, int timeout);

int __wrap_nanosleep(const struct timespec *wanted, struct timespec *left)
{
    (void)wanted;
    look();
    return __real_nanosleep(&(struct timespec){.tv_nsec = 20000}, left);
}

int __wrap_poll(struct pollfd *fds, nfds_t n, int timeout)
{
    (void)timeout;
    look();
    return __real_poll(fds, n, 0);
}

/* Makes a video of one frame, which does not fit into a pipe, by this script; *out_log: what was
 * said of it. */
static lf_status make_video(const char *script, lf_error *err, char *out_log, size_t size)
{
    static uint8_t pixels[256 * 512 * 3];
    const lf_layout layout = {1, 1, 1, 512, 256, 2.0};
    const lf_output_source source = {.views8 = {1, 512, 256, sizeof pixels, 1536, pixels}};
    const lf_output_request request = {.kind = &lf_output_video, .layout = layout};
    lf_video_options options;
    lf_video *video = NULL;
    char log[PATH_MAX], name[PATH_MAX];
    *err = (lf_error){0};
    lf_param_defaults(lf_video_params, &options);
    assert_int_equal(chmod(lf_test_write(folder, "ffmpeg", script), 0755), 0);
    snprintf(log, sizeof log, "%s/log", folder);
    snprintf(name, sizeof name, "%s/v.mp4", folder);
    int before = dup(STDERR_FILENO), fd = open(log, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    dup2(fd, STDERR_FILENO);
    lf_status status = lf_video_create(name, &layout, &options, NULL, &video, err);
    if (status == LF_OK)
        status = lf_video_add(video, &request, &source, err);
    if (status == LF_OK)
        status = lf_video_finish(video, err);
    lf_video_destroy(video);
    dup2(before, STDERR_FILENO);
    close(before);
    ssize_t n = pread(fd, out_log, size - 1, 0);
    out_log[n > 0 ? n : 0] = '\0';
    close(fd);
    return status;
}

#define NOTES_ITSELF "#!/bin/sh\necho $$ > \"${0%/*}/pid\"\n"
#define STOPS_FIRST NOTES_ITSELF "kill -STOP $$\ncat >&3\n"
#define STOPS_LAST NOTES_ITSELF "cat >&3\nkill -STOP $$\n"

static const char told[] = "ffmpeg is stopped (signal 19); waiting for it to continue";

static bool is_there(const char *name)
{
    return access(lf_test_path(folder, name), F_OK) == 0;
}

/* Before it takes the pixels, and when it has them all. */
static void one_that_stays_stopped_is_given_up(void **state)
{
    static const char *const scripts[] = {STOPS_FIRST, STOPS_LAST};
    char log[4096];
    lf_error err;
    (void)state;
    for (int i = 0; i < 2; i++) {
        looks_left = -1;
        lf_assert_status(make_video(scripts[i], &err, log, sizeof log), LF_E_TIMEOUT, &err);
        assert_string_equal(err.what,
                            "has been stopped (signal 19) for 60 s, so the video is abandoned");
        assert_non_null(strstr(log, told));
        assert_null(strstr(strstr(log, told) + 1, told)); /* once */
        assert_false(is_there("v.mp4"));
        assert_int_equal(kill(read_pid(), 0), -1); /* it is ended */
        assert_int_equal(errno, ESRCH);
    }
}

static void one_that_goes_on_makes_its_video(void **state)
{
    static const char *const scripts[] = {STOPS_FIRST, STOPS_LAST};
    char log[4096];
    lf_error err;
    struct stat st;
    (void)state;
    for (int i = 0; i < 2; i++) {
        looks_left = 100;
        lf_status status = make_video(scripts[i], &err, log, sizeof log);
        lf_assert_ok(status, &err);
        assert_int_equal(stat(lf_test_path(folder, "v.mp4"), &st), 0);
        assert_int_equal(st.st_size, 256 * 512 * 3);
        assert_int_equal(unlink(lf_test_path(folder, "v.mp4")), 0);
    }
}

static int set_up(void **state)
{
    char path[PATH_MAX + 8192];
    folder = *state = lf_test_folder();
    lf_log_init("test", LF_LOG_INFO);
    signal(SIGPIPE, SIG_IGN);
    snprintf(path, sizeof path, "%s:%s", folder, getenv("PATH"));
    setenv("PATH", path, 1);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_that_stays_stopped_is_given_up),
        cmocka_unit_test(one_that_goes_on_makes_its_video),
    };
    return cmocka_run_group_tests(tests, set_up, lf_test_folder_teardown);
}
