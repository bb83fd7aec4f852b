/* What takes too long: connections, bodies, readers, files that nobody fetches. Time passes when
 * the test says so. */
#include "tests/web/clock.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>

#include "daemon/web/downloads.h"
#include "daemon/web/listen.h"
#include "daemon/web/patience.h"
#include "daemon/web/session.h"
#include "daemon/web/stream.h"
#include "daemon/web/uploads.h"
#include "daemon/web/web.h"
#include "daemon/web/ws.h"

static sd_event *event;

static int setup(void **state)
{
    (void)state;
    assert_true(sd_event_new(&event) >= 0);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    lf_clock_finish();
    event = sd_event_unref(event);
    return 0;
}

static void make_pair(int fds[2])
{
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, fds), 0);
}

static void close_pair(const int fds[2])
{
    close(fds[0]);
    close(fds[1]);
}

/* Nothing came, and the other side is there. */
static bool is_open(int fd)
{
    char byte;
    return recv(fd, &byte, 1, MSG_DONTWAIT | MSG_PEEK) < 0 && errno == EAGAIN;
}

/* ---------------------------------------------------------------------------------- patience -- */

static void a_connection_has_so_long_for_all(void **state)
{
    (void)state;
    lf_patience *patience = NULL;
    int fds[2];
    make_pair(fds);
    lf_assert_ok(lf_patience_create(event, fds[0], 1000000, &patience), NULL);
    lf_patience_note(patience, 10 * LF_PATIENCE_BYTES);
    lf_clock_pass(event, 0.9);
    assert_true(is_open(fds[1]));
    lf_clock_pass(event, 0.1);
    assert_false(is_open(fds[1]));
    lf_patience_destroy(patience);
    close_pair(fds);
}

static void a_paced_connection_has_so_long_for_each_part(void **state)
{
    (void)state;
    lf_patience *patience = NULL;
    int fds[2];
    make_pair(fds);
    lf_assert_ok(lf_patience_create(event, fds[0], 1000000, &patience), NULL);
    lf_patience_pace(patience, 1000000);
    for (int i = 0; i < 3; i++) {
        lf_patience_note(patience, LF_PATIENCE_BYTES - 1);
        lf_patience_note(patience, 1);
        lf_clock_pass(event, 1);
        assert_true(is_open(fds[1]));
    }
    lf_patience_note(patience, LF_PATIENCE_BYTES - 1);
    lf_clock_pass(event, 1);
    assert_false(is_open(fds[1]));
    lf_patience_destroy(patience);
    close_pair(fds);
}

/* After the first minute what was moved needs a rate, too, and not only a part in each period. */
static void a_paced_connection_needs_a_mean_rate(void **state)
{
    (void)state;
    enum { PERIOD_S = 10, RATE = 65536 };
    lf_patience *patience = NULL;
    int fds[2];
    make_pair(fds);
    lf_assert_ok(lf_patience_create(event, fds[0], 1000000, &patience), NULL);
    lf_patience_pace(patience, PERIOD_S * 1000000);
    for (int i = 1; i <= 20; i++) { /* all that is due comes at the last moment */
        lf_patience_note(patience, i > 6 ? PERIOD_S * RATE - LF_PATIENCE_BYTES : LF_PATIENCE_BYTES);
        lf_patience_note(patience, i > 6 ? LF_PATIENCE_BYTES : 0);
        lf_clock_pass(event, PERIOD_S);
        assert_true(is_open(fds[1]));
    }
    for (int i = 0; i < 2; i++) { /* the parts of the first minute last for one period more */
        assert_true(is_open(fds[1]));
        lf_patience_note(patience, PERIOD_S * RATE / 2);
        lf_clock_pass(event, PERIOD_S);
    }
    assert_false(is_open(fds[1]));
    lf_patience_destroy(patience);
    close_pair(fds);
}

static void a_stopped_patience_is_endless(void **state)
{
    (void)state;
    lf_patience *patience = NULL;
    int fds[2];
    make_pair(fds);
    lf_assert_ok(lf_patience_create(event, fds[0], 1000000, &patience), NULL);
    lf_patience_stop(patience);
    lf_clock_pass(event, 1);
    assert_true(is_open(fds[1]));
    lf_patience_wait(patience, 1000000);
    lf_clock_pass(event, 1);
    assert_false(is_open(fds[1]));
    lf_patience_destroy(patience);
    close_pair(fds);
}

/* -------------------------------------------------------------------------------- WebSockets -- */

static int n_ended;

static void on_ended(void *context)
{
    (void)context;
    n_ended++;
}

static void on_other(void *context)
{
    (void)context;
}

static void on_text(void *context, const char *text, size_t n)
{
    (void)context;
    (void)text;
    (void)n;
}

/* Takes all that is there. */
static size_t drain(int fd)
{
    static char taken[1 << 16];
    size_t all = 0;
    for (ssize_t n; (n = recv(fd, taken, sizeof taken, MSG_DONTWAIT)) > 0;)
        all += (size_t)n;
    return all;
}

static void a_reader_has_to_take_a_part_of_what_waits(void **state)
{
    (void)state;
    enum { LONG = 1 << 20, MESSAGES = 4 };
    const lf_ws_events events = {.text = on_text, .flushed = on_other, .ended = on_ended};
    lf_error err = {0};
    lf_ws *ws = NULL;
    int fds[2];
    char *text = malloc(LONG);
    assert_non_null(text);
    memset(text, 'x', LONG);
    make_pair(fds);
    n_ended = 0;
    lf_assert_ok(lf_ws_create(event, fds[0], "", 0, &events, &ws, &err), &err);
    for (int i = 0; i < MESSAGES; i++)
        lf_ws_send_text(ws, text, LONG);
    lf_clock_settle(event);
    for (int i = 0; i < 4; i++) { /* one that takes much stays */
        assert_true(drain(fds[1]) > 65536);
        lf_clock_pass(event, 19);
        assert_int_equal(n_ended, 0);
    }
    assert_true(lf_ws_queued(ws) > 0);
    lf_clock_pass(event, 1); /* one that takes nothing goes */
    assert_int_equal(n_ended, 1);
    lf_ws_destroy(ws);
    close_pair(fds);
    free(text);
}

/* ------------------------------------------------------------------------------ memory files -- */

static void uploads_that_nobody_uses_are_dropped(void **state)
{
    (void)state;
    lf_error err = {0};
    lf_uploads *uploads = NULL;
    lf_upload *one = NULL, *two = NULL;
    char folder[LF_UPLOADS_FOLDER + 1];
    lf_assert_ok(lf_uploads_create(event, 100, &uploads, &err), &err);
    lf_assert_ok(lf_uploads_begin(uploads, 3, &one, &err), &err);
    lf_assert_ok(lf_uploads_begin(uploads, 97, &two, &err), &err);
    lf_assert_ok(lf_upload_append(one, "abc", 3, &err), &err);
    lf_assert_status(lf_upload_append(one, "d", 1, &err), LF_E_ARG, &err);
    lf_assert_status(lf_upload_keep(two, NULL, "b", folder, &err), LF_E_ARG, &err);
    lf_assert_ok(lf_upload_keep(one, NULL, "a", folder, &err), &err);
    assert_int_equal(lf_uploads_bytes(uploads), 100);
    lf_clock_pass(event, 600);
    assert_int_equal(lf_uploads_count(uploads), 1); /* the one on its way stays */
    assert_int_equal(lf_uploads_bytes(uploads), 97);
    lf_upload_drop(two);
    assert_int_equal(lf_uploads_bytes(uploads), 0);
    lf_uploads_destroy(uploads);
}

static int n_over;

static void on_over(void *context, lf_download *download)
{
    (void)context;
    n_over++;
    lf_download_drop(download);
}

static lf_download *begin_download(lf_downloads *downloads, const char *name, size_t bytes)
{
    lf_error err = {0};
    lf_download *new = NULL;
    lf_assert_ok(lf_download_create(downloads, &name, 1, on_over, NULL, &new, &err), &err);
    assert_int_equal(ftruncate(lf_download_fd(new, 0), (off_t)bytes), 0);
    return new;
}

/* Its path behind the prefix. */
static const char *end_download(lf_download *download)
{
    lf_error err = {0};
    json_t *files = NULL;
    char *out = lf_test_buffer();
    lf_assert_ok(lf_download_finish(download, &files, &err), &err);
    const char *path = json_string_value(json_object_get(json_array_get(files, 0), "path"));
    snprintf(out, PATH_MAX, "%s", path + strlen(LF_DOWNLOADS_PREFIX));
    json_decref(files);
    return out;
}

static void downloads_are_dropped_unless_they_are_read(void **state)
{
    (void)state;
    lf_error err = {0};
    lf_downloads *downloads = NULL;
    lf_download_read read, other;
    lf_assert_ok(lf_downloads_create(event, 1000, &downloads, &err), &err);
    const char *path = end_download(begin_download(downloads, "a.png", 10));
    (void)end_download(begin_download(downloads, "b.png", 20));
    assert_true(lf_download_open(downloads, path, &read));
    assert_int_equal(read.bytes, 10);
    assert_string_equal(read.name, "a.png");
    lf_clock_pass(event, 600);
    assert_int_equal(lf_downloads_count(downloads), 1);
    assert_false(lf_download_open(downloads, path, &other)); /* for nobody new */
    lf_download_close(&read);
    assert_int_equal(lf_downloads_count(downloads), 0);
    lf_downloads_destroy(downloads);
}

static void downloads_have_a_limit_together(void **state)
{
    (void)state;
    lf_error err = {0};
    lf_downloads *downloads = NULL;
    json_t *files = NULL;
    lf_download_read read;
    n_over = 0;
    lf_assert_ok(lf_downloads_create(event, 1000, &downloads, &err), &err);
    const char *first = end_download(begin_download(downloads, "a.png", 500));
    const char *second = end_download(begin_download(downloads, "b.png", 500));
    (void)end_download(begin_download(downloads, "c.png", 400)); /* the oldest goes */
    assert_false(lf_download_open(downloads, first, &read));
    assert_true(lf_download_open(downloads, second, &read));
    lf_download *large = begin_download(downloads, "d.png", 0);
    assert_int_equal(ftruncate(lf_download_fd(large, 0), 600), 0);
    lf_clock_pass(event, 0.5); /* c.png goes; b.png is read; the largest unfinished one is to end */
    assert_int_equal(n_over, 1);
    assert_int_equal(lf_downloads_bytes(downloads), 500);
    lf_download_close(&read);
    lf_assert_status(lf_download_finish(begin_download(downloads, "e.png", 1001), &files, &err),
                     LF_E_NOMEM, &err);
    assert_int_equal(lf_downloads_count(downloads), 1);
    lf_downloads_destroy(downloads);
}

/* Its path is told to a client, so it stays; if there is no room for it, it is no download. */
static void a_finished_export_does_not_make_room_for_others(void **state)
{
    (void)state;
    lf_error err = {0};
    lf_downloads *downloads = NULL;
    json_t *files = NULL;
    lf_download_read read, other;
    n_over = 0;
    lf_assert_ok(lf_downloads_create(event, 1000, &downloads, &err), &err);
    const char *first = end_download(begin_download(downloads, "a.png", 300));
    assert_true(lf_download_open(downloads, first, &read));
    lf_download *large = begin_download(downloads, "b.png", 500);
    const char *second = end_download(begin_download(downloads, "c.png", 400));
    assert_int_equal(n_over, 1); /* b.png, which is being written, goes */
    assert_true(lf_download_open(downloads, second, &other));
    lf_download_close(&other);
    large = begin_download(downloads, "d.png", 0);
    assert_int_equal(ftruncate(lf_download_fd(large, 0), 800), 0);
    lf_assert_status(lf_download_finish(large, &files, &err), LF_E_NOMEM, &err);
    assert_null(files);
    assert_int_equal(lf_downloads_bytes(downloads), 300);
    lf_download_close(&read);
    lf_downloads_destroy(downloads);
}

/* ------------------------------------------------------------------------------------ images -- */

/* A quiltd that says what the test says: its listening socket, at a path in a folder. */
static int listen_as_quiltd(const char *folder, char path[108])
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    assert_true(snprintf(path, 108, "%s/sock", folder) < 108);
    memcpy(address.sun_path, path, sizeof address.sun_path);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    assert_int_equal(bind(fd, (const struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(fd, 16), 0);
    return fd;
}

/* What came of the gateway since the last call, terminated, in a static buffer; a descriptor that
 * came with it in *out_fd, if it is wanted. */
static const char *hear(int fd, int *out_fd)
{
    static char text[4096];
    union {
        struct cmsghdr align;
        char bytes[CMSG_SPACE(sizeof(int))];
    } control;
    size_t used = 0;
    lf_clock_settle(event);
    for (ssize_t n = 1; n > 0; used += n > 0 ? (size_t)n : 0) {
        struct iovec vector = {text + used, sizeof text - 1 - used};
        struct msghdr message = {.msg_iov = &vector,
                                 .msg_iovlen = 1,
                                 .msg_control = &control,
                                 .msg_controllen = sizeof control};
        n = recvmsg(fd, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
        const struct cmsghdr *c = n > 0 ? CMSG_FIRSTHDR(&message) : NULL;
        int passed = -1;
        if (!c)
            continue;
        memcpy(&passed, CMSG_DATA(c), sizeof passed);
        if (out_fd)
            *out_fd = passed;
        else
            close(passed);
    }
    text[used] = '\0';
    return text;
}

static void say(int fd, const char *text)
{
    for (size_t n = strlen(text); n > 0;) {
        ssize_t sent = send(fd, text, n, MSG_DONTWAIT | MSG_NOSIGNAL);
        text += sent > 0 ? sent : 0;
        n -= sent > 0 ? (size_t)sent : 0;
        lf_clock_settle(event);
    }
}

/* Answers the call that limits rights; all other calls wait for it. */
static void limit_rights(int quiltd)
{
    const char *call = hear(quiltd, NULL);
    assert_non_null(strstr(call, "rights.limit"));
    assert_ptr_equal(strchr(call, '\n') + 1, call + strlen(call));
    say(quiltd, "{\"jsonrpc\":\"2.0\",\"id\":\"quiltweb:rights\",\"result\":{}}\n");
}

/* No image is asked for while much waits for the client. */
static void a_slow_reader_gets_no_image(void **state)
{
    (void)state;
    enum { LONG = 200000, LINES = 4 };
    static const char start[] = "{\"jsonrpc\":\"2.0\",\"method\":\"preview.start\"}";
    char *folder = lf_test_folder(), path[108], *line = malloc(LONG + 2), frame[128] = {'\x81'};
    lf_error err = {0};
    lf_session *session = NULL;
    int fds[2], listener = listen_as_quiltd(folder, path);
    const lf_session_home home = {.event = event, .socket = path};
    assert_non_null(line);
    memset(line, 'x', LONG);
    memcpy(line + LONG, "\n", 2);
    make_pair(fds);
    lf_assert_ok(lf_session_create(&home, fds[0], "", 0, &session, &err), &err);
    int quiltd = accept(listener, NULL, NULL);
    limit_rights(quiltd);
    for (int i = 0; i < LINES; i++)
        say(quiltd, line);
    frame[1] = (char)(0x80 | strlen(start)); /* its mask is zero */
    memcpy(frame + 6, start, strlen(start));
    assert_true(send(fds[1], frame, 6 + strlen(start), MSG_NOSIGNAL) > 0);
    assert_null(strstr(hear(quiltd, NULL), "frame.get"));
    for (int i = 0; i < 2 * LINES; i++) {
        (void)drain(fds[1]);
        lf_clock_settle(event);
    }
    assert_non_null(strstr(hear(quiltd, NULL), "frame.get"));
    lf_session_destroy(session);
    close(quiltd);
    close(listener);
    close_pair(fds);
    free(line);
    lf_test_folder_remove(folder);
}

static int n_ready;

static void on_ready(void *context)
{
    (void)context;
    n_ready++;
}

/* A client that has left is seen when something is sent to it. */
static void a_stream_repeats_its_image(void **state)
{
    (void)state;
    static const char answer[] =
        "{\"jsonrpc\":\"2.0\",\"id\":\"quiltweb:stream\",\"result\":{\"columns\":1,\"rows\":1,"
        "\"views\":1,\"width\":2,\"height\":2,\"bytes\":5}}\n";
    char *folder = lf_test_folder(), path[108], first[512] = "", again[512] = "", byte;
    lf_error err = {0};
    lf_stream *stream = NULL;
    int listener = listen_as_quiltd(folder, path), file = -1;
    n_ready = 0;
    lf_assert_ok(lf_stream_create(event, path, on_ready, NULL, &stream, &err), &err);
    int quiltd = accept(listener, NULL, NULL);
    limit_rights(quiltd);
    assert_non_null(strstr(hear(quiltd, &file), "frame.get"));
    assert_int_equal(write(file, "image", 5), 5);
    close(file);
    say(quiltd, answer);
    assert_int_equal(n_ready, 1);
    const size_t n = lf_stream_read(stream, first, sizeof first - 1);
    assert_non_null(strstr(first, "\r\n\r\nimage\r\n--" LF_STREAM_BOUNDARY "\r\n"));
    assert_int_equal(lf_stream_read(stream, &byte, 1), 0);
    lf_clock_pass(event, LF_STREAM_REPEAT_S - 1);
    assert_int_equal(n_ready, 1);
    lf_clock_pass(event, 1);
    assert_int_equal(n_ready, 2);
    assert_int_equal(lf_stream_read(stream, again, sizeof again - 1), n);
    assert_string_equal(first, again);
    lf_stream_destroy(stream);
    close(quiltd);
    close(listener);
    lf_test_folder_remove(folder);
}

/* An image that comes while the last one is repeated would be cut into it. */
static void a_repeat_waits_for_an_image_on_its_way(void **state)
{
    (void)state;
    static const char answer[] =
        "{\"jsonrpc\":\"2.0\",\"id\":\"quiltweb:stream\",\"result\":{\"columns\":1,\"rows\":1,"
        "\"views\":1,\"width\":2,\"height\":2,\"bytes\":5}}\n";
    char *folder = lf_test_folder(), path[108], part[512] = "";
    lf_error err = {0};
    lf_stream *stream = NULL;
    int listener = listen_as_quiltd(folder, path), file = -1;
    lf_assert_ok(lf_stream_create(event, path, on_ready, NULL, &stream, &err), &err);
    int quiltd = accept(listener, NULL, NULL);
    limit_rights(quiltd);
    assert_non_null(strstr(hear(quiltd, &file), "frame.get"));
    assert_int_equal(write(file, "image", 5), 5);
    close(file);
    say(quiltd, answer);
    (void)lf_stream_read(stream, part, sizeof part - 1);
    lf_clock_pass(event, 0.25);
    say(quiltd, "{\"jsonrpc\":\"2.0\",\"method\":\"frame\",\"params\":{}}\n");
    assert_non_null(strstr(hear(quiltd, &file), "frame.get"));
    lf_clock_pass(event, LF_STREAM_REPEAT_S);
    assert_int_equal(lf_stream_read(stream, part, 10), 0);
    assert_int_equal(write(file, "other", 5), 5);
    close(file);
    say(quiltd, answer);
    (void)lf_stream_read(stream, part, sizeof part - 1);
    assert_non_null(strstr(part, "other"));
    lf_stream_destroy(stream);
    close(quiltd);
    close(listener);
    lf_test_folder_remove(folder);
}

/* ------------------------------------------------------------------------------- the gateway -- */

static lf_web *begin_web_for(const char *path)
{
    lf_error err = {0};
    lf_web *web = NULL;
    int fd = -1;
    const lf_web_config config = {
        .listen_fds = &fd, .n_listen_fds = 1, .socket = path, .upload_limit = 1 << 20};
    lf_assert_ok(lf_web_listen("127.0.0.1:0", &fd, &err), &err);
    lf_assert_ok(lf_web_create(event, &config, &web, &err), &err);
    return web;
}

static lf_web *begin_web(void)
{
    return begin_web_for("/nowhere");
}

static int connect_client(const lf_web *web)
{
    const struct sockaddr_in address = {.sin_family = AF_INET,
                                        .sin_port = htons((uint16_t)lf_web_port(web)),
                                        .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(connect(fd, (const struct sockaddr *)&address, sizeof address), 0);
    lf_clock_settle(event);
    return fd;
}

/* A client that has sent its headers. */
static int begin_client(const lf_web *web, const char *line, const char *headers)
{
    char request[512];
    int fd = connect_client(web);
    const int n =
        snprintf(request, sizeof request,
                 "%s HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nAuthorization: Bearer %s\r\n%s\r\n", line,
                 lf_web_port(web), strchr(lf_web_url(web), '#') + 1, headers);
    assert_int_equal(send(fd, request, (size_t)n, MSG_NOSIGNAL), n);
    return fd;
}

static void a_body_may_take_long_if_it_moves(void **state)
{
    (void)state;
    static char part[LF_PATIENCE_BYTES];
    lf_web *web = begin_web();
    char answer[64] = "";
    int fast = begin_client(web, "PUT /api/upload?name=a", "Content-Length: 196608\r\n");
    int slow = begin_client(web, "PUT /api/upload?name=b", "Content-Length: 196608\r\n");
    for (int i = 0; i < 3; i++) {
        assert_int_equal(send(fast, part, sizeof part, MSG_NOSIGNAL), sizeof part);
        assert_true(i > 0 || send(slow, part, sizeof part - 1, MSG_NOSIGNAL) > 0);
        lf_clock_settle(event);
        if (i < 2) {
            lf_clock_pass(event, 10);
            assert_true(is_open(fast));
            assert_false(is_open(slow));
        }
    }
    assert_true(recv(fast, answer, sizeof answer - 1, MSG_DONTWAIT) > 0);
    assert_memory_equal(answer, "HTTP/1.1 201", 12);
    close(fast);
    close(slow);
    lf_web_destroy(web);
}

/* A client of the web, behind which quiltd does what the test says. */
typedef struct behind {
    char *folder, path[108];
    int listener, quiltd;
    lf_web *web;
} behind;

static behind begin_behind(void)
{
    behind b = {.folder = lf_test_folder(), .quiltd = -1};
    b.listener = listen_as_quiltd(b.folder, b.path);
    b.web = begin_web_for(b.path);
    return b;
}

static void end_behind(const behind *b)
{
    lf_web_destroy(b->web);
    close(b->quiltd);
    close(b->listener);
    lf_test_folder_remove(b->folder);
}

/* A stream is repeated as long as quiltd answers, and ends if it does not. */
static void a_stream_ends_with_a_quiltd_that_hangs(void **state)
{
    (void)state;
    static const char answer[] =
        "{\"jsonrpc\":\"2.0\",\"id\":\"quiltweb:stream\",\"result\":{\"columns\":1,\"rows\":1,"
        "\"views\":1,\"width\":2,\"height\":2,\"bytes\":5}}\n";
    behind b = begin_behind();
    int file = -1, fd = begin_client(b.web, "GET /preview.mjpg", "");
    lf_clock_settle(event);
    b.quiltd = accept(b.listener, NULL, NULL);
    limit_rights(b.quiltd);
    assert_non_null(strstr(hear(b.quiltd, &file), "frame.get"));
    assert_int_equal(write(file, "image", 5), 5);
    close(file);
    say(b.quiltd, answer);
    for (int s = 0; s <= 70; s += LF_STREAM_REPEAT_S) {
        assert_true(drain(fd) > 0);
        lf_clock_pass(event, LF_STREAM_REPEAT_S);
    }
    say(b.quiltd, "{\"jsonrpc\":\"2.0\",\"method\":\"frame\",\"params\":{}}\n");
    assert_non_null(strstr(hear(b.quiltd, NULL), "frame.get")); /* and no answer */
    (void)drain(fd);
    for (int s = 0; s < 50; s += LF_STREAM_REPEAT_S)
        lf_clock_pass(event, LF_STREAM_REPEAT_S);
    assert_true(is_open(fd));
    for (int s = 50; s < 70; s += LF_STREAM_REPEAT_S)
        lf_clock_pass(event, LF_STREAM_REPEAT_S);
    assert_false(is_open(fd));
    close(fd);
    end_behind(&b);
}

static void send_text(int fd, const char *text)
{
    enum { LENGTH = 200 };
    char frame[8 + LENGTH + 1] = {'\x81', (char)(0x80 | 126), 0,
                                  (char)LENGTH}; /* its mask is zero */
    snprintf(frame + 8, LENGTH + 1, "%-*s", LENGTH, text);
    assert_int_equal(send(fd, frame, 8 + LENGTH, MSG_NOSIGNAL), 8 + LENGTH);
    lf_clock_settle(event);
}

/* The path of an export of so many bytes. */
static const char *export_file(behind *b, off_t bytes)
{
    int file = -1, fd = begin_client(b->web, "GET /rpc",
                                     "Upgrade: websocket\r\nConnection: Upgrade\r\n"
                                     "Sec-WebSocket-Version: 13\r\n"
                                     "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n");
    static char text[4096];
    lf_clock_settle(event);
    b->quiltd = accept(b->listener, NULL, NULL);
    limit_rights(b->quiltd);
    send_text(fd,
              "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"export\",\"params\":{\"kind\":\"still\","
              "\"file\":\"a.png\"}}");
    assert_non_null(strstr(hear(b->quiltd, &file), "\"export\""));
    assert_int_equal(ftruncate(file, bytes), 0);
    close(file);
    say(b->quiltd, "{\"jsonrpc\":\"2.0\",\"id\":\"quiltweb:export:1\",\"result\":{\"job\":1}}\n"
                   "{\"jsonrpc\":\"2.0\",\"method\":\"export\",\"params\":{\"job\":1,"
                   "\"state\":\"done\"}}\n");
    char *path = NULL;
    for (size_t used = 0; !path || !strchr(path, '"'); path = strstr(text, LF_DOWNLOADS_PREFIX)) {
        const ssize_t n = recv(fd, text + used, sizeof text - 1 - used, 0);
        assert_true(n > 0);
        for (ssize_t i = 0; i < n; i++) /* heads of frames */
            text[used + (size_t)i] = text[used + (size_t)i] ? text[used + (size_t)i] : ' ';
        used += (size_t)n;
        text[used] = '\0';
    }
    path[strcspn(path, "\"")] = '\0';
    close(fd);
    return path;
}

/* One that takes a part in each minute would hold a large file for days. */
static void a_download_needs_a_mean_rate(void **state)
{
    (void)state;
    enum { SIZE = 1 << 28, PERIODS = 60, PART = 1 << 20 };
    static char part[PART];
    char line[256];
    behind b = begin_behind();
    snprintf(line, sizeof line, "GET %s", export_file(&b, SIZE));
    for (int fast = 1; fast >= 0; fast--) {
        ssize_t n = 1;
        size_t taken = 0;
        int fd = begin_client(b.web, line, ""), periods = 0;
        for (; periods < PERIODS && n > 0; periods++) {
            for (int i = 0; i < (fast ? 16 : 1) && n > 0; i++) {
                lf_clock_settle(event);
                n = recv(fd, part, sizeof part, MSG_DONTWAIT);
                taken += n > 0 ? (size_t)n : 0;
            }
            lf_clock_pass(event, 60);
        }
        assert_true(fast ? taken > SIZE : taken < SIZE / 2);
        close(fd);
    }
    end_behind(&b);
}

/* Clients that only connect do not keep others out. */
static void the_oldest_silent_connection_makes_room(void **state)
{
    (void)state;
    lf_web *web = begin_web();
    int fds[LF_WEB_MAX_CONNECTIONS];
    char answer[64] = "";
    fds[0] = begin_client(web, "PUT /api/upload?name=a", "Content-Length: 10\r\n");
    for (int i = 1; i < LF_WEB_MAX_CONNECTIONS; i++)
        fds[i] = connect_client(web);
    for (int i = 0; i < LF_WEB_MAX_CONNECTIONS; i++)
        assert_true(is_open(fds[i]));
    int fd = begin_client(web, "GET /", "");
    lf_clock_settle(event);
    assert_true(recv(fd, answer, sizeof answer - 1, MSG_DONTWAIT) > 0);
    assert_memory_equal(answer, "HTTP/1.1 200", 12);
    for (int i = 0; i < LF_WEB_MAX_CONNECTIONS; i++) {
        assert_int_equal(is_open(fds[i]), i != 1);
        close(fds[i]);
    }
    close(fd);
    lf_web_destroy(web);
}

/* Nobody waits any more for one whose time is over. */
static void a_late_thumbnail_is_not_asked_for(void **state)
{
    (void)state;
    enum { AT_ONCE = 4, ALL = 2 * AT_ONCE + 1 };
    char *folder = lf_test_folder(), path[108], answer[16] = "";
    int listener = listen_as_quiltd(folder, path), fds[ALL], quiltd, n = 0;
    lf_web *web = begin_web_for(path);
    for (int i = 0; i < ALL; i++) {
        fds[i] = begin_client(web, "GET /api/thumbnail?file=/a", "");
        lf_clock_settle(event);
    }
    lf_clock_pass(event, 8); /* the first ones are given up, and the next ones asked for */
    for (int i = 0; i < AT_ONCE; i++) {
        assert_int_equal(recv(fds[i], answer, 12, 0), 12);
        assert_string_equal(answer, "HTTP/1.1 503");
    }
    lf_clock_pass(event, 8);
    for (int i = AT_ONCE; i < ALL; i++)
        assert_false(is_open(fds[i]));
    while ((quiltd = accept(listener, NULL, NULL)) >= 0) {
        close(quiltd);
        n++;
    }
    assert_int_equal(n, 2 * AT_ONCE);
    for (int i = 0; i < ALL; i++)
        close(fds[i]);
    lf_web_destroy(web);
    close(listener);
    lf_test_folder_remove(folder);
}

/* What has come but was not read at the end is not answered any more. */
static void nobody_is_let_in_at_the_end(void **state)
{
    (void)state;
    lf_web *web = begin_web();
    char byte;
    int fd = begin_client(web, "GET /", "");
    int socket = begin_client(web, "GET /rpc",
                              "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: "
                              "13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n");
    lf_clock_settle(event);
    assert_int_equal(recv(fd, &byte, 1, MSG_DONTWAIT), 1); /* before the end, it is */
    assert_int_equal(recv(socket, &byte, 1, MSG_DONTWAIT), 1);
    close(fd);
    close(socket);
    fd = begin_client(web, "GET /", "");
    lf_web_destroy(web);
    assert_true(recv(fd, &byte, 1, 0) <= 0);
    close(fd);
}

#define timed(test) cmocka_unit_test_setup_teardown(test, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        timed(a_connection_has_so_long_for_all),
        timed(a_paced_connection_has_so_long_for_each_part),
        timed(a_paced_connection_needs_a_mean_rate),
        timed(a_stopped_patience_is_endless),
        timed(a_reader_has_to_take_a_part_of_what_waits),
        timed(uploads_that_nobody_uses_are_dropped),
        timed(downloads_are_dropped_unless_they_are_read),
        timed(downloads_have_a_limit_together),
        timed(a_finished_export_does_not_make_room_for_others),
        timed(a_slow_reader_gets_no_image),
        timed(a_stream_repeats_its_image),
        timed(a_repeat_waits_for_an_image_on_its_way),
        timed(a_body_may_take_long_if_it_moves),
        timed(the_oldest_silent_connection_makes_room),
        timed(a_stream_ends_with_a_quiltd_that_hangs),
        timed(a_download_needs_a_mean_rate),
        timed(a_late_thumbnail_is_not_asked_for),
        timed(nobody_is_let_in_at_the_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
