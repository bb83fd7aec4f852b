/* A soak: the daemon renders a small scene that moves and converges, on a panel with random faults
 * (tests/daemon/faulty.h), while a client goes on sending commands. Rendering never stops, nothing
 * grows, nothing is left open.
 *
 *     make soak                 10 minutes; SOAK_SECONDS, SOAK_SEED (printed)
 *
 * make check runs 20 seconds of it. How long commands take is told, and only make soak
 * (SOAK_STRICT) judges it. The first fifth of the time is without faults, to compare with. */
#include "tests/daemon/live.h"

#include <dirent.h>
#include <limits.h>
#include <poll.h>
#include <stdatomic.h>
#include <sys/mman.h>

#include "base/log.h"
#include "base/thread.h"
#include "daemon/server/server.h"
#include "tests/daemon/faulty.h"

#define SECONDS 20.0
#define QUIET_SHARE 0.2
#define WARM_SHARE 0.2      /* of the time with faults: caches and the allocator's pools fill */
#define STOPPED_SECONDS 60  /* without a pass: rendering has stopped */
#define PROMPT_SECONDS 0.1  /* a command that need not wait for files or devices */
#define SAMPLE_SECONDS 0.25 /* between looks at the process */
#define SETTLE_SECONDS 120  /* until what faults left behind is closed */

enum {
    MAX_LATENCIES = 1 << 16,
    MAX_SAMPLES = 1 << 14,
    N_PHASES = 2,
    MAX_PARAMS = 5,
    N_SERIAL = 4,
    N_WORKERS = 2 /* at most */
};

/* AddressSanitizer keeps what was freed for a while, ThreadSanitizer what it knows of memory. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { GROWTH_KIB = 512 * 1024 };
#else
enum { GROWTH_KIB = 16 * 1024 };
#endif

static double wanted_seconds(void)
{
    const char *text = getenv("SOAK_SECONDS");
    double seconds = text ? strtod(text, NULL) : 0;
    return seconds > 0 ? seconds : lf_test_long() ? 60 : SECONDS;
}

/* Every check has other tests to run beside 20 seconds of this one. */
static int n_workers(void)
{
#if defined(__SANITIZE_THREAD__)
    return N_WORKERS;
#else
    return wanted_seconds() > SECONDS ? N_WORKERS : 1;
#endif
}

/* Threads whose waits for a CPU count: this one, the daemon's event thread, loader and engine, one
 * after the other; and workers, who have to leave a cancelled pass, side by side. */
enum { N_WAITS = N_SERIAL + N_WORKERS };

typedef enum phase { QUIET, FAULTS } phase;

/* -------------------------------------------------------------------------------- the daemon -- */

static lf_faulty_orders *orders; /* shared by both programs */

static void map_orders(int fd)
{
    orders = mmap(NULL, sizeof *orders, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
}

/* The whole server with the faulty panel in place of real ones: this program again, since a library
 * that it links has threads that a fork would lose. */
static pid_t start_server(const live *l, int orders_fd)
{
    char number[16];
    snprintf(number, sizeof number, "%d", orders_fd);
    char *args[] = {(char *)(uintptr_t) "/proc/self/exe",
                    (char *)(uintptr_t)l->scene,
                    (char *)(uintptr_t)l->socket,
                    (char *)(uintptr_t)l->exports,
                    number,
                    NULL};
    return live_spawn(l, args);
}

/* args: what start_server gives. */
static int run_server(char *args[])
{
    lf_server_config config = {
        .scene = args[1], .socket = args[2], .device = "usb", .export_dir = args[3]};
    lf_error err;
    map_orders((int)strtol(args[4], NULL, 10));
    lf_log_init("quiltd", LF_LOG_INFO);
    lf_button_actions_default(&config.buttons);
    /* a pause would be no stop of rendering */
    if (orders == MAP_FAILED ||
        lf_button_actions_parse("square=none", &config.buttons, &err) != LF_OK)
        return 1;
    config.options.view_width = 48;
    config.options.view_height = 64;
    config.options.threads = n_workers();
    config.options.target_error = 1e-9;
    lf_faulty_use(orders);
    return lf_server_run(&config);
}

static int count_entries(pid_t pid, const char *what)
{
    char path[64];
    snprintf(path, sizeof path, "/proc/%d/%s", (int)pid, what);
    DIR *folder = opendir(path);
    assert_non_null(folder);
    int n = 0;
    while (readdir(folder))
        n++;
    closedir(folder);
    return n - 2; /* "." and ".." */
}

/* -------------------------------------------------------------------------------- the client -- */

/* A command that is sent again and again, never before the last one was answered. */
typedef struct command {
    const char *method;
    double period; /* seconds */
    /* answered when a file or a device was opened, looked for, or loaded */
    bool late;
    const char *params[MAX_PARAMS]; /* in turn; NULL ends them */
} command;

static const command commands[] = {
    {"status", 0.04, false, {"{}"}},
    {"scene.get", 0.3, false, {"{}"}},
    {"device.calibration", 0.35, false, {"{}"}},
    {"render.set", 0.8, false, {"{\"target_error\":1e-9}", "{\"target_error\":1e-8}"}},
    {"button", 2.3, false, {"{\"name\":\"circle\"}", "{\"name\":\"right\"}"}},
    {"camera.orbit",
     1.1,
     false,
     {"{\"yaw\":7}", "{\"yaw\":-3,\"pitch\":2}", "{\"yaw\":-4,\"pitch\":-2}"}},
    {"scene.patch",
     1.7,
     true,
     {"{\"patch\":{\"lights\":{\"sky\":{\"radiance\":0.9}}}}",
      "{\"patch\":{\"lights\":{\"sky\":{\"radiance\":0.4}}}}"}},
    {"scene.load",
     3.1,
     true,
     {"{\"file\":\"fog.json\"}", "{\"file\":\"mist.json\"}", "{\"file\":\"broken.json\"}"}},
    {"device.list", 0.9, true, {"{}"}},
    {"device.set",
     4.3,
     true,
     {"{\"spec\":\"usb\"}", "{\"spec\":\"usb:1-1\"}", "{\"spec\":\"none\"}", "{\"spec\":\"usb\"}",
      "{\"spec\":\"usb:7-7\"}"}},
};

enum { N_COMMANDS = sizeof commands / sizeof *commands };

typedef struct latency {
    float seconds;
    float own; /* less what the threads that it went through waited for a CPU that others had */
} latency;

typedef struct latencies {
    size_t n;
    latency of[MAX_LATENCIES];
} latencies;

/* One command's turn. */
typedef struct turn {
    double next_at, sent_at; /* lf_time_now; sent_at 0 = nothing is on its way */
    double waited[N_WAITS];  /* wait_of then */
    int id;
    unsigned sent;
} turn;

/* Passes as the status tells them: they begin anew with every picture. */
typedef struct progress {
    json_int_t generation;
    double passes; /* of this generation */
    double sum;
    double moved_at;  /* when there was a new one last */
    double longest_s; /* that there was none */
} progress;

typedef struct soak {
    live l;
    live_client c;
    int ids;
    int waits[N_WAITS]; /* descriptors of schedstat files */
    phase phase;
    turn turns[N_COMMANDS];
    progress progress;
    double passes[N_PHASES], seconds[N_PHASES];
    size_t n_samples; /* with faults */
    struct {
        double at, kib;
    } samples[MAX_SAMPLES];
    latencies latencies[N_PHASES][N_COMMANDS];
} soak;

/* A file of one of the daemon's threads. */
static int open_of_thread(pid_t pid, const char *thread, const char *name)
{
    char path[128];
    snprintf(path, sizeof path, "/proc/%d/task/%.16s/%s", (int)pid, thread, name);
    return open(path, O_RDONLY | O_CLOEXEC);
}

static bool is_thread(pid_t pid, const char *thread, const char *name)
{
    char text[32];
    int fd = open_of_thread(pid, thread, "comm");
    ssize_t n = fd >= 0 ? read(fd, text, sizeof text) : 0;
    close(fd);
    return n > 1 && (size_t)n - 1 == strlen(name) && memcmp(text, name, (size_t)n - 1) == 0;
}

static void open_waits(soak *s)
{
    static const struct {
        const char *name;
        int first, end; /* places for threads of that name */
    } kinds[] = {{"lf-loader", 2, 3}, {"lf-engine", 3, N_SERIAL}, {"lf-worker", N_SERIAL, N_WAITS}};
    char path[64], first[16];
    snprintf(first, sizeof first, "%d", (int)s->l.pid);
    s->waits[0] = open("/proc/self/schedstat", O_RDONLY | O_CLOEXEC);
    s->waits[1] = open_of_thread(s->l.pid, first, "schedstat");
    snprintf(path, sizeof path, "/proc/%d/task", (int)s->l.pid);
    DIR *folder = opendir(path);
    assert_non_null(folder);
    for (const struct dirent *entry = readdir(folder); entry; entry = readdir(folder)) {
        for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
            int place = kinds[k].first;
            while (place < kinds[k].end && s->waits[place] > 0)
                place++;
            if (place < kinds[k].end && is_thread(s->l.pid, entry->d_name, kinds[k].name))
                s->waits[place] = open_of_thread(s->l.pid, entry->d_name, "schedstat");
        }
    }
    closedir(folder);
}

static void close_waits(soak *s)
{
    for (int i = 0; i < N_WAITS; i++)
        if (s->waits[i] > 0)
            close(s->waits[i]);
}

/* Seconds so far that a thread could have run and did not; 0 where the kernel does not count it. */
static double wait_of(const soak *s, int i)
{
    char text[96];
    unsigned long long ns = 0;
    ssize_t n = s->waits[i] > 0 ? pread(s->waits[i], text, sizeof text - 1, 0) : 0;
    text[n > 0 ? n : 0] = 0;
    return sscanf(text, "%*u %llu", &ns) == 1 ? 1e-9 * (double)ns : 0;
}

/* How long a command that was sent at `since` waited for CPUs. */
static double waited(const soak *s, const double since[N_WAITS])
{
    double serial = 0, workers = 0;
    for (int i = 0; i < N_WAITS; i++) {
        double more = wait_of(s, i) - since[i];
        serial += i < N_SERIAL ? more : 0;
        workers = fmax(workers, i < N_SERIAL ? 0 : more);
    }
    return serial + workers;
}

static void send_command(soak *s, int index)
{
    const command *c = &commands[index];
    turn *t = &s->turns[index];
    unsigned n = 0;
    while (n < MAX_PARAMS && c->params[n])
        n++;
    char text[512];
    t->id = ++s->ids;
    int length = snprintf(text, sizeof text,
                          "{\"jsonrpc\":\"2.0\",\"id\":%d,\"method\":\"%s\",\"params\":%s}\n",
                          t->id, c->method, c->params[t->sent++ % n]);
    for (int i = 0; i < N_WAITS; i++)
        t->waited[i] = wait_of(s, i);
    t->sent_at = lf_time_now();
    t->next_at = t->sent_at + c->period;
    live_send(&s->c, text, (size_t)length);
}

static void follow(progress *p, const json_t *status, double now)
{
    json_int_t generation = json_integer_value(json_object_get(status, "generation"));
    double passes = json_number_value(json_object_get(status, "passes"));
    double more = generation == p->generation ? passes - p->passes : passes;
    if (generation != p->generation || more > 0) {
        p->longest_s = fmax(p->longest_s, now - p->moved_at);
        p->moved_at = now;
    }
    p->sum += fmax(more, 0);
    p->generation = generation;
    p->passes = passes;
    if (now - p->moved_at > STOPPED_SECONDS)
        fail_msg("nothing was rendered for %d s", STOPPED_SECONDS);
}

static void take_answer(soak *s, const json_t *message)
{
    double now = lf_time_now();
    int id = (int)json_integer_value(json_object_get(message, "id"));
    for (int i = 0; i < N_COMMANDS; i++) {
        turn *t = &s->turns[i];
        if (t->sent_at <= 0 || t->id != id)
            continue;
        latencies *all = &s->latencies[s->phase][i];
        if (all->n < MAX_LATENCIES) {
            double seconds = now - t->sent_at, own = seconds - waited(s, t->waited);
            all->of[all->n++] = (latency){(float)seconds, (float)fmax(own, 0)};
        }
        t->sent_at = 0;
        if (i == 0)
            follow(&s->progress, json_object_get(message, "result"), now);
    }
}

/* Answers that have come; waits at most wait_ms for the first. */
static void take_answers(soak *s, int wait_ms)
{
    struct pollfd p = {.fd = s->c.fd, .events = POLLIN};
    if (!memchr(s->c.buffer, '\n', s->c.used) && poll(&p, 1, wait_ms) != 1)
        return;
    do {
        json_t *message = live_receive(&s->c);
        if (!message)
            fail_msg("the daemon closed the connection");
        take_answer(s, message);
        json_decref(message);
    } while (memchr(s->c.buffer, '\n', s->c.used));
}

static void take_sample(soak *s)
{
    if (s->phase == FAULTS && s->n_samples < MAX_SAMPLES) {
        s->samples[s->n_samples].at = lf_time_now();
        s->samples[s->n_samples++].kib = (double)live_resident_kib(&s->l);
    }
}

/* Commands for so long. */
static void run_phase(soak *s, phase which, double seconds)
{
    double begin = lf_time_now(), sample_at = begin, passes = s->progress.sum;
    s->phase = which;
    s->progress.moved_at = begin;
    for (double now = begin; now < begin + seconds; now = lf_time_now()) {
        double next = begin + seconds;
        for (int i = 0; i < N_COMMANDS; i++) {
            if (s->turns[i].sent_at <= 0 && now >= s->turns[i].next_at)
                send_command(s, i);
            next = s->turns[i].sent_at <= 0 ? fmin(next, s->turns[i].next_at) : next;
        }
        if (now >= sample_at) {
            take_sample(s);
            sample_at += SAMPLE_SECONDS;
        }
        take_answers(s, 1 + (int)(1e3 * fmax(0, fmin(next, sample_at) - now)));
    }
    s->seconds[which] = lf_time_now() - begin;
    s->passes[which] = s->progress.sum - passes;
}

static bool all_answered(const soak *s)
{
    for (int i = 0; i < N_COMMANDS; i++)
        if (s->turns[i].sent_at > 0)
            return false;
    return true;
}

static void take_last_answers(soak *s)
{
    double end = lf_time_now() + LIVE_PATIENCE_S;
    while (!all_answered(s)) {
        assert_true(lf_time_now() < end);
        take_answers(s, 100);
    }
}

/* ----------------------------------------------------------------------------------- judging -- */

/* Opens the panel, which is healthy. */
static void open_panel(soak *s)
{
    for (int i = 0; live_code(&s->c, "device.set", json_pack("{s:s}", "spec", "usb")) != 0; i++) {
        assert_true(i < 100);
        live_nap(100);
    }
    live_wait(&s->c, "complete");
}

typedef struct holdings {
    int descriptors, threads;
} holdings;

static holdings holdings_of(const soak *s)
{
    return (holdings){count_entries(s->l.pid, "fd"), count_entries(s->l.pid, "task")};
}

static bool same_holdings(holdings a, holdings b)
{
    return a.descriptors == b.descriptors && a.threads == b.threads;
}

/* What is held with the panel open and its buttons found: the same ten times in a row. */
static holdings settled_holdings(soak *s, const holdings *expected)
{
    holdings now = {0};
    double end = lf_time_now() + SETTLE_SECONDS;
    for (int same = 0; same < 10 && lf_time_now() < end;) {
        live_nap(50);
        holdings before = now;
        now = holdings_of(s);
        bool good = same_holdings(now, before) && (!expected || same_holdings(now, *expected));
        same = good ? same + 1 : 0;
    }
    return now;
}

static int compare_latencies(const void *a, const void *b)
{
    float x = ((const latency *)a)->seconds, y = ((const latency *)b)->seconds;
    return x < y ? -1 : x > y;
}

/* Of sorted ones, by the nearest rank. */
static double quantile_ms(const latencies *l, double share)
{
    size_t rank = (size_t)ceil(share * (double)l->n);
    return l->n == 0 ? 0 : 1e3 * (double)l->of[rank > 0 ? rank - 1 : 0].seconds;
}

static double most_own(const latencies *l)
{
    float most = 0;
    for (size_t i = 0; i < l->n; i++)
        most = fmaxf(most, l->of[i].own);
    return (double)most;
}

/* Prints the table; the longest that the daemon itself kept a prompt command waiting. */
static double report_latencies(soak *s)
{
    double slowest = 0;
    print_message("%-20s %24s   %42s\n", "", "without faults", "with faults");
    print_message("%-20s %6s %8s %8s   %6s %8s %8s %8s %8s\n", "ms", "n", "99.9 %", "max", "n",
                  "50 %", "99.9 %", "max", "own max");
    for (int i = 0; i < N_COMMANDS; i++) {
        latencies *quiet = &s->latencies[QUIET][i], *faults = &s->latencies[FAULTS][i];
        qsort(quiet->of, quiet->n, sizeof *quiet->of, compare_latencies);
        qsort(faults->of, faults->n, sizeof *faults->of, compare_latencies);
        print_message("%-20s %6zu %8.1f %8.1f   %6zu %8.1f %8.1f %8.1f %8.1f%s\n",
                      commands[i].method, quiet->n, quantile_ms(quiet, 0.999),
                      quantile_ms(quiet, 1), faults->n, quantile_ms(faults, 0.5),
                      quantile_ms(faults, 0.999), quantile_ms(faults, 1), 1e3 * most_own(faults),
                      commands[i].late ? " (late by design)" : "");
        slowest = commands[i].late ? slowest : fmax(slowest, most_own(faults));
    }
    print_message("own: without waiting for a CPU\n");
    return slowest;
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* The median of samples[first..last). */
static double median_kib(const soak *s, size_t first, size_t last)
{
    static double values[MAX_SAMPLES];
    size_t n = 0;
    for (size_t i = first; i < last; i++)
        values[n++] = s->samples[i].kib;
    qsort(values, n, sizeof *values, compare_doubles);
    return n > 0 ? values[n / 2] : 0;
}

/* KiB a minute, by least squares. */
static double slope_kib(const soak *s, size_t first, size_t last)
{
    double n = (double)(last - first), t = 0, y = 0, tt = 0, ty = 0;
    for (size_t i = first; i < last; i++) {
        t += (s->samples[i].at - s->samples[first].at) / n;
        y += s->samples[i].kib / n;
    }
    for (size_t i = first; i < last; i++) {
        double d = s->samples[i].at - s->samples[first].at - t;
        tt += d * d;
        ty += d * (s->samples[i].kib - y);
    }
    return tt > 0 ? 60 * ty / tt : 0;
}

/* Prints what memory did; its growth. */
static double report_memory(const soak *s)
{
    size_t n = s->n_samples, warm = (size_t)(WARM_SHARE * (double)n), tenth = n / 10 + 1;
    assert_true(n > 20);
    double begin = median_kib(s, warm, warm + tenth), end = median_kib(s, n - tenth, n);
    print_message(
        "RSS: %.1f MiB at the beginning (warm), %.1f at the end, slope %+.2f MiB a minute\n",
        begin / 1024, end / 1024, slope_kib(s, warm, n) / 1024);
    return end - begin;
}

static void report_rendering(const soak *s)
{
    double quiet = s->passes[QUIET] / s->seconds[QUIET],
           faults = s->passes[FAULTS] / s->seconds[FAULTS];
    print_message(
        "passes a second: %.0f without faults, %.0f with (%.2f); longest without one %.2f s\n",
        quiet, faults, faults / quiet, s->progress.longest_s);
}

static void report_faults(void)
{
    print_message("displays opened %llu, rectangles shown %llu, EEPROM pages %llu, presses %llu; ",
                  (unsigned long long)orders->opened, (unsigned long long)orders->rects,
                  (unsigned long long)orders->pages, (unsigned long long)orders->presses);
    for (int i = 0; i < LF_FAULTY_KINDS; i++)
        print_message("%s %llu%s", lf_faulty_name((lf_faulty_kind)i),
                      (unsigned long long)orders->struck[i], i + 1 < LF_FAULTY_KINDS ? ", " : "\n");
}

/* -------------------------------------------------------------------------------------- test -- */

static void prepare(soak *s)
{
    char cache[PATH_MAX];
    const char *seed = getenv("SOAK_SEED");
    live_prepare(&s->l);
    lf_test_write(s->l.folder, "scene/mist.json", LIVE_SCENE);
    lf_test_write(s->l.folder, "scene/broken.json", "{\"quiltd\":1,");
    assert_int_equal(mkdir(s->l.exports, 0700), 0);
    snprintf(cache, sizeof cache, "%s/cache", s->l.folder);
    setenv("XDG_CACHE_HOME", cache, 1);
    int fd = memfd_create("orders", 0);
    assert_int_equal(ftruncate(fd, sizeof *orders), 0);
    map_orders(fd);
    assert_ptr_not_equal(orders, MAP_FAILED);
    orders->seed = seed ? strtoull(seed, NULL, 10) : lf_test_seed();
    s->l.pid = start_server(&s->l, fd);
    close(fd);
}

/* Faults for most of the time, then none. */
static void run(soak *s, holdings *out_before, holdings *out_after)
{
    double seconds = wanted_seconds();
    open_panel(s);
    open_waits(s);
    *out_before = settled_holdings(s, NULL);
    run_phase(s, QUIET, QUIET_SHARE * seconds);
    take_last_answers(s);
    atomic_store(&orders->sick, true);
    run_phase(s, FAULTS, (1 - QUIET_SHARE) * seconds);
    atomic_store(&orders->sick, false);
    take_last_answers(s);
    open_panel(s);
    *out_after = settled_holdings(s, out_before);
}

static void faults_stop_nothing_and_leave_nothing(void **state)
{
    (void)state;
    static soak s;
    holdings before, after;
    prepare(&s);
    print_message("SOAK_SEED=%llu, %g s\n", (unsigned long long)orders->seed, wanted_seconds());
    live_connect(&s.l, &s.c);
    run(&s, &before, &after);
    double slowest = report_latencies(&s);
    double growth = report_memory(&s);
    report_rendering(&s);
    report_faults();
    print_message("descriptors %d before, %d after; threads %d, %d\n", before.descriptors,
                  after.descriptors, before.threads, after.threads);
    close_waits(&s);
    live_close(&s.c);
    assert_int_equal(live_stop(&s.l), 0);
    live_finish(&s.l);
    assert_true(orders->opened > 2 && orders->rects > 0 && orders->pages > 0);
    assert_int_equal(orders->violations, 0);
    assert_true(s.passes[FAULTS] > 0);
    assert_true(growth < GROWTH_KIB);
    assert_int_equal(after.descriptors, before.descriptors);
    assert_int_equal(after.threads, before.threads);
    if (getenv("SOAK_STRICT"))
        assert_true(slowest <= PROMPT_SECONDS);
    munmap(orders, sizeof *orders);
}

int main(int argc, char *argv[])
{
    if (argc > 1)
        return run_server(argv);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(faults_stop_nothing_and_leave_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
