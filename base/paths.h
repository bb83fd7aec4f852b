/* paths: the only place of the rule for readable and writable paths (quiltd(1), PATHS). A daemon
 * reads only inside a set of roots, and writes only inside one folder.
 *
 * A name is first resolved, with all links. Then its canonical name is opened inside the root
 * without following any link, so that a link created in between is not followed. The kernel ensures
 * this (openat2 with RESOLVE_BENEATH). Before Linux 5.6, or if a sandbox forbids the call, each
 * folder of the name is opened separately, without following links.
 *
 * A path outside the roots gives the same error whether or not it exists. For this, "FOLDER/.." is
 * removed from a name if FOLDER is outside, before any access.
 *
 * A daemon also opens the files that clients have passed as descriptors (base/passed.h), by exactly
 * their names, if the roots do not contain them.
 *
 * Programs that run with the caller's own rights have no roots, which allows all paths. Thread:
 * any. */
#ifndef LF_BASE_PATHS_H
#define LF_BASE_PATHS_H

#include "base/passed.h"
#include "base/status.h"

#define LF_MAX_ROOTS 64

/* Where files may be read. n_roots 0 = anywhere. Roots are canonical absolute folders, owned. */
typedef struct lf_roots {
    int n_roots;
    char *root[LF_MAX_ROOTS];
    /* The list is complete. The folder of a scene is not a root by itself, because the scene may
     * have been passed under any name. */
    bool closed;
    lf_passed *passed; /* borrowed; NULL = none */
} lf_roots;

/* Adds a folder (made canonical). LF_E_IO, LF_E_ARG (not a folder, too many). */
LF_NODISCARD lf_status lf_roots_add(lf_roots *roots, const char *folder, lf_error *err);
void lf_roots_finish(lf_roots *roots);

/* A hint to append to an error about this path, if the program cannot see home folders (a service,
 * systemd's ProtectHome=) and the path is inside one; otherwise "". */
const char *lf_hidden_home(const char *path);

/* Replaces the error about a path outside the roots by one that names the daemon's option:
 * LF_E_PATH. */
lf_status lf_say_outside(const char *path, lf_error *err);

/* The canonical name (lf_free) of a file or folder inside the roots, for messages and comparisons;
 * opening it checks again. For a passed file it is the name it was passed by. LF_E_PATH: outside
 * the roots, whether or not it exists; LF_E_IO: it does not exist; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_roots_resolve(const lf_roots *roots, const char *path, char **out_path,
                                        lf_error *err);
/* Opens a regular file inside the roots (n_roots > 0) for reading. Never opens a device, not even
 * briefly, and never waits for a FIFO. On LF_OK the caller owns *out_fd (O_CLOEXEC). Errors of
 * lf_roots_resolve; LF_E_FORMAT: not a regular file. */
LF_NODISCARD lf_status lf_roots_open(const lf_roots *roots, const char *path, int *out_fd,
                                     lf_error *err);
/* Opens a folder inside the roots, so that its names are read (fdopendir, scandirat) from the
 * folder that was checked. roots may be NULL or empty: anywhere. On LF_OK the caller owns *out_fd
 * (O_CLOEXEC). Errors of lf_roots_resolve; with roots LF_E_FORMAT: not a folder. */
LF_NODISCARD lf_status lf_roots_open_folder(const lf_roots *roots, const char *path, int *out_fd,
                                            lf_error *err);

/* A name that may be written. Its folder is held open, so that the checked folder is the one
 * written to. */
typedef struct lf_held_name {
    int folder_fd; /* O_PATH */
    char *path;    /* canonical, for messages; a final "/" is kept */
} lf_held_name;

/* Checks the name of a new file or folder. LF_E_ARG: it holds a control character or a line end. */
LF_NODISCARD lf_status lf_check_name(const char *path, lf_error *err);
/* Like lf_check_name, for a file name with this ending (".png"). LF_E_ARG also if the name is only
 * the ending, or dots before it. */
LF_NODISCARD lf_status lf_check_stem(const char *path, const char *ending, lf_error *err);

/* Holds the name `path` inside the canonical folder `root`, relative to it or absolute. Its folder
 * must exist; the name itself need not, and must not be a link. option: the user's name for root.
 * LF_E_PATH: not inside it, whether or not it exists; LF_E_ARG as for lf_check_name; LF_E_NOMEM.
 * Release with lf_held_name_finish. */
LF_NODISCARD lf_status lf_held_name_open(const char *root, const char *option, const char *path,
                                         lf_held_name *out, lf_error *err);
/* Accepts finished structs, and zeroed ones with folder_fd -1. */
void lf_held_name_finish(lf_held_name *held);
/* A path (lf_free) to `name` in the held folder, whatever the folder is called now. For functions
 * that follow no link in the last part. NULL = out of memory. */
char *lf_held_path(int folder_fd, const char *name);
/* Opens the folder `name` in the held folder (O_PATH), and creates it if it is missing. LF_E_IO. */
LF_NODISCARD lf_status lf_held_folder(int folder_fd, const char *name, int *out_fd, bool *out_made,
                                      lf_error *err);

/* The mechanism, and its replacement without openat2. Open `name` inside the folder, which is
 * O_PATH. name: parts separated by one "/", or "." for the folder itself. No part may be "." or
 * ".." (EXDEV), and no link is followed. -1 and errno on failure. */
int lf_beneath_open(int folder_fd, const char *name, int flags);
int lf_beneath_walk(int folder_fd, const char *name, int flags);

#endif
