/* quiltd --web: quiltweb beside quiltd, from its start to its end. */
#include "tests/daemon/live.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/sendfile.h>

/* Number of lines of the log that hold this text; the last one is copied to `line`. */
static int lines_with(const live *l, const char *text, char line[1024])
{
    FILE *file = fopen(l->log, "r");
    char next[1024];
    int n = 0;
    while (file && fgets(next, sizeof next, file))
        if (strstr(next, text)) {
            memcpy(line, next, sizeof next);
            n++;
        }
    if (file)
        fclose(file);
    return n;
}

/* Lines about quiltweb, without the one of machines that lack IPv6. */
static int words_about_it(const live *l)
{
    char line[1024];
    return lines_with(l, "quiltweb", line) - lines_with(l, "quiltweb: [::1]:", line);
}

/* Waits until a line of the log holds this text. */
static void await_line(const live *l, const char *text, char line[1024])
{
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++, live_nap(20))
        if (lines_with(l, text, line) > 0)
            return;
    live_show_log(l);
    fail_msg("the log has no line with \"%s\"", text);
}

typedef struct page {
    int port;
    char token[33];
} page;

/* The page whose URL was printed. */
static page await_page(const live *l)
{
    page p = {0};
    char line[1024];
    await_line(l, "http://127.0.0.1:", line);
    assert_int_equal(sscanf(line, "http://127.0.0.1:%d/#%32s\n", &p.port, p.token), 2);
    assert_int_equal(strlen(p.token), 32);
    return p;
}

/* A connection to a port; -1: nobody listens there. */
static int connect_to(int port)
{
    struct sockaddr_in address = {.sin_family = AF_INET,
                                  .sin_port = htons((uint16_t)port),
                                  .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (connect(fd, (const struct sockaddr *)&address, sizeof address) == 0)
        return fd;
    close(fd);
    return -1;
}

/* What quiltweb answers to /api/status, in a buffer. */
static const char *ask_status(const page *p)
{
    static char answer[65536];
    size_t n = 0;
    ssize_t got;
    int fd = connect_to(p->port);
    assert_true(fd >= 0);
    dprintf(fd,
            "GET /api/status HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nAuthorization: Bearer %s\r\n\r\n",
            p->port, p->token);
    while ((got = recv(fd, answer + n, sizeof answer - 1 - n, 0)) > 0)
        n += (size_t)got;
    answer[n] = '\0';
    close(fd);
    return answer;
}

static void await_end(const page *p)
{
    for (int i = 0; i < LIVE_PATIENCE_S * 50; i++, live_nap(20)) {
        int fd = connect_to(p->port);
        if (fd < 0)
            return;
        close(fd);
    }
    fail_msg("quiltweb does not end");
}

/* The child of quiltd with this name; 0: none. */
static pid_t child_named(const live *l, const char *name)
{
    char path[64], words[4096], comm[32];
    snprintf(path, sizeof path, "/proc/%d/task/%d/children", (int)l->pid, (int)l->pid);
    FILE *file = fopen(path, "r");
    size_t n = file ? fread(words, 1, sizeof words - 1, file) : 0;
    if (file)
        fclose(file);
    words[n] = '\0';
    for (char *rest = words, *word; (word = strtok_r(rest, " ", &rest));) {
        snprintf(path, sizeof path, "/proc/%.20s/comm", word);
        file = fopen(path, "r");
        bool found =
            file && fgets(comm, sizeof comm, file) && strncmp(comm, name, strlen(name)) == 0;
        if (file)
            fclose(file);
        if (found)
            return (pid_t)strtol(word, NULL, 10);
    }
    return 0;
}

/* ------------------------------------------------------------------------------------- tests -- */

static void the_page_is_that_of_this_daemon_and_ends_with_it(void **state)
{
    (void)state;
    live l;
    char line[1024];
    live_prepare(&l);
    live_start(&l, l.scene, "--device", "none", "--web=0", NULL);
    page p = await_page(&l);
    const char *answer = ask_status(&p);
    assert_memory_equal(answer, "HTTP/1.1 200", 12);
    assert_non_null(strstr(answer, "\"state\":"));
    assert_int_equal(live_stop(&l), 0);
    assert_int_equal(connect_to(p.port), -1); /* quiltd has waited for it */
    assert_int_equal(lines_with(&l, "http://", line), 1);
    assert_int_equal(words_about_it(&l), 0); /* an end with quiltd needs no words */
    live_finish(&l);
}

static void it_ends_with_a_daemon_that_is_killed(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    live_start(&l, NULL, "--device", "none", "--web=0", NULL);
    page p = await_page(&l);
    kill(l.pid, SIGKILL);
    live_reap(l.pid);
    l.pid = 0;
    await_end(&p);
    live_finish(&l);
}

static void it_ends_when_the_time_of_the_daemon_is_over(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    assert_int_equal(live_run(&l, "quiltd", "--device", "none", "--socket", l.socket, "--web=0",
                              "--run-for", "1", NULL),
                     0);
    char line[1024];
    if (lines_with(&l, "http://", line) >
        0) { /* slow machines: quiltd ended before its child began */
        page p = await_page(&l);
        await_end(&p);
    }
    live_finish(&l);
}

static void its_own_end_is_told_once_and_the_daemon_goes_on(void **state)
{
    (void)state;
    static const struct {
        int signal;
        const char *words;
    } ends[] = {{SIGKILL, "quiltd: quiltweb: was ended by signal 9"},
                {SIGTERM, "quiltd: quiltweb: has ended"}};
    char line[1024];
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
        live l;
        live_client c;
        live_prepare(&l);
        live_start(&l, NULL, "--device", "none", "--web=0", NULL);
        page p = await_page(&l);
        pid_t child = child_named(&l, "quiltweb");
        assert_true(child > 0);
        kill(child, ends[i].signal);
        await_line(&l, ends[i].words, line);
        await_end(&p);
        live_connect(&l, &c);
        for (int k = 0; k < 20; k++) { /* it is not started again */
            assert_string_equal(live_status_text(&c, "state"), "idle");
            assert_int_equal(child_named(&l, "quilt"), 0);
        }
        live_close(&c);
        assert_int_equal(words_about_it(&l), 1);
        assert_int_equal(lines_with(&l, "http://", line), 1);
        live_finish(&l);
    }
}

static void a_failed_start_is_one_line_and_the_daemon_goes_on(void **state)
{
    (void)state;
    live l;
    live_client c;
    char line[1024], option[32];
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t size = sizeof address;
    int taken = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(bind(taken, (struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(taken, 1), 0);
    assert_int_equal(getsockname(taken, (struct sockaddr *)&address, &size), 0);
    snprintf(option, sizeof option, "--web=%d", ntohs(address.sin_port));
    live_prepare(&l);
    live_start(&l, NULL, "--device", "none", option, NULL);
    await_line(&l, "cannot listen", line);
    while (child_named(&l, "quiltweb") > 0)
        live_nap(10);
    live_connect(&l, &c);
    assert_string_equal(live_status_text(&c, "state"), "idle");
    live_close(&c);
    assert_int_equal(words_about_it(&l), 1);
    close(taken);
    live_finish(&l);
}

/* Copies quiltd into the folder, and starts it there with --web. */
static void start_alone(live *l)
{
    static char alone[PATH_MAX];
    struct stat st;
    snprintf(alone, sizeof alone, "%s/quiltd", l->folder);
    int in = open(lf_test_built("quiltd"), O_RDONLY | O_CLOEXEC);
    int out = open(alone, O_WRONLY | O_CREAT | O_CLOEXEC, 0700);
    assert_int_equal(fstat(in, &st), 0);
    for (off_t left = st.st_size; left > 0;) {
        ssize_t n = sendfile(out, in, NULL, (size_t)left);
        assert_true(n > 0);
        left -= n;
    }
    close(in);
    close(out);
    char *args[] = {alone,
                    (char *)(uintptr_t) "--device",
                    (char *)(uintptr_t) "none",
                    (char *)(uintptr_t) "--socket",
                    l->socket,
                    (char *)(uintptr_t) "--web",
                    NULL};
    l->pid = live_spawn(l, args);
}

/* Starts it so, and ends it after one line about quiltweb with this text. */
static void assert_one_line(live *l, const char *text)
{
    live_client c;
    char line[1024];
    start_alone(l);
    await_line(l, text, line);
    live_connect(l, &c);
    assert_string_equal(live_status_text(&c, "state"), "idle");
    live_close(&c);
    assert_int_equal(words_about_it(l), 1);
    live_finish(l);
}

static void a_missing_program_is_one_line_and_the_daemon_goes_on(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    assert_one_line(&l, "quiltd: quiltweb: the program is missing");
}

/* Not by a failure, of which it tells itself: as the dynamic linker ends it, for example. */
static void another_exit_status_is_told(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    lf_test_write(l.folder, "quiltweb", "#!/bin/sh\nexit 127\n");
    assert_int_equal(chmod(lf_test_path(l.folder, "quiltweb"), 0700), 0);
    assert_one_line(&l, "quiltd: quiltweb: has ended with exit status 127; restart quiltd");
}

/* systemd's socket has a path, too, and what systemd says to quiltd is not for quiltweb. */
static void it_finds_a_socket_from_systemd(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    snprintf(address.sun_path, sizeof address.sun_path, "%.100s", l.socket);
    int listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(bind(listener, (struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(listener, 8), 0);
    pid_t pid = fork();
    if (pid == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        char number[16];
        int log = open(l.log, O_WRONLY | O_CREAT | O_APPEND, 0600);
        dup2(log, STDOUT_FILENO);
        dup2(log, STDERR_FILENO);
        dup2(fcntl(listener, F_DUPFD, 10), 3);
        snprintf(number, sizeof number, "%d", (int)getpid());
        setenv("LISTEN_PID", number, 1);
        setenv("LISTEN_FDS", "1", 1);
        execl(lf_test_built("quiltd"), "quiltd", "--device", "none", "--web=0", (char *)NULL);
        _exit(127);
    }
    close(listener);
    l.pid = pid;
    page p = await_page(&l);
    assert_memory_equal(ask_status(&p), "HTTP/1.1 200", 12);
    assert_int_equal(live_stop(&l), 0);
    assert_int_equal(access(l.socket, F_OK), 0);
    assert_int_equal(connect_to(p.port), -1);
    live_finish(&l);
}

static void wrong_usage_is_2(void **state)
{
    (void)state;
    live l;
    live_prepare(&l);
    assert_int_equal(live_run(&l, "quiltd", "--web=page", NULL), 2);
    assert_int_equal(live_run(&l, "quiltd", "--web=65536", NULL), 2);
    assert_int_equal(live_run(&l, "quiltd", "--web=-1", NULL), 2);
    int in = dup(STDIN_FILENO), file = open(l.scene, O_RDONLY | O_CLOEXEC);
    assert_int_equal(dup2(file, STDIN_FILENO), STDIN_FILENO);
    assert_int_equal(
        live_run(&l, "quiltweb", "--listen", "127.0.0.1:0", "--until-input-ends", NULL), 2);
    dup2(in, STDIN_FILENO);
    close(in);
    close(file);
    live_finish(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_page_is_that_of_this_daemon_and_ends_with_it),
        cmocka_unit_test(it_ends_with_a_daemon_that_is_killed),
        cmocka_unit_test(it_ends_when_the_time_of_the_daemon_is_over),
        cmocka_unit_test(its_own_end_is_told_once_and_the_daemon_goes_on),
        cmocka_unit_test(a_failed_start_is_one_line_and_the_daemon_goes_on),
        cmocka_unit_test(a_missing_program_is_one_line_and_the_daemon_goes_on),
        cmocka_unit_test(another_exit_status_is_told),
        cmocka_unit_test(it_finds_a_socket_from_systemd),
        cmocka_unit_test(wrong_usage_is_2),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
