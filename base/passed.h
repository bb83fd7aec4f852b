/* passed: files that a client has opened and passed as descriptors (SCM_RIGHTS), so that a daemon
 * can read files outside its folders (base/paths.h). A passed file is a name and a descriptor. It
 * is found by exactly that name. It grants no access to its folder, to neighbouring files or by
 * another name.
 *
 * Each reader gets an open file description of its own, so no offset is shared with the client or
 * other readers. If the daemon's user may not open the file again (another user's file with mode
 * 0600), the file is copied into memory once, at its first read.
 *
 * One thread builds a list; once it is complete, any thread may open its files. Reading may wait
 * for the client's file system: do not call it on a thread that must not wait.
 *
 * A list also holds arrays (base/array.h) in sealed memory files (memfd_create). An array is found
 * by its name in scenes, which is not a path. Its file can no longer change, so it is read where it
 * is. */
#ifndef LF_BASE_PASSED_H
#define LF_BASE_PASSED_H

#include <stdint.h>

#include "base/array.h"
#include "base/status.h"

#define LF_MAX_PASSED 64                       /* files and arrays, per call and per scene */
#define LF_MAX_PASSED_ALL 256                  /* open in the process at a time */
#define LF_MAX_PASSED_COPY ((uint64_t)1 << 30) /* bytes of all copies in the process */

typedef struct lf_passed lf_passed;

/* An empty list, with one reference; NULL = out of memory. */
lf_passed *lf_passed_create(void);
/* Adds a file by its name in scenes: an absolute path without ".", ".." or empty parts, and without
 * a frame number field. On LF_OK ownership of fd is taken, otherwise it stays the caller's. Never
 * waits for a file system. LF_E_ARG: another kind of name, a name already present, too many files,
 * or fd is not a regular file that only can be read: opened so, or a memory file sealed against
 * writing; LF_E_BUSY: the process holds LF_MAX_PASSED_ALL;
 * LF_E_NOMEM. */
LF_NODISCARD lf_status lf_passed_add(lf_passed *passed, const char *path, int fd, lf_error *err);
/* Adds an array. name: 1 to LF_MAX_ARRAY_NAME bytes without a slash. fd as above; asks only the
 * kernel, never reads. LF_E_ARG: another kind of name, a name already present, too many, a length
 * below 1, or a file that has another size, is not sealed against writing, shrinking and growing,
 * or is not readable; LF_E_BUSY and LF_E_NOMEM as above. */
LF_NODISCARD lf_status lf_passed_add_array(lf_passed *passed, const char *name,
                                           const lf_array *array, int fd, lf_error *err);
#define LF_MAX_ARRAY_NAME 128
/* A list of the files and arrays of both; `newer` wins if a name is in both. Either may be NULL. If
 * there are too many, drops files of `older` that nobody has opened since that list was made.
 * LF_E_ARG: still too many; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_passed_join(const lf_passed *older, const lf_passed *newer,
                                      lf_passed **out, lf_error *err);
/* Drops files of `newer` (may be NULL) that were never opened, because no scene names them. */
void lf_passed_drop_unopened(lf_passed *passed, const lf_passed *newer);
lf_passed *lf_passed_ref(lf_passed *passed);
/* Closes files that no other list holds. Accepts NULL. */
void lf_passed_unref(lf_passed *passed);

/* True if a file with this name was passed; passed may be NULL. Relative names start at the working
 * folder; ".." is resolved in the text only. */
bool lf_passed_has(const lf_passed *passed, const char *path);
/* Opens it for reading, at offset 0. On LF_OK the caller owns *out_fd (O_CLOEXEC). LF_E_PATH: no
 * such file was passed; LF_E_IO; LF_E_FORMAT: too large to copy; LF_E_NOMEM; LF_E_CANCELLED
 * (lf_passed_stop_when). */
LF_NODISCARD lf_status lf_passed_open(lf_passed *passed, const char *path, int *out_fd,
                                      lf_error *err);

/* Takes the array of this name: its shape, and a descriptor of its file, which the caller owns
 * (O_CLOEXEC). Its offset is shared, so it must not be read there. LF_E_IO, also if no such array
 * was passed (passed may be NULL); LF_E_FORMAT: it has not the type and shape of `wanted`
 * (lf_array_is; NULL: any). */
LF_NODISCARD lf_status lf_passed_open_array(lf_passed *passed, const char *name,
                                            const lf_array *wanted, lf_array *out, int *out_fd,
                                            lf_error *err);

/* From now on copying stops when stopped() returns true; it is polled. Thread: any. */
void lf_passed_stop_when(bool (*stopped)(void));

/* The name of file or array number `index`; NULL after the last, or if passed is NULL. */
const char *lf_passed_at(const lf_passed *passed, int index);

/* The normalised name for comparison: absolute, without ".", ".." and empty parts; out is PATH_MAX
 * bytes. False: too long. */
bool lf_passed_name(const char *path, char *out);

#endif
