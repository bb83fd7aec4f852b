/* The Unix socket of programs: frames as nng's ipc has them, clients that are wrong, slow or too
 * many, and names that belong to somebody else. */
#include "tests/web/told_quiltd.h"

#include <sys/stat.h>

#include "daemon/web/nng.h"
#include "daemon/wire/listen.h"
#include "tests/web/sp.h"

enum { ID = (int)0xcaba09e5u, LIMIT = 1 << 20 };

static const uint8_t greeting[] = {0, 'S', 'P', 0, 0, 0x30, 0, 0};

typedef struct home {
    char *folder, path[108];
    lf_listener listener;
    lf_driver *driver;
    lf_nng *nng;
} home;

static home begin_before(const char *quiltd)
{
    home h = {.folder = lf_test_folder()};
    lf_error err = {0};
    int fd = -1;
    const lf_driver_config config = {
        .event = event, .socket = quiltd, .version = "2.6.3", .image_limit = LIMIT};
    assert_true(snprintf(h.path, sizeof h.path, "%s/nng", h.folder) < (int)sizeof h.path);
    lf_assert_ok(lf_listen_at(h.path, "--nng=PATH", &h.listener, &fd, &err), &err);
    lf_assert_ok(lf_driver_create(&config, &h.driver, &err), &err);
    lf_assert_ok(lf_nng_create(event, fd, h.driver, &h.nng, &err), &err);
    return h;
}

static home begin(void)
{
    return begin_before("/nowhere");
}

static void end(home *h)
{
    lf_nng_destroy(h->nng);
    lf_driver_destroy(h->driver);
    lf_unlisten(&h->listener);
    lf_test_folder_remove(h->folder);
}

static int connect_client(const home *h)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    memcpy(address.sun_path, h->path, sizeof h->path);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    assert_int_equal(connect(fd, (const struct sockaddr *)&address, sizeof address), 0);
    lf_clock_settle(event);
    return fd;
}

static void put(int fd, const uint8_t *data, size_t n)
{
    for (size_t at = 0; at < n;) {
        const ssize_t sent = send(fd, data + at, n - at, MSG_DONTWAIT | MSG_NOSIGNAL);
        at += sent > 0 ? (size_t)sent : 0;
        assert_true(sent > 0 || errno == EAGAIN);
        lf_clock_settle(event);
    }
}

/* One that has greeted, and was greeted. */
static int greet(const home *h)
{
    static const uint8_t expected[] = {0, 'S', 'P', 0, 0, 0x31, 0, 0};
    uint8_t got[16];
    int fd = connect_client(h);
    put(fd, greeting, sizeof greeting);
    assert_int_equal(recv(fd, got, sizeof got, MSG_DONTWAIT), sizeof expected);
    assert_memory_equal(got, expected, sizeof expected);
    return fd;
}

/* With its head. */
static uint8_t *frame(uint32_t id, const char *cmd, size_t *out_n)
{
    size_t n = 0;
    uint8_t *message = sp_request(id, cmd, NULL, 0, &n), *framed = calloc(n + 9, 1);
    assert_non_null(framed);
    framed[0] = 1;
    for (int i = 0; i < 8; i++)
        framed[1 + i] = (uint8_t)((uint64_t)n >> (56 - 8 * i));
    memcpy(framed + 9, message, n);
    free(message);
    *out_n = n + 9;
    return framed;
}

/* The error of the next answer. */
static int take_error(int fd, uint32_t id)
{
    uint8_t head[9], body[4096];
    size_t n = 0;
    lf_clock_settle(event);
    assert_int_equal(recv(fd, head, sizeof head, MSG_DONTWAIT), sizeof head);
    assert_int_equal(head[0], 1);
    for (int i = 1; i < 9; i++)
        n = n << 8 | head[i];
    assert_true(n <= sizeof body);
    assert_int_equal(recv(fd, body, n, MSG_DONTWAIT), (ssize_t)n);
    json_t *answer = sp_answer(id, body, n);
    const int error = sp_error(answer);
    json_decref(answer);
    return error;
}

/* The bytes that nngcat has sent, in parts. */
static void the_least_request_is_answered(void **state)
{
    (void)state;
    static const uint8_t sent[] = {1,    0,    0,    0,    0,    0,    0,   0,   0x15, 0xca,
                                   0xba, 0x09, 0xe5, 0xa2, 0x63, 'c',  'm', 'd', 0xa1, 0x64,
                                   'i',  'n',  'f',  'o',  0xa0, 0x63, 'b', 'i', 'n',  0x60};
    home h = begin();
    for (size_t step = 1; step <= sizeof sent; step += 7) {
        int fd = greet(&h);
        for (size_t at = 0; at < sizeof sent; at += step)
            put(fd, sent + at, sizeof sent - at < step ? sizeof sent - at : step);
        assert_int_equal(take_error(fd, (uint32_t)ID), LF_DRIVER_FAILED); /* no quiltd */
        close(fd);
    }
    lf_clock_settle(event);
    assert_int_equal(lf_nng_clients(h.nng), 0);
    end(&h);
}

/* AliceLG does not wait for the answer to show. */
static void requests_may_follow_each_other(void **state)
{
    (void)state;
    home h = begin();
    uint8_t all[4096];
    size_t used = 0;
    int fd = greet(&h);
    for (uint32_t i = 0; i < 40; i++) {
        size_t n = 0;
        uint8_t *next = frame((uint32_t)ID + i, "{\"init\": {}}", &n);
        memcpy(all + used, next, n);
        used += n;
        free(next);
    }
    put(fd, all, used);
    for (uint32_t i = 0; i < 40; i++)
        assert_int_equal(take_error(fd, (uint32_t)ID + i), LF_DRIVER_NONE);
    close(fd);
    end(&h);
}

/* It sends on and on, and reads nothing: what cannot be delivered is dropped, and others go on. */
static void a_client_that_does_not_read_stays_harmless(void **state)
{
    (void)state;
    home h = begin();
    size_t n = 0;
    int deaf = greet(&h), other = greet(&h);
    uint8_t *next = frame((uint32_t)ID, "{\"init\": {}}", &n);
    for (int i = 0; i < 20000; i++) {
        const ssize_t sent = send(deaf, next, n, MSG_DONTWAIT | MSG_NOSIGNAL);
        assert_true(sent == (ssize_t)n || (sent < 0 && errno == EAGAIN));
        if (sent < 0)
            lf_clock_settle(event);
    }
    lf_clock_settle(event);
    put(other, next, n);
    assert_int_equal(take_error(other, (uint32_t)ID), LF_DRIVER_NONE);
    assert_true(is_open(other));
    assert_true(drain(deaf) > 0);
    lf_clock_settle(event);
    (void)drain(deaf);
    put(deaf, next, n);
    lf_clock_settle(event);
    assert_true(drain(deaf) > 0); /* it is answered again */
    free(next);
    close(deaf);
    close(other);
    end(&h);
}

static void check_dropped(const uint8_t *data, size_t n, bool greeted)
{
    home h = begin();
    int fd = greeted ? greet(&h) : connect_client(&h);
    put(fd, data, n);
    lf_clock_settle(event);
    (void)drain(fd);
    assert_false(is_open(fd));
    assert_int_equal(lf_nng_clients(h.nng), 0);
    close(fd);
    end(&h);
}

static void other_protocols_are_dropped(void **state)
{
    (void)state;
    static const uint8_t greetings[][8] = {{0, 'S', 'P', 0, 0, 0x31, 0, 0},
                                           {0, 'S', 'P', 1, 0, 0x30, 0, 0},
                                           {1, 'S', 'P', 0, 0, 0x30, 0, 0},
                                           {0, 'S', 'P', 0, 0, 0x30, 0, 1},
                                           {'G', 'E', 'T', ' ', '/', ' ', 'H', 'T'}};
    static const uint8_t heads[][9] = {{0, 0, 0, 0, 0, 0, 0, 0, 4},
                                       {2, 0, 0, 0, 0, 0, 0, 0, 4},
                                       {1, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff},
                                       {1, 0, 0, 0, 1, 0, 0, 0, 0}};
    for (size_t i = 0; i < sizeof greetings / sizeof greetings[0]; i++)
        check_dropped(greetings[i], sizeof greetings[i], false);
    for (size_t i = 0; i < sizeof heads / sizeof heads[0]; i++)
        check_dropped(heads[i], sizeof heads[i], true);
}

/* 10 s for a greeting, 20 s for 64 KiB of a message, and any time between two messages. */
static void a_client_that_stands_still_is_dropped(void **state)
{
    (void)state;
    static uint8_t part[65536];
    static const uint8_t head[] = {1, 0,    0,    0,   0,   0,   0x10, 0, 0,    0x80, 0, 0,
                                   1, 0xa1, 0x63, 'b', 'i', 'n', 0x5a, 0, 0x0f, 0,    0};
    home h = begin();
    int silent = connect_client(&h), slow = greet(&h), moving = greet(&h), idle = greet(&h);
    put(slow, head, sizeof head);
    put(moving, head, sizeof head);
    (void)drain(silent);
    lf_clock_pass(event, 9.9);
    assert_true(is_open(silent));
    lf_clock_pass(event, 0.1);
    assert_false(is_open(silent));
    put(moving, part, sizeof part);
    lf_clock_pass(event, 9.9);
    assert_true(is_open(slow));
    lf_clock_pass(event, 0.1);
    assert_false(is_open(slow));
    assert_true(is_open(moving));
    assert_true(is_open(idle));
    lf_clock_pass(event, 3600);
    assert_true(is_open(idle));
    close(silent);
    close(slow);
    close(moving);
    close(idle);
    end(&h);
}

/* quiltd answers the next call, which must hold these words. */
static void answer_call(int listener, const char *words, const char *result)
{
    char line[256];
    int quiltd = accept(listener, NULL, NULL), fd = -1;
    assert_true(quiltd >= 0);
    limit_rights(quiltd);
    const char *call = hear(quiltd, &fd);
    if (!strstr(call, words))
        fail_msg("%s, expected %s", call, words);
    snprintf(line, sizeof line, "{\"jsonrpc\":\"2.0\",\"id\":\"quiltweb:fetch\",\"result\":%s}\n",
             result);
    say(quiltd, line);
    if (fd >= 0)
        close(fd);
    close(quiltd);
    lf_clock_settle(event);
}

/* Its next message stands still because a command of it runs: quiltd does not answer. */
static void a_client_that_waits_for_us_stays(void **state)
{
    (void)state;
    static const uint8_t head[] = {1, 0, 0, 0, 0, 0, 0x10, 0, 0, 0x80, 0, 0, 1};
    char *folder = lf_test_folder(), path[108];
    const int quiltd = listen_as_quiltd(folder, path);
    home h = begin_before(path);
    size_t n = 0;
    uint8_t *next = frame((uint32_t)ID, "{\"wipe\": {}}", &n);
    int fd = greet(&h);
    uint8_t both[256];
    memcpy(both, next, n);
    memcpy(both + n, head, sizeof head);
    put(fd, both, n + sizeof head); /* quiltweb reads them together */
    answer_call(quiltd, "device.calibration", "{}");
    lf_clock_pass(event, 59);
    assert_true(is_open(fd));
    lf_clock_pass(event, 1);
    assert_int_equal(take_error(fd, (uint32_t)ID), LF_DRIVER_FAILED);
    lf_clock_pass(event, 19);
    assert_true(is_open(fd));
    lf_clock_pass(event, 1);
    assert_false(is_open(fd));
    free(next);
    close(fd);
    end(&h);
    close(quiltd);
    lf_test_folder_remove(folder);
}

/* quiltd has the quilt at first, and shows it later. */
static void an_answer_waits_for_the_panel(void **state)
{
    (void)state;
    char *folder = lf_test_folder(), path[108];
    const int quiltd = listen_as_quiltd(folder, path);
    home h = begin_before(path);
    size_t n = 0;
    uint8_t *wipe = frame((uint32_t)ID, "{\"wipe\": {}}", &n);
    int fd = greet(&h);
    put(fd, wipe, n);
    answer_call(quiltd, "device.calibration", "{}");
    answer_call(quiltd, "quilt.show", "{\"generation\":9,\"warnings\":[]}");
    assert_true(is_open(fd)); /* and nothing came */
    answer_call(quiltd, "\"generation\":9,\"for\":\"coarse\"", "{\"generation\":9}");
    assert_int_equal(take_error(fd, (uint32_t)ID), LF_DRIVER_NONE);
    free(wipe);
    close(fd);
    end(&h);
    close(quiltd);
    lf_test_folder_remove(folder);
}

static void clients_are_bounded(void **state)
{
    (void)state;
    home h = begin();
    int fds[LF_DRIVER_MAX_CLIENTS];
    for (int i = 0; i < LF_DRIVER_MAX_CLIENTS; i++)
        fds[i] = greet(&h);
    int refused = connect_client(&h);
    assert_int_equal(drain(refused), 0); /* it is not even greeted */
    assert_false(is_open(refused));
    close(refused);
    close(fds[0]);
    lf_clock_settle(event);
    fds[0] = greet(&h);
    assert_int_equal(lf_nng_clients(h.nng), LF_DRIVER_MAX_CLIENTS);
    for (int i = 0; i < LF_DRIVER_MAX_CLIENTS; i++)
        close(fds[i]);
    end(&h);
}

/* An image of 1 MiB may come, one of more is skipped and told. */
static void a_large_image_is_skipped(void **state)
{
    (void)state;
    static uint8_t image[LIMIT + 1] = "\xff\xd8";
    static const char cmd[] = "{\"show\": {\"quilt\": {\"settings\": {\"vx\": 1, \"vy\": 1}}}}";
    home h = begin();
    int fd = greet(&h);
    for (size_t more = 0; more < 2; more++) {
        size_t n = 0;
        uint8_t *message = sp_request((uint32_t)ID, cmd, image, LIMIT + more, &n), head[9] = {1};
        for (int i = 0; i < 8; i++)
            head[1 + i] = (uint8_t)((uint64_t)n >> (56 - 8 * i));
        put(fd, head, sizeof head);
        put(fd, message, n);
        assert_int_equal(take_error(fd, (uint32_t)ID),
                         more ? LF_DRIVER_NO_IMAGE : LF_DRIVER_FAILED);
        free(message);
    }
    close(fd);
    end(&h);
}

static void the_socket_is_for_its_user_alone(void **state)
{
    (void)state;
    home h = begin();
    struct stat st;
    char path[108];
    memcpy(path, h.path, sizeof path);
    assert_int_equal(lstat(path, &st), 0);
    assert_int_equal(st.st_mode & 0777, 0600);
    lf_nng_destroy(h.nng);
    lf_driver_destroy(h.driver);
    lf_unlisten(&h.listener);
    assert_int_not_equal(lstat(path, &st), 0); /* our own goes with us */
    lf_test_folder_remove(h.folder);
}

static void check_name(const char *path, lf_status expected)
{
    lf_listener listener;
    lf_error err = {0};
    int fd = -1;
    lf_status status = lf_listen_at(path, "--nng=PATH", &listener, &fd, &err);
    if (status != expected)
        fail_msg("%d, expected %d: %s", status, expected, err.what);
    if (expected != LF_OK)
        assert_true(strstr(err.what, "--nng=PATH") || strstr(err.where, "--nng=PATH"));
    if (expected == LF_E_BUSY || expected == LF_E_EXISTS) {
        char lock[128];
        snprintf(lock, sizeof lock, "%s.lock", path);
        assert_int_not_equal(access(lock, F_OK), 0); /* in /tmp it would keep out others */
    }
    if (fd >= 0)
        close(fd);
    lf_unlisten(&listener);
}

/* A socket of ours that nobody listens at is replaced; everything else at the path stays. */
static void what_belongs_to_others_stays(void **state)
{
    (void)state;
    char *folder = lf_test_folder(), path[108];
    struct stat before, after;
    const int listening = listen_as_quiltd(folder, path);
    assert_int_equal(lstat(path, &before), 0);
    check_name(path, LF_E_BUSY);
    close(listening);
    if (geteuid() == 0) {
        assert_int_equal(lchown(path, 65534, 65534), 0);
        check_name(path, LF_E_EXISTS);
        assert_int_equal(lstat(path, &after), 0);
        assert_int_equal(after.st_ino, before.st_ino);
        assert_int_equal(lchown(path, 0, 0), 0);
    } else {
        print_message("not root: a socket of another user is not tested\n");
    }
    check_name(path, LF_OK);
    check_name("", LF_E_ARG); /* Linux would take it for a name without rights */
    lf_test_write(folder, "sock", "a file");
    check_name(path, LF_E_EXISTS);
    assert_int_equal(lstat(path, &after), 0);
    assert_true(S_ISREG(after.st_mode));
    assert_int_equal(unlink(path), 0);
    assert_int_equal(symlink("elsewhere", path), 0);
    check_name(path, LF_E_EXISTS);
    assert_int_equal(lstat(path, &after), 0);
    lf_test_folder_remove(folder);
}

static void a_socket_of_another_kind_is_refused(void **state)
{
    (void)state;
    lf_nng *nng = NULL;
    lf_driver *driver = NULL;
    lf_error err = {0};
    const lf_driver_config config = {
        .event = event, .socket = "/nowhere", .version = "", .image_limit = LIMIT};
    lf_assert_ok(lf_driver_create(&config, &driver, &err), &err);
    lf_assert_status(lf_nng_create(event, socket(AF_INET, SOCK_STREAM, 0), driver, &nng, &err),
                     LF_E_ARG, &err);
    lf_assert_status(lf_nng_create(event, socket(AF_UNIX, SOCK_STREAM, 0), driver, &nng, &err),
                     LF_E_ARG, &err);
    lf_driver_destroy(driver);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        timed(the_least_request_is_answered),
        timed(requests_may_follow_each_other),
        timed(a_client_that_does_not_read_stays_harmless),
        timed(other_protocols_are_dropped),
        timed(a_client_that_stands_still_is_dropped),
        timed(a_client_that_waits_for_us_stays),
        timed(an_answer_waits_for_the_panel),
        timed(clients_are_bounded),
        timed(a_large_image_is_skipped),
        timed(the_socket_is_for_its_user_alone),
        timed(what_belongs_to_others_stays),
        timed(a_socket_of_another_kind_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
