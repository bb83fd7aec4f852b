#include "tests/web/gateway.h"

#include <errno.h>
#include <fcntl.h>
#include <jansson.h>
#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/un.h>

#include "daemon/web/listen.h"
#include "daemon/web/web.h"

enum { MAX_CONNECTIONS = 40, MAX_CALLS = 4096, LINE = 1 << 20, MAX_FDS = 64 };

struct gateway {
    char *folder;
    char socket[108];
    pthread_t web_thread, daemon_thread;
    int stop_web, stop_daemon; /* eventfds */
    int daemon_fd;             /* listening */
    struct {
        lf_web_sockets sockets;
        int port;
    } services[LF_SERVICES];
    const char *public_origin;
    lf_origins allowed;
    char url[LF_WEB_URL_SIZE];
    char cookie[128];
    pthread_barrier_t ready;
    pthread_mutex_t lock; /* holds what follows */
    int connections[MAX_CONNECTIONS];
    char *lines[MAX_CONNECTIONS]; /* [LINE] what came of the next line */
    size_t used[MAX_CONNECTIONS];
    bool limited[MAX_CONNECTIONS]; /* rights.limit was answered */
    int n_connections;
    char calls[MAX_CALLS][24];
    int n_calls;
    bool answers_images;
    lf_gateway_rights rights;
    lf_false_slideshow slideshow;
    int unlimited; /* calls before the rights were limited */
    struct {
        int fd[MAX_FDS];
        int n;
    } passed, exported; /* that no call has taken yet; of the last export */
    int n_jobs;
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

/* The next descriptor that came; -1: none. The caller closes it. */
static int take_fd(gateway *g)
{
    if (g->passed.n == 0)
        return -1;
    const int fd = g->passed.fd[0];
    memmove(g->passed.fd, g->passed.fd + 1, (size_t)--g->passed.n * sizeof(int));
    return fd;
}

/* What a passed file holds, and whether it can only be read. */
static json_t *look_at_fd(int fd)
{
    char text[64] = "";
    const ssize_t n = pread(fd, text, sizeof text - 1, 0);
    const bool reads = (fcntl(fd, F_GETFL) & O_ACCMODE) == O_RDONLY;
    json_t *seen = json_pack("{s:s, s:b, s:I}", "text", n > 0 ? text : "", "reads", reads, "bytes",
                             (json_int_t)lseek(fd, 0, SEEK_END));
    if (fd >= 0)
        close(fd);
    return seen ? seen : json_object();
}

static json_t *take_files(gateway *g, const char *method, json_t *params)
{
    json_t *seen = json_array();
    for (size_t i = 0; i < json_array_size(json_object_get(params, "files")); i++)
        json_array_append_new(seen, look_at_fd(take_fd(g)));
    return json_pack("{s:s, s:O?, s:o}", "method", method, "params", params, "seen", seen);
}

/* Job 1, 2 … writes its number and the number of the file. */
static json_t *take_export(gateway *g, json_t *params)
{
    char text[32];
    while (g->exported.n > 0)
        close(g->exported.fd[--g->exported.n]);
    g->n_jobs++;
    for (json_int_t i = 0; i < json_integer_value(json_object_get(params, "fds")); i++) {
        const int fd = take_fd(g),
                  n = snprintf(text, sizeof text, "job %d file %d", g->n_jobs, (int)i);
        if (fd < 0 || write(fd, text, (size_t)n) != n)
            return json_object();
        g->exported.fd[g->exported.n++] = fd;
    }
    return json_pack("{s:i, s:O, s:O}", "job", g->n_jobs, "file", json_object_get(params, "file"),
                     "params", params);
}

static json_t *make_thumbnail(int fd)
{
    static const char jpeg[] = "\xff\xd8 a thumbnail \xff\xd9";
    if (fd < 0 || write(fd, jpeg, sizeof jpeg) != (ssize_t)sizeof jpeg)
        return json_object();
    close(fd);
    return json_pack("{s:i, s:i, s:i}", "width", 16, "height", 16, "bytes", (int)sizeof jpeg);
}

/* NULL: *out_code and *out_pointer say why. */
static json_t *limit_rights(gateway *g, json_t *params, int *out_code, const char **out_pointer)
{
    size_t i;
    json_t *name;
    static char pointer[32];
    *out_code = g->rights == LF_RIGHTS_UNKNOWN  ? -32601
                : g->rights == LF_RIGHTS_SILENT ? 0
                                                : -32602;
    json_array_foreach(json_object_get(params, "methods"), i, name)
    {
        if (g->rights != LF_RIGHTS_LACKING || strcmp(json_string_value(name), "doctor") != 0)
            continue;
        snprintf(pointer, sizeof pointer, "/methods/%zu", i);
        *out_pointer = pointer;
    }
    if (g->rights == LF_RIGHTS_KNOWN || (g->rights == LF_RIGHTS_LACKING && !*out_pointer))
        return json_incref(params);
    return NULL;
}

static json_t *result_of(gateway *g, const char *method, json_t *params, int *out_code,
                         const char **out_pointer)
{
    const char *file = json_string_value(json_object_get(params, "file"));
    if (strcmp(method, "status") == 0)
        return json_pack("{s:s, s:i}", "state", "rendering", "generation", 7);
    if (strcmp(method, "rights.limit") == 0)
        return limit_rights(g, params, out_code, out_pointer);
    if (strcmp(method, "export") == 0)
        return take_export(g, params);
    if (strcmp(method, "scene.load") == 0 || strcmp(method, "scene.patch") == 0)
        return take_files(g, method, params);
    if (!g->answers_images &&
        (strcmp(method, "library.thumbnail") == 0 || strcmp(method, "quilt.show") == 0)) {
        close(take_fd(g));
        return NULL;
    }
    if (strcmp(method, "library.thumbnail") == 0) {
        const int fd = take_fd(g);
        *out_code = -32001;
        if (file && strcmp(file, "/etc/passwd") != 0)
            return make_thumbnail(fd);
        close(fd);
        return NULL;
    }
    if (strcmp(method, "quilt.show") == 0) {
        json_t *seen = look_at_fd(take_fd(g));
        *out_code = -32602;
        if (json_integer_value(json_object_get(params, "columns")) < 99)
            return json_pack("{s:i, s:O, s:o}", "generation", 9, "params", params, "seen", seen);
        json_decref(seen);
        return NULL;
    }
    return params ? json_pack("{s:s, s:O}", "method", method, "params", params)
                  : json_pack("{s:s}", "method", method);
}

/* In one piece, so that no client acts between two of them: quiltd sends them without a pause, too.
 */
static void send_all(int connection, json_t *notes)
{
    char *text = NULL;
    size_t i, size = 0;
    json_t *message;
    FILE *out = open_memstream(&text, &size);
    json_array_foreach(notes, i, message)
    {
        json_dumpf(message, out, JSON_COMPACT);
        fputc('\n', out);
    }
    fclose(out);
    if (size > 0)
        send_whole(connection, text);
    free(text);
    json_decref(notes);
}

/* A call without an id gets none. */
static void send_answer(int connection, json_t *answer)
{
    char *text = NULL;
    if (json_is_null(json_object_get(answer, "id"))) {
        json_decref(answer);
        return;
    }
    text = json_dumps(answer, JSON_COMPACT);
    send_whole(connection, text);
    send_whole(connection, "\n");
    free(text);
    json_decref(answer);
}

static json_t *make_error(json_t *id, int code, const char *message, const char *pointer)
{
    return json_pack("{s:s, s:O?, s:{s:i, s:s, s:{s:s*}}}", "jsonrpc", "2.0", "id", id, "error",
                     "code", code, "message", message, "data", "pointer", pointer);
}

/* False: the slideshow does not answer this. */
static bool answer_slideshow(gateway *g, int i, const char *method, json_t *params, json_t *id)
{
    lf_false_answer answer;
    if (!lf_false_slideshow_answer(&g->slideshow, method, params, &answer))
        return false;
    send_all(g->connections[i], answer.before);
    send_answer(g->connections[i], answer.result ? json_pack("{s:s, s:O?, s:o}", "jsonrpc", "2.0",
                                                             "id", id, "result", answer.result)
                                                 : make_error(id, -32002, answer.message, NULL));
    send_all(g->connections[i], answer.after);
    return true;
}

static void answer_line(gateway *g, int i, const char *line, size_t n)
{
    json_t *call = json_loadb(line, n, 0, NULL), *result = NULL;
    const char *method = json_string_value(json_object_get(call, "method")), *pointer = NULL;
    json_t *params = json_object_get(call, "params"), *id = json_object_get(call, "id");
    int code = 0;
    if (!method) { /* no assertion: this is another thread */
        json_decref(call);
        return;
    }
    if (g->n_calls < MAX_CALLS)
        snprintf(g->calls[g->n_calls++], sizeof g->calls[0], "%s", method);
    const bool limits = strcmp(method, "rights.limit") == 0;
    g->unlimited += !limits && !g->limited[i];
    if (answer_slideshow(g, i, method, params, id)) {
        json_decref(call);
        return;
    }
    if (strcmp(method, "frame.get") == 0) {
        const int fd = take_fd(g);
        result = g->answers_images ? image_for(params, fd, g->columns) : NULL;
        if (fd >= 0)
            close(fd);
    } else {
        result = result_of(g, method, params, &code, &pointer);
    }
    g->limited[i] |= limits && (result || code == -32601);
    if (result)
        send_answer(g->connections[i],
                    json_pack("{s:s, s:O?, s:o}", "jsonrpc", "2.0", "id", id, "result", result));
    else if (code != 0)
        send_answer(g->connections[i], make_error(id, code, "the false quiltd refuses", pointer));
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
        g->limited[k] = g->limited[k + 1];
    }
}

static void keep_fds(gateway *g, struct msghdr *message)
{
    struct cmsghdr *c = CMSG_FIRSTHDR(message);
    if (!c || c->cmsg_type != SCM_RIGHTS)
        return;
    const size_t n = (c->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (size_t i = 0; i < n && g->passed.n < MAX_FDS; i++)
        memcpy(&g->passed.fd[g->passed.n++], CMSG_DATA(c) + i * sizeof(int), sizeof(int));
}

/* False: the connection is gone. */
static bool read_connection(gateway *g, int i)
{
    union {
        struct cmsghdr align;
        char bytes[CMSG_SPACE(MAX_FDS * sizeof(int))];
    } control;
    struct iovec vector = {g->lines[i] + g->used[i], LINE - g->used[i]};
    struct msghdr message = {.msg_iov = &vector,
                             .msg_iovlen = 1,
                             .msg_control = &control,
                             .msg_controllen = sizeof control};
    ssize_t n = recvmsg(g->connections[i], &message, MSG_CMSG_CLOEXEC);
    if (n <= 0)
        return false;
    keep_fds(g, &message);
    g->used[i] += (size_t)n;
    char *line = g->lines[i], *end;
    while ((end = memchr(line, '\n', g->used[i] - (size_t)(line - g->lines[i])))) {
        answer_line(g, i, line, (size_t)(end - line));
        line = end + 1;
    }
    g->used[i] -= (size_t)(line - g->lines[i]);
    memmove(g->lines[i], line, g->used[i]);
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
    g->limited[g->n_connections] = false;
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

void lf_gateway_set_slideshow(gateway *g, void (*change)(lf_false_slideshow *))
{
    pthread_mutex_lock(&g->lock);
    change(&g->slideshow);
    pthread_mutex_unlock(&g->lock);
}

json_t *lf_gateway_slideshow(gateway *g)
{
    pthread_mutex_lock(&g->lock);
    json_t *json = lf_false_slideshow_json(&g->slideshow);
    pthread_mutex_unlock(&g->lock);
    return json;
}

void lf_gateway_set_rights(gateway *g, lf_gateway_rights rights)
{
    pthread_mutex_lock(&g->lock);
    g->rights = rights;
    pthread_mutex_unlock(&g->lock);
}

int lf_gateway_unlimited(gateway *g)
{
    pthread_mutex_lock(&g->lock);
    const int n = g->unlimited;
    pthread_mutex_unlock(&g->lock);
    return n;
}

bool lf_gateway_grow_export(gateway *g, int64_t bytes)
{
    pthread_mutex_lock(&g->lock);
    const bool grown = g->exported.n > 0 && ftruncate(g->exported.fd[0], bytes) == 0;
    pthread_mutex_unlock(&g->lock);
    return grown;
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
    lf_web_config config = {.allowed = &g->allowed,
                            .socket = g->socket,
                            .public_origin = g->public_origin,
                            .upload_limit = GATEWAY_UPLOADS};
    for (int i = 0; i < LF_SERVICES; i++)
        config.services[i] = g->services[i].sockets;
    if (sd_event_new(&event) < 0 ||
        sd_event_add_io(event, NULL, g->stop_web, POLLIN, on_stop, NULL) < 0 ||
        lf_web_create(event, &config, &web, &err) != LF_OK)
        abort();
    for (int i = 0; i < LF_SERVICES; i++)
        g->services[i].port = lf_web_port(web, i);
    snprintf(g->url, sizeof g->url, "%s", lf_web_url(web));
    pthread_barrier_wait(&g->ready);
    sd_event_loop(event);
    lf_web_destroy(web);
    sd_event_unref(event);
    return NULL;
}

static int set_up(void **state, const char *public_origin, bool programs)
{
    gateway *g = calloc(1, sizeof *g);
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    lf_error err = {0};
    assert_non_null(g);
    g->public_origin = public_origin;
    g->folder = lf_test_folder();
    assert_true(snprintf(g->socket, sizeof g->socket, "%s/sock", g->folder) < 108);
    memcpy(address.sun_path, g->socket, sizeof address.sun_path);
    g->answers_images = true;
    g->columns = FALSE_COLUMNS;
    g->slideshow.on = programs;
    g->stop_web = eventfd(0, EFD_CLOEXEC);
    g->stop_daemon = eventfd(0, EFD_CLOEXEC);
    g->daemon_fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(bind(g->daemon_fd, (struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(g->daemon_fd, 40), 0);
    for (int i = 0; i < (programs ? LF_SERVICES : 1); i++)
        lf_assert_ok(lf_web_listen_port(0, &g->services[i].sockets, &err), &err);
    if (programs)
        lf_assert_ok(lf_origins_add(&g->allowed, "https://allowed.test", &err), &err);
    pthread_mutex_init(&g->lock, NULL);
    pthread_barrier_init(&g->ready, NULL, 2);
    assert_int_equal(pthread_create(&g->daemon_thread, NULL, be_daemon, g), 0);
    assert_int_equal(pthread_create(&g->web_thread, NULL, be_gateway, g), 0);
    pthread_barrier_wait(&g->ready);
    *state = g;
    return 0;
}

int lf_gateway_setup(void **state)
{
    return set_up(state, NULL, false);
}

int lf_gateway_public_setup(void **state)
{
    return set_up(state, "https://panel.test", false);
}

int lf_gateway_programs_setup(void **state)
{
    return set_up(state, NULL, true);
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
    lf_false_slideshow_finish(&g->slideshow);
    while (g->exported.n > 0)
        close(g->exported.fd[--g->exported.n]);
    while (g->passed.n > 0)
        close(take_fd(g));
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
    return g->services[LF_SERVICE_PAGE].port;
}

int lf_gateway_service_port(const gateway *g, int service)
{
    return g->services[service].port;
}

bool lf_gateway_has_v6(const gateway *g)
{
    return g->services[LF_SERVICE_PAGE].sockets.n == 2;
}

const char *lf_gateway_url(const gateway *g)
{
    return g->url;
}

const char *lf_gateway_token(const gateway *g)
{
    return strchr(g->url, '#') + 1;
}

const char *lf_gateway_cookie(gateway *g)
{
    char header[80];
    snprintf(header, sizeof header, "Authorization: Bearer %s\r\n", lf_gateway_token(g));
    const char *answer = lf_caller_get(g, "POST /api/login HTTP/1.1", header);
    const char *at = strstr(answer, "Set-Cookie: ");
    assert_int_equal(lf_caller_status(answer), 204);
    assert_non_null(at);
    at += strlen("Set-Cookie: ");
    snprintf(g->cookie, sizeof g->cookie, "%.*s", (int)strcspn(at, ";\r"), at);
    return g->cookie;
}
