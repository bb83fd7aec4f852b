#include "daemon/parts/watch.h"

#include <errno.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/inotify.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/file.h"
#include "base/log.h"

/* Editors write a file in several steps; it is read once it was unchanged for this long. */
#define QUIET_USEC 100000

/* A watched file, through its folder. */
typedef struct watched {
    int id; /* inotify's, the same for all files of a folder; -1 = the folder cannot be watched */
    char *name;
} watched;

struct lf_watch {
    lf_watch_events events;
    void *context;
    sd_event *event;
    int fd; /* inotify's */
    int n;
    watched *files;
    sd_event_source *io, *timer;
};

static int on_quiet(sd_event_source *source, uint64_t usec, void *context)
{
    const lf_watch *watch = context;
    (void)source;
    (void)usec;
    watch->events.changed(watch->context);
    return 0;
}

static bool is_watched(const lf_watch *watch, int id, const char *name)
{
    for (int i = 0; i < watch->n; i++)
        if (watch->files[i].id == id && strcmp(watch->files[i].name, name) == 0)
            return true;
    return false;
}

/* True when an event of this buffer names a watched file. */
static bool names_file(const lf_watch *watch, const char *bytes, size_t n)
{
    for (size_t at = 0; at + sizeof(struct inotify_event) <= n;) {
        struct inotify_event event;
        memcpy(&event, bytes + at, sizeof event);
        if (event.len > 0 && is_watched(watch, event.wd, bytes + at + sizeof event))
            return true;
        at += sizeof event + event.len;
    }
    return false;
}

static int on_watch(sd_event_source *source, int fd, uint32_t events, void *context)
{
    lf_watch *watch = context;
    char bytes[4096];
    ssize_t n = read(fd, bytes, sizeof bytes);
    (void)source;
    (void)events;
    if (n > 0 && names_file(watch, bytes, (size_t)n)) {
        sd_event_source_disable_unref(watch->timer);
        watch->timer = NULL;
        (void)sd_event_add_time_relative(watch->event, &watch->timer, CLOCK_MONOTONIC, QUIET_USEC,
                                         0, on_quiet, watch);
    }
    return 0;
}

static void forget(lf_watch *watch)
{
    for (int i = 0; i < watch->n; i++) {
        if (watch->files[i].id >= 0) /* EINVAL for a folder that was removed already */
            inotify_rm_watch(watch->fd, watch->files[i].id);
        lf_free(watch->files[i].name);
    }
    lf_free(watch->files);
    watch->files = NULL;
    watch->n = 0;
}

static void add(lf_watch *watch, const char *file)
{
    const char *slash = strrchr(file, '/');
    char *folder = lf_path_folder(file), *name = lf_strdup(slash ? slash + 1 : file);
    if (!folder || !name) {
        lf_free(folder);
        lf_free(name);
        return;
    }
    int id = inotify_add_watch(watch->fd, folder, IN_CLOSE_WRITE | IN_MOVED_TO | IN_CREATE);
    if (id < 0)
        lf_log(LF_LOG_WARNING, "%s: cannot watch the folder for changes: %s", folder,
               lf_errno_text(errno));
    watch->files[watch->n++] = (watched){id, name};
    lf_free(folder);
}

void lf_watch_files(lf_watch *watch, const char *const *files, size_t n)
{
    forget(watch);
    watch->files = n > 0 ? lf_calloc(n, sizeof *watch->files) : NULL;
    for (size_t i = 0; watch->files && i < n; i++)
        add(watch, files[i]);
}

lf_status lf_watch_create(sd_event *event, const lf_watch_events *events, void *context,
                          lf_watch **out_watch, lf_error *err)
{
    lf_watch *watch = lf_calloc(1, sizeof *watch);
    if (!watch)
        return lf_error_set(err, LF_E_NOMEM, "--watch", "out of memory");
    *watch = (lf_watch){.events = *events,
                        .context = context,
                        .event = event,
                        .fd = inotify_init1(IN_CLOEXEC | IN_NONBLOCK)};
    int r = watch->fd < 0 ? -errno : 0;
    r = r < 0 ? r : sd_event_add_io(event, &watch->io, watch->fd, EPOLLIN, on_watch, watch);
    if (r < 0) {
        lf_watch_destroy(watch);
        return lf_error_set(err, LF_E_IO, "event loop", "cannot be set up: %s", lf_errno_text(-r));
    }
    *out_watch = watch;
    return LF_OK;
}

void lf_watch_destroy(lf_watch *watch)
{
    if (!watch)
        return;
    sd_event_source_disable_unref(watch->io);
    sd_event_source_disable_unref(watch->timer);
    forget(watch);
    if (watch->fd >= 0)
        close(watch->fd);
    lf_free(watch);
}
