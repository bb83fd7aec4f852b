#include "daemon/parts/web_child.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/log.h"
#include "base/spawn.h"

#define PROGRAM "quiltweb"
enum { N_STANDARD = 3, NAPS = 20, NAP_MS = 10 };

struct lf_web_child {
    pid_t pid;   /* 0: it has ended */
    int pipe_fd; /* it ends when this is closed; -1: closed */
    sd_event_source *source;
};

static int on_end(sd_event_source *source, const siginfo_t *info, void *context)
{
    (void)source;
    lf_web_child *child = context;
    child->pid = 0;
    if (child->pipe_fd < 0)
        return 0;
    if (info->si_code != CLD_EXITED)
        lf_log(LF_LOG_ERROR, PROGRAM ": was ended by signal %d; restart quiltd to start it again",
               info->si_status);
    else if (info->si_status == EXIT_SUCCESS)
        lf_log(LF_LOG_INFO, PROGRAM ": has ended; restart quiltd to start it again");
    else if (info->si_status != EXIT_FAILURE)
        lf_log(LF_LOG_ERROR,
               PROGRAM ": has ended with exit status %d; restart quiltd to start it again",
               info->si_status);
    return 0;
}

/* Copies our standard output and error, so that no descriptor in fds is one that has to be
 * replaced. One that is closed stays -1. */
static lf_status start(lf_web_child *child, const char *path, const char *const words[], int input,
                       lf_error *err)
{
    int fds[N_STANDARD] = {fcntl(input, F_DUPFD_CLOEXEC, N_STANDARD),
                           fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, N_STANDARD),
                           fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, N_STANDARD)};
    /* not ours: NOTIFY_SOCKET, and what systemd says of its sockets, are for quiltd */
    char *bare[3] = {NULL, NULL, NULL};
    char libraries[PATH_MAX], journal[128];
    const char *where = secure_getenv("LD_LIBRARY_PATH"), *stream = getenv("JOURNAL_STREAM");
    int n = 0;
    if (where && snprintf(libraries, sizeof libraries, "LD_LIBRARY_PATH=%s", where) < PATH_MAX)
        bare[n++] = libraries;
    if (stream && snprintf(journal, sizeof journal, "JOURNAL_STREAM=%s", stream) < 128)
        bare[n++] = journal;
    int failed = fds[0] < 0 ? errno : lf_spawn(path, fds, N_STANDARD, words, bare, &child->pid);
    for (int i = 0; i < N_STANDARD; i++)
        if (fds[i] >= 0)
            close(fds[i]);
    return failed ? lf_error_set(err, LF_E_IO, path, "cannot be started: %s", lf_errno_text(failed))
                  : LF_OK;
}

lf_status lf_web_child_create(sd_event *event, const char *socket, int port, lf_web_child **out,
                              lf_error *err)
{
    char path[PATH_MAX], v4[32], v6[32];
    int ends[2];
    lf_web_child *child = NULL;
    snprintf(v4, sizeof v4, "127.0.0.1:%d", port);
    snprintf(v6, sizeof v6, "[::1]:%d", port);
    const char *const words[] = {PROGRAM, "--until-input-ends", "--socket", socket, "--listen",
                                 v4,      "--listen",           v6,         NULL};
    lf_status status = lf_find_program(PROGRAM, NULL, path, err);
    if (status != LF_OK)
        return status;
    if (pipe2(ends, O_CLOEXEC) != 0)
        return lf_error_set(err, LF_E_IO, PROGRAM, "no pipe: %s", lf_errno_text(errno));
    child = lf_calloc(1, sizeof *child);
    if (!child) {
        close(ends[0]);
        close(ends[1]);
        return lf_error_set(err, LF_E_NOMEM, PROGRAM, "out of memory");
    }
    *child = (lf_web_child){.pipe_fd = ends[1]};
    status = start(child, path, words, ends[0], err);
    close(ends[0]);
    if (status == LF_OK &&
        sd_event_add_child(event, &child->source, child->pid, WEXITED, on_end, child) < 0)
        status = lf_error_set(err, LF_E_NOMEM, PROGRAM, "cannot be watched");
    if (status != LF_OK) {
        lf_web_child_destroy(child);
        return status;
    }
    *out = child;
    return LF_OK;
}

void lf_web_child_stop(lf_web_child *child)
{
    if (!child || child->pipe_fd < 0)
        return;
    close(child->pipe_fd);
    child->pipe_fd = -1;
}

void lf_web_child_destroy(lf_web_child *child)
{
    if (!child)
        return;
    lf_web_child_stop(child);
    sd_event_source_disable_unref(child->source);
    for (int i = 0; child->pid > 0 && i < NAPS; i++)
        if (waitpid(child->pid, NULL, WNOHANG) != 0)
            child->pid = 0;
        else
            nanosleep(&(struct timespec){.tv_nsec = NAP_MS * 1000000L}, NULL);
    if (child->pid > 0) {
        kill(child->pid, SIGKILL);
        waitpid(child->pid, NULL, 0);
    }
    lf_free(child);
}
