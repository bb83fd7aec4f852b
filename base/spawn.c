#include "base/spawn.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdint.h>

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
