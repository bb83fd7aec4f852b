/* Starts a program with a few given descriptors and no others. */
#ifndef LF_BASE_SPAWN_H
#define LF_BASE_SPAWN_H

#include <sys/types.h>

/* Starts a program in a process group of its own, with no signal blocked or ignored. Its
 * descriptors i < n are fds[i], or /dev/null if fds[i] < 0; it has no others. fds stay the
 * caller's. All of them except the last must be >= n; the last is put in place first. program: a
 * path, or a name without slash that is looked up in PATH. words and environment end with NULL.
 * Returns 0 and *out_pid, or an errno. Thread: any. */
int lf_spawn(const char *program, const int fds[], int n, const char *const words[],
             char *const environment[], pid_t *out_pid);

#endif
