#include "daemon/web/nng.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"
#include "daemon/web/patience.h"

/* What the driver keeps of it while a command runs has to fit into LF_DRIVER_MAX_LATER. */
#define BYTES_A_TURN ((size_t)32768)
#define MAX_OUT ((size_t)65536) /* bytes of answers that wait */
#define GREETING_USEC ((uint64_t)10000000)
#define PACE_USEC ((uint64_t)20000000)

enum { GREETING = 8, HEAD = 9, MESSAGE = 1 };

/* Zero, "SP", version 0, the protocol, zero. */
static const uint8_t rep[GREETING] = {0, 'S', 'P', 0, 0, 0x31, 0, 0};
static const uint8_t req[GREETING] = {0, 'S', 'P', 0, 0, 0x30, 0, 0};

typedef struct peer {
    struct peer *next;
    lf_nng *nng;
    int fd;
    sd_event_source *io;
    lf_patience *patience;
    lf_driver_client *client;
    bool greeted;
    uint8_t head[HEAD]; /* or greeting */
    size_t n_head;
    bool inside;   /* a message, of which … */
    uint64_t left; /* … so many bytes follow */
    uint8_t *out;  /* [MAX_OUT] */
    size_t n_out;  /* bytes of it that wait */
    bool paused;
} peer;

struct lf_nng {
    int fd;
    sd_event *event;
    sd_event_source *accept;
    lf_driver *driver;
    peer *peers;
    int n_peers;
};

static void drop(peer *gone)
{
    lf_nng *nng = gone->nng;
    for (peer **at = &nng->peers; *at; at = &(*at)->next) {
        if (*at != gone)
            continue;
        *at = gone->next;
        nng->n_peers--;
        break;
    }
    sd_event_source_disable_unref(gone->io);
    lf_patience_destroy(gone->patience);
    lf_driver_leave(gone->client);
    if (gone->fd >= 0)
        close(gone->fd);
    lf_free(gone->out);
    lf_free(gone);
}

/* ------------------------------------------------------------------------------------ output -- */

static void listen_for(peer *p)
{
    sd_event_source_set_enabled(p->io, p->paused && p->n_out == 0 ? SD_EVENT_OFF : SD_EVENT_ON);
    sd_event_source_set_io_events(p->io,
                                  (p->paused ? 0u : EPOLLIN) | (p->n_out > 0 ? EPOLLOUT : 0u));
}

/* False: the connection broke. */
static bool flush(peer *p)
{
    while (p->n_out > 0) {
        const ssize_t n = send(p->fd, p->out, p->n_out, MSG_DONTWAIT | MSG_NOSIGNAL);
        if (n < 0)
            return errno == EAGAIN || errno == EINTR;
        p->n_out -= (size_t)n;
        memmove(p->out, p->out + n, p->n_out);
    }
    return true;
}

/* An answer that does not fit is dropped: its client does not read answers. */
static void on_reply(void *context, const uint8_t *data, size_t n)
{
    peer *p = context;
    uint8_t head[HEAD] = {MESSAGE};
    if (n > MAX_OUT - HEAD || p->n_out > MAX_OUT - HEAD - n) {
        lf_log(LF_LOG_DEBUG, "nng: an answer is dropped: its client does not read");
        return;
    }
    for (int i = 0; i < 8; i++)
        head[1 + i] = (uint8_t)((uint64_t)n >> (56 - 8 * i));
    memcpy(p->out + p->n_out, head, HEAD);
    memcpy(p->out + p->n_out + HEAD, data, n);
    p->n_out += HEAD + n;
    listen_for(p);
}

/* Of the message that comes. */
static void expect_more(const peer *p)
{
    lf_patience_pace(p->patience, PACE_USEC);
}

static void on_ready(void *context)
{
    peer *p = context;
    p->paused = false;
    if (p->inside)
        expect_more(p);
    listen_for(p);
}

/* ------------------------------------------------------------------------------------- input -- */

/* The head of a message is there. False: it is not one. */
static bool begin_message(peer *p)
{
    uint64_t n = 0;
    for (int i = 1; i < HEAD; i++)
        n = n << 8 | p->head[i];
    if (p->head[0] != MESSAGE || n > lf_driver_longest(p->nng->driver))
        return false;
    p->inside = true;
    p->left = n;
    expect_more(p);
    return true;
}

static bool end_message(peer *p)
{
    p->inside = false;
    lf_patience_stop(p->patience);
    return lf_driver_end(p->client) == LF_OK;
}

/* Takes one greeting, head or part of a message; *out_used: its bytes. False: drop the client. */
static bool take_some(peer *p, const uint8_t *data, size_t n, size_t *out_used)
{
    const size_t whole = p->greeted ? HEAD : GREETING;
    size_t used = p->inside ? (n < p->left ? n : (size_t)p->left)
                            : (n < whole - p->n_head ? n : whole - p->n_head);
    *out_used = used;
    if (p->inside) {
        p->left -= used;
        lf_patience_note(p->patience, used);
        return lf_driver_take(p->client, data, used) == LF_OK && (p->left > 0 || end_message(p));
    }
    memcpy(p->head + p->n_head, data, used);
    p->n_head += used;
    if (p->n_head < whole)
        return true;
    p->n_head = 0;
    if (p->greeted)
        return begin_message(p) && (p->left > 0 || end_message(p));
    p->greeted = memcmp(p->head, req, GREETING) == 0;
    lf_patience_stop(p->patience);
    return p->greeted;
}

/* False: the connection is over. */
static bool read_some(peer *p)
{
    uint8_t data[BYTES_A_TURN];
    const ssize_t n = recv(p->fd, data, sizeof data, MSG_DONTWAIT);
    if (n < 0)
        return errno == EAGAIN || errno == EINTR;
    bool good = n > 0;
    for (size_t at = 0, used = 0; good && at < (size_t)n; at += used)
        good = take_some(p, data + at, (size_t)n - at, &used);
    p->paused = lf_driver_is_busy(p->client);
    if (p->paused)
        lf_patience_stop(p->patience); /* it waits for us */
    return good;
}

static int on_io(sd_event_source *source, int fd, uint32_t what, void *context)
{
    (void)source;
    (void)fd;
    peer *p = context;
    bool good = !(what & EPOLLOUT) || flush(p);
    if (good && !p->paused && (what & (EPOLLIN | EPOLLHUP | EPOLLERR)))
        good = read_some(p);
    else if (good && (what & (EPOLLHUP | EPOLLERR)))
        good = p->n_out == 0; /* what waits cannot be delivered */
    if (good)
        listen_for(p);
    else
        drop(p);
    return 0;
}

/* ---------------------------------------------------------------------------------- its life -- */

static lf_status set_up(peer *p)
{
    const lf_driver_events events = {.reply = on_reply, .ready = on_ready, .context = p};
    lf_status status = lf_driver_join(p->nng->driver, &events, &p->client);
    p->out = lf_calloc(MAX_OUT, 1);
    if (status == LF_OK)
        status = lf_patience_create(p->nng->event, p->fd, GREETING_USEC, &p->patience);
    if (status != LF_OK || !p->out ||
        sd_event_add_io(p->nng->event, &p->io, p->fd, EPOLLIN | EPOLLOUT, on_io, p) < 0)
        return LF_E_NOMEM;
    memcpy(p->out, rep, GREETING);
    p->n_out = GREETING;
    return LF_OK;
}

static int on_accept(sd_event_source *source, int fd, uint32_t what, void *context)
{
    (void)source;
    (void)what;
    lf_nng *nng = context;
    const int accepted = accept4(fd, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (accepted < 0)
        return 0;
    peer *new = nng->n_peers < LF_DRIVER_MAX_CLIENTS ? lf_calloc(1, sizeof *new) : NULL;
    if (!new) {
        lf_log(LF_LOG_WARNING, "nng: a client was refused: %d are there", nng->n_peers);
        close(accepted);
        return 0;
    }
    *new = (peer){.nng = nng, .fd = accepted, .next = nng->peers};
    nng->peers = new;
    nng->n_peers++;
    if (set_up(new) != LF_OK)
        drop(new);
    return 0;
}

lf_status lf_nng_create(sd_event *event, int fd, lf_driver *driver, lf_nng **out, lf_error *err)
{
    if (sd_is_socket_unix(fd, SOCK_STREAM, 1, NULL, 0) <= 0) {
        close(fd);
        return lf_error_set(err, LF_E_ARG, "nng",
                            "expects a listening Unix stream socket; check the socket unit");
    }
    lf_nng *nng = lf_calloc(1, sizeof *nng);
    if (nng)
        *nng = (lf_nng){.fd = fd, .event = event, .driver = driver};
    fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK);
    if (!nng || sd_event_add_io(event, &nng->accept, fd, EPOLLIN, on_accept, nng) < 0) {
        lf_free(nng);
        close(fd);
        return lf_error_set(err, LF_E_NOMEM, "nng", "out of memory");
    }
    *out = nng;
    return LF_OK;
}

void lf_nng_destroy(lf_nng *nng)
{
    if (!nng)
        return;
    while (nng->peers)
        drop(nng->peers);
    sd_event_source_disable_unref(nng->accept);
    close(nng->fd);
    lf_free(nng);
}

int lf_nng_clients(const lf_nng *nng)
{
    return nng->n_peers;
}
