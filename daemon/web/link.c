#include "daemon/web/link.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/errno_text.h"
#include "daemon/web/memory.h"
#include "daemon/wire/rpc.h"

/* Most that is read in a turn, so that one client does not hold up the others. */
#define READ_CHUNK ((size_t)65536)
#define MAX_IN (LF_RPC_MAX_LINE + READ_CHUNK)

typedef struct outgoing {
    struct outgoing *next;
    char *data; /* n bytes, the newline included */
    size_t n, sent;
    int *fds; /* [n_fds] go with the first byte */
    int n_fds;
    bool ahead; /* of those that are held */
} outgoing;

struct lf_link {
    int fd;
    sd_event_source *io;
    lf_link_events events;
    outgoing *first, *last;
    size_t queued;
    char *in; /* [size], of which `used` are read */
    size_t used, size;
    bool paused, held, closed;
};

static int on_io(sd_event_source *source, int fd, uint32_t what, void *context);

static bool may_send(const lf_link *link)
{
    return link->first && (!link->held || link->first->ahead);
}

static void listen_for(lf_link *link)
{
    const uint32_t in = link->paused ? 0 : EPOLLIN, out = may_send(link) ? EPOLLOUT : 0;
    if (!link->closed)
        sd_event_source_set_io_events(link->io, in | out);
}

static lf_status open_socket(const char *path, int *out_fd, lf_error *err)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (strlen(path) >= sizeof address.sun_path)
        return lf_error_set(err, LF_E_ARG, path, "the path of a socket has at most %zu bytes",
                            sizeof address.sun_path - 1);
    memcpy(address.sun_path, path, strlen(path) + 1);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd >= 0 && connect(fd, (const struct sockaddr *)&address, sizeof address) == 0) {
        *out_fd = fd;
        return LF_OK;
    }
    const int why = errno;
    if (fd >= 0)
        close(fd);
    return lf_error_set(err, LF_E_NODEV, path, "no quiltd answers: %s", lf_errno_text(why));
}

lf_status lf_link_create(sd_event *event, const char *path, const lf_link_events *events,
                         lf_link **out, lf_error *err)
{
    lf_link *link = lf_calloc(1, sizeof *link);
    if (!link)
        return lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    *link = (lf_link){.fd = -1, .events = *events, .size = READ_CHUNK};
    lf_status status = open_socket(path, &link->fd, err);
    if (status == LF_OK) {
        link->in = lf_calloc(link->size, 1);
        if (!link->in || sd_event_add_io(event, &link->io, link->fd, EPOLLIN, on_io, link) < 0)
            status = lf_error_set(err, LF_E_NOMEM, path, "out of memory");
    }
    if (status == LF_OK)
        *out = link;
    else
        lf_link_destroy(link);
    return status;
}

static void drop_line(outgoing *line)
{
    for (int i = 0; i < line->n_fds; i++)
        close(line->fds[i]);
    lf_free(line->fds);
    lf_free(line->data);
    lf_free(line);
}

static void drop_first(lf_link *link)
{
    outgoing *done = link->first;
    link->first = done->next;
    if (!link->first)
        link->last = NULL;
    link->queued -= done->n - done->sent;
    drop_line(done);
}

void lf_link_close(lf_link *link)
{
    if (!link || link->closed)
        return;
    link->closed = true;
    link->io = sd_event_source_disable_unref(link->io);
    if (link->fd >= 0)
        close(link->fd);
    link->fd = -1;
    while (link->first)
        drop_first(link);
}

void lf_link_destroy(lf_link *link)
{
    if (!link)
        return;
    lf_link_close(link);
    lf_free(link->in);
    lf_free(link);
}

static void end(lf_link *link)
{
    if (link->closed)
        return;
    lf_link_close(link);
    link->events.ended(link->events.context);
}

static ssize_t send_part(lf_link *link, const outgoing *o)
{
    union {
        struct cmsghdr align;
        char bytes[CMSG_SPACE(LF_LINK_MAX_FDS * sizeof(int))];
    } control = {.bytes = {0}};
    struct iovec vector = {.iov_base = o->data + o->sent, .iov_len = o->n - o->sent};
    struct msghdr message = {.msg_iov = &vector, .msg_iovlen = 1};
    if (o->sent == 0 && o->n_fds > 0) {
        const size_t bytes = (size_t)o->n_fds * sizeof(int);
        message.msg_control = &control;
        message.msg_controllen = CMSG_SPACE(bytes);
        struct cmsghdr *c = CMSG_FIRSTHDR(&message);
        c->cmsg_level = SOL_SOCKET;
        c->cmsg_type = SCM_RIGHTS;
        c->cmsg_len = CMSG_LEN(bytes);
        memcpy(CMSG_DATA(c), o->fds, bytes);
    }
    return sendmsg(link->fd, &message, MSG_NOSIGNAL);
}

/* False: the connection broke. */
static bool flush(lf_link *link)
{
    while (may_send(link)) {
        ssize_t n = send_part(link, link->first);
        if (n < 0)
            return errno == EAGAIN || errno == EINTR;
        link->first->sent += (size_t)n;
        link->queued -= (size_t)n;
        if (link->first->sent == link->first->n)
            drop_first(link);
    }
    return true;
}

/* NULL: out of memory, or of descriptors. */
static outgoing *make_line(const char *text, size_t n, const int *fds, int n_fds)
{
    outgoing *o = lf_calloc(1, sizeof *o);
    if (!o)
        return NULL;
    o->data = lf_calloc(n + 1, 1);
    o->fds = lf_calloc((size_t)n_fds + 1, sizeof *o->fds);
    bool made = o->data && o->fds;
    for (int i = 0; made && i < n_fds; i++) {
        o->fds[i] = fcntl(fds[i], F_DUPFD_CLOEXEC, 0);
        made = o->fds[i] >= 0;
        o->n_fds += made;
    }
    if (!made) {
        drop_line(o);
        return NULL;
    }
    memcpy(o->data, text, n);
    o->data[n] = '\n';
    o->n = n + 1;
    return o;
}

lf_status lf_link_send_fds(lf_link *link, const char *text, size_t n, const int *fds, int n_fds)
{
    if (link->closed)
        return LF_OK;
    outgoing *o = make_line(text, n, fds, n_fds);
    if (!o)
        return LF_E_NOMEM;
    if (link->last)
        link->last->next = o;
    else
        link->first = o;
    link->last = o;
    link->queued += o->n;
    listen_for(link); /* sent from the loop, where an end may be reported */
    return LF_OK;
}

lf_status lf_link_send(lf_link *link, const char *text, size_t n, int fd)
{
    return lf_link_send_fds(link, text, n, &fd, fd >= 0 ? 1 : 0);
}

lf_status lf_link_send_ahead(lf_link *link, const char *text, size_t n)
{
    outgoing *o = link->closed ? NULL : make_line(text, n, NULL, 0);
    if (!o)
        return link->closed ? LF_OK : LF_E_NOMEM;
    o->ahead = true;
    o->next = link->first;
    link->first = o;
    if (!link->last)
        link->last = o;
    link->held = true;
    link->queued += o->n;
    listen_for(link);
    return LF_OK;
}

void lf_link_go_on(lf_link *link)
{
    link->held = false;
    listen_for(link);
}

size_t lf_link_queued(const lf_link *link)
{
    return link->queued;
}

void lf_link_waiting(const lf_link *link, int *fds, uint64_t *bytes)
{
    for (const outgoing *o = link->first; o; o = o->next) {
        *fds += o->sent == 0 ? o->n_fds : 0;
        for (int i = 0; i < o->n_fds; i++)
            *bytes += lf_memory_bytes(o->fds[i]);
    }
}

void lf_link_pause(lf_link *link, bool paused)
{
    if (link->paused == paused)
        return;
    link->paused = paused;
    listen_for(link);
}

static void hand_over(lf_link *link, size_t scanned)
{
    size_t begin = 0;
    char *newline = memchr(link->in + scanned, '\n', link->used - scanned);
    while (newline && !link->closed) {
        const size_t at = (size_t)(newline - link->in);
        link->events.line(link->events.context, link->in + begin, at - begin);
        begin = at + 1;
        newline = memchr(link->in + begin, '\n', link->used - begin);
    }
    memmove(link->in, link->in + begin, link->used - begin);
    link->used -= begin;
}

/* Room for READ_CHUNK more bytes. */
static bool make_room(lf_link *link)
{
    size_t size = link->size;
    while (size - link->used < READ_CHUNK)
        size *= 2;
    if (size == link->size)
        return true;
    char *in = size <= 2 * MAX_IN ? lf_calloc(size, 1) : NULL;
    if (!in)
        return false;
    memcpy(in, link->in, link->used);
    lf_free(link->in);
    link->in = in;
    link->size = size;
    return true;
}

static void read_some(lf_link *link)
{
    if (!make_room(link)) {
        end(link);
        return;
    }
    const size_t scanned = link->used;
    ssize_t n = recv(link->fd, link->in + link->used, READ_CHUNK, 0);
    if (n < 0 && (errno == EAGAIN || errno == EINTR))
        return;
    if (n <= 0) {
        end(link);
        return;
    }
    link->used += (size_t)n;
    hand_over(link, scanned);
    if (link->used > MAX_IN)
        end(link);
}

static int on_io(sd_event_source *source, int fd, uint32_t what, void *context)
{
    (void)source;
    (void)fd;
    lf_link *link = context;
    if ((what & EPOLLOUT) && !flush(link))
        end(link);
    if (!link->closed && !link->paused && (what & (EPOLLIN | EPOLLHUP | EPOLLERR)))
        read_some(link);
    else if (!link->closed && (what & (EPOLLHUP | EPOLLERR)))
        end(link);
    listen_for(link);
    return 0;
}
