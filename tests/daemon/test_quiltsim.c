/* The program quiltsim: its command line, what it says, and its panel over TCP as `usbip` takes it.
 */
#include "tests/testing.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include "base/image_io.h"

enum { WAIT_MS = 20000, RECORD = 312 };

typedef struct program {
    pid_t pid;
    int in, out; /* ours: what it reads, what it prints */
    char line[1024];
} program;

static program *start(const char *const arguments[])
{
    const char *argv[16] = {lf_test_built("quiltsim")};
    int in[2], out[2];
    program *p = calloc(1, sizeof *p);
    assert_non_null(p);
    for (int i = 0; arguments[i]; i++)
        argv[1 + i] = arguments[i];
    assert_int_equal(pipe2(in, O_CLOEXEC), 0);
    assert_int_equal(pipe2(out, O_CLOEXEC), 0);
    p->pid = fork();
    assert_true(p->pid >= 0);
    if (p->pid == 0) {
        dup2(in[0], STDIN_FILENO);
        dup2(out[1], STDOUT_FILENO);
        dup2(out[1], STDERR_FILENO);
        execv(argv[0], (char *const *)(uintptr_t)argv);
        _exit(127);
    }
    close(in[0]);
    close(out[1]);
    p->in = in[1];
    p->out = out[0];
    return p;
}

static bool readable(int fd)
{
    struct pollfd poll_fd = {.fd = fd, .events = POLLIN};
    return poll(&poll_fd, 1, WAIT_MS) == 1;
}

/* The next line it prints; empty at the end. */
static const char *says(program *p)
{
    size_t n = 0;
    while (n + 1 < sizeof p->line && readable(p->out) && read(p->out, p->line + n, 1) == 1 &&
           p->line[n] != '\n')
        n++;
    p->line[n] = 0;
    return p->line;
}

static const char *answer(program *p, const char *command)
{
    assert_int_equal(write(p->in, command, strlen(command)), strlen(command));
    return says(p);
}

static int finish(program *p)
{
    int status;
    close(p->in);
    assert_int_equal(waitpid(p->pid, &status, 0), p->pid);
    close(p->out);
    free(p);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

static int port_of(const char *line)
{
    int port = 0;
    const char *at = strstr(line, "--tcp-port ");
    assert_non_null(at);
    assert_int_equal(sscanf(at, "--tcp-port %d attach -r 127.0.0.1 -b 1-1", &port), 1);
    return port;
}

static int connect_to(int port)
{
    struct sockaddr_in at = {.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    assert_int_equal(connect(fd, (const struct sockaddr *)&at, sizeof at), 0);
    return fd;
}

static ssize_t get(int fd, void *out, size_t n)
{
    size_t got = 0;
    while (got < n && readable(fd)) {
        ssize_t r = recv(fd, (uint8_t *)out + got, n - got, 0);
        if (r <= 0)
            break;
        got += (size_t)r;
    }
    return (ssize_t)got;
}

static unsigned import(int fd)
{
    uint8_t request[40] = {0x01, 0x11, 0x80, 0x03}, reply[8] = {0}, record[RECORD];
    memcpy(request + 8, "1-1", 3);
    assert_int_equal(send(fd, request, sizeof request, MSG_NOSIGNAL), sizeof request);
    assert_int_equal(get(fd, reply, sizeof reply), sizeof reply);
    if (reply[7] == 0)
        assert_int_equal(get(fd, record, sizeof record), sizeof record);
    return reply[7];
}

static void wrong_usage_is_told(void **state)
{
    (void)state;
    static const char *const wrong[][4] = {
        {"--nothing"},         {"--listen", "65536"},        {"--size", "0x5"},
        {"--size", "10.5x5"},  {"--formats", "rgb888,"},     {"--formats", "grey"},
        {"--fault", "always"}, {"--buffer", "-1"},           {"--hid-stale", "many"},
        {"operand"},           {"--no-hid", "--no-display"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        program *p = start(wrong[i]);
        assert_memory_equal(says(p), "quiltsim: ", 10);
        assert_int_equal(finish(p), 2);
    }
}

static void a_fault_has_a_former_name(void **state)
{
    (void)state;
    static const char *const names[] = {"--fault", "--lie"};
    for (int i = 0; i < 2; i++) {
        program *p = start((const char *const[]){"--listen", "0", names[i], "no-modes", "x", NULL});
        assert_string_equal(
            says(p), "quiltsim: x: unexpected argument; quiltsim takes only options (see --help)");
        assert_int_equal(finish(p), 2);
    }
}

static void a_file_that_is_not_there_is_told(void **state)
{
    (void)state;
    program *p =
        start((const char *const[]){"--listen", "0", "--calibration", "/nonexistent", NULL});
    assert_non_null(strstr(says(p), "/nonexistent"));
    assert_int_equal(finish(p), 1);
}

/* The EEPROM may hold nonsense, when the display's size comes from elsewhere. */
static void a_damaged_calibration_needs_a_size(void **state)
{
    (void)state;
    char *dir = lf_test_folder();
    const char *path = lf_test_write(dir, "damaged.json", "{\"pitch\":");
    program *p = start((const char *const[]){"--listen", "0", "--calibration", path, NULL});
    assert_non_null(strstr(says(p), "not JSON"));
    assert_int_equal(finish(p), 1);
    p = start(
        (const char *const[]){"--listen", "0", "--calibration", path, "--size", "32x16", NULL});
    assert_true(port_of(says(p)) > 0);
    assert_string_equal(answer(p, "quit\n"), "ok");
    assert_int_equal(finish(p), 0);
    lf_test_folder_remove(dir);
}

static void it_is_plugged_in_and_out(void **state)
{
    (void)state;
    uint8_t byte;
    program *p = start((const char *const[]){"--listen", "0", "--size", "32x16", NULL});
    int port = port_of(says(p)), fd = connect_to(port), second = connect_to(port);
    assert_int_equal(import(fd), 0);
    assert_string_equal(says(p), "attached");
    assert_int_equal(import(second), 1); /* one host alone */
    close(second);
    assert_string_equal(answer(p, "press left\n"), "ok");
    assert_string_equal(answer(p, "unplug\n"), "ok");
    assert_int_equal(get(fd, &byte, 1), 0);
    close(fd);
    assert_memory_equal(answer(p, "press left\n"), "error: ", 7);
    fd = connect_to(port);
    assert_int_equal(import(fd), 1);
    close(fd);
    assert_string_equal(answer(p, "replug\n"), "ok");
    fd = connect_to(port);
    assert_int_equal(import(fd), 0);
    assert_string_equal(says(p), "attached");
    close(fd);
    assert_string_equal(says(p), "detached");
    assert_string_equal(answer(p, "quit\n"), "ok");
    assert_int_equal(finish(p), 0);
}

/* Those who connect and say nothing do not keep others out. */
static void idle_connections_make_room(void **state)
{
    (void)state;
    int idle[40];
    program *p = start((const char *const[]){"--listen", "0", "--size", "32x16", NULL});
    int port = port_of(says(p));
    for (int i = 0; i < 40; i++)
        idle[i] = connect_to(port);
    int fd = connect_to(port);
    assert_int_equal(import(fd), 0);
    for (int i = 0; i < 40; i++)
        close(idle[i]);
    close(fd);
    assert_string_equal(says(p), "attached");
    assert_string_equal(says(p), "detached");
    assert_string_equal(answer(p, "quit\n"), "ok");
    assert_int_equal(finish(p), 0);
}

static void commands_that_are_none_are_told(void **state)
{
    (void)state;
    char text[1024];
    memset(text, 'x', sizeof text);
    memcpy(text + sizeof text - 2, "\n", 2);
    program *p = start((const char *const[]){"--listen", "0", "--no-display", NULL});
    assert_true(port_of(says(p)) > 0);
    assert_memory_equal(answer(p, "press\n"), "error: ", 7);
    assert_memory_equal(answer(p, "press nose\n"), "error: ", 7);
    assert_memory_equal(answer(p, text), "error: ", 7);
    assert_memory_equal(answer(p, "counters\n"), "lit=0 ", 6);
    assert_string_equal(says(p), "ok");
    assert_int_equal(kill(p->pid, SIGTERM), 0);
    assert_int_equal(finish(p), 0);
}

static void the_picture_is_written(void **state)
{
    (void)state;
    char *dir = lf_test_folder(), png[PATH_MAX];
    lf_image8 image = {0};
    lf_error err;
    snprintf(png, sizeof png, "%s", lf_test_path(dir, "panel.png"));
    program *p =
        start((const char *const[]){"--listen", "0", "--size", "32x16", "--panel-png", png, NULL});
    assert_true(port_of(says(p)) > 0);
    assert_int_not_equal(access(png, F_OK), 0);
    assert_string_equal(answer(p, "picture\n"), "ok");
    lf_assert_ok(lf_image8_read(png, NULL, &image, &err), &err);
    assert_int_equal(image.width, 32);
    assert_int_equal(image.height, 16);
    lf_image8_finish(&image);
    assert_int_equal(unlink(png), 0);
    assert_string_equal(answer(p, "quit\n"), "ok");
    assert_int_equal(finish(p), 0);
    assert_int_equal(access(png, F_OK), 0); /* and at the end */
    lf_test_folder_remove(dir);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_usage_is_told),
        cmocka_unit_test(a_fault_has_a_former_name),
        cmocka_unit_test(a_file_that_is_not_there_is_told),
        cmocka_unit_test(a_damaged_calibration_needs_a_size),
        cmocka_unit_test(it_is_plugged_in_and_out),
        cmocka_unit_test(idle_connections_make_room),
        cmocka_unit_test(commands_that_are_none_are_told),
        cmocka_unit_test(the_picture_is_written),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
