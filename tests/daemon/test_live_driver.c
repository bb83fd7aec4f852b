/* Programs of the older protocol, from their bytes to the panel: AliceLG by nng's ipc, WebXR pages
 * by a WebSocket, and a panel that is lent. */
#include "tests/daemon/live.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/mman.h>

#include "tests/web/bitmap.h"
#include "tests/web/sp.h"

enum { ID = (int)0xcaba09e5u };
/* As the live scene: 3 x 2 views of 24 x 32 pixels. */
enum { COLUMNS = 3, ROWS = 2, WIDTH = 72, HEIGHT = 64, BYTES = 3 * WIDTH * HEIGHT };

/* quiltd, and quiltweb with all of its services. */
typedef struct programs {
    live l;
    pid_t web;
    int port; /* of WebXR pages */
    char nng[108], page[PATH_MAX / 4];
    live_client c;
} programs;

/* The number behind the last such text in the log; *out_lines: how many lines have it. */
static int number_logged(const live *l, const char *text, int *out_lines)
{
    FILE *file = fopen(l->log, "r");
    char line[1024];
    int number = 0;
    *out_lines = 0;
    while (file && fgets(line, sizeof line, file)) {
        const char *at = strstr(line, text);
        number = at ? atoi(at + strlen(text)) : number;
        *out_lines += at ? 1 : 0;
    }
    if (file)
        fclose(file);
    return number;
}

static void start_web(programs *p, const char *more)
{
    char program[PATH_MAX], nng[128];
    int before = 0, now;
    (void)number_logged(&p->l, "WebXR: port ", &before);
    now = before;
    snprintf(program, sizeof program, "%s", lf_test_built("quiltweb"));
    snprintf(p->nng, sizeof p->nng, "%s/nng", p->l.folder);
    snprintf(p->page, sizeof p->page, "%s/url", p->l.folder);
    snprintf(nng, sizeof nng, "--nng=%s", p->nng);
    char *args[] = {program,
                    (char *)(uintptr_t) "--socket",
                    p->l.socket,
                    (char *)(uintptr_t) "--listen",
                    (char *)(uintptr_t) "127.0.0.1:0",
                    (char *)(uintptr_t) "--url-file",
                    p->page,
                    (char *)(uintptr_t) "--webxr=0",
                    (char *)(uintptr_t) "--allow-origin",
                    (char *)(uintptr_t) "http://localhost:*",
                    nng,
                    (char *)(uintptr_t)more,
                    NULL};
    p->web = live_spawn(&p->l, args);
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && now == before; i++, live_nap(20))
        p->port = number_logged(&p->l, "WebXR: port ", &now);
    assert_true(p->port > 0);
}

static void stop_web(programs *p)
{
    kill(p->web, SIGTERM);
    assert_int_equal(live_reap(p->web), 0);
}

static void begin(programs *p, const char *more)
{
    live_prepare(&p->l);
    live_start(&p->l, p->l.scene, "--device", p->l.sim, "--state", p->l.state, NULL);
    live_connect(&p->l, &p->c);
    start_web(p, more);
}

static void end(programs *p)
{
    stop_web(p);
    live_close(&p->c);
    live_finish(&p->l);
}

/* ----------------------------------------------------------------------------------- clients -- */

static void put(int fd, const void *data, size_t n)
{
    for (size_t at = 0; at < n;) {
        const ssize_t sent = send(fd, (const char *)data + at, n - at, MSG_NOSIGNAL);
        assert_true(sent > 0);
        at += (size_t)sent;
    }
}

static void get(int fd, uint8_t *out, size_t n)
{
    for (size_t at = 0; at < n;) {
        const ssize_t got = recv(fd, out + at, n - at, 0);
        if (got <= 0)
            fail_msg("the connection has ended");
        at += (size_t)got;
    }
}

static uint64_t number_of(const uint8_t *bytes, int n)
{
    uint64_t number = 0;
    for (int i = 0; i < n; i++)
        number = number << 8 | bytes[i];
    return number;
}

static void wait_long(int fd)
{
    const struct timeval patience = {.tv_sec = LIVE_PATIENCE_S};
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
}

static int nng_connect(const programs *p)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    uint8_t greeting[8];
    memcpy(address.sun_path, p->nng, sizeof p->nng);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(connect(fd, (const struct sockaddr *)&address, sizeof address), 0);
    wait_long(fd);
    put(fd, "\0SP\0\0\x30\0\0", 8);
    get(fd, greeting, sizeof greeting);
    assert_memory_equal(greeting, "\0SP\0\0\x31\0\0", 8);
    return fd;
}

static void nng_send(int fd, const uint8_t *message, size_t n)
{
    uint8_t head[9] = {1};
    for (int i = 0; i < 8; i++)
        head[1 + i] = (uint8_t)((uint64_t)n >> (56 - 8 * i));
    put(fd, head, sizeof head);
    put(fd, message, n);
}

static json_t *nng_answer(int fd, uint32_t id)
{
    uint8_t head[9], body[8192];
    get(fd, head, sizeof head);
    const size_t n = (size_t)number_of(head + 1, 8);
    assert_true(head[0] == 1 && n <= sizeof body);
    get(fd, body, n);
    return sp_answer(id, body, n);
}

static json_t *nng_ask(int fd, const char *cmd, const uint8_t *bin, size_t n_bin)
{
    size_t n = 0;
    uint8_t *message = sp_request((uint32_t)ID, cmd, bin, n_bin, &n);
    nng_send(fd, message, n);
    free(message);
    return nng_answer(fd, (uint32_t)ID);
}

static void nng_check(int fd, const char *cmd, const uint8_t *bin, size_t n_bin, int error)
{
    json_t *answer = nng_ask(fd, cmd, bin, n_bin);
    if (sp_error(answer) != error) {
        char *text = json_dumps(answer, 0);
        fail_msg("%s: %s", cmd, text);
    }
    json_decref(answer);
}

/* A WebSocket's handshake; the status. */
static int ws_connect(const programs *p, const char *path, const char *headers, int *out_fd)
{
    struct sockaddr_in address = {.sin_family = AF_INET,
                                  .sin_port = htons((uint16_t)p->port),
                                  .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    char request[1024], answer[2048] = "";
    size_t used = 0;
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0), status = 0;
    if (connect(fd, (const struct sockaddr *)&address, sizeof address) != 0) {
        live_show_log(&p->l);
        fail_msg("nobody listens at port %d", p->port);
    }
    wait_long(fd);
    const int n = snprintf(request, sizeof request,
                           "GET %s HTTP/1.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                           "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: "
                           "dGhlIHNhbXBsZSBub25jZQ==\r\n%s\r\n",
                           path, headers);
    put(fd, request, (size_t)n);
    while (used + 1 < sizeof answer && recv(fd, answer + used, 1, 0) == 1)
        if (strstr(answer, "\r\n\r\n") || (answer[++used] = '\0', strstr(answer, "\r\n\r\n")))
            break;
    assert_int_equal(sscanf(answer, "HTTP/1.1 %d", &status), 1);
    if (status == 101)
        assert_null(strstr(answer, "permessage-deflate"));
    if (status == 101 && strcmp(path, "/driver") == 0)
        assert_non_null(strstr(answer, "Sec-WebSocket-Protocol: rep.sp.nanomsg.org\r\n"));
    *out_fd = fd;
    return status;
}

#define BROWSER                                                                                    \
    "Sec-WebSocket-Protocol: rep.sp.nanomsg.org\r\n"                                               \
    "Sec-WebSocket-Extensions: permessage-deflate; client_max_window_bits\r\n"

static int ws_open(const programs *p, const char *path)
{
    char headers[512];
    int fd = -1;
    snprintf(headers, sizeof headers,
             "Host: localhost:%d\r\nOrigin: http://localhost:8090\r\n" BROWSER, p->port);
    assert_int_equal(ws_connect(p, path, headers, &fd), 101);
    return fd;
}

/* A frame with a mask. */
static void ws_send(int fd, int first, const uint8_t *data, size_t n)
{
    static const uint8_t mask[4] = {0x12, 0x34, 0x56, 0x78};
    uint8_t head[14] = {(uint8_t)first, 0x80 | 127};
    for (int i = 0; i < 8; i++)
        head[2 + i] = (uint8_t)((uint64_t)n >> (56 - 8 * i));
    size_t n_head = 10;
    if (n < 65536) {
        n_head = 4;
        head[1] = 0x80 | 126;
        head[2] = (uint8_t)(n >> 8);
        head[3] = (uint8_t)n;
    }
    if (n < 126) {
        n_head = 2;
        head[1] = (uint8_t)(0x80 | n);
    }
    memcpy(head + n_head, mask, 4);
    uint8_t *masked = malloc(n + 1);
    assert_non_null(masked);
    for (size_t i = 0; i < n; i++)
        masked[i] = data[i] ^ mask[i % 4];
    put(fd, head, n_head + 4);
    put(fd, masked, n);
    free(masked);
}

/* The next message, of this opcode: *out_n bytes in out[size]. */
static void ws_receive(int fd, int opcode, uint8_t *out, size_t size, size_t *out_n)
{
    uint8_t head[10];
    get(fd, head, 2);
    const int more = head[1] == 126 ? 2 : head[1] == 127 ? 8 : 0;
    get(fd, head + 2, (size_t)more);
    const size_t n = more ? (size_t)number_of(head + 2, more) : head[1];
    assert_int_equal(head[0] & 15, opcode);
    assert_true(n < size);
    get(fd, out, n);
    out[n] = 0;
    *out_n = n;
}

static json_t *ws_answer(int fd, uint32_t id)
{
    uint8_t data[8192];
    size_t n = 0;
    ws_receive(fd, 2, data, sizeof data, &n);
    return sp_answer(id, data, n);
}

/* ------------------------------------------------------------------------------------ panels -- */

/* Each field is there, as a number in {"value": …}. */
static void check_calibration(const json_t *calibration)
{
    static const char *const fields[] = {
        "pitch",   "slope",         "center",     "viewCone",   "DPI",      "screenW", "screenH",
        "invView", "verticalAngle", "flipImageX", "flipImageY", "flipSubp", "fringe"};
    assert_true(json_is_string(json_object_get(calibration, "serial")));
    for (size_t i = 0; i < sizeof fields / sizeof fields[0]; i++)
        assert_true(
            json_is_number(json_object_get(json_object_get(calibration, fields[i]), "value")));
    assert_int_equal(
        json_integer_value(json_object_get(json_object_get(calibration, "screenW"), "value")), 96);
}

static void check_info(json_t *answer)
{
    const json_t *devices = json_object_get(answer, "devices"),
                 *device = json_array_get(devices, 0);
    assert_int_equal(sp_error(answer), 0);
    assert_true(json_is_string(json_object_get(answer, "version")));
    assert_int_equal(json_array_size(devices), 1);
    assert_string_equal(json_string_value(json_object_get(device, "state")), "ok");
    check_calibration(json_object_get(device, "calibration"));
    json_decref(answer);
}

/* Waits until quiltd has, or has not, its panel. */
static void await_panel(programs *p, bool present)
{
    bool is = !present;
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && is != present; i++, live_nap(20)) {
        json_t *answer = live_call(&p->c, "status", NULL);
        const json_t *device = json_object_get(json_object_get(answer, "result"), "device");
        is = strcmp(json_string_value(json_object_get(device, "kind")), "sim") == 0;
        json_decref(answer);
    }
    assert_int_equal(is, present);
}

/* What quiltd shows, as a quilt. */
static void get_frame(programs *p, uint8_t out[BYTES])
{
    int fd = memfd_create("frame", MFD_CLOEXEC);
    live_ask_with(&p->c, "frame.get", json_pack("{s:s}", "format", "raw"), &fd, 1);
    json_t *answer = live_answer(&p->c);
    assert_int_equal(
        json_integer_value(json_object_get(json_object_get(answer, "result"), "bytes")), BYTES);
    json_decref(answer);
    assert_int_equal(pread(fd, out, BYTES, 0), BYTES);
    close(fd);
}

/* The number of pixels of the frame that are those of the bitmap at (x, y), or as `other` has it:
 * from the bottom, or with red and blue exchanged. */
enum { AS_IT_IS, FROM_THE_BOTTOM, EXCHANGED };

static int pixels_like(const uint8_t frame[BYTES], int other)
{
    int n = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        uint8_t rgb[3];
        const int y = i / WIDTH;
        bitmap_pixel(i % WIDTH, other == FROM_THE_BOTTOM ? HEIGHT - 1 - y : y, rgb);
        if (other == EXCHANGED) {
            const uint8_t red = rgb[0];
            rgb[0] = rgb[2];
            rgb[2] = red;
        }
        n += memcmp(frame + 3 * i, rgb, 3) == 0;
    }
    return n;
}

#define SHOW                                                                                       \
    "{\"show\": {\"targetDisplay\": 0, \"source\": \"bindata\", \"quilt\": {\"type\": \"image\", " \
    "\"settings\": {\"vx\": 3, \"vy\": 2, \"vtotal\": 6, \"aspect\": 0.75, \"invert\": 0}}}}"

/* ------------------------------------------------------------------------------------- tests -- */

/* The answer comes once the panel shows the pixels: no frame is waited for here. */
static void a_bitmap_reaches_the_panel(void **state)
{
    (void)state;
    static const struct {
        int height, bits;
    } rows[] = {{HEIGHT, 24}, {-HEIGHT, 24}, {HEIGHT, 32}, {-HEIGHT, 32}};
    programs p;
    uint8_t frame[BYTES];
    begin(&p, NULL);
    int fd = nng_connect(&p);
    nng_check(fd, "{\"init\": {\"appid\": \"test\"}}", NULL, 0, 0);
    check_info(nng_ask(fd, "{\"info\": {}}", (const uint8_t *)"", 0));
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        size_t n = 0;
        uint8_t *bmp = bitmap_make(WIDTH, rows[i].height, rows[i].bits, &n);
        nng_check(fd, SHOW, bmp, n, 0);
        get_frame(&p, frame);
        assert_int_equal(pixels_like(frame, AS_IT_IS), WIDTH * HEIGHT);
        assert_true(pixels_like(frame, FROM_THE_BOTTOM) < WIDTH * HEIGHT / 4);
        assert_true(pixels_like(frame, EXCHANGED) < WIDTH * HEIGHT / 4);
        nng_check(fd, "{\"targetDisplay\": 0, \"wipe\": {}}", NULL, 0, 0);
        free(bmp);
    }
    nng_check(fd, "{\"hide\": {\"targetDisplay\": 0}}", NULL, 0, 0);
    nng_check(fd, "{\"show\": {\"targetDisplay\": 0}}", NULL, 0, 0);
    close(fd);
    end(&p);
}

/* What quiltd cannot show is told, and the last image stays. */
static void a_failure_is_told(void **state)
{
    (void)state;
    static const char bad[] = "\xff\xd8 this is no JPEG";
    programs p;
    uint8_t frame[BYTES];
    size_t n = 0;
    begin(&p, "--image-limit=1");
    uint8_t *bmp = bitmap_make(WIDTH, HEIGHT, 24, &n), *large = calloc(2 << 20, 1);
    int fd = nng_connect(&p);
    nng_check(fd, SHOW, bmp, n, 0);
    nng_check(fd, SHOW, (const uint8_t *)bad, sizeof bad, 3);
    nng_check(fd, SHOW, bmp, n - 1, 3);
    nng_check(fd, SHOW, large, 2 << 20, 3);
    nng_check(fd, "{\"show\": {\"quilt\": {\"settings\": {\"vx\": 5, \"vy\": 2}}}}", bmp, n, 3);
    get_frame(&p, frame);
    assert_int_equal(pixels_like(frame, AS_IT_IS), WIDTH * HEIGHT);
    assert_true(live_logged(&p.l, "driver: show: the image is larger than 1 MiB"));
    free(bmp);
    free(large);
    close(fd);
    end(&p);
}

/* quiltd takes a quilt without a panel, too, but nobody sees it. */
static void without_a_panel_nothing_is_shown(void **state)
{
    (void)state;
    static const char *const commands[] = {SHOW, "{\"show\": {}}", "{\"wipe\": {}}",
                                           "{\"hide\": {}}"};
    programs p;
    size_t n = 0;
    begin(&p, NULL);
    uint8_t *bmp = bitmap_make(WIDTH, HEIGHT, 24, &n);
    int fd = nng_connect(&p);
    assert_int_equal(live_code(&p.c, "device.set", json_pack("{s:s}", "spec", "none")), 0);
    await_panel(&p, false);
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++)
        nng_check(fd, commands[i], i == 0 ? bmp : NULL, i == 0 ? n : 0, 4);
    free(bmp);
    close(fd);
    end(&p);
}

/* AliceLG sends the next request without an eye on the answer, and may leave. */
static void a_program_need_not_wait(void **state)
{
    (void)state;
    programs p;
    uint8_t frame[BYTES];
    size_t n = 0, n_show = 0, n_info = 0;
    begin(&p, NULL);
    uint8_t *bmp = bitmap_make(WIDTH, HEIGHT, 24, &n);
    uint8_t *show = sp_request((uint32_t)ID, SHOW, bmp, n, &n_show);
    uint8_t *info = sp_request((uint32_t)ID + 1, "{\"info\": {}}", NULL, 0, &n_info);
    int fd = nng_connect(&p);
    nng_send(fd, show, n_show);
    nng_send(fd, info, n_info);
    nng_send(fd, show, n_show);
    json_decref(nng_answer(fd, (uint32_t)ID));
    check_info(nng_answer(fd, (uint32_t)ID + 1));
    close(fd);
    fd = nng_connect(&p);
    check_info(nng_ask(fd, "{\"info\": {}}", NULL, 0));
    get_frame(&p, frame);
    assert_int_equal(pixels_like(frame, AS_IT_IS), WIDTH * HEIGHT);
    free(show);
    free(info);
    free(bmp);
    close(fd);
    end(&p);
}

/* Messages of one frame, of many, and with a ping between two of them. */
static void a_page_talks_by_a_websocket(void **state)
{
    (void)state;
    static const uint8_t info[] = {0xc4, 0x22, 0x82, 0x85, 0xa2, 0x63, 'c', 'm', 'd', 0xa1, 0x64,
                                   'i',  'n',  'f',  'o',  0xa0, 0x63, 'b', 'i', 'n', 0xf6};
    programs p;
    uint8_t frame[BYTES], pong[256];
    size_t n = 0, n_show = 0, n_pong = 0;
    begin(&p, NULL);
    int fd = ws_open(&p, "/driver");
    ws_send(fd, 0x82, info, sizeof info);
    check_info(ws_answer(fd, 0xc4228285u));
    uint8_t *bmp = bitmap_make(WIDTH, HEIGHT, 24, &n);
    uint8_t *show = sp_request((uint32_t)ID, SHOW, bmp, n, &n_show);
    for (size_t at = 0; at < n_show; at += 5)
        ws_send(fd, (at == 0 ? 2 : 0) | (at + 5 >= n_show ? 0x80 : 0), show + at,
                n_show - at < 5 ? n_show - at : 5);
    json_t *answer = ws_answer(fd, (uint32_t)ID);
    assert_int_equal(sp_error(answer), 0);
    json_decref(answer);
    get_frame(&p, frame);
    assert_int_equal(pixels_like(frame, AS_IT_IS), WIDTH * HEIGHT);
    ws_send(fd, 2, show, 1000);
    ws_send(fd, 0x89, (const uint8_t *)"ping", 4);
    ws_send(fd, 0x80, show + 1000, n_show - 1000);
    ws_send(fd, 0x82, info, sizeof info); /* in advance */
    ws_receive(fd, 10, pong, sizeof pong, &n_pong);
    assert_int_equal(n_pong, 4);
    answer = ws_answer(fd, (uint32_t)ID);
    assert_int_equal(sp_error(answer), 0);
    json_decref(answer);
    check_info(ws_answer(fd, 0xc4228285u));
    ws_send(fd, 0x81, (const uint8_t *)"a text", 6);
    ws_receive(fd, 8, pong, sizeof pong, &n_pong);
    assert_int_equal(number_of(pong, 2), 1003);
    free(show);
    free(bmp);
    close(fd);
    end(&p);
}

static void the_calibration_is_told_at_once(void **state)
{
    (void)state;
    programs p;
    uint8_t text[8192];
    size_t n = 0;
    begin(&p, NULL);
    int fd = ws_open(&p, "/");
    ws_receive(fd, 1, text, sizeof text, &n);
    json_t *calibration = json_loads((const char *)text, 0, NULL);
    check_calibration(calibration);
    json_decref(calibration);
    close(fd);
    end(&p);
}

/* A socket unit passes it by the name "nng"; then the path is not quiltweb's to remove. */
static void a_socket_may_come_from_systemd(void **state)
{
    (void)state;
    programs p;
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    live_prepare(&p.l);
    live_start(&p.l, p.l.scene, "--device", p.l.sim, "--state", p.l.state, NULL);
    live_connect(&p.l, &p.c);
    snprintf(p.nng, sizeof p.nng, "%s/passed", p.l.folder);
    memcpy(address.sun_path, p.nng, sizeof p.nng);
    const int listening = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_int_equal(bind(listening, (struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(listening, 4), 0);
    /* a shell gives the descriptor its number, and the variables their values */
    char command[PATH_MAX], fd[16];
    snprintf(fd, sizeof fd, "%d", listening);
    snprintf(command, sizeof command,
             "exec 3<&%s; LISTEN_FDS=1 LISTEN_FDNAMES=nng LISTEN_PID=$$ exec %s --socket %s "
             "--listen 127.0.0.1:0 --url-file %s/url",
             fd, lf_test_built("quiltweb"), p.l.socket, p.l.folder);
    char *args[] = {(char *)(uintptr_t) "/bin/bash", (char *)(uintptr_t) "-c", command, NULL};
    p.web = live_spawn(&p.l, args);
    int client = nng_connect(&p); /* waits in the kernel until quiltweb runs */
    check_info(nng_ask(client, "{\"info\": {}}", NULL, 0));
    close(client);
    stop_web(&p);
    assert_int_equal(access(p.nng, F_OK), 0);
    close(listening);
    live_close(&p.c);
    live_finish(&p.l);
}

/* Each beside one that is let in. */
static void strangers_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *host, *rest;
        int status;
    } rows[] = {
        {"localhost", BROWSER, 101},
        {"127.0.0.1", "Origin: http://127.0.0.1:3000\r\n" BROWSER, 101},
        {"localhost", "Origin: https://evil.test\r\n" BROWSER, 403},
        {"localhost", "Origin: null\r\n" BROWSER, 403},
        {"evil.test", BROWSER, 421},
        {"evil.test", "Origin: http://localhost:8090\r\n" BROWSER, 421},
        {"localhost", "Sec-WebSocket-Protocol: req.sp.nanomsg.org\r\n", 400},
        {"localhost", "", 400},
    };
    programs p;
    begin(&p, NULL);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char headers[512];
        int fd = -1;
        snprintf(headers, sizeof headers, "Host: %s:%d\r\n%s", rows[i].host, p.port, rows[i].rest);
        const int status = ws_connect(&p, "/driver", headers, &fd);
        if (status != rows[i].status)
            fail_msg("%s: %d, expected %d", headers, status, rows[i].status);
        close(fd);
    }
    end(&p);
}

/* Bytes of hexadecimal digits. */
static size_t unhex(const char *hex, uint8_t *out, size_t size)
{
    size_t n = 0;
    for (unsigned byte; n < size && sscanf(hex + 2 * n, "%2x", &byte) == 1;)
        out[n++] = (uint8_t)byte;
    return n;
}

/* Requests that real programs have sent: a page's over its WebSocket, and nngcat's over both. */
static void recorded_requests_are_answered(void **state)
{
    static const char *const names[] = {"webxr-minimal.jsonl", "webxr-nodev.jsonl",
                                        "webxr-portrait.jsonl", "nng-ws.jsonl",
                                        "ipc-transcript.jsonl"};
    int n_sent = 0;
    programs p;
    if (!lf_test_shared("bridge-vectors/nng-ws.jsonl"))
        skip();
    (void)state;
    begin(&p, NULL);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char name[64], line[65536];
        snprintf(name, sizeof name, "bridge-vectors/%s", names[i]);
        FILE *file = fopen(lf_test_shared(name), "r");
        assert_non_null(file);
        while (fgets(line, sizeof line, file)) {
            json_t *event = json_loads(line, 0, NULL);
            const char *hex = json_string_value(json_object_get(event, "hex")),
                       *frame = json_string_value(json_object_get(event, "frame")),
                       *dir = json_string_value(json_object_get(event, "dir"));
            uint8_t data[512];
            if (dir && strcmp(dir, ">") == 0 && hex) {
                const size_t n = unhex(hex, data, sizeof data);
                int fd = ws_open(&p, "/driver");
                ws_send(fd, 0x82, data, n);
                check_info(ws_answer(fd, (uint32_t)number_of(data, 4)));
                close(fd);
                n_sent++;
            } else if (dir && strcmp(dir, ">") == 0 && frame) {
                size_t n = unhex(frame, data, 9);
                n += unhex(json_string_value(json_object_get(event, "id")), data + n, 4);
                n += unhex(json_string_value(json_object_get(event, "body")), data + n, 256);
                int fd = nng_connect(&p);
                put(fd, data, n);
                check_info(nng_answer(fd, (uint32_t)number_of(data + 9, 4)));
                close(fd);
                n_sent++;
            }
            json_decref(event);
        }
        fclose(file);
    }
    assert_int_equal(n_sent, 5);
    end(&p);
}

/* While quiltweb lives; also if it is killed. */
static void a_panel_is_lent_and_comes_back(void **state)
{
    (void)state;
    programs p;
    begin(&p, "--panel-only");
    for (int killed = 0; killed < 2; killed++) {
        uint8_t text[8192];
        size_t n = 0;
        await_panel(&p, false);
        int fd = nng_connect(&p), ws = ws_open(&p, "/");
        check_info(nng_ask(fd, "{\"info\": {}}", NULL, 0)); /* it is known all the same */
        ws_receive(ws, 1, text, sizeof text, &n);
        json_t *calibration = json_loads((const char *)text, 0, NULL);
        check_calibration(calibration);
        json_decref(calibration);
        nng_check(fd, SHOW, NULL, 0, 7);
        nng_check(fd, "{\"wipe\": {}}", NULL, 0, 7);
        close(fd);
        close(ws);
        if (killed) {
            kill(p.web, SIGKILL);
            assert_int_equal(live_reap(p.web), 128 + SIGKILL);
        } else {
            stop_web(&p);
        }
        await_panel(&p, true);
        start_web(&p, "--panel-only");
    }
    end(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_bitmap_reaches_the_panel),
        cmocka_unit_test(a_failure_is_told),
        cmocka_unit_test(without_a_panel_nothing_is_shown),
        cmocka_unit_test(a_program_need_not_wait),
        cmocka_unit_test(a_page_talks_by_a_websocket),
        cmocka_unit_test(the_calibration_is_told_at_once),
        cmocka_unit_test(a_socket_may_come_from_systemd),
        cmocka_unit_test(strangers_are_refused),
        cmocka_unit_test(recorded_requests_are_answered),
        cmocka_unit_test(a_panel_is_lent_and_comes_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
