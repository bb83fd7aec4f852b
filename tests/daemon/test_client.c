/* Clients of a socket and their turns: so many lines, so many bytes, and then whoever else is
 * ready; what was left comes later, though nothing more is read. On one thread, with an event loop
 * of the test's own. */
#include "tests/testing.h"

#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include "base/alloc.h"
#include "daemon/threads/turns.h"
#include "daemon/wire/client.h"

/* As daemon/wire/client.c has them. */
enum { LINES = 16, BYTES = 65536 };

/* FEW: answers that a connection holds before anybody reads them */
enum { FEW = 200, MANY = 1000, CLIENTS = 10, ORDER = 20000 };

typedef struct bench {
    sd_event *event;
    lf_clients *clients;
    char *folder;
    struct sockaddr_un address;
    uint64_t order[ORDER]; /* whose lines were handed over, by their serials */
    int n;
    size_t answer;  /* bytes that each line is answered */
    uint64_t pause; /* at the first line of this one */
    int stopped_at; /* lines that were handed over when TERM came; -1: it has not */
    int n_held, fd;
} bench;

/* "fd" takes a descriptor, "hold" is a call without an answer. */
static void on_line(void *context, lf_client *client, const char *line, size_t n)
{
    bench *b = context;
    size_t held;
    assert_true(b->n < ORDER);
    b->order[b->n++] = lf_client_serial(client);
    if (n >= 4 && memcmp(line, "hold", 4) == 0)
        b->n_held += lf_client_hold(client, &held);
    if (n == 2 && memcmp(line, "fd", 2) == 0)
        assert_true(lf_client_take_fds(client, &b->fd, 1));
    if (b->pause == lf_client_serial(client)) {
        lf_client_pause(client);
        b->pause = 0;
    }
    if (b->answer > 0) {
        char *answer = memset(lf_calloc(b->answer, 1), 'x', b->answer);
        lf_client_send_text(client, answer, b->answer);
        lf_free(answer);
    }
}

static int on_term(sd_event_source *source, const struct signalfd_siginfo *info, void *context)
{
    bench *b = context;
    (void)source;
    (void)info;
    b->stopped_at = b->n;
    return 0;
}

static void begin(bench *b)
{
    *b = (bench){.folder = lf_test_folder(), .stopped_at = -1, .fd = -1};
    b->address.sun_family = AF_UNIX;
    snprintf(b->address.sun_path, sizeof b->address.sun_path, "%.90s/s", b->folder);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    assert_int_equal(bind(fd, (const struct sockaddr *)&b->address, sizeof b->address), 0);
    assert_int_equal(listen(fd, 64), 0);
    assert_true(sd_event_new(&b->event) >= 0);
    assert_int_equal(lf_clients_create(b->event, fd, on_line, b, &b->clients), LF_OK);
}

static void finish(bench *b)
{
    lf_clients_destroy(b->clients);
    sd_event_unref(b->event);
    lf_test_folder_remove(b->folder);
}

/* Turns of the loop until there is nothing to do; a timer that is due fires a little later. */
static void settle(const bench *b)
{
    while (sd_event_run(b->event, 10000) > 0)
        continue;
}

/* A connection that was accepted. */
static int join(const bench *b)
{
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0), size = 4 << 20;
    struct timeval patience = {.tv_sec = 60};
    (void)setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    assert_int_equal(connect(fd, (const struct sockaddr *)&b->address, sizeof b->address), 0);
    (void)setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &size, sizeof size);
    settle(b);
    return fd;
}

/* n lines in one write. */
static void write_lines(int fd, const char *line, int n)
{
    size_t length = strlen(line);
    char *text = lf_calloc((size_t)n, length), *at = text;
    for (int i = 0; i < n; i++, at += length)
        memcpy(at, line, length);
    assert_int_equal(send(fd, text, (size_t)n * length, 0), (int)((size_t)n * length));
    lf_free(text);
}

/* How many lines were handed over before the first of this client. */
static int before(const bench *b, uint64_t serial)
{
    int i = 0;
    while (i < b->n && b->order[i] != serial)
        i++;
    return i;
}

/* How many lines of this client were handed over in its first turn. */
static int first_turn(const bench *b, uint64_t serial)
{
    int from = before(b, serial), n = 0;
    while (from + n < b->n && b->order[from + n] == serial)
        n++;
    return n;
}

static void another_waits_for_no_more_than_a_turn(void **state)
{
    (void)state;
    bench *b = malloc(sizeof *b);
    begin(b);
    int hostile = join(b), honest = join(b);
    write_lines(hostile, "a\n", MANY);
    write_lines(honest, "b\n", 1);
    settle(b);
    assert_int_equal(b->n, MANY + 1); /* the rest came without another byte */
    assert_int_equal(before(b, 2), LINES);
    assert_int_equal(lf_clients_lines(b->clients), MANY + 1);
    close(hostile);
    close(honest);
    finish(b);
    free(b);
}

static void nor_for_more_than_a_turn_of_each_of_ten(void **state)
{
    (void)state;
    bench *b = malloc(sizeof *b);
    int fd[CLIENTS], honest;
    begin(b);
    for (int i = 0; i < CLIENTS; i++)
        fd[i] = join(b);
    honest = join(b);
    for (int i = 0; i < CLIENTS; i++)
        write_lines(fd[i], "a\n", MANY);
    /* more lines than one turn has: each turn of it waits for one of each of the others */
    write_lines(honest, "b\n", 2 * LINES);
    settle(b);
    assert_int_equal(b->n, CLIENTS * MANY + 2 * LINES);
    assert_true(before(b, CLIENTS + 1) <= CLIENTS * LINES);
    int last = 0;
    for (int i = 0; i < b->n; i++)
        last = b->order[i] == CLIENTS + 1 ? i : last;
    assert_true(last < 2 * (CLIENTS + 1) * LINES);
    for (int i = 0; i < CLIENTS; i++)
        close(fd[i]);
    close(honest);
    finish(b);
    free(b);
}

static void a_turn_has_so_many_bytes_of_lines_and_of_answers(void **state)
{
    (void)state;
    bench *b = malloc(sizeof *b);
    static char line[BYTES / 8];
    begin(b);
    int hostile = join(b), honest = join(b), other = join(b);
    memset(line, 'a', sizeof line - 2);
    line[sizeof line - 2] = '\n';
    write_lines(hostile, line, 7);
    b->answer = BYTES / 4;
    write_lines(other, "c\n", LINES);
    write_lines(honest, "b\n", 1);
    settle(b);
    assert_int_equal(b->n, 7 + LINES + 1);
    /* line and answer: three eighths of a turn; the answer alone: a quarter, less the newline */
    assert_int_equal(first_turn(b, 1), 3);
    assert_int_equal(first_turn(b, 3), 4);
    assert_true(before(b, 2) <= 3 + 4);
    close(hostile);
    close(honest);
    close(other);
    finish(b);
    free(b);
}

static void who_has_ended_is_still_worked_for(void **state)
{
    (void)state;
    bench *b = malloc(sizeof *b);
    char text[4096];
    size_t got = 0;
    begin(b);
    b->answer = 1;
    int half = join(b);
    write_lines(half, "a\n", FEW);
    assert_int_equal(shutdown(half, SHUT_WR), 0);
    settle(b);
    assert_int_equal(b->n, FEW);
    for (ssize_t n; (n = recv(half, text, sizeof text, 0)) > 0;)
        got += (size_t)n;
    assert_int_equal(got, 2 * FEW); /* each answer with its newline, and then the end */
    close(half);
    assert_int_equal(lf_clients_count(b->clients), 0);
    b->answer = 0;
    int gone = join(b);
    write_lines(gone, "a\n", FEW);
    close(gone);
    settle(b);
    assert_int_equal(b->n, 2 * FEW);
    assert_int_equal(lf_clients_count(b->clients), 0);
    finish(b);
    free(b);
}

static void write_with_fd(int to, const char *text, int fd)
{
    union {
        struct cmsghdr align;
        char bytes[CMSG_SPACE(sizeof(int))];
    } control = {0};
    struct iovec vector = {.iov_base = (void *)(uintptr_t)text, .iov_len = strlen(text)};
    struct msghdr message = {.msg_iov = &vector,
                             .msg_iovlen = 1,
                             .msg_control = &control,
                             .msg_controllen = sizeof control};
    struct cmsghdr *c = CMSG_FIRSTHDR(&message);
    c->cmsg_level = SOL_SOCKET;
    c->cmsg_type = SCM_RIGHTS;
    c->cmsg_len = CMSG_LEN(sizeof fd);
    memcpy(CMSG_DATA(c), &fd, sizeof fd);
    assert_int_equal(sendmsg(to, &message, 0), (int)strlen(text));
}

static void a_descriptor_comes_with_its_line(void **state)
{
    (void)state;
    bench *b = malloc(sizeof *b);
    begin(b);
    int c = join(b), end[2];
    assert_int_equal(pipe(end), 0);
    write_lines(c, "a\n", 3 * LINES);
    write_with_fd(c, "fd\n", end[1]);
    write_lines(c, "a\n", 3 * LINES);
    settle(b);
    assert_int_equal(b->n, 6 * LINES + 1);
    assert_true(b->fd >= 0);
    assert_int_equal(write(b->fd, "x", 1), 1);
    close(b->fd);
    /* the same behind a line that takes its time, and many that follow in the same turn */
    b->pause = 1;
    write_with_fd(c, "fd\n", end[1]);
    b->fd = -1;
    settle(b);
    assert_true(b->fd >= 0);
    lf_client_resume(lf_clients_find(b->clients, 1));
    /* one that nobody takes is closed: the pipe has no end any more */
    close(b->fd);
    write_with_fd(c, "a\n", end[1]);
    settle(b);
    close(end[1]);
    char byte[2];
    assert_int_equal(read(end[0], byte, 2), 1);
    assert_int_equal(read(end[0], byte, 2), 0);
    close(end[0]);
    close(c);
    finish(b);
    free(b);
}

static ino_t inode_of(int fd)
{
    struct stat info;
    assert_int_equal(fstat(fd, &info), 0);
    return info.st_ino;
}

/* A line that comes in two parts, the first with a descriptor that it does not take, is received
 * together with the next line, which has a descriptor of its own. */
static void a_line_does_not_get_the_descriptor_of_the_line_before(void **state)
{
    (void)state;
    bench *b = malloc(sizeof *b);
    begin(b);
    int c = join(b), left[2], own[2];
    for (uint64_t pause = 0; pause < 2; pause++) {
        assert_int_equal(pipe(left), 0);
        assert_int_equal(pipe(own), 0);
        b->pause = pause;
        write_with_fd(c, "a", left[1]);
        write_lines(c, "a\n", 1);
        write_with_fd(c, "fd\n", own[1]);
        settle(b);
        if (pause) {
            assert_int_equal(b->fd, -1);
            lf_client_resume(lf_clients_find(b->clients, 1));
            settle(b);
        }
        assert_true(b->fd >= 0);
        assert_int_equal(inode_of(b->fd), inode_of(own[1]));
        close(b->fd);
        b->fd = -1;
        /* the other one is closed */
        char byte;
        close(left[1]);
        assert_int_equal(read(left[0], &byte, 1), 0);
        close(left[0]);
        close(own[0]);
        close(own[1]);
    }
    close(c);
    finish(b);
    free(b);
}

static void term_comes_between_turns(void **state)
{
    (void)state;
    bench *b = malloc(sizeof *b);
    sigset_t term;
    begin(b);
    sigemptyset(&term);
    sigaddset(&term, SIGTERM);
    assert_int_equal(sigprocmask(SIG_BLOCK, &term, NULL), 0);
    assert_true(sd_event_add_signal(b->event, NULL, SIGTERM, on_term, b) >= 0);
    int hostile = join(b);
    write_lines(hostile, "a\n", MANY);
    assert_int_equal(raise(SIGTERM), 0);
    settle(b);
    assert_true(b->stopped_at >= 0 && b->stopped_at <= LINES);
    assert_int_equal(b->n, MANY);
    close(hostile);
    finish(b);
    free(b);
}

static void lines_wait_while_one_takes_its_time(void **state)
{
    (void)state;
    bench *b = malloc(sizeof *b);
    begin(b);
    int c = join(b), other = join(b);
    b->pause = 1;
    write_lines(c, "a\n", MANY);
    settle(b);
    assert_int_equal(b->n, 1);
    write_lines(other, "b\n", 1);
    settle(b);
    assert_int_equal(b->n, 2);
    lf_client_resume(lf_clients_find(b->clients, 1));
    settle(b);
    assert_int_equal(b->n, MANY + 1);
    /* one that goes meanwhile waits for the end of that line, and its others are worked off */
    b->pause = 1;
    write_lines(c, "a\n", 3);
    close(c);
    settle(b);
    assert_int_equal(b->n, MANY + 2);
    assert_non_null(lf_clients_find(b->clients, 1));
    lf_client_resume(lf_clients_find(b->clients, 1));
    settle(b);
    assert_int_equal(b->n, MANY + 4);
    assert_null(lf_clients_find(b->clients, 1));
    close(other);
    finish(b);
    free(b);
}

/* A line of n bytes. */
static void write_hold(const bench *b, int fd, size_t n)
{
    char *line = lf_calloc(n + 2, 1);
    memcpy(memset(line, 'a', n), "hold", 4);
    line[n] = '\n';
    for (size_t at = 0; at < n + 1;) {
        ssize_t done = send(fd, line + at, n + 1 - at < BYTES ? n + 1 - at : BYTES, 0);
        assert_true(done > 0);
        at += (size_t)done;
        settle(b);
    }
    lf_free(line);
}

/* Calls that wait are parsed already, and much larger than their lines. */
static void lines_of_calls_that_wait_have_a_limit_for_all_clients(void **state)
{
    (void)state;
    bench *b = malloc(sizeof *b);
    int fd[6];
    begin(b);
    for (int i = 0; i < 6; i++)
        fd[i] = join(b);
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 4; k++)
            write_hold(b, fd[i], LF_RPC_MAX_LINE);
    assert_int_equal(b->n_held, 16);
    write_hold(b, fd[4], LF_RPC_MAX_LINE); /* 16 MiB there are */
    assert_int_equal(b->n_held, 16);
    write_hold(b, fd[4], 60000); /* a modest one is always served */
    write_hold(b, fd[5], 4);
    assert_int_equal(b->n_held, 18);
    /* what a client holds is there until it is released, though the client goes before */
    assert_false(lf_clients_left_much(b->clients));
    close(fd[0]);
    settle(b);
    assert_null(lf_clients_find(b->clients, 1));
    assert_true(lf_clients_left_much(b->clients));
    write_hold(b, fd[5], LF_RPC_MAX_LINE);
    assert_int_equal(b->n_held, 18);
    for (int i = 0; i < 4; i++)
        lf_clients_release(b->clients, 1, LF_RPC_MAX_LINE);
    assert_false(lf_clients_left_much(b->clients));
    write_hold(b, fd[5], LF_RPC_MAX_LINE);
    assert_int_equal(b->n_held, 19);
    fd[0] = join(b);
    for (int i = 0; i < 6; i++)
        close(fd[i]);
    finish(b);
    free(b);
}

static void calls_that_wait_have_a_limit_for_all_clients(void **state)
{
    (void)state;
    bench *b = malloc(sizeof *b);
    begin(b);
    int one = join(b), two = join(b);
    for (int i = 0; i < LF_MAX_CLIENT_CALLS / 1024; i++) {
        write_lines(one, "hold\n", 1024);
        settle(b);
    }
    write_lines(one, "hold\n", 1);
    settle(b);
    assert_int_equal(b->n_held, LF_MAX_CLIENT_CALLS);
    write_lines(two, "hold\n", 100);
    settle(b);
    assert_int_equal(b->n_held, LF_MAX_CLIENT_CALLS + 64);
    close(one);
    close(two);
    finish(b);
    free(b);
}

/* ----------------------------------------------------------------------- how long turns take -- */

static double cpu_seconds(void)
{
    struct timespec now;
    assert_int_equal(clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now), 0);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

typedef struct turns {
    double longest, spent; /* as told; of CPU time by the longest handler */
    int left;
} turns;

/* Works, and then sleeps, which does not count. */
static int on_time(sd_event_source *source, uint64_t usec, void *context)
{
    turns *t = context;
    double begun = cpu_seconds(), now = begun;
    (void)usec;
    while (now < begun + 2e-3 * t->left)
        now = cpu_seconds();
    t->spent = fmax(t->spent, now - begun);
    nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL);
    if (--t->left == 0)
        return sd_event_exit(sd_event_source_get_event(source), 7);
    return sd_event_source_set_enabled(source, SD_EVENT_ONESHOT);
}

static void the_longest_turn_is_told_in_cpu_time(void **state)
{
    (void)state;
    sd_event *event;
    turns t = {.left = 5};
    assert_true(sd_event_new(&event) >= 0);
    assert_true(sd_event_add_time(event, NULL, CLOCK_MONOTONIC, 0, 1, on_time, &t) >= 0);
    double begun = cpu_seconds();
    assert_int_equal(lf_turns_run(event, &t.longest), 7);
    double all = cpu_seconds() - begun;
    assert_true(t.longest >= t.spent);
    assert_true(t.longest <= all - 2e-3 * (1 + 2 + 3 + 4)); /* the other four are not in it */
    sd_event_unref(event);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(another_waits_for_no_more_than_a_turn),
        cmocka_unit_test(nor_for_more_than_a_turn_of_each_of_ten),
        cmocka_unit_test(a_turn_has_so_many_bytes_of_lines_and_of_answers),
        cmocka_unit_test(who_has_ended_is_still_worked_for),
        cmocka_unit_test(a_descriptor_comes_with_its_line),
        cmocka_unit_test(a_line_does_not_get_the_descriptor_of_the_line_before),
        cmocka_unit_test(term_comes_between_turns),
        cmocka_unit_test(lines_wait_while_one_takes_its_time),
        cmocka_unit_test(lines_of_calls_that_wait_have_a_limit_for_all_clients),
        cmocka_unit_test(calls_that_wait_have_a_limit_for_all_clients),
        cmocka_unit_test(the_longest_turn_is_told_in_cpu_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
