#include "base/spawn.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

lf_status lf_find_program(const char *name, const char *first, char path[PATH_MAX], lf_error *err)
{
    char own[PATH_MAX] = "", places[2][PATH_MAX + 32];
    ssize_t n = readlink("/proc/self/exe", own, sizeof own - 1);
    char *last = n > 0 ? strrchr(own, '/') : own;
    *last = '\0';
    snprintf(places[0], sizeof places[0], "%s", first ? first : own);
    snprintf(places[1], sizeof places[1], "%s/../libexec/quiltd", own);
    for (int i = 0; i < 2; i++)
        if (snprintf(path, PATH_MAX, "%s/%s", places[i], name) < PATH_MAX &&
            access(path, X_OK) == 0)
            return LF_OK;
    return lf_error_set(err, LF_E_IO, name,
                        "the program is missing in %s and %s; install quiltd again", places[0],
                        places[1]);
}

static int place_descriptors(posix_spawn_file_actions_t *actions, const int fds[], int n)
{
    int failed = 0;
    for (int i = n - 1; i >= 0 && !failed; i--)
        failed = fds[i] < 0 ? posix_spawn_file_actions_addopen(actions, i, "/dev/null", O_RDWR, 0)
                            : posix_spawn_file_actions_adddup2(actions, fds[i], i);
    return failed ? failed : posix_spawn_file_actions_addclosefrom_np(actions, n);
}

static int free_signals(posix_spawnattr_t *how)
{
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    int failed = posix_spawnattr_setflags(how, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF |
                                                   POSIX_SPAWN_SETPGROUP);
    if (!failed)
        failed = posix_spawnattr_setsigmask(how, &none);
    return failed ? failed : posix_spawnattr_setsigdefault(how, &all);
}

int lf_spawn(const char *program, const int fds[], int n, const char *const words[],
             char *const environment[], pid_t *out_pid)
{
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t how;
    if (posix_spawn_file_actions_init(&actions) != 0)
        return ENOMEM;
    if (posix_spawnattr_init(&how) != 0) {
        posix_spawn_file_actions_destroy(&actions);
        return ENOMEM;
    }
    int failed = place_descriptors(&actions, fds, n);
    if (!failed)
        failed = free_signals(&how);
    if (!failed)
        failed = posix_spawnp(out_pid, program, &actions, &how, (char *const *)(uintptr_t)words,
                              environment);
    posix_spawnattr_destroy(&how);
    posix_spawn_file_actions_destroy(&actions);
    return failed;
}
