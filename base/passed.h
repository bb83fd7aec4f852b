/* passed: files that a client has opened itself and hands over as descriptors (SCM_RIGHTS), so that
 * a daemon reads what lies outside of its folders (base/paths.h). A passed file is a name and a
 * descriptor. It is found by exactly that name, and gives nothing else: not its folder, not what
 * stands beside it, no other name of it.
 *
 * Each reader gets a description of its own (no offset is shared with the client, nor with other
 * readers). Where the daemon's user may not open the file again, as one of another user with mode
 * 0600, it is copied into memory once, when it is first read.
 *
 * A list is built by one thread; once it is complete, any thread may open its files. Reading waits
 * as long as the client's file system does: not on a thread that must not wait. */
#ifndef LF_BASE_PASSED_H
#define LF_BASE_PASSED_H

#include "base/status.h"

#define LF_MAX_PASSED 64                       /* of a call, and of a scene */
#define LF_MAX_PASSED_ALL 256                  /* that the process holds at a time */
#define LF_MAX_PASSED_COPY ((uint64_t)1 << 30) /* bytes of all copies in the process */

typedef struct lf_passed lf_passed;

/* An empty list, with one reference; NULL = out of memory. */
lf_passed *lf_passed_create(void);
/* Adds a file by the name that scenes call it: an absolute path without ".", ".." or empty parts,
 * and without a place for a frame's number. On LF_OK fd is taken over, else it stays the caller's.
 * Never waits for a file system. LF_E_ARG: another name, one that is there already, too many, or fd
 * is no regular file that was opened for reading alone; LF_E_BUSY: the process holds
 * LF_MAX_PASSED_ALL; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_passed_add(lf_passed *passed, const char *path, int fd, lf_error *err);
/* A list of the files of both; where a name is in both, that of `newer`. Either may be NULL.
 * Files of `older` that nobody has opened since that list was made are left out when they are too
 * many. LF_E_ARG: they are still too many; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_passed_join(const lf_passed *older, const lf_passed *newer,
                                      lf_passed **out, lf_error *err);
/* Leaves out those of `newer` (may be NULL) that were never opened: no scene names them. */
void lf_passed_drop_unopened(lf_passed *passed, const lf_passed *newer);
lf_passed *lf_passed_ref(lf_passed *passed);
/* Closes what no other list holds. Accepts NULL. */
void lf_passed_unref(lf_passed *passed);

/* Whether a file of that name was passed; passed may be NULL. Relative names are those of the
 * working folder; ".." is taken by the letter. */
bool lf_passed_has(const lf_passed *passed, const char *path);
/* Opens it for reading, at offset 0. On LF_OK the caller owns *out_fd (O_CLOEXEC). LF_E_PATH: no
 * such file was passed; LF_E_IO, LF_E_FORMAT (too large to be copied), LF_E_NOMEM, LF_E_CANCELLED
 * (lf_passed_stop_when). */
LF_NODISCARD lf_status lf_passed_open(lf_passed *passed, const char *path, int *out_fd,
                                      lf_error *err);

/* From now on a copy ends when this is true, which is asked again and again. Thread: any. */
void lf_passed_stop_when(bool (*stopped)(void));

/* The name of file number `index`; NULL after the last, and where passed is NULL. */
const char *lf_passed_at(const lf_passed *passed, int index);

/* The name as it is compared: absolute, without ".", ".." and empty parts; out is PATH_MAX bytes.
 * false: too long. */
bool lf_passed_name(const char *path, char *out);

#endif
