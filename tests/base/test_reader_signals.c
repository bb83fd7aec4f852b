/* A scheduler that ends a job signals all of its processes. A file reader goes on, because the
 * program that started it decides what becomes of it. */
#include "tests/testing.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include "base/sandbox/import.h"
#include "base/spawn.h"

/* Seconds until a program must have begun. */
enum { PATIENCE = 120 };

static bool ignores(pid_t pid, int signal)
{
    char path[64], line[256];
    unsigned long long mask = 0;
    snprintf(path, sizeof path, "/proc/%d/status", (int)pid);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    while (fgets(line, sizeof line, file))
        if (strncmp(line, "SigIgn:", 7) == 0)
            mask = strtoull(line + 7, NULL, 16);
    fclose(file);
    return mask >> (signal - 1) & 1;
}

static void signals_to_the_job_do_not_end_a_reader(void **state)
{
    (void)state;
    const int signals[] = {SIGTERM, SIGINT, SIGHUP};
    const char *const words[] = {"quiltimport", NULL};
    char *none[] = {NULL};
    int fds[LF_IMPORT_SOCKET + 1] = {-1, -1, -1, -1}, pair[2], how = 0;
    pid_t pid;
    assert_int_equal(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair), 0);
    fds[LF_IMPORT_SOCKET] = fcntl(pair[1], F_DUPFD_CLOEXEC, LF_IMPORT_SOCKET + 1);
    assert_int_equal(
        lf_spawn(lf_test_built("quiltimport"), fds, LF_IMPORT_SOCKET + 1, words, none, &pid), 0);
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 50 * PATIENCE && !ignores(pid, signals[i]); k++)
            usleep(20000);
        assert_int_equal(kill(pid, signals[i]), 0);
    }
    assert_int_equal(kill(pid, SIGKILL), 0);
    assert_int_equal(waitpid(pid, &how, 0), pid);
    assert_true(WIFSIGNALED(how));
    assert_int_equal(WTERMSIG(how), SIGKILL);
    for (int i = 0; i < 2; i++)
        close(pair[i]);
    close(fds[LF_IMPORT_SOCKET]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(signals_to_the_job_do_not_end_a_reader),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
