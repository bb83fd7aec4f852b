/* quiltfarm as a child process, whose output goes to memory files that do not grow. */
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/spawn.h"
#include "daemon/parts/farmed_internal.h"

#define SAID_BYTES ((size_t)4 << 20)
#define TOLD_BYTES ((size_t)1 << 16)
enum { N_STANDARD = 3 };

/* A memory file above the standard descriptors; -1: errno. */
static int make_file(size_t bytes)
{
    int low = memfd_create(LF_FARMED_PROGRAM, MFD_CLOEXEC | MFD_ALLOW_SEALING);
    int fd = low < 0 ? -1 : fcntl(low, F_DUPFD_CLOEXEC, N_STANDARD);
    if (low >= 0)
        close(low);
    if (fd >= 0 && ftruncate(fd, (off_t)bytes) == 0 &&
        fcntl(fd, F_ADD_SEALS, F_SEAL_GROW | F_SEAL_SHRINK) == 0)
        return fd;
    if (fd >= 0)
        close(fd);
    return -1;
}

/* Not for children: NOTIFY_SOCKET and what systemd says of its sockets are for quiltd. */
static bool is_ours(const char *variable)
{
    static const char *const names[] = {"NOTIFY_SOCKET=", "WATCHDOG_USEC=", "WATCHDOG_PID=",
                                        "LISTEN_PID=",    "LISTEN_FDS=",    "LISTEN_FDNAMES="};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strncmp(variable, names[i], strlen(names[i])) == 0)
            return true;
    return false;
}

/* Our environment without these (lf_free); the texts are borrowed. */
static char **make_environment(void)
{
    size_t n = 0, kept = 0;
    while (environ[n])
        n++;
    char **list = lf_calloc(n + 1, sizeof *list);
    for (size_t i = 0; list && i < n; i++)
        if (!is_ours(environ[i]))
            list[kept++] = environ[i];
    return list;
}

lf_status lf_farmed_start(const char *const words[], lf_farmed_child *child, lf_error *err)
{
    *child = (lf_farmed_child){.said = make_file(SAID_BYTES), .told = make_file(TOLD_BYTES)};
    char **environment = make_environment();
    const int fds[N_STANDARD] = {-1, child->said, child->told};
    int failed = !environment || child->said < 0 || child->told < 0 ? ENOMEM : 0;
    if (!failed)
        failed = lf_spawn(LF_FARMED_PROGRAM, fds, N_STANDARD, words, environment, &child->pid);
    lf_free(environment);
    child->open = true;
    if (!failed)
        return LF_OK;
    child->pid = 0;
    lf_farmed_drop(child, 0);
    if (failed == ENOENT)
        return lf_error_set(err, LF_E_IO, LF_FARMED_PROGRAM,
                            "is not in the PATH of quiltd; install it, or set PATH");
    return lf_error_set(err, LF_E_IO, LF_FARMED_PROGRAM, "cannot be started: %s",
                        lf_errno_text(failed));
}

bool lf_farmed_has_ended(lf_farmed_child *child, int *out_status)
{
    if (child->pid == 0 || waitpid(child->pid, out_status, WNOHANG) != child->pid)
        return false;
    child->pid = 0;
    return true;
}

/* A memory file up to its first zero; NULL: it is full, or out of memory. */
static char *text_of(int fd, size_t bytes)
{
    char *text = lf_calloc(bytes + 1, 1);
    const ssize_t n = text ? pread(fd, text, bytes, 0) : -1;
    if (n == (ssize_t)bytes && strlen(text) < bytes)
        return text;
    lf_free(text);
    return NULL;
}

char *lf_farmed_said(const lf_farmed_child *child)
{
    return text_of(child->said, SAID_BYTES);
}

/* The last line that is not empty; it begins at *out_begin. */
static const char *cut_line(char *text, size_t *out_begin)
{
    size_t n = strlen(text);
    while (n > 0 && (text[n - 1] == '\n' || text[n - 1] == '\r' || text[n - 1] == ' '))
        text[--n] = '\0';
    while (n > 0 && text[n - 1] != '\n' && text[n - 1] != '\r')
        n--;
    *out_begin = n;
    return text + n;
}

/* The last line without the program's name before it. If it blames quiltrender, the line before,
 * where quiltrender says why. */
static const char *last_line(char *text)
{
    static const char name[] = LF_FARMED_PROGRAM ": ", blamed[] = "quiltrender: ";
    size_t begin;
    const char *line = cut_line(text, &begin);
    if (strncmp(line, name, strlen(name)) != 0)
        return line;
    line += strlen(name);
    if (begin == 0 || strncmp(line, blamed, strlen(blamed)) != 0)
        return line;
    text[begin - 1] = '\0';
    const char *before = cut_line(text, &begin);
    return strncmp(before, blamed, strlen(blamed)) == 0 ? before : line;
}

lf_status lf_farmed_judge(const lf_farmed_child *child, const char *what, int status, lf_error *err)
{
    char where[64];
    snprintf(where, sizeof where, LF_FARMED_PROGRAM " %s", what);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0)
        return LF_OK;
    if (WIFSIGNALED(status))
        return lf_error_set(err, LF_E_IO, where, "was ended by signal %d", WTERMSIG(status));
    char *text = text_of(child->told, TOLD_BYTES);
    const char *line = text ? last_line(text) : "";
    lf_status judged =
        line[0] != '\0'
            ? lf_error_set(err, LF_E_IO, where, "%s", line)
            : lf_error_set(err, LF_E_IO, where, "ended with exit status %d", WEXITSTATUS(status));
    lf_free(text);
    return judged;
}

void lf_farmed_drop(lf_farmed_child *child, int signal)
{
    if (child->pid > 0 && signal != 0)
        kill(-child->pid, signal);
    if (child->pid > 0 && signal == SIGKILL)
        (void)waitpid(child->pid, NULL, 0);
    if (signal == SIGKILL)
        child->pid = 0;
    if (child->open && child->said >= 0)
        close(child->said);
    if (child->open && child->told >= 0)
        close(child->told);
    child->open = false;
}
