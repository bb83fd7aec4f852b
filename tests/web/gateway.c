#include "tests/web/gateway.h"

#include <arpa/inet.h>
#include <errno.h>
#include <jansson.h>
#include <netinet/in.h>
#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/un.h>

#include "daemon/web/web.h"

enum { MAX_CONNECTIONS = 40, MAX_CALLS = 4096, LINE = 1 << 20, PATIENCE_MS = 60000 };

struct gateway {
    char *folder;
    char socket[108];
    pthread_t web_thread, daemon_thread;
    int stop_web, stop_daemon; /* eventfds */
    int web_fd, daemon_fd;     /* listening */
    int port;
    char token[33];
    char cookie[128];
    pthread_barrier_t ready;
    pthread_mutex_t lock; /* holds what follows */
    int connections[MAX_CONNECTIONS];
    char *lines[MAX_CONNECTIONS]; /* [LINE] what came of the next line */
    size_t used[MAX_CONNECTIONS];
    int n_connections;
    char calls[MAX_CALLS][24];
    int n_calls;
    bool answers_images;
    int columns;      /* of its images */
    const char *rest; /* of the line that lf_gateway_flood could not end */
};

/* -------------------------------------------------------------------------- the false quiltd -- */

static json_t *image_for(const json_t *params, int fd, int columns)
{
    static const char jpeg[] = "\xff\xd8 an image \xff\xd9";
    json_t *width = json_object_get(params, "width");
    json_int_t wide = width ? json_integer_value(width) : FALSE_WIDTH;
    json_int_t views = json_object_get(params, "views") ? 1 : FALSE_VIEWS;
    if (fd < 0 || write(fd, jpeg, sizeof jpeg) != (ssize_t)sizeof jpeg)
        return json_object();
    return json_pack("{s:i, s:s, s:I, s:i, s:I, s:I, s:I, s:i}", "generation", 7, "level",
                     "complete", "columns", views == 1 ? (json_int_t)1 : columns, "rows",
                     views == 1 ? 1 : FALSE_COLUMNS, "views", views, "width", wide, "height",
                     wide * FALSE_HEIGHT / FALSE_WIDTH, "bytes", (int)sizeof jpeg);
}

static void send_whole(int fd, const char *text)
{
    for (size_t n = strlen(text); n > 0;) {
        ssize_t sent = send(fd, text, n, MSG_NOSIGNAL);
        if (sent <= 0)
            return;
        text += sent;
        n -= (size_t)sent;
    }
}

static void answer_line(gateway *g, int connection, const char *line, size_t n, int fd)
{
    json_t *call = json_loadb(line, n, 0, NULL), *result;
    const char *method = json_string_value(json_object_get(call, "method"));
    json_t *params = json_object_get(call, "params");
    if (!method) { /* no assertion: this is another thread */
        json_decref(call);
        return;
    }
    if (g->n_calls < MAX_CALLS)
        snprintf(g->calls[g->n_calls++], sizeof g->calls[0], "%s", method);
    if (strcmp(method, "status") == 0)
        result = json_pack("{s:s, s:i}", "state", "rendering", "generation", 7);
    else if (strcmp(method, "frame.get") == 0)
        result = g->answers_images ? image_for(params, fd, g->columns) : NULL;
    else if (params)
        result = json_pack("{s:s, s:O}", "method", method, "params", params);
    else
        result = json_pack("{s:s}", "method", method);
    if (result) {
        json_t *answer = json_pack("{s:s, s:O?, s:o}", "jsonrpc", "2.0", "id",
                                   json_object_get(call, "id"), "result", result);
        char *text = json_dumps(answer, JSON_COMPACT);
        send_whole(connection, text);
        send_whole(connection, "\n");
        free(text);
        json_decref(answer);
    }
    json_decref(call);
}

static void close_connection(gateway *g, int i)
{
    close(g->connections[i]);
    free(g->lines[i]);
    g->n_connections--;
    for (int k = i; k < g->n_connections; k++) {
        g->connections[k] = g->connections[k + 1];
        g->lines[k] = g->lines[k + 1];
        g->used[k] = g->used[k + 1];
    }
}

/* False: the connection is gone. */
static bool read_connection(gateway *g, int i)
{
    union {
        struct cmsghdr align;
        char bytes[CMSG_SPACE(sizeof(int))];
    } control;
    struct iovec vector = {g->lines[i] + g->used[i], LINE - g->used[i]};
    struct msghdr message = {.msg_iov = &vector,
                             .msg_iovlen = 1,
                             .msg_control = &control,
                             .msg_controllen = sizeof control};
    ssize_t n = recvmsg(g->connections[i], &message, MSG_CMSG_CLOEXEC);
    if (n <= 0)
        return false;
    int fd = -1;
    struct cmsghdr *c = CMSG_FIRSTHDR(&message);
    if (c && c->cmsg_type == SCM_RIGHTS)
        memcpy(&fd, CMSG_DATA(c), sizeof fd);
    g->used[i] += (size_t)n;
    char *line = g->lines[i], *end;
    while ((end = memchr(line, '\n', g->used[i] - (size_t)(line - g->lines[i])))) {
        answer_line(g, g->connections[i], line, (size_t)(end - line), fd);
        line = end + 1;
    }
    g->used[i] -= (size_t)(line - g->lines[i]);
    memmove(g->lines[i], line, g->used[i]);
    if (fd >= 0)
        close(fd);
    return true;
}

static void take_connection(gateway *g)
{
    int fd = accept4(g->daemon_fd, NULL, NULL, SOCK_CLOEXEC);
    char *line = malloc(LINE);
    if (fd < 0 || !line || g->n_connections == MAX_CONNECTIONS) {
        free(line);
        if (fd >= 0)
            close(fd);
        return;
    }
    g->connections[g->n_connections] = fd;
    g->lines[g->n_connections] = line;
    g->used[g->n_connections++] = 0;
}

static void *be_daemon(void *context)
{
    gateway *g = context;
    for (;;) {
        struct pollfd polled[MAX_CONNECTIONS + 2] = {{g->stop_daemon, POLLIN, 0},
                                                     {g->daemon_fd, POLLIN, 0}};
        pthread_mutex_lock(&g->lock);
        const int n = g->n_connections;
        for (int i = 0; i < n; i++)
            polled[i + 2] = (struct pollfd){g->connections[i], POLLIN, 0};
        pthread_mutex_unlock(&g->lock);
        /* a look now and then: lf_gateway_hang_up closes connections meanwhile */
        poll(polled, (nfds_t)n + 2, 50);
        if (polled[0].revents)
            return NULL;
        pthread_mutex_lock(&g->lock);
        for (int i = n - 1; i >= 0 && n == g->n_connections; i--)
            if (polled[i + 2].revents && !read_connection(g, i)) {
                close_connection(g, i);
                break;
            }
        if (polled[1].revents)
            take_connection(g);
        pthread_mutex_unlock(&g->lock);
    }
}

void lf_gateway_answer_images(gateway *g, bool answer)
{
    pthread_mutex_lock(&g->lock);
    g->answers_images = answer;
    pthread_mutex_unlock(&g->lock);
}

void lf_gateway_set_columns(gateway *g, int columns)
{
    pthread_mutex_lock(&g->lock);
    g->columns = columns;
    pthread_mutex_unlock(&g->lock);
}

int lf_gateway_calls(gateway *g, const char *method)
{
    int n = 0;
    pthread_mutex_lock(&g->lock);
    for (int i = 0; i < g->n_calls; i++)
        n += strcmp(g->calls[i], method) == 0;
    pthread_mutex_unlock(&g->lock);
    return n;
}

void lf_gateway_notify(gateway *g, const char *line)
{
    pthread_mutex_lock(&g->lock);
    for (int i = 0; i < g->n_connections; i++) {
        send_whole(g->connections[i], line);
        send_whole(g->connections[i], "\n");
    }
    pthread_mutex_unlock(&g->lock);
}

int lf_gateway_flood(gateway *g, const char *line, int most)
{
    const size_t length = strlen(line);
    size_t at = 0;
    int sent = 0, fd = g->connections[0];
    while (sent < most) {
        struct pollfd polled = {fd, POLLOUT, 0};
        if (at == 0 && poll(&polled, 1, 1000) == 0)
            break;
        ssize_t n = send(fd, line + at, length - at, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (n < 0 && errno == EAGAIN && at > 0 && poll(&polled, 1, 1000) == 0)
            break;
        at += n > 0 ? (size_t)n : 0;
        if (at == length) {
            at = 0;
            sent++;
        }
    }
    g->rest = at > 0 ? line + at : "";
    return sent;
}

void lf_gateway_flood_end(gateway *g)
{
    send_whole(g->connections[0], g->rest);
}

void lf_gateway_hang_up(gateway *g)
{
    pthread_mutex_lock(&g->lock);
    while (g->n_connections > 0)
        close_connection(g, 0);
    pthread_mutex_unlock(&g->lock);
}

/* ------------------------------------------------------------------------------- the gateway -- */

static int on_stop(sd_event_source *source, int fd, uint32_t what, void *context)
{
    (void)fd;
    (void)what;
    (void)context;
    return sd_event_exit(sd_event_source_get_event(source), 0);
}

static void *be_gateway(void *context)
{
    gateway *g = context;
    sd_event *event = NULL;
    lf_web *web = NULL;
    lf_error err = {0};
    if (sd_event_new(&event) < 0 ||
        sd_event_add_io(event, NULL, g->stop_web, POLLIN, on_stop, NULL) < 0 ||
        lf_web_create(event, g->web_fd, g->socket, &web, &err) != LF_OK)
        abort();
    g->port = lf_web_port(web);
    snprintf(g->token, sizeof g->token, "%s", strchr(lf_web_url(web), '#') + 1);
    pthread_barrier_wait(&g->ready);
    sd_event_loop(event);
    lf_web_destroy(web);
    sd_event_unref(event);
    return NULL;
}

int lf_gateway_setup(void **state)
{
    gateway *g = calloc(1, sizeof *g);
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    lf_error err = {0};
    assert_non_null(g);
    g->folder = lf_test_folder();
    assert_true(snprintf(g->socket, sizeof g->socket, "%s/sock", g->folder) < 108);
    memcpy(address.sun_path, g->socket, sizeof address.sun_path);
    g->answers_images = true;
    g->columns = FALSE_COLUMNS;
    g->stop_web = eventfd(0, EFD_CLOEXEC);
    g->stop_daemon = eventfd(0, EFD_CLOEXEC);
    g->daemon_fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(bind(g->daemon_fd, (struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(g->daemon_fd, 40), 0);
    lf_assert_ok(lf_web_listen("127.0.0.1:0", &g->web_fd, &err), &err);
    pthread_mutex_init(&g->lock, NULL);
    pthread_barrier_init(&g->ready, NULL, 2);
    assert_int_equal(pthread_create(&g->daemon_thread, NULL, be_daemon, g), 0);
    assert_int_equal(pthread_create(&g->web_thread, NULL, be_gateway, g), 0);
    pthread_barrier_wait(&g->ready);
    *state = g;
    return 0;
}

int lf_gateway_teardown(void **state)
{
    gateway *g = *state;
    const uint64_t one = 1;
    assert_int_equal(write(g->stop_web, &one, sizeof one), sizeof one);
    pthread_join(g->web_thread, NULL);
    assert_int_equal(write(g->stop_daemon, &one, sizeof one), sizeof one);
    pthread_join(g->daemon_thread, NULL);
    lf_gateway_hang_up(g);
    close(g->stop_web);
    close(g->stop_daemon);
    close(g->daemon_fd);
    pthread_mutex_destroy(&g->lock);
    pthread_barrier_destroy(&g->ready);
    lf_test_folder_remove(g->folder);
    free(g);
    return 0;
}

int lf_gateway_port(const gateway *g)
{
    return g->port;
}

const char *lf_gateway_token(const gateway *g)
{
    return g->token;
}

const char *lf_gateway_cookie(gateway *g)
{
    char header[80];
    snprintf(header, sizeof header, "Authorization: Bearer %s\r\n", g->token);
    const char *answer = lf_caller_get(g, "POST /api/login HTTP/1.1", header);
    const char *at = strstr(answer, "Set-Cookie: ");
    assert_int_equal(lf_caller_status(answer), 204);
    assert_non_null(at);
    at += strlen("Set-Cookie: ");
    snprintf(g->cookie, sizeof g->cookie, "%.*s", (int)strcspn(at, ";\r"), at);
    return g->cookie;
}

/* ----------------------------------------------------------------------------------- clients -- */

int lf_caller_connect(const gateway *g)
{
    struct sockaddr_in address = {.sin_family = AF_INET,
                                  .sin_port = htons((uint16_t)g->port),
                                  .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    const struct timeval patience = {.tv_sec = PATIENCE_MS / 1000};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_true(fd >= 0);
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    assert_int_equal(connect(fd, (struct sockaddr *)&address, sizeof address), 0);
    return fd;
}

bool lf_caller_send(int fd, const char *raw, size_t n)
{
    while (n > 0) {
        ssize_t sent = send(fd, raw, n, MSG_NOSIGNAL);
        if (sent <= 0)
            return false;
        raw += sent;
        n -= (size_t)sent;
    }
    return true;
}

size_t lf_caller_flood(int fd, const char *raw, size_t n)
{
    size_t sent = 0;
    struct pollfd polled = {fd, POLLOUT, 0};
    while (sent < n && poll(&polled, 1, 1000) > 0) {
        ssize_t more = send(fd, raw + sent, n - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (more < 0 && errno != EAGAIN)
            break;
        sent += more > 0 ? (size_t)more : 0;
    }
    return sent;
}

const char *lf_caller_ask(const gateway *g, const char *request)
{
    static char answer[1 << 17];
    size_t used = 0;
    int fd = lf_caller_connect(g);
    (void)lf_caller_send(fd, request, strlen(request));
    ssize_t n;
    while (used + 1 < sizeof answer &&
           (n = recv(fd, answer + used, sizeof answer - 1 - used, 0)) > 0)
        used += (size_t)n;
    answer[used] = '\0';
    close(fd);
    return answer;
}

const char *lf_caller_get(const gateway *g, const char *line, const char *headers)
{
    char request[4096];
    snprintf(request, sizeof request, "%s\r\nHost: 127.0.0.1:%d\r\n%s\r\n", line, g->port, headers);
    return lf_caller_ask(g, request);
}

int lf_caller_status(const char *answer)
{
    return strncmp(answer, "HTTP/1.1 ", 9) == 0 ? atoi(answer + 9) : 0;
}

int lf_talk_connect(const gateway *g, const char *headers, const char **out_answer)
{
    static char answer[4096];
    char request[4096];
    size_t used = 0;
    int fd = lf_caller_connect(g);
    snprintf(request, sizeof request,
             "GET /rpc HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nUpgrade: websocket\r\n"
             "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
             "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n%s\r\n",
             g->port, headers);
    assert_true(lf_caller_send(fd, request, strlen(request)));
    while (used + 1 < sizeof answer && recv(fd, answer + used, 1, 0) == 1) {
        answer[++used] = '\0';
        if (used >= 4 && strcmp(answer + used - 4, "\r\n\r\n") == 0)
            break;
    }
    if (out_answer)
        *out_answer = answer;
    return fd;
}

int lf_talk_open(const gateway *g)
{
    char header[80];
    const char *answer = NULL;
    snprintf(header, sizeof header, "Authorization: Bearer %s\r\n", g->token);
    int fd = lf_talk_connect(g, header, &answer);
    assert_int_equal(lf_caller_status(answer), 101);
    return fd;
}

void lf_talk_send(int fd, int opcode, const char *data, size_t n)
{
    unsigned char head[14] = {(unsigned char)(0x80 | opcode)};
    size_t n_head = 2;
    if (n < 126) {
        head[1] = (unsigned char)(0x80 | n);
    } else if (n < 65536) {
        head[1] = 0x80 | 126;
        for (int i = 0; i < 2; i++)
            head[n_head++] = (unsigned char)(n >> (8 - 8 * i));
    } else {
        head[1] = 0x80 | 127;
        for (int i = 0; i < 8; i++)
            head[n_head++] = (unsigned char)(n >> (56 - 8 * i));
    }
    n_head += 4; /* a mask of zeros: the data is as it is */
    if (lf_caller_send(fd, (const char *)head, n_head))
        (void)lf_caller_send(fd, data, n);
}

void lf_talk_say(int fd, const char *text)
{
    lf_talk_send(fd, 1, text, strlen(text));
}

static bool receive_all(int fd, unsigned char *to, size_t n)
{
    for (size_t used = 0; used < n;) {
        ssize_t got = recv(fd, to + used, n - used, 0);
        if (got <= 0)
            return false;
        used += (size_t)got;
    }
    return true;
}

int lf_talk_next(int fd, const unsigned char **out_data, size_t *out_n)
{
    static unsigned char data[(1 << 21) + 1];
    for (;;) {
        unsigned char head[10];
        if (!receive_all(fd, head, 2))
            return -1;
        size_t n = head[1] & 127u, more = n == 126 ? 2 : n == 127 ? 8 : 0;
        if (!receive_all(fd, head + 2, more))
            return -1;
        for (size_t i = 0, m = 0; i < more; i++)
            n = m = m << 8 | head[2 + i];
        assert_true(n < sizeof data);
        assert_false(head[1] & 0x80); /* a server does not mask */
        if (!receive_all(fd, data, n))
            return -1;
        data[n] = '\0';
        if ((head[0] & 15) == 9 || (head[0] & 15) == 10)
            continue;
        *out_data = data;
        *out_n = n;
        return head[0] & 15;
    }
}

const char *lf_talk_until(int fd, const char *word, int *out_binaries)
{
    const unsigned char *data = NULL;
    size_t n = 0;
    for (int opcode; (opcode = lf_talk_next(fd, &data, &n)) > 0;) {
        if (opcode == 8)
            fail_msg("closed with %d: %s", n >= 2 ? data[0] << 8 | data[1] : 0,
                     n >= 2 ? (const char *)data + 2 : "");
        if (opcode == 2 && out_binaries)
            ++*out_binaries;
        if (opcode == 1 && strstr((const char *)data, word))
            return (const char *)data;
    }
    fail_msg("the connection ended before \"%s\"", word);
    return NULL;
}
