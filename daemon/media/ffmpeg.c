#include "daemon/media/ffmpeg.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/errno_text.h"
#include "base/log.h"
#include "base/spawn.h"

#define FILE_FD 3
#define NAP_MS 5
#define SAID_BYTES 65536
#define PIPE_BYTES (1 << 20) /* fewer switches between the processes; without it it works, too */
#define MOST_FILES 64

void lf_ffmpeg_add(lf_ffmpeg_words *words, const char *const more[])
{
    for (; *more; more++) {
        assert(words->n < (int)(sizeof words->list / sizeof words->list[0]) - 1);
        words->list[words->n++] = *more;
    }
}

/* Moves fd above the descriptors that the child gets. */
static int raised(int fd)
{
    int higher = fd < 0 ? -1 : fcntl(fd, F_DUPFD_CLOEXEC, FILE_FD + 1);
    if (fd >= 0)
        close(fd);
    return higher;
}

/* A memory file that cannot grow, so a talkative child does not fill the memory. */
static int make_said(const char *program)
{
    int fd = raised(memfd_create(program, MFD_CLOEXEC | MFD_ALLOW_SEALING));
    if (fd >= 0 && ftruncate(fd, SAID_BYTES) == 0 &&
        fcntl(fd, F_ADD_SEALS, F_SEAL_GROW | F_SEAL_SHRINK) == 0)
        return fd;
    if (fd >= 0)
        close(fd);
    return -1;
}

/* A shell sets the limits before it becomes the program, so no moment is without them. The shell
 * counts memory in units of 1024 bytes, and files in units of 512. */
static lf_ffmpeg_words limited(const lf_ffmpeg_words *words, const lf_ffmpeg_limits *limits,
                               char *script, size_t size)
{
    const struct {
        rlim_t most, unit;
        enum __rlimit_resource what;
        char option;
    } rows[] = {{limits->memory, 1024, RLIMIT_AS, 'v'},
                {SAID_BYTES, 512, RLIMIT_FSIZE, 'f'},
                {MOST_FILES, 1, RLIMIT_NOFILE, 'n'},
                {0, 512, RLIMIT_CORE, 'c'}};
    lf_ffmpeg_words out = {0};
    int used = 0;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        struct rlimit now = {.rlim_max = RLIM_INFINITY};
        (void)getrlimit(rows[i].what, &now);
        const rlim_t most = rows[i].most < now.rlim_max ? rows[i].most : now.rlim_max;
        used += snprintf(script + used, size - (size_t)used, "ulimit -%c %ju && ", rows[i].option,
                         (uintmax_t)(most / rows[i].unit));
        assert((size_t)used < size);
    }
    snprintf(script + used, size - (size_t)used, "exec \"$@\"");
    lf_ffmpeg_add(&out, (const char *const[]){"sh", "-c", script, "sh", NULL});
    lf_ffmpeg_add(&out, words->list);
    return out;
}

static bool is_in_path(const char *program, const char *path)
{
    char candidate[PATH_MAX];
    for (const char *from = path; *from;) {
        const size_t n = strcspn(from, ":");
        snprintf(candidate, sizeof candidate, "%.*s/%s", (int)n, from, program);
        if (access(candidate, X_OK) == 0)
            return true;
        from += n + (from[n] == ':');
    }
    return false;
}

/* Frames of tens of megabytes come and go. Kept by malloc, their pages are not zeroed for each
 * frame, which takes a third of ffmpeg's time. */
#define KEEPS_PAGES                                                                                \
    "GLIBC_TUNABLES=glibc.malloc.mmap_threshold=268435456:glibc.malloc.top_pad=134217728:"         \
    "glibc.malloc.trim_threshold=1073741824"

/* A child that reads foreign files gets only what it needs of our environment. */
static int spawn(lf_ffmpeg *child, const int fds[], const lf_ffmpeg_words *words,
                 const lf_ffmpeg_limits *limits)
{
    static char plain[] = "LC_ALL=C", keeps[] = KEEPS_PAGES;
    char path[8192], libraries[4096], script[256];
    char *few[5] = {plain, keeps, path};
    const char *own = getenv("PATH"), *own_libraries = getenv("LD_LIBRARY_PATH");
    if (!limits->given)
        return lf_spawn(child->program, fds, FILE_FD + 1, words->list, environ, &child->pid);
    own = own ? own : "/usr/local/bin:/usr/bin:/bin";
    snprintf(path, sizeof path, "PATH=%s", own);
    snprintf(libraries, sizeof libraries, "LD_LIBRARY_PATH=%s", own_libraries ? own_libraries : "");
    few[3] = own_libraries ? libraries : NULL;
    if (!is_in_path(child->program, own))
        return ENOENT;
    const lf_ffmpeg_words within = limited(words, limits, script, sizeof script);
    return lf_spawn("/bin/sh", fds, FILE_FD + 1, within.list, few, &child->pid);
}

static int start(lf_ffmpeg *child, const lf_ffmpeg_words *words, lf_ffmpeg_flow flow, int ends[2],
                 int file, const lf_ffmpeg_limits *limits)
{
    const bool reads = flow == LF_FFMPEG_READS;
    int theirs = raised(ends[reads ? 0 : 1]);
    child->pipe = raised(ends[reads ? 1 : 0]);
    child->said = make_said(child->program);
    file = fcntl(file, F_DUPFD_CLOEXEC, FILE_FD + 1);
    const int fds[FILE_FD + 1] = {reads ? theirs : -1, reads ? -1 : theirs, child->said, file};
    int failed = theirs < 0 || child->pipe < 0 || child->said < 0 || file < 0 ||
                         fcntl(child->pipe, F_SETFL, O_NONBLOCK) != 0
                     ? errno
                     : 0;
    (void)fcntl(child->pipe, F_SETPIPE_SZ, PIPE_BYTES);
    if (!failed)
        failed = spawn(child, fds, words, limits);
    if (theirs >= 0)
        close(theirs);
    if (file >= 0)
        close(file);
    return failed;
}

lf_status lf_ffmpeg_start(const char *program, const lf_ffmpeg_words *words, lf_ffmpeg_flow flow,
                          int file, const lf_ffmpeg_limits *limits, const char *purpose,
                          lf_ffmpeg *child, lf_error *err)
{
    int ends[2];
    *child = LF_FFMPEG_NONE;
    if (pipe2(ends, O_CLOEXEC) != 0)
        return lf_error_set(err, LF_E_IO, program, "cannot create a pipe: %s",
                            lf_errno_text(errno));
    child->program = program;
    int failed = start(child, words, flow, ends, file, limits);
    if (failed)
        lf_ffmpeg_end(child);
    if (failed == ENOENT)
        return lf_error_set(err, LF_E_IO, program,
                            "is not in PATH; install the package ffmpeg, which %s", purpose);
    return failed
               ? lf_error_set(err, LF_E_IO, program, "cannot be started: %s", lf_errno_text(failed))
               : LF_OK;
}

lf_status lf_ffmpeg_waited(lf_ffmpeg *child, int ms, lf_error *err)
{
    siginfo_t info = {0};
    if (child->pid == 0 || waitid(P_PID, (id_t)child->pid, &info, WSTOPPED | WNOHANG | WNOWAIT) ||
        info.si_pid != child->pid) {
        child->stopped_ms = 0;
        return LF_OK;
    }
    if (!child->told)
        lf_log(LF_LOG_WARNING, "%s is stopped (signal %d); waiting for it to continue",
               child->program, info.si_status);
    child->told = true;
    child->stopped_ms += ms;
    return child->stopped_ms < LF_FFMPEG_STOPPED_S * 1000
               ? LF_OK
               : lf_error_set(err, LF_E_TIMEOUT, child->program,
                              "has been stopped (signal %d) for %d s, so the video is abandoned",
                              info.si_status, LF_FFMPEG_STOPPED_S);
}

static int64_t worked_ns(const lf_ffmpeg *child)
{
    clockid_t clock;
    struct timespec worked = {0};
    if (clock_getcpuclockid(child->pid, &clock) == 0)
        (void)clock_gettime(clock, &worked);
    return (int64_t)worked.tv_sec * 1000000000 + worked.tv_nsec;
}

lf_status lf_ffmpeg_opening(lf_ffmpeg *child, int ms, lf_error *err)
{
    lf_status status = lf_ffmpeg_waited(child, ms, err);
    const int64_t now = worked_ns(child);
    const bool is_idle = now == child->worked_ns && child->stopped_ms == 0;
    child->worked_ns = now;
    child->idle_ms = is_idle ? child->idle_ms + ms : 0;
    return status != LF_OK || child->idle_ms < LF_FFMPEG_IDLE_S * 1000
               ? status
               : lf_error_set(err, LF_E_TIMEOUT, child->program,
                              "has done nothing for %d s; try the file with ffplay",
                              LF_FFMPEG_IDLE_S);
}

bool lf_ffmpeg_ended(lf_ffmpeg *child, int *out_status)
{
    if (child->pid > 0 && waitpid(child->pid, out_status, WNOHANG) == child->pid)
        child->pid = 0;
    return child->pid == 0;
}

lf_status lf_ffmpeg_await(lf_ffmpeg *child, bool (*stopped)(const void *context),
                          const void *context, const char *where, int *out_status, lf_error *err)
{
    while (!lf_ffmpeg_ended(child, out_status)) {
        if (stopped && stopped(context))
            return lf_error_set(err, LF_E_CANCELLED, where, "cancelled");
        nanosleep(&(struct timespec){.tv_nsec = NAP_MS * 1000000}, NULL);
        lf_status status = lf_ffmpeg_waited(child, NAP_MS, err);
        if (status != LF_OK)
            return status;
    }
    return LF_OK;
}

size_t lf_ffmpeg_said(const lf_ffmpeg *child, size_t offset, char *text, size_t size)
{
    ssize_t n = pread(child->said, text, size - 1, (off_t)offset);
    text[n > 0 ? n : 0] = '\0';
    return strlen(text);
}

/* Skips prefixes such as "[mov @ 0x55…] [error] ". */
static const char *without_prefixes(const char *line)
{
    while (*line == '[') {
        const char *end = strchr(line, ']');
        if (!end)
            break;
        line = end[1] == ' ' ? end + 2 : end + 1;
    }
    return line;
}

const char *lf_ffmpeg_first_line(char *text)
{
    static const char *const levels[] = {"[error] ", "[fatal] ", "[panic] "};
    char *first = NULL;
    for (size_t i = 0; i < sizeof levels / sizeof levels[0]; i++) {
        char *found = strstr(text, levels[i]);
        if (found && (!first || found < first))
            first = found;
    }
    if (!first)
        first = text;
    first[strcspn(first, "\n")] = '\0';
    return without_prefixes(first);
}

lf_status lf_ffmpeg_judge(const lf_ffmpeg *child, int status, lf_error *err)
{
    char text[4096], how[48];
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0)
        return LF_OK;
    (void)lf_ffmpeg_said(child, 0, text, sizeof text);
    const char *line = lf_ffmpeg_first_line(text);
    if (WIFSIGNALED(status))
        snprintf(how, sizeof how, "was ended by signal %d", WTERMSIG(status));
    else
        snprintf(how, sizeof how, "failed (exit status %d)", WEXITSTATUS(status));
    return lf_error_set(err, LF_E_IO, child->program, "%s%s%.300s", how, line[0] ? ": " : "", line);
}

void lf_ffmpeg_end(lf_ffmpeg *child)
{
    if (child->pipe >= 0)
        close(child->pipe);
    if (child->pid > 0) {
        kill(child->pid, SIGKILL);
        while (waitpid(child->pid, NULL, 0) < 0 && errno == EINTR)
            ;
    }
    if (child->said >= 0)
        close(child->said);
    *child = LF_FFMPEG_NONE;
}
