/* Clients of random bytes against a daemon that renders: it goes on serving, and neither memory nor
 * descriptors grow. A few seconds; a minute under make verify. */
#include "tests/daemon/live.h"

#include <dirent.h>

enum { N_CLIENTS = 10 };

/* AddressSanitizer keeps what was freed for a while (and finds leaks by itself at the end). */
#ifdef __SANITIZE_ADDRESS__
enum { GROWTH_KIB = 512 * 1024 };
#else
enum { GROWTH_KIB = 32 * 1024 };
#endif

static uint64_t next_random(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

static int count_descriptors(pid_t pid)
{
    char path[64];
    snprintf(path, sizeof path, "/proc/%d/fd", (int)pid);
    DIR *folder = opendir(path);
    assert_non_null(folder);
    int n = 0;
    while (readdir(folder))
        n++;
    closedir(folder);
    return n;
}

/* Bytes that are noise, or look like a request for a while. */
static size_t make_garbage(char *out, size_t size, uint64_t *state)
{
    static const char *const pieces[] = {
        "{\"jsonrpc\":\"2.0\",",  "\"id\":1,", "\"method\":\"status\"",
        "\"method\":\"export\",", "}\n",       "{\"a\":[[[[",
        "\"params\":{",           "\n",        "\"file\":\"../x.png\"",
        "\"kind\":\"panel\","};
    size_t n = 0;
    while (n + 64 < size) {
        if (next_random(state) % 3 == 0) {
            out[n++] = (char)next_random(state);
            continue;
        }
        const char *piece = pieces[next_random(state) % (sizeof pieces / sizeof *pieces)];
        memcpy(out + n, piece, strlen(piece));
        n += strlen(piece);
    }
    return n;
}

/* One round: every client sends garbage, some read what comes back, some hang up in the middle. */
static void run_round(const live *l, int *fds, uint64_t *state)
{
    char bytes[4096];
    for (int i = 0; i < N_CLIENTS; i++) {
        if (fds[i] < 0) {
            fds[i] = live_connect_fd(l);
            assert_true(fds[i] >= 0);
        }
        size_t n = make_garbage(bytes, 64 + next_random(state) % (sizeof bytes - 64), state);
        bool alive = send(fds[i], bytes, n, MSG_NOSIGNAL | MSG_DONTWAIT) > 0 || errno == EAGAIN;
        if (i % 2 == 0) {
            while (recv(fds[i], bytes, sizeof bytes, MSG_DONTWAIT) > 0) {
            }
        }
        if (!alive || next_random(state) % 50 == 0) {
            close(fds[i]);
            fds[i] = -1;
        }
    }
}

static void run_for(const live *l, double seconds, uint64_t *state)
{
    int fds[N_CLIENTS];
    struct timespec begin, now;
    clock_gettime(CLOCK_MONOTONIC, &begin);
    for (int i = 0; i < N_CLIENTS; i++)
        fds[i] = -1;
    do {
        run_round(l, fds, state);
        clock_gettime(CLOCK_MONOTONIC, &now);
    } while ((double)(now.tv_sec - begin.tv_sec) + 1e-9 * (double)(now.tv_nsec - begin.tv_nsec) <
             seconds);
    for (int i = 0; i < N_CLIENTS; i++)
        if (fds[i] >= 0)
            close(fds[i]);
}

/* Until the daemon has noticed that all clients but this one have gone, and for long enough that
 * none of those was still waiting to be accepted. */
static void wait_until_alone(live_client *c)
{
    int alone = 0;
    for (int i = 0; i < LIVE_PATIENCE_S * 50 && alone < 25; i++) {
        alone = live_number(c, "status", NULL, "clients") == 1 ? alone + 1 : 0;
        live_nap(20);
    }
    assert_int_equal(alone, 25);
}

static void random_bytes_from_ten_clients_change_nothing(void **state)
{
    (void)state;
    live l;
    uint64_t random = lf_test_seed() | 1;
    double seconds = lf_test_long() ? 60 : 2;
    live_prepare(&l);
    live_start(&l, l.scene, "--device", l.sim, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "complete");
    run_for(&l, seconds / 2, &random);
    wait_until_alone(&c);
    int descriptors = count_descriptors(l.pid);
    long kib = live_resident_kib(&l);
    run_for(&l, seconds, &random);
    wait_until_alone(&c);
    /* The panel may be writing a picture at either moment. */
    assert_true(count_descriptors(l.pid) <= descriptors + 3);
    assert_true(live_resident_kib(&l) < kib + GROWTH_KIB);
    assert_int_equal(live_code(&c, "camera.orbit", json_pack("{s:i}", "yaw", 5)), 0);
    live_wait(&c, "coarse");
    live_close(&c);
    live_finish(&l);
}

/* kill -9 while it exports and saves: no broken file, no state that stops the next start. */
static void killed_at_any_moment_it_leaves_nothing_broken(void **state)
{
    (void)state;
    live l;
    uint64_t random = lf_test_seed() | 1;
    int rounds = lf_test_long() ? 200 : 8;
    live_prepare(&l);
    for (int i = 0; i < rounds; i++) {
        live_start(&l, l.scene, "--device", l.sim, "--state", l.state, NULL);
        live_client c;
        live_connect(&l, &c);
        live_wait(&c, "coarse");
        json_t *params = json_pack("{s:s, s:s, s:b}", "kind", i % 2 == 0 ? "panel" : "state",
                                   "file", i % 2 == 0 ? "p.png" : "s.lfstate", "overwrite", 1);
        assert_int_equal(live_code(&c, "export", params), 0);
        live_nap((long)(next_random(&random) % 40));
        kill(l.pid, SIGKILL);
        assert_int_equal(live_reap(l.pid), 128 + SIGKILL);
        l.pid = 0;
        live_close(&c);
    }
    /* What is there is whole: no leftovers beside it once the same name is written again. */
    live_start(&l, l.scene, "--device", l.sim, "--state", l.state, NULL);
    live_client c;
    live_connect(&l, &c);
    live_wait(&c, "coarse");
    json_t *params = json_pack("{s:s, s:s, s:b}", "kind", "panel", "file", "p.png", "overwrite", 1);
    json_int_t job = (json_int_t)live_number(&c, "export", params, "job");
    assert_string_equal(live_job_end(&c, job), "done");
    live_close(&c);
    DIR *folder = opendir(l.exports);
    assert_non_null(folder);
    for (const struct dirent *entry = readdir(folder); entry; entry = readdir(folder))
        assert_null(strstr(entry->d_name, ".p.png.quiltd-"));
    closedir(folder);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_bytes_from_ten_clients_change_nothing),
        cmocka_unit_test(killed_at_any_moment_it_leaves_nothing_broken),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
