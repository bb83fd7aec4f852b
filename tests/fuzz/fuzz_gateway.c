/* A client's text messages, one per line of the input, over a WebSocket of the gateway. What
 * reaches quiltd is allowed (gateway.h), and what comes back are whole frames of JSON. */
#include "tests/fuzz/gateway.h"

enum { TEXT = 0x81, CLOSE = 0x88, MASK = 0x80, MOST = 1 << 20 };

static char answer[MOST];

static int open_socket(fuzz_gateway *g)
{
    char request[512];
    int fd = fuzz_connect(g);
    snprintf(request, sizeof request,
             "GET /rpc HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nAuthorization: Bearer %s\r\n"
             "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
             "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n",
             lf_web_port(g->web, LF_SERVICE_PAGE), g->token);
    fuzz_send(g, fd, request, strlen(request));
    return fd;
}

/* A frame with a mask of zeros. */
static void say(fuzz_gateway *g, int fd, const uint8_t *text, size_t n)
{
    uint8_t head[8] = {TEXT, (uint8_t)(MASK | (n < 126 ? n : 126))};
    size_t length = 2;
    lf_fuzz_require(n < 65536);
    if (n >= 126) {
        head[2] = (uint8_t)(n >> 8);
        head[3] = (uint8_t)n;
        length = 4;
    }
    fuzz_send(g, fd, head, length + 4);
    fuzz_send(g, fd, text, n);
}

/* Bytes of the head of a frame, and of its text. */
static size_t read_head(const uint8_t *head, size_t n, size_t *out_length)
{
    const size_t more = head[1] < 126 ? 0 : head[1] == 126 ? 2 : 8;
    size_t length = more == 0 ? head[1] : 0;
    lf_fuzz_require(head[1] < MASK && n >= 2 + more);
    for (size_t i = 0; i < more; i++)
        length = length << 8 | head[2 + i];
    *out_length = length;
    return 2 + more;
}

/* Frames of a server have no mask, and texts are JSON objects. */
static void check_frames(const char *frames, size_t n)
{
    while (n >= 2) {
        size_t length = 0;
        const uint8_t kind = (uint8_t)frames[0];
        const size_t head = read_head((const uint8_t *)frames, n, &length);
        lf_fuzz_require(n - head >= length && (kind == TEXT || kind == CLOSE));
        json_t *message = kind == TEXT ? json_loadb(frames + head, length, 0, NULL) : NULL;
        lf_fuzz_require(kind != TEXT || json_is_object(message));
        json_decref(message);
        frames += head + length;
        n -= head + length;
    }
    lf_fuzz_require(n == 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_gateway *g = fuzz_gateway_begin();
    int fd = open_socket(g);
    for (size_t at = 0; at < size;) {
        const uint8_t *end = memchr(data + at, '\n', size - at);
        const size_t n = end ? (size_t)(end - data) - at : size - at;
        say(g, fd, data + at, n);
        at += n + 1;
    }
    const size_t got = fuzz_end(g, fd, answer, sizeof answer);
    const char *begin = memmem(answer, got, "\r\n\r\n", 4);
    lf_fuzz_require(got < sizeof answer - 1 && strncmp(answer, "HTTP/1.1 101 ", 13) == 0 && begin);
    check_frames(begin + 4, got - (size_t)(begin + 4 - answer));
    return 0;
}
