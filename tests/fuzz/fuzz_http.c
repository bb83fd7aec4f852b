/* Anything that a client may send to the gateway's port, in pieces as long as the first byte says.
 * The bytes 1, 2 and 3 stand for what an input cannot know: the address, the token, and the cookie.
 * Whoever has neither secret reaches no quiltd, and nobody is told the token. */
#include "tests/fuzz/gateway.h"

#include "base/alloc.h"

enum { ADDRESS = 1, TOKEN = 2, COOKIE = 3, MOST = 1 << 20 };

static char answer[MOST];

/* The header Set-Cookie that the gateway answers to the token: "quiltweb-PORT=…". */
static const char *cookie_of(fuzz_gateway *g)
{
    static char cookie[80];
    char request[256];
    if (cookie[0] != '\0')
        return cookie;
    snprintf(request, sizeof request,
             "POST /api/login HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nAuthorization: Bearer %s\r\n"
             "Content-Length: 0\r\n\r\n",
             lf_web_port(g->web, LF_SERVICE_PAGE), g->token);
    int fd = fuzz_connect(g);
    fuzz_send(g, fd, request, strlen(request));
    fuzz_end(g, fd, answer, sizeof answer);
    const char *found = strstr(answer, "quiltweb-");
    lf_fuzz_require(found);
    snprintf(cookie, sizeof cookie, "%.*s", (int)strcspn(found, ";\r\n"), found);
    return cookie;
}

/* The input with its bytes replaced; lf_free. */
static char *request_of(const uint8_t *data, size_t size, const char *cookie, const fuzz_gateway *g,
                        size_t *out_n)
{
    char address[32];
    snprintf(address, sizeof address, "127.0.0.1:%d", lf_web_port(g->web, LF_SERVICE_PAGE));
    const char *const words[] = {[ADDRESS] = address, [TOKEN] = g->token, [COOKIE] = cookie};
    char *request = lf_calloc(size + 1, 64);
    size_t n = 0;
    lf_fuzz_require(request && strlen(cookie) < 64);
    for (size_t i = 0; i < size; i++) {
        const char *word = data[i] >= ADDRESS && data[i] <= COOKIE ? words[data[i]] : NULL;
        const size_t length = word ? strlen(word) : 1;
        memcpy(request + n, word ? word : (const char *)data + i, length);
        n += length;
    }
    *out_n = n;
    return request;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_gateway *g = fuzz_gateway_begin();
    const char *cookie = cookie_of(g);
    if (size < 1)
        return 0;
    const size_t piece = data[0] + 1u;
    size_t n = 0;
    char *request = request_of(data + 1, size - 1, cookie, g, &n);
    /* a fuzzer may find them out, because it sees what is compared */
    const bool has_token = memmem(request, n, g->token, strlen(g->token));
    const bool knows = has_token || memmem(request, n, cookie, strlen(cookie));
    const int reached = g->n_reached;
    int fd = fuzz_connect(g);
    for (size_t at = 0; at < n; at += piece)
        fuzz_send(g, fd, request + at, n - at < piece ? n - at : piece);
    const size_t got = fuzz_end(g, fd, answer, sizeof answer);
    lf_fuzz_require(got == 0 || strncmp(answer, "HTTP/1.", 7) == 0);
    lf_fuzz_require(has_token || !memmem(answer, got, g->token, strlen(g->token)));
    lf_fuzz_require(knows || g->n_reached == reached);
    lf_free(request);
    return 0;
}
