/* Files from and to the outside: size limits, and writing beside and renaming.
 * Files are read by the paths rule: base/paths.h. */
#ifndef LF_BASE_FILE_H
#define LF_BASE_FILE_H

#include <stddef.h>
#include <stdint.h>

#include "base/paths.h"

/* Opens a regular file for reading (never blocks on a FIFO or device; O_CLOEXEC) and checks it
 * against roots (NULL = anywhere), max_bytes, and being a web page that was saved in its place. On
 * LF_OK the caller owns *out_fd; *out_size (may be NULL) is its size. LF_E_PATH, LF_E_IO,
 * LF_E_FORMAT. */
LF_NODISCARD lf_status lf_file_open(const char *path, const lf_roots *roots, uint64_t max_bytes,
                                    int *out_fd, uint64_t *out_size, lf_error *err);

/* The whole file with a terminating 0 behind it (not counted in *out_size). Caller releases
 * *out_data with lf_free. */
LF_NODISCARD lf_status lf_file_read(const char *path, const lf_roots *roots, uint64_t max_bytes,
                                    char **out_data, size_t *out_size, lf_error *err);

/* "folder/relative", or relative itself when it is absolute; caller frees. NULL = out of memory. */
char *lf_path_join(const char *folder, const char *relative);
/* The folder part of a path ("." when there is none); caller frees. */
char *lf_path_folder(const char *path);
/* Whether a path ends in `ending` (".png"), whatever the case. */
bool lf_path_has_ending(const char *path, const char *ending);

/* A file that becomes visible whole or not at all: written beside as ".NAME.quiltd-XXXXXX"
 * (O_TMPFILE where the file system has it, so that a kill leaves nothing), fsynced, then linked or
 * renamed onto NAME. */
typedef struct lf_outfile {
    int fd;          /* write here; -1 when not open */
    bool borrowed;   /* the descriptor came from outside (a client's): no rename */
    char *path;      /* final name; NULL when borrowed */
    char *temporary; /* name beside; NULL when unnamed (O_TMPFILE) or borrowed */
} lf_outfile;

/* Begins to write path; leftovers "…quiltd-XXXXXX" of killed runs for the same NAME are removed
 * first. */
LF_NODISCARD lf_status lf_outfile_open(lf_outfile *file, const char *path, bool overwrite,
                                       lf_error *err);
/* Removes what killed runs have left of all NAMEs in folder that begin so. */
void lf_outfile_clean(const char *folder, const char *beginning);
/* The same onto a descriptor opened by somebody else: truncated and rewound first. On LF_OK it is
 * taken over (closed by commit or abandon), otherwise it stays the caller's. LF_E_ARG when it is
 * not a regular file open for writing. */
LF_NODISCARD lf_status lf_outfile_adopt(lf_outfile *file, int fd, lf_error *err);
/* fsync, publish, close; the struct is finished then, also on failure, when nothing was published.
 * LF_E_EXISTS without overwrite. */
LF_NODISCARD lf_status lf_outfile_commit(lf_outfile *file, bool overwrite, lf_error *err);
/* Gives up: nothing is published, an adopted file is left empty. Accepts zeroed (fd 0 with path
 * NULL and not borrowed) and finished structs. */
void lf_outfile_abandon(lf_outfile *file);
/* Writes all bytes, EINTR and short writes handled. */
LF_NODISCARD lf_status lf_outfile_write(lf_outfile *file, const void *data, size_t n,
                                        lf_error *err);
/* All of that in one: the file is this text from now on, or on failure what it was. */
LF_NODISCARD lf_status lf_outfile_text(const char *path, const char *text, lf_error *err);

#endif
