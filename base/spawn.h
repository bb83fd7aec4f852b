/* Programs that belong to this one: finding them, and starting one with a few given descriptors and
 * no others. */
#ifndef LF_BASE_SPAWN_H
#define LF_BASE_SPAWN_H

#include <limits.h>
#include <sys/types.h>

#include "base/status.h"

/* Finds a program that was installed with this one: in the folder of this program, or in
 * ../libexec/quiltd. first: a folder to look in instead of the former; NULL: none. LF_E_IO: it is
 * in neither. Thread: any. */
LF_NODISCARD lf_status lf_find_program(const char *name, const char *first, char path[PATH_MAX],
                                       lf_error *err);

/* Starts a program in a process group of its own, with no signal blocked or ignored. Its
 * descriptors i < n are fds[i], or /dev/null if fds[i] < 0; it has no others. fds stay the
 * caller's. All of them except the last must be >= n; the last is put in place first. program: a
 * path, or a name without slash that is looked up in PATH. words and environment end with NULL.
 * Returns 0 and *out_pid, or an errno. Thread: any. */
int lf_spawn(const char *program, const int fds[], int n, const char *const words[],
             char *const environment[], pid_t *out_pid);

#endif
