/* --watch: the file shown is loaded again when it changes on disk. */
#include <errno.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/inotify.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "base/log.h"
#include "daemon/server/server.h"

/* Editors write a file in several steps; it is read when it has been quiet for so long. */
#define QUIET_USEC 100000

struct lf_watch {
    int fd, id; /* inotify's; id -1 = nothing is watched */
    char *name; /* of the file, in its folder */
    sd_event_source *io, *timer;
};

static int on_quiet(sd_event_source *source, uint64_t usec, void *context)
{
    lf_server *server = context;
    (void)source;
    (void)usec;
    if (!lf_server_is_stopping(server))
        lf_server_reload(server);
    return 0;
}

/* True when an event of this buffer names the watched file. */
static bool names_file(const char *bytes, size_t n, const char *name)
{
    for (size_t at = 0; at + sizeof(struct inotify_event) <= n;) {
        struct inotify_event event;
        memcpy(&event, bytes + at, sizeof event);
        if (event.len > 0 && strcmp(bytes + at + sizeof event, name) == 0)
            return true;
        at += sizeof event + event.len;
    }
    return false;
}

static int on_watch(sd_event_source *source, int fd, uint32_t events, void *context)
{
    lf_server *server = context;
    lf_watch *watch = server->watch;
    char bytes[4096];
    ssize_t n = read(fd, bytes, sizeof bytes);
    (void)source;
    (void)events;
    if (n > 0 && watch->name && names_file(bytes, (size_t)n, watch->name)) {
        sd_event_source_disable_unref(watch->timer);
        watch->timer = NULL;
        (void)sd_event_add_time_relative(server->event, &watch->timer, CLOCK_MONOTONIC, QUIET_USEC,
                                         0, on_quiet, server);
    }
    return 0;
}

void lf_server_watch(lf_server *server)
{
    lf_watch *watch = server->watch;
    const char *file = server->content ? server->content->file : server->config.scene;
    char *folder = file && watch ? lf_path_folder(file) : NULL;
    if (!folder)
        return;
    if (watch->id >= 0)
        inotify_rm_watch(watch->fd, watch->id);
    lf_free(watch->name);
    const char *slash = strrchr(file, '/');
    watch->name = lf_strdup(slash ? slash + 1 : file);
    watch->id = inotify_add_watch(watch->fd, folder, IN_CLOSE_WRITE | IN_MOVED_TO | IN_CREATE);
    if (watch->id < 0)
        lf_log(LF_LOG_WARNING, "%s: cannot be watched: %s", folder, lf_errno_text(errno));
    lf_free(folder);
}

int lf_server_begin_watch(lf_server *server)
{
    lf_watch *watch = lf_calloc(1, sizeof *watch);
    if (!watch)
        return -ENOMEM;
    *watch = (lf_watch){.fd = inotify_init1(IN_CLOEXEC | IN_NONBLOCK), .id = -1};
    server->watch = watch;
    if (watch->fd < 0)
        return -errno;
    int r = sd_event_add_io(server->event, &watch->io, watch->fd, EPOLLIN, on_watch, server);
    lf_server_watch(server);
    return r;
}

void lf_server_end_watch(lf_server *server)
{
    lf_watch *watch = server->watch;
    if (!watch)
        return;
    sd_event_source_disable_unref(watch->io);
    sd_event_source_disable_unref(watch->timer);
    if (watch->fd >= 0)
        close(watch->fd);
    lf_free(watch->name);
    lf_free(watch);
    server->watch = NULL;
}
