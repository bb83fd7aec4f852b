/* Addresses to listen on, and connections that never end their request. */
#include "tests/web/gateway.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include "daemon/web/listen.h"
#include "daemon/web/web.h"
#include "tests/daemon/soon.h"

static void only_loopback_is_listened_on(void **state)
{
    (void)state;
    static const char *const wrong[] = {
        "0.0.0.0:80",      "127.0.0.1",      "[::]:0", "localhost:1",
        "127.0.0.1:65536", "127.0.0.1:-1",   "",       "8033",
        "127.0.0.1:80x",   "192.168.1.1:80", "[::1]"};
    lf_error err = {0};
    int fd = -1;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        lf_assert_status(lf_web_listen(wrong[i], &fd, &err), LF_E_ARG, &err);
    assert_int_equal(fd, -1);
    lf_assert_ok(lf_web_listen("127.0.0.1:0", &fd, &err), &err);
    struct sockaddr_in address;
    socklen_t size = sizeof address;
    char again[32];
    int second = -1;
    assert_int_equal(getsockname(fd, (struct sockaddr *)&address, &size), 0);
    snprintf(again, sizeof again, "127.0.0.1:%d", ntohs(address.sin_port));
    lf_assert_status(lf_web_listen(again, &second, &err), LF_E_BUSY, &err);
    close(fd);
}

static void check_refused(sd_event *event, const int *fds, int n)
{
    lf_error err = {0};
    lf_web *web = NULL;
    const lf_web_config config = {.services[LF_SERVICE_PAGE] = {.fd = {fds[0], fds[1]}, .n = n},
                                  .socket = "/nowhere"};
    lf_assert_status(lf_web_create(event, &config, &web, &err), LF_E_ARG, &err);
}

/* What systemd passes may be anything. */
static void a_socket_for_everybody_is_refused(void **state)
{
    (void)state;
    struct sockaddr_in address = {.sin_family = AF_INET};
    lf_error err = {0};
    sd_event *event = NULL;
    lf_web *web = NULL;
    int fds[2] = {socket(AF_INET, SOCK_STREAM, 0), -1};
    lf_web_config config = {.services[LF_SERVICE_PAGE].n = 1, .socket = "/nowhere"};
    assert_true(sd_event_new(&event) >= 0);
    assert_int_equal(bind(fds[0], (struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(fds[0], 1), 0);
    check_refused(event, fds, 1);
    fds[0] = socket(AF_UNIX, SOCK_STREAM, 0);
    check_refused(event, fds, 1);
    lf_assert_ok(lf_web_listen("127.0.0.1:0", &fds[0], &err), &err);
    lf_assert_ok(lf_web_listen("127.0.0.1:0", &fds[1], &err), &err);
    check_refused(event, fds, 2); /* two ports */
    lf_assert_ok(lf_web_listen("127.0.0.1:0", &config.services[LF_SERVICE_PAGE].fd[0], &err), &err);
    lf_assert_ok(lf_web_create(event, &config, &web, &err), &err);
    assert_memory_equal(lf_web_url(web), "http://127.0.0.1:", 17);
    assert_int_equal(strlen(strchr(lf_web_url(web), '#') + 1), 32);
    lf_web_destroy(web);
    sd_event_unref(event);
}

static bool without_v6; /* as on a machine that lacks it */

int __real_bind(int fd, const struct sockaddr *address, socklen_t size);
int __wrap_bind(int fd, const struct sockaddr *address, socklen_t size);
int __wrap_bind(int fd, const struct sockaddr *address, socklen_t size)
{
    if (without_v6 && address->sa_family == AF_INET6) {
        errno = EADDRNOTAVAIL;
        return -1;
    }
    return __real_bind(fd, address, size);
}

static void close_all(int *fds, int n)
{
    for (int i = 0; i < n; i++)
        close(fds[i]);
}

static void both_addresses_have_one_port(void **state)
{
    (void)state;
    static const char *const both[] = {"127.0.0.1:0", "[::1]:0"};
    static const char *const wrong[][2] = {
        {"127.0.0.1:1", "[::1]:2"}, {"127.0.0.1:0", "127.0.0.1:0"}, {"127.0.0.1:0", "0.0.0.0:0"}};
    lf_error err = {0};
    int fds[2] = {-1, -1}, n = 0, ports[2] = {0};
    bool v6[2] = {false};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        lf_assert_status(lf_web_listen_all(wrong[i], 2, fds, &n, &err), LF_E_ARG, &err);
    lf_assert_ok(lf_web_listen_all(both, 2, fds, &n, &err), &err);
    for (int i = 0; i < n; i++)
        lf_assert_ok(lf_web_listener_look(fds[i], &ports[i], &v6[i], &err), &err);
    if (n == 2) {
        char taken[2][32];
        const char *const again[] = {taken[0], taken[1]};
        int more[2], n_more = 0;
        assert_int_equal(ports[0], ports[1]);
        assert_true(!v6[0] && v6[1]);
        snprintf(taken[0], sizeof taken[0], "127.0.0.1:%d", ports[0]);
        snprintf(taken[1], sizeof taken[1], "[::1]:%d", ports[0]);
        close(fds[0]); /* in use on one of the two is in use */
        lf_assert_status(lf_web_listen_all(again, 2, more, &n_more, &err), LF_E_BUSY, &err);
        close(fds[1]);
    } else {
        close_all(fds, n);
    }
}

static void a_machine_without_an_address_is_served_on_the_other(void **state)
{
    (void)state;
    static const char *const both[] = {"[::1]:0", "127.0.0.1:0"};
    lf_error err = {0};
    int fds[2] = {-1, -1}, n = 0, port = 0;
    bool v6 = true;
    without_v6 = true;
    lf_assert_ok(lf_web_listen_all(both, 2, fds, &n, &err), &err);
    assert_int_equal(n, 1);
    lf_assert_ok(lf_web_listener_look(fds[0], &port, &v6, &err), &err);
    assert_false(v6);
    close_all(fds, n);
    lf_assert_status(lf_web_listen_all(both, 1, fds, &n, &err), LF_E_NODEV, &err);
    without_v6 = false;
}

/* The exit status of quiltweb, and the first line that it prints. */
static int run_quiltweb(const char *options, char line[256])
{
    char command[512];
    snprintf(command, sizeof command,
             ": | '%s' --socket /nowhere --listen 127.0.0.1:0 --until-input-ends %s 2>&1",
             lf_test_built("quiltweb"), options);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    assert_non_null(fgets(line, 256, pipe));
    while (fgetc(pipe) != EOF)
        ;
    return WEXITSTATUS(pclose(pipe));
}

static void a_wrong_public_origin_is_wrong_usage(void **state)
{
    (void)state;
    char line[256];
    assert_int_equal(run_quiltweb("--public http://a.test", line), 2);
    assert_non_null(strstr(line, "--public: expects https://NAME or https://NAME:PORT"));
    assert_int_equal(run_quiltweb("--public https://a.test:8443", line), 0);
    assert_memory_equal(line, "https://a.test:8443/#", 21);
}

static void wrong_options_of_programs_are_wrong_usage(void **state)
{
    (void)state;
    static const char *const rows[][2] = {
        {"--bridge=1", "--bridge: expects PORT,PORT"},
        {"--bridge=1,2,3", "--bridge: expects PORT,PORT"},
        {"--bridge=1,65536", "--bridge: expects PORT,PORT"},
        {"--webxr=1,2", "--webxr: expects PORT"},
        {"--webxr=", "--webxr: expects PORT"},
        {"--allow-origin null", "--allow-origin: expects http://NAME"},
        {"--allow-origin '*'", "--allow-origin: expects http://NAME"},
        {"--bridge-version two", "--bridge-version: expects numbers with points"},
        {"--bridge-version .1", "--bridge-version: expects numbers with points"},
        {"--bridge-version ''", "--bridge-version: expects numbers with points"},
    };
    char line[256];
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_int_equal(run_quiltweb(rows[i][0], line), 2);
        if (!strstr(line, rows[i][1]))
            fail_msg("%s: %s", rows[i][0], line);
    }
    assert_int_equal(run_quiltweb("--bridge=0,0 --webxr=0 --bridge-version 2.7", line), 0);
    assert_non_null(strstr(line, "http://127.0.0.1:"));
}

/* Runs quiltweb with listening sockets as systemd passes them, with these names (NULL ends them),
 * and returns what it logs and prints. */
static const char *run_with_sockets(const char *const names[], const char *option, int *out_code)
{
    static char text[4096];
    char joined[128] = "", count[16], self[32];
    int fds[8], n = 0, out[2], status = 0;
    lf_error err = {0};
    for (; names[n]; n++) {
        lf_assert_ok(lf_web_listen("127.0.0.1:0", &fds[n], &err), &err);
        snprintf(joined + strlen(joined), sizeof joined - strlen(joined), "%s%s", n ? ":" : "",
                 names[n]);
    }
    snprintf(count, sizeof count, "%d", n);
    assert_int_equal(pipe(out), 0);
    const pid_t pid = fork();
    if (pid == 0) {
        const int input = open("/dev/null", O_RDONLY);
        int pipe_in[2];
        if (input < 0 || pipe(pipe_in) != 0)
            _exit(126);
        close(pipe_in[1]); /* the input has ended */
        dup2(pipe_in[0], STDIN_FILENO);
        dup2(out[1], STDOUT_FILENO);
        dup2(out[1], STDERR_FILENO);
        for (int i = 0; i < n; i++) /* out of the way of those that follow */
            fds[i] = fcntl(fds[i], F_DUPFD, 100);
        for (int i = 0; i < n; i++)
            dup2(fds[i], 3 + i);
        snprintf(self, sizeof self, "%d", (int)getpid());
        setenv("LISTEN_PID", self, 1);
        setenv("LISTEN_FDS", count, 1);
        setenv("LISTEN_FDNAMES", joined, 1);
        execl(lf_test_built("quiltweb"), "quiltweb", "--socket", "/nowhere", "--until-input-ends",
              option, (char *)NULL);
        _exit(127);
    }
    close(out[1]);
    for (int i = 0; i < n; i++)
        close(fds[i]);
    size_t used = 0;
    for (ssize_t got; (got = read(out[0], text + used, sizeof text - 1 - used)) > 0;)
        used += (size_t)got;
    text[used] = '\0';
    close(out[0]);
    assert_int_equal(waitpid(pid, &status, 0), pid);
    *out_code = WEXITSTATUS(status);
    return text;
}

static void sockets_of_systemd_are_told_apart_by_name(void **state)
{
    (void)state;
    static const char *const all[] = {"page", "events", "bridge", "webxr", NULL},
                             *const unnamed[] = {"quiltweb.socket", NULL},
                             *const same[] = {"page", "bridge", "page", NULL},
                             *const three[] = {"page", "page", "page", NULL};
    int code = 0;
    const char *text = run_with_sockets(all, NULL, &code);
    assert_int_equal(code, 0);
    assert_non_null(strstr(text, "requests of Bridge: port "));
    assert_non_null(strstr(text, "events of Bridge: port "));
    assert_non_null(strstr(text, "WebXR: port "));
    text = run_with_sockets(unnamed, NULL, &code);
    assert_int_equal(code, 0);
    assert_non_null(strstr(text, "http://127.0.0.1:"));
    assert_null(strstr(text, "port "));
    text = run_with_sockets(unnamed, "--bridge=0,0", &code); /* others may be its own */
    assert_int_equal(code, 0);
    assert_non_null(strstr(text, "requests of Bridge: port "));
    text = run_with_sockets(all, "--bridge=0,0", &code);
    assert_int_equal(code, 2);
    assert_non_null(strstr(text, "leave out its option"));
    text = run_with_sockets(same, NULL, &code); /* those of a service need one port */
    assert_int_equal(code, 2);
    text = run_with_sockets(three, NULL, &code);
    assert_int_equal(code, 2);
    assert_non_null(strstr(text, "one or two sockets named page"));
}

/* The other side has ended; not only the patience of this test. */
static bool has_ended(int fd)
{
    char byte;
    const ssize_t n = recv(fd, &byte, 1, 0);
    return n == 0 || (n < 0 && errno == ECONNRESET);
}

/* Timers of this program are due at once. */
static void a_request_that_does_not_end_is_dropped(void **state)
{
    gateway *g = *state;
    enum { MOST = 20000 };
    int fd = lf_caller_connect(g);
    int n = 0; /* a byte now and then, so that it is never idle */
    assert_true(lf_caller_send(fd, "GET / HTTP/1.1\r\nX: ", 19));
    for (; n < MOST && lf_caller_send(fd, "x", 1); n++)
        usleep(1000);
    assert_true(n < MOST);
    assert_true(has_ended(fd)); /* without an answer */
    close(fd);
    fd = lf_caller_connect(g); /* and one that says nothing */
    assert_true(has_ended(fd));
    close(fd);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_loopback_is_listened_on),
        cmocka_unit_test(a_socket_for_everybody_is_refused),
        cmocka_unit_test(both_addresses_have_one_port),
        cmocka_unit_test(a_machine_without_an_address_is_served_on_the_other),
        cmocka_unit_test(a_wrong_public_origin_is_wrong_usage),
        cmocka_unit_test(wrong_options_of_programs_are_wrong_usage),
        cmocka_unit_test(sockets_of_systemd_are_told_apart_by_name),
        lf_gateway_test(a_request_that_does_not_end_is_dropped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
