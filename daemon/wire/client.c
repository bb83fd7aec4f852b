#include "daemon/wire/client.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/alloc.h"
#include "base/log.h"

#define READ_CHUNK 65536
#define MAX_QUEUE ((size_t)1 << 20)
/* Limits of a client's turn: lines handled, and the bytes of these lines and of their answers. Then
 * other events are handled. */
#define LINES_A_TURN 16
#define BYTES_A_TURN ((size_t)65536)
/* Limits on open calls and the bytes of their lines: for all clients, including clients that have
 * left, and the modest part that each client may always have. */
#define MAX_CALLS_OF_ALL 4096
#define MAX_HELD_OF_ALL ((size_t)16 << 20)
#define MODEST_CALLS 64
#define MODEST_BYTES ((size_t)65536)
/* Pause of accepting after descriptors ran out. */
#define ACCEPT_PAUSE_USEC 200000

typedef struct buffer {
    char *data;
    size_t used, size;
} buffer;

/* A descriptor, and the end of the bytes that it came with, counted from the client's first. */
typedef struct passed_fd {
    int fd;
    uint64_t end;
} passed_fd;

struct lf_client {
    lf_clients *owner;
    lf_client *next;
    uint64_t serial;
    int fd;
    sd_event_source *io;
    sd_event_source *turn; /* on while lines wait for the next turn */
    buffer in, out;
    size_t scanned; /* bytes of `in` known to hold no newline */
    size_t sent;    /* bytes of `out` already sent */
    buffer frame;   /* the newest frame notification, if it has to wait */
    bool skipping;  /* in a line that is too long */
    bool at_end;    /* the peer has closed its sending side */
    bool dropped;   /* to be freed after its turn */
    bool busy;      /* its lines are being handled */
    bool paused;    /* its next lines wait for lf_client_resume */
    int calls;
    size_t line, held; /* bytes of the line being handled; of the lines of open calls */
    size_t turn_bytes; /* bytes handled and sent in this turn */
    uint64_t received; /* bytes received */
    uint64_t line_end; /* of these, up to the end of the line being handled */
    unsigned flags;
    uint64_t denied;
    passed_fd fds[LF_MAX_CLIENT_FDS]; /* in the order of their arrival */
    int n_fds, line_fds; /* all, and the first of them, which are for the line being handled */
};

struct lf_clients {
    sd_event *event;
    int listen_fd;
    sd_event_source *listen_io, *pause;
    lf_line_fn on_line;
    lf_gone_fn on_gone; /* may be NULL */
    void *context;
    lf_client *first;
    int count;
    int calls, calls_left; /* totals of all clients, and of clients that have left */
    size_t held, held_left;
    uint64_t serials, lines;
};

/* ----------------------------------------------------------------------------------- buffers -- */

static bool buffer_add(buffer *b, const char *data, size_t n)
{
    if (b->used + n > b->size) {
        size_t size = b->size > 0 ? b->size : 4096;
        while (size < b->used + n)
            size *= 2;
        char *grown = realloc(b->data, size);
        if (!grown)
            return false;
        b->data = grown;
        b->size = size;
    }
    memcpy(b->data + b->used, data, n);
    b->used += n;
    return true;
}

static void buffer_finish(buffer *b)
{
    free(b->data);
    *b = (buffer){0};
}

/* Empties the buffer; a large one frees its memory. */
static void buffer_reset(buffer *b)
{
    b->used = 0;
    if (b->size > READ_CHUNK)
        buffer_finish(b);
}

/* ----------------------------------------------------------------------------------- sending -- */

static void drop(lf_client *client)
{
    client->dropped = true;
}

/* Forgets the first n descriptors. */
static void remove_fds(lf_client *client, int n)
{
    client->n_fds -= n;
    memmove(client->fds, client->fds + n, (size_t)client->n_fds * sizeof *client->fds);
}

/* Closes the first n descriptors. */
static void close_fds(lf_client *client, int n)
{
    for (int i = 0; i < n; i++)
        close(client->fds[i].fd);
    remove_fds(client, n);
}

/* Number of descriptors that came with bytes up to the end of the line being handled. */
static int fds_of_line(const lf_client *client)
{
    int n = 0;
    while (n < client->n_fds && client->fds[n].end <= client->line_end)
        n++;
    return n;
}

/* Lines of one message share its descriptors, which then are for the first line that takes them. */
static void begin_line(lf_client *client, uint64_t end)
{
    client->line_end = end;
    client->line_fds = fds_of_line(client);
    if (client->line_fds == 0)
        client->line_fds = client->n_fds;
}

/* Closes the descriptors that the line did not take. */
static void end_line(lf_client *client)
{
    close_fds(client, fds_of_line(client));
    client->line_fds = 0;
}

static void free_client(lf_client *client)
{
    lf_clients *owner = client->owner;
    const uint64_t serial = client->serial;
    lf_client **at = &owner->first;
    while (*at != client)
        at = &(*at)->next;
    *at = client->next;
    owner->count--;
    owner->calls_left += client->calls;
    owner->held_left += client->held;
    sd_event_source_disable_unref(client->io);
    sd_event_source_disable_unref(client->turn);
    close(client->fd);
    close_fds(client, client->n_fds);
    buffer_finish(&client->in);
    buffer_finish(&client->out);
    buffer_finish(&client->frame);
    lf_free(client);
    if (owner->on_gone)
        owner->on_gone(owner->context, serial);
}

/* True if a complete line is waiting. */
static bool has_line(const lf_client *client)
{
    return client->scanned < client->in.used;
}

/* Sets the events to wait for: nothing is read while lines wait. */
static void arm(lf_client *client)
{
    bool waiting = client->out.used > client->sent, rests = client->paused || has_line(client),
         next = has_line(client) && !client->paused;
    uint32_t events =
        (rests || client->at_end ? 0 : (uint32_t)EPOLLIN) | (waiting ? (uint32_t)EPOLLOUT : 0);
    sd_event_source_set_io_events(client->io, events);
    /* a closed connection would wake the loop all the time */
    sd_event_source_set_enabled(client->io, rests && !waiting ? SD_EVENT_OFF : SD_EVENT_ON);
    sd_event_source_set_enabled(client->turn, next ? SD_EVENT_ONESHOT : SD_EVENT_OFF);
}

static bool is_done(const lf_client *client)
{
    return client->at_end && client->calls == 0 && client->out.used == client->sent &&
           client->frame.used == 0 && !client->paused && !has_line(client);
}

/* Frees a client that is done, unless its lines are being handled further up the stack. */
static void settle(lf_client *client)
{
    if (client->busy)
        return;
    if (client->dropped || is_done(client))
        free_client(client);
    else
        arm(client);
}

static void flush(lf_client *client)
{
    while (client->sent < client->out.used || client->frame.used > 0) {
        if (client->sent == client->out.used) {
            buffer_reset(&client->out);
            client->sent = 0;
            if (!buffer_add(&client->out, client->frame.data, client->frame.used)) {
                drop(client);
                return;
            }
            buffer_reset(&client->frame);
        }
        ssize_t n = send(client->fd, client->out.data + client->sent,
                         client->out.used - client->sent, MSG_DONTWAIT | MSG_NOSIGNAL);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0) {
            if (errno != EAGAIN)
                drop(client);
            return;
        }
        client->sent += (size_t)n;
    }
    buffer_reset(&client->out);
    client->sent = 0;
}

static void send_bytes(lf_client *client, const char *line, size_t n)
{
    if (client->dropped)
        return;
    size_t waiting = client->out.used - client->sent;
    if (waiting + n + 1 > MAX_QUEUE) {
        lf_log(LF_LOG_INFO, "disconnected a client that does not read its messages");
        drop(client);
        return;
    }
    if (client->sent > 0) {
        memmove(client->out.data, client->out.data + client->sent, waiting);
        client->out.used = waiting;
        client->sent = 0;
    }
    if (!buffer_add(&client->out, line, n) || !buffer_add(&client->out, "\n", 1)) {
        drop(client);
        return;
    }
    client->turn_bytes += n + 1;
    flush(client);
}

/* Only marks the client as dropped, since callers still use it; it is freed in its own turn of the
 * event loop. */
static void leave(lf_client *client)
{
    if (client->busy)
        return;
    if (client->dropped || is_done(client))
        sd_event_source_set_enabled(client->turn, SD_EVENT_ONESHOT);
    else
        arm(client);
}

void lf_client_send_text(lf_client *client, const char *text, size_t n)
{
    send_bytes(client, text, n);
    leave(client);
}

void lf_client_send(lf_client *client, json_t *message)
{
    char *text = message ? json_dumps(message, JSON_COMPACT) : NULL;
    size_t n = text ? strlen(text) : 0;
    if (!text) {
        drop(client);
    } else if (n >= MAX_QUEUE) {
        json_t *refusal = lf_rpc_error(json_object_get(message, "id"), LF_RPC_INTERNAL,
                                       "the answer is longer than 1 MiB", NULL);
        lf_client_send(client, refusal);
    } else {
        send_bytes(client, text, n);
    }
    free(text);
    json_decref(message);
    leave(client);
}

void lf_client_send_frame(lf_client *client, const char *line, size_t n)
{
    if (client->out.used == client->sent) {
        send_bytes(client, line, n);
    } else if (!client->dropped) {
        client->frame.used = 0;
        if (!buffer_add(&client->frame, line, n) || !buffer_add(&client->frame, "\n", 1))
            drop(client);
    }
    leave(client);
}

/* --------------------------------------------------------------------------------- receiving -- */

static void refuse_long_line(lf_client *client)
{
    lf_client_send(client,
                   lf_rpc_error(NULL, LF_RPC_INVALID_REQUEST, "a line is longer than 1 MiB", NULL));
}

static void take_line(lf_client *client, const char *line, size_t n)
{
    if (client->skipping) {
        client->skipping = false;
    } else if (n > LF_RPC_MAX_LINE) {
        refuse_long_line(client);
    } else if (n > 0) {
        client->line = n;
        client->owner->lines++;
        client->owner->on_line(client->owner->context, client, line, n);
    }
}

/* Discards the first bytes of the input. */
static void discard(lf_client *client, size_t n)
{
    if (n == 0)
        return;
    client->in.used -= n;
    if (client->in.used > 0)
        memmove(client->in.data, client->in.data + n, client->in.used);
    else
        buffer_reset(&client->in);
}

/* The input is the start of a line, or empty. */
static void keep_beginning(lf_client *client)
{
    client->scanned = client->in.used;
    if (!client->skipping && client->in.used > LF_RPC_MAX_LINE) {
        refuse_long_line(client);
        client->skipping = true;
    }
    if (client->skipping) {
        buffer_reset(&client->in);
        client->scanned = 0;
    }
}

/* Hands over complete lines of the input, as many as a turn allows. */
static void take_lines(lf_client *client)
{
    size_t begin = 0;
    int n_lines = 0;
    bool rest = true;
    client->turn_bytes = 0;
    while (!client->dropped && !client->paused && n_lines < LINES_A_TURN &&
           client->turn_bytes < BYTES_A_TURN) {
        size_t from = client->scanned > begin ? client->scanned : begin;
        char *end = from < client->in.used
                        ? memchr(client->in.data + from, '\n', client->in.used - from)
                        : NULL;
        rest = end;
        if (!end)
            break;
        size_t n = (size_t)(end - (client->in.data + begin));
        client->scanned = 0;
        client->turn_bytes += n + 1;
        begin_line(client, client->received - client->in.used + begin + n + 1);
        n_lines++;
        take_line(client, client->in.data + begin, n);
        if (!client->paused)
            end_line(client);
        begin += n + 1;
    }
    discard(client, begin);
    if (!rest || client->in.used == 0)
        keep_beginning(client);
}

static void keep_fds(lf_client *client, struct msghdr *message, uint64_t end)
{
    for (struct cmsghdr *c = CMSG_FIRSTHDR(message); c; c = CMSG_NXTHDR(message, c)) {
        if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_RIGHTS)
            continue;
        size_t n = (c->cmsg_len - CMSG_LEN(0)) / sizeof(int);
        for (size_t i = 0; i < n; i++) {
            int fd;
            memcpy(&fd, CMSG_DATA(c) + i * sizeof fd, sizeof fd);
            if (client->n_fds < LF_MAX_CLIENT_FDS)
                client->fds[client->n_fds++] = (passed_fd){fd, end};
            else
                close(fd);
        }
    }
}

/* NOLINTNEXTLINE(readability-non-const-parameter): data is written through the message */
static ssize_t receive(lf_client *client, char *data, size_t size)
{
    union {
        struct cmsghdr align;
        char bytes[CMSG_SPACE(LF_MAX_CLIENT_FDS * sizeof(int))];
    } control;
    struct iovec vector = {.iov_base = data, .iov_len = size};
    struct msghdr message = {.msg_iov = &vector,
                             .msg_iovlen = 1,
                             .msg_control = &control,
                             .msg_controllen = sizeof control};
    ssize_t n = recvmsg(client->fd, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
    if (n >= 0)
        keep_fds(client, &message, client->received + (uint64_t)n);
    return n;
}

static void read_some(lf_client *client)
{
    char chunk[READ_CHUNK];
    ssize_t n = receive(client, chunk, sizeof chunk);
    if (n < 0) {
        if (errno != EAGAIN && errno != EINTR)
            drop(client);
        return;
    }
    if (n == 0) {
        client->at_end = true;
        return;
    }
    if (!buffer_add(&client->in, chunk, (size_t)n)) {
        drop(client);
        return;
    }
    client->received += (uint64_t)n;
    take_lines(client);
}

static int on_client(sd_event_source *source, int fd, uint32_t events, void *context)
{
    lf_client *client = context;
    (void)source;
    (void)fd;
    client->busy = true;
    if ((events & EPOLLOUT) != 0)
        flush(client);
    if ((events & EPOLLIN) != 0 && !client->dropped && !client->at_end)
        read_some(client);
    if ((events & (EPOLLHUP | EPOLLERR)) != 0 && ((events & EPOLLIN) == 0 || client->at_end))
        drop(client);
    client->busy = false;
    settle(client);
    return 0;
}

/* The next turn of a client that had more lines than one turn allows. */
static int on_turn(sd_event_source *source, uint64_t usec, void *context)
{
    lf_client *client = context;
    (void)source;
    (void)usec;
    client->busy = true;
    take_lines(client);
    client->busy = false;
    settle(client);
    return 0;
}

/* --------------------------------------------------------------------------------- listening -- */

/* A timer with time 0 is due at once, but after all earlier events. */
static bool listen_to(lf_client *client, sd_event *event)
{
    return sd_event_add_io(event, &client->io, client->fd, EPOLLIN, on_client, client) >= 0 &&
           sd_event_add_time(event, &client->turn, CLOCK_MONOTONIC, 0, 1, on_turn, client) >= 0 &&
           sd_event_source_set_enabled(client->turn, SD_EVENT_OFF) >= 0;
}

static void add_client(lf_clients *clients, int fd)
{
    lf_client *client = clients->count < LF_MAX_CLIENTS ? lf_calloc(1, sizeof *client) : NULL;
    if (client)
        client->fd = fd;
    if (!client || !listen_to(client, clients->event)) {
        static const char refusal[] = "{\"jsonrpc\":\"2.0\",\"id\":null,\"error\":{\"code\":-32000,"
                                      "\"message\":\"too many clients\"}}\n";
        (void)!send(fd, refusal, sizeof refusal - 1, MSG_DONTWAIT | MSG_NOSIGNAL);
        if (client) {
            sd_event_source_disable_unref(client->io);
            sd_event_source_disable_unref(client->turn);
        }
        close(fd);
        lf_free(client);
        return;
    }
    client->owner = clients;
    client->serial = ++clients->serials;
    client->next = clients->first;
    clients->first = client;
    clients->count++;
}

static int on_pause_over(sd_event_source *source, uint64_t usec, void *context)
{
    lf_clients *clients = context;
    (void)source;
    (void)usec;
    if (clients->listen_io)
        sd_event_source_set_enabled(clients->listen_io, SD_EVENT_ON);
    return 0;
}

static int on_listen(sd_event_source *source, int fd, uint32_t events, void *context)
{
    lf_clients *clients = context;
    (void)events;
    int connection = accept4(fd, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (connection >= 0) {
        add_client(clients, connection);
    } else if (errno == EMFILE || errno == ENFILE || errno == ENOMEM || errno == ENOBUFS) {
        /* The pending connection would wake the loop again at once. */
        sd_event_source_set_enabled(source, SD_EVENT_OFF);
        sd_event_source_disable_unref(clients->pause);
        clients->pause = NULL;
        (void)sd_event_add_time_relative(clients->event, &clients->pause, CLOCK_MONOTONIC,
                                         ACCEPT_PAUSE_USEC, 0, on_pause_over, clients);
    }
    return 0;
}

lf_status lf_clients_create(sd_event *event, int listen_fd, lf_line_fn on_line, void *context,
                            lf_clients **out)
{
    lf_clients *clients = lf_calloc(1, sizeof *clients);
    if (!clients ||
        sd_event_add_io(event, &clients->listen_io, listen_fd, EPOLLIN, on_listen, clients) < 0) {
        close(listen_fd);
        lf_free(clients);
        return LF_E_NOMEM;
    }
    clients->event = event;
    clients->listen_fd = listen_fd;
    clients->on_line = on_line;
    clients->context = context;
    *out = clients;
    return LF_OK;
}

void lf_clients_on_gone(lf_clients *clients, lf_gone_fn fn)
{
    clients->on_gone = fn;
}

void lf_clients_close_listener(lf_clients *clients)
{
    if (clients->listen_fd >= 0) {
        sd_event_source_disable_unref(clients->listen_io);
        clients->listen_io = NULL;
        close(clients->listen_fd);
        clients->listen_fd = -1;
    }
}

void lf_clients_destroy(lf_clients *clients)
{
    if (!clients)
        return;
    lf_clients_close_listener(clients);
    sd_event_source_disable_unref(clients->pause);
    while (clients->first) {
        flush(clients->first);
        free_client(clients->first);
    }
    lf_free(clients);
}

int lf_clients_count(const lf_clients *clients)
{
    return clients->count;
}

uint64_t lf_clients_lines(const lf_clients *clients)
{
    return clients->lines;
}

lf_client *lf_clients_find(lf_clients *clients, uint64_t serial)
{
    lf_client *client = clients->first;
    while (client && client->serial != serial)
        client = client->next;
    return client;
}

uint64_t lf_client_serial(const lf_client *client)
{
    return client->serial;
}

void lf_client_pause(lf_client *client)
{
    client->paused = true;
}

void lf_client_resume(lf_client *client)
{
    client->paused = false;
    end_line(client);
    leave(client);
}

bool lf_client_hold(lf_client *client, size_t *out_bytes)
{
    lf_clients *clients = client->owner;
    const size_t own = client->held + client->line, all = clients->held + client->line;
    bool few = client->calls < MODEST_CALLS || clients->calls < MAX_CALLS_OF_ALL,
         small = own <= MODEST_BYTES || all <= MAX_HELD_OF_ALL;
    if (client->calls >= LF_MAX_CLIENT_CALLS || !few || !small ||
        (client->calls > 0 && own > LF_MAX_HELD_BYTES))
        return false;
    client->calls++;
    client->held += client->line;
    clients->calls++;
    clients->held += client->line;
    *out_bytes = client->line;
    return true;
}

void lf_clients_release(lf_clients *clients, uint64_t serial, size_t bytes)
{
    lf_client *client = lf_clients_find(clients, serial);
    clients->calls--;
    clients->held -= bytes;
    if (!client) {
        clients->calls_left--;
        clients->held_left -= bytes;
        return;
    }
    client->calls--;
    client->held -= bytes;
    leave(client);
}

bool lf_clients_left_much(const lf_clients *clients)
{
    return clients->calls_left > MODEST_CALLS || clients->held_left > MODEST_BYTES;
}

int lf_client_count_fds(const lf_client *client)
{
    return client->line_fds;
}

bool lf_client_take_fds(lf_client *client, int *out_fds, int n)
{
    if (n > client->line_fds)
        return false;
    for (int i = 0; i < n; i++)
        out_fds[i] = client->fds[i].fd;
    remove_fds(client, n);
    client->line_fds -= n;
    return true;
}

unsigned *lf_client_flags(lf_client *client)
{
    return &client->flags;
}

uint64_t *lf_client_denied(lf_client *client)
{
    return &client->denied;
}

void lf_clients_each(lf_clients *clients, void (*fn)(void *context, lf_client *client),
                     void *context)
{
    for (lf_client *client = clients->first; client; client = client->next)
        fn(context, client);
}
