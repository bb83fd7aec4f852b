/* WebSockets: who may open one, what may be called, images, and clients that do not read. */
#include "tests/web/gateway.h"

#include <sys/socket.h>

#include "daemon/web/allow.h"
#include "daemon/web/image.h"
#include "daemon/web/web.h"

static int handshake(gateway *g, const char *headers)
{
    const char *answer = NULL;
    close(lf_talk_connect(g, headers, &answer));
    return lf_caller_status(answer);
}

static void a_page_needs_cookie_and_origin(void **state)
{
    gateway *g = *state;
    char headers[512];
    const char *cookie = lf_gateway_cookie(g);
    snprintf(headers, sizeof headers, "Cookie: %s\r\nOrigin: http://127.0.0.1:%d\r\n", cookie,
             lf_gateway_port(g));
    assert_int_equal(handshake(g, headers), 101);
    snprintf(headers, sizeof headers, "Origin: http://127.0.0.1:%d\r\n", lf_gateway_port(g));
    assert_int_equal(handshake(g, headers), 401);
    snprintf(headers, sizeof headers, "Cookie: %s\r\n", cookie);
    assert_int_equal(handshake(g, headers), 401);
    snprintf(headers, sizeof headers, "Cookie: %s\r\nOrigin: http://evil.test\r\n", cookie);
    assert_int_equal(handshake(g, headers), 403);
    snprintf(headers, sizeof headers, "Authorization: Bearer %s\r\n", lf_gateway_token(g));
    assert_int_equal(handshake(g, headers), 101);
    assert_int_equal(handshake(g, ""), 401);
}

static void a_handshake_is_one_of_version_13(void **state)
{
    gateway *g = *state;
    char request[512];
    static const struct {
        const char *headers;
        int status;
    } rows[] = {
        {"Upgrade: websocket\r\nSec-WebSocket-Version: 8\r\n", 426},
        {"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n", 426},
        {"Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: short\r\n", 400},
        {"Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n", 400},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        snprintf(request, sizeof request, "Authorization: Bearer %s\r\nConnection: Upgrade\r\n%s",
                 lf_gateway_token(g), rows[i].headers);
        assert_int_equal(lf_caller_status(lf_caller_get(g, "GET /rpc HTTP/1.1", request)),
                         rows[i].status);
    }
}

/* The example of RFC 6455. */
static void the_key_is_answered_as_the_standard_says(void **state)
{
    gateway *g = *state;
    char headers[80];
    const char *answer = NULL;
    snprintf(headers, sizeof headers, "Authorization: Bearer %s\r\n", lf_gateway_token(g));
    close(lf_talk_connect(g, headers, &answer));
    assert_non_null(strstr(answer, "Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n"));
}

static void allowed_methods_reach_quiltd(void **state)
{
    gateway *g = *state;
    int fd = lf_talk_open(g);
    char call[128];
    for (int i = 0; lf_allow_at(i); i++) {
        const bool needs_files = strcmp(lf_allow_at(i), "export") == 0;
        snprintf(call, sizeof call, "{\"jsonrpc\":\"2.0\",\"id\":%d,\"method\":\"%s\"%s}", i,
                 lf_allow_at(i),
                 needs_files ? ",\"params\":{\"kind\":\"still\",\"file\":\"a.png\"}" : "");
        lf_talk_say(fd, call);
        snprintf(call, sizeof call, "\"id\":%d,", i);
        assert_non_null(strstr(lf_talk_until(fd, call, NULL), "\"result\""));
        assert_true(lf_gateway_calls(g, lf_allow_at(i)) > 0);
    }
    close(fd);
}

static void all_other_methods_are_refused(void **state)
{
    gateway *g = *state;
    static const char *const methods[] = {"shutdown",  "device.set", "library.thumbnail",
                                          "frame.get", "button",     "quilt.show",
                                          "Shutdown",  "shutdown ",  "",
                                          "status2",   "preview.x",  "rpc.discover"};
    int fd = lf_talk_open(g);
    char call[160];
    for (size_t i = 0; i < sizeof methods / sizeof methods[0]; i++) {
        snprintf(call, sizeof call, "{\"jsonrpc\":\"2.0\",\"id\":%zu,\"method\":\"%s\"}", i,
                 methods[i]);
        lf_talk_say(fd, call);
        snprintf(call, sizeof call, "\"id\":%zu,", i);
        assert_non_null(strstr(lf_talk_until(fd, call, NULL), "-32601"));
        assert_int_equal(lf_gateway_calls(g, methods[i]), 0);
    }
    lf_talk_say(fd, "{\"jsonrpc\":\"2.0\",\"id\":89,\"method\":\"rights.limit\"}");
    assert_non_null(strstr(lf_talk_until(fd, "\"id\":89", NULL), "-32601"));
    assert_int_equal(lf_gateway_calls(g, "rights.limit"), 1); /* the gateway's own */
    /* of two keys of a name quiltd gets the one that was looked at */
    lf_talk_say(fd,
                "{\"jsonrpc\":\"2.0\",\"id\":90,\"method\":\"status\",\"method\":\"shutdown\"}");
    lf_talk_say(fd,
                "{\"jsonrpc\":\"2.0\",\"id\":91,\"method\":\"shutdown\",\"method\":\"status\"}");
    /* and of two lines in a message neither */
    lf_talk_say(fd, "{\"jsonrpc\":\"2.0\",\"id\":92,\"method\":\"status\"}\n"
                    "{\"jsonrpc\":\"2.0\",\"id\":93,\"method\":\"shutdown\"}");
    lf_talk_say(fd, "{\"jsonrpc\":\"2.0\",\"id\":94,\"method\":\"hello\"}");
    (void)lf_talk_until(fd, "\"id\":94", NULL);
    assert_int_equal(lf_gateway_calls(g, "shutdown"), 0);
    close(fd);
}

static void check_answer(int fd, const char *call, const char *word)
{
    lf_talk_say(fd, call);
    const char *answer = lf_talk_until(fd, "\"id\":", NULL);
    if (!strstr(answer, word))
        fail_msg("%s: %s, expected %s", call, answer, word);
}

static void some_parameters_are_refused(void **state)
{
    gateway *g = *state;
    static const char *const refused[] = {
        "\"scene.load\",\"params\":{\"file\":\"a\",\"files\":[\"/etc/passwd\"]}",
        "\"scene.load\",\"params\":{\"scene_fd\":true}",
        "\"scene.load\",\"params\":{\"scene\":{},\"arrays\":{}}",
        "\"scene.patch\",\"params\":{\"patch\":{},\"arrays\":{}}",
        "\"scene.patch\",\"params\":{\"patch\":{},\"files\":[\"/etc/passwd\"]}",
        "\"render.set\",\"params\":{\"threads\":1}",
        "\"export\",\"params\":{\"kind\":\"still\",\"file\":\"a.png\",\"fds\":1}",
        "\"export\",\"params\":{\"kind\":\"still\",\"file\":\"a.png\",\"detach\":true}",
        "\"export\",\"params\":{\"kind\":\"still\",\"file\":\"a.png\",\"overwrite\":true}",
        "\"export\",\"params\":{\"kind\":\"still\",\"file\":\"a.png\",\"farm\":\"list\"}",
        "\"export\",\"params\":{\"kind\":\"still\",\"file\":\"a.png\",\"job\":\"j\"}",
        "\"preview.start\",\"params\":{\"x\":1}"};
    static const char *const methods[] = {"scene.load", "scene.patch", "render.set", "export"};
    int fd = lf_talk_open(g);
    char call[256];
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++) {
        snprintf(call, sizeof call, "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":%s}", refused[i]);
        check_answer(fd, call, "-32602");
    }
    for (size_t i = 0; i < sizeof methods / sizeof methods[0]; i++)
        assert_int_equal(lf_gateway_calls(g, methods[i]), 0);
    check_answer(
        fd, "{\"jsonrpc\":\"2.0\",\"id\":2,\"method\":\"scene.load\",\"params\":{\"file\":\"a\"}}",
        "\"result\"");
    /* ids of the gateway's own calls */
    check_answer(fd, "{\"jsonrpc\":\"2.0\",\"id\":\"quiltweb:image\",\"method\":\"hello\"}",
                 "-32600");
    check_answer(fd, "{\"jsonrpc\":\"2.0\",\"id\":\"quiltweb:export:1\",\"method\":\"hello\"}",
                 "-32600");
    check_answer(fd, "no JSON", "-32700");
    check_answer(fd, "", "-32700");
    close(fd);
}

/* Whatever quiltd says to it, the gateway calls rights.limit before all else, on each connection.
 */
static void rights_are_limited_first(void **state)
{
    gateway *g = *state;
    static const struct {
        lf_gateway_rights rights;
        int calls;
    } rows[] = {{LF_RIGHTS_KNOWN, 1}, {LF_RIGHTS_UNKNOWN, 1}, {LF_RIGHTS_LACKING, 2}};
    int before = 0;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        lf_gateway_set_rights(g, rows[i].rights);
        int fd = lf_talk_open(g);
        check_answer(fd, "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"hello\"}", "\"result\"");
        check_answer(fd, "{\"jsonrpc\":\"2.0\",\"id\":2,\"method\":\"hello\"}", "\"result\"");
        assert_int_equal(lf_gateway_calls(g, "rights.limit") - before, rows[i].calls);
        before += rows[i].calls;
        close(fd);
    }
    lf_gateway_set_rights(g, LF_RIGHTS_KNOWN);
    char token[80];
    snprintf(token, sizeof token, "Authorization: Bearer %s\r\n", lf_gateway_token(g));
    static const char *const lines[] = {"GET /api/status HTTP/1.1", "GET /preview.jpg HTTP/1.1",
                                        "GET /api/thumbnail?file=/a.png HTTP/1.1"};
    for (int i = 0; i < 3; i++)
        assert_int_equal(lf_caller_status(lf_caller_get(g, lines[i], token)), 200);
    assert_int_equal(lf_gateway_calls(g, "rights.limit") - before, 3);
    assert_int_equal(lf_gateway_unlimited(g), 0);
}

/* The code of the close that comes next. */
static int close_code(int fd)
{
    const unsigned char *data = NULL;
    size_t n = 0;
    for (int opcode; (opcode = lf_talk_next(fd, &data, &n)) > 0;)
        if (opcode == 8)
            return n >= 2 ? data[0] << 8 | data[1] : 0;
    return -1;
}

static void a_quiltd_that_does_not_limit_rights_is_not_used(void **state)
{
    gateway *g = *state;
    char token[80];
    snprintf(token, sizeof token, "Authorization: Bearer %s\r\n", lf_gateway_token(g));
    lf_gateway_set_rights(g, LF_RIGHTS_AGAINST);
    int fd = lf_talk_open(g);
    assert_int_equal(close_code(fd), 1011);
    close(fd);
    assert_int_equal(lf_caller_status(lf_caller_get(g, "GET /api/status HTTP/1.1", token)), 503);
    assert_int_equal(lf_caller_status(lf_caller_get(g, "GET /preview.mjpg HTTP/1.1", token)), 503);
    assert_int_equal(lf_caller_status(lf_caller_put(g, "/api/quilt?cols=1&rows=1", "x", 1)), 503);
    assert_int_equal(lf_gateway_calls(g, "rights.limit"), 4);
    assert_int_equal(lf_gateway_unlimited(g), 0); /* nothing else has come */
}

static void a_subscription_keeps_frames(void **state)
{
    gateway *g = *state;
    int fd = lf_talk_open(g);
    lf_talk_say(fd, "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"subscribe\",\"params\":{\"events\":"
                    "[\"scene\"]}}");
    assert_non_null(strstr(lf_talk_until(fd, "\"id\":1", NULL), "[\"scene\",\"frame\"]"));
    close(fd);
}

static void long_messages_are_closed_with_1009(void **state)
{
    gateway *g = *state;
    enum { LONGEST = 1 << 20 };
    char *text = malloc(LONGEST + 1);
    assert_non_null(text);
    memset(text, ' ', LONGEST + 1);
    static const char call[] = "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"hello\"}";
    memcpy(text, call, strlen(call));
    int fd = lf_talk_open(g);
    lf_talk_send(fd, 1, text, LONGEST);
    assert_non_null(strstr(lf_talk_until(fd, "\"id\":1", NULL), "\"result\""));
    lf_talk_send(fd, 1, text, LONGEST + 1);
    assert_int_equal(close_code(fd), 1009);
    close(fd);
    free(text);
}

/* Each frame costs memory besides its bytes. Pings between them are no part of the message. */
static void a_message_has_a_thousand_frames_at_most(void **state)
{
    gateway *g = *state;
    enum { MOST = 1024, HEAD = 6, PING = 7 };
    static const char call[] = "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"hello\"}";
    static char frames[MOST * (HEAD + 1) + PING];
    for (int frame = 0, used = 0; frame < MOST; frame++) { /* all masks are zero */
        frames[used] = (char)((frame == 0) | (frame == MOST - 1 ? 0x80 : 0));
        frames[used + 1] = (char)0x81;
        frames[used + HEAD] = (size_t)frame < strlen(call) ? call[frame] : ' ';
        used += HEAD + 1;
        if (frame == 1) {
            memcpy(frames + used, "\x89\x81\0\0\0\0p", PING);
            used += PING;
        }
    }
    int fd = lf_talk_open(g);
    for (int i = 0; i < 2; i++) {
        assert_true(lf_caller_send(fd, frames, sizeof frames));
        assert_non_null(strstr(lf_talk_until(fd, "\"id\":1", NULL), "\"result\""));
    }
    assert_true(lf_caller_send(fd, frames, sizeof frames - HEAD - 1));
    assert_true(lf_caller_send(fd, "\0\x81\0\0\0\0 ", HEAD + 1));
    assert_true(lf_caller_send(fd, "\0\x81\0\0\0\0 ", HEAD + 1));
    assert_int_equal(close_code(fd), 1008);
    close(fd);
}

/* quiltd does not read; at 4 MiB of requests the client is told. */
static void requests_that_wait_are_bounded(void **state)
{
    gateway *g = *state;
    enum { SIZE = 1 << 20 };
    char *text = malloc(SIZE), *at = text;
    assert_non_null(text);
    static const char call[] = "{\"jsonrpc\":\"2.0\",\"method\":\"log.tail\",\"params\":{\"x\":\"";
    memset(text, 'x', SIZE);
    memcpy(at, call, strlen(call));
    memcpy(text + SIZE - 3, "\"}}", 3);
    lf_gateway_set_rights(g, LF_RIGHTS_SILENT);
    int fd = lf_talk_open(g);
    for (int i = 0; i < 4; i++) /* a little less than 4 MiB */
        lf_talk_send(fd, 1, text, i < 3 ? SIZE : SIZE / 2);
    lf_talk_say(fd, "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"shutdown\"}");
    assert_non_null(strstr(lf_talk_until(fd, "\"id\":1", NULL), "-32601"));
    lf_talk_send(fd, 1, text, SIZE);
    assert_int_equal(close_code(fd), 1008);
    close(fd);
    free(text);
}

/* A short message may be a long line: 1e9 becomes 1000000000.0. */
static void long_lines_are_refused_with_their_id(void **state)
{
    gateway *g = *state;
    enum { NUMBERS = 100000 };
    static const char begin[] = "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"scene.patch\","
                                "\"params\":{\"patch\":[0";
    char *text = calloc(NUMBERS + 1, 4);
    assert_non_null(text);
    size_t n = strlen(begin);
    memcpy(text, begin, n);
    for (; n < (size_t)NUMBERS * 4 - 4; n += 4)
        memcpy(text + n, ",1e9", 4);
    memcpy(text + n, "]}}", 3);
    int fd = lf_talk_open(g);
    lf_talk_say(fd, text);
    assert_non_null(strstr(lf_talk_until(fd, "\"id\":1", NULL), "-32600"));
    assert_int_equal(lf_gateway_calls(g, "scene.patch"), 0);
    close(fd);
    free(text);
}

static void other_breaches_are_closed(void **state)
{
    gateway *g = *state;
    int fd = lf_talk_open(g);
    lf_talk_send(fd, 2, "x", 1);
    assert_int_equal(close_code(fd), 1003);
    close(fd);
    fd = lf_talk_open(g);
    lf_talk_send(fd, 1, "\xff\xfe", 2); /* not UTF-8 */
    assert_int_equal(close_code(fd), 1007);
    close(fd);
    fd = lf_talk_open(g);
    assert_true(lf_caller_send(fd, "\x81\x01x", 3)); /* without a mask */
    assert_int_equal(close_code(fd), 1002);
    close(fd);
    fd = lf_talk_open(g);
    lf_talk_send(fd, 8, "\x03\xe8", 2); /* an orderly end */
    assert_int_equal(close_code(fd), 1000);
    close(fd);
}

static void a_quiltd_that_ends_closes_its_clients(void **state)
{
    gateway *g = *state;
    int fd = lf_talk_open(g);
    lf_talk_say(fd, "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"hello\"}");
    (void)lf_talk_until(fd, "\"id\":1", NULL);
    lf_gateway_hang_up(g);
    assert_int_equal(close_code(fd), 1001);
    close(fd);
}

static void the_seventeenth_client_is_refused(void **state)
{
    gateway *g = *state;
    char headers[80];
    int fds[LF_WEB_MAX_SESSIONS];
    snprintf(headers, sizeof headers, "Authorization: Bearer %s\r\n", lf_gateway_token(g));
    for (int i = 0; i < LF_WEB_MAX_SESSIONS; i++)
        fds[i] = lf_talk_open(g);
    assert_int_equal(handshake(g, headers), 503);
    lf_talk_send(fds[3], 8, "\x03\xe8", 2);
    assert_int_equal(close_code(fds[3]), 1000);
    close(fds[3]);
    int status = 503; /* its seat is free once the gateway has seen the end */
    for (int i = 0; i < 1000 && status == 503; i++)
        status = handshake(g, headers);
    assert_int_equal(status, 101);
    for (int i = 0; i < LF_WEB_MAX_SESSIONS; i++)
        if (i != 3)
            close(fds[i]);
}

/* ------------------------------------------------------------------------------------ images -- */

static const unsigned char *next_image(int fd, size_t *out_n)
{
    const unsigned char *data = NULL;
    for (int opcode; (opcode = lf_talk_next(fd, &data, out_n)) > 0;)
        if (opcode == 2)
            return data;
    fail_msg("the connection ended before an image");
    return NULL;
}

static void an_image_has_its_header(void **state)
{
    gateway *g = *state;
    static const unsigned char header[LF_WEB_IMAGE_HEADER] = {
        7, 0, 0, 0, 2, 1, FALSE_COLUMNS, 0, 3, 0, FALSE_VIEWS, 0, FALSE_WIDTH, 0, FALSE_HEIGHT, 0};
    int fd = lf_talk_open(g);
    size_t n = 0;
    lf_talk_say(fd, "{\"jsonrpc\":\"2.0\",\"method\":\"preview.start\"}");
    const unsigned char *image = next_image(fd, &n);
    assert_memory_equal(image, header, sizeof header);
    assert_int_equal(image[LF_WEB_IMAGE_HEADER], 0xff);
    assert_int_equal(image[LF_WEB_IMAGE_HEADER + 1], 0xd8);
    close(fd);
}

static void one_image_is_in_flight(void **state)
{
    gateway *g = *state;
    static const char frame[] = "{\"jsonrpc\":\"2.0\",\"method\":\"frame\",\"params\":{"
                                "\"generation\":8,\"level\":\"complete\"}}";
    int fd = lf_talk_open(g), binaries = 0;
    size_t n = 0;
    lf_talk_say(fd, "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"preview.start\"}");
    (void)next_image(fd, &n);
    lf_gateway_notify(g, frame);
    (void)lf_talk_until(fd, "\"frame\"", &binaries);
    usleep(400000); /* longer than the gateway waits between two images */
    lf_talk_say(fd, "{\"jsonrpc\":\"2.0\",\"id\":2,\"method\":\"hello\"}");
    (void)lf_talk_until(fd, "\"id\":2", &binaries);
    assert_int_equal(binaries, 0);
    assert_int_equal(lf_gateway_calls(g, "frame.get"), 1);
    lf_talk_say(fd, "{\"jsonrpc\":\"2.0\",\"method\":\"preview.ack\"}");
    (void)next_image(fd, &n);
    assert_int_equal(lf_gateway_calls(g, "frame.get"), 2);
    close(fd);
}

/* An image that was asked for before the stop does not come after it, and needs no ack. */
static void no_image_follows_a_stop(void **state)
{
    gateway *g = *state;
    static const char start[] = "{\"jsonrpc\":\"2.0\",\"method\":\"preview.start\"}";
    static const char stop[] = "{\"jsonrpc\":\"2.0\",\"method\":\"preview.stop\"}";
    char both[160] = {0}; /* two messages that are read in one turn */
    size_t used = 0, n = 0;
    int fd = lf_talk_open(g), binaries = 0;
    for (int i = 0; i < 2; i++) {
        const char *text = i == 0 ? start : stop;
        both[used] = '\x81';
        both[used + 1] = (char)(0x80 | strlen(text));
        memcpy(both + used + 6, text, strlen(text)); /* the mask is zero */
        used += 6 + strlen(text);
    }
    assert_true(lf_caller_send(fd, both, used));
    lf_talk_say(fd, "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"hello\"}");
    (void)lf_talk_until(fd, "\"id\":1", &binaries);
    assert_int_equal(lf_gateway_calls(g, "frame.get"), 1);
    assert_int_equal(binaries, 0);
    lf_talk_say(fd, start);
    (void)next_image(fd, &n);
    close(fd);
}

static void a_coarse_image_comes_at_half_size(void **state)
{
    gateway *g = *state;
    static const char frame[] = "{\"jsonrpc\":\"2.0\",\"method\":\"frame\",\"params\":{"
                                "\"generation\":8,\"level\":\"coarse\"}}";
    int fd = lf_talk_open(g);
    size_t n = 0;
    lf_talk_say(fd, "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"preview.start\"}");
    assert_int_equal(next_image(fd, &n)[12], FALSE_WIDTH);
    lf_gateway_notify(g, frame);
    (void)lf_talk_until(fd, "\"frame\"", NULL);
    lf_talk_say(fd, "{\"jsonrpc\":\"2.0\",\"method\":\"preview.ack\"}");
    assert_int_equal(next_image(fd, &n)[12], FALSE_WIDTH / 2 / 16 * 16);
    /* the false quiltd says that it is complete: the whole one follows */
    lf_talk_say(fd, "{\"jsonrpc\":\"2.0\",\"method\":\"preview.ack\"}");
    assert_int_equal(next_image(fd, &n)[12], FALSE_WIDTH);
    close(fd);
}

static void another_layout_is_asked_for_as_rendered(void **state)
{
    gateway *g = *state;
    static const char frame[] = "{\"jsonrpc\":\"2.0\",\"method\":\"frame\",\"params\":{"
                                "\"generation\":8,\"level\":\"coarse\"}}";
    int fd = lf_talk_open(g);
    size_t n = 0;
    lf_talk_say(fd, "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"preview.start\"}");
    assert_int_equal(next_image(fd, &n)[12], FALSE_WIDTH);
    lf_gateway_set_columns(g, FALSE_COLUMNS + 1);
    lf_gateway_notify(g, frame);
    (void)lf_talk_until(fd, "\"frame\"", NULL);
    lf_talk_say(fd, "{\"jsonrpc\":\"2.0\",\"method\":\"preview.ack\"}");
    const unsigned char *image = next_image(fd, &n);
    assert_int_equal(image[6], FALSE_COLUMNS + 1);
    assert_int_equal(image[12], FALSE_WIDTH);
    assert_int_equal(lf_gateway_calls(g, "frame.get"), 3);
    close(fd);
}

/* ------------------------------------------------------------------------------ slow readers -- */

static void a_slow_reader_holds_up_nobody_and_loses_nothing(void **state)
{
    gateway *g = *state;
    enum { LINE = 1000, MOST = 65536 };
    char line[LINE + 2];
    snprintf(line, sizeof line, "{\"jsonrpc\":\"2.0\",\"method\":\"scene\",\"params\":\"");
    memset(line + strlen(line), 'x', LINE - strlen(line));
    memcpy(line + LINE - 2, "\"}\n", 4);
    int slow = lf_talk_open(g);
    lf_talk_say(slow, "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"hello\"}");
    (void)lf_talk_until(slow, "\"id\":1", NULL);
    const int sent = lf_gateway_flood(g, line, MOST);
    assert_in_range(sent, 100, MOST - 1); /* quiltd is not read any more */
    int other = lf_talk_open(g);
    lf_talk_say(other, "{\"jsonrpc\":\"2.0\",\"id\":2,\"method\":\"hello\"}");
    assert_non_null(strstr(lf_talk_until(other, "\"id\":2", NULL), "\"result\""));
    for (int i = 0; i < sent; i++) {
        (void)lf_talk_until(slow, "\"scene\"", NULL);
        if (i == sent / 2)
            lf_gateway_flood_end(g);
    }
    lf_talk_say(slow, "{\"jsonrpc\":\"2.0\",\"id\":3,\"method\":\"hello\"}");
    (void)lf_talk_until(slow, "\"id\":3", NULL);
    close(slow);
    close(other);
}

/* All that is asked is answered, and no more is read than the answers find room for. */
static void a_client_that_only_asks_is_not_read(void **state)
{
    gateway *g = *state;
    enum { FRAME = 8, MOST = 1 << 20 };
    static const char call[FRAME + 1] = "\x81\x82\0\0\0\0{}";
    const int small = 16384;
    const unsigned char *data = NULL;
    size_t n = 0;
    char *calls = malloc((size_t)MOST * FRAME);
    assert_non_null(calls);
    for (int i = 0; i < MOST; i++)
        memcpy(calls + (size_t)i * FRAME, call, FRAME);
    int greedy = lf_talk_open(g);
    setsockopt(greedy, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
    setsockopt(greedy, SOL_SOCKET, SO_SNDBUF, &small, sizeof small);
    const size_t sent = lf_caller_flood(greedy, calls, (size_t)MOST * FRAME);
    assert_in_range(sent, 1000 * FRAME, (size_t)MOST * FRAME - 1);
    int other = lf_talk_open(g);
    lf_talk_say(other, "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"hello\"}");
    assert_non_null(strstr(lf_talk_until(other, "\"id\":1", NULL), "\"result\""));
    for (size_t i = 0; i < sent / FRAME; i++)
        assert_int_equal(lf_talk_next(greedy, &data, &n), 1);
    assert_true(lf_caller_send(greedy, call + sent % FRAME, FRAME - sent % FRAME));
    lf_talk_say(greedy, "{\"jsonrpc\":\"2.0\",\"id\":2,\"method\":\"hello\"}");
    assert_non_null(strstr(lf_talk_until(greedy, "\"id\":2", NULL), "\"result\""));
    close(greedy);
    close(other);
    free(calls);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        lf_gateway_test(a_page_needs_cookie_and_origin),
        lf_gateway_test(a_handshake_is_one_of_version_13),
        lf_gateway_test(the_key_is_answered_as_the_standard_says),
        lf_gateway_test(allowed_methods_reach_quiltd),
        lf_gateway_test(all_other_methods_are_refused),
        lf_gateway_test(some_parameters_are_refused),
        lf_gateway_test(rights_are_limited_first),
        lf_gateway_test(a_quiltd_that_does_not_limit_rights_is_not_used),
        lf_gateway_test(a_subscription_keeps_frames),
        lf_gateway_test(long_messages_are_closed_with_1009),
        lf_gateway_test(a_message_has_a_thousand_frames_at_most),
        lf_gateway_test(requests_that_wait_are_bounded),
        lf_gateway_test(long_lines_are_refused_with_their_id),
        lf_gateway_test(other_breaches_are_closed),
        lf_gateway_test(a_quiltd_that_ends_closes_its_clients),
        lf_gateway_test(the_seventeenth_client_is_refused),
        lf_gateway_test(an_image_has_its_header),
        lf_gateway_test(one_image_is_in_flight),
        lf_gateway_test(no_image_follows_a_stop),
        lf_gateway_test(a_coarse_image_comes_at_half_size),
        lf_gateway_test(another_layout_is_asked_for_as_rendered),
        lf_gateway_test(a_slow_reader_holds_up_nobody_and_loses_nothing),
        lf_gateway_test(a_client_that_only_asks_is_not_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
