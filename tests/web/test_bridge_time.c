/* Programs of Bridge that wait: for quiltd, and for events that they do not take. Time passes when
 * the test says so. */
#include "tests/web/told_quiltd.h"

#include <arpa/inet.h>
#include <jansson.h>
#include <netinet/in.h>

#include "base/log.h"
#include "daemon/web/bridge.h"
#include "daemon/web/calls.h"
#include "daemon/web/listen.h"
#include "daemon/web/web.h"

/* A gateway with the services of Bridge, and a quiltd that says what the test says. */
typedef struct behind {
    char *folder, path[108];
    int listener, quiltd;
    lf_web *web;
    char token[64];
} behind;

static int connect_service(const behind *b, lf_service service)
{
    const struct sockaddr_in address = {.sin_family = AF_INET,
                                        .sin_port = htons((uint16_t)lf_web_port(b->web, service)),
                                        .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0), small = 32768;
    setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
    assert_int_equal(connect(fd, (const struct sockaddr *)&address, sizeof address), 0);
    lf_clock_settle(event);
    return fd;
}

static int begin_put(const behind *b, const char *endpoint, const char *body)
{
    char request[1024];
    int fd = connect_service(b, LF_SERVICE_BRIDGE);
    const int n =
        snprintf(request, sizeof request,
                 "PUT /%s HTTP/1.1\r\nHost: localhost:%d\r\nContent-Length: %zu\r\n\r\n%s",
                 endpoint, lf_web_port(b->web, LF_SERVICE_BRIDGE), strlen(body), body);
    assert_int_equal(send(fd, request, (size_t)n, MSG_NOSIGNAL), n);
    lf_clock_settle(event);
    return fd;
}

static const char *receive(int fd)
{
    static char text[8192];
    const ssize_t n = recv(fd, text, sizeof text - 1, MSG_DONTWAIT);
    text[n > 0 ? n : 0] = '\0';
    close(fd);
    return text;
}

/* With small buffers of the kernel. */
static void open_behind(behind *b)
{
    lf_error err = {0};
    const int small = 4096;
    *b = (behind){.folder = lf_test_folder(), .quiltd = -1};
    b->listener = listen_as_quiltd(b->folder, b->path);
    lf_web_config config = {.socket = b->path, .upload_limit = 1 << 20};
    for (int i = 0; i <= LF_SERVICE_EVENTS; i++) {
        config.services[i].n = 1;
        lf_assert_ok(lf_web_listen("127.0.0.1:0", &config.services[i].fd[0], &err), &err);
        setsockopt(config.services[i].fd[0], SOL_SOCKET, SO_SNDBUF, &small, sizeof small);
    }
    lf_assert_ok(lf_web_create(event, &config, &b->web, &err), &err);
    const char *reply = receive(begin_put(b, "enter_orchestration", "{}"));
    const char *at = strstr(reply, "\"payload\"");
    assert_non_null(at);
    assert_int_equal(sscanf(strstr(at, "\"value\""), "\"value\":\"%60[0-9a-f-]", b->token), 1);
}

static void close_behind(const behind *b)
{
    lf_web_destroy(b->web);
    close(b->quiltd);
    close(b->listener);
    lf_test_folder_remove(b->folder);
}

static int begin_with_token(const behind *b, const char *endpoint, const char *members)
{
    char body[512];
    snprintf(body, sizeof body, "{\"orchestration\":\"%s\",%s}", b->token, members);
    return begin_put(b, endpoint, body);
}

/* Answers the call of this method that comes next. */
static void answer(behind *b, const char *method, const char *result)
{
    char text[1024];
    const char *call = hear(b->quiltd, NULL), *at = strstr(call, method);
    int number = 0;
    if (!at)
        fail_msg("%s is not called, but %s", method, call);
    while (at > call && strncmp(at, "\"id\":", 5) != 0)
        at--;
    assert_int_equal(sscanf(at, "\"id\":%d", &number), 1);
    snprintf(text, sizeof text, "{\"jsonrpc\":\"2.0\",\"id\":%d,\"result\":%s}\n", number, result);
    say(b->quiltd, text);
}

static void accept_quiltd(behind *b)
{
    lf_clock_settle(event);
    b->quiltd = accept(b->listener, NULL, NULL);
    assert_true(b->quiltd >= 0);
    limit_rights(b->quiltd);
}

/* Up to the point where quiltd plays and has shown nothing. */
static int play(behind *b)
{
    static const char entries[] =
        "{\"entries\":[{\"file\":\"/a.png\"}],\"index\":0,\"playing\":true}";
    close(begin_with_token(b, "instance_playlist", "\"name\":\"a\""));
    int fd = begin_with_token(b, "insert_playlist_entry", "\"name\":\"a\",\"uri\":\"/a.png\"");
    accept_quiltd(b);
    answer(b, "playlist.set", entries);
    assert_non_null(strstr(receive(fd), "Completion"));
    fd = begin_with_token(b, "play_playlist", "\"name\":\"a\"");
    answer(b, "status", "{\"device\":{\"present\":true}}");
    answer(b, "device.calibration", "{\"serial\":\"LKG-P\",\"screenW\":8,\"screenH\":8}");
    answer(b, "playlist.stop", entries);
    answer(b, "playlist.set", entries);
    answer(b, "playlist.play", entries);
    return fd;
}

static void an_image_that_takes_long_is_pending(void **state)
{
    (void)state;
    behind b;
    open_behind(&b);
    int fd = play(&b);
    lf_clock_pass(event, LF_BRIDGE_SHOW_S - 0.1);
    assert_true(is_open(fd));
    lf_clock_pass(event, 0.1);
    assert_non_null(strstr(receive(fd), "\"Pending\""));
    close_behind(&b);
}

static void an_image_is_waited_for(void **state)
{
    (void)state;
    behind b;
    open_behind(&b);
    int fd = play(&b);
    say(b.quiltd, "{\"jsonrpc\":\"2.0\",\"method\":\"scene\",\"params\":{\"file\":\"/b.png\"}}\n");
    lf_clock_pass(event, 1);
    assert_true(is_open(fd)); /* another one */
    say(b.quiltd, "{\"jsonrpc\":\"2.0\",\"method\":\"scene\",\"params\":{\"file\":\"/a.png\"}}\n");
    assert_non_null(strstr(receive(fd), "\"Completion\""));
    close_behind(&b);
}

static void another_playlist_takes_the_place(void **state)
{
    (void)state;
    behind b;
    open_behind(&b);
    int first = play(&b);
    int second = begin_with_token(&b, "play_playlist", "\"name\":\"a\"");
    static const char entries[] =
        "{\"entries\":[{\"file\":\"/a.png\"}],\"index\":0,\"playing\":true}";
    answer(&b, "status", "{\"device\":{\"present\":true}}");
    answer(&b, "device.calibration", "{\"serial\":\"LKG-P\",\"screenW\":8,\"screenH\":8}");
    assert_non_null(strstr(receive(first), "another playlist is played"));
    say(b.quiltd, "{\"jsonrpc\":\"2.0\",\"method\":\"playlist\",\"params\":{\"entries\":[{"
                  "\"file\":\"/a.png\"}],\"index\":0,\"playing\":false}}\n");
    answer(&b, "playlist.stop", entries);
    answer(&b, "playlist.set", entries);
    answer(&b, "playlist.play", entries);
    assert_true(is_open(second));
    close(second);
    close_behind(&b);
}

static const char stopped[] =
    "{\"jsonrpc\":\"2.0\",\"method\":\"playlist\",\"params\":{\"entries\":[{"
    "\"file\":\"/a.png\"}],\"index\":0,\"playing\":false}}\n";

/* By another client; no entry was skipped. */
static void a_stop_is_told_as_one(void **state)
{
    (void)state;
    behind b;
    open_behind(&b);
    int fd = play(&b);
    say(b.quiltd, stopped);
    answer(&b, "status", "{}");
    assert_non_null(strstr(receive(fd), "was stopped"));
    close_behind(&b);
}

static const char shown[] =
    "{\"jsonrpc\":\"2.0\",\"method\":\"scene\",\"params\":{\"file\":\"/a.png\"}}\n";

/* As a slider sends them: the one before does not know what became of it. */
static void a_change_takes_the_place_of_another(void **state)
{
    (void)state;
    behind b;
    static const char entries[] =
        "{\"entries\":[{\"file\":\"/a.png\"}],\"index\":0,\"playing\":true}";
    open_behind(&b);
    int fd = play(&b);
    say(b.quiltd, shown);
    assert_non_null(strstr(receive(fd), "\"Completion\""));
    int first = begin_with_token(&b, "update_current_entry", "\"name\":\"a\",\"zoom\":2");
    answer(&b, "playlist.change", entries);
    assert_true(is_open(first)); /* what is on the panel is the old one */
    int second = begin_with_token(&b, "update_current_entry", "\"name\":\"a\",\"zoom\":3");
    assert_true(is_open(first));
    answer(&b, "playlist.change", entries);
    assert_non_null(strstr(receive(first), "\"Pending\""));
    assert_true(is_open(second));
    say(b.quiltd, shown);
    assert_non_null(strstr(receive(second), "\"Completion\""));
    close_behind(&b);
}

/* quiltd loads an entry when it has answered; what it has loaded before may be told after that. */
static void an_image_of_an_earlier_turn_is_not_waited_for(void **state)
{
    (void)state;
    behind b;
    open_behind(&b);
    int fd = play(&b);
    say(b.quiltd, shown);
    assert_non_null(strstr(receive(fd), "\"Completion\""));
    fd = begin_with_token(&b, "update_current_entry", "\"name\":\"a\",\"zoom\":2");
    answer(&b, "playlist.change",
           "{\"entries\":[{\"file\":\"/a.png\"}],\"index\":0,\"turn\":7,\"playing\":true}");
    say(b.quiltd, "{\"jsonrpc\":\"2.0\",\"method\":\"scene\",\"params\":{\"file\":\"/a.png\","
                  "\"turn\":6}}\n");
    say(b.quiltd, shown); /* read again by itself: of no turn */
    assert_true(is_open(fd));
    say(b.quiltd, "{\"jsonrpc\":\"2.0\",\"method\":\"scene\",\"params\":{\"file\":\"/a.png\","
                  "\"turn\":7}}\n");
    assert_non_null(strstr(receive(fd), "\"Completion\""));
    close_behind(&b);
}

static void fail_once(const behind *b)
{
    assert_non_null(strstr(receive(begin_put(b, "cancel_pending", "{}")), "\"Failure\""));
}

static void check_last_line(const char *end)
{
    static lf_log_line line;
    assert_true(lf_log_line_at(lf_log_last(), &line));
    const size_t n = strlen(line.text), n_end = strlen(end);
    if (n < n_end || strcmp(line.text + n - n_end, end) != 0)
        fail_msg("%s, expected %s", line.text, end);
}

/* Not once for all, and not once for each. */
static void the_same_failure_is_logged_again(void **state)
{
    (void)state;
    behind b;
    open_behind(&b);
    fail_once(&b);
    const int64_t last = lf_log_last();
    check_last_line("the storage of a panel");
    for (int i = 0; i < 5; i++)
        fail_once(&b);
    assert_int_equal(lf_log_last(), last);
    lf_clock_pass(event, LF_BRIDGE_QUIET_S);
    check_last_line("the storage of a panel (5 more times)");
    fail_once(&b);
    assert_int_equal(lf_log_last(), last + 1);
    close(begin_put(&b, "get_camera_parameters", "{}")); /* another one ends the count */
    assert_int_equal(lf_log_last(), last + 3);
    lf_clock_pass(event, LF_BRIDGE_QUIET_S);
    close(begin_put(&b, "get_camera_parameters", "{}"));
    assert_int_equal(lf_log_last(), last + 4);
    close_behind(&b);
}

/* What needs no quiltd does not wait for one that hangs. */
static void versions_are_told_at_once(void **state)
{
    (void)state;
    behind b;
    open_behind(&b);
    int fd = begin_put(&b, "available_output_devices", "{}");
    accept_quiltd(&b);
    assert_non_null(strstr(receive(begin_put(&b, "bridge_version", "{}")), "2.6.3"));
    assert_non_null(strstr(receive(begin_put(&b, "cancel_pending", "{}")), "\"Failure\""));
    assert_true(is_open(fd));
    close(fd);
    close_behind(&b);
}

/* bridge.js takes each member of the payload for a panel. */
static void without_quiltd_no_panel_is_told(void **state)
{
    (void)state;
    behind b;
    open_behind(&b);
    close(b.listener);
    b.listener = -1;
    const char *reply = receive(begin_put(&b, "available_output_devices", "{}"));
    assert_non_null(strstr(reply, "\"Failure\""));
    assert_non_null(strstr(reply, "\"VARIANT_MAP\",\"value\":{}"));
    assert_non_null(strstr(reply, "\"message\""));
    close_behind(&b);
}

/* Whoever waits in the queue does not wait as long again. */
static void a_quiltd_that_hangs_is_given_up(void **state)
{
    (void)state;
    behind b;
    open_behind(&b);
    int fd = begin_put(&b, "available_output_devices", "{}");
    accept_quiltd(&b);
    int next = begin_put(&b, "available_output_devices", "{}");
    lf_clock_pass(event, LF_CALLS_PATIENCE_S - 0.1);
    assert_true(is_open(fd) && is_open(next));
    lf_clock_pass(event, 0.1);
    assert_non_null(strstr(receive(fd), "does not answer"));
    assert_false(is_open(b.quiltd));
    close(b.quiltd);
    assert_non_null(strstr(receive(next), "was not begun"));
    fd = begin_put(&b, "available_output_devices", "{}");
    accept_quiltd(&b); /* a new connection */
    answer(&b, "status", "{\"device\":{\"present\":false}}");
    answer(&b, "device.calibration", "{}");
    assert_non_null(strstr(receive(fd), "\"Completion\""));
    close_behind(&b);
}

static void on_tell(void *context, const char *token, json_t *told)
{
    (void)context;
    (void)token;
    (void)told;
}

static void on_done(void *context)
{
    ++*(int *)context;
}

/* What was begun goes on, and nobody is told of the reply. */
static void nobody_is_told_who_has_left(void **state)
{
    (void)state;
    behind b = {.folder = lf_test_folder()};
    lf_error err = {0};
    lf_bridge *bridge = NULL;
    lf_bridge_call *gone = NULL, *stays = NULL;
    int n_done = 0;
    b.listener = listen_as_quiltd(b.folder, b.path);
    const lf_bridge_config config = {
        .event = event, .socket = b.path, .version = "2.6.3", .tell = on_tell};
    lf_assert_ok(lf_bridge_create(&config, &bridge, &err), &err);
    lf_assert_ok(lf_bridge_begin(bridge, "available_output_devices", json_object(), on_done,
                                 &n_done, &gone, &err),
                 &err);
    lf_assert_ok(lf_bridge_begin(bridge, "available_output_devices", json_object(), on_done,
                                 &n_done, &stays, &err),
                 &err);
    accept_quiltd(&b);
    lf_bridge_leave(gone);
    for (int i = 0; i < 2; i++) {
        assert_null(lf_bridge_reply(stays));
        answer(&b, "status", "{\"device\":{\"present\":false}}");
        answer(&b, "device.calibration", "{}");
    }
    assert_non_null(lf_bridge_reply(stays));
    assert_int_equal(n_done, 1);
    lf_bridge_leave(stays);
    lf_bridge_destroy(bridge);
    close(b.quiltd);
    close(b.listener);
    lf_test_folder_remove(b.folder);
}

static void the_end_does_not_wait(void **state)
{
    (void)state;
    behind b;
    open_behind(&b);
    int running = begin_put(&b, "available_output_devices", "{}");
    accept_quiltd(&b);
    int queued = begin_put(&b, "available_output_devices", "{}");
    close_behind(&b);
    close(running);
    close(queued);
}

/* For one that takes nothing at most 64 KiB wait. */
static void events_for_a_program_that_sleeps_are_lost(void **state)
{
    (void)state;
    enum { EVENTS = 1200, A_TIME = 20, MASKED = 6, LEAST = 400 };
    static const char
        gone[] = "{\"jsonrpc\":\"2.0\",\"method\":\"device\",\"params\":{\"present\":false}}\n",
        there[] = "{\"jsonrpc\":\"2.0\",\"method\":\"device\",\"params\":{\"present\":true}}\n";
    char text[512];
    unsigned char frame[160] = {0x81};
    behind b;
    open_behind(&b);
    int fd = connect_service(&b, LF_SERVICE_EVENTS);
    int n = snprintf(text, sizeof text,
                     "GET /event_source HTTP/1.1\r\nHost: localhost:%d\r\nUpgrade: websocket\r\n"
                     "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                     "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n",
                     lf_web_port(b.web, LF_SERVICE_EVENTS));
    assert_int_equal(send(fd, text, (size_t)n, MSG_NOSIGNAL), n);
    lf_clock_settle(event);
    n = snprintf(text, sizeof text, "{\"subscribe_orchestration_events\":\"%s\"}", b.token);
    frame[1] = (unsigned char)(0x80 | n);
    memcpy(frame + MASKED, text, (size_t)n);
    assert_int_equal(send(fd, frame, (size_t)(MASKED + n), MSG_NOSIGNAL), MASKED + n);
    lf_clock_settle(event);
    accept_quiltd(&b);
    (void)hear(b.quiltd, NULL);
    for (int i = 0; i < EVENTS; i += A_TIME) {
        char lines[A_TIME * 100] = "";
        for (int k = 0; k < A_TIME; k++)
            strcat(lines, k % 2 ? gone : there);
        say(b.quiltd, lines);
    }
    assert_int_equal(lf_web_sessions(b.web), 1);
    size_t all = 0, more = 1;
    for (int idle = 0; idle<200; idle = more> 0 ? 0 : idle + 1) {
        more = drain(fd);
        all += more;
        lf_clock_settle(event);
    }
    assert_true(all > LEAST && all < (size_t)EVENTS / 2 * LEAST);
    say(b.quiltd, there); /* it is awake again */
    say(b.quiltd, gone);
    assert_true(drain(fd) > LEAST);
    close(fd);
    close_behind(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        timed(an_image_that_takes_long_is_pending),
        timed(an_image_is_waited_for),
        timed(another_playlist_takes_the_place),
        timed(a_stop_is_told_as_one),
        timed(a_change_takes_the_place_of_another),
        timed(an_image_of_an_earlier_turn_is_not_waited_for),
        timed(versions_are_told_at_once),
        timed(the_same_failure_is_logged_again),
        timed(without_quiltd_no_panel_is_told),
        timed(a_quiltd_that_hangs_is_given_up),
        timed(nobody_is_told_who_has_left),
        timed(the_end_does_not_wait),
        timed(events_for_a_program_that_sleeps_are_lost),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
