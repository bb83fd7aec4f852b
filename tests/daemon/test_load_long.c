/* QUILTD_LONG=1: storms as people's sliders and scripts make them, on the scene and the panel that
 * are shown first. What it measures is printed; what it judges is that no call is refused, that the
 * last position comes to the panel and that an export asked for in the middle is written.
 * Hostile clients beside an honest one: how long its status takes, and the longest turn of the
 * event thread (CPU time) are printed. STORM_STRICT=1 judges the times as well, on a machine that
 * does nothing else. */
#include "tests/testing.h"

#include <poll.h>

#include "base/thread.h"
#include "tests/daemon/live.h"

enum { MAX_SENDERS = 10, SECONDS = 20, MAX_ASKED = 100000 };

/* The targets: seconds from the last call to the panel, of a status, of an export. */
static const double most_coarse = 0.6, most_status = 0.020, most_export = 10;

typedef struct talker {
    live_client c;
    double due;
    long sent, answered, refused;
    json_int_t generation; /* of its last answer */
} talker;

typedef struct load {
    live l;
    talker senders[MAX_SENDERS], status, exporter, waiter;
    int n_senders;
    double rate; /* calls a second of each sender */
    double asked_at, export_at, exported_at;
    double latency[MAX_ASKED]; /* of status */
    json_int_t job;
    int n_latencies;
    bool export_failed;
} load;

static void tell(talker *t, const char *method, const char *params)
{
    char line[1024];
    int n = snprintf(line, sizeof line,
                     "{\"jsonrpc\":\"2.0\",\"id\":%lld,\"method\":\"%s\",\"params\":%s}\n",
                     (long long)++t->c.ids, method, params);
    live_send(&t->c, line, (size_t)n);
    t->sent++;
}

static void take_answer(talker *t, const json_t *message)
{
    const json_t *result = json_object_get(message, "result");
    if (!json_object_get(message, "id"))
        return;
    t->answered++;
    if (!result && t->refused++ == 0)
        print_message("refused: %s\n", json_string_value(json_object_get(
                                           json_object_get(message, "error"), "message")));
    if (json_object_get(result, "generation"))
        t->generation = json_integer_value(json_object_get(result, "generation"));
}

static void take_job(load *s, const json_t *message)
{
    const json_t *result = json_object_get(message, "result"),
                 *params = json_object_get(message, "params");
    const char *state = json_string_value(json_object_get(params, "state"));
    if (json_object_get(result, "job"))
        s->job = json_integer_value(json_object_get(result, "job"));
    if (!state || strcmp(state, "running") == 0 || s->exported_at > 0)
        return;
    s->exported_at = lf_time_now();
    s->export_failed = strcmp(state, "done") != 0;
}

/* All whole lines that have come; nothing is waited for. */
static void drain(load *s, talker *t)
{
    ssize_t n = recv(t->c.fd, t->c.buffer + t->c.used, t->c.size - t->c.used, MSG_DONTWAIT);
    if (n <= 0) {
        assert_true(n < 0 && (errno == EAGAIN || errno == EINTR));
        return;
    }
    t->c.used += (size_t)n;
    char *at = t->c.buffer, *end;
    while ((end = memchr(at, '\n', t->c.used - (size_t)(at - t->c.buffer)))) {
        json_t *message = json_loadb(at, (size_t)(end - at), 0, NULL);
        assert_non_null(message);
        take_answer(t, message);
        if (t == &s->exporter)
            take_job(s, message);
        json_decref(message);
        at = end + 1;
    }
    t->c.used -= (size_t)(at - t->c.buffer);
    memmove(t->c.buffer, at, t->c.used);
}

/* A status is asked for 20 ms after the last one was answered, the whole time long. */
static void ask_status(load *s)
{
    double now = lf_time_now();
    if (s->status.answered < s->status.sent || now < s->status.due)
        return;
    s->asked_at = now;
    tell(&s->status, "status", "{}");
}

static void take_status(load *s)
{
    long before = s->status.answered;
    drain(s, &s->status);
    if (s->status.answered == before)
        return;
    double now = lf_time_now();
    if (s->n_latencies < MAX_ASKED)
        s->latency[s->n_latencies++] = now - s->asked_at;
    s->status.due = now + 0.02;
}

/* What comes within a millisecond. */
static void hear(load *s)
{
    struct pollfd ready[MAX_SENDERS + 3];
    int n = 0;
    for (int i = 0; i < s->n_senders; i++)
        ready[n++] = (struct pollfd){s->senders[i].c.fd, POLLIN, 0};
    ready[n++] = (struct pollfd){s->status.c.fd, POLLIN, 0};
    ready[n++] = (struct pollfd){s->exporter.c.fd, POLLIN, 0};
    ready[n++] = (struct pollfd){s->waiter.c.fd, POLLIN, 0};
    ask_status(s);
    (void)poll(ready, (nfds_t)n, 1);
    take_status(s);
    drain(s, &s->exporter);
    drain(s, &s->waiter);
    for (int i = 0; i < s->n_senders; i++)
        drain(s, &s->senders[i]);
}

static void start_export(load *s)
{
    char params[PATH_MAX];
    snprintf(params, sizeof params, "{\"kind\":\"quilt\",\"file\":\"%s/q.png\"}", s->l.exports);
    s->export_at = lf_time_now();
    tell(&s->exporter, "export", params);
}

/* The calls; when the last one was sent. */
static double send_all(load *s)
{
    double from = lf_time_now(), last = from, to = from + SECONDS;
    for (int i = 0; i < s->n_senders; i++)
        s->senders[i].due = from;
    while (lf_time_now() < to) {
        if (s->export_at == 0 && lf_time_now() > from + SECONDS / 2.0)
            start_export(s);
        for (int i = 0; i < s->n_senders; i++) {
            talker *t = &s->senders[i];
            for (; t->due < lf_time_now() && t->due < to; t->due += 1 / s->rate) {
                tell(t, "camera.orbit", "{\"yaw\":0.25}");
                last = lf_time_now();
            }
        }
        hear(s);
    }
    return last;
}

static void await_answers(load *s)
{
    double until = lf_time_now() + LIVE_PATIENCE_S;
    for (int i = 0; i < s->n_senders;) {
        hear(s);
        assert_true(lf_time_now() < until);
        i += s->senders[i].answered == s->senders[i].sent;
    }
}

/* Until the panel shows the newest position. */
static void await_panel(load *s)
{
    char params[128];
    json_int_t newest = 0;
    for (int i = 0; i < s->n_senders; i++)
        newest = s->senders[i].generation > newest ? s->senders[i].generation : newest;
    snprintf(params, sizeof params, "{\"generation\":%lld,\"for\":\"coarse\"}", (long long)newest);
    tell(&s->waiter, "wait", params);
    double until = lf_time_now() + LIVE_PATIENCE_S;
    while (s->waiter.answered < s->waiter.sent && lf_time_now() < until)
        hear(s);
    assert_int_equal(s->waiter.answered, 1);
    assert_int_equal(s->waiter.refused, 0);
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void report(load *s, double last, double answered, double coarse)
{
    long sent = 0, refused = 0;
    for (int i = 0; i < s->n_senders; i++) {
        sent += s->senders[i].sent;
        refused += s->senders[i].refused;
    }
    qsort(s->latency, (size_t)s->n_latencies, sizeof *s->latency, compare);
    double p99 = s->latency[s->n_latencies * 99 / 100], most = s->latency[s->n_latencies - 1];
    print_message("%d clients, %g calls a second each: %ld calls, %ld refused, %lld generations\n"
                  "last call answered after %.3f s, on the panel after %.3f s\n"
                  "status of %d: median %.1f ms, 99 %% %.1f ms, at most %.1f ms\n"
                  "export %s after %.2f s\n",
                  s->n_senders, s->rate, sent, refused, (long long)s->senders[0].generation,
                  answered - last, coarse - last, s->n_latencies,
                  1e3 * s->latency[s->n_latencies / 2], 1e3 * p99, 1e3 * most,
                  s->export_failed ? "FAILED" : "written", s->exported_at - s->export_at);
    assert_int_equal(refused, 0);
    assert_false(s->export_failed);
    if (getenv("STORM_STRICT")) {
        assert_true(coarse - last <= most_coarse);
        assert_true(most <= most_status);
        assert_true(s->exported_at - s->export_at <= most_export);
    }
}

static void run(int n_senders, double rate)
{
    load *s = calloc(1, sizeof *s);
    assert_non_null(s);
    if (!lf_test_long()) {
        free(s);
        skip();
    }
    live_prepare(&s->l);
    unlink(lf_test_path(s->l.folder, "sim/calibration.json")); /* a whole panel */
    live_start(&s->l, lf_test_source("scenes/first-light.json"), "--device", s->l.sim,
               "--view-size", "420x560", NULL);
    s->n_senders = n_senders;
    s->rate = rate;
    live_connect(&s->l, &s->status.c);
    live_connect(&s->l, &s->exporter.c);
    live_connect(&s->l, &s->waiter.c);
    for (int i = 0; i < n_senders; i++)
        live_connect(&s->l, &s->senders[i].c);
    live_wait(&s->waiter.c, "complete");
    double last = send_all(s);
    await_answers(s);
    double answered = lf_time_now();
    await_panel(s);
    double coarse = lf_time_now();
    while (s->exported_at == 0 && lf_time_now() < coarse + LIVE_PATIENCE_S)
        hear(s);
    assert_true(s->exported_at > 0);
    report(s, last, answered, coarse);
    for (int i = 0; i < n_senders; i++)
        live_close(&s->senders[i].c);
    live_close(&s->status.c);
    live_close(&s->exporter.c);
    live_close(&s->waiter.c);
    live_finish(&s->l);
    free(s);
}

static void a_thousand_calls_a_second_of_one_client(void **state)
{
    (void)state;
    run(1, 1000);
}

static void sixty_calls_a_second_of_each_of_ten(void **state)
{
    (void)state;
    run(10, 60);
}

/* --------------------------------------------------------------------------- hostile clients -- */

/* What a hostile client sends over and over, whatever it is answered. */
typedef struct flood {
    live_client c;
    const char *text;
    size_t n, sent; /* bytes, of this round */
} flood;

enum { FLOODS = 10, FLOOD_LINES = 1000 };

/* A call many times. */
static char *many_calls(const char *method, const char *params)
{
    char *text = calloc(FLOOD_LINES, 256), *at = text;
    for (int i = 0; i < FLOOD_LINES; i++)
        at += snprintf(at, 256, "{\"jsonrpc\":\"2.0\",\"id\":%d,\"method\":\"%s\",\"params\":%s}\n",
                       i, method, params);
    return text;
}

/* A line of a mebibyte whose patch is so many of these. */
static char *long_patch(const char *unit)
{
    const size_t most = ((size_t)1 << 20) - 100, step = strlen(unit);
    char *text = calloc(1, most + 100);
    int head = sprintf(text, "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"scene.patch\",\"params\":{"
                             "\"patch\":{\"x\":[1");
    char *at = text + head;
    for (; at + step < text + most; at += step)
        memcpy(at, unit, step);
    memcpy(at, "]}}}\n", 5);
    return text;
}

/* Sends what has room, and throws away what has come. */
static void flow(live *l, flood *f)
{
    ssize_t n = send(f->c.fd, f->text + f->sent, f->n - f->sent, MSG_DONTWAIT | MSG_NOSIGNAL);
    f->sent += n > 0 ? (size_t)n : 0;
    f->sent = f->sent == f->n ? 0 : f->sent;
    while ((n = recv(f->c.fd, f->c.buffer, f->c.size, MSG_DONTWAIT)) > 0)
        continue;
    if (n == 0 || errno == ECONNRESET || errno == EPIPE) { /* it was dropped: it comes again */
        live_close(&f->c);
        live_connect(l, &f->c);
        f->sent = 0;
    }
}

static void ten_hostile_clients_beside_an_honest_one(void **state)
{
    (void)state;
    load *s = calloc(1, sizeof *s);
    flood floods[FLOODS];
    assert_non_null(s);
    if (!lf_test_long()) {
        free(s);
        skip();
    }
    char *texts[] = {many_calls("scene.get", "{}"),
                     many_calls("hello", "{}"),
                     many_calls("status", "{}"),
                     many_calls("camera.orbit", "{\"yaw\":1}"),
                     many_calls("device.list", "{}"),
                     many_calls("wait", "{\"for\":\"coarse\"}"),
                     many_calls("subscribe", "{\"events\":[\"frame\",\"scene\",\"device\"]}"),
                     long_patch(",1"),
                     long_patch(",[]"),
                     long_patch(",{\"a\":1}")};
    live_prepare(&s->l);
    live_start(&s->l, lf_test_source("scenes/first-light.json"), "--device", s->l.sim, NULL);
    live_connect(&s->l, &s->status.c);
    live_wait(&s->status.c, "coarse");
    for (int i = 0; i < FLOODS; i++) {
        live_connect(&s->l, &floods[i].c);
        floods[i].text = texts[i];
        floods[i].n = strlen(texts[i]);
        floods[i].sent = 0;
    }
    double end = lf_time_now() + SECONDS, most = 0;
    while (lf_time_now() < end) {
        ask_status(s);
        take_status(s);
        for (int i = 0; i < FLOODS; i++)
            flow(&s->l, &floods[i]);
    }
    while (s->status.answered < s->status.sent)
        take_status(s);
    for (int i = 0; i < s->n_latencies; i++)
        most = fmax(most, s->latency[i]);
    for (int i = 0; i < FLOODS; i++)
        live_close(&floods[i].c);
    print_message("%d hostile clients: status of another one, %d times: at most %.1f ms; longest "
                  "turn of the event thread %.1f ms; %.0f lines\n",
                  FLOODS, s->n_latencies, 1e3 * most,
                  1e3 * live_number(&s->status.c, "status", NULL, "longest_turn"),
                  live_number(&s->status.c, "status", NULL, "lines"));
    assert_int_equal(s->status.refused, 0);
    for (int i = 0; i < FLOODS; i++)
        free(texts[i]);
    live_close(&s->status.c);
    live_finish(&s->l);
    free(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_thousand_calls_a_second_of_one_client),
        cmocka_unit_test(sixty_calls_a_second_of_each_of_ten),
        cmocka_unit_test(ten_hostile_clients_beside_an_honest_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
