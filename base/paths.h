/* paths: what a client or a scene may open and write, the one place of that rule (docs: quiltd(1),
 * PATHS). A daemon reads only beneath a set of roots, and writes only beneath one folder. Where a
 * name leads is found out first, links and all; what is opened is then its canonical name, beneath
 * the root, without following any link: whatever is swapped for a link in between is not followed.
 * The kernel holds that (openat2 with RESOLVE_BENEATH); where it cannot (before Linux 5.6, or a
 * sandbox that forbids the call), each folder of the name is opened by itself, without following.
 *
 * What lies outside gives one and the same error, whether it exists or not: "FOLDER/.." is left out
 * of a name where FOLDER is outside, before it is asked for.
 *
 * Beyond that a daemon opens the files that clients have passed to it as descriptors
 * (base/passed.h): by their very names, and where the roots do not give them.
 *
 * Programs that run with the caller's own rights have no roots, which allows all. Any thread. */
#ifndef LF_BASE_PATHS_H
#define LF_BASE_PATHS_H

#include "base/passed.h"
#include "base/status.h"

#define LF_MAX_ROOTS 64

/* Where files may be read. n_roots 0 = anywhere. Roots are canonical absolute folders, owned. */
typedef struct lf_roots {
    int n_roots;
    char *root[LF_MAX_ROOTS];
    /* These are all: the folder of a scene is none of them by itself, since the scene may have been
     * passed under any name. */
    bool closed;
    lf_passed *passed; /* borrowed; NULL = none */
} lf_roots;

/* Adds a folder (made canonical). LF_E_IO, LF_E_ARG (not a folder, too many). */
LF_NODISCARD lf_status lf_roots_add(lf_roots *roots, const char *folder, lf_error *err);
void lf_roots_finish(lf_roots *roots);

/* What is to be said behind an error about this path where the program sees no home folders (a
 * service, systemd's ProtectHome=) and the path lies in one; else "". */
const char *lf_hidden_home(const char *path);

/* The canonical name (lf_free) of a file or folder that lies beneath the roots: to be told and
 * compared; whoever opens it asks again. A passed file's is the name it was passed by. LF_E_PATH:
 * it lies outside, or would if it were there; LF_E_IO: it is not there; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_roots_resolve(const lf_roots *roots, const char *path, char **out_path,
                                        lf_error *err);
/* Opens a regular file beneath the roots (n_roots > 0) for reading; never a device, not even for a
 * moment, and never waits for a FIFO. On LF_OK the caller owns *out_fd (O_CLOEXEC). Errors as
 * lf_roots_resolve; LF_E_FORMAT: no regular file. */
LF_NODISCARD lf_status lf_roots_open(const lf_roots *roots, const char *path, int *out_fd,
                                     lf_error *err);
/* Opens a folder beneath the roots, so that its names are read (fdopendir, scandirat) from the one
 * that was checked; roots may be NULL or empty here: anywhere. On LF_OK the caller owns *out_fd
 * (O_CLOEXEC). Errors as lf_roots_resolve; beneath roots LF_E_FORMAT: no folder. */
LF_NODISCARD lf_status lf_roots_open_folder(const lf_roots *roots, const char *path, int *out_fd,
                                            lf_error *err);

/* A name that may be written: its folder is held open, so that what was checked is what is written
 * to. */
typedef struct lf_held_name {
    int folder_fd; /* O_PATH */
    char *path;    /* canonical, to be told; a final "/" is kept */
} lf_held_name;

/* Whether a file or folder may be made under this name: LF_E_ARG where it holds a control character
 * or a line end. */
LF_NODISCARD lf_status lf_check_name(const char *path, lf_error *err);
/* The same of a file whose name ends so (".png"): LF_E_ARG also where that, or dots before it, is
 * all. */
LF_NODISCARD lf_status lf_check_stem(const char *path, const char *ending, lf_error *err);

/* Holds the name `path` beneath the canonical folder `root`, relative to it or absolute. Its folder
 * must be there, it itself need not be, and may be no link. option: what the user knows root by.
 * LF_E_PATH: not beneath it, and the same whether it is there or not; LF_E_ARG as lf_check_name;
 * LF_E_NOMEM. Release with lf_held_name_finish. */
LF_NODISCARD lf_status lf_held_name_open(const char *root, const char *option, const char *path,
                                         lf_held_name *out, lf_error *err);
/* Accepts finished ones, and those with folder_fd -1 and nothing else. */
void lf_held_name_finish(lf_held_name *held);
/* A path (lf_free) that leads to `name` in the folder that is held, whatever that is called by now.
 * It is for functions that follow no link in its last part. NULL = out of memory. */
char *lf_held_path(int folder_fd, const char *name);
/* Opens the folder `name` in the folder that is held (O_PATH), and makes it when it is missing.
 * LF_E_IO. */
LF_NODISCARD lf_status lf_held_folder(int folder_fd, const char *name, int *out_fd, bool *out_made,
                                      lf_error *err);

/* The mechanism, and what stands in for it. Open `name` beneath the folder, which is O_PATH:
 * parts of letters with one "/" between them, or "." for the folder itself; no "." or ".." among
 * them (EXDEV), and no link anywhere. -1 and errno. */
int lf_beneath_open(int folder_fd, const char *name, int flags);
int lf_beneath_walk(int folder_fd, const char *name, int flags);

#endif
