/* quiltctl doctor: collects the facts to judge, with the caller's rights; a daemon need not run. */
#include <fcntl.h>
#include <spawn.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include "base/alloc.h"
#include "daemon/tools/ctl.h"

enum { MAX_DEVICES = 32, MAX_FOUND = 32 };

/* The daemon's status; NULL = no daemon answers, with *err. */
static json_t *ask_daemon(const char *socket, lf_error *err)
{
    lf_ctl *ctl = NULL;
    json_t *status = NULL;
    if (lf_ctl_connect(socket, &ctl, err) == LF_OK &&
        lf_ctl_call(ctl, "status", json_object(), NULL, 0, &status, NULL, err) != LF_OK)
        status = NULL;
    lf_ctl_close(ctl);
    return status;
}

/* Reads fd to its end, as text. */
static void read_text(int fd, char *out, size_t size)
{
    size_t n = 0;
    ssize_t got = 1;
    while (got > 0 && n < size - 1) {
        got = read(fd, out + n, size - 1 - n);
        n += got > 0 ? (size_t)got : 0;
    }
    out[n] = '\0';
}

/* Queries systemd about the service, into out; "" without systemd. */
static void ask_systemd(char *out, size_t size)
{
    static const char *const words[] = {"systemctl",         "show", "quiltd.service", "-p",
                                        lf_doctor_unit_keys, NULL};
    posix_spawn_file_actions_t actions;
    pid_t pid;
    int ends[2];
    out[0] = '\0';
    if (sd_booted() <= 0 || pipe2(ends, O_CLOEXEC) != 0)
        return;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    int failed =
        posix_spawnp(&pid, words[0], &actions, NULL, (char *const *)(uintptr_t)words, environ);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    if (failed == 0)
        read_text(ends[0], out, size);
    close(ends[0]);
    if (failed == 0)
        (void)waitpid(pid, NULL, 0);
}

typedef struct findings {
    FILE *out;
    int n_problems;
} findings;

static void print_finding(void *context, lf_doctor_level level, const char *text)
{
    static const char *const heads[] = {"ok   ", "note ", "FAIL "};
    findings *all = context;
    all->n_problems += level == LF_DOCTOR_FAIL;
    fprintf(all->out, "%s %s\n", heads[level], text);
}

int lf_ctl_print_findings(const lf_doctor_facts *facts, FILE *out)
{
    findings all = {.out = out};
    lf_doctor_judge(facts, print_finding, &all);
    if (all.n_problems == 0)
        fprintf(out, "no problem found\n");
    else
        fprintf(out, "%d problem%s found\n", all.n_problems, all.n_problems == 1 ? "" : "s");
    return all.n_problems;
}

bool lf_ctl_doctor(const char *socket)
{
    lf_error no_answer = {0};
    lf_device_info devices[MAX_DEVICES];
    lf_found *found = lf_calloc(MAX_FOUND, sizeof *found);
    json_t *status = ask_daemon(socket, &no_answer);
    char unit[1024];
    ask_systemd(unit, sizeof unit);
    const lf_doctor_facts facts = {
        .root = "",
        .status = status,
        .no_answer = &no_answer,
        .devices = devices,
        .n_devices = lf_device_list(devices, MAX_DEVICES),
        .found = found,
        .n_found = found ? lf_find_all(found, MAX_FOUND) : 0,
        .unit = unit,
        .path = getenv("PATH"),
    };
    const int n_problems = lf_ctl_print_findings(&facts, stdout);
    json_decref(status);
    lf_free(found);
    return n_problems == 0;
}
