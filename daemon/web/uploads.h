/* uploads: bodies of PUT requests in memory, and the files that wait until a client passes them to
 * quiltd.
 *
 * An upload has three states: it is received, then it waits under a name, then it is gone. What is
 * received and what waits have a common limit of bytes; the announced size counts from the start.
 * An upload that nobody uses is dropped after LF_UPLOADS_KEPT_S. Thread: event. */
#ifndef LF_DAEMON_WEB_UPLOADS_H
#define LF_DAEMON_WEB_UPLOADS_H

#include <jansson.h>
#include <stdint.h>
#include <systemd/sd-event.h>

#include "base/status.h"

#define LF_UPLOADS_AT_ONCE 4 /* bodies that are received */
#define LF_UPLOADS_MOST 128  /* files, received or waiting */
#define LF_UPLOADS_A_CALL 64 /* files that one call may pass */
#define LF_UPLOADS_KEPT_S 600
#define LF_UPLOADS_MAX_NAME 255

typedef struct lf_uploads lf_uploads;
typedef struct lf_upload lf_upload;

/* limit: bytes of all uploads together. LF_E_NOMEM. */
LF_NODISCARD lf_status lf_uploads_create(sd_event *event, uint64_t limit, lf_uploads **out,
                                         lf_error *err);
/* Drops all uploads. Accepts NULL. */
void lf_uploads_destroy(lf_uploads *uploads);
/* Bytes and number of what is received and what waits. */
uint64_t lf_uploads_bytes(const lf_uploads *uploads);
int lf_uploads_count(const lf_uploads *uploads);

/* Begins a body of `size` bytes. LF_E_BUSY: too many uploads, or too many bytes, are there;
 * LF_E_IO; LF_E_NOMEM. */
LF_NODISCARD lf_status lf_uploads_begin(lf_uploads *uploads, uint64_t size, lf_upload **out,
                                        lf_error *err);
/* Adds data[n] at the end. LF_E_ARG: more than the announced size; LF_E_IO. */
LF_NODISCARD lf_status lf_upload_append(lf_upload *upload, const void *data, size_t n,
                                        lf_error *err);
/* The body is there: seals the file and opens it for reading only. The caller closes *out_fd.
 * LF_E_ARG: it is shorter than announced; LF_E_IO. */
LF_NODISCARD lf_status lf_upload_open(lf_upload *upload, int *out_fd, lf_error *err);
/* Forgets an upload. Accepts NULL. */
void lf_upload_drop(lf_upload *upload);

/* Checks the name of a future upload: 1 to LF_UPLOADS_MAX_NAME bytes of UTF-8 without control
 * characters; folders end in a slash ("textures/a.png"), and no part is empty, "." or "..".
 * folder: the id of another upload; NULL: a new one. LF_E_ARG; LF_E_EXISTS: such a file waits. */
LF_NODISCARD lf_status lf_uploads_check_name(const lf_uploads *uploads, const char *folder,
                                             const char *name, lf_error *err);
/* The body is there and waits under its name from now on; on LF_OK the upload is the store's.
 * out_folder: LF_UPLOADS_FOLDER + 1 bytes. Errors of lf_uploads_check_name and lf_upload_open. */
#define LF_UPLOADS_FOLDER 16 /* digits of a folder's id */
LF_NODISCARD lf_status lf_upload_keep(lf_upload *upload, const char *folder, const char *name,
                                      char *out_folder, lf_error *err);

/* "/upload/ID/NAME"; NULL: it does not wait yet. */
const char *lf_upload_path(const lf_upload *upload);

/* Files and their bytes that were taken, but are in memory because quiltd has not read them. */
typedef struct lf_uploads_passed {
    int files;
    uint64_t bytes;
} lf_uploads_passed;

/* Takes the files with these paths ("/upload/ID/NAME", an array of strings), which then wait no
 * longer. The caller closes out_fds[*out_n]. LF_E_ARG: not such an array, more than
 * LF_UPLOADS_A_CALL, a path twice, or no such upload waits. LF_E_BUSY: with what was passed before
 * they are more than LF_UPLOADS_MOST files, or more bytes than the limit. Then all are still there.
 */
LF_NODISCARD lf_status lf_uploads_take(lf_uploads *uploads, const json_t *paths,
                                       const lf_uploads_passed *passed,
                                       int out_fds[LF_UPLOADS_A_CALL], int *out_n, lf_error *err);

#endif
