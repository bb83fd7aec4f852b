/* Anything that a peer may send over a WebSocket. The first byte says how much of the rest came
 * together with the handshake, and its top bit whether texts are wanted, or binary messages in
 * parts. Messages are not too long, the end comes once, and nothing is said after it. While paused,
 * little comes. */
#include "tests/fuzz/fuzz.h"

#include <string.h>
#include <sys/socket.h>
#include <systemd/sd-event.h>

#include "daemon/web/ws.h"

enum { MAX_STEPS = 100000, MAX_PARTS = 100000 };

typedef struct peer {
    lf_ws *ws;
    int n_texts, n_ends;
    size_t length; /* of the message whose parts come */
    size_t ahead;  /* bytes that have come since the pause */
    bool paused;
} peer;

/* Every second message is answered; one that asks for it closes. */
static void on_text(void *context, const char *text, size_t n)
{
    peer *p = context;
    lf_fuzz_require(p->n_ends == 0 && n <= LF_WS_MAX_MESSAGE && text);
    unsigned sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += (unsigned char)text[i]; /* all of it may be read */
    if (p->n_texts++ % 2 == 0)
        lf_ws_send_text(p->ws, text, n);
    if (n > 0 && sum % 64 == 0)
        lf_ws_close(p->ws, LF_WS_POLICY, "enough");
}

/* After every message it pauses, until the next turn of the peer. */
static void on_part(void *context, const uint8_t *data, size_t n)
{
    peer *p = context;
    unsigned sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += data[i];
    p->length = n > 0 ? p->length + n : 0;
    p->ahead += p->paused ? n : 0;
    lf_fuzz_require(p->n_ends == 0 && p->length <= MAX_PARTS && p->ahead <= LF_WS_READ_AHEAD);
    if (n > 0)
        return;
    p->paused = true;
    lf_ws_pause(p->ws, true);
    if (p->n_texts++ % 2 == 0)
        lf_ws_send_binary(p->ws, (const uint8_t *)&sum, sizeof sum);
}

static void on_flushed(void *context)
{
    lf_fuzz_require(((const peer *)context)->n_ends == 0);
}

static void on_ended(void *context)
{
    ((peer *)context)->n_ends++;
}

static void run(sd_event *event)
{
    int steps = 0;
    while (sd_event_run(event, 0) > 0)
        lf_fuzz_require(++steps < MAX_STEPS);
}

static void go_on(peer *p)
{
    p->paused = false;
    p->ahead = 0;
    lf_ws_pause(p->ws, false);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    peer p = {0};
    lf_ws_events events = {.text = on_text,
                           .longest = MAX_PARTS,
                           .flushed = on_flushed,
                           .ended = on_ended,
                           .context = &p};
    sd_event *event = NULL;
    lf_error err = {0};
    int ends[2];
    char forgotten[4096];
    if (size < 1)
        return 0;
    const size_t wanted = data[0] & 127u, early = wanted < size - 1 ? wanted : size - 1;
    events.part = data[0] & 128 ? on_part : NULL;
    lf_fuzz_require(sd_event_new(&event) >= 0 &&
                    socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends) == 0);
    lf_fuzz_require(lf_ws_create(event, ends[0], data + 1, early, &events, &p.ws, &err) == LF_OK);
    for (size_t at = 1 + early; at < size;) {
        ssize_t n = send(ends[1], data + at, size - at, MSG_NOSIGNAL);
        if (n <= 0)
            break;
        at += (size_t)n;
        go_on(&p);
        run(event);
        while (recv(ends[1], forgotten, sizeof forgotten, 0) > 0)
            run(event);
    }
    run(event);
    close(ends[1]);
    for (int i = 0; i < MAX_STEPS && p.n_ends == 0; i++) {
        go_on(&p);
        run(event);
    }
    lf_fuzz_require(p.n_ends == 1);
    lf_ws_destroy(p.ws);
    close(ends[0]);
    sd_event_unref(event);
    return 0;
}
