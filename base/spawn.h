/* Starting a program that has a few descriptors of ours and nothing else. */
#ifndef LF_BASE_SPAWN_H
#define LF_BASE_SPAWN_H

#include <sys/types.h>

/* Starts the program in a process group of its own, no signal blocked or ignored. It gets fds[i] as
 * descriptor i, below n, /dev/null where that is below 0, and none beside them; fds stay the
 * caller's, and all but the last lie at n or above: the last is put in place first. program: a
 * path, or without a slash a name that is looked for in PATH. words and environment end with NULL.
 * 0 and *out_pid, or an errno. Thread: any. */
int lf_spawn(const char *program, const int fds[], int n, const char *const words[],
             char *const environment[], pid_t *out_pid);

#endif
