/* Clients of the gateway: plain requests, and WebSockets. */
#include "tests/web/gateway.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include "daemon/web/service.h"

enum { PATIENCE_MS = 60000 };

int lf_caller_connect_service(const gateway *g, int service)
{
    struct sockaddr_in address = {.sin_family = AF_INET,
                                  .sin_port = htons((uint16_t)lf_gateway_service_port(g, service)),
                                  .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    const struct timeval patience = {.tv_sec = PATIENCE_MS / 1000};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_true(fd >= 0);
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    assert_int_equal(connect(fd, (struct sockaddr *)&address, sizeof address), 0);
    return fd;
}

int lf_caller_connect(const gateway *g)
{
    return lf_caller_connect_service(g, LF_SERVICE_PAGE);
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

const char *lf_caller_rest(int fd)
{
    static char answer[1 << 18];
    size_t used = 0;
    ssize_t n;
    while (used + 1 < sizeof answer &&
           (n = recv(fd, answer + used, sizeof answer - 1 - used, 0)) > 0)
        used += (size_t)n;
    answer[used] = '\0';
    close(fd);
    return answer;
}

const char *lf_caller_ask_service(const gateway *g, int service, const char *request)
{
    int fd = lf_caller_connect_service(g, service);
    (void)lf_caller_send(fd, request, strlen(request));
    return lf_caller_rest(fd);
}

const char *lf_caller_ask(const gateway *g, const char *request)
{
    return lf_caller_ask_service(g, LF_SERVICE_PAGE, request);
}

int lf_caller_begin(const gateway *g, const char *line, const char *headers)
{
    char request[4096];
    int fd = lf_caller_connect(g);
    snprintf(request, sizeof request,
             "%s\r\nHost: 127.0.0.1:%d\r\nAuthorization: Bearer %s\r\n%s\r\n", line,
             lf_gateway_port(g), lf_gateway_token(g), headers);
    assert_true(lf_caller_send(fd, request, strlen(request)));
    return fd;
}

const char *lf_caller_put(const gateway *g, const char *target, const char *body, size_t n)
{
    char line[1024], length[64];
    snprintf(line, sizeof line, "PUT %s HTTP/1.1", target);
    snprintf(length, sizeof length, "Content-Length: %zu\r\n", n);
    int fd = lf_caller_begin(g, line, length);
    (void)lf_caller_send(fd, body, n);
    return lf_caller_rest(fd);
}

const char *lf_caller_get(const gateway *g, const char *line, const char *headers)
{
    char request[4096];
    snprintf(request, sizeof request, "%s\r\nHost: 127.0.0.1:%d\r\n%s\r\n", line,
             lf_gateway_port(g), headers);
    return lf_caller_ask(g, request);
}

int lf_caller_status(const char *answer)
{
    return strncmp(answer, "HTTP/1.1 ", 9) == 0 ? atoi(answer + 9) : 0;
}

int lf_talk_connect_service(const gateway *g, int service, const char *path, const char *headers,
                            const char **out_answer)
{
    static char answer[4096];
    char request[4096];
    size_t used = 0;
    int fd = lf_caller_connect_service(g, service);
    snprintf(request, sizeof request,
             "GET %s HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nUpgrade: websocket\r\n"
             "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
             "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n%s\r\n",
             path, lf_gateway_service_port(g, service), headers);
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

int lf_talk_connect(const gateway *g, const char *headers, const char **out_answer)
{
    return lf_talk_connect_service(g, LF_SERVICE_PAGE, "/rpc", headers, out_answer);
}

int lf_talk_open(const gateway *g)
{
    char header[80];
    const char *answer = NULL;
    snprintf(header, sizeof header, "Authorization: Bearer %s\r\n", lf_gateway_token(g));
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

/* The next frame of any kind; as lf_talk_next. */
static int next_frame(int fd, const unsigned char **out_data, size_t *out_n)
{
    static unsigned char data[(1 << 21) + 1];
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
    *out_data = data;
    *out_n = n;
    return head[0] & 15;
}

int lf_talk_next(int fd, const unsigned char **out_data, size_t *out_n)
{
    int opcode;
    while ((opcode = next_frame(fd, out_data, out_n)) == 9 || opcode == 10)
        ;
    return opcode;
}

void lf_talk_settle(int fd)
{
    const unsigned char *data = NULL;
    size_t n = 0;
    lf_talk_send(fd, 9, "", 0);
    assert_int_equal(next_frame(fd, &data, &n), 10);
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
