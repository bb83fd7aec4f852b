#include "daemon/farm/farm_process.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/escape.h"
#include "base/spawn.h"
#include "base/thread.h"
#include "daemon/farm/farm_words.h"

#define LOOK_SECONDS 2.0   /* between two calls of look */
#define TOUCH_SECONDS 60.0 /* between two touches of the file `running` */
#define MOST_TEXT ((size_t)64 << 20)
#define CANNOT_START 127

/* ----------------------------------------------------------------------------------- signals -- */

static volatile sig_atomic_t told;

static void on_signal(int number)
{
    told = number;
}

static void on_child(int number)
{
    (void)number;
}

void lf_farm_catch_signals(void)
{
    static const int numbers[] = {SIGTERM, SIGINT, SIGHUP};
    struct sigaction action = {.sa_handler = on_signal};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        sigaction(numbers[i], &action, NULL);
}

bool lf_farm_is_told_to_end(void)
{
    return told != 0;
}

/* Blocks what interrupts waiting; *out_before: the mask to wait with. */
static void block_signals(sigset_t *out_before)
{
    struct sigaction action = {.sa_handler = on_child, .sa_flags = SA_NOCLDSTOP};
    sigset_t ours;
    sigaction(SIGCHLD, &action, NULL);
    sigemptyset(&ours);
    sigaddset(&ours, SIGTERM);
    sigaddset(&ours, SIGINT);
    sigaddset(&ours, SIGHUP);
    sigaddset(&ours, SIGCHLD);
    sigprocmask(SIG_BLOCK, &ours, out_before);
}

/* ------------------------------------------------------------------------------------- umask -- */

static mode_t users_umask;
static bool has_own_umask;

void lf_farm_keep_others_out(void)
{
    users_umask = umask(077);
    has_own_umask = true;
    (void)umask(users_umask | S_IWGRP | S_IWOTH);
}

/* In a child. */
static void restore_umask(void)
{
    if (has_own_umask)
        (void)umask(users_umask);
}

/* -------------------------------------------------------------------------------------- find -- */

/* The whole path of a program in PATH. */
static bool find_in_path(const char *name, char path[PATH_MAX])
{
    const char *folders = getenv("PATH");
    for (size_t n; folders && *folders; folders += n + (folders[n] == ':')) {
        n = strcspn(folders, ":");
        if (n > 0 && snprintf(path, PATH_MAX, "%.*s/%s", (int)n, folders, name) < PATH_MAX &&
            access(path, X_OK) == 0)
            return true;
    }
    return false;
}

lf_status lf_farm_find(const char *name, char path[PATH_MAX], lf_error *err)
{
    if (lf_find_program(name, NULL, path, NULL) == LF_OK || find_in_path(name, path))
        return LF_OK;
    return lf_error_set(err, LF_E_IO, name,
                        "not found beside quiltfarm and in PATH; install it there");
}

/* ------------------------------------------------------------------------------------- start -- */

/* In the child: never returns. */
__attribute__((noreturn)) static void become(const lf_farm_run *run, pid_t parent, int out_fd,
                                             const sigset_t *mask)
{
    struct sigaction ignore = {.sa_handler = SIG_IGN}, usual = {.sa_handler = SIG_DFL};
    sigaction(SIGHUP, &ignore, NULL); /* of a lost connection: this program passes TERM on */
    sigaction(SIGTERM, &usual, NULL);
    sigaction(SIGINT, &usual, NULL);
    sigprocmask(SIG_SETMASK, mask, NULL);
    restore_umask();
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent || (run->folder && chdir(run->folder) != 0))
        _exit(CANNOT_START);
    const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
    dup2(nothing, STDIN_FILENO);
    dup2(out_fd, STDOUT_FILENO);
    dup2(out_fd, STDERR_FILENO);
    execvp(run->words[0], run->words);
    _exit(CANNOT_START);
}

static pid_t start(const lf_farm_run *run, const sigset_t *mask, int *out_fd)
{
    int fds[2];
    if (pipe2(fds, O_CLOEXEC) != 0)
        return -1;
    const pid_t parent = getpid(), pid = fork();
    if (pid == 0)
        become(run, parent, fds[1], mask);
    close(fds[1]);
    if (pid < 0)
        close(fds[0]);
    else
        *out_fd = fds[0];
    return pid;
}

/* ------------------------------------------------------------------------------------ listen -- */

/* What a program prints. */
typedef struct listener {
    lf_farm_run *run;
    int fd, log_fd;
    size_t n; /* length of the line so far */
    char line[sizeof((lf_farm_run *)0)->last];
} listener;

static void take_line(listener *l)
{
    l->line[l->n] = '\0';
    if (l->n > 0)
        lf_escape(l->run->last, sizeof l->run->last, l->line);
    l->n = 0;
}

static void take_bytes(listener *l, const char *bytes, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (bytes[i] == '\n' || bytes[i] == '\r')
            take_line(l);
        else if (l->n < sizeof l->line - 1)
            l->line[l->n++] = bytes[i];
}

static void write_all(int fd, const char *bytes, size_t n)
{
    while (n > 0) {
        const ssize_t done = write(fd, bytes, n);
        if (done < 0 && errno == EINTR)
            continue;
        if (done <= 0)
            return; /* what is printed helps a reader, and no result depends on it */
        bytes += done;
        n -= (size_t)done;
    }
}

/* Takes what is there. False: the program has closed its end. */
static bool listen_once(listener *l)
{
    char bytes[4096];
    const ssize_t n = read(l->fd, bytes, sizeof bytes);
    if (n < 0)
        return errno == EINTR || errno == EAGAIN;
    take_bytes(l, bytes, (size_t)n);
    if (l->log_fd >= 0)
        write_all(l->log_fd, bytes, (size_t)n);
    if (!l->run->quiet)
        write_all(STDERR_FILENO, bytes, (size_t)n);
    return n > 0;
}

/* -------------------------------------------------------------------------------------- wait -- */

static void note_end(lf_farm_run *run, int status, const struct rusage *used, double begun)
{
    run->signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    run->code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + run->signal;
    run->cpu_seconds = (double)used->ru_utime.tv_sec + (double)used->ru_stime.tv_sec +
                       1e-6 * ((double)used->ru_utime.tv_usec + (double)used->ru_stime.tv_usec);
    run->seconds = lf_time_now() - begun;
}

static void do_now_and_then(lf_farm_run *run, double *looked, double *touched)
{
    const double now = lf_time_now();
    if (run->look && now - *looked >= LOOK_SECONDS) {
        *looked = now;
        run->look(run->context);
    }
    if (run->running && now - *touched >= TOUCH_SECONDS) {
        *touched = now;
        (void)utimensat(AT_FDCWD, run->running, NULL, 0);
    }
}

static void wait_for(listener *l, pid_t pid, const sigset_t *mask)
{
    const double begun = lf_time_now();
    double looked = 0, touched = begun;
    bool is_passed_on = false, is_open = true;
    const struct timespec nap = {.tv_sec = 1};
    struct rusage used = {0};
    int status = 0;
    for (;;) {
        if (told && !is_passed_on) {
            is_passed_on = true;
            kill(pid, told == SIGTERM ? SIGINT : SIGTERM);
        }
        if (wait4(pid, &status, WNOHANG, &used) == pid)
            break;
        struct pollfd fd = {.fd = is_open ? l->fd : -1, .events = POLLIN};
        if (ppoll(&fd, 1, &nap, mask) > 0)
            is_open = listen_once(l);
        do_now_and_then(l->run, &looked, &touched);
    }
    /* what it has left in the pipe; its own children may hold the pipe open */
    (void)fcntl(l->fd, F_SETFL, O_NONBLOCK);
    errno = 0;
    while (is_open && errno == 0)
        is_open = listen_once(l);
    take_line(l);
    note_end(l->run, status, &used, begun);
}

lf_status lf_farm_process_run(lf_farm_run *run, lf_error *err)
{
    listener l = {.run = run, .fd = -1, .log_fd = -1};
    sigset_t before;
    if (run->log)
        l.log_fd = open(run->log, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0666);
    block_signals(&before);
    const pid_t pid = start(run, &before, &l.fd);
    if (pid >= 0) {
        wait_for(&l, pid, &before);
        close(l.fd);
    }
    sigprocmask(SIG_SETMASK, &before, NULL);
    if (l.log_fd >= 0)
        close(l.log_fd);
    if (pid < 0 || (run->code == CANNOT_START && run->last[0] == '\0'))
        return lf_error_set(err, LF_E_IO, run->words[0], "cannot be started; is it installed?");
    return LF_OK;
}

/* -------------------------------------------------------------------------------------- read -- */

static lf_status read_to_end(int fd, const char *where, char **out_text, lf_error *err)
{
    size_t room = 4096, n = 0;
    char *text = lf_calloc(room, 1);
    for (ssize_t got = 1; text && got != 0;) {
        if (n + 1 == room) {
            char *more = room < MOST_TEXT ? lf_calloc(2 * room, 1) : NULL;
            if (more)
                memcpy(more, text, n);
            lf_free(text);
            text = more;
            room *= 2;
            continue;
        }
        got = read(fd, text + n, room - n - 1);
        if (got < 0 && errno != EINTR) {
            lf_free(text);
            return lf_error_set(err, LF_E_IO, where, "cannot be read: %s", lf_errno_text(errno));
        }
        n += got > 0 ? (size_t)got : 0;
    }
    *out_text = text;
    return text ? LF_OK : lf_farm_no_memory(where, err);
}

lf_status lf_farm_process_read(char *const words[], char **out_text, int *out_code, lf_error *err)
{
    int fds[2], status = 0;
    if (pipe2(fds, O_CLOEXEC) != 0)
        return lf_error_set(err, LF_E_IO, words[0], "cannot be started: %s", lf_errno_text(errno));
    const pid_t pid = fork();
    if (pid == 0) {
        dup2(fds[1], STDOUT_FILENO);
        restore_umask();
        execvp(words[0], words);
        _exit(CANNOT_START);
    }
    close(fds[1]);
    lf_status result = pid > 0 ? read_to_end(fds[0], words[0], out_text, err) : LF_E_IO;
    close(fds[0]);
    while (pid > 0 && waitpid(pid, &status, 0) < 0 && errno == EINTR)
        ;
    *out_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    if (pid < 0 || (result == LF_OK && *out_code == CANNOT_START)) {
        if (result == LF_OK)
            lf_free(*out_text);
        *out_text = NULL;
        result = lf_error_set(err, LF_E_IO, words[0], "cannot be started; is it installed?");
    }
    return result;
}
