#include "base/sandbox/import.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/log.h"
#include "base/sandbox/import_group.h"
#include "base/sandbox/import_share.h"
#include "base/spawn.h"
#include "base/thread.h"

#define LOOK_MS 50 /* interval of checks for cancellation */

/* ------------------------------------------------------------------------------- the process -- */

static struct {
    lf_import_watch_fn look;
    void *context;
} watcher;

void lf_import_watch(lf_import_watch_fn watch, void *context)
{
    watcher.look = watch;
    watcher.context = context;
}

/* A file to read, possibly twice. */
typedef struct reading {
    double begun;
    lf_import_progress progress; /* the end is reported if the beginning was */
    bool told;
} reading;

typedef struct child {
    pid_t pid;
    int socket;
    double deadline;
    reading *file;
    bool late, stopped; /* why it was stopped */
} child;

static const char *const programs[] = {[LF_IMPORT_MESH] = "quiltimport",
                                       [LF_IMPORT_GRID] = "quiltimport-vdb",
                                       [LF_IMPORT_PICTURE] = "quiltimport-picture",
                                       [LF_IMPORT_INSTANCES] = "quiltimport",
                                       [LF_IMPORT_TEXTURE] = "quiltimport"};

/* The reader gets the socket, and no other descriptor. */
static int spawn(const char *path, int socket, pid_t *out_pid)
{
    const char *const words[] = {"quiltimport", NULL};
    const int fds[LF_IMPORT_SOCKET + 1] = {-1, -1, -1, socket};
    char *bare[2] = {NULL, NULL}; /* from the environment only the library path */
    char libraries[PATH_MAX];
    const char *where = secure_getenv("LD_LIBRARY_PATH");
    if (where && snprintf(libraries, sizeof libraries, "LD_LIBRARY_PATH=%s", where) < PATH_MAX)
        bare[0] = libraries;
    return lf_spawn(path, fds, LF_IMPORT_SOCKET + 1, words, bare, out_pid);
}

static lf_status begin_child(child *reader, lf_import_kind kind, lf_error *err)
{
    char path[PATH_MAX];
    int pair[2];
    lf_status status = lf_find_program(programs[kind], secure_getenv("QUILTIMPORT"), path, err);
    if (status != LF_OK)
        return status;
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair) != 0)
        return lf_error_set(err, LF_E_IO, path, "no socket: %s", strerror(errno));
    /* a descriptor that is to become itself would stay close-on-exec */
    if (pair[1] <= LF_IMPORT_SOCKET) {
        int higher = fcntl(pair[1], F_DUPFD_CLOEXEC, LF_IMPORT_SOCKET + 1);
        close(pair[1]);
        pair[1] = higher;
    }
    int failed = pair[1] < 0 ? errno : spawn(path, pair[1], &reader->pid);
    if (pair[1] >= 0)
        close(pair[1]);
    reader->socket = pair[0];
    if (!failed)
        return LF_OK;
    close(pair[0]);
    return lf_error_set(err, LF_E_IO, path, "cannot be started: %s", strerror(failed));
}

static void tell_watcher(reading *file, bool ended)
{
    file->progress.seconds = lf_time_now() - file->begun;
    file->progress.ended = ended;
    file->told = true;
    if (watcher.look && !lf_import_is_quiet())
        watcher.look(watcher.context, &file->progress);
}

/* Waits for a message or the end of the reader. False: it must be stopped. */
static bool await(child *reader)
{
    for (;;) {
        struct pollfd ready = {reader->socket, POLLIN, 0};
        tell_watcher(reader->file, false);
        reader->stopped = lf_import_is_stopped();
        reader->late = lf_time_now() > reader->deadline;
        if (reader->stopped || reader->late)
            return false;
        if (poll(&ready, 1, LOOK_MS) > 0)
            return true;
    }
}

/* Ends the reader; returns its exit status. */
static int end_child(child *reader)
{
    int how = 0;
    close(reader->socket);
    (void)kill(reader->pid, SIGKILL); /* all its messages have been read */
    while (waitpid(reader->pid, &how, 0) < 0 && errno == EINTR) {
    }
    return how;
}

/* -------------------------------------------------------------------------- the conversation -- */

static lf_status answer_open(child *reader, const lf_import_reply *ask, lf_import_open_fn open,
                             void *context)
{
    int fd = -1;
    bool needed = ask->step == LF_IMPORT_OPEN;
    lf_import_answer answer = {.status = open ? open(context, ask->text, needed, &fd) : LF_E_PATH};
    lf_status status = lf_import_send(reader->socket, &answer, sizeof answer, fd);
    if (fd >= 0)
        close(fd);
    return status;
}

static atomic_int landlock;

lf_landlock lf_import_landlock(void)
{
    return (lf_landlock)atomic_load(&landlock);
}

const char *lf_landlock_name(lf_landlock which)
{
    static const char *const names[] = {"unknown", "on", "off", "refused"};
    return names[which];
}

/* Records the reader's report, which is untrusted. */
static void note_landlock(uint32_t meta)
{
    static atomic_flag told = ATOMIC_FLAG_INIT;
    if (meta == LF_LANDLOCK_UNKNOWN || meta >= LF_N_LANDLOCK)
        return;
    atomic_store(&landlock, (int)meta);
    if (meta == LF_LANDLOCK_REFUSED && !atomic_flag_test_and_set(&told))
        lf_log(LF_LOG_WARNING, "file readers run without Landlock, which is blocked here, perhaps "
                               "by a system call filter; seccomp still confines them");
}

/* Converts the reader's failure to an error. Its text and status are untrusted. */
static lf_status failure(const lf_import_reply *reply, const char *where, lf_error *err)
{
    switch (reply->status) {
    case LF_E_NOMEM:
    case LF_E_IO:
    case LF_E_FORMAT:
    case LF_E_ARG:
        return lf_error_set(err, (lf_status)reply->status, where, "%s", reply->text);
    default:
        return lf_error_set(err, LF_E_FORMAT, where,
                            "the file reader failed without giving a reason");
    }
}

/* LF_E_STATE: it has ended, or breaks the protocol. */
static lf_status converse(child *reader, const char *where, lf_import_open_fn open, void *context,
                          lf_parcel *out, lf_error *err)
{
    lf_import_reply reply;
    int fd;
    while (await(reader)) {
        if (lf_import_receive(reader->socket, &reply, sizeof reply, &fd) != LF_OK)
            return LF_E_STATE;
        reply.text[sizeof reply.text - 1] = '\0';
        lf_status status = LF_OK;
        bool asks = reply.step == LF_IMPORT_OPEN || reply.step == LF_IMPORT_TRY;
        if (!asks)
            note_landlock(reply.landlock);
        if (asks)
            status = answer_open(reader, &reply, open, context);
        else if (reply.step == LF_IMPORT_FAILED)
            status = failure(&reply, where, err);
        else
            status = lf_parcel_open(fd, out, err);
        if (fd >= 0)
            close(fd);
        if (status == LF_E_IO && asks)
            return LF_E_STATE;
        if (status != LF_OK || !asks)
            return status;
    }
    return LF_E_STATE;
}

/* The error for a reader that ended without a reply. */
static lf_status say_how_it_ended(const child *reader, int how, const char *where, lf_error *err)
{
    int signal = WIFSIGNALED(how) ? WTERMSIG(how) : 0;
    if (reader->stopped)
        return lf_import_say_stopped(where, err);
    if (reader->late || signal == SIGXCPU)
        return lf_import_say_late(where, err);
    if (signal != 0 && signal != SIGKILL)
        return lf_error_set(err, LF_E_FORMAT, where,
                            "the file reader was ended by signal %d; the file is damaged or in "
                            "another format than its name says",
                            signal);
    return lf_error_set(err, LF_E_FORMAT, where,
                        "the file reader ended without a message; the file is damaged or in "
                        "another format than its name says");
}

/* True if more memory may help: it ran out of memory, or a library crashed without it. */
static bool is_starved(const child *reader, int how, lf_status status)
{
    const bool crashed = WIFSIGNALED(how) && WTERMSIG(how) != SIGXCPU;
    return status == LF_E_NOMEM ||
           (status == LF_E_STATE && crashed && !reader->late && !reader->stopped);
}

typedef struct attempt {
    lf_import_share share; /* its share of memory */
    double deadline;
    reading file;
    bool again; /* out: read again with more memory */
} attempt;

static lf_status run(lf_import_request *request, int fd, const char *where, lf_import_open_fn open,
                     void *context, attempt *trial, lf_parcel *out, lf_error *err)
{
    child reader = {.pid = -1, .deadline = trial->deadline, .file = &trial->file};
    const double left = trial->deadline - lf_time_now();
    if (lf_import_is_stopped())
        return lf_import_say_stopped(where, err);
    if (!(left > 0))
        return lf_import_say_late(where, err);
    request->version = LF_IMPORT_VERSION;
    request->asker = getpid();
    request->memory = trial->share.memory;
    request->seconds = (uint32_t)ceil(left);
    lf_status status = begin_child(&reader, (lf_import_kind)request->kind, err);
    if (status != LF_OK)
        return status;
    status = LF_E_STATE;
    if (lf_import_send(reader.socket, request, sizeof *request, fd) == LF_OK)
        status = converse(&reader, where, open, context, out, err);
    int how = end_child(&reader);
    trial->again =
        !trial->share.is_whole && is_starved(&reader, how, status) && lseek(fd, 0, SEEK_SET) == 0;
    if (status == LF_E_STATE)
        status = say_how_it_ended(&reader, how, where, err);
    return status;
}

lf_status lf_import_run(lf_import_request *request, int fd, const char *where,
                        lf_import_open_fn open, void *context, lf_parcel *out, lf_error *err)
{
    struct stat info;
    const uint64_t bytes = fstat(fd, &info) == 0 ? (uint64_t)info.st_size : 0;
    attempt trial = {.deadline = lf_import_begin_reading(),
                     .file = {lf_time_now(), {.path = where, .bytes = bytes}, false}};
    lf_status status;
    do {
        trial.share = lf_import_share_begin(trial.again);
        trial.again = false;
        status = run(request, fd, where, open, context, &trial, out, err);
        lf_import_share_end(&trial.share);
    } while (trial.again);
    if (trial.file.told)
        tell_watcher(&trial.file, true);
    lf_import_end_reading();
    return status;
}
