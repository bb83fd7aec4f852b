/* External files: reading with size limits, and atomic writing by renaming. The rule for readable
 * paths is in base/paths.h. */
#ifndef LF_BASE_FILE_H
#define LF_BASE_FILE_H

#include <stddef.h>
#include <stdint.h>

#include "base/paths.h"

/* Opens a regular file for reading (never blocks on a FIFO or device; O_CLOEXEC). Checks it against
 * roots (NULL = anywhere) and max_bytes. Refuses a web page that was saved instead of the file. On
 * LF_OK the caller owns *out_fd; *out_size (may be NULL) is its size. LF_E_PATH, LF_E_IO,
 * LF_E_FORMAT. */
LF_NODISCARD lf_status lf_file_open(const char *path, const lf_roots *roots, uint64_t max_bytes,
                                    int *out_fd, uint64_t *out_size, lf_error *err);

/* Hears of every file that lf_file_open has opened, in the thread that opened it. */
typedef void (*lf_file_opened_fn)(void *context, const char *path);
/* Sets who hears, for the whole process, while no other thread opens files; opened NULL: nobody. */
void lf_file_on_open(lf_file_opened_fn opened, void *context);

/* Reads the whole file and appends a terminating 0 (not counted in *out_size). The caller releases
 * *out_data with lf_free. */
LF_NODISCARD lf_status lf_file_read(const char *path, const lf_roots *roots, uint64_t max_bytes,
                                    char **out_data, size_t *out_size, lf_error *err);

/* "folder/relative", or relative itself if it is absolute; caller frees. NULL = out of memory. */
char *lf_path_join(const char *folder, const char *relative);
/* The folder of a path ("." if it has none); caller frees. */
char *lf_path_folder(const char *path);
/* The name of a file beside another: "sheet.json" for "sheet.tif" and ".json". A name without an
 * ending gets one; caller frees. NULL = out of memory. */
char *lf_path_beside(const char *path, const char *ending);
/* True if a path ends in `ending` (".png"), in any case. */
bool lf_path_has_ending(const char *path, const char *ending);

/* A file that becomes visible whole or not at all. It is written as ".NAME.quiltd-XXXXXX" in the
 * same folder, fsynced, then linked or renamed to NAME. With O_TMPFILE, if the file system has it,
 * a killed process leaves nothing behind. */
typedef struct lf_outfile {
    int fd;          /* write here; -1 when not open */
    bool borrowed;   /* the descriptor is a client's: no rename */
    char *path;      /* final name; NULL when borrowed */
    char *temporary; /* temporary name; NULL when unnamed (O_TMPFILE) or borrowed */
    /* Threads that compress for this file: the caller sets it after opening. NULL: only the caller
     * works. The bytes are the same. */
    struct lf_pool *pool;
} lf_outfile;

/* Begins to write path. First removes remains "…quiltd-XXXXXX" of killed runs for the same NAME. */
LF_NODISCARD lf_status lf_outfile_open(lf_outfile *file, const char *path, bool overwrite,
                                       lf_error *err);
/* Removes remains of killed runs in folder, for all NAMEs with this beginning. */
void lf_outfile_clean(const char *folder, const char *beginning);
/* Writes to a descriptor opened by another process, after truncating and rewinding it. On LF_OK
 * ownership is taken (commit or abandon closes it), otherwise it stays the caller's. LF_E_ARG: not
 * a regular file open for writing. */
LF_NODISCARD lf_status lf_outfile_adopt(lf_outfile *file, int fd, lf_error *err);
/* Syncs, publishes and closes. The struct is finished then, also after a failure, which publishes
 * nothing. LF_E_EXISTS without overwrite. */
LF_NODISCARD lf_status lf_outfile_commit(lf_outfile *file, bool overwrite, lf_error *err);
/* Publishes nothing; leaves an adopted file empty. Accepts zeroed structs (fd 0 with path NULL and
 * not borrowed) and finished ones. */
void lf_outfile_abandon(lf_outfile *file);
/* Writes all bytes, EINTR and short writes handled. */
LF_NODISCARD lf_status lf_outfile_write(lf_outfile *file, const void *data, size_t n,
                                        lf_error *err);
/* Writes a whole file with this text. After a failure the old file is unchanged. */
LF_NODISCARD lf_status lf_outfile_text(const char *path, const char *text, lf_error *err);

#endif
